// render/mirror.cpp: see mirror.h.
#include "render/mirror.h"

#include "core/threads.h"

#include <mutex>

namespace tessera {

namespace {

template <typename Real> struct UniformField {
    LatticeReader& samples;
    Real samplesPerVoxel;
    Real value(const glm::vec<3, Real>& p) { return fieldValue(samples, p, samplesPerVoxel); }
    glm::vec<3, Real> gradient(const glm::vec<3, Real>& p) {
        return fieldGradient(samples, p, samplesPerVoxel);
    }
};

template <typename Real> struct MixedField {
    MixedReader& samples;
    Real value(const glm::vec<3, Real>& p) { return interblockValue(samples, p); }
    glm::vec<3, Real> gradient(const glm::vec<3, Real>& p) { return interblockGradient(samples, p); }
};

} // namespace

template <typename Real>
std::vector<glm::vec<4, Real>> mirrorRays(const MirrorInput& input, std::size_t rayCount,
                                          const RaySource<Real>& rays, int threads, Work& work) {
    constexpr std::size_t kStrip = 64; // rays a thread takes at a time: neighbours share chunks
    std::vector<glm::vec<4, Real>> out(rayCount);
    std::mutex mutex;
    parallelFor((rayCount + kStrip - 1) / kStrip, threads, [&](std::size_t strip) {
        Work mine;
        const auto draw = [&](auto& field) {
            for (std::size_t i = strip * kStrip; i < std::min(rayCount, (strip + 1) * kStrip); ++i)
                out[i] = mirrorRay(rays(i), field, input, mine);
        };
        if (input.levels) {
            MixedReader samples(*input.cache, *input.info, *input.selection, *input.levels);
            MixedField<Real> field{samples};
            draw(field);
        } else {
            const int level = input.selection->finest();
            LatticeReader samples(*input.cache, *input.info, level, input.selection);
            UniformField<Real> field{samples, Real(1) / static_cast<Real>(1 << level)};
            draw(field);
        }
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
