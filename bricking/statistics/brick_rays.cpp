// bricking/statistics/brick_rays.cpp: see brick_rays.h.
#include "bricking/statistics/brick_rays.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <optional>
#include <type_traits>
#include <utility>
#include <vector>

namespace tessera {
namespace {

constexpr int kResidualLevel = 3; // rays are sorted by their distance from this level: cells of 8 voxels

constexpr int kEdge = kBrickExtent;
constexpr std::size_t kMostCandidates = 3 * std::size_t{kEdge / 2} * (kEdge / 2);

struct Candidate {
    int axis = 0;
    glm::ivec3 start{0};
    double mean = 0, residual = 0; // of the values; of |value - its sample at kResidualLevel|
};

/// Sums along all rows of a brick, by axis; a row's place is that of its first voxel.
/// @tparam Sum  double: in the order of the voxels; float: of whole numbers, which are exact in any order
template <typename Sum> struct RowSums {
    using Plane = std::array<Sum, static_cast<std::size_t>(kEdge* kEdge)>;
    std::array<Plane, 3> values, residuals;

    static std::size_t placeOf(int axis, const glm::ivec3& start) {
        return static_cast<std::size_t>(axis == 0   ? start.z * kEdge + start.y
                                        : axis == 1 ? start.z * kEdge + start.x
                                                    : start.y * kEdge + start.x);
    }
};

using RowOfFloats = std::array<float, static_cast<std::size_t>(kEdge)>;

/// Ranges of a brick's slices.
struct SliceRanges {
    RowOfFloats least, most;
};

template <typename Sum> Sum sumOf(const std::array<Sum, static_cast<std::size_t>(kEdge)>& row) {
    if constexpr (std::is_same_v<Sum, float>) {
        constexpr std::size_t kLanes = 8;
        std::array<float, kLanes> lanes{};
        for (std::size_t x = 0; x < row.size(); x += kLanes)
            for (std::size_t lane = 0; lane < kLanes; ++lane)
                lanes[lane] += row[x + lane];
        return std::accumulate(lanes.begin(), lanes.end(), 0.f);
    } else {
        return std::accumulate(row.begin(), row.end(), Sum{0});
    }
}

/// One pass over all voxels, by whole rows along x: the sums of every third row would take as long.
template <typename Sum> void sumRows(const BrickFields& fields, RowSums<Sum>& sums, SliceRanges& ranges) {
    using Row = std::array<Sum, static_cast<std::size_t>(kEdge)>;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        sums.values[axis].fill(0);
        sums.residuals[axis].fill(0);
    }
    const glm::ivec3 size = fields.size;
    const auto width = static_cast<std::size_t>(size.x);
    const BrickFields::Box& box = fields.levels[kResidualLevel];
    Row coarse{}, value{}, residual{}; // 0 beyond the brick
    RowOfFloats seen{};                // the last voxel again beyond it
    for (int z = 0; z < size.z; ++z) {
        RowOfFloats least, most;
        least.fill(std::numeric_limits<float>::infinity());
        most.fill(-std::numeric_limits<float>::infinity());
        for (int y = 0; y < size.y; ++y) {
            if (y % (1 << kResidualLevel) == 0) {
                const glm::ivec3 first = glm::ivec3(0, y, z) >> kResidualLevel;
                const float* const samples = box.samples.data() + linearIndex(first - box.first, box.extent);
                for (std::size_t x = 0; x < width; ++x)
                    coarse[x] = static_cast<Sum>(samples[x >> kResidualLevel]);
            }
            const float* const row = fields.voxels.data() + linearIndex({0, y, z}, size);
            seen.fill(row[width - 1]);
            std::copy_n(row, width, seen.begin());
            for (std::size_t x = 0; x < width; ++x)
                value[x] = static_cast<Sum>(row[x]);
            for (std::size_t x = 0; x < value.size(); ++x) {
                residual[x] = std::abs(value[x] - coarse[x]);
                least[x] = seen[x] < least[x] ? seen[x] : least[x];
                most[x] = most[x] < seen[x] ? seen[x] : most[x];
            }
            const std::size_t alongY = RowSums<Sum>::placeOf(1, {0, y, z}),
                              alongZ = RowSums<Sum>::placeOf(2, {0, y, z});
            for (std::size_t x = 0; x < value.size(); ++x) {
                sums.values[1][alongY + x] += value[x];
                sums.values[2][alongZ + x] += value[x];
                sums.residuals[1][alongY + x] += residual[x];
                sums.residuals[2][alongZ + x] += residual[x];
            }
            const std::size_t alongX = RowSums<Sum>::placeOf(0, {0, y, z});
            sums.values[0][alongX] = sumOf(value);
            sums.residuals[0][alongX] = sumOf(residual);
        }
        ranges.least[static_cast<std::size_t>(z)] = *std::min_element(least.begin(), least.end());
        ranges.most[static_cast<std::size_t>(z)] = *std::max_element(most.begin(), most.end());
    }
}

/// Every second row each way, staggered, so that all phases against the coarser lattices occur.
template <typename Sum>
void addCandidates(const glm::ivec3& size, const RowSums<Sum>& sums, int axis, std::vector<Candidate>& out) {
    const int u = (axis + 1) % 3, w = (axis + 2) % 3;
    const auto at = static_cast<std::size_t>(axis);
    for (int q = 0; 2 * q < size[w]; ++q)
        for (int p = 0; 2 * p < size[u]; ++p) {
            Candidate candidate;
            candidate.axis = axis;
            candidate.start[u] = std::min(2 * p + (q & 1), size[u] - 1);
            candidate.start[w] = std::min(2 * q + (p & 1), size[w] - 1);
            const std::size_t place = RowSums<Sum>::placeOf(axis, candidate.start);
            candidate.mean = static_cast<double>(sums.values[at][place]) / size[axis];
            candidate.residual = static_cast<double>(sums.residuals[at][place]) / size[axis];
            out.push_back(candidate);
        }
}

template <typename Sum>
void addCandidates(const BrickFields& fields, std::vector<Candidate>& out, SliceRanges& ranges) {
    static thread_local RowSums<Sum> sums; // 48 KiB: not for the stack
    sumRows(fields, sums, ranges);
    for (int axis = 0; axis < 3; ++axis)
        addCandidates(fields.size, sums, axis, out);
}

/// First of the least voxels and last of the most, as std::minmax_element() has them.
std::pair<std::size_t, std::size_t> extremesOf(const BrickFields& fields, const SliceRanges& ranges) {
    const std::size_t slices = static_cast<std::size_t>(fields.size.z), slice = fields.voxels.size() / slices;
    const float* const leastOf = std::min_element(ranges.least.data(), ranges.least.data() + slices);
    std::size_t z = slices - 1;
    for (std::size_t other = slices; other-- > 0;)
        z = ranges.most[other] > ranges.most[z] ? other : z;
    const auto first = static_cast<std::size_t>(leastOf - ranges.least.data()) * slice;
    const auto in = fields.voxels.subspan(first, slice);
    const auto least = static_cast<std::size_t>(std::find(in.begin(), in.end(), *leastOf) - in.begin());
    std::size_t most = (z + 1) * slice - 1;
    while (fields.voxels[most] != ranges.most[z])
        --most;
    return {first + least, most};
}

/// Numbers of candidates by ascending keys, of equal ones as they come: by bytes, the last one first.
class CandidateOrder {
  public:
    template <typename KeyOf> void sort(std::size_t count, const KeyOf& keyOf) {
        std::uint64_t differ = 0;
        for (std::size_t i = 0; i < count; ++i) {
            from_[i] = {bitsOf(keyOf(i)), static_cast<std::uint32_t>(i)};
            differ |= from_[i].bits ^ from_[0].bits;
        }
        for (int shift = 0; shift < 64; shift += 8)
            if ((differ >> shift & 0xFF) != 0)
                pass(count, shift);
    }
    std::size_t operator[](std::size_t rank) const { return from_[rank].number; }

