// viewer/annotations/panel_sheet.cpp: see panel_sheet.h.
#include "viewer/annotations/panel_sheet.h"

#include "core/base/budget.h"
#include "core/base/error.h"
#include "core/scene/scene.h"
#include "core/scene/scene_fields.h" // setSceneKey
#include "render/plan/frame_plan.h"  // kPictureBytesPerPixel
#include "viewer/annotations/figure_file.h"
#include "viewer/annotations/figure_page.h"
#include "viewer/cli/manifest/manifest.h" // manifestText

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/vec4.hpp>
#include <utility>

namespace tessera {
namespace {

constexpr int kMostInARow = 3;

/// The words of all panels, beside those of each.
FigurePart partOf(const Annotations& words, const Figure& figure) {
    FigurePart part;
    part.size = figure.size;
    part.annotations = words;
    part.orientationKnown = false;
    const FigurePart& first = figure.parts.front();
    part.onLight = first.strips.any() ? first.stripsAreLight : first.onLight;
    return part;
}

/// "A", "B", ... "Z", "AA".
std::string letterOf(int panel) {
    constexpr int kLetters = 26;
    return (panel < kLetters ? std::string() : letterOf(panel / kLetters - 1)) +
           static_cast<char>('A' + panel % kLetters);
}

} // namespace

glm::ivec2 PanelGrid::size() const {
    return glm::ivec2(columns, rows()) * (cellSize() + gap) - gap + glm::ivec2(0, above + below);
}

glm::ivec2 PanelGrid::at(int panel) const {
    return glm::ivec2(panel % columns, panel / columns) * (cellSize() + gap) + glm::ivec2(0, above);
}

PanelGrid gridOf(int panels, int columns, int gap, const glm::ivec2& panelSize, const std::string& where) {
    const int square = static_cast<int>(std::ceil(std::sqrt(static_cast<double>(panels))));
    const int chosen = columns > 0 ? columns : panels <= kMostInARow ? panels : square;
    PanelGrid grid{panels, std::min(chosen, panels), gap, panelSize};
    checkSize(grid, where);
    return grid;
}

void checkSize(const PanelGrid& grid, const std::string& where) {
    // In 64 bits, for a side is refused before it overflows.
    const auto side = [&](std::int64_t count, int length) { return count * (length + grid.gap) - grid.gap; };
    const std::int64_t width = side(grid.columns, grid.cellSize().x),
                       height = side(grid.rows(), grid.cellSize().y) + grid.above + grid.below;
    if (width > Scene::kMaxImageExtent || height > Scene::kMaxImageExtent)
        throw badFile(where,
                      "a figure of at most " + std::to_string(Scene::kMaxImageExtent) + " pixels a side",
                      std::to_string(width) + " x " + std::to_string(height));
}

Annotations takeShared(const std::vector<Annotations*>& panels) {
    Annotations all;
    all.textPoints = panels.front()->textPoints;
    all.dpi = panels.front()->dpi;
    for (std::string Annotations::*const words : {&Annotations::title, &Annotations::caption}) {
        const std::string first = panels.front()->*words;
        if (!std::ranges::all_of(panels, [&](const Annotations* panel) { return panel->*words == first; }))
            continue;
        all.*words = first;
        for (Annotations* const panel : panels)
            (panel->*words).clear();
    }
    return all;
}

void makeRoomForWords(PanelLayout& layout, const std::string& where) {
    layout.grid.above = layout.grid.below = 0;
    FigurePart part;
    part.size = layout.grid.size();
    part.annotations = layout.words;
    const StripHeights strips = heightsOf(part, layout.words.dpi);
    layout.grid.above = strips.above;
    layout.grid.below = strips.below;
    checkSize(layout.grid, where);
}

std::size_t bytesOf(const PanelGrid& grid) {
    return kPictureBytesPerPixel * static_cast<std::size_t>(grid.size().x) *
           static_cast<std::size_t>(grid.size().y);
}

PanelSheet::PanelSheet(const PanelLayout& layout) : layout_(layout), image_(layout.grid.size()) {
    figure_.size = image_.size;
    figure_.dpi = layout.words.dpi;
}

void PanelSheet::put(const Image& picture, FigurePart part, const std::optional<glm::vec3>& background,
                     nlohmann::json manifest) {
    const auto panel = static_cast<int>(figure_.parts.size());
    TESSERA_CHECK(panel < layout_.grid.panels && picture.size == layout_.grid.panelSize);
    const Strips& strips = layout_.grid.strips;
    if (panel == 0)
        between_ = strips.any() ? part.stripColour : background ? glm::vec4(*background, 1) : glm::vec4(0);
    const glm::ivec2 cell = layout_.grid.at(panel), size = layout_.grid.cellSize();
    for (int y = 0; y < size.y && strips.any(); ++y)
        std::fill_n(&image_.at(cell.x, cell.y + y), size.x, part.stripColour);
    placePart(part, cell, strips);
    const glm::ivec2 corner = part.from;
    for (int y = 0; y < picture.size.y; ++y)
        for (int x = 0; x < picture.size.x; ++x) {
            const glm::vec4& pixel = picture.at(x, y);
            image_.at(corner.x + x, corner.y + y) = background ? overBackground(pixel, *background) : pixel;
        }
    part.size = picture.size;
    part.mark = layout_.letters ? letterOf(panel) : "";
    figure_.parts.push_back(std::move(part));
    panels_.push_back(std::move(manifest));
}

/// Between panels, where a row has fewer, and above and below them.
void PanelSheet::fillRest() {
    if (between_ == glm::vec4(0))
        return;
    const PanelGrid& grid = layout_.grid;
    std::vector<bool> taken(static_cast<std::size_t>(image_.size.x));
    for (int y = 0; y < image_.size.y; ++y) {
        taken.assign(taken.size(), false);
        for (int n = 0; n < grid.panels; ++n)
            if (const glm::ivec2 at = grid.at(n); y >= at.y && y < at.y + grid.cellSize().y)
                std::fill_n(taken.begin() + at.x, grid.cellSize().x, true);
        for (int x = 0; x < image_.size.x; ++x)
            if (!taken[static_cast<std::size_t>(x)])
                image_.at(x, y) = between_;
    }
}

nlohmann::json PanelSheet::write(const std::filesystem::path& path, MemoryBudget& ram) {
    fillRest();
    figure_.parts.push_back(partOf(layout_.words, figure_));
    nlohmann::json report = {{"tesseraManifest", 1},
                             {"notice", "not for diagnosis"},
                             {"program", "tessera " TESSERA_VERSION},
                             {"figure", layoutJson(layout_)},
                             {"panels", std::move(panels_)}};
    tellAnnotations(report, figure_);
    writeFigure(path, std::move(image_), figure_, manifestText(report), {}, ram);
    return report;
}

nlohmann::json layoutJson(const PanelLayout& layout) {
    const PanelGrid& grid = layout.grid;
    nlohmann::json said = {{"columns", grid.columns},
                           {"gap", grid.gap},
                           {"panelSize", {grid.panelSize.x, grid.panelSize.y}},
                           {"above", grid.above},
                           {"below", grid.below},
                           {"title", layout.words.title},
                           {"caption", layout.words.caption},
                           {"textPoints", layout.words.textPoints},
                           {"dpi", layout.words.dpi},
                           {"oneScale", layout.oneScale}};
    if (layout.letters)
        said["letters"] = true;
    if (const Strips& strips = grid.strips; strips.any())
        said["strips"] = {strips.left, strips.right, strips.above, strips.below};
    return said;
}

PanelLayout layoutOfJson(const nlohmann::json& said, int panels, const std::string& where) {
    const auto wrong = [&] { return badFile(where, "\"figure\" as tessera writes it", "another"); };
    const auto within = [&](const nlohmann::json& number, int most) {
        const auto value = number.is_number_integer() ? number.get<std::int64_t>() : -1;
        return value >= 0 && value <= most ? static_cast<int>(value) : throw wrong();
    };
    if (panels > static_cast<int>(kMostPanels))
        throw wrong();
    PanelLayout layout;
    try {
        const auto pixels = [&](const nlohmann::json& number) {
            return within(number, Scene::kMaxImageExtent);
        };
        PanelGrid& grid = layout.grid;
        const nlohmann::json& size = said.at("panelSize");
        grid = gridOf(panels, within(said.at("columns"), panels), pixels(said.at("gap")),
                      {pixels(size.at(0)), pixels(size.at(1))}, where);
        grid.above = pixels(said.at("above"));
        grid.below = pixels(said.at("below"));
        if (said.contains("strips")) {
            const nlohmann::json& strips = said.at("strips");
            grid.strips = {pixels(strips.at(0)), pixels(strips.at(1)), pixels(strips.at(2)),
                           pixels(strips.at(3))};
        }
        checkSize(grid, where);
        Scene words; // by the ranges of scenes
        for (const char* key : {"title", "caption", "textPoints", "dpi"})
            setSceneKey(words, std::string("annotations.") + key, said.at(key), where);
        layout.words = words.annotations;
        layout.oneScale = said.at("oneScale").get<bool>();
        layout.letters = said.value("letters", false);
    } catch (const nlohmann::json::exception&) {
        throw wrong();
    } catch (const InputError&) {
        throw wrong();
    }
    return layout;
}

} // namespace tessera
