// datasets/colon_shape.cpp: see colon_shape.h.
#include "datasets/colon_shape.h"

#include "datasets/phantom.h"

#include <algorithm>

namespace tessera {
namespace {

constexpr float kFoldSpacingMm = 28;     // of one row; the three rows are staggered by a third of it
constexpr float kFoldHalfWidthMm = 3.2F; // a fold is half as high 1.7 mm from its crest
constexpr float kPouch = 0.10F;          // swelling between folds, part of the radius
constexpr float kTaeniae = 0.05F;        // how triangular the lumen is
constexpr float kSqrt3Half = 0.8660254F;
constexpr float kClosedWallMm = 5, kClosedLumenMm = -4; // where it is collapsed

// control points of a cubic B-spline; caecum first
const std::vector<glm::vec3> kControl = {
    {-64, -36, -166}, {-66, -34, -158}, {-74, -26, -134}, {-84, -10, -108}, {-90, 6, -86},   {-90, 4, -66},
    {-84, -22, -64},  {-72, -44, -76},  {-48, -54, -92},  {-18, -58, -104}, {14, -58, -106}, {44, -56, -94},
    {66, -46, -72},   {82, -26, -46},   {92, -4, -34},    {96, 14, -44},    {98, 20, -66},   {95, 15, -90},
    {89, 2, -114},    {80, -16, -138},  {66, -32, -156},  {44, -40, -162},  {20, -34, -150}, {0, -14, -138},
    {-14, 8, -138},   {-14, 28, -150},  {-4, 42, -166},   {0, 44, -184},    {0, 38, -200},   {0, 30, -214}};

glm::vec3 bspline(float u) { // u in [0, control - 3]
    const auto i = std::min(static_cast<std::size_t>(u), kControl.size() - 4);
    const float t = u - static_cast<float>(i), s = 1 - t;
    return (s * s * s * kControl[i] + (3 * t * t * t - 6 * t * t + 4) * kControl[i + 1] +
            (3 * s * s * s - 6 * s * s + 4) * kControl[i + 2] + t * t * t * kControl[i + 3]) /
           6.0F;
}

float smoothStep(float low, float high, float x) {
    const float t = std::clamp((x - low) / (high - low), 0.0F, 1.0F);
    return t * t * (3 - 2 * t);
}

} // namespace

ColonCourse::ColonCourse(bool collapsed) : collapsed_(collapsed) {
    // equal steps of arc along a finely cut curve
    std::vector<glm::vec3> fine;
    const int steps = static_cast<int>(kControl.size() - 3) * 200;
    for (int i = 0; i <= steps; ++i)
        fine.push_back(bspline(static_cast<float>(i) / 200.0F));
    std::vector<float> arc = {0};
    for (std::size_t i = 1; i < fine.size(); ++i)
        arc.push_back(arc.back() + glm::length(fine[i] - fine[i - 1]));
    lengthMm_ = arc.back();
    const int count = static_cast<int>(std::round(lengthMm_ / 2));
    stationMm_ = lengthMm_ / static_cast<float>(count);
    std::size_t at = 0;
    for (int k = 0; k <= count; ++k) {
        const float wanted = std::min(stationMm_ * static_cast<float>(k), lengthMm_);
        while (at + 2 < arc.size() && arc[at + 1] < wanted)
            ++at;
        const float t = std::clamp((wanted - arc[at]) / (arc[at + 1] - arc[at]), 0.0F, 1.0F);
        stations_.push_back({fine[at] + t * (fine[at + 1] - fine[at]), {}, {}});
    }
    glm::vec3 normal(0, -1, 0);
    for (std::size_t k = 0; k < stations_.size(); ++k) {
        const glm::vec3 along = glm::normalize(stations_[std::min(k + 1, stations_.size() - 1)].at -
                                               stations_[k > 0 ? k - 1 : 0].at);
        normal = glm::normalize(normal - glm::dot(normal, along) * along); // carried on without twist
        stations_[k].normal = normal;
        stations_[k].binormal = glm::cross(along, normal);
    }
}

ColonCourse::Station ColonCourse::atArc(float arcMm) const {
    const float u = std::clamp(arcMm / stationMm_, 0.0F, static_cast<float>(stations_.size() - 1));
    const auto i = std::min(static_cast<std::size_t>(u), stations_.size() - 2);
    const float t = u - static_cast<float>(i);
    const Station &a = stations_[i], &b = stations_[i + 1];
    return {a.at + t * (b.at - a.at), glm::normalize(a.normal + t * (b.normal - a.normal)),
            glm::normalize(a.binormal + t * (b.binormal - a.binormal))};
}

float ColonCourse::radiusMm(float arcFraction) {
    struct Stop {
        float u, radius;
    };
    constexpr Stop kStops[] = {{0, 23},     {0.1F, 23},     {0.3F, 20},  {0.5F, 19},  {0.62F, 18},
                               {0.75F, 16}, {0.86F, 14.5F}, {0.92F, 17}, {0.97F, 20}, {1, 16}};
    for (std::size_t i = 0; i + 1 < std::size(kStops); ++i)
        if (arcFraction <= kStops[i + 1].u) {
            const float t = smoothStep(kStops[i].u, kStops[i + 1].u, arcFraction);
            return kStops[i].radius + t * (kStops[i + 1].radius - kStops[i].radius);
        }
    return kStops[std::size(kStops) - 1].radius;
}

ColonCourse::Lumen ColonCourse::lumen(float arcMm, float cosine, float sine, bool withFolds) const {
    const float base = radiusMm(arcMm / lengthMm_);
    const float triangular = kTaeniae * (4 * cosine * cosine * cosine - 3 * cosine); // cos of 3 angles
    // folds fade out in the caecal pole and the rectum, and are lower in the descending colon
    const float fade = smoothStep(6, 24, arcMm) * (1 - smoothStep(0.90F, 0.95F, arcMm / lengthMm_)) *
                       (1 - 0.25F * smoothStep(0.55F, 0.7F, arcMm / lengthMm_));
    Lumen lumen{base * (1 + triangular), 0};
    constexpr float kRows[3][2] = {{1, 0}, {-0.5F, kSqrt3Half}, {-0.5F, -kSqrt3Half}};
    for (std::uint32_t row = 0; row < 3; ++row) {
        const float facing = cosine * kRows[row][0] + sine * kRows[row][1];
        const float window = smoothStep(0.25F, 0.7F, facing);
        if (window <= 0)
            continue;
        const float place = arcMm / kFoldSpacingMm - static_cast<float>(row) / 3;
        const float index = std::floor(place + 0.5F);
        const auto fold = static_cast<std::uint32_t>(static_cast<int>(index) + 8);
        const float shift = (hashUnit(fold, row, 71) - 0.5F) * 0.22F;
        const float ds = (place - index - shift) * kFoldSpacingMm;
        const float x = std::min(std::abs(ds) / (0.5F * kFoldSpacingMm), 1.0F);
        const float sign = ds < 0 ? -1.0F : 1.0F;
        lumen.radiusMm += window * kPouch * base * fade * (2 - x * x) * x * x;
        lumen.slope += window * kPouch * base * fade * sign * 4 * x * (1 - x * x) / (0.5F * kFoldSpacingMm);
        if (!withFolds || std::abs(ds) >= kFoldHalfWidthMm)
            continue;
        const float depth = window * fade * base * (0.26F + 0.14F * hashUnit(fold, row, 72));
        const float w = ds / kFoldHalfWidthMm;
        lumen.radiusMm -= depth * (1 - w * w) * (1 - w * w);
        lumen.slope += depth * 4 * w * (1 - w * w) / kFoldHalfWidthMm;
    }
    if (collapsed_)
        close(lumen, arcMm, withFolds ? kClosedLumenMm : kClosedWallMm);
    return lumen;
}

void ColonCourse::close(Lumen& lumen, float arcMm, float closedMm) const {
    constexpr auto kClosing = static_cast<float>(kColonClosingMm);
    const float from = static_cast<float>(kCollapsedFrom) * lengthMm_;
    const float to = static_cast<float>(kCollapsedTo) * lengthMm_;
    const float away = std::max({from - arcMm, arcMm - to, 0.0F});
    if (away >= kClosing)
        return;
    const float open = smoothStep(0, kClosing, away), t = away / kClosing;
    const float opening =
        (arcMm < from ? -1.0F : 1.0F) * 6 * t * (1 - t) / kClosing; // of `open` along the course
    lumen.slope = open * lumen.slope + opening * (lumen.radiusMm - closedMm);
    lumen.radiusMm = closedMm + open * (lumen.radiusMm - closedMm);
}

ColonGrid::ColonGrid(std::shared_ptr<const ColonCourse> course) : course_(std::move(course)) {
    const auto& stations = course_->stations();
    low_ = glm::vec3(1e9F);
    glm::vec3 high(-1e9F);
    for (const auto& station : stations) {
        low_ = glm::min(low_, station.at);
        high = glm::max(high, station.at);
    }
    low_ -= kReachMm;
    cells_ = glm::ivec3(glm::ceil((high + kReachMm - low_) / kCellMm));
    const float halfDiagonal = kCellMm * kSqrt3Half;
    std::vector<float> squared(stations.size());
    for (int k = 0; k < cells_.z; ++k)
        for (int j = 0; j < cells_.y; ++j)
            for (int i = 0; i < cells_.x; ++i) {
                firstOfCell_.push_back(static_cast<std::uint32_t>(candidates_.size()));
                const glm::vec3 centre = low_ + (glm::vec3(i, j, k) + 0.5F) * kCellMm;
                float best = 1e18F;
                for (std::size_t s = 0; s < stations.size(); ++s) {
                    const glm::vec3 away = stations[s].at - centre;
                    squared[s] = glm::dot(away, away);
                    best = std::min(best, squared[s]);
                }
                const float reach = std::sqrt(best) + 2 * halfDiagonal;
                if (reach > kReachMm + 3 * halfDiagonal)
                    continue;
                for (std::size_t s = 0; s < stations.size(); ++s)
                    if (squared[s] <= reach * reach)
                        candidates_.push_back(static_cast<std::uint16_t>(s));
            }
    firstOfCell_.push_back(static_cast<std::uint32_t>(candidates_.size()));
}

bool ColonGrid::nearest(const glm::vec3& p, Nearest& found) const {
    const glm::vec3 place = (p - low_) / kCellMm;
    if (place.x < 0 || place.y < 0 || place.z < 0)
        return false;
    const glm::ivec3 cell(place);
    if (cell.x >= cells_.x || cell.y >= cells_.y || cell.z >= cells_.z)
        return false;
    const auto at = static_cast<std::size_t>((cell.z * cells_.y + cell.y) * cells_.x + cell.x);
    const auto& stations = course_->stations();
    std::size_t closest = stations.size();
    float best = 1e18F;
    for (std::uint32_t k = firstOfCell_[at]; k < firstOfCell_[at + 1]; ++k) {
        const glm::vec3 away = p - stations[candidates_[k]].at;
        const float d2 = glm::dot(away, away);
        if (d2 < best) {
            best = d2;
            closest = candidates_[k];
        }
    }
    if (closest == stations.size())
        return false;
    // the stations are close beside the curve's bends, so the nearest point is on one of the two segments
    // here
    best = 1e18F;
    const std::size_t first = closest > 0 ? closest - 1 : 0;
    for (std::size_t s = first; s <= closest && s + 1 < stations.size(); ++s) {
        const glm::vec3 fromA = p - stations[s].at, ab = stations[s + 1].at - stations[s].at;
        const float t = std::clamp(glm::dot(fromA, ab) / glm::dot(ab, ab), 0.0F, 1.0F);
        const glm::vec3 away = fromA - t * ab;
        const float d2 = glm::dot(away, away);
        if (d2 < best) {
            best = d2;
            found = {(static_cast<float>(s) + t) * course_->stationMm(), 0, s, t};
        }
    }
    found.distanceMm = std::sqrt(best);
    return true;
}

float Colon::distance(const glm::vec3& p) const {
    ColonGrid::Nearest n{};
    if (!grid_->nearest(p, n))
        return ColonGrid::kReachMm * 0.25F;
    const auto &a = grid_->course().stations()[n.station], &b = grid_->course().stations()[n.station + 1];
    const glm::vec3 away = p - (a.at + n.t * (b.at - a.at));
    const float u = glm::dot(away, a.normal + n.t * (b.normal - a.normal));
    const float v = glm::dot(away, a.binormal + n.t * (b.binormal - a.binormal));
    const float across = std::sqrt(u * u + v * v);
    const float cosine = across > 1e-4F ? u / across : 1, sine = across > 1e-4F ? v / across : 0;
    const ColonCourse::Lumen lumen = grid_->course().lumen(n.arcMm, cosine, sine, withFolds_);
    return (n.distanceMm - lumen.radiusMm) / std::sqrt(1 + lumen.slope * lumen.slope);
}

Range Colon::bounds(const glm::vec3& c, float r) const {
    const float kNarrowest = grid_->course().collapsed() ? kClosedLumenMm : 14.4F * 0.5F;
    constexpr float kWidest = 23.1F * 1.16F, kSteepest = 8; // of radius and slope
    ColonGrid::Nearest n{};
    if (r > 20)
        return {-1e9F, 1e9F};
    if (!grid_->nearest(c, n) || n.distanceMm > ColonGrid::kReachMm - 1)
        return {(ColonGrid::kReachMm - 1 - r - kWidest) / kSteepest, 1e9F};
    const float low = n.distanceMm - r - kWidest, high = n.distanceMm + r - kNarrowest;
    return {low > 0 ? low / kSteepest : low, high < 0 ? high / kSteepest : high};
}

} // namespace tessera