  private:
    struct Entry {
        std::uint64_t bits;
        std::uint32_t number;
    };
    /// Whole numbers in the order of the keys; no key is NaN.
    static std::uint64_t bitsOf(double key) {
        const auto bits = std::bit_cast<std::uint64_t>(key + 0.0); // -0 is 0
        constexpr std::uint64_t kSign = std::uint64_t{1} << 63;
        return bits & kSign ? ~bits : bits | kSign;
    }
    void pass(std::size_t count, int shift) {
        std::array<std::uint32_t, 256> places{};
        const auto digit = [&](const Entry& entry) { return entry.bits >> shift & 0xFF; };
        for (std::size_t i = 0; i < count; ++i)
            ++places[digit(from_[i])];
        std::uint32_t before = 0;
        for (std::uint32_t& place : places)
            before += std::exchange(place, before);
        for (std::size_t i = 0; i < count; ++i)
            to_[places[digit(from_[i])]++] = from_[i];
        from_.swap(to_);
    }
    std::vector<Entry> from_ = std::vector<Entry>(kMostCandidates), to_ = from_;
};

using Values = std::array<float, static_cast<std::size_t>(kRaysPerPart* kSamplesPerRay)>;

/// Two samples of a level on either side of a place, along an axis: how far they lie in memory from the
/// level's first one, and the weight of the second.
struct Between {
    std::size_t low = 0, high = 0;
    double part = 0;
};

/// What a brick's fields have besides their values.
struct Shape {
    glm::ivec3 size{0};
    std::array<glm::ivec3, kLevelCount> first{}, extent{};
    bool operator==(const Shape&) const = default;
};
Shape shapeOf(const BrickFields& fields) {
    Shape shape;
    shape.size = fields.size;
    for (std::size_t level = 1; level < kLevelCount; ++level) {
        shape.first[level] = fields.levels[level].first;
        shape.extent[level] = fields.levels[level].extent;
    }
    return shape;
}

/// The value of all samples of all levels, if it is one, to the bit.
std::optional<float> onlyValueOf(const BrickFields& fields) {
    const float value = fields.voxels.front();
    const auto isAll = [&](std::span<const float> samples) {
        const std::span<const std::byte> bytes = std::as_bytes(samples);
        return std::bit_cast<std::uint32_t>(samples[0]) == std::bit_cast<std::uint32_t>(value) &&
               std::memcmp(bytes.data(), bytes.data() + sizeof value, bytes.size() - sizeof value) == 0;
    };
    if (!isAll(fields.voxels))
        return std::nullopt;
    for (std::size_t level = 1; level < kLevelCount; ++level)
        if (!isAll(fields.levels[level].samples))
            return std::nullopt;
    return value;
}

/// BrickFields::at() of places along rays, from tables that bricks of the same shape share.
class RaySampler {
  public:
    void setShape(const BrickFields& fields);
    void sample(const BrickFields& fields, const Candidate& ray, float* out) const;

