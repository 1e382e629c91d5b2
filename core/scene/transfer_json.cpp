// core/scene/transfer_json.cpp: see transfer_json.h.
#include "core/scene/transfer_json.h"

#include <nlohmann/json.hpp>

namespace tessera {
namespace {
constexpr double kMinUnitMm = 1e-6, kMaxUnitMm = 1e6; // from microscopes to mountains
}

const std::vector<std::string>& transferKeys() {
    static const std::vector<std::string> keys = {"scalarOpacityUnitDistance", "scalarOpacity",
                                                  "rgbTransferFunction",       "materials",
                                                  "gradientOpacity",           "gradientOpacityUnit"};
    return keys;
}

const std::vector<std::string>& materialKeys() {
    static const std::vector<std::string> keys = {
        "from", "to", "ambient", "diffuse", "specular", "specularPower", "emission"};
    return keys;
}

namespace {

/// All keys but emission are needed: what a scene's shading says is for values without a material.
Material parseMaterial(const JsonValue& value) {
    value.requireKeys(materialKeys());
    Material m;
    m.from = value.at("from").number();
    m.to = value.at("to").number();
    m.ambient = value.at("ambient").number(0, 1);
    m.diffuse = value.at("diffuse").number(0, 1);
    m.specular = value.at("specular").number(0, 1);
    m.specularPower = value.at("specularPower").integer(1, 1024);
    if (value.has("emission")) {
        const JsonValue emission = value.at("emission");
        if (!emission.isList() || emission.items().size() != 3)
            emission.refuse("[r, g, b], linear");
        for (int c = 0; c < 3; ++c)
            m.emission[c] = emission.items()[static_cast<std::size_t>(c)].number(0, 1);
    }
    return m;
}

nlohmann::json materialJson(const Material& m) {
    nlohmann::json out = {{"from", m.from},         {"to", m.to},
                          {"ambient", m.ambient},   {"diffuse", m.diffuse},
                          {"specular", m.specular}, {"specularPower", m.specularPower}};
    if (m.emission != glm::dvec3(0))
        out["emission"] = {m.emission.r, m.emission.g, m.emission.b};
    return out;
}

const std::vector<std::string> kGradientUnits = {"mm", "voxel"}; // in the order of GradientOpacity::Per

GradientOpacity parseGradientOpacity(const JsonValue& value, const std::string& unit) {
    std::vector<GradientPoint> points;
    for (const JsonValue& item : value.items(GradientOpacity::kMostPoints, "points")) {
        const std::vector<double> point = item.numbers(2);
        if (!(point[0] >= 0))
            item.refuse("[length, factor], a length of 0 or more");
        points.push_back({point[0], point[1]});
    }
    return GradientOpacity::fromPoints(
        std::move(points), unit == kGradientUnits[0] ? GradientOpacity::Per::mm : GradientOpacity::Per::voxel,
        value.place());
}

} // namespace

TransferFunction parseTransfer(const JsonValue& value) {
    const double unitMm = value.has("scalarOpacityUnitDistance")
                              ? value.at("scalarOpacityUnitDistance").number(kMinUnitMm, kMaxUnitMm)
                              : 1;
    std::vector<OpacityPoint> opacity;
    for (const JsonValue& item : value.at("scalarOpacity").items()) {
        const std::vector<double> point = item.numbers(2);
        opacity.push_back({point[0], point[1]});
    }
    std::vector<ColourPoint> colour;
    if (value.has("rgbTransferFunction"))
        for (const JsonValue& item : value.at("rgbTransferFunction").items()) {
            const std::vector<double> point = item.numbers(4);
            colour.push_back({point[0], {point[1], point[2], point[3]}});
        }
    TransferFunction function =
        TransferFunction::fromOpacity(std::move(opacity), std::move(colour), unitMm, value.place());
    if (value.has("materials")) {
        std::vector<Material> materials;
        for (const JsonValue& item :
             value.at("materials").items(TransferFunction::kMaxMaterials, "materials"))
            materials.push_back(parseMaterial(item));
        function.setMaterials(std::move(materials), value.at("materials").place());
    }
    const std::string unit = value.has("gradientOpacityUnit")
                                 ? value.at("gradientOpacityUnit").oneOf(kGradientUnits)
                                 : kGradientUnits[0];
    if (value.has("gradientOpacity"))
        function.setGradientOpacity(parseGradientOpacity(value.at("gradientOpacity"), unit));
    return function;
}

nlohmann::json transferJson(const TransferFunction& function) {
    nlohmann::json opacity = nlohmann::json::array(), colour = nlohmann::json::array();
    for (const OpacityPoint& p : function.opacityPoints())
        opacity.push_back({p.value, p.opacity});
    for (const ColourPoint& p : function.colourPoints())
        colour.push_back({p.value, p.colour.r, p.colour.g, p.colour.b});
    nlohmann::json out = {{"scalarOpacityUnitDistance", function.referenceLengthMm()},
                          {"scalarOpacity", std::move(opacity)},
                          {"rgbTransferFunction", std::move(colour)}};
    for (const Material& m : function.materials())
        out["materials"].push_back(materialJson(m));
    for (const GradientPoint& p : function.gradientOpacity().points())
        out["gradientOpacity"].push_back({p.length, p.factor});
    if (function.gradientOpacity().per() == GradientOpacity::Per::voxel)
        out["gradientOpacityUnit"] = kGradientUnits[1];
    return out;
}

} // namespace tessera
