// core/scene/shading_fields.cpp: the keys of how surfaces answer light: see light_fields.h.
#include "core/base/magnitude.h"
#include "core/scene/light_fields.h"

namespace tessera {

template <> const NameTable<ReflectionKind>& namesOf() {
    static const NameTable<ReflectionKind> names{{{ReflectionKind::constant, "constant"},
                                                  {ReflectionKind::fresnel, "fresnel"},
                                                  {ReflectionKind::gradient, "gradient"}}};
    return names;
}

Kind<GradientWeight> gradientWeightKind() {
    return numbersAt<GradientWeight>(&GradientWeight::low, &GradientWeight::high)
        .checked([](const GradientWeight& weight, const JsonValue& value) {
            if (!(weight.low >= 0 && weight.low <= weight.high))
                value.refuse("[low, high], 0 or more, ascending");
            checkValue(weight.high, "[low, high]", value.place());
        });
}

const Fields<Shading>& shadingFields() {
    static const Fields<Shading> fields = [] {
        Fields<Shading> f("shading", "Material response to light, and the gradient operator.");
        f.add("shade", &Shading::on, trueOrFalse(), "false: colours of the transfer function, unlit.")
            .setBy("--no-shading", "draw the transfer function's colours, unlit");
        f.add("ambient", &Shading::ambient, numberIn(0, 1), "Share of ambient light.");
        f.add("diffuse", &Shading::diffuse, numberIn(0, 1), "Share of diffuse light.");
        f.add("specular", &Shading::specular, numberIn(0, 1), "Share of specular light.");
        f.add("specularPower", &Shading::specularPower, numberIn(0, 1024),
              "Exponent of the highlights: the higher, the smaller they are.");
        f.add(
             "gradient", &Shading::gradient, named<Gradient>(),
             "Gradient operator: differences forward, central over a pitch or half a pitch to both sides, or "
             "of Sobel, or Sobel's over two or four pitches, for normals of noisy scans; or the derivative "
             "of "
             "trilinear interpolation (analytic) or of the cubic B-spline.")
            .setBy("--gradient", "gradient operator of shading: {names} (default: {default})");
        f.add("model", &Shading::model, named<ShadingModel>(),
              "Highlights by the mirrored light direction, or by the direction halfway between light and "
              "viewer (wider at the same power).")
            .unlessDefault();
        f.add("gradientWeight", &Shading::gradientWeight, gradientWeightKind(),
              "[low, high], physical units per mm: gradients up to low are shaded as a volume, from high on "
              "as a surface. Without it every gradient is a surface.");
        return f;
    }();
    return fields;
}

const Fields<Reflection>& reflectionFields() {
    static const Fields<Reflection> fields = [] {
        Fields<Reflection> f("reflection",
                             "The isosurface mirrors what is around it, in stills. What rays see beyond the "
                             "volume is lighting.environment, or the background.");
        f.add("kind", &Reflection::kind, named<ReflectionKind>(),
              "The share of light that is mirrored. constant: the same everywhere. fresnel: by the angle, as "
              "glass or water. gradient: by the length of the field's gradient.");
        f.add("strength", &Reflection::strength, numberIn(0, 1), "Factor on that share.");
        f.add("gradient", &Reflection::gradient, gradientWeightKind(),
              "[low, high], physical units per mm, of kind gradient: nothing is mirrored up to low, all from "
              "high on.")
            .unlessDefault();
        f.add("ior", &Reflection::ior, numberIn(1, Reflection::kMostIor),
              "Index of refraction behind the surface; before it that of the next lower isosurface, 1 below "
              "all.");
        f.add("transmits", &Reflection::transmits, trueOrFalse(),
              "Light that is not mirrored goes through the surface, refracted; by 1 less its opacity.")
            .unlessDefault();
        return f;
    }();
    return fields;
}

} // namespace tessera
