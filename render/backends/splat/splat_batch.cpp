// render/backends/splat/splat_batch.cpp: see splat_batch.h.
#include "render/backends/splat/splat_batch.h"

#include "core/base/error.h"
#include "core/base/threads.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <limits>

namespace tessera {
namespace {

constexpr std::size_t kMost = std::size_t{1} << 19; // splats of a batch; more would leave the cache
constexpr int kPatch = 8;                           // samples, along both axes of a slice
constexpr double kNearest = 3;                      // deviations of a kernel before the eye

} // namespace

SplatCounts& SplatCounts::operator+=(const SplatCounts& o) {
    drawn += o.drawn;
    for (std::size_t n = 0; n < byFilter.size(); ++n)
        byFilter[n] += o.byFilter[n];
    pixels += o.pixels;
    tooNear += o.tooNear;
    tooThin += o.tooThin;
    return *this;
}

SplatBatch::SplatBatch(const SplatView& view, const SplatSettings& settings, const SliceOrder& order,
                       float brightest, SheetTiles& tiles, std::size_t bytes, MemoryBudget& budget)
    : view_(view), settings_(settings), order_(order), brightest_(brightest), tiles_(tiles),
      numbers_(settings) {
    for (int level = 0; level < kLevelCount; ++level)
        depths_[static_cast<std::size_t>(level)] = FilterDepths::of(view, settings, level);
    // A slice of a brick has a splat at least.
    const std::size_t count = std::clamp(bytes / (sizeof(DrawnSplat) + sizeof(Unit)), kLeast, kMost);
    charge_ = budget.charge(count * (sizeof(DrawnSplat) + sizeof(Unit)), "splats that are drawn together");
    splats_.resize(count);
    units_.reserve(count);
}

glm::dvec3 SplatBatch::middleOf(const BrickList& list, int slice, int place) const {
    const int edge = kBrickExtent >> list.level;
    return (glm::dvec3(list.brick * edge + order_.sample(slice, place)) + 0.5) *
           static_cast<double>(1 << list.level);
}

/// Numbers of a footprint are no larger than where each of their parts is.
TileBox SplatBatch::tilesOf(const glm::dvec3& low, const glm::dvec3& high, int level) const {
    const double deviation = settings_.sigma * (1 << level);
    glm::dvec2 least(std::numeric_limits<double>::max()), most(-least), tangent(0);
    double nearest = least.x, farthest = -least.x;
    for (int n = 0; n < 8; ++n) {
        const glm::dvec3 u = view_.place(glm::mix(low, high, glm::dvec3(n & 1, (n >> 1) & 1, n >> 2)));
        nearest = std::min(nearest, u.z);
        farthest = std::max(farthest, u.z);
        const glm::dvec2 at = view_.perspective ? glm::dvec2(u) / u.z : glm::dvec2(u);
        least = glm::min(least, at);
        most = glm::max(most, at);
    }
    if (view_.perspective) {
        const double first = kNearest * deviation * view_.deviations.z;
        if (nearest < first)
            return {glm::ivec2(0), farthest < first ? glm::ivec2(0) : tiles_.grid()};
        tangent = glm::max(glm::abs(least), glm::abs(most));
    }
    glm::dvec2 reach;
    for (int axis = 0; axis < 2; ++axis) {
        const double kernel = view_.deviations.z * deviation * view_.scale * (1 + tangent[axis]) /
                              (view_.perspective ? nearest : 1);
        reach[axis] = settings_.cutOff * std::hypot(kernel, settings_.lowPass) + 1;
    }
    return tiles_.around(glm::vec2(view_.middle + view_.scale * least - reach),
                         glm::vec2(view_.middle + view_.scale * most + reach));
}

std::array<SplatFilter, 16> SplatBatch::filtersOf(const BrickList& list, int slice) const {
    std::array<SplatFilter, 16> filters;
    filters.fill(settings_.filter);
    if (settings_.filter != SplatFilter::adaptive)
        return filters;
    const int edge = kBrickExtent >> list.level, patch = std::min(edge, kPatch);
    const FilterDepths& depths = depths_[static_cast<std::size_t>(list.level)];
    for (int y = 0; y < edge; y += patch)
        for (int x = 0; x < edge; x += patch) {
            double corners[4];
            for (int n = 0; n < 4; ++n) {
                const int place = (x + (n & 1) * (patch - 1)) | (y + (n >> 1) * (patch - 1)) << 5;
                corners[n] = view_.perspective ? view_.place(middleOf(list, slice, place)).z : 1;
            }
            filters[static_cast<std::size_t>(x / kPatch + 4 * (y / kPatch))] = depths.choose(corners);
        }
    return filters;
}

void SplatBatch::put(const glm::vec3& at, const glm::mat3& kernel, float mass, SplatFilter filter,
                     const glm::vec3& colour, Projected& out) const {
    const glm::vec2 middle(view_.middle);
    DrawnSplat& splat = *out.next;
    if (!filtered(footprintOf(view_.perspective, static_cast<float>(view_.scale), middle, at, kernel), filter,
                  numbers_, mass, splat)) {
        ++out.counts.tooThin;
        return;
    }
    const glm::vec2 place(splat.x, splat.y), half(splat.halfWidth, splat.halfHeight);
    if (glm::any(glm::lessThan(place + half, glm::vec2(0))) ||
        glm::any(glm::greaterThan(place - half, middle + middle)))
        return;
    splat.red = colour.r;
    splat.green = colour.g;
    splat.blue = colour.b;
    out.low = glm::min(out.low, place - half);
    out.high = glm::max(out.high, place + half);
    ++out.counts.byFilter[static_cast<std::size_t>(filter)];
    out.counts.pixels += static_cast<double>(4 * half.x * half.y);
    ++out.next;
}

void SplatBatch::projectSamples(const Unit& unit, Projected& out) const {
    const BrickList& list = *unit.list;
    const double pitch = 1 << list.level;
    const std::array<SplatFilter, 16> filters = filtersOf(list, unit.slice);
    const glm::mat3 kernel = view_.kernel(settings_.sigma * pitch);
    const glm::vec3 first(view_.place(middleOf(list, unit.slice, 0)));
    const auto [across, along] = order_.others();
    const glm::vec3 right(view_.axes[across] * pitch), down(view_.axes[along] * pitch);
    const auto nearest = static_cast<float>(kNearest * settings_.sigma * pitch * view_.deviations.z);
    const float bright = brightest_ / 65535;
    for (const ShownSample& s : list.of(unit.slice)) {
        const int x = s.place & 31, y = s.place >> 5;
        const glm::vec3 u = first + static_cast<float>(x) * right + static_cast<float>(y) * down;
        if (view_.perspective && u.z < nearest) {
            ++out.counts.tooNear;
            continue;
        }
        put(u, kernel, s.mass * unit.share,
            filters[static_cast<std::size_t>((x / kPatch) + 4 * (y / kPatch))],
            glm::vec3(s.red, s.green, s.blue) * std::ldexp(bright, -s.halvings), out);
    }
}

void SplatBatch::projectPoints(const Unit& unit, Projected& out) const {
    for (const ShownPoint& point : unit.points) {
        const PointLook& look = unit.looks[point.look];
        if (view_.perspective && point.at.z < look.nearest) {
            ++out.counts.tooNear;
            continue;
        }
        const double depth = view_.perspective ? double{point.at.z} : 1;
        const SplatFilter filter = settings_.filter == SplatFilter::adaptive
                                       ? look.filters.choose(std::span(&depth, 1))
                                       : settings_.filter;
        put(point.at, look.kernel, look.mass, filter, look.colour, out);
    }
}

void SplatBatch::project(Unit& unit) {
    DrawnSplat* const first = splats_.data() + unit.first;
    constexpr float kFar = std::numeric_limits<float>::max();
    Projected out{first, glm::vec2(kFar), glm::vec2(-kFar), unit.counts};
    if (unit.list)
        projectSamples(unit, out);
    else
        projectPoints(unit, out);
    unit.count = unit.counts.drawn = static_cast<std::size_t>(out.next - first);
    if (unit.count > 0)
        unit.tiles = tiles_.around(out.low, out.high);
}

void SplatBatch::add(const BrickList& list, int slice, int sheet, float share, int threads) {
    const std::size_t count = list.of(slice).size();
    if (count == 0)
        return;
    if (used_ + count > splats_.size())
        draw(threads);
    TESSERA_CHECK(used_ + count <= splats_.size());
    units_.push_back({&list, slice, sheet, share, used_, 0, {}, {}, {}, {}});
    used_ += count;
}

void SplatBatch::add(std::span<const ShownPoint> points, std::span<const PointLook> looks, int threads) {
    while (!points.empty()) {
        if (used_ == splats_.size())
            draw(threads);
        const std::size_t count = std::min({points.size(), splats_.size() - used_, kLeast});
        units_.push_back({nullptr, 0, points.front().sheet, 1, used_, 0, {}, {}, points.first(count), looks});
        points = points.subspan(count);
        used_ += count;
    }
}

void SplatBatch::draw(int threads) {
    parallelFor(units_.size(), threads, [this](std::size_t n) { project(units_[n]); });
    parallelFor(tiles_.count(), threads, [this](std::size_t tile) {
        const auto width = static_cast<std::size_t>(tiles_.grid().x);
        const glm::ivec2 at(static_cast<int>(tile % width), static_cast<int>(tile / width));
        for (const Unit& unit : units_)
            if (unit.tiles.holds(at))
                tiles_.draw(tile, unit.sheet, std::span(splats_).subspan(unit.first, unit.count));
    });
    for (const Unit& unit : units_)
        counts_ += unit.counts;
    units_.clear();
    used_ = 0;
}

} // namespace tessera
