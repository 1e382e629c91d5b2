# tessera_room(TARGET FOLDER name [SOURCES ...] [HEADERS ...] [USES ...] [PRIVATE ...]): one room of the house as a target.
# Only targets that link it can include its headers, by their path from the root ("core/base/brick.h"): the root is on no
# include path. Instead every room has a folder of links in the build folder, to its own headers alone, and that is what
# its users get. So an #include against the arrows does not compile.
#   FOLDER   from the root
#   SOURCES  relative to it; left out with HEADERS: a room of headers
#   HEADERS  relative to it; left out: all of the folder, without those of folders in it, and so are SOURCES
#   USES     rooms and libraries that its headers need; PRIVATE: those that its sources need alone
function(tessera_room target)
  cmake_parse_arguments(ARG "" "FOLDER" "SOURCES;HEADERS;USES;PRIVATE" ${ARGN})
  set(folder ${PROJECT_SOURCE_DIR}/${ARG_FOLDER})
  if(NOT ARG_HEADERS)
    file(GLOB ARG_HEADERS RELATIVE ${folder} CONFIGURE_DEPENDS ${folder}/*.h)
    if(NOT ARG_SOURCES)
      file(GLOB ARG_SOURCES RELATIVE ${folder} CONFIGURE_DEPENDS ${folder}/*.cpp)
    endif()
  endif()
  set(view ${PROJECT_BINARY_DIR}/rooms/${target})
  file(MAKE_DIRECTORY ${view}/${ARG_FOLDER})
  file(GLOB links RELATIVE ${view}/${ARG_FOLDER} ${view}/${ARG_FOLDER}/*.h)
  foreach(link IN LISTS links)
    if(NOT link IN_LIST ARG_HEADERS) # its header went
      file(REMOVE ${view}/${ARG_FOLDER}/${link})
    endif()
  endforeach()
  foreach(header IN LISTS ARG_HEADERS) # only those that are new: what is made anew looks changed to the build
    if(NOT EXISTS ${view}/${ARG_FOLDER}/${header})
      file(CREATE_LINK ${folder}/${header} ${view}/${ARG_FOLDER}/${header} SYMBOLIC)
    endif()
  endforeach()
  if(ARG_SOURCES)
    list(TRANSFORM ARG_SOURCES PREPEND ${folder}/)
    add_library(${target} STATIC ${ARG_SOURCES})
    target_include_directories(${target} PUBLIC ${view})
    target_link_libraries(${target} PUBLIC tessera_options ${ARG_USES} PRIVATE ${ARG_PRIVATE})
    tessera_in_unity(${target})
  else()
    add_library(${target} INTERFACE)
    target_include_directories(${target} INTERFACE ${view})
    target_link_libraries(${target} INTERFACE tessera_options ${ARG_USES})
  endif()
endfunction()

# Sources of a target are compiled several at a time, so that what they include is read once for all of them. Names in
# their anonymous namespaces must therefore differ within a target, also from those of headers that others of them
# take from another namespace: the nearer one would hide them.
set(TESSERA_UNITY_BATCH 10 CACHE STRING "Sources that are compiled as one with TESSERA_UNITY")
function(tessera_in_unity target)
  set_target_properties(${target} PROPERTIES UNITY_BUILD ${TESSERA_UNITY} UNITY_BUILD_BATCH_SIZE ${TESSERA_UNITY_BATCH})
endfunction()
