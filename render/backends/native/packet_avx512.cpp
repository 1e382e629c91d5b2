// render/backends/native/packet_avx512.cpp: packets of rays for AVX-512 (x86-64-v4).
#define TESSERA_LANES lanes_avx512
#include "render/backends/native/packet_blocks.h"
#include "render/backends/native/packet_fused.h"
#include "render/backends/native/packet_light.h"
#include "render/backends/native/packet_places.h"
#include "render/backends/native/packet_rays.h"
#include "render/backends/native/packet_shadows.h"
#include "render/backends/native/packet_surfaces.h"
#include "render/backends/native/packet_ways.h"

namespace tessera::native {

const PacketTarget kAvx512Target{"avx512",
                                 lanes_avx512::kColumns,
                                 lanes_avx512::kWidth / lanes_avx512::kColumns,
                                 lanes_avx512::chooseAnyMarch,
                                 lanes_avx512::marchFused,
                                 lanes_avx512::makeRays,
                                 lanes_avx512::cellSamples,
                                 lanes_avx512::cellRanges,
                                 lanes_avx512::opacities,
                                 lanes_avx512::occlude,
                                 lanes_avx512::occludeAndShine,
                                 lanes_avx512::chooseShadows,
                                 lanes_avx512::addShadows,
                                 lanes_avx512::chooseWays,
                                 lanes_avx512::choosePlaces,
                                 lanes_avx512::bareSamples};

} // namespace tessera::native
