// render/backends/mirror/mirror_fused.h: rays through several volumes (docs/sampling.md, "Several volumes"),
// one at a time; counterpart of render/backends/native/packet_fused.h. Nothing is leapt over.
#pragma once

#include "core/base/work.h"
#include "render/backends/mirror/mirror_input.h"
#include "render/backends/mirror/mirror_sample.h"
#include "render/contract/integrators.h"
#include "render/contract/ray.h"

#include <functional>
#include <glm/mat3x3.hpp>
#include <glm/vec4.hpp>
#include <vector>

namespace tessera {

/// A ray's segment in one of the volumes.
template <typename Real> struct FusedPlace {
    glm::vec<3, Real> middle{0}, direction{0}; // voxels
    Real lengthMm = 0;
    int segments = 1;
};

/// One of the volumes, and what its field shows of a segment.
template <typename Real> struct FusedField {
    glm::mat<3, 3, Real> linear{1}; // voxels from places of the lattice
    glm::vec<3, Real> offset{0}, extent{0};
    Real unitMm = 1; // unit distance of its function
    std::span<const leaf::CutSlab> cuts = {};
    /// As seeSegment(); false also where its map has nothing.
    std::function<bool(const FusedPlace<Real>&, Work&, SeenSegment<Real>&)> see;
};

/// Composites a ray, or a part of it, behind what it has gathered before.
/// @param ray  of the lattice
template <typename Real>
void fusedAlong(const SegmentedRay<Real>& ray, const std::vector<FusedField<Real>>& fields,
                const MirrorInput& input, Work& work, glm::vec<4, Real>& sum) {
    using Vec = glm::vec<3, Real>;
    struct Line {
        Vec entry, step, direction;
    };
    std::vector<Line> lines;
    for (const FusedField<Real>& f : fields)
        lines.push_back({leaf::transformed(f.linear, ray.entry) + f.offset,
                         leaf::transformed(f.linear, ray.step), leaf::transformed(f.linear, ray.direction)});
    const int rule = static_cast<int>(input.fused->rule), n = input.strides.uniformSegments;
    for (int i = 0; i < ray.count; i += n) {
        ++work.iterations;
        const Real length = strideLength(ray, i, n), at = leaf::strideMiddle(static_cast<Real>(i), length);
        leaf::Fused<Real> fused{};
        bool shows = false;
        for (std::size_t v = 0; v < fields.size(); ++v) {
            const Vec p = leaf::placeAlong(lines[v].entry, lines[v].step, at);
            if (!glm::all(glm::lessThanEqual(Vec(0), p)) || !glm::all(glm::lessThan(p, fields[v].extent)))
                continue;
            if (!fields[v].cuts.empty() &&
                !leaf::isKept(fields[v].cuts.data(), static_cast<int>(fields[v].cuts.size()), p))
                continue;
            SeenSegment<Real> seen;
            if (!fields[v].see({p, lines[v].direction, length * ray.segmentMm, n}, work, seen) ||
                !(seen.extinction > Real(0)))
                continue;
            ++work.samples;
            fused = leaf::fusedWith<Real>(fused, rule, seen.extinction,
                                          opacityOf(seen.extinction * fields[v].unitMm), seen.colour.r,
                                          seen.colour.g, seen.colour.b);
            shows = true;
        }
        if (!shows)
            continue;
        ++work.segments;
        composite(sum, Vec(fused.red, fused.green, fused.blue),
                  opacityOf(fused.extinction * (length * ray.segmentMm)));
        if (Real(1) - sum.a < static_cast<Real>(input.optics->termination))
            return;
    }
}

} // namespace tessera
