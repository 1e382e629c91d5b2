// core/transfer_json.cpp: see transfer_json.h.
#include "core/transfer_json.h"

#include <nlohmann/json.hpp>

namespace tessera {
namespace {
constexpr double kMinUnitMm = 1e-6, kMaxUnitMm = 1e6; // from microscopes to mountains
}

const std::vector<std::string>& transferKeys() {
    static const std::vector<std::string> keys = {"scalarOpacityUnitDistance", "scalarOpacity",
                                                  "rgbTransferFunction"};
    return keys;
}

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
    return TransferFunction::fromOpacity(std::move(opacity), std::move(colour), unitMm, value.place());
}

nlohmann::json transferJson(const TransferFunction& function) {
    nlohmann::json opacity = nlohmann::json::array(), colour = nlohmann::json::array();
    for (const OpacityPoint& p : function.opacityPoints())
        opacity.push_back({p.value, p.opacity});
    for (const ColourPoint& p : function.colourPoints())
        colour.push_back({p.value, p.colour.r, p.colour.g, p.colour.b});
    return {{"scalarOpacityUnitDistance", function.referenceLengthMm()},
            {"scalarOpacity", std::move(opacity)},
            {"rgbTransferFunction", std::move(colour)}};
}

} // namespace tessera
