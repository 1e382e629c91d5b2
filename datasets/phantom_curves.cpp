// datasets/phantom_curves.cpp: the curves that the torso's tubes follow, as lists of points and as JSON. See
// phantom.h.
#include "core/base/error.h"
#include "datasets/colon_shape.h"
#include "datasets/phantom.h"
#include "datasets/torso_parts.h"

#include <nlohmann/json.hpp>

namespace tessera {
namespace {

using nlohmann::json;

PhantomCurve curveOf(const std::vector<Knot>& knots) {
    PhantomCurve curve;
    for (const Knot& knot : knots) {
        curve.pointsMm.emplace_back(knot.at);
        curve.radiiMm.push_back(static_cast<double>(knot.radiusMm));
    }
    return curve;
}

json pointJson(const glm::dvec3& p) {
    return {p.x, p.y, p.z};
}

json curveJson(const PhantomCurve& curve) {
    json points = json::array();
    for (const glm::dvec3& p : curve.pointsMm)
        points.push_back(pointJson(p));
    return {{"points", points}, {"radii", curve.radiiMm}};
}

} // namespace

std::vector<PhantomCurve> torsoAirways() {
    std::vector<PhantomCurve> curves;
    for (const AirwayTube& tube : torsoAirwayTubes(*torsoInnerWall())) {
        curves.push_back(curveOf(tube.knots.size() > 2 ? curveThrough(tube.knots, 4) : tube.knots));
        curves.back().parent = tube.parent;
        curves.back().generation = tube.generation;
    }
    return curves;
}

PhantomCurve torsoAorta() {
    return curveOf(curveThrough(aortaCourse(), 4));
}

PhantomCurve torsoColon() {
    PhantomCurve curve;
    curve.pointsMm = torsoColonCentreline();
    for (std::size_t i = 0; i < curve.pointsMm.size(); ++i)
        curve.radiiMm.push_back(
            torsoColonRadiusMm(static_cast<double>(i) / static_cast<double>(curve.pointsMm.size() - 1)));
    return curve;
}

std::string phantomCurvesJson(const std::string& name) {
    if (!isTorso(name))
        throw badFile("--curves", "a torso, which has curves", "phantom " + name);
    json airways = json::array(), polyps = json::array();
    for (const PhantomCurve& curve : torsoAirways()) {
        airways.push_back(curveJson(curve));
        airways.back()["parent"] = curve.parent;
        airways.back()["generation"] = curve.generation;
    }
    for (const ColonPolyp& polyp : torsoColonPolyps())
        polyps.push_back({{"centre", pointJson(polyp.centreMm)},
                          {"arcFraction", polyp.arcFraction},
                          {"diameter", polyp.diameterMm},
                          {"pedunculated", polyp.pedunculated}});
    json colon = curveJson(torsoColon());
    colon["polyps"] = polyps;
    if (name == "torso-collapsed")
        colon["collapsed"] = {kCollapsedFrom, kCollapsedTo};
    const json curves = {{"phantom", name},
                         {"unit", "mm"},
                         {"colon", colon},
                         {"airways", airways},
                         {"aorta", curveJson(torsoAorta())}};
    return curves.dump(1) + "\n";
}

} // namespace tessera
