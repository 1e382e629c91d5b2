// viewer/window/function_edits.cpp: see function_edits.h.
#include "viewer/window/function_edits.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tessera {
namespace {

TransferFunction made(std::vector<OpacityPoint> opacity, std::vector<ColourPoint> colour,
                      const TransferFunction& like, std::vector<Material> materials) {
    TransferFunction function =
        TransferFunction::fromOpacity(std::move(opacity), std::move(colour), like.referenceLengthMm());
    function.setMaterials(std::move(materials));
    function.setTissues(like.tissues());
    function.setGradientOpacity(like.gradientOpacity());
    return function;
}

} // namespace

TransferFunction shiftedAndStretched(const TransferFunction& f, double shift, double factor) {
    std::vector<OpacityPoint> opacity = f.opacityPoints();
    std::vector<ColourPoint> colour = f.colourPoints();
    std::vector<Material> materials = f.materials();
    if (opacity.empty())
        return f;
    const double middle = (opacity.front().value + opacity.back().value) / 2;
    const auto moved = [&](double value) { return middle + shift + factor * (value - middle); };
    for (OpacityPoint& p : opacity)
        p.value = moved(p.value);
    for (ColourPoint& p : colour)
        p.value = moved(p.value);
    for (Material& m : materials)
        m.from = moved(m.from), m.to = moved(m.to);
    std::vector<Tissue> tissues = f.tissues();
    for (Tissue& t : tissues)
        t.from = moved(t.from), t.to = moved(t.to);
    TransferFunction function = made(std::move(opacity), std::move(colour), f, std::move(materials));
    function.setTissues(std::move(tissues));
    return function;
}

double halfOpaqueValue(const TransferFunction& f, double lowest, double highest) {
    const std::vector<OpacityPoint>& points = f.opacityPoints();
    double most = 0;
    for (const OpacityPoint& p : points)
        most = std::max(most, p.opacity);
    double value = (lowest + highest) / 2;
    for (std::size_t i = 0; i < points.size() && most > 0; ++i)
        if (points[i].opacity >= most / 2) {
            value = points[i].value;
            if (i > 0 && points[i].opacity > points[i - 1].opacity)
                value -= (points[i].value - points[i - 1].value) * (points[i].opacity - most / 2) /
                         (points[i].opacity - points[i - 1].opacity);
            break;
        }
    return std::clamp(value, lowest, highest);
}

TransferFunction withPointAt(const TransferFunction& f, std::size_t point, double value, double opacity) {
    std::vector<OpacityPoint> points = f.opacityPoints();
    constexpr double kNone = std::numeric_limits<double>::infinity();
    const double low = point > 0 ? points[point - 1].value : -kNone;
    const double high = point + 1 < points.size() ? points[point + 1].value : kNone;
    points[point] = {std::clamp(value, low, high), std::clamp(opacity, 0.0, 1.0)};
    return made(std::move(points), f.colourPoints(), f, f.materials());
}

TransferFunction withNewPoint(const TransferFunction& f, double value, double opacity, std::size_t& index) {
    std::vector<OpacityPoint> points = f.opacityPoints();
    const auto at = std::upper_bound(points.begin(), points.end(), value,
                                     [](double v, const OpacityPoint& p) { return v < p.value; });
    index = static_cast<std::size_t>(at - points.begin());
    points.insert(at, {value, std::clamp(opacity, 0.0, 1.0)});
    return made(std::move(points), f.colourPoints(), f, f.materials());
}

TransferFunction withoutPoint(const TransferFunction& f, std::size_t point) {
    std::vector<OpacityPoint> points = f.opacityPoints();
    if (points.size() > 1)
        points.erase(points.begin() + static_cast<std::ptrdiff_t>(point));
    return made(std::move(points), f.colourPoints(), f, f.materials());
}

TransferFunction withColourAt(const TransferFunction& f, double value, const glm::dvec3& colour,
                              double reach) {
    std::vector<ColourPoint> points = f.colourPoints();
    const auto nearest = std::min_element(points.begin(), points.end(), [&](const auto& a, const auto& b) {
        return std::abs(a.value - value) < std::abs(b.value - value);
    });
    if (nearest != points.end() && std::abs(nearest->value - value) <= reach)
        nearest->colour = colour;
    else
        points.push_back({value, colour});
    return made(f.opacityPoints(), std::move(points), f, f.materials());
}

} // namespace tessera
