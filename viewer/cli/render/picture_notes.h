// viewer/cli/render/picture_notes.h: notes and warnings of `tessera render` about a picture that it drew.
#pragma once

#include "core/base/volume.h"
#include "core/scene/scene.h"
#include "render/picture/render_scene.h"
#include "viewer/cli/render/render_task.h"

#include <string>

namespace tessera {

// The position of a volume in words, for messages about pictures outside it.

/// "x from -170 to 169.3, y from -12 to 80 and z from -400 to -1.5 mm": its bounding box, patient space.
std::string placeOf(const VolumeInfo& info);

/// Throws InputError naming `where`, with the volume's box, for a slice entirely outside the volume.
void requireSliceInVolume(const Scene& scene, const VolumeInfo& info, const std::string& where);

/// "wrote OUT: 512 x 512, levels 0 to 4, DEVICE, 1.2 s" as a note.
/// @param kind  ", unfolded" after the size; "" of a picture
void noteWritten(const RenderTask& task, const Scene& scene, const RenderResult& result,
                 const std::string& kind);

/// A blank picture is no error, but never a silent one: why it is, and what to try.
void warnBlank(const RenderTask& task, const RenderResult& result);

/// Says of an oblique slice seen along its normal that its picture is the mirror image of radiology's.
void noteMirrored(const RenderTask& task);

/// Says that the table is left out, or with --verbose why not.
void noteTable(const RenderTask& task, const RenderResult& result);

/// Names the fill values that an adaptive function or window leaves out.
void noteLeftOut(const RenderTask& task, const RenderResult& result);

/// Isosurfaces of values that the volume does not have.
void noteMissingSurfaces(const RenderTask& task, const RenderResult& result);

/// Tells of an environment that nothing shows.
void noteUnseenSky(const RenderTask& task);
/// With an error bound: the reason if the picture is not known to be within it.
void noteMissedError(const RenderTask& task, const RenderResult& result);

} // namespace tessera