  private:
    void setTables(const BrickFields& fields);
    using Table = std::array<std::array<Between, static_cast<std::size_t>(kEdge)>, 3>; // by axis
    Shape shape_;
    std::array<Table, kLevelCount> ofVoxels_, ofSamples_; // at voxels' centres; at raySampleAt()
};

Between betweenAt(const BrickFields::Box& box, int level, int axis, double voxel) {
    const double at = voxel / (1 << level) - 0.5 - box.first[axis];
    const double below = std::floor(at);
    const auto strides = glm::ivec3(1, box.extent.x, box.extent.x * box.extent.y);
    const auto offset = [&](int sample) {
        return static_cast<std::size_t>(std::clamp(sample, 0, box.extent[axis] - 1) * strides[axis]);
    };
    const int low = static_cast<int>(below);
    return {offset(low), offset(low + 1), at - below};
}

float trilinear(const BrickFields::Box& box, const Between& x, const Between& y, const Between& z) {
    const auto row = [&](std::size_t start) {
        const double a = box.samples[start + x.low], b = box.samples[start + x.high];
        return a + x.part * (b - a);
    };
    const auto plane = [&](std::size_t start) {
        const double a = row(start + y.low), b = row(start + y.high);
        return a + y.part * (b - a);
    };
    const double a = plane(z.low), b = plane(z.high);
    return static_cast<float>(a + z.part * (b - a));
}

void RaySampler::setShape(const BrickFields& fields) {
    if (const Shape shape = shapeOf(fields); shape != std::exchange(shape_, shape))
        setTables(fields);
}

void RaySampler::setTables(const BrickFields& fields) {
    for (int level = 1; level < kLevelCount; ++level) {
        const auto of = static_cast<std::size_t>(level);
        const int samples = kRaySamples[of];
        for (int axis = 0; axis < 3; ++axis) {
            const auto along = static_cast<std::size_t>(axis);
            for (int voxel = 0; voxel < kEdge; ++voxel)
                ofVoxels_[of][along][static_cast<std::size_t>(voxel)] =
                    betweenAt(fields.levels[of], level, axis, voxel + 0.5);
            for (int j = 0; j < samples; ++j)
                ofSamples_[of][along][static_cast<std::size_t>(j)] =
                    betweenAt(fields.levels[of], level, axis, raySampleAt(j, samples, fields.size[axis]));
        }
    }
}

void RaySampler::sample(const BrickFields& fields, const Candidate& ray, float* out) const {
    glm::dvec3 p = glm::dvec3(ray.start) + 0.5;
    for (int j = 0; j < kRaySamples[0]; ++j) {
        p[ray.axis] = raySampleAt(j, kRaySamples[0], fields.size[ray.axis]);
        *out++ = fields.at(0, p);
    }
    for (std::size_t level = 1; level < kLevelCount; ++level) {
        std::array<Between, 3> at;
        for (int axis = 0; axis < 3; ++axis) {
            const auto along = static_cast<std::size_t>(axis);
            at[along] = ofVoxels_[level][along][static_cast<std::size_t>(ray.start[axis])];
        }
        const auto along = static_cast<std::size_t>(ray.axis);
        for (std::size_t j = 0; j < static_cast<std::size_t>(kRaySamples[level]); ++j) {
            at[along] = ofSamples_[level][along][j];
            *out++ = trilinear(fields.levels[level], at[0], at[1], at[2]);
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
        for (std::size_t i = 0; i < values.size(); ++i) {
            const double code = (static_cast<double>(values[i]) - static_cast<double>(part.lo)) / range * 255;
            const int below = static_cast<int>(code); // to the nearest, halves up: as std::lround(), inline
            part.codes[i] = static_cast<std::uint8_t>(below + (code - below >= 0.5 ? 1 : 0));
        }
    return part;
}

std::array<BrickRayPart, kBrickRayParts> chooseRays(const BrickFields& fields) {
    static thread_local std::vector<Candidate> candidates;
    static thread_local CandidateOrder byMean, byResidual;
    static thread_local RaySampler sampler;
    sampler.setShape(fields);
    candidates.clear();
    SliceRanges ranges;
    if (fields.isWhole)
        addCandidates<float>(fields, candidates, ranges);
    else
        addCandidates<double>(fields, candidates, ranges);
    // Ties go to the first candidate, so that the choice is the same everywhere.
    const std::size_t n = candidates.size();
    byMean.sort(n, [](std::size_t i) { return candidates[i].mean; });
    byResidual.sort(n, [](std::size_t i) { return candidates[i].residual; });
    // Groups of ranks by mean, in each the candidates by residual.
    std::array<std::uint32_t, kMostCandidates> order{}, groupOf{}; // of a candidate
    std::array<std::size_t, kRayGroups + 1> firstOf{};
    for (std::size_t group = 0; group <= kRayGroups; ++group)
        firstOf[group] = n * group / kRayGroups;
    for (std::size_t group = 0; group < kRayGroups; ++group)
        for (std::size_t rank = firstOf[group]; rank < firstOf[group + 1]; ++rank)
            groupOf[byMean[rank]] = static_cast<std::uint32_t>(group);
    std::array<std::size_t, kRayGroups + 1> next = firstOf;
    for (std::size_t i = 0; i < n; ++i)
        order[next[groupOf[byResidual[i]]]++] = static_cast<std::uint32_t>(byResidual[i]);
    std::array<Values, kBrickRayParts> values{};
    std::array<std::uint32_t, kBrickRayParts> axes{};
    for (std::size_t group = 0; group < kRayGroups; ++group) {
        std::size_t first = firstOf[group], end = firstOf[group + 1];
        if (first == end) { // fewer candidates than groups: some occur twice
            first = std::min(first, n - 1);
            end = first + 1;
        }
        for (std::size_t half = 0; half < kBrickRayParts; ++half) {
            const std::size_t middle = (end - first) * (2 * half + 1) / (2 * kBrickRayParts);
            const Candidate& ray = candidates[order[first + middle]];
            // Each part has near and far rays alternately, so that it is a fair sample by itself.
            const std::size_t part = (half + group) % kBrickRayParts;
            sampler.sample(fields, ray, values[part].data() + group * kSamplesPerRay);
            axes[part] |= static_cast<std::uint32_t>(ray.axis) << (2 * group);
        }
    }
    const auto [least, most] = extremesOf(fields, ranges);
    for (std::size_t part = 0; part < kBrickRayParts; ++part) {
        const auto voxel = static_cast<int>(part == 0 ? most : least);
        Candidate ray;
        ray.axis = static_cast<int>(part);
        ray.start = {voxel % fields.size.x, voxel / fields.size.x % fields.size.y,
                     voxel / fields.size.x / fields.size.y};
        ray.start[ray.axis] = 0;
        sampler.sample(fields, ray, values[part].data() + kRayGroups * kSamplesPerRay);
        axes[part] |= static_cast<std::uint32_t>(ray.axis) << (2 * kRayGroups);
    }
    std::array<BrickRayPart, kBrickRayParts> parts;
    for (std::size_t part = 0; part < parts.size(); ++part) {
        parts[part] = quantised(values[part]);
        parts[part].axes = axes[part];
    }
    return parts;
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
    return trilinear(box, betweenAt(box, level, 0, p.x), betweenAt(box, level, 1, p.y),
                     betweenAt(box, level, 2, p.z));
}

std::array<BrickRayPart, kBrickRayParts> sampleRays(const BrickFields& fields) {
    const std::optional<float> value = onlyValueOf(fields);
    if (!value)
        return chooseRays(fields);
    // Much of a scan is air of one value: such a brick's rays are those of the one before.
    static thread_local Shape shape;
    static thread_local std::uint32_t bits = 0;
    static thread_local std::array<BrickRayPart, kBrickRayParts> rays;
    const std::uint32_t nowBits = std::bit_cast<std::uint32_t>(*value);
    if (const Shape now = shapeOf(fields); now != shape || nowBits != bits) {
        rays = chooseRays(fields);
        shape = now;
        bits = nowBits;
    }
    return rays;
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
