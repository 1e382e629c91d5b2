// viewer/presets/preset_files.cpp: see preset_files.h.
#include "viewer/presets/preset_files.h"

#include "core/image/colour.h"
#include "viewer/presets/foreign_preset.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/common.hpp>
#include <limits>
#include <vtkColorTransferFunction.h>
#include <vtkNew.h>
#include <vtkPiecewiseFunction.h>

namespace tessera {
namespace {

constexpr int kDeepest = 12;     // bisections of an interval between two points
constexpr double kBeside = 1e-7; // fraction of an interval: offset at which the limits at its ends are taken
constexpr double kSame = 1e-5;   // tolerance between a point's value and the curve's limit there
constexpr double kSteepest = 1e-9; // width of a step, relative to its position

/// sRGB from linear light, and back.
glm::dvec3 shown(const glm::dvec3& linear) {
    return {srgbFromLinear(linear.r), srgbFromLinear(linear.g), srgbFromLinear(linear.b)};
}
glm::dvec3 linearOf(const glm::dvec3& screen) {
    return {linearFromSrgb(screen.r), linearFromSrgb(screen.g), linearFromSrgb(screen.b)};
}

/// Divides a curve between two places into linear pieces. `add` gets every place after `a` except `b`.
/// @param isStraight  whether the curve between two places is linear within the tolerance
void inStraightPieces(double a, double b, int depth,
                      const std::function<bool(double from, double to, double at)>& isStraight,
                      const std::function<void(double at)>& add) {
    const double middle = 0.5 * (a + b);
    if (depth == kDeepest || (isStraight(a, b, middle) && isStraight(a, b, 0.5 * (a + middle)) &&
                              isStraight(a, b, 0.5 * (middle + b))))
        return;
    inStraightPieces(a, middle, depth + 1, isStraight, add);
    add(middle);
    inStraightPieces(middle, b, depth + 1, isStraight, add);
}

template <typename Value> Value between(const Value& left, const Value& right, double share) {
    return (1 - share) * left + share * right;
}
double largest(double x) {
    return std::abs(x);
}
double largest(const glm::dvec3& x) {
    return std::max({std::abs(x.r), std::abs(x.g), std::abs(x.b)});
}

/// The points of linear pieces of a curve. The curve is `at` within its intervals; its points have their own
/// values.
/// @param own  the point's own value
/// @param error  of the linear piece against the curve
template <typename Point, typename Value>
std::vector<std::pair<double, Value>>
straightened(const std::vector<Point>& points, const std::function<Value(double)>& at,
             const std::function<Value(const Point&)>& own, const std::function<double(Value, Value)>& error,
             double mostError) {
    std::vector<std::pair<double, Value>> out;
    if (points.empty())
        return out;
    out.push_back({points.front().x, own(points.front())});
    for (std::size_t i = 0; i + 1 < points.size(); ++i) {
        const Point &left = points[i], &right = points[i + 1];
        const double width = right.x - left.x;
        if (!(width > 0)) { // a step
            out.push_back({right.x, own(right)});
            continue;
        }
        const auto limit = [&](const Point& point, double inside) {
            const Value found = at(inside);
            return largest(found - own(point)) < kSame ? own(point) : found;
        };
        const Value first = limit(left, left.x + kBeside * width),
                    last = limit(right, right.x - kBeside * width);
        if (largest(first - own(left)) >= kSame)
            out.push_back({left.x, first});
        const auto valueAt = [&](double x) { return x <= left.x ? first : x >= right.x ? last : at(x); };
        inStraightPieces(
            left.x, right.x, 0,
            [&](double a, double b, double x) {
                return error(between(valueAt(a), valueAt(b), (x - a) / (b - a)), valueAt(x)) <= mostError;
            },
            [&](double x) {
                out.push_back({x, at(x)});
            });
        out.push_back({right.x, last});
        if (largest(last - own(right)) >= kSame)
            out.push_back({right.x, own(right)});
    }
    return out;
}

/// Moves points at the same position apart, because VTK keeps only the last of them.
template <typename Point> void setApart(std::vector<Point>& points) {
    for (std::size_t i = points.size(); i-- > 1;)
        if (points[i - 1].x >= points[i].x)
            points[i - 1].x = points[i].x - kSteepest * std::max(1.0, std::abs(points[i].x));
}

template <typename Point> void sortByPlace(std::vector<Point>& points) {
    std::stable_sort(points.begin(), points.end(), [](const Point& a, const Point& b) { return a.x < b.x; });
}

} // namespace

std::vector<OpacityPoint> opacityPoints(std::vector<VtkPoint> points, double mostError) {
    sortByPlace(points);
    vtkNew<vtkPiecewiseFunction> curve;
    curve->AllowDuplicateScalarsOn();
    for (VtkPoint& p : points) {
        p.y = std::clamp(p.y, 0.0, 1.0);
        curve->AddPoint(p.x, p.y, p.midpoint, p.sharpness);
    }
    const auto at = [&](double x) { return curve->GetValue(x); };
    const auto own = [](const VtkPoint& p) { return p.y; };
    const auto error = [](double a, double b) { return std::abs(a - b); };
    std::vector<OpacityPoint> out;
    for (const auto& [x, y] : straightened<VtkPoint, double>(points, at, own, error, mostError))
        out.push_back({x, y});
    return out;
}

double thinned(std::vector<OpacityPoint>& points, std::size_t most) {
    const std::vector<OpacityPoint> all = points;
    const auto errorWithout = [&](std::size_t i) { // largest error of the points between the two that stay
        const OpacityPoint &left = points[i - 1], &right = points[i + 1];
        double worst = 0;
        for (const OpacityPoint& p : all)
            if (p.value > left.value && p.value < right.value)
                worst =
                    std::max(worst, std::abs(between(left.opacity, right.opacity,
                                                     (p.value - left.value) / (right.value - left.value)) -
                                             p.opacity));
            else if (left.value == right.value && p.value == left.value)
                worst = std::max({worst, p.opacity - std::max(left.opacity, right.opacity),
                                  std::min(left.opacity, right.opacity) - p.opacity});
        return worst;
    };
    double worst = 0;
    while (points.size() > std::max<std::size_t>(most, 2)) {
        std::size_t least = 1;
        double error = std::numeric_limits<double>::infinity();
        for (std::size_t i = 1; i + 1 < points.size(); ++i)
            if (const double mine = errorWithout(i); mine < error)
                error = mine, least = i;
        points.erase(points.begin() + static_cast<std::ptrdiff_t>(least));
        worst = std::max(worst, error);
    }
    return worst;
}

std::vector<ColourPoint> colourPoints(std::vector<VtkColour> points, ColourSpace space, bool wrapsHue) {
    sortByPlace(points);
    vtkNew<vtkColorTransferFunction> map;
    map->AllowDuplicateScalarsOn();
    switch (space) {
    case ColourSpace::rgb:
        map->SetColorSpaceToRGB();
        break;
    case ColourSpace::hsv:
        map->SetColorSpaceToHSV();
        break;
    case ColourSpace::lab:
        map->SetColorSpaceToLab();
        break;
    case ColourSpace::diverging:
        map->SetColorSpaceToDiverging();
        break;
    case ColourSpace::labCiede2000:
        map->SetColorSpaceToLabCIEDE2000();
        break;
    case ColourSpace::step:
        map->SetColorSpaceToStep();
        break;
    }
    map->SetHSVWrap(wrapsHue);
    for (VtkColour& p : points) {
        p.colour = glm::clamp(p.colour, glm::dvec3(0), glm::dvec3(1));
        map->AddRGBPoint(p.x, p.colour.r, p.colour.g, p.colour.b, p.midpoint, p.sharpness);
    }
    const auto at = [&](double x) {
        glm::dvec3 screen(0);
        map->GetColor(x, &screen.x);
        return linearOf(glm::clamp(screen, glm::dvec3(0), glm::dvec3(1)));
    };
    const auto own = [](const VtkColour& p) { return linearOf(p.colour); };
    const auto error = [](const glm::dvec3& a, const glm::dvec3& b) { return largest(shown(a) - shown(b)); };
    std::vector<ColourPoint> out;
    for (const auto& [x, colour] : straightened<VtkColour, glm::dvec3>(points, at, own, error, kColourError))
        out.push_back({x, colour});
    return out;
}

std::vector<VtkColour> screenColours(const std::vector<ColourPoint>& points) {
    std::vector<VtkColour> out;
    for (std::size_t i = 0; i < points.size(); ++i) {
        out.push_back({points[i].value, shown(points[i].colour)});
        if (i + 1 == points.size() || !(points[i + 1].value > points[i].value))
            continue;
        const ColourPoint &left = points[i], &right = points[i + 1];
        const auto at = [&](double x) {
            return shown(between(left.colour, right.colour, (x - left.value) / (right.value - left.value)));
        };
        inStraightPieces(
            left.value, right.value, 0,
            [&](double a, double b, double x) {
                return largest(between(at(a), at(b), (x - a) / (b - a)) - at(x)) <= kColourError;
            },
            [&](double x) {
                out.push_back({x, at(x)});
            });
    }
    setApart(out);
    return out;
}

std::vector<VtkPoint> distinct(const std::vector<OpacityPoint>& points) {
    std::vector<VtkPoint> out;
    for (const OpacityPoint& p : points)
        out.push_back({p.value, p.opacity});
    setApart(out);
    return out;
}

} // namespace tessera
