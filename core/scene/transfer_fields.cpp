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
        f.add("from", &Material::from, anyNumber(), "First value, in physical units.").required();
        f.add("to", &Material::to, anyNumber(), "End of the range, itself excluded.").required();
        f.add("ambient", &Material::ambient, numberIn(0, 1), "Share of ambient light.").required();
        f.add("diffuse", &Material::diffuse, numberIn(0, 1), "Share of diffuse light.").required();
        f.add("specular", &Material::specular, numberIn(0, 1), "Share of specular light.").required();
        f.add("specularPower", &Material::specularPower, wholeIn(1, 1024),
              "Exponent of the highlights: the higher, the smaller they are.")
            .required();
        f.add("emission", &Material::emission, colourKind(),
              "Emitted light: red, green and blue, linear; added to what is reflected.")
            .unlessDefault();
        return f;
    }();
    return fields;
}

const Fields<Tissue>& tissueFields() {
    static const Fields<Tissue> fields = [] {
        Fields<Tissue> f("tissue");
        f.add("from", &Tissue::from, anyNumber(), "First value, in physical units.").required();
        f.add("to", &Tissue::to, anyNumber(), "End of the range, itself excluded.").required();
        f.add("phase", &Tissue::phase, objectOf(phaseFields()));
        f.add("finish", &Tissue::finish, objectOf(finishFields()));
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
    if (whole.has("tissues"))
        function.setTissues(std::move(keys.tissues), whole.at("tissues").place());
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
              "Path length that opacities refer to, mm.");
        f.add("scalarOpacity", &TransferKeys::opacity,
              listOf(numbersAt<OpacityPoint>(&OpacityPoint::value, &OpacityPoint::opacity)),
              "[value, opacity]; opacity is clamped to 0..1.")
            .required();
        f.add("rgbTransferFunction", &TransferKeys::colour, listOf(colourPointKind()),
              "[value, r, g, b]; linear light, clamped to 0..1. None: white.");
        f.add("materials", &TransferKeys::materials,
              listOf(objectOf(materialFields()), TransferFunction::kMaxMaterials, "materials"),
              "Material response of ranges of values; other values take that of shading. Ranges do not "
              "overlap.")
            .unlessDefault();
        f.add("tissues", &TransferKeys::tissues,
              listOf(objectOf(tissueFields()), TransferFunction::kMaxTissues, "tissues"),
              "How tissue of ranges of values answers light along paths, in place of "
              "lighting.transport.phase and .surface. Ranges do not overlap.")
            .unlessDefault();
        f.add("gradientOpacity", &TransferKeys::gradient,
              listOf(gradientPointKind(), GradientOpacity::kMostPoints, "points"),
              "[length, factor]: factor on the extinction, clamped to 0..1, by the length of the field's "
              "gradient. It is linear between points and constant beyond the outermost; two points of one "
              "length are a step. None: 1.")
            .unlessDefault();
        f.add("gradientOpacityUnit", &TransferKeys::gradientPer, named<GradientOpacity::Per>(),
              "Lengths of gradients are physical units per mm, or per voxel: the mean of the volume's three "
              "spacings, as in 3D Slicer and VTK.")
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
                                   function.gradientOpacity().points(), function.gradientOpacity().per(),
                                   function.tissues()});
}

const Fields<MaterialResponse>& responseFields() {
    static const Fields<MaterialResponse> fields = [] {
        Fields<MaterialResponse> f("response");
        f.add("ambient", &MaterialResponse::ambient, numberIn(0, 1), "Share of ambient light.");
        f.add("diffuse", &MaterialResponse::diffuse, numberIn(0, 1), "Share of diffuse light.");
        f.add("specular", &MaterialResponse::specular, numberIn(0, 1), "Share of specular light.");
        f.add("specularPower", &MaterialResponse::specularPower, wholeIn(1, 1024),
              "Exponent of the highlights.");
        return f;
    }();
    return fields;
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
