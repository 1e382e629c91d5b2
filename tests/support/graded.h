// tests/support/graded.h: transfer functions with gradient opacity, for tests: flat parts, a rise and a
// step at lengths that phantoms and scans have.
#pragma once

#include "core/scene/preset.h"
#include "core/scene/scene.h"

#include <string>
#include <utility>

namespace tessera::test {

/// Lengths per mm of values in HU.
inline GradientOpacity someOpacityByGradient() {
    return GradientOpacity::fromPoints({{2, 0}, {15, 0.3}, {40, 0.35}, {40, 0.7}, {120, 1}, {600, 0.5}});
}

inline TransferFunction graded(TransferFunction function, GradientOpacity factor = someOpacityByGradient()) {
    function.setGradientOpacity(std::move(factor));
    return function;
}

/// The scene's preset, spelled out, of values in HU.
inline void grade(Scene& scene) {
    ValueSummary values;
    values.isHu = true;
    TransferChoice& choice = scene.volumes[0].transferFunction;
    if (const auto* preset = std::get_if<std::string>(&choice))
        choice = graded(presetFunction(*preset, values));
    else
        choice = graded(std::get<TransferFunction>(choice));
}

} // namespace tessera::test
