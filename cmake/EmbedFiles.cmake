# tessera_embed_files(TARGET NAMESPACE FILES...): compiles text files into TARGET, so that the program finds
# its shaders and presets wherever it is copied. Gives NAMESPACE::embeddedFiles(), name -> text.
function(tessera_embed_files target namespace)
  set(out ${CMAKE_CURRENT_BINARY_DIR}/${namespace}_embedded)
  add_custom_command(
    OUTPUT ${out}.cpp
    COMMAND ${CMAKE_COMMAND} "-DOUT=${out}.cpp" "-DNAMESPACE=${namespace}" "-DFILES=${ARGN}"
            -P ${CMAKE_SOURCE_DIR}/cmake/embed.cmake
    DEPENDS ${ARGN} ${CMAKE_SOURCE_DIR}/cmake/embed.cmake
    VERBATIM)
  target_sources(${target} PRIVATE ${out}.cpp)
endfunction()
