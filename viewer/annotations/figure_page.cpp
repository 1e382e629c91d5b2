// viewer/annotations/figure_page.cpp: see figure_page.h.
#include "viewer/annotations/figure_page.h"

#include "core/base/error.h"
#include "core/scene/scene.h" // Scene::kMaxImageExtent
#include "viewer/annotations/figure_drawing.h"

#include <algorithm>
#include <glm/vec2.hpp>
#include <glm/vec4.hpp>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace tessera {
namespace {

const FigurePart& partOf(const Figure& figure) {
    TESSERA_CHECK(figure.parts.size() == 1);
    return figure.parts.front();
}

std::size_t indexOf(const glm::ivec2& at, const glm::ivec2& size) {
    return static_cast<std::size_t>(at.y) * static_cast<std::size_t>(size.x) + static_cast<std::size_t>(at.x);
}

} // namespace

Strips stripsOf(const FigurePart& part, double dpi) {
    const bool any = part.annotations.any() || !part.mark.empty();
    return any && part.annotations.margin != AnnotationMargin::none ? measureBeside(part, dpi) : Strips();
}

void placePart(FigurePart& part, const glm::ivec2& corner, const Strips& strips) {
    part.from = corner + strips.corner();
    part.strips = strips;
}

Figure figureOf(FigurePart part, double dpi) {
    const Strips strips = stripsOf(part, dpi);
    return figureOf(std::move(part), dpi, strips);
}

Figure figureOf(FigurePart part, double dpi, const Strips& strips) {
    placePart(part, {0, 0}, strips);
    Figure figure;
    figure.size = part.size + strips.size();
    figure.dpi = dpi;
    if (figure.size.x > Scene::kMaxImageExtent || figure.size.y > Scene::kMaxImageExtent)
        throw badFile("--margin",
                      "a page of at most " + std::to_string(Scene::kMaxImageExtent) + " pixels a side",
                      std::to_string(figure.size.x) + " x " + std::to_string(figure.size.y));
    figure.parts.push_back(std::move(part));
    return figure;
}

std::size_t pageBytes(const Figure& figure) {
    const bool isOwn = std::ranges::none_of(figure.parts, [](const auto& part) { return part.strips.any(); });
    return isOwn ? 0
                 : sizeof(glm::vec4) * static_cast<std::size_t>(figure.size.x) *
                       static_cast<std::size_t>(figure.size.y);
}

Image onPage(Image picture, const Figure& figure) {
    if (picture.size == figure.size)
        return picture;
    const FigurePart& part = partOf(figure);
    TESSERA_CHECK(picture.size == part.size);
    Image page(figure.size);
    std::ranges::fill(page.pixels, part.stripColour);
    for (int y = 0; y < picture.size.y; ++y)
        std::copy_n(&picture.at(0, y), picture.size.x, &page.at(part.from.x, part.from.y + y));
    return page;
}

LayerChannel onPage(const LayerChannel& channel, const Figure& figure, std::vector<float>& values) {
    const FigurePart& part = partOf(figure);
    values.assign(static_cast<std::size_t>(figure.size.x) * static_cast<std::size_t>(figure.size.y), 0.0f);
    for (int y = 0; y < part.size.y; ++y)
        for (int x = 0; x < part.size.x; ++x)
            values[indexOf(part.from + glm::ivec2(x, y), figure.size)] =
                channel.first[indexOf({x, y}, part.size) * channel.stride];
    return {channel.name, values.data(), 1};
}

ImageRows onPage(ImageRows picture, const Figure& figure) {
    if (picture.size == figure.size)
        return picture;
    const FigurePart& part = partOf(figure);
    TESSERA_CHECK(picture.size == part.size);
    const auto rows = std::make_shared<std::vector<glm::vec4>>();
    return {figure.size, picture.opaque && part.stripColour.a >= 1,
            [&part, size = figure.size, rows,
             picture = std::move(picture)](int first, int count) -> std::span<const glm::vec4> {
                const int top = std::max(first, part.from.y),
                          end = std::min(first + count, part.from.y + part.size.y);
                const std::span<const glm::vec4> within =
                    top < end ? picture.rows(top - part.from.y, end - top) : std::span<const glm::vec4>();
                rows->assign(static_cast<std::size_t>(count) * static_cast<std::size_t>(size.x),
                             part.stripColour);
                for (int y = top; y < end; ++y)
                    std::copy_n(&within[indexOf({0, y - top}, part.size)], part.size.x,
                                &(*rows)[indexOf({part.from.x, y - first}, size)]);
                return *rows;
            }};
}

} // namespace tessera
