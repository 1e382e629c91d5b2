# tessera_module(TARGET FOLDER name [COMPONENT name] SOURCES ... ROOMS ... PRIVATE ...): rooms as a library of their own, TARGET.so, which
# the program loads when it first needs them (viewer/cli/modules/load_module.h) and with them the libraries that they stand on.
#   SOURCES  relative to FOLDER: the table of functions that the module shows, `tesseraModule`
#   ROOMS    compiled into it
#   PRIVATE  libraries of others
#   COMPONENT  of an installation that it belongs to, in place of `program`
# No room that the program holds is linked into a module as well: what the module needs of them it finds in the program,
# which shows it (program.symbols). So there is one budget, one Ctrl-C and one line of progress, not two.
function(tessera_module target)
  cmake_parse_arguments(ARG "" "FOLDER;COMPONENT" "SOURCES;ROOMS;PRIVATE" ${ARGN})
  list(TRANSFORM ARG_SOURCES PREPEND ${PROJECT_SOURCE_DIR}/${ARG_FOLDER}/)
  add_library(${target} MODULE ${ARG_SOURCES})
  foreach(room IN LISTS ARG_ROOMS)
    target_sources(${target} PRIVATE $<TARGET_OBJECTS:${room}>)
    target_include_directories(${target} PRIVATE $<TARGET_PROPERTY:${room},INTERFACE_INCLUDE_DIRECTORIES>)
  endforeach()
  target_include_directories(${target} PRIVATE ${PROJECT_BINARY_DIR}/rooms/tessera_modules)
  target_compile_definitions(${target} PRIVATE TESSERA_VERSION="${PROJECT_VERSION}")
  target_link_libraries(${target} PRIVATE tessera_options ${ARG_PRIVATE})
  # Symbols of its own bind in it, and those that are missing are told when it is loaded, not when they are called.
  target_link_options(${target} PRIVATE LINKER:--version-script=${PROJECT_SOURCE_DIR}/cmake/module.symbols LINKER:-z,now)
  set_target_properties(${target} PROPERTIES PREFIX "" LIBRARY_OUTPUT_DIRECTORY ${CMAKE_RUNTIME_OUTPUT_DIRECTORY}
    LINK_DEPENDS ${PROJECT_SOURCE_DIR}/cmake/module.symbols)
  if(NOT ARG_COMPONENT)
    set(ARG_COMPONENT program)
  endif()
  install(TARGETS ${target} LIBRARY DESTINATION ${TESSERA_MODULE_FOLDER} COMPONENT ${ARG_COMPONENT}
    PERMISSIONS OWNER_READ OWNER_WRITE GROUP_READ WORLD_READ)
  set_property(GLOBAL APPEND PROPERTY TESSERA_MODULES ${target})
endfunction()

# tessera_shows_rooms(TARGET rooms...): programs that link TARGET hold all of these rooms, used or not, and show them to
# the modules that they load.
function(tessera_shows_rooms target)
  list(TRANSFORM ARGN REPLACE "(.+)" "$<TARGET_FILE:\\1>" OUTPUT_VARIABLE files)
  list(JOIN files "," files)
  # Options stand before libraries: what links the same rooms as libraries finds all of them there already.
  target_link_options(${target} INTERFACE "-Wl,--whole-archive,${files},--no-whole-archive"
                      LINKER:--dynamic-list=${PROJECT_SOURCE_DIR}/cmake/program.symbols)
endfunction()

# tessera_on_demand(TARGET module room source): TARGET declares room's headers, and its source defines their functions by
# those of the module. Who links TARGET must not link the room.
function(tessera_on_demand target module room source)
  target_sources(${target} PRIVATE ${PROJECT_SOURCE_DIR}/viewer/cli/modules/${source})
  target_include_directories(${target} PUBLIC $<TARGET_PROPERTY:${room},INTERFACE_INCLUDE_DIRECTORIES>)
  add_dependencies(${target} ${module})
endfunction()
