// viewer/cli/render/panel_figure.cpp: see panel_figure.h.
#include "viewer/cli/render/panel_figure.h"

#include "core/base/error.h"
#include "core/base/output_file.h"
#include "render/plan/frame_plan.h" // kPictureBytesPerPixel
#include "render/plan/fusion.h"     // resolved
#include "viewer/annotations/figure.h"
#include "viewer/annotations/figure_file.h"
#include "viewer/annotations/figure_page.h"
#include "viewer/annotations/figure_part.h"
#include "viewer/cli/render/one_picture.h"
#include "viewer/cli/render/picture_files.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace tessera {
namespace {

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
            throw badFile(kPanelOption, std::string("no ") + option + " with it", option);
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

/// With the camera and the functions that its picture would have.
Scene shownScene(const RenderTask& task) {
    return resolved(task.scene, task.stores, task.ram, task.options.threads, kPictureBytesPerPixel);
}

/// The function that "auto" means in a picture; none: another one is asked for.
std::optional<TransferFunction> automaticFunction(const Scene& asked, const Scene& shown) {
    const auto* const name = std::get_if<std::string>(&asked.volumes.front().transferFunction);
    const auto* const function = std::get_if<TransferFunction>(&shown.volumes.front().transferFunction);
    if (!name || *name != "auto" || !function || reductionOf(asked) != Reduction::composite)
        return std::nullopt;
    return *function;
}

/// A manifest of what the figure left out beside what its panels did, which was told.
nlohmann::json ofNoPanel(const nlohmann::json& report) {
    nlohmann::json left = nlohmann::json::array();
    for (const nlohmann::json& what :
         report.value("annotations", nlohmann::json::object()).value("leftOut", nlohmann::json::array()))
        if (std::ranges::none_of(report.at("panels"), [&](const nlohmann::json& panel) {
                const auto told = panel.find("annotations");
                return told != panel.end() &&
                       std::ranges::count(told->value("leftOut", nlohmann::json::array()), what) > 0;
            }))
            left.push_back(what);
    return left.empty() ? nlohmann::json::object()
                        : nlohmann::json::object({{"annotations", {{"leftOut", left}}}});
}

/// Draws a panel into the figure. Returns whether it shows anything.
bool drawPanel(const RenderTask& whole, const FittedPanel& fitted, PanelSheet& sheet) {
    RenderTask task = whole;
    if (fitted.camera)
        task.scene.camera = *fitted.camera;
    task.scene.annotations = fitted.annotations;
    task.strips = sheet.strips();
    bool shows = false;
    task.take = [&](const RenderTask& drawn, RenderResult& result, const Figure& figure,
                    const nlohmann::json& manifest) {
        shows = !isBlank(result.image);
        sheet.put(result.image, figure.parts.front(), drawn.scene.background, manifest);
    };
    renderOnePicture(task);
    return shows;
}

} // namespace

void renderPanels(const RenderArguments& arguments, const CommonOptions& common, const WithTask& withTask) {
    checkPanelOptions(arguments);
    PanelFigure figure;
    for (const Panel& panel : panelsOf(arguments.panels))
        figure.panels.push_back({argumentsOf(panel, arguments), std::nullopt, {}});
    PanelLayout& layout = figure.layout;
    layout.oneScale = !arguments.fitEach;
    layout.letters = arguments.panelLetters;
    const glm::ivec2 size = fitPanels(figure, common, withTask);
    std::vector<Annotations*> words;
    for (FittedPanel& panel : figure.panels)
        words.push_back(&panel.annotations);
    layout.words = takeShared(words);
    layout.grid =
        gridOf(static_cast<int>(figure.panels.size()), arguments.columns, arguments.gap, size, kPanelOption);
    fitStrips(figure, common, withTask);
    makeRoomForWords(layout, kPanelOption);

    MemoryBudget ram("RAM", "--ram", budgetBytes(arguments.ram, "--ram", common));
    const Charge charge = ram.charge(bytesOf(layout.grid), "the figure");
    for (FittedPanel& panel : figure.panels)
        panel.arguments.ram = std::to_string(ram.limitBytes() - charge.bytes());
    drawPanels(figure, arguments, common, ram, withTask);
}

