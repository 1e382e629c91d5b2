// core/scene/transfer_fields.cpp: the keys of a transfer function: see scene_fields.h.
#include "core/scene/scene_fields.h"

#include <glm/vec3.hpp>

namespace tessera {

template <> const NameTable<GradientOpacity::Per>& namesOf() {
    static const NameTable<GradientOpacity::Per> names{
        {{GradientOpacity::Per::mm, "mm"}, {GradientOpacity::Per::voxel, "voxel"}}};
    return names;
}

namespace {

constexpr double kMinUnitMm = 1e-6, kMaxUnitMm = 1e6; // from microscopes to mountains

/// All keys but emission are needed: what a scene's shading says is for values without a material.
const Fields<Material>& materialFields() {
    static const Fields<Material> fields = [] {
        Fields<Material> f("material");
        f.add("from", &Material::from, anyNumber(), "The first value, physical units.").required();
        f.add("to", &Material::to, anyNumber(), "Where it ends, itself not with it.").required();
        f.add("ambient", &Material::ambient, numberIn(0, 1), "Light from all sides.").required();
        f.add("diffuse", &Material::diffuse, numberIn(0, 1), "Light that is scattered.").required();
        f.add("specular", &Material::specular, numberIn(0, 1), "Highlights.").required();
        f.add("specularPower", &Material::specularPower, wholeIn(1, 1024),
              "The higher, the smaller they are.")
            .required();
        f.add("emission", &Material::emission, colourKind(),
              "Light that it sends, red, green and blue, linear, beside what it reflects.")
            .unlessDefault();
        return f;
    }();
    return fields;
}

Kind<ColourPoint> colourPointKind() {
    return numbersAt<ColourPoint>(
        &ColourPoint::value, [](auto& p) -> auto& { return p.colour.r; },
        [](auto& p) -> auto& { return p.colour.g; }, [](auto& p) -> auto& { return p.colour.b; });
}

Kind<GradientPoint> gradientPointKind() {
    return numbersAt<GradientPoint>(&GradientPoint::length, &GradientPoint::factor)
        .checked([](const GradientPoint& point, const JsonValue& value) {
            if (!(point.length >= 0))
                value.refuse("[length, factor], a length of 0 or more");
        });
}

TransferFunction functionOf(TransferKeys keys, const JsonValue& whole) {
    TransferFunction function = TransferFunction::fromOpacity(std::move(keys.opacity), std::move(keys.colour),
                                                              keys.unitMm, whole.place());
    if (whole.has("materials"))
        function.setMaterials(std::move(keys.materials), whole.at("materials").place());
    if (whole.has("gradientOpacity"))
        function.setGradientOpacity(GradientOpacity::fromPoints(std::move(keys.gradient), keys.gradientPer,
                                                                whole.at("gradientOpacity").place()));
    return function;
}

} // namespace

const Fields<TransferKeys>& transferFields() {
    static const Fields<TransferKeys> fields = [] {
        Fields<TransferKeys> f(
            "transferFunction",
            "Linear between points, constant beyond the outermost. Two points at one value "
            "are a step; the second holds at the value itself.");
        f.add("scalarOpacityUnitDistance", &TransferKeys::unitMm, numberIn(kMinUnitMm, kMaxUnitMm),
              "Path length in mm over which an opacity is reached.");
        f.add("scalarOpacity", &TransferKeys::opacity,
              listOf(numbersAt<OpacityPoint>(&OpacityPoint::value, &OpacityPoint::opacity)),
              "[value, opacity]; opacity is clamped to 0..1.")
            .required();
        f.add("rgbTransferFunction", &TransferKeys::colour, listOf(colourPointKind()),
              "[value, r, g, b]; linear light, clamped to 0..1. None: white.");
        f.add("materials", &TransferKeys::materials,
              listOf(objectOf(materialFields()), TransferFunction::kMaxMaterials, "materials"),
              "How what has a value answers to light; values in none of these ranges take what shading says. "
              "Ranges share no value.")
            .unlessDefault();
        f.add("gradientOpacity", &TransferKeys::gradient,
              listOf(gradientPointKind(), GradientOpacity::kMostPoints, "points"),
              "[length, factor]: a factor, clamped to 0..1, on the extinction, by the length of the field's "
              "gradient; linear between points, constant beyond the outermost, and two points at one length "
              "are a step. None: 1.")
            .unlessDefault();
        f.add("gradientOpacityUnit", &TransferKeys::gradientPer, named<GradientOpacity::Per>(),
              "What lengths of gradients are told by, in physical units: mm, or voxel, the mean of the "
              "volume's three spacings, as 3D Slicer and VTK have it.")
            .unlessDefault();
        return f;
    }();
    return fields;
}

TransferFunction parseTransfer(const JsonValue& whole) {
    TransferKeys keys;
    transferFields().readKnown(whole, keys);
    return functionOf(std::move(keys), whole);
}

nlohmann::json transferJson(const TransferFunction& function) {
    return transferFields().write({function.referenceLengthMm(), function.opacityPoints(),
                                   function.colourPoints(), function.materials(),
                                   function.gradientOpacity().points(), function.gradientOpacity().per()});
}

Kind<TransferChoice> transferKind() {
    return {[](const JsonValue& value) -> TransferChoice {
                if (value.isText())
                    return value.text();
                if (!value.isObject())
                    value.refuse("the name of a preset or an object");
                value.requireKeys(transferFields().keys());
                return parseTransfer(value);
            },
            [](const TransferChoice& choice) {
                const auto* const name = std::get_if<std::string>(&choice);
                return name ? nlohmann::json(*name) : transferJson(std::get<TransferFunction>(choice));
            },
            [](Schema& parts) {
                return Schema{{"oneOf", {{{"type", "string"}}, transferFields().reference(parts)}}};
            }};
}

} // namespace tessera
