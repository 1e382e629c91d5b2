# Pages of the manual and completion in shells, made whenever the program is. Included where the target tessera is made.
set(packaging ${PROJECT_SOURCE_DIR}/cmake/packages)

# The date of the pages is that of the version: "Sun, 29 Nov 2026 12:00:00 +0000".
file(STRINGS ${packaging}/debian/changelog release_date REGEX "^ -- " LIMIT_COUNT 1)
string(REGEX MATCH "([0-9]+) ([A-Z][a-z][a-z]) ([0-9]+) [0-9:]+ \\+0000$" release_date "${release_date}")
set(months January Jan Feb Mar Apr May Jun Jul Aug Sep Oct Nov Dec) # counted from 1
list(FIND months ${CMAKE_MATCH_2} month)
if(month LESS 10)
  set(month 0${month})
endif()
set(release_date ${CMAKE_MATCH_3}-${month}-${CMAKE_MATCH_1})

# The program says what its pages and its completion are. One of another architecture could not.
set(pages ${PROJECT_BINARY_DIR}/pages)
if(NOT CMAKE_CROSSCOMPILING AND NOT TESSERA_SANITIZE)
  add_custom_command(TARGET tessera POST_BUILD
    COMMAND ${CMAKE_COMMAND} -D TESSERA=$<TARGET_FILE:tessera> -D OUT=${pages} -D DATE=${release_date}
            -P ${packaging}/say_pages.cmake
    VERBATIM)
  install(DIRECTORY ${pages}/man1 DESTINATION ${CMAKE_INSTALL_MANDIR} COMPONENT program)
  install(FILES ${pages}/bash/tessera DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions COMPONENT program)
  install(FILES ${pages}/zsh/_tessera DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/site-functions COMPONENT program)
endif()
