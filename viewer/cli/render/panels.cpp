// viewer/cli/render/panels.cpp: see panels.h.
#include "viewer/cli/render/panels.h"

#include "core/base/error.h"
#include "core/base/names.h"
#include "viewer/annotations/panel_sheet.h" // kMostPanels

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <sstream>

namespace tessera {
namespace {

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

void shareScale(std::vector<Camera>& cameras) {
    const auto sizeOf = [](const Camera& camera) { // half the height of what it shows at its focal point
        return camera.projection == Projection::parallel ? camera.parallelScale
                                                         : glm::length(camera.position - camera.focalPoint) *
                                                               std::tan(glm::radians(camera.viewAngle) / 2);
    };
    for (const Projection projection : {Projection::parallel, Projection::perspective}) {
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
}

} // namespace tessera
