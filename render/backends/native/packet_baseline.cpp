// render/backends/native/packet_baseline.cpp: packets of rays for the instructions that every processor of
// its kind has.
#define TESSERA_LANES lanes_baseline
#include "render/backends/native/packet_blocks.h"
#include "render/backends/native/packet_fused.h"
#include "render/backends/native/packet_light.h"
#include "render/backends/native/packet_places.h"
#include "render/backends/native/packet_rays.h"
#include "render/backends/native/packet_shadows.h"
#include "render/backends/native/packet_surfaces.h"
#include "render/backends/native/packet_ways.h"

namespace tessera::native {

const PacketTarget kBaselineTarget{"baseline",
                                   lanes_baseline::kColumns,
                                   lanes_baseline::kWidth / lanes_baseline::kColumns,
                                   lanes_baseline::chooseAnyMarch,
                                   lanes_baseline::marchFused,
                                   lanes_baseline::makeRays,
                                   lanes_baseline::cellSamples,
                                   lanes_baseline::cellRanges,
                                   lanes_baseline::opacities,
                                   lanes_baseline::occlude,
                                   lanes_baseline::occludeAndShine,
                                   lanes_baseline::chooseShadows,
                                   lanes_baseline::addShadows,
                                   lanes_baseline::chooseWays,
                                   lanes_baseline::choosePlaces,
                                   lanes_baseline::bareSamples};

} // namespace tessera::native
