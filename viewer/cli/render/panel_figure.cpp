// viewer/cli/render/panel_figure.cpp: see panel_figure.h.
#include "viewer/cli/render/panel_figure.h"

#include "core/base/error.h"
#include "core/base/output_file.h"
#include "render/plan/frame_plan.h"
#include "render/plan/fusion.h" // resolved
#include "viewer/annotations/figure_file.h"
#include "viewer/annotations/figure_part.h"
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

/// What is known of a panel before it is drawn.
struct Fitted {
    Camera camera;
    Annotations annotations;
};

/// As its picture would have it.
Camera cameraOf(const RenderTask& task) {
    return std::get<Camera>(
        resolved(task.scene, task.stores, task.ram, task.options.threads, kPictureBytesPerPixel).camera);
}

/// Words that all panels have stand once, above and below all of them.
struct SharedWords {
    Annotations all = {};

    explicit SharedWords(const std::vector<Fitted>& panels) {
        const auto shared = [&](std::string Annotations::*words) {
            const std::string& first = panels.front().annotations.*words;
            const bool same = std::ranges::all_of(
                panels, [&](const Fitted& panel) { return panel.annotations.*words == first; });
            return same ? first : std::string();
        };
        all.title = shared(&Annotations::title);
        all.caption = shared(&Annotations::caption);
        all.textPoints = panels.front().annotations.textPoints;
        all.dpi = panels.front().annotations.dpi;
    }
    Annotations without(Annotations panel) const {
        if (!all.title.empty())
            panel.title.clear();
        if (!all.caption.empty())
            panel.caption.clear();
        return panel;
    }
    /// Room for lines of them, pixels.
    int height(const std::string& words, int width) const {
        constexpr double kLetterWidth = 0.62, kLine = 1.4, kMargins = 2; // parts of a letter's height
        if (words.empty())
            return 0;
        const double letter = all.textPoints / 72 * all.dpi;
        const double lines = std::ceil(kLetterWidth * letter * static_cast<double>(words.size()) /
                                       std::max(1.0, width - kMargins * letter));
        return static_cast<int>(std::ceil(letter * (kLine * lines + kMargins)));
    }
    /// Beside the panels of a figure.
    void addTo(Figure& figure) const {
        FigurePart part;
        part.size = figure.size;
        part.annotations = all;
        part.orientationKnown = false;
        part.onLight = figure.parts.front().onLight;
        figure.parts.push_back(part);
    }
};

/// "A", "B", ... "Z", "AA".
std::string letterOf(int panel) {
    constexpr int kLetters = 26;
    return (panel < kLetters ? std::string() : letterOf(panel / kLetters - 1)) +
           static_cast<char>('A' + panel % kLetters);
}

/// Draws a panel into the figure.
void drawPanel(const RenderTask& whole, const Fitted& fitted, int panel, Sheet& sheet) {
    RenderTask task = whole;
    task.scene.camera = fitted.camera;
    task.scene.annotations = fitted.annotations;
    task.take = [&](const RenderTask& drawn, RenderResult& result, const nlohmann::json& manifest) {
        const FigureMaker maker(drawn.scene, drawn.stores, drawn.ram, drawn.options.threads);
        FigurePart part = maker.part(drawn.scene, result);
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
    const std::vector<Panel> panels = panelsOf(arguments.panels);
    const int count = static_cast<int>(panels.size());
    CommonOptions quiet = common; // what is told when a panel is drawn is not told when it is fitted
    quiet.quiet = true;
    std::vector<Fitted> fitted;
    glm::ivec2 size{0};
    for (const Panel& panel : panels)
        withTask(argumentsOf(panel, arguments), quiet, [&](const RenderTask& task) {
            if (size != glm::ivec2(0) && size != task.scene.imageSize)
                throw badFile(kPanelOfFigure, "panels of one size (--size)", "others");
            size = task.scene.imageSize;
            fitted.push_back({cameraOf(task), task.scene.annotations});
        });
    if (!arguments.ownScales) {
        std::vector<Camera> cameras;
        for (const Fitted& panel : fitted)
            cameras.push_back(panel.camera);
        shareScale(cameras);
        for (std::size_t n = 0; n < cameras.size(); ++n)
            fitted[n].camera = cameras[n];
    }
    const SharedWords words(fitted);
    for (std::size_t n = 0; n < fitted.size(); ++n) {
        Annotations& own = fitted[n].annotations = words.without(fitted[n].annotations);
        if (arguments.panelLetters)
            own.title = letterOf(static_cast<int>(n)) + (own.title.empty() ? "" : "  " + own.title);
    }

    Sheet sheet;
    sheet.grid = gridOf(count, arguments.columns, arguments.gap, size);
    sheet.grid.above = words.height(words.all.title, sheet.grid.size().x);
    sheet.grid.below = words.height(words.all.caption, sheet.grid.size().x);
    MemoryBudget ram("RAM", "--ram", budgetBytes(arguments.ram, "--ram", common));
    const glm::ivec2 whole = sheet.grid.size();
    const std::size_t bytes =
        kPictureBytesPerPixel * static_cast<std::size_t>(whole.x) * static_cast<std::size_t>(whole.y);
    const Charge charge = ram.charge(bytes, "the figure");
    sheet.image = Image(whole);
    sheet.figure.size = whole;
    sheet.figure.dpi = words.all.dpi;
    for (int n = 0; n < count; ++n) {
        RenderArguments one = argumentsOf(panels[static_cast<std::size_t>(n)], arguments);
        one.ram = std::to_string(ram.limitBytes() - bytes);
        one.json = false;
        withTask(one, common, [&](const RenderTask& task) {
            drawPanel(task, fitted[static_cast<std::size_t>(n)], n, sheet);
        });
    }
    sheet.fillRest();
    words.addTo(sheet.figure);
    common.progress->stage("writing the figure");
    nlohmann::json report = {{"tesseraManifest", 1},
                             {"notice", "not for diagnosis"},
                             {"program", "tessera " TESSERA_VERSION},
                             {"figure",
                              {{"columns", sheet.grid.columns},
                               {"gap", sheet.grid.gap},
                               {"panelSize", {size.x, size.y}},
                               {"above", sheet.grid.above},
                               {"below", sheet.grid.below},
                               {"title", words.all.title},
                               {"caption", words.all.caption},
                               {"oneScale", !arguments.ownScales}}},
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
    }
    finishStandardOutput();
    common.note("wrote " + arguments.out + ": " + std::to_string(whole.x) + " x " + std::to_string(whole.y) +
                ", " + std::to_string(count) + " panels");
}

} // namespace tessera
