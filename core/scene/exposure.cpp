// core/scene/exposure.cpp: see exposure.h.
#include "core/scene/exposure.h"

#include "core/base/error.h"
#include "core/base/names.h"
#include "core/image/colour.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <string>
#include <variant>

namespace tessera {

GreyWindow Exposure::windowOf(const Image& sums) const {
    float most = 0;
    for (const glm::vec4& sum : sums.pixels)
        most = std::max(most, mode == Mode::emission ? std::max({sum.r, sum.g, sum.b}) : sum.a);
    const double width = double{most} / double{kThin};
    return width > 0 ? GreyWindow{width / 2, width} : GreyWindow{0.5, 1};
}

glm::vec4 Exposure::shown(const glm::vec4& sum, const GreyWindow& window, bool meets) const {
    const auto part = [&](float thin) {
        return std::clamp((double{thin} / double{kThin} - window.low()) / window.width, 0.0, 1.0);
    };
    switch (mode) {
    case Mode::emission: {
        const glm::vec3 light(part(sum.r), part(sum.g), part(sum.b));
        return {light, std::max({light.r, light.g, light.b})};
    }
    case Mode::absorption: {
        const auto alpha = static_cast<float>(-std::expm1(-double{sum.a} / double{kThin}));
        if (colour == ValueColour::transferFunction)
            return sum.a > 0 ? glm::vec4(glm::min(glm::vec3(sum) / sum.a, 1.0f) * alpha, alpha)
                             : glm::vec4(0);
        return {glm::vec3(colour == ValueColour::inverse ? 0 : alpha), alpha};
    }
    default: {
        if (!meets)
            return glm::vec4(0);
        const double grey = colour == ValueColour::inverse ? 1 - part(sum.a) : part(sum.a);
        return {glm::vec3(static_cast<float>(linearFromSrgb(grey))), 1};
    }
    }
}

Exposure exposureOf(Mode mode, ValueColour colour, const WindowChoice& window) {
    TESSERA_CHECK(mode == Mode::emission || mode == Mode::absorption || mode == Mode::radiograph);
    Exposure exposure{mode, colour, {}};
    if (const auto* named = std::get_if<std::string>(&window)) {
        if (*named != "auto" && mode != Mode::absorption)
            throw InputError("window: expected auto or CENTRE,WIDTH of " +
                             std::string(mode == Mode::radiograph ? "mm of water" : "light") + " in mode " +
                             nameOf(mode) + ", found \"" + *named + "\", which is in HU");
    } else {
        exposure.window = std::get<GreyWindow>(window);
    }
    if (mode == Mode::radiograph && colour == ValueColour::transferFunction)
        throw InputError(
            "valueColour: expected window or inverse in mode radiograph, which takes no function, "
            "found transferFunction");
    return exposure;
}

TransferFunction radiographFunction(double highest) {
    constexpr double kAir = -1000;
    std::vector<OpacityPoint> points{{kAir, 0}};
    if (highest > kAir)
        points.push_back({highest, (highest - kAir) / -kAir});
    return TransferFunction::fromExtinction(std::move(points), {}, "mode radiograph");
}

TransferFunction bodyFunction() {
    return TransferFunction::fromExtinction({{-500, 0}, {-200, 0.2}}, {}, "mode radiograph");
}

} // namespace tessera
