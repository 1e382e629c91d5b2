# Called by CPack when the components are staged, before they become packages: puts files where Debian has them, adds what it
# asks for, and gives all files the time of the version (SOURCE_DATE_EPOCH).
file(GLOB staged LIST_DIRECTORIES ON ${CPACK_TEMPORARY_DIRECTORY}/*)
set(package_of_program tessera)
set(package_of_window tessera-window)
set(package_of_python python3-tessera)
foreach(root IN LISTS staged)
  get_filename_component(component ${root} NAME)
  set(package ${package_of_${component}})
  if(NOT package)
    continue()
  endif()
  # Debian's zsh looks for the completion of packages in a folder of its own.
  if(EXISTS ${root}/usr/share/zsh/site-functions)
    file(RENAME ${root}/usr/share/zsh/site-functions ${root}/usr/share/zsh/vendor-completions)
  endif()
  set(documents ${root}/usr/share/doc/${package})
  file(MAKE_DIRECTORY ${documents})
  file(REMOVE ${documents}/LICENSE) # the text is /usr/share/common-licenses/Apache-2.0
  file(COPY ${CPACK_TESSERA_DEBIAN}/copyright DESTINATION ${documents})
  execute_process(COMMAND gzip -9nc ${CPACK_TESSERA_DEBIAN}/changelog OUTPUT_FILE ${documents}/changelog.gz
    COMMAND_ERROR_IS_FATAL ANY)
  if(EXISTS ${CPACK_TESSERA_DEBIAN}/${package}.lintian-overrides)
    file(MAKE_DIRECTORY ${root}/usr/share/lintian/overrides)
    configure_file(${CPACK_TESSERA_DEBIAN}/${package}.lintian-overrides ${root}/usr/share/lintian/overrides/${package} COPYONLY)
  endif()
  execute_process(COMMAND chmod -R u=rwX,go=rX ${root} COMMAND_ERROR_IS_FATAL ANY)
  if(DEFINED ENV{SOURCE_DATE_EPOCH})
    execute_process(COMMAND find ${root} -exec touch --no-dereference --date=@$ENV{SOURCE_DATE_EPOCH} {} +
      COMMAND_ERROR_IS_FATAL ANY)
  endif()
endforeach()
