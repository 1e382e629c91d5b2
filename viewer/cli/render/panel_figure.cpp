// viewer/cli/render/panel_figure.cpp: see panel_figure.h.
#include "viewer/cli/render/panel_figure.h"

#include "core/base/error.h"
#include "core/base/output_file.h"
#include "core/scene/scene_fields.h" // setSceneKey
#include "render/plan/frame_plan.h"
#include "render/plan/fusion.h" // resolved
#include "viewer/annotations/figure.h"
#include "viewer/annotations/figure_file.h"
#include "viewer/cli/render/one_picture.h"
#include "viewer/cli/render/panels.h"
#include "viewer/cli/render/picture_files.h"

#include <algorithm>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace tessera {
namespace {

constexpr const char* kPanelOfFigure = "--panel";

void checkPanelOptions(const RenderArguments& a) {
    for (const auto& [said, option] : {std::pair{a.isFilm(), "a film"},
                                       {!a.path.empty(), "--path"},
                                       {a.tiles > 0, "--tiles"},
                                       {a.ranks, "--ranks"},
                                       {!a.view.empty(), "--view"},
                                       {!a.first.empty(), "--first"},
                                       {!a.layers.empty(), "--layers"},
                                       {!a.keepState.empty(), "--keep-state"},
                                       {a.explain, "--explain"}})
        if (said)
            throw badFile(kPanelOfFigure, std::string("no ") + option + " with it", option);
    checkFigureOutput(a.out);
}

RenderArguments argumentsOf(const Panel& panel, const RenderArguments& all) {
    RenderArguments arguments = all;
    if (!panel.scene.empty())
        arguments.in = panel.scene;
    if (!panel.view.empty())
        arguments.view = panel.view;
    for (const std::string& set : panel.sets)
        arguments.keys.alsoSet(set);
    return arguments;
}

/// The figure while its panels are drawn.
struct Sheet {
    PanelGrid grid = {};
    Image image = {};
    Figure figure = {};
    std::optional<glm::vec3> background = {}; // of the first panel: also between panels
    nlohmann::json panels = nlohmann::json::array();
    int blank = 0;

    void put(int panel, const Image& picture, const std::optional<glm::vec3>& behind) {
        const glm::ivec2 corner = grid.at(panel);
        for (int y = 0; y < picture.size.y; ++y)
            for (int x = 0; x < picture.size.x; ++x) {
                const glm::vec4& pixel = picture.at(x, y);
                image.at(corner.x + x, corner.y + y) = behind ? overBackground(pixel, *behind) : pixel;
            }
    }
    /// Between panels, where a row has fewer, and above and below them.
    void fillRest() {
        if (!background)
            return;
        std::vector<bool> taken(static_cast<std::size_t>(image.size.x));
        for (int y = 0; y < image.size.y; ++y) {
            taken.assign(taken.size(), false);
            for (int n = 0; n < grid.panels; ++n)
                if (const glm::ivec2 at = grid.at(n); y >= at.y && y < at.y + grid.panelSize.y)
                    std::fill_n(taken.begin() + at.x, grid.panelSize.x, true);
            for (int x = 0; x < image.size.x; ++x)
                if (!taken[static_cast<std::size_t>(x)])
                    image.at(x, y) = glm::vec4(*background, 1);
        }
    }
};

/// As its picture would have it.
Camera cameraOf(const RenderTask& task) {
    return std::get<Camera>(
        resolved(task.scene, task.stores, task.ram, task.options.threads, kPictureBytesPerPixel).camera);
}

/// Words that all panels have stand once, above and below all of them: takes them from the panels.
Annotations takeShared(std::vector<FittedPanel>& panels) {
    Annotations all;
    all.textPoints = panels.front().annotations.textPoints;
    all.dpi = panels.front().annotations.dpi;
    for (std::string Annotations::*const words : {&Annotations::title, &Annotations::caption}) {
        const std::string first = panels.front().annotations.*words;
        if (!std::ranges::all_of(panels,
                                 [&](const FittedPanel& panel) { return panel.annotations.*words == first; }))
            continue;
        all.*words = first;
        for (FittedPanel& panel : panels)
            (panel.annotations.*words).clear();
    }
    return all;
}

/// The words of all panels, beside those of each.
FigurePart partOf(const Annotations& words, const Figure& figure) {
    FigurePart part;
    part.size = figure.size;
    part.annotations = words;
    part.orientationKnown = false;
    part.onLight = figure.parts.front().onLight;
    return part;
}

/// "A", "B", ... "Z", "AA".
std::string letterOf(int panel) {
    constexpr int kLetters = 26;
    return (panel < kLetters ? std::string() : letterOf(panel / kLetters - 1)) +
           static_cast<char>('A' + panel % kLetters);
}

/// Draws a panel into the figure.
void drawPanel(const RenderTask& whole, const FittedPanel& fitted, int panel, Sheet& sheet) {
    RenderTask task = whole;
    if (fitted.camera)
        task.scene.camera = *fitted.camera;
    task.scene.annotations = fitted.annotations;
    task.take = [&](const RenderTask& drawn, RenderResult& result, const Figure& figure,
                    const nlohmann::json& manifest) {
        FigurePart part = figure.parts.front();
        part.from = sheet.grid.at(panel);
        part.mark = fitted.mark;
        sheet.figure.parts.push_back(std::move(part));
        sheet.panels.push_back(manifest);
        sheet.blank += isBlank(result.image) ? 1 : 0;
        if (panel == 0)
            sheet.background = drawn.scene.background;
        sheet.put(panel, result.image, drawn.scene.background);
    };
    renderOnePicture(task);
}

} // namespace

