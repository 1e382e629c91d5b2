// bricking/statistics/brick_rays.cpp: see brick_rays.h.
#include "bricking/statistics/brick_rays.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

namespace tessera {
namespace {

constexpr int kResidualLevel = 3; // rays are sorted by their distance from this level: cells of 8 voxels

struct Candidate {
    int axis = 0;
    glm::ivec3 start{0};
    double mean = 0, residual = 0; // of the values; of |value - its sample at kResidualLevel|
};

/// Every second row each way, staggered, so that all phases against the coarser lattices occur.
void addCandidates(const BrickFields& fields, int axis, std::vector<Candidate>& out) {
    const int u = (axis + 1) % 3, w = (axis + 2) % 3;
    const glm::ivec3 size = fields.size;
    const glm::ivec3 stride(1, size.x, size.x * size.y);
    const BrickFields::Box& box = fields.levels[kResidualLevel];
    for (int q = 0; 2 * q < size[w]; ++q)
        for (int p = 0; 2 * p < size[u]; ++p) {
            Candidate candidate;
            candidate.axis = axis;
            candidate.start[u] = std::min(2 * p + (q & 1), size[u] - 1);
            candidate.start[w] = std::min(2 * q + (p & 1), size[w] - 1);
            const float* voxel = fields.voxels.data() + linearIndex(candidate.start, size);
            glm::ivec3 at = candidate.start >> kResidualLevel;
            for (int first = 0; first < size[axis]; first += 1 << kResidualLevel) {
                at[axis] = first >> kResidualLevel;
                const double coarse = box.samples[linearIndex(at - box.first, box.extent)];
                const int end = std::min(first + (1 << kResidualLevel), size[axis]);
                for (int i = first; i < end; ++i) {
                    const double value = voxel[i * stride[axis]];
                    candidate.mean += value;
                    candidate.residual += std::abs(value - coarse);
                }
            }
            candidate.mean /= size[axis];
            candidate.residual /= size[axis];
            out.push_back(candidate);
        }
}

using Values = std::array<float, static_cast<std::size_t>(kRaysPerPart* kSamplesPerRay)>;

void sampleRay(const BrickFields& fields, const Candidate& ray, float* out) {
    for (int level = 0; level < kLevelCount; ++level) {
        const int samples = kRaySamples[static_cast<std::size_t>(level)];
        for (int j = 0; j < samples; ++j) {
            glm::dvec3 p = glm::dvec3(ray.start) + 0.5;
            p[ray.axis] = raySampleAt(j, samples, fields.size[ray.axis]);
            *out++ = fields.at(level, p);
        }
    }
}

BrickRayPart quantised(const Values& values) {
    BrickRayPart part;
    const auto [lo, hi] = std::minmax_element(values.begin(), values.end());
    part.lo = *lo;
    part.hi = *hi;
    const double range = static_cast<double>(part.hi) - static_cast<double>(part.lo);
    if (range > 0)
        for (std::size_t i = 0; i < values.size(); ++i)
            part.codes[i] = static_cast<std::uint8_t>(
                std::lround((static_cast<double>(values[i]) - static_cast<double>(part.lo)) / range * 255));
    return part;
}

} // namespace

void encode(const BrickRayPart& part, std::span<std::uint8_t, kBrickRayBytes> bytes) {
    std::memcpy(bytes.data(), &part.lo, sizeof part.lo);
    std::memcpy(bytes.data() + 4, &part.hi, sizeof part.hi);
    std::memcpy(bytes.data() + 8, &part.axes, sizeof part.axes);
    std::memcpy(bytes.data() + 12, part.codes.data(), part.codes.size());
}

BrickRayPart decodeRays(std::span<const std::uint8_t, kBrickRayBytes> bytes) {
    BrickRayPart part;
    std::memcpy(&part.lo, bytes.data(), sizeof part.lo);
    std::memcpy(&part.hi, bytes.data() + 4, sizeof part.hi);
    std::memcpy(&part.axes, bytes.data() + 8, sizeof part.axes);
    std::memcpy(part.codes.data(), bytes.data() + 12, part.codes.size());
    return part;
}

float rangeOfRays(std::span<const std::uint8_t, kBrickRayBytes> bytes) {
    float lo = 0, hi = 0;
    std::memcpy(&lo, bytes.data(), sizeof lo);
    std::memcpy(&hi, bytes.data() + sizeof lo, sizeof hi);
    return hi - lo;
}

double raySampleAt(int j, int samples, int n) {
    const double middle = (j + 0.5) * n / samples;
    if (samples < kRaySamples[0])
        return middle;
    // Alternately the voxel before and after the middle, so that odd and even voxels both occur.
    const double voxel = std::floor(middle + (j % 2 == 0 ? -0.25 : 0.25));
    return std::clamp(voxel, 0.0, n - 1.0) + 0.5;
}

float BrickFields::at(int level, const glm::dvec3& p) const {
    if (level == 0) {
        const glm::ivec3 voxel = glm::clamp(glm::ivec3(glm::floor(p)), glm::ivec3(0), size - 1);
        return voxels[linearIndex(voxel, size)];
    }
    const Box& box = levels[static_cast<std::size_t>(level)];
    glm::ivec3 low(0), high(0);
    glm::dvec3 f(0);
    for (int axis = 0; axis < 3; ++axis) {
        const double at = p[axis] / (1 << level) - 0.5 - box.first[axis];
        const double below = std::floor(at);
        f[axis] = at - below;
        low[axis] = std::clamp(static_cast<int>(below), 0, box.extent[axis] - 1);
        high[axis] = std::clamp(static_cast<int>(below) + 1, 0, box.extent[axis] - 1);
    }
    const auto row = [&](int y, int z) {
        const double a = box.samples[linearIndex({low.x, y, z}, box.extent)];
        const double b = box.samples[linearIndex({high.x, y, z}, box.extent)];
        return a + f.x * (b - a);
    };
    const auto plane = [&](int z) {
        const double a = row(low.y, z), b = row(high.y, z);
        return a + f.y * (b - a);
    };
    const double a = plane(low.z), b = plane(high.z);
    return static_cast<float>(a + f.z * (b - a));
}

std::array<BrickRayPart, kBrickRayParts> sampleRays(const BrickFields& fields) {
    std::vector<Candidate> candidates;
    candidates.reserve(3 * 256);
    for (int axis = 0; axis < 3; ++axis)
        addCandidates(fields, axis, candidates);
    std::vector<std::size_t> order(candidates.size());
    for (std::size_t i = 0; i < order.size(); ++i)
        order[i] = i;
    // Ties go to the first candidate, so that the choice is the same everywhere.
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
        return candidates[a].mean != candidates[b].mean ? candidates[a].mean < candidates[b].mean : a < b;
    });
    std::array<Values, kBrickRayParts> values{};
    std::array<std::uint32_t, kBrickRayParts> axes{};
    for (std::size_t group = 0; group < kRayGroups; ++group) {
        const std::size_t n = order.size();
        std::size_t first = n * group / kRayGroups, end = n * (group + 1) / kRayGroups;
        if (first == end) { // fewer candidates than groups: some occur twice
            first = std::min(first, n - 1);
            end = first + 1;
        }
        const auto begin = order.begin() + static_cast<std::ptrdiff_t>(first);
        std::sort(begin, order.begin() + static_cast<std::ptrdiff_t>(end), [&](std::size_t a, std::size_t b) {
            return candidates[a].residual != candidates[b].residual
                       ? candidates[a].residual < candidates[b].residual
                       : a < b;
        });
        for (std::size_t half = 0; half < kBrickRayParts; ++half) {
            const std::size_t middle = (end - first) * (2 * half + 1) / (2 * kBrickRayParts);
            const Candidate& ray = candidates[order[first + middle]];
            // Each part has near and far rays alternately, so that it is a fair sample by itself.
            const std::size_t part = (half + group) % kBrickRayParts;
            sampleRay(fields, ray, values[part].data() + group * kSamplesPerRay);
            axes[part] |= static_cast<std::uint32_t>(ray.axis) << (2 * group);
        }
    }
    const auto [least, most] = std::minmax_element(fields.voxels.begin(), fields.voxels.end());
    for (std::size_t part = 0; part < kBrickRayParts; ++part) {
        const auto voxel = static_cast<int>((part == 0 ? most : least) - fields.voxels.begin());
        Candidate ray;
        ray.axis = static_cast<int>(part);
        ray.start = {voxel % fields.size.x, voxel / fields.size.x % fields.size.y,
                     voxel / fields.size.x / fields.size.y};
        ray.start[ray.axis] = 0;
        sampleRay(fields, ray, values[part].data() + kRayGroups * kSamplesPerRay);
        axes[part] |= static_cast<std::uint32_t>(ray.axis) << (2 * kRayGroups);
    }
    std::array<BrickRayPart, kBrickRayParts> parts;
    for (std::size_t part = 0; part < parts.size(); ++part) {
        parts[part] = quantised(values[part]);
        parts[part].axes = axes[part];
    }
    return parts;
}

std::span<const std::uint8_t, kBrickRayBytes> BrickRays::part(std::uint32_t row, int part) const {
    const std::size_t at = row % kRowsPerPage * rowBytes() + static_cast<std::size_t>(part) * kBrickRayBytes;
    return std::span<const std::uint8_t, kBrickRayBytes>(pages[row / kRowsPerPage].data() + at,
                                                         kBrickRayBytes);
}

std::span<std::uint8_t> BrickRays::row(std::uint32_t row) {
    return std::span(pages[row / kRowsPerPage]).subspan(row % kRowsPerPage * rowBytes(), rowBytes());
}

} // namespace tessera
