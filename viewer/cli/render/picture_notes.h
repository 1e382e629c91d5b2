// viewer/cli/render/picture_notes.h: notes and warnings of `tessera render` about a picture
// that it drew.
#pragma once

#include "render/picture/render_scene.h"
#include "viewer/cli/render/render_task.h"

#include <string>

namespace tessera {

/// "wrote OUT: 512 x 512, levels 0 to 4, DEVICE, 1.2 s" as a note.
/// @param kind  ", unfolded" after the size; "" of a picture
void noteWritten(const RenderTask& task, const Scene& scene, const RenderResult& result,
                 const std::string& kind);

/// A blank picture is no error, but never a silent one: why it is, and what to try.
void warnBlank(const RenderTask& task, const RenderResult& result);

/// Isosurfaces of values that the volume does not have.
void noteMissingSurfaces(const RenderTask& task, const RenderResult& result);

/// With an error bound: the reason if the picture is not known to be within it.
void noteMissedError(const RenderTask& task, const RenderResult& result);

} // namespace tessera
