// render/picture/reformed_picture.h: draws curved planar reformations: the values of the contract's field on
// rows of places, as slices show them (docs/reformations.md). No engine is needed, since no ray is cast.
#pragma once

#include "core/scene/reformation.h"
#include "render/picture/render_scene.h"

#include <cstddef>
#include <vector>

namespace tessera {

/// What pixels of reformations show.
struct ReformedShare {
    std::size_t pixels = 0;  // between pictures none
    std::size_t outside = 0; // nowhere in the drawn part of the volume: transparent
    std::size_t folded = 0;  // where rows cross one another: hatched
};

/// The pictures in one image, each where it lies (Reformation::from); between them it is transparent. Pixels
/// are the mean of their samples; each is the value of level 0 at its place, by trilinear interpolation. If
/// the scene's slice has a thickness, it is the greatest, least or mean value along it, at steps of at most
/// half a voxel. Colours are those of the scene's window or function; labels lie over them as over slices.
/// The scene's cuts hold; camera, light and all else do not count. Reads chunks through a cache, in bands of
/// rows, all pictures of a band together, cross-sections one by one. Threads share the bands, and change no
/// bit. Throws InputError for budgets that are too small, more than one volume, and damaged chunks.
RenderResult renderReformed(const Scene& scene, const std::vector<Reformation>& pictures,
                            const StoreReader& store, MemoryBudget& ram, const RenderOptions& options,
                            ReformedShare& share);

} // namespace tessera
