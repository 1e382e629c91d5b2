# Writes the pages of the manual, packed as Debian has them, and the completion of shells, as the program says them.
#   cmake -D TESSERA=program -D OUT=folder -D DATE=YYYY-MM-DD -P say_pages.cmake
file(MAKE_DIRECTORY ${OUT}/bash ${OUT}/zsh)
file(REMOVE_RECURSE ${OUT}/man1) # of a command that is no more
file(MAKE_DIRECTORY ${OUT}/man1)
execute_process(COMMAND ${TESSERA} --quiet man ${OUT}/man1 --date ${DATE} COMMAND_ERROR_IS_FATAL ANY)
file(GLOB written ${OUT}/man1/*.1)
execute_process(COMMAND gzip -9n ${written} COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${TESSERA} completion bash OUTPUT_FILE ${OUT}/bash/tessera COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${TESSERA} completion zsh OUTPUT_FILE ${OUT}/zsh/_tessera COMMAND_ERROR_IS_FATAL ANY)
