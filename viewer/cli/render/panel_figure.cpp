// viewer/cli/render/panel_figure.cpp: see panel_figure.h.
#include "viewer/cli/render/panel_figure.h"

#include "core/base/error.h"
#include "core/base/output_file.h"
#include "render/plan/frame_plan.h"
#include "render/plan/fusion.h" // resolved
#include "viewer/annotations/figure.h"
#include "viewer/annotations/figure_file.h"
#include "viewer/cli/render/one_picture.h"
#include "viewer/cli/render/panels.h"
#include "viewer/cli/render/picture_files.h"

#include <algorithm>
#include <cmath>
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

/// Room for lines of words, pixels.
int heightOf(const std::string& words, const Annotations& all, int width) {
    constexpr double kLetterWidth = 0.62, kLine = 1.4, kMargins = 2; // parts of a letter's height
    if (words.empty())
        return 0;
    const double letter = all.textPoints / 72 * all.dpi;
    const double lines = std::ceil(kLetterWidth * letter * static_cast<double>(words.size()) /
                                   std::max(1.0, width - kMargins * letter));
    return static_cast<int>(std::ceil(letter * (kLine * lines + kMargins)));
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
    CommonOptions quiet = common; // what is told when a panel is drawn is not told when it is fitted
    quiet.quiet = true;
    std::vector<Camera> cameras;
    glm::ivec2 size{0};
    for (const Panel& panel : panelsOf(arguments.panels)) {
        const RenderArguments one = argumentsOf(panel, arguments);
        withTask(one, quiet, [&](const RenderTask& task) {
            if (size != glm::ivec2(0) && size != task.scene.imageSize)
                throw badFile(kPanelOfFigure, "panels of one size (--size)", "others");
            size = task.scene.imageSize;
            cameras.push_back(cameraOf(task));
            figure.panels.push_back({one, cameras.back(), task.scene.annotations});
        });
    }
    figure.oneScale = !arguments.ownScales;
    if (figure.oneScale)
        shareScale(cameras);
    figure.words = takeShared(figure.panels);
    for (std::size_t n = 0; n < cameras.size(); ++n) {
        FittedPanel& panel = figure.panels[n];
        panel.camera = cameras[n];
        if (arguments.panelLetters)
            panel.annotations.title = letterOf(static_cast<int>(n)) +
                                      (panel.annotations.title.empty() ? "" : "  " + panel.annotations.title);
    }
    figure.grid = gridOf(static_cast<int>(cameras.size()), arguments.columns, arguments.gap, size);
    figure.grid.above = heightOf(figure.words.title, figure.words, figure.grid.size().x);
    figure.grid.below = heightOf(figure.words.caption, figure.words, figure.grid.size().x);

    MemoryBudget ram("RAM", "--ram", budgetBytes(arguments.ram, "--ram", common));
    const Charge charge = ram.charge(bytesOf(figure.grid), "the figure");
    for (FittedPanel& panel : figure.panels)
        panel.arguments.ram = std::to_string(ram.limitBytes() - charge.bytes());
    drawPanels(figure, arguments, common, ram, withTask);
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
        const FittedPanel& panel = figure.panels[static_cast<std::size_t>(n)];
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
    return {{"columns", grid.columns},
            {"gap", grid.gap},
            {"panelSize", {grid.panelSize.x, grid.panelSize.y}},
            {"above", grid.above},
            {"below", grid.below},
            {"title", figure.words.title},
            {"caption", figure.words.caption},
            {"textPoints", figure.words.textPoints},
            {"dpi", figure.words.dpi},
            {"oneScale", figure.oneScale}};
}

PanelFigure figureOfJson(const nlohmann::json& said, int panels, const std::string& where) {
    const auto wrong = [&] { return badFile(where, "\"figure\" as tessera writes it", "another"); };
    PanelFigure figure;
    try {
        PanelGrid& grid = figure.grid;
        const auto within = [&](int number, int most) {
            return number >= 0 && number <= most ? number : throw wrong();
        };
        grid.panelSize = {within(said.at("panelSize").at(0).get<int>(), Scene::kMaxImageExtent),
                          within(said.at("panelSize").at(1).get<int>(), Scene::kMaxImageExtent)};
        grid = gridOf(panels, within(said.at("columns").get<int>(), panels),
                      within(said.at("gap").get<int>(), Scene::kMaxImageExtent), grid.panelSize);
        grid.above = within(said.at("above").get<int>(), Scene::kMaxImageExtent);
        grid.below = within(said.at("below").get<int>(), Scene::kMaxImageExtent);
        figure.words.title = said.at("title").get<std::string>();
        figure.words.caption = said.at("caption").get<std::string>();
        figure.words.textPoints = said.at("textPoints").get<double>();
        figure.words.dpi = said.at("dpi").get<double>();
        // As scenes have them (core/scene/annotation_fields.cpp).
        constexpr std::size_t kMostLetters = 1000;
        const auto isWithin = [](double number, double least, double most) {
            return number >= least && number <= most;
        };
        if (!isWithin(figure.words.textPoints, 1, 200) || !isWithin(figure.words.dpi, 10, 10000) ||
            figure.words.title.size() > kMostLetters || figure.words.caption.size() > kMostLetters)
            throw wrong();
        figure.oneScale = said.at("oneScale").get<bool>();
    } catch (const nlohmann::json::exception&) {
        throw wrong();
    }
    return figure;
}

} // namespace tessera
