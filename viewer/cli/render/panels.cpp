// viewer/cli/render/panels.cpp: see panels.h.
#include "viewer/cli/render/panels.h"

#include "core/base/error.h"
#include "core/base/names.h"
#include "core/scene/scene.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <sstream>

namespace tessera {
namespace {

constexpr const char* kPanelOption = "--panel";
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
    return glm::ivec2(columns, rows()) * (panelSize + gap) - gap + glm::ivec2(0, above + below);
}

glm::ivec2 PanelGrid::at(int panel) const {
    return glm::ivec2(panel % columns, panel / columns) * (panelSize + gap) + glm::ivec2(0, above);
}

PanelGrid gridOf(int panels, int columns, int gap, const glm::ivec2& panelSize) {
    const int square = static_cast<int>(std::ceil(std::sqrt(static_cast<double>(panels))));
    const int chosen = columns > 0 ? columns : panels <= kMostInARow ? panels : square;
    PanelGrid grid{panels, std::min(chosen, panels), gap, panelSize};
    checkSize(grid);
    return grid;
}

void checkSize(const PanelGrid& grid) {
    // In 64 bits, for a side is refused before it overflows.
    const auto side = [&](std::int64_t count, int length) { return count * (length + grid.gap) - grid.gap; };
    const std::int64_t width = side(grid.columns, grid.panelSize.x),
                       height = side(grid.rows(), grid.panelSize.y) + grid.above + grid.below;
    if (width > Scene::kMaxImageExtent || height > Scene::kMaxImageExtent)
        throw badFile(kPanelOption,
                      "a figure of at most " + std::to_string(Scene::kMaxImageExtent) + " pixels a side",
                      std::to_string(width) + " x " + std::to_string(height));
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

} // namespace tessera
