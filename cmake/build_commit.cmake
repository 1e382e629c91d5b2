# At every build: which commit it is of, for reports whose figures must be traced to code. Empty without git.
#   cmake -D SOURCE=folder -D OUT=file.cpp -P build_commit.cmake
execute_process(COMMAND git -C "${SOURCE}" describe --always --dirty --abbrev=12 --exclude=*
  OUTPUT_VARIABLE TESSERA_COMMIT OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
configure_file("${SOURCE}/viewer/cli/manifest/build_commit.cpp.in" "${OUT}" @ONLY) # written where it changed
