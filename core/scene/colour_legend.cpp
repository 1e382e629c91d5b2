// core/scene/colour_legend.cpp: see colour_legend.h.
#include "core/scene/colour_legend.h"

#include "core/base/shown_text.h"
#include "core/scene/mode.h"
#include "core/scene/picture_text.h"

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
                             windowOf(alone.window, volumes[n].values)};
        LegendBar bar;
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

void drawColourLegend(Image& image, std::span<const LegendBar> bars) {
    constexpr int kWidth = 96, kHeight = 6, kGap = 3, kMargin = 6, kParts = 2; // dots; intervals of values
    constexpr int kRow = 2 * kTextHeight + kHeight + 4 * kGap;
    const int count = static_cast<int>(bars.size());
    int unit = textUnit(image.size);
    while (unit > 1 && (unit * (kWidth + 2 * kMargin) > image.size.x || unit * kRow * count > image.size.y))
        --unit;
    const int dots = std::clamp(image.size.x / std::max(1, unit) - 2 * kMargin, 1, kWidth);
    int top = image.size.y - unit * (kMargin + kRow * count - 2 * kGap);
    for (const LegendBar& bar : bars) {
        const glm::ivec2 from(unit * kMargin, top + unit * (kTextHeight + kGap));
        const glm::ivec2 size = unit * glm::ivec2(dots, kHeight);
        for (const bool edge : {true, false}) {
            const int more = edge ? std::max(1, unit / 2) : 0;
            PicturePen pen(image, edge ? glm::vec4(0, 0, 0, 1) : glm::vec4(1));
            pen.write({from.x, top}, bar.title(), unit, more);
            pen.fill(from - more, from + size + more);
            for (int part = 0; part <= kParts; ++part) {
                const std::string text = bar.textAt(static_cast<double>(part) / kParts);
                const int width = unit * (kTextPitch * static_cast<int>(text.size()) - 1);
                const int x = from.x + part * (size.x - width) / kParts;
                pen.write({x, from.y + size.y + unit * kGap}, text, unit, more);
            }
        }
        for (int x = 0; x < size.x; ++x) {
            const std::size_t colour =
                static_cast<std::size_t>(x) * bar.colours.size() / static_cast<std::size_t>(size.x);
            PicturePen pen(image, glm::vec4(glm::vec3(bar.colours[colour]), 1));
            pen.fill({from.x + x, from.y}, {from.x + x + 1, from.y + size.y});
        }
        top += unit * kRow;
    }
}

} // namespace tessera
