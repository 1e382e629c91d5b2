// core/scene/colour_legend.cpp: see colour_legend.h.
#include "core/scene/colour_legend.h"

#include "core/base/shown_text.h"
#include "core/scene/mode.h"

#include <algorithm>
#include <tuple>
#include <utility>
#include <variant>

namespace tessera {
namespace {

constexpr std::size_t kColours = 64;

/// The values from a function's first point to its last, within the volume's; all of these where none are.
std::pair<double, double> rangeOf(const TransferFunction& function, const ValueSummary& values) {
    const std::vector<double>& kinks = function.kinks();
    double low = values.lowest, high = values.highest;
    if (!kinks.empty() && std::max(low, kinks.front()) < std::min(high, kinks.back()))
        low = std::max(low, kinks.front()), high = std::min(high, kinks.back());
    return {low, high > low ? high : low + 1};
}

} // namespace

std::string LegendBar::textAt(double part) const {
    return numberText(low + part * (high - low), 3);
}

std::vector<LegendBar> colourLegend(const Scene& scene, std::span<const LegendVolume> volumes) {
    std::vector<LegendBar> bars;
    if (scene.mode == Mode::isosurface || reductionOf(scene) == Reduction::sum)
        return bars;
    const bool composite = reductionOf(scene) == Reduction::composite;
    for (std::size_t n = 0; n < std::min(scene.volumes.size(), volumes.size()); ++n) {
        const SceneVolume& volume = scene.volumes[n];
        const auto* const function = std::get_if<TransferFunction>(&volume.transferFunction);
        if (!(volume.opacity > 0) || !function)
            continue;
        const Scene alone = scene.volumes.size() == 1 ? scene : sceneOfVolume(scene, n);
        const ValueLook look{composite ? ValueColour::transferFunction : alone.valueColour,
                             windowOf(alone.window, volumes[n].values, scene.mode)};
        LegendBar bar;
        bar.volume = n;
        bar.name = printable(volume.path.stem().string());
        bar.unit = printable(volumes[n].unit);
        std::tie(bar.low, bar.high) = look.colour == ValueColour::transferFunction
                                          ? rangeOf(*function, volumes[n].values)
                                          : std::pair(look.window.low(), look.window.high());
        for (std::size_t i = 0; i < kColours; ++i) {
            const double part = static_cast<double>(i) / (kColours - 1);
            bar.colours.push_back(colourOfValue(look, *function, bar.low + part * (bar.high - bar.low)));
        }
        bars.push_back(std::move(bar));
    }
    return bars;
}

bool needsLegend(const Scene& scene) {
    return scene.mode == Mode::slice &&
           std::any_of(scene.volumes.begin() + 1, scene.volumes.end(),
                       [](const SceneVolume& volume) { return volume.opacity > 0; });
}

} // namespace tessera
