// render/mirror.cpp: see mirror.h.
#include "render/mirror.h"

#include "core/threads.h"

#include <mutex>

namespace tessera {

template <typename Real>
std::vector<glm::vec<4, Real>> mirrorRays(const MirrorInput& input, std::size_t rayCount,
                                          const RaySource<Real>& rays, int threads, Work& work) {
    constexpr std::size_t kStrip = 64; // rays a thread takes at a time: neighbours share chunks
    std::vector<glm::vec<4, Real>> out(rayCount);
    const Real samplesPerVoxel = Real(1) / static_cast<Real>(1 << input.selection->level);
    std::mutex mutex;
    parallelFor((rayCount + kStrip - 1) / kStrip, threads, [&](std::size_t strip) {
        LatticeReader samples(*input.cache, *input.info, input.selection->level, input.selection);
        Work mine;
        for (std::size_t i = strip * kStrip; i < std::min(rayCount, (strip + 1) * kStrip); ++i)
            out[i] = mirrorRay(rays(i), samples, samplesPerVoxel, *input.optics, input.occupancy, mine);
        const std::lock_guard lock(mutex);
        work += mine;
    });
    return out;
}

template std::vector<glm::vec4> mirrorRays<float>(const MirrorInput&, std::size_t, const RaySource<float>&,
                                                  int, Work&);
template std::vector<glm::dvec4> mirrorRays<double>(const MirrorInput&, std::size_t, const RaySource<double>&,
                                                    int, Work&);

} // namespace tessera
