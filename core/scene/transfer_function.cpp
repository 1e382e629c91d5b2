// core/scene/transfer_function.cpp: see transfer_function.h.
#include "core/scene/transfer_function.h"

#include "core/base/error.h"
#include "core/base/magnitude.h"

#include <algorithm>
#include <cmath>

namespace tessera {

GradientOpacity GradientOpacity::fromPoints(std::vector<GradientPoint> points, Per per,
                                            const std::string& where) {
    if (points.size() > kMostPoints)
        throw InputError(where + ": expected at most " + std::to_string(kMostPoints) + " points, found " +
                         std::to_string(points.size()));
    for (GradientPoint& p : points) {
        checkValue(p.length, "a gradient's length", where);
        if (!(p.length >= 0))
            throw InputError(where + ": expected lengths of 0 or more, found " + shownNumber(p.length));
        if (!std::isfinite(p.factor))
            throw InputError(where + ": expected finite numbers, found factor " + std::to_string(p.factor));
        p.factor = std::clamp(p.factor, 0.0, 1.0);
    }
    std::stable_sort(points.begin(), points.end(),
                     [](const GradientPoint& a, const GradientPoint& b) { return a.length < b.length; });
    GradientOpacity out;
    if (std::all_of(points.begin(), points.end(), [](const GradientPoint& p) { return p.factor == 1; }))
        return out;
    out.points_ = std::move(points);
    out.per_ = per;
    return out;
}

double GradientOpacity::factor(double length) const {
    if (points_.empty())
        return 1;
    const auto right = std::upper_bound(points_.begin(), points_.end(), length,
                                        [](double x, const GradientPoint& p) { return x < p.length; });
    if (right == points_.begin())
        return right->factor;
    const auto left = right - 1;
    if (right == points_.end())
        return left->factor;
    return left->factor +
           (length - left->length) / (right->length - left->length) * (right->factor - left->factor);
}

GradientOpacity GradientOpacity::perMm(double spacingMm) const {
    GradientOpacity out = *this;
    if (per_ == Per::voxel)
        for (GradientPoint& p : out.points_)
            p.length /= spacingMm;
    out.per_ = Per::mm;
    return out;
}

namespace {

// Opacity 1 would be infinite extinction; this is the largest float below 1 (docs/sampling.md).
constexpr double kMaxOpacity = 1.0 - 0x1p-24;

/// Linear between the two points around value, constant beyond the outermost; `get` picks what to read.
/// Among points of equal value the last decides at the value itself and to its right, the first to its left.
template <typename Point, typename Get>
auto piecewiseLinear(const std::vector<Point>& points, double value, Get get) {
    const auto right = std::upper_bound(points.begin(), points.end(), value,
                                        [](double v, const Point& p) { return v < p.value; });
    if (right == points.begin())
        return get(*right);
    const auto left = right - 1;
    if (right == points.end())
        return get(*left);
    const double f = (value - left->value) / (right->value - left->value);
    return get(*left) + f * (get(*right) - get(*left));
}

template <typename Point> void sortByValue(std::vector<Point>& points) {
    std::stable_sort(points.begin(), points.end(),
                     [](const Point& a, const Point& b) { return a.value < b.value; });
}

void checkFinite(double number, const char* what, const std::string& where) {
    if (!std::isfinite(number))
        throw InputError(where + ": expected finite numbers, found " + what + " " + std::to_string(number));
}

/// Sorts them. Throws InputError for ranges that are empty or share values, and for too many.
template <typename Range>
void checkRanges(std::vector<Range>& ranges, std::size_t most, const std::string& what,
                 const std::string& where) {
    std::stable_sort(ranges.begin(), ranges.end(),
                     [](const Range& a, const Range& b) { return a.from < b.from; });
    if (ranges.size() > most)
        throw InputError(where + ": expected at most " + std::to_string(most) + " " + what + "s, found " +
                         std::to_string(ranges.size()));
    for (std::size_t i = 0; i < ranges.size(); ++i) {
        checkValue(ranges[i].from, "a " + what + "'s \"from\"", where);
        checkValue(ranges[i].to, "a " + what + "'s \"to\"", where);
        if (!(ranges[i].from < ranges[i].to))
            throw InputError(where + ": expected a " + what + "'s \"from\" below its \"to\"");
        if (i > 0 && ranges[i].from < ranges[i - 1].to)
            throw InputError(where + ": expected " + what + "s that share no value");
    }
}

} // namespace

TransferFunction TransferFunction::fromOpacity(std::vector<OpacityPoint> opacity,
                                               std::vector<ColourPoint> colour, double referenceLengthMm,
                                               const std::string& where) {
    if (!std::isfinite(referenceLengthMm) || !(referenceLengthMm > 0))
        throw InputError(where + ": expected a positive reference length in mm, found " +
                         std::to_string(referenceLengthMm));
    TransferFunction f = fromExtinction(std::move(opacity), std::move(colour), where);
    for (OpacityPoint& p : f.opacity_)
        p.opacity = std::min(p.opacity, 1.0);
    f.referenceLengthMm_ = referenceLengthMm;
    f.pointsAreExtinction_ = false;
    return f;
}

TransferFunction TransferFunction::fromExtinction(std::vector<OpacityPoint> extinction,
                                                  std::vector<ColourPoint> colour, const std::string& where) {
    for (OpacityPoint& p : extinction) {
        checkValue(p.value, "a point's value", where);
        checkFinite(p.opacity, "opacity", where);
        p.opacity = std::max(p.opacity, 0.0);
    }
    for (ColourPoint& p : colour) {
        checkValue(p.value, "a point's value", where);
        for (int c = 0; c < 3; ++c) {
            checkFinite(p.colour[c], "colour", where);
            p.colour[c] = std::clamp(p.colour[c], 0.0, 1.0);
        }
    }
    sortByValue(extinction);
    sortByValue(colour);
    TransferFunction f;
    f.opacity_ = std::move(extinction);
    f.colour_ = std::move(colour);
    f.pointsAreExtinction_ = true;
    for (const OpacityPoint& p : f.opacity_)
        f.kinks_.push_back(p.value);
    for (const ColourPoint& p : f.colour_)
        f.kinks_.push_back(p.value);
    std::sort(f.kinks_.begin(), f.kinks_.end());
    f.kinks_.erase(std::unique(f.kinks_.begin(), f.kinks_.end()), f.kinks_.end());
    return f;
}

void TransferFunction::setMaterials(std::vector<Material> materials, const std::string& where) {
    checkRanges(materials, kMaxMaterials, "material", where);
    materials_ = std::move(materials);
}

void TransferFunction::setTissues(std::vector<Tissue> tissues, const std::string& where) {
    checkRanges(tissues, kMaxTissues, "tissue", where);
    tissues_ = std::move(tissues);
}

bool TransferFunction::emits() const {
    return std::any_of(materials_.begin(), materials_.end(),
                       [](const Material& m) { return m.emission != glm::dvec3(0); });
}

double TransferFunction::extinction(double value) const {
    if (opacity_.empty())
        return 0;
    return extinctionOf(piecewiseLinear(opacity_, value, [](const OpacityPoint& p) { return p.opacity; }));
}

double TransferFunction::extinctionOf(double opacity) const {
    const double whole =
        pointsAreExtinction_ ? opacity : -std::log1p(-std::min(opacity, kMaxOpacity)) / referenceLengthMm_;
    return share_ * whole;
}

glm::dvec3 TransferFunction::colour(double value) const {
    if (colour_.empty())
        return glm::dvec3(1.0);
    return piecewiseLinear(colour_, value, [](const ColourPoint& p) { return p.colour; });
}

bool TransferTable::emptyOver(double lowest, double highest) const {
    const double last = static_cast<double>(entries.size() - 1);
    const double a = (lowest - firstValue) * static_cast<double>(entriesPerValue);
    const double b = (highest - firstValue) * static_cast<double>(entriesPerValue);
    const auto clampIndex = [&](double i) { return static_cast<std::size_t>(std::clamp(i, 0.0, last)); };
    const std::size_t first = clampIndex(std::floor(a) - 1), final = clampIndex(std::ceil(b) + 1);
    return nonZeroUpTo[final] == (first == 0 ? 0 : nonZeroUpTo[first - 1]);
}

bool TransferTable::isTransparent() const {
    return std::all_of(entries.begin(), entries.end(), [](const glm::vec4& e) { return e.a == 0; });
}

namespace {
/// Entries that are an isosurface's value or lie beside it.
std::vector<std::uint8_t> besideSurfaces(const TransferTable& table) {
    std::vector<std::uint8_t> marks(table.entries.size());
    const double last = static_cast<double>(marks.size() - 1);
    for (const SurfaceValue& surface : table.surfaces) {
        const double place = (surface.value - static_cast<double>(table.firstValue)) *
                             static_cast<double>(table.entriesPerValue);
        marks[static_cast<std::size_t>(std::clamp(std::floor(place), 0.0, last))] = 1;
        marks[static_cast<std::size_t>(std::clamp(std::ceil(place), 0.0, last))] = 1;
    }
    return marks;
}
void countShown(TransferTable& table) {
    const std::vector<std::uint8_t> marks = besideSurfaces(table);
    table.nonZeroUpTo.resize(marks.size());
    int shown = 0;
    for (std::size_t i = 0; i < marks.size(); ++i)
        table.nonZeroUpTo[i] = shown += table.entries[i].a != 0 || marks[i] != 0 ? 1 : 0;
}
} // namespace

TransferTable TransferTable::ofSurfaces() const {
    TransferTable table = *this;
    const std::vector<std::uint8_t> marks = besideSurfaces(*this);
    for (std::size_t i = 0; i < marks.size(); ++i)
        table.entries[i].a = marks[i];
    countShown(table);
    return table;
}

TransferTable TransferTable::withSurfacesAsSteps(double voxelMm) const {
    constexpr double kNearlyOpaque = 0.9, kDense = 0.5, kThin = 0.02; // extinctions per voxel
    TransferTable table = *this;
    for (std::size_t n = 0; n < surfaces.size(); ++n) {
        const SurfaceValue& surface = surfaces[n];
        const double first =
            (surface.value - static_cast<double>(firstValue)) * static_cast<double>(entriesPerValue);
        const double perVoxel = surface.opacity >= kNearlyOpaque ? kDense : kThin * surface.opacity;
        const float extinction = static_cast<float>(perVoxel / voxelMm);
        const glm::vec3 colour = surface.colour * (n % 2 == 0 ? 1.0f : 0.5f); // told from its neighbours
        for (std::size_t i = 0; i < table.entries.size(); ++i) {
            if (static_cast<double>(i) < first)
                continue;
            glm::vec4& e = table.entries[i];
            const float own = entries[i].a, sum = own + extinction;
            e = glm::vec4((glm::vec3(entries[i]) * own + colour * extinction) / sum, std::max(sum, e.a));
        }
    }
    countShown(table);
    return table;
}

TransferTable makeTable(const TransferFunction& function, std::vector<SurfaceValue> surfaces) {
    const std::size_t kMinEntries = surfaces.empty() ? 256 : 4096;
    std::stable_sort(surfaces.begin(), surfaces.end(),
                     [](const SurfaceValue& a, const SurfaceValue& b) { return a.value < b.value; });
    const std::vector<double>& kinks = function.kinks();
    double first = kinks.empty() ? 0 : kinks.front(), last = kinks.empty() ? 1 : kinks.back();
    if (!surfaces.empty()) {
        first = kinks.empty() ? surfaces.front().value : std::min(first, surfaces.front().value);
        last = kinks.empty() ? surfaces.back().value : std::max(last, surfaces.back().value);
        // Values beyond the table read its end entries, which must not be an isosurface's.
        const double beyond = std::max((last - first) / 64, 0.5);
        first -= first == surfaces.front().value ? beyond : 0;
        last += last == surfaces.back().value ? beyond : 0;
    }
    // Readers have scale and offset in float. A narrower table would make the scale infinite or cancel the
    // offset. A single value, which is a constant or a step with both sides, also gets a width.
    const double least =
        std::max(last > first ? 1e-25 : 1.0, 1e-6 * std::max(std::abs(first), std::abs(last)));
    if (const double lacking = least - (last - first); lacking > 0) {
        first -= 0.5 * lacking;
        last += 0.5 * lacking;
    }
    // The margin added to a range may exceed the range of floats.
    first = std::max(first, -kLargestValue);
    last = std::min(last, kLargestValue);
    double closest = last - first;
    for (std::size_t i = 1; i < kinks.size(); ++i)
        closest = std::min(closest, kinks[i] - kinks[i - 1]);
    std::size_t size = kMinEntries;
    while (size < static_cast<std::size_t>(TransferTable::kMaxEntries) &&
           static_cast<double>(size) * closest < 8 * (last - first))
        size *= 2;

    TransferTable table;
    table.entries.resize(size);
    const double pitch = (last - first) / static_cast<double>(size - 1);
    table.firstValue = static_cast<float>(first);
    table.entriesPerValue = static_cast<float>(1 / pitch);
    double highest = 0;
    for (std::size_t i = 0; i < size; ++i) {
        // The first entry is the limit from the left. Otherwise values below a step at the first point would
        // read the value above it.
        const double value =
            i == 0 ? std::nextafter(first, first - 1) : first + pitch * static_cast<double>(i);
        const double extinction = function.extinction(value);
        table.entries[i] = glm::vec4(glm::vec3(function.colour(value)), static_cast<float>(extinction));
        highest = std::max(highest, extinction);
    }
    table.surfaces = std::move(surfaces);
    table.gradientOpacity = function.gradientOpacity();
    countShown(table);
    // Own error: four probes a bin, away from steps (bins that a duplicate point falls into or beside).
    std::vector<double> steps;
    const auto& points = function.opacityPoints();
    for (std::size_t i = 1; i < points.size(); ++i)
        if (points[i].value == points[i - 1].value)
            steps.push_back(points[i].value);
    double worst = 0;
    for (std::size_t i = 0; i + 1 < size; ++i) {
        for (const double f : {0.125, 0.375, 0.625, 0.875}) {
            const double value = first + pitch * (static_cast<double>(i) + f);
            const auto near = std::lower_bound(steps.begin(), steps.end(), value - pitch);
            if (near != steps.end() && *near <= value + pitch)
                continue;
            const double a = table.entries[i].a, b = table.entries[i + 1].a;
            worst = std::max(worst, std::abs(a + f * (b - a) - function.extinction(value)));
        }
    }
    table.relativeError = highest > 0 ? worst / highest : 0;
    return table;
}

} // namespace tessera
