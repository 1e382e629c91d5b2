// core/scene/value_look.cpp: see value_look.h.
#include "core/scene/value_look.h"

#include "core/base/error.h"
#include "core/image/colour.h"

#include <algorithm>
#include <cmath>

namespace tessera {

glm::dvec3 colourOfValue(const ValueLook& look, const TransferFunction& function, double value) {
    if (look.colour == ValueColour::transferFunction)
        return function.colour(value);
    const double part = std::clamp((value - look.window.low()) / look.window.width, 0.0, 1.0);
    return glm::dvec3(linearFromSrgb(look.colour == ValueColour::inverse ? 1 - part : part));
}

TransferTable valueTable(const ValueLook& look, const TransferFunction& function, Reduction reduction) {
    TESSERA_CHECK(reduction != Reduction::composite);
    TransferTable table;
    if (look.colour == ValueColour::transferFunction) {
        table = makeTable(function);
        table.gradientOpacity = {};
    } else {
        // Between so many entries the curve of sRGB is off by 5e-8 at most.
        constexpr std::size_t kEntries = 4096;
        table.firstValue = static_cast<float>(look.window.low());
        // A window so narrow, or so far from 0, that floats cannot tell its ends apart is a step.
        const double least = 1e-6 * std::max(std::abs(look.window.low()), std::abs(look.window.high()));
        table.entriesPerValue =
            static_cast<float>((kEntries - 1) / std::max({look.window.width, least, 1e-25}));
        table.entries.resize(kEntries);
        for (std::size_t i = 0; i < kEntries; ++i) {
            const std::size_t grey = look.colour == ValueColour::inverse ? kEntries - 1 - i : i;
            table.entries[i] = glm::vec4(
                glm::vec3(static_cast<float>(linearFromSrgb(static_cast<double>(grey) / (kEntries - 1)))), 1);
        }
    }
    table.relativeError = 0;
    for (glm::vec4& entry : table.entries)
        entry.a = 1;
    if (reduction == Reduction::maximum)
        table.entries.front().a = 0;
    if (reduction == Reduction::minimum)
        table.entries.back().a = 0;
    table.nonZeroUpTo.resize(table.entries.size());
    int shown = 0;
    for (std::size_t i = 0; i < table.entries.size(); ++i)
        table.nonZeroUpTo[i] = shown += table.entries[i].a != 0 ? 1 : 0;
    return table;
}

} // namespace tessera
