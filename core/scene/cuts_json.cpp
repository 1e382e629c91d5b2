// core/scene/cuts_json.cpp: see cuts_json.h.
#include "core/scene/cuts_json.h"

#include "core/base/error.h"

#include <nlohmann/json.hpp>

namespace tessera {
namespace {

using nlohmann::json;
using Keys = std::vector<std::string>;

const Keys kKeepNames = {"inside", "outside"};  // in the order of Keep
const Keys kSpaceNames = {"patient", "voxels"}; // in the order of CropBox::Space

glm::dvec3 vector(const JsonValue& value) {
    const std::vector<double> n = value.numbers(3);
    return {n[0], n[1], n[2]};
}
json listOf(const glm::dvec3& v) {
    return {v.x, v.y, v.z};
}
Keep keepOf(const JsonValue& object) {
    return object.has("keep") && object.at("keep").oneOf(kKeepNames) == kKeepNames[1] ? Keep::outside
                                                                                      : Keep::inside;
}
json keepJson(Keep keep) {
    return kKeepNames[static_cast<std::size_t>(keep)];
}

CropBox parseBox(const JsonValue& value) {
    value.requireKeys(cropBoxKeys());
    CropBox box{vector(value.at("low")), vector(value.at("high")), CropBox::Space::patient, keepOf(value)};
    if (value.has("space") && value.at("space").oneOf(kSpaceNames) == kSpaceNames[1])
        box.space = CropBox::Space::voxels;
    checkBox(box, value.place());
    return box;
}

CutPlane parsePlane(const JsonValue& value) {
    value.requireKeys(cutPlaneKeys());
    const CutPlane plane{vector(value.at("point")), vector(value.at("normal")), keepOf(value)};
    checkPlane(plane, value.place());
    return plane;
}

Scissors parseScissors(const JsonValue& value) {
    value.requireKeys(scissorsKeys());
    value.at("camera").requireKeys(freeCameraKeys());
    Scissors scissors{parseFreeCamera(value.at("camera")), 1, {}, keepOf(value)};
    if (value.has("aspect"))
        scissors.aspect = value.at("aspect").number();
    for (const JsonValue& point : value.at("outline").items(Cuts::kMostPoints, "points")) {
        const std::vector<double> n = point.numbers(2);
        scissors.outline.emplace_back(n[0], n[1]);
    }
    checkScissors(scissors, value.place());
    return scissors;
}

template <typename Cut, typename Parse>
void parseAll(const JsonValue& object, const char* key, std::vector<Cut>& out, const Parse& parse) {
    if (!object.has(key))
        return;
    for (const JsonValue& item : object.at(key).items(Cuts::kMostOfAKind, key))
        out.push_back(parse(item));
}

} // namespace

Cuts parseCuts(const JsonValue& value) {
    value.requireKeys(cutsKeys());
    Cuts cuts;
    parseAll(value, "boxes", cuts.boxes, parseBox);
    parseAll(value, "planes", cuts.planes, parsePlane);
    parseAll(value, "scissors", cuts.scissors, parseScissors);
    return cuts;
}

json cutsJson(const Cuts& cuts) {
    if (!cuts.any())
        return {};
    json out = json::object();
    for (const CropBox& box : cuts.boxes) {
        json one = {{"low", listOf(box.low)}, {"high", listOf(box.high)}, {"keep", keepJson(box.keep)}};
        if (box.space == CropBox::Space::voxels)
            one["space"] = kSpaceNames[1];
        out["boxes"].push_back(std::move(one));
    }
    for (const CutPlane& plane : cuts.planes)
        out["planes"].push_back({{"point", listOf(plane.point)},
                                 {"normal", listOf(plane.normal)},
                                 {"keep", keepJson(plane.keep)}});
    for (const Scissors& scissors : cuts.scissors) {
        json outline = json::array();
        for (const glm::dvec2& p : scissors.outline)
            outline.push_back({p.x, p.y});
        out["scissors"].push_back({{"camera", freeCameraJson(scissors.camera)},
                                   {"aspect", scissors.aspect},
                                   {"outline", std::move(outline)},
                                   {"keep", keepJson(scissors.keep)}});
    }
    return out;
}

Camera parseFreeCamera(const JsonValue& value) {
    Camera camera;
    camera.projection = value.has("parallelProjection") && value.at("parallelProjection").boolean()
                            ? Projection::parallel
                            : Projection::perspective;
    camera.position = vector(value.at("position"));
    camera.focalPoint = vector(value.at("focalPoint"));
    if (value.has("viewUp"))
        camera.viewUp = vector(value.at("viewUp"));
    if (value.has("viewAngle"))
        camera.viewAngle = value.at("viewAngle").number();
    if (value.has("parallelScale"))
        camera.parallelScale = value.at("parallelScale").number();
    camera.validate(value.place());
    return camera;
}

json freeCameraJson(const Camera& camera) {
    return {{"position", listOf(camera.position)},
            {"focalPoint", listOf(camera.focalPoint)},
            {"viewUp", listOf(camera.viewUp)},
            {"viewAngle", camera.viewAngle},
            {"parallelProjection", camera.projection == Projection::parallel},
            {"parallelScale", camera.parallelScale}};
}

const Keys& freeCameraKeys() {
    static const Keys keys = {"position",  "focalPoint",         "viewUp",
                              "viewAngle", "parallelProjection", "parallelScale"};
    return keys;
}
const Keys& cutsKeys() {
    static const Keys keys = {"boxes", "planes", "scissors"};
    return keys;
}
const Keys& cropBoxKeys() {
    static const Keys keys = {"low", "high", "space", "keep"};
    return keys;
}
const Keys& cutPlaneKeys() {
    static const Keys keys = {"point", "normal", "keep"};
    return keys;
}
const Keys& scissorsKeys() {
    static const Keys keys = {"camera", "aspect", "outline", "keep"};
    return keys;
}

} // namespace tessera
