// viewer/cli/render/panels.cpp: see panels.h.
#include "viewer/cli/render/panels.h"

#include "core/base/error.h"
#include "core/base/names.h"
#include "core/base/output_file.h"
#include "render/picture/render_scene.h"
#include "render/plan/frame_plan.h"
#include "render/plan/fusion.h" // resolved
#include "viewer/cli/manifest/manifest.h"
#include "viewer/cli/render/picture_files.h"
#include "viewer/cli/render/picture_notes.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <nlohmann/json.hpp>
#include <sstream>
#include <utility>
#include <variant>

namespace tessera {
namespace {

constexpr const char* kPanelOption = "--panel";
constexpr std::size_t kMostPanels = 400;
constexpr int kMostInARow = 3;

std::vector<std::string> split(const std::string& text, char between) {
    std::vector<std::string> parts;
    std::istringstream stream(text);
    for (std::string part; std::getline(stream, part, between);)
        parts.push_back(part);
    if (text.empty() || text.back() == between)
        parts.emplace_back();
    return parts;
}

InputError refused(const std::string& found) {
    return badFile(kPanelOption,
                   joinNames(viewNames()) + ", TURN,RISE, a scene (.json), a volume, or KEY=VALUE",
                   "\"" + found.substr(0, 100) + "\"");
}

bool isView(const std::string& text) {
    try {
        parseName<View>(text, kPanelOption);
        return true;
    } catch (const InputError&) {
        return false;
    }
}

/// "30,10", "-20,0".
bool isAngles(const std::string& text) {
    const std::vector<std::string> parts = split(text, ',');
    return parts.size() == 2 && std::ranges::all_of(parts, [](const std::string& part) {
               char* end = nullptr;
               std::strtod(part.c_str(), &end);
               return !part.empty() && *end == '\0';
           });
}

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
    checkPictureOutput(a.out);
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
struct Figure {
    PanelGrid grid;
    Image image;
    std::optional<glm::vec3> background; // of the first panel: also between panels
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
};

/// As its picture would have it.
Camera cameraOf(const RenderTask& task) {
    return std::get<Camera>(
        resolved(task.scene, task.stores, task.ram, task.options.threads, kPictureBytesPerPixel).camera);
}

/// Draws a panel into the figure.
void drawPanel(const RenderTask& task, int panel, Figure& figure) {
    RenderOptions options = task.options;
    options.progress = task.common.progress.get();
    const RenderResult result = renderScene(task.scene, task.stores, task.ram, task.gpu, options);
    noteTable(task, result);
    figure.panels.push_back(makeManifest(task.scene, task.stores, result, task.ram, task.gpu));
    if (isBlank(result.image)) {
        ++figure.blank;
        warnBlank(task, result);
    } else {
        noteMissingSurfaces(task, result);
    }
    noteMissedError(task, result);
    if (panel == 0)
        figure.background = task.scene.background;
    figure.put(panel, result.image, task.scene.background);
}

} // namespace

std::vector<Panel> panelsOf(const std::vector<std::string>& texts) {
    std::vector<Panel> panels;
    for (const std::string& text : texts) {
        std::error_code ignored;
        if (text.find('=') != std::string::npos) {
            panels.push_back({.sets = split(text, ';')});
        } else if (isAngles(text)) {
            panels.push_back({.view = text});
        } else if (std::filesystem::exists(text, ignored)) {
            panels.push_back({.scene = text});
        } else {
            for (const std::string& side : split(text, ','))
                if (isView(side))
                    panels.push_back({.view = side});
                else if (std::filesystem::exists(side, ignored))
                    panels.push_back({.scene = side});
                else
                    throw refused(side);
        }
    }
    if (panels.size() > kMostPanels)
        throw badFile(kPanelOption, "at most " + std::to_string(kMostPanels) + " panels",
                      std::to_string(panels.size()));
    return panels;
}

glm::ivec2 PanelGrid::size() const {
    return glm::ivec2(columns, rows()) * (panelSize + gap) - gap;
}

glm::ivec2 PanelGrid::at(int panel) const {
    return glm::ivec2(panel % columns, panel / columns) * (panelSize + gap);
}

PanelGrid gridOf(int panels, int columns, int gap, const glm::ivec2& panelSize) {
    const int square = static_cast<int>(std::ceil(std::sqrt(static_cast<double>(panels))));
    const int chosen = columns > 0 ? columns : panels <= kMostInARow ? panels : square;
    PanelGrid grid{panels, std::min(chosen, panels), gap, panelSize};
    const int rows = grid.rows(); // in 64 bits, for a side is refused before it overflows
    const auto side = [&](std::int64_t count, int length) { return count * (length + gap) - gap; };
    if (side(grid.columns, panelSize.x) > Scene::kMaxImageExtent ||
        side(rows, panelSize.y) > Scene::kMaxImageExtent)
        throw badFile(kPanelOption,
                      "a figure of at most " + std::to_string(Scene::kMaxImageExtent) + " pixels a side",
                      std::to_string(side(grid.columns, panelSize.x)) + " x " +
                          std::to_string(side(rows, panelSize.y)));
    return grid;
}

void shareScale(std::vector<Camera>& cameras) {
    if (cameras.empty())
        return;
    const Projection projection = cameras.front().projection;
    const auto sizeOf = [](const Camera& camera) { // half the height of what it shows at its focal point
        return camera.projection == Projection::parallel ? camera.parallelScale
                                                         : glm::length(camera.position - camera.focalPoint) *
                                                               std::tan(glm::radians(camera.viewAngle) / 2);
    };
    double most = 0;
    for (const Camera& camera : cameras)
        if (camera.projection == projection)
            most = std::max(most, sizeOf(camera));
    for (Camera& camera : cameras) {
        if (camera.projection != projection || !(sizeOf(camera) > 0))
            continue;
        if (projection == Projection::parallel)
            camera.parallelScale = most;
        else
            camera.position =
                camera.focalPoint + (camera.position - camera.focalPoint) * (most / sizeOf(camera));
    }
}

void renderPanels(const RenderArguments& arguments, const CommonOptions& common, const WithTask& withTask) {
    checkPanelOptions(arguments);
    const std::vector<Panel> panels = panelsOf(arguments.panels);
    const int count = static_cast<int>(panels.size());
    CommonOptions quiet = common; // what is told when a panel is drawn is not told when it is fitted
    quiet.quiet = true;
    std::vector<Camera> cameras;
    glm::ivec2 size{0};
    for (const Panel& panel : panels)
        withTask(argumentsOf(panel, arguments), quiet, [&](const RenderTask& task) {
            if (size != glm::ivec2(0) && size != task.scene.imageSize)
                throw badFile(kPanelOption, "panels of one size (--size)", "others");
            size = task.scene.imageSize;
            cameras.push_back(cameraOf(task));
        });
    if (!arguments.ownScales)
        shareScale(cameras);

    Figure figure{gridOf(count, arguments.columns, arguments.gap, size), {}, {}, nlohmann::json::array()};
    MemoryBudget ram("RAM", "--ram", budgetBytes(arguments.ram, "--ram", common));
    const glm::ivec2 whole = figure.grid.size();
    const std::size_t bytes =
        kPictureBytesPerPixel * static_cast<std::size_t>(whole.x) * static_cast<std::size_t>(whole.y);
    const Charge charge = ram.charge(bytes, "the figure");
    figure.image = Image(whole);
    for (int n = 0; n < count; ++n) {
        RenderArguments one = argumentsOf(panels[static_cast<std::size_t>(n)], arguments);
        one.ram = std::to_string(ram.limitBytes() - bytes);
        withTask(one, common, [&](const RenderTask& whole) {
            RenderTask task = whole;
            task.scene.camera = cameras[static_cast<std::size_t>(n)];
            drawPanel(task, n, figure);
        });
    }
    const auto clear = [&](int x, int y) { // between panels, and where a row has fewer
        const glm::ivec2 pitch = figure.grid.panelSize + figure.grid.gap;
        return x % pitch.x >= figure.grid.panelSize.x || y % pitch.y >= figure.grid.panelSize.y ||
               y / pitch.y * figure.grid.columns + x / pitch.x >= count;
    };
    if (figure.background)
        for (int y = 0; y < whole.y; ++y)
            for (int x = 0; x < whole.x; ++x)
                if (clear(x, y))
                    figure.image.at(x, y) = glm::vec4(*figure.background, 1);
    common.progress->stage("writing the figure");
    nlohmann::json report = {{"tesseraManifest", 1},
                             {"notice", "not for diagnosis"},
                             {"program", "tessera " TESSERA_VERSION},
                             {"figure",
                              {{"columns", figure.grid.columns},
                               {"gap", figure.grid.gap},
                               {"panelSize", {size.x, size.y}},
                               {"oneScale", !arguments.ownScales}}},
                             {"panels", figure.panels}};
    writePicture(arguments.out, figure.image, figure.background, manifestText(report));
    common.progress->end();
    if (arguments.json) {
        report["output"] = arguments.out;
        report["blank"] = figure.blank == count;
        printReport(report);
    }
    finishStandardOutput();
    common.note("wrote " + arguments.out + ": " + std::to_string(whole.x) + " x " + std::to_string(whole.y) +
                ", " + std::to_string(count) + " panels");
}

} // namespace tessera
