// render/backends/native/packet_avx2.cpp: packets of rays for AVX2 (x86-64-v3).
#define TESSERA_LANES lanes_avx2
#include "render/backends/native/packet_blocks.h"
#include "render/backends/native/packet_fused.h"
#include "render/backends/native/packet_light.h"
#include "render/backends/native/packet_places.h"
#include "render/backends/native/packet_rays.h"
#include "render/backends/native/packet_shadows.h"
#include "render/backends/native/packet_surfaces.h"
#include "render/backends/native/packet_ways.h"

namespace tessera::native {

const PacketTarget kAvx2Target{"avx2",
                               lanes_avx2::kColumns,
                               lanes_avx2::kWidth / lanes_avx2::kColumns,
                               lanes_avx2::chooseAnyMarch,
                               lanes_avx2::marchFused,
                               lanes_avx2::makeRays,
                               lanes_avx2::cellSamples,
                               lanes_avx2::cellRanges,
                               lanes_avx2::opacities,
                               lanes_avx2::occlude,
                               lanes_avx2::occludeAndShine,
                               lanes_avx2::chooseShadows,
                               lanes_avx2::addShadows,
                               lanes_avx2::chooseWays,
                               lanes_avx2::choosePlaces,
                               lanes_avx2::bareSamples};

} // namespace tessera::native