glm::ivec2 fitPanels(PanelFigure& figure, const CommonOptions& common, const WithTask& withTask) {
    CommonOptions quiet = common; // what is told when a panel is drawn is not told when it is fitted
    quiet.quiet = true;
    std::vector<Camera> cameras;
    std::vector<TransferFunction> functions; // where "auto" is asked for
    glm::ivec2 size{0};
    for (FittedPanel& panel : figure.panels)
        withTask(panel.arguments, quiet, [&](const RenderTask& task) {
            if (size != glm::ivec2(0) && size != task.scene.imageSize)
                throw badFile(kPanelOption, "panels of one size (--size)", "others");
            size = task.scene.imageSize;
            const Scene shown = shownScene(task);
            cameras.push_back(std::get<Camera>(shown.camera));
            if (auto function = automaticFunction(task.scene, shown))
                functions.push_back(*std::move(function));
            panel.annotations = task.scene.annotations;
        });
    if (std::ranges::any_of(functions, [&](const auto& one) { return one != functions.front(); }))
        common.note("panels have other functions, each by its volume's values (preset auto): a preset of "
                    "values, or a "
                    "function in the scene, is the same in all");
    if (figure.layout.oneScale)
        shareScale(cameras);
    for (std::size_t n = 0; n < cameras.size(); ++n)
        figure.panels[n].camera = cameras[n];
    return size;
}

void fitStrips(PanelFigure& figure, const CommonOptions& common, const WithTask& withTask) {
    PanelLayout& layout = figure.layout;
    layout.grid.strips = {};
    CommonOptions quiet = common;
    quiet.quiet = true;
    for (const FittedPanel& panel : figure.panels)
        if (panel.annotations.margin != AnnotationMargin::none)
            withTask(panel.arguments, quiet, [&](const RenderTask& task) {
                Scene scene = task.scene;
                if (panel.camera)
                    scene.camera = *panel.camera;
                scene.annotations = panel.annotations;
                const FigureMaker maker(scene, task.stores, task.ram, task.options.threads);
                FigurePart part = maker.partToCome(scene);
                part.mark = layout.letters ? "A" : "";
                layout.grid.strips = larger(layout.grid.strips, stripsOf(part, scene.annotations.dpi));
            });
    checkSize(layout.grid, kPanelOption);
}

void drawPanels(const PanelFigure& figure, const RenderArguments& arguments, const CommonOptions& common,
                MemoryBudget& ram, const WithTask& withTask) {
    const PanelGrid& grid = figure.layout.grid;
    PanelSheet sheet(figure.layout);
    bool shows = false;
    for (std::size_t n = 0; n < figure.panels.size(); ++n) {
        const FittedPanel& panel = figure.panels[n];
        RenderArguments one = panel.arguments;
        one.json = false;
        CommonOptions ofPanel = common;
        ofPanel.prefix += "panel " + std::to_string(n + 1) + ": ";
        withTask(one, ofPanel, [&](const RenderTask& task) { shows |= drawPanel(task, panel, sheet); });
    }
    common.progress->stage("writing the figure");
    nlohmann::json report = sheet.write(arguments.out, ram);
    common.progress->end();
    if (const std::string left = leftOutText(ofNoPanel(report)); !left.empty())
        common.note(left);
    if (arguments.json) {
        report["output"] = arguments.out;
        report["blank"] = !shows;
        printReport(report);
        finishStandardOutput();
    }
    common.note("wrote " + arguments.out + ": " + std::to_string(grid.size().x) + " x " +
                std::to_string(grid.size().y) + ", " + std::to_string(grid.panels) + " panels");
}

} // namespace tessera
