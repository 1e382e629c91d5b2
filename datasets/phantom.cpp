// datasets/phantom.cpp: the phantoms by name, and their slices on several threads. Memory is the caller's
// slab and the phantom's own shapes; nothing grows with the volume.
#include "datasets/phantom.h"

#include "core/base/error.h"
#include "core/base/names.h"
#include "core/base/threads.h"
#include "datasets/colon_shape.h"
#include "datasets/slice_generator.h"
#include "datasets/torso_parts.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

namespace tessera {
namespace {

class PhantomSource final : public SlabSource {
  public:
    PhantomSource(std::string name, std::unique_ptr<SliceGenerator> slices, int threads)
        : name_(std::move(name)), slices_(std::move(slices)), threads_(threads) {}

    const VolumeInfo& info() const override { return slices_->info(); }

    void readSlices(int count, std::span<std::byte> out) override {
        const glm::ivec3 n = info().extentVoxels;
        if (count < 0 || count > n.z - next_)
            throw badFile("phantom " + name_, std::to_string(n.z - next_) + " slices left at most",
                          "a request for " + std::to_string(count));
        const std::size_t sliceBytes =
            static_cast<std::size_t>(n.x) * static_cast<std::size_t>(n.y) * bytesPerValue(info().type);
        TESSERA_CHECK(out.size() == sliceBytes * static_cast<std::size_t>(count));
        parallelFor(static_cast<std::size_t>(count), threads_, [&](std::size_t i) {
            slices_->slice(next_ + static_cast<int>(i), out.subspan(i * sliceBytes, sliceBytes));
        });
        next_ += count;
    }

    std::string describe() const override {
        const glm::ivec3 n = info().extentVoxels;
        return "phantom " + name_ + ", " + std::to_string(n.x) + "x" + std::to_string(n.y) + "x" +
               std::to_string(n.z);
    }

  private:
    std::string name_;
    std::unique_ptr<SliceGenerator> slices_;
    int threads_;
    int next_ = 0; // first slice not read yet
};

} // namespace

VolumeInfo centredVolume(const std::string& name, const glm::ivec3& extentVoxels, const glm::dvec3& bodyMm,
                         ValueType type) {
    const glm::dvec3 spacing = bodyMm / glm::dvec3(extentVoxels);
    VolumeInfo info;
    info.extentVoxels = extentVoxels;
    info.type = type;
    info.patientFromVoxel = patientFromVoxelOf(0.5 * spacing - 0.5 * bodyMm, {spacing.x, 0, 0},
                                               {0, spacing.y, 0}, {0, 0, spacing.z});
    info.validate("phantom " + name);
    return info;
}

std::vector<std::string> phantomNames() {
    return {"torso", "torso-collapsed", "marschner-lobb", "sphere", "ramp", "checkerboard"};
}

bool isTorso(const std::string& name) {
    return name == "torso" || name == "torso-collapsed";
}

std::unique_ptr<SlabSource> makePhantom(const std::string& name, const glm::ivec3& extentVoxels,
                                        int threads) {
    const std::vector<std::string> names = phantomNames();
    if (std::find(names.begin(), names.end(), name) == names.end())
        throw badFile("phantom", "one of " + joinNames(names),
                      "'" + name + "' (did you mean '" + nearestName(name, names) + "'?)");
    auto slices =
        isTorso(name) ? makeTorso(extentVoxels, name == "torso-collapsed") : makeAnalytic(name, extentVoxels);
    return std::make_unique<PhantomSource>(name, std::move(slices), threads);
}

// The curves that the torso's tubes follow, as lists of points and as JSON. See phantom.h.

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