void renderPanels(const RenderArguments& arguments, const CommonOptions& common, const WithTask& withTask) {
    checkPanelOptions(arguments);
    PanelFigure figure;
    for (const Panel& panel : panelsOf(arguments.panels))
        figure.panels.push_back({argumentsOf(panel, arguments), std::nullopt, {}, {}});
    figure.oneScale = !arguments.fitEach;
    figure.letters = arguments.panelLetters;
    const glm::ivec2 size = fitPanels(figure, common, withTask);
    figure.words = takeShared(figure.panels);
    figure.grid = gridOf(static_cast<int>(figure.panels.size()), arguments.columns, arguments.gap, size);
    makeRoomForWords(figure);

    MemoryBudget ram("RAM", "--ram", budgetBytes(arguments.ram, "--ram", common));
    const Charge charge = ram.charge(bytesOf(figure.grid), "the figure");
    for (FittedPanel& panel : figure.panels)
        panel.arguments.ram = std::to_string(ram.limitBytes() - charge.bytes());
    drawPanels(figure, arguments, common, ram, withTask);
}

glm::ivec2 fitPanels(PanelFigure& figure, const CommonOptions& common, const WithTask& withTask) {
    CommonOptions quiet = common; // what is told when a panel is drawn is not told when it is fitted
    quiet.quiet = true;
    std::vector<Camera> cameras;
    glm::ivec2 size{0};
    for (FittedPanel& panel : figure.panels)
        withTask(panel.arguments, quiet, [&](const RenderTask& task) {
            if (size != glm::ivec2(0) && size != task.scene.imageSize)
                throw badFile(kPanelOfFigure, "panels of one size (--size)", "others");
            size = task.scene.imageSize;
            cameras.push_back(cameraOf(task));
            panel.annotations = task.scene.annotations;
        });
    if (figure.oneScale)
        shareScale(cameras);
    for (std::size_t n = 0; n < cameras.size(); ++n)
        figure.panels[n].camera = cameras[n];
    return size;
}

void makeRoomForWords(PanelFigure& figure) {
    figure.grid.above = figure.grid.below = 0;
    FigurePart part;
    part.size = figure.grid.size();
    part.annotations = figure.words;
    const StripHeights strips = stripsOf(part, figure.words.dpi);
    figure.grid.above = strips.above;
    figure.grid.below = strips.below;
    checkSize(figure.grid);
}

std::size_t bytesOf(const PanelGrid& grid) {
    return kPictureBytesPerPixel * static_cast<std::size_t>(grid.size().x) *
           static_cast<std::size_t>(grid.size().y);
}

