// viewer/session/volume_values.cpp: see volume_values.h.
#include "viewer/session/volume_values.h"

#include "core/base/brick.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "render/contract/lattice.h"
#include "render/contract/ray.h"
#include "render/contract/sampler.h"
#include "render/labels/drawn_labels.h"
#include "render/plan/drawn_part.h"
#include "viewer/session/volume_labels.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat4x4.hpp>
#include <glm/matrix.hpp>
#include <optional>

namespace tessera {
namespace {

constexpr double kStepVoxels = 0.5;
constexpr int kReach = 2; // segments to either side of a place: a voxel
constexpr double kLeast = 1.0 / 255, kEndOfLight = 1.0 / 512;

/// The contribution of each segment of a ray to the picture's opacity, and the position of its middle, in
/// segments.
struct Shares {
    std::vector<double> added, at;
};

/// The surface that a ray crosses between two values, nearest to the first; null: none.
const SurfaceValue* crossed(const std::vector<SurfaceValue>& surfaces, double a, double b) {
    const SurfaceValue* nearest = nullptr;
    for (const SurfaceValue& s : surfaces)
        if (s.opacity > 0 && s.value >= std::min(a, b) && s.value <= std::max(a, b) && a != b &&
            (!nearest || std::abs(s.value - a) < std::abs(nearest->value - a)))
            nearest = &s;
    return nearest;
}

/// @param from, to  whole segments
/// @param value  physical value at a place, in segments from the entry
/// @param factor  gradient opacity there
/// @param labels  factors of the labels there; null: there are none
/// @param drawn   whether a place is not cut away
template <typename Value, typename Factor, typename Labelled, typename Drawn>
Shares sharesAlong(const SegmentedRay<double>& ray, int from, int to, const Layer& volume, const Value& value,
                   const Factor& factor, const Labelled& labels, const Drawn& drawn) {
    Shares s;
    double left = 1, before = value(static_cast<double>(from));
    for (int i = from; i < to && left > kEndOfLight; ++i) {
        const double length = strideLength(ray, i, 1), behind = value(i + length);
        if (!drawn(i + length / 2)) {
            before = behind;
            continue;
        }
        if (const SurfaceValue* const surface = crossed(volume.table.surfaces, before, behind)) {
            const double part = (surface->value - before) / (behind - before);
            s.added.push_back(left * surface->opacity);
            s.at.push_back(i + part * length);
            left *= 1 - surface->opacity;
        }
        before = behind;
        const double middle = i + length / 2;
        const LabelFactors* const label = labels(middle);
        double extinction = 0;
        if (!label || label->plain > 0 || label->tinted > 0)
            extinction = volume.function.extinction(value(middle));
        if (extinction > 0)
            extinction *= factor(middle);
        if (label)
            extinction = static_cast<double>(label->plain + label->tinted) * extinction +
                         static_cast<double>(label->solid * volume.labels->numbers().density);
        if (extinction <= 0)
            continue;
        const double opacity = -std::expm1(-extinction * ray.segmentMm * length);
        if (opacity <= 0)
            continue;
        s.added.push_back(left * opacity);
        s.at.push_back(middle);
        left *= 1 - opacity;
    }
    return s;
}

/// Dims the volume behind meshes, and the meshes' surfaces by all before them. Returns the number of the
/// surface that contributes most, if that is more than `most`.
/// @param at  of the surfaces, in segments
std::optional<std::size_t> dim(Shares& s, std::span<const MeshOnRay> meshes, std::span<const double> at,
                               double& most) {
    std::optional<std::size_t> found;
    double left = 1;
    std::size_t next = 0;
    double taken = 0; // by the volume so far, before it is dimmed
    for (std::size_t n = 0; n <= meshes.size(); ++n) {
        for (; next < s.at.size() && (n == meshes.size() || s.at[next] < at[n]); ++next) {
            taken += s.added[next];
            s.added[next] *= left;
        }
        if (n == meshes.size())
            break;
        const double share = left * (1 - taken) * meshes[n].opacity;
        if (share > most * 1.0001) {
            most = share;
            found = n;
        }
        left *= 1 - meshes[n].opacity;
    }
    return found;
}

/// The place, in segments, whose neighbourhood of one voxel to either side contributes most; negative:
/// nothing is visible.
/// @param most  the contribution to exceed; that of the place, if there is one
double placeOfMost(const Shares& s, double& most) {
    double place = -1;
    for (std::size_t i = 0; i < s.added.size(); ++i) {
        double sum = 0, weighted = 0;
        for (std::size_t j = i; j-- > 0 && s.at[i] - s.at[j] <= kReach;)
            sum += s.added[j], weighted += s.added[j] * s.at[j];
        for (std::size_t j = i; j < s.added.size() && s.at[j] - s.at[i] <= kReach; ++j)
            sum += s.added[j], weighted += s.added[j] * s.at[j];
        if (sum > most * 1.0001) // of equal sums the first
            most = sum, place = weighted / sum;
    }
    return place;
}

/// The place, in segments, of the value that a ray keeps; the middle for an average; negative: nothing is
/// drawn.
template <typename Value, typename Drawn>
double placeOfKept(const SegmentedRay<double>& ray, int from, int to, Reduction reduction, const Value& value,
                   const Drawn& drawn) {
    double place = -1, kept = 0, first = -1, last = -1;
    for (int i = from; i < to; ++i) {
        const double middle = i + strideLength(ray, i, 1) / 2;
        if (!drawn(middle))
            continue;
        first = first < 0 ? middle : first;
        last = middle;
        const double here = value(middle);
        if (place < 0 || (reduction == Reduction::maximum ? here > kept : here < kept))
            place = middle, kept = here;
    }
    return reduction == Reduction::average ? (first + last) / 2 : place;
}

/// The finest level on which a ray crosses few chunks.
int quickLevel(const VolumeInfo& info) {
    constexpr int kMostChunks = 12; // along the longest axis
    const int longest = std::max({info.extentVoxels.x, info.extentVoxels.y, info.extentVoxels.z});
    int level = 0;
    while (level < kLevelCount - 1 && (longest >> level) > kMostChunks * kChunkExtent)
        ++level;
    return level;
}

/// Where a ray meets a slice without thickness, level 0.
PickedPlace placeOnPlane(const Layer& volume, const DrawnPart& part, const SegmentedRay<double>& ray) {
    constexpr double kRounding = 1e-6; // voxels
    PickedPlace picked;
    const RaySlab<double>& plane = part.slabs.front();
    const double along = glm::dot(plane.normal, ray.step);
    if (along == 0)
        return picked;
    const VolumeInfo& info = volume.info();
    const glm::dvec3 voxel = ray.entry + (plane.low - glm::dot(plane.normal, ray.entry)) / along * ray.step,
                     inside = glm::clamp(voxel, glm::dvec3(0), glm::dvec3(info.extentVoxels));
    if (glm::distance(voxel, inside) > kRounding || !part.keeps(inside, kRounding))
        return picked;
    picked.hit = true;
    picked.voxel = inside;
    picked.mm = glm::dvec3(info.patientFromVoxel * glm::dvec4(inside, 1));
    LatticeReader samples(*volume.cache, info, 0, nullptr);
    picked.value = info.rescaleSlope * fieldValue(samples, inside, 1.0) + info.rescaleIntercept;
    return picked;
}

} // namespace

PickedPlace pickPlace(const Layer& volume, const DrawnPart& part, const Camera& camera,
                      const glm::ivec2& imageSize, const glm::dvec2& place,
                      std::span<const MeshOnRay> meshes) {
    const VolumeInfo& info = volume.info();
    PickedPlace picked;
    const auto ofMesh = [&](const MeshOnRay& mesh) {
        picked.hit = true;
        picked.mesh = mesh.mesh;
        picked.voxel = mesh.voxel;
        picked.mm = glm::dvec3(info.patientFromVoxel * glm::dvec4(mesh.voxel, 1));
        return picked;
    };
    const SegmentedRay<double> ray = segmentedRay(rayFrame(camera, info, imageSize, kStepVoxels), place);
    std::vector<double> meshesAt;
    for (const MeshOnRay& mesh : meshes)
        meshesAt.push_back(
            ray.count == 0 ? 0 : glm::dot(mesh.voxel - ray.entry, ray.step) / glm::dot(ray.step, ray.step));
    std::optional<std::size_t> mesh;
    if (ray.count == 0) {
        Shares none;
        double most = kLeast;
        mesh = dim(none, meshes, meshesAt, most);
        return mesh ? ofMesh(meshes[*mesh]) : picked;
    }
    if (part.flat)
        return placeOnPlane(volume, part, ray);
    // No place of a sum tells more than another.
    const Reduction reduction = volume.addsUp ? Reduction::average : volume.optics.reduction;
    const auto position = [&](double segments) { return ray.entry + segments * ray.step; };
    const auto placeAt = [&](int level, int from, int to) {
        LatticeReader samples(*volume.cache, info, level, nullptr);
        const double perVoxel = std::exp2(-level);
        const auto value = [&](double segments) {
            return info.rescaleSlope * fieldValue(samples, position(segments), perVoxel) +
                   info.rescaleIntercept;
        };
        const auto factor = [&](double segments) {
            return volume.optics.grades()
                       ? gradientFactor(volume.optics, fieldGradient(samples, position(segments), perVoxel,
                                                                     volume.optics.gradient))
                       : 1;
        };
        std::optional<LabelVoxels> voxels;
        if (volume.labels)
            voxels.emplace(volume.labels->volume().voxels(), level);
        const glm::ivec3 last = levelExtent(info.extentVoxels, level) - 1;
        const auto labels = [&](double segments) -> const LabelFactors* {
            if (!voxels)
                return nullptr;
            const glm::ivec3 at(glm::floor(position(segments) * perVoxel));
            const auto& factors = volume.labels->factors();
            return &factors[std::min(voxels->setAt(glm::clamp(at, glm::ivec3(0), last)), factors.size() - 1)];
        };
        const auto drawn = [&](double segments) {
            const glm::dvec3 p = position(segments);
            return !part.any() || part.meets(p, p);
        };
        if (reduction != Reduction::composite)
            return placeOfKept(ray, from, to, reduction, value, drawn);
        Shares shares = sharesAlong(ray, from, to, volume, value, factor, labels, drawn);
        double most = kLeast;
        if (from == 0 && to == ray.count)
            mesh = dim(shares, meshes, meshesAt, most);
        const double found = placeOfMost(shares, most);
        if (found >= 0)
            mesh.reset();
        return found;
    };
    picked.level = quickLevel(info);
    double at = placeAt(picked.level, 0, ray.count);
    if (mesh)
        return ofMesh(meshes[*mesh]);
    if (at < 0)
        return picked;
    try {
        const int reach = static_cast<int>(2 / kStepVoxels) << picked.level, middle = static_cast<int>(at);
        if (reduction != Reduction::average) {
            const double finer =
                placeAt(0, std::max(0, middle - reach), std::min(ray.count, middle + reach + 1));
            at = finer < 0 ? at : finer;
        }
        picked.level = 0;
    } catch (const Error&) { // damaged
    }
    picked.hit = true;
    picked.voxel = glm::clamp(position(at), glm::dvec3(0), glm::dvec3(info.extentVoxels));
    picked.mm = glm::dvec3(info.patientFromVoxel * glm::dvec4(picked.voxel, 1));
    LatticeReader samples(*volume.cache, info, picked.level, nullptr);
    picked.value = info.rescaleSlope * fieldValue(samples, picked.voxel, std::exp2(-picked.level)) +
                   info.rescaleIntercept;
    return picked;
}

std::vector<double> volumeHistogram(const Layer& volume, double lowest, double highest, int bins) {
    constexpr std::size_t kMostSamples = 2'000'000;
    const VolumeInfo& info = volume.info();
    int level = 0;
    while (level < kLevelCount - 1 && cellCount(levelExtent(info.extentVoxels, level)) > kMostSamples)
        ++level;
    const glm::ivec3 extent = levelExtent(info.extentVoxels, level);
    std::vector<double> counts(static_cast<std::size_t>(bins));
    const double perValue = highest > lowest ? bins / (highest - lowest) : 0;
    SampleReader samples(*volume.cache, info.type);
    const glm::ivec3 chunks = ceilDiv(extent, kChunkExtent);
    for (int chunk = 0; chunk < static_cast<int>(cellCount(chunks));
         ++chunk) { // chunk by chunk: each read once
        checkInterrupted();
        const glm::ivec3 first = kChunkExtent * glm::ivec3(chunk % chunks.x, chunk / chunks.x % chunks.y,
                                                           chunk / (chunks.x * chunks.y));
        const glm::ivec3 end = glm::min(first + kChunkExtent, extent);
        for (int z = first.z; z < end.z; ++z)
            for (int y = first.y; y < end.y; ++y)
                for (int x = first.x; x < end.x; ++x) {
                    const double value =
                        info.rescaleSlope * samples.at(level, {x, y, z}) + info.rescaleIntercept;
                    if (value < lowest || value > highest)
                        continue;
                    const int bin = std::clamp(static_cast<int>((value - lowest) * perValue), 0, bins - 1);
                    ++counts[static_cast<std::size_t>(bin)];
                }
    }
    return counts;
}

} // namespace tessera
