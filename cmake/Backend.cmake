# tessera_backend(NAME [USES ...] [PRIVATE ...]): a renderer, or a backend that takes rays, as a room. Its folder,
# render/backends/NAME, defines `EngineTraits NAMETraits()` (engine_traits.h) and calls this in a CMakeLists.txt: that, and a value
# in EngineKind, is all that a renderer takes.
function(tessera_backend name)
  cmake_parse_arguments(ARG "" "" "USES;PRIVATE" ${ARGN})
  tessera_room(tessera_${name} FOLDER render/backends/${name}
    USES tessera_renderer ${ARG_USES}
    PRIVATE ${ARG_PRIVATE})
  set_property(GLOBAL APPEND PROPERTY TESSERA_BACKENDS ${name})
endfunction()

# tessera_backend_table(FILE): writes the source of engineTraits() of engine_traits.h.
function(tessera_backend_table file)
  get_property(backends GLOBAL PROPERTY TESSERA_BACKENDS)
  set(declared "")
  set(rows "")
  foreach(backend IN LISTS backends)
    string(APPEND declared "EngineTraits ${backend}Traits();\n")
    string(APPEND rows "        ${backend}Traits(),\n")
  endforeach()
  file(CONFIGURE OUTPUT ${file} CONTENT [[
#include "render/engine_traits.h"

namespace tessera {
@declared@
const std::vector<EngineTraits>& engineTraits() {
    static const std::vector<EngineTraits> all = {
@rows@    };
    return all;
}
} // namespace tessera
]] @ONLY)
endfunction()