void drawPanels(const PanelFigure& figure, const RenderArguments& arguments, const CommonOptions& common,
                MemoryBudget& ram, const WithTask& withTask) {
    const int count = figure.grid.panels;
    const glm::ivec2 whole = figure.grid.size();
    Sheet sheet;
    sheet.grid = figure.grid;
    sheet.image = Image(whole);
    sheet.figure.size = whole;
    sheet.figure.dpi = figure.words.dpi;
    for (int n = 0; n < count; ++n) {
        FittedPanel panel = figure.panels[static_cast<std::size_t>(n)];
        panel.mark = figure.letters ? letterOf(n) : "";
        RenderArguments one = panel.arguments;
        one.json = false;
        withTask(one, common, [&](const RenderTask& task) { drawPanel(task, panel, n, sheet); });
    }
    sheet.fillRest();
    sheet.figure.parts.push_back(partOf(figure.words, sheet.figure));
    common.progress->stage("writing the figure");
    nlohmann::json report = {{"tesseraManifest", 1},
                             {"notice", "not for diagnosis"},
                             {"program", "tessera " TESSERA_VERSION},
                             {"figure", figureJson(figure)},
                             {"panels", sheet.panels}};
    tellAnnotations(report, sheet.figure);
    writeFigure(arguments.out, std::move(sheet.image), sheet.figure, manifestText(report), {}, ram);
    common.progress->end();
    if (const std::string left = leftOutText(report); !left.empty())
        common.note(left);
    if (arguments.json) {
        report["output"] = arguments.out;
        report["blank"] = sheet.blank == count;
        printReport(report);
        finishStandardOutput();
    }
    common.note("wrote " + arguments.out + ": " + std::to_string(whole.x) + " x " + std::to_string(whole.y) +
                ", " + std::to_string(count) + " panels");
}

nlohmann::json figureJson(const PanelFigure& figure) {
    const PanelGrid& grid = figure.grid;
    nlohmann::json said = {{"columns", grid.columns},
                           {"gap", grid.gap},
                           {"panelSize", {grid.panelSize.x, grid.panelSize.y}},
                           {"above", grid.above},
                           {"below", grid.below},
                           {"title", figure.words.title},
                           {"caption", figure.words.caption},
                           {"textPoints", figure.words.textPoints},
                           {"dpi", figure.words.dpi},
                           {"oneScale", figure.oneScale}};
    if (figure.letters)
        said["letters"] = true;
    return said;
}

PanelFigure figureOfJson(const nlohmann::json& said, int panels, const std::string& where) {
    const auto wrong = [&] { return badFile(where, "\"figure\" as tessera writes it", "another"); };
    const auto within = [&](const nlohmann::json& number, int most) {
        const auto value = number.is_number_integer() ? number.get<std::int64_t>() : -1;
        return value >= 0 && value <= most ? static_cast<int>(value) : throw wrong();
    };
    if (panels > static_cast<int>(kMostPanels))
        throw wrong();
    PanelFigure figure;
    try {
        const auto pixels = [&](const nlohmann::json& number) {
            return within(number, Scene::kMaxImageExtent);
        };
        PanelGrid& grid = figure.grid;
        const nlohmann::json& size = said.at("panelSize");
        grid = gridOf(panels, within(said.at("columns"), panels), pixels(said.at("gap")),
                      {pixels(size.at(0)), pixels(size.at(1))});
        grid.above = pixels(said.at("above"));
        grid.below = pixels(said.at("below"));
        checkSize(grid);
        Scene words; // by the ranges of scenes
        for (const char* key : {"title", "caption", "textPoints", "dpi"})
            setSceneKey(words, std::string("annotations.") + key, said.at(key), where);
        figure.words = words.annotations;
        figure.oneScale = said.at("oneScale").get<bool>();
        figure.letters = said.value("letters", false);
    } catch (const nlohmann::json::exception&) {
        throw wrong();
    } catch (const InputError&) {
        throw wrong();
    }
    return figure;
}

} // namespace tessera
