// viewer/annotations/figure.cpp: see figure.h.
#include "viewer/annotations/figure.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <utility>

namespace tessera {

bool isLight(const std::optional<glm::vec3>& background) {
    constexpr glm::vec3 kLuminance(0.2126f, 0.7152f, 0.0722f); // of linear Rec. 709
    constexpr float kMiddle = 0.18f;                           // L* is 50
    return background && glm::dot(*background, kLuminance) > kMiddle;
}

Strips larger(const Strips& a, const Strips& b) {
    return {std::max(a.left, b.left), std::max(a.right, b.right), std::max(a.above, b.above),
            std::max(a.below, b.below)};
}

std::string firstAnnotation(const Annotations& a) {
    for (const auto& [asked, option] : {std::pair{a.scaleBar, "--scale-bar"},
                                        {a.directions != Directions::none, "--directions"},
                                        {a.legend, "--legend"},
                                        {a.labelLegend, "--label-legend"},
                                        {a.measurements, "--measurements"},
                                        {a.error, "--error-caption"},
                                        {!a.title.empty(), "--title"},
                                        {!a.caption.empty(), "--caption"},
                                        {!a.arrows.empty(), "annotations.arrows"}})
        if (asked)
            return option;
    return {};
}

bool Figure::any() const {
    const auto says = [](const InnerPicture& inner) {
        return !inner.ticks.empty() ||
               !(inner.words + inner.left + inner.right + inner.top + inner.bottom).empty();
    };
    return std::ranges::any_of(parts, [&](const FigurePart& part) {
        return part.annotations.any() || !part.mark.empty() || std::ranges::any_of(part.inner, says);
    });
}

} // namespace tessera
