// core/scene/shading_json.cpp: see shading_json.h.
#include "core/scene/shading_json.h"

#include "core/base/magnitude.h"

#include <nlohmann/json.hpp>

namespace tessera {
const std::vector<std::string>& shadingKeys() {
    static const std::vector<std::string> keys = {"shade",         "ambient",  "diffuse", "specular",
                                                  "specularPower", "gradient", "model",   "gradientWeight"};
    return keys;
}

Shading parseShading(const JsonValue& value) {
    value.requireKeys(shadingKeys());
    Shading shading;
    value.read("shade", shading.on);
    value.read("ambient", 0, 1, shading.ambient);
    value.read("diffuse", 0, 1, shading.diffuse);
    value.read("specular", 0, 1, shading.specular);
    value.read("specularPower", 0, 1024, shading.specularPower);
    if (value.has("gradient"))
        shading.gradient = parseGradient(value.at("gradient").oneOf(gradientNames()), value.place());
    if (value.has("model"))
        shading.model = value.at("model").oneOf(shadingModelNames()) == "phong" ? ShadingModel::phong
                                                                                : ShadingModel::blinnPhong;
    if (value.has("gradientWeight")) {
        const JsonValue weight = value.at("gradientWeight");
        const std::vector<double> ends = weight.numbers(2);
        if (!(ends[0] >= 0 && ends[0] <= ends[1]))
            weight.refuse("[low, high], 0 or more, ascending");
        checkValue(ends[1], "[low, high]", weight.place());
        shading.gradientWeight = GradientWeight{ends[0], ends[1]};
    }
    return shading;
}

} // namespace tessera
