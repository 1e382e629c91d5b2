// viewer/window/endoscopy_overlay.cpp: the overlay of endoscopy.h on the picture and the planes: lines, the
// lumen's width around them, what was found, and a map of the position.
#include "viewer/session/view_geometry.h"
#include "viewer/window/boxes.h" // drawLabel
#include "viewer/window/endoscopy.h"

#include "core/animation/path.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <imgui.h>

namespace tessera {
namespace {

constexpr ImU32 kLineInk = IM_COL32(255, 110, 160, 220), kBranchInk = IM_COL32(255, 110, 160, 110),
                kHere = IM_COL32(255, 230, 90, 255), kUnseen = IM_COL32(90, 210, 255, 255),
                kCompassInk = IM_COL32(235, 235, 235, 110);
constexpr double kMapShare = 0.26; // of the picture's height
constexpr double kMapMargin = 12;
constexpr double kLeastStep = 3; // of a wall's outline, units of the window

ImVec2 onScreen(const glm::dvec2& p) {
    return {static_cast<float>(p.x), static_cast<float>(p.y)};
}

/// A point of a line and its distance to the wall, in units of the window.
struct OutlinePlace {
    glm::dvec2 at{0};
    double radius = 0; // below 0: hidden
};

/// Both edges of a tube along a line.
/// @param placeOf  of the line's points, by number
void drawOutline(ImDrawList& draw, std::size_t points,
                 const std::function<OutlinePlace(std::size_t)>& placeOf) {
    OutlinePlace last{{}, -1};
    glm::dvec2 lastSide(0);
    for (std::size_t i = 0; i < points; ++i) {
        const OutlinePlace here = placeOf(i);
        if (here.radius < 0 || last.radius < 0) {
            last = here;
            lastSide = glm::dvec2(0);
            continue;
        }
        const glm::dvec2 way = here.at - last.at;
        const double length = glm::length(way);
        if (length < kLeastStep)
            continue;
        const glm::dvec2 side(-way.y / length, way.x / length);
        if (lastSide == glm::dvec2(0))
            lastSide = side;
        for (const double hand : {-1.0, 1.0})
            draw.AddLine(onScreen(last.at + hand * last.radius * lastSide),
                         onScreen(here.at + hand * here.radius * side), kBranchInk, 1);
        last = here;
        lastSide = side;
    }
}

/// The result, a sentence per row, and why it may be wrong.
void drawFound(ImDrawList& draw, const glm::dvec2& from, std::string about, const std::string& doubt) {
    for (std::size_t at = about.find("; "); at != std::string::npos; at = about.find("; ", at))
        about.replace(at, 2, "\n");
    drawLabel(draw, onScreen(from), IM_COL32(235, 235, 235, 255), about);
    const auto height = static_cast<double>(ImGui::CalcTextSize(about.c_str()).y);
    if (!doubt.empty())
        drawLabel(draw, onScreen(from + glm::dvec2(0, height + 6)), IM_COL32(255, 190, 70, 255), doubt);
}

} // namespace

/// From outside, from the front: the volume's box, the lines, and where one is.
void Endoscopy::drawMap(ImDrawList& draw, const WindowState& desk, const Area& area) const {
    const VolumeInfo& info = desk.volume()->info;
    glm::dvec3 low(1e30), high(-1e30);
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 voxel =
            glm::dvec3(info.extentVoxels) * glm::dvec3(corner & 1, corner >> 1 & 1, corner >> 2 & 1);
        const glm::dvec3 mm(info.patientFromVoxel * glm::dvec4(voxel, 1));
        low = glm::min(low, mm);
        high = glm::max(high, mm);
    }
    const double height = kMapShare * area.size.y, scale = height / (high.z - low.z),
                 width = scale * (high.x - low.x);
    const glm::dvec2 corner = area.from + glm::dvec2(kMapMargin, area.size.y - height - 3 * kMapMargin);
    const auto onMap = [&](const glm::dvec3& mm) {
        return corner + scale * glm::dvec2(mm.x - low.x, high.z - mm.z);
    };
    draw.AddRectFilled(onScreen(corner), onScreen(corner + glm::dvec2(width, height)),
                       IM_COL32(10, 12, 16, 190));
    draw.AddRect(onScreen(corner), onScreen(corner + glm::dvec2(width, height)), kCompassInk);
    for (const CentreLine& line : path_->lines)
        for (std::size_t i = 0; i + 1 < line.points.size(); ++i)
            draw.AddLine(onScreen(onMap(line.points[i])), onScreen(onMap(line.points[i + 1])), kLineInk,
                         1.2f);
    for (const UnseenPatch& patch : unseen())
        draw.AddCircle(onScreen(onMap(patch.middleMm)), 2.5f, kUnseen);
    const Camera& camera = desk.camera();
    const glm::dvec2 here = onMap(camera.position);
    const glm::dvec3 forward = -patientFromCamera(camera)[2];
    draw.AddLine(onScreen(here), onScreen(here + 12.0 * glm::dvec2(forward.x, -forward.z)), kHere, 2);
    draw.AddCircleFilled(onScreen(here), 3.5f, kHere);
    if (info.orientationKnown) {
        draw.AddText(onScreen(corner + glm::dvec2(3, height / 2 - 7)), kCompassInk, "R");
        draw.AddText(onScreen(corner + glm::dvec2(width - 12, height / 2 - 7)), kCompassInk, "L");
    }
    char words[48];
    std::snprintf(words, sizeof words, "%.0f of %.0f mm", placeMm_, curve_->lengthMm());
    draw.AddText(onScreen(corner + glm::dvec2(4, -18)), kHere, words);
}

void Endoscopy::drawOnPlane(ImDrawList& draw, const Area& view, const SliceFrame& frame) const {
    if (!path_)
        return;
    constexpr double kNearMm = 1.5;
    const auto near = [&](const glm::dvec3& p) {
        return std::abs(glm::dot(p - frame.pose.point, frame.pose.normal)) <= kNearMm;
    };
    const auto place = [&](const glm::dvec3& p) {
        return view.from + frame.pictureFromPatient(p) / view.pixelsPerUnit;
    };
    for (const CentreLine& line : path_->lines)
        for (std::size_t i = 0; i < line.points.size(); ++i)
            if (near(line.points[i])) {
                draw.AddCircleFilled(onScreen(place(line.points[i])), 1.5f, kLineInk);
                if (i + 1 < line.points.size() && near(line.points[i + 1]))
                    draw.AddLine(onScreen(place(line.points[i])), onScreen(place(line.points[i + 1])),
                                 kLineInk, 1.5f);
            }
    for (const CentreLine& line : path_->lines) {
        const auto apart = [&](std::size_t i) {
            return glm::dot(line.points[i] - frame.pose.point, frame.pose.normal);
        };
        const auto width =
            [&](std::size_t i) { // half the width of the lumen's section by the plane; below 0: none
                const double r = line.radiusMm[i], d = apart(i);
                return r > std::abs(d) ? std::sqrt(r * r - d * d) / frame.mmPerPixel / view.pixelsPerUnit
                                       : -1.0;
            };
        drawOutline(draw, line.points.size(), [&](std::size_t i) {
            return OutlinePlace{place(line.points[i]), width(i)};
        });
        for (std::size_t i = 0; i + 1 < line.points.size(); ++i) // where it goes through
            if ((apart(i) < 0) != (apart(i + 1) < 0) && width(i) > 0)
                draw.AddCircle(onScreen(place(line.points[i])), static_cast<float>(width(i)), kBranchInk);
    }
    for (const UnseenPatch& patch : unseen())
        if (near(patch.middleMm))
            draw.AddCircle(onScreen(place(patch.middleMm)), 4, kUnseen, 0, 1.5f);
}

void Endoscopy::draw(WindowState& desk, const Area& area) const {
    if (!desk.volume())
        return;
    ImDrawList& draw = *ImGui::GetBackgroundDrawList();
    draw.PushClipRect(onScreen(area.from), onScreen(area.from + area.size));
    const auto seen = [&](const glm::dvec3& mm, glm::dvec2& out) {
        glm::dvec2 pixel(0);
        if (!pictureFromPatient(desk.camera(), area.pixels(), mm, pixel))
            return false;
        out = area.from + pixel / area.pixelsPerUnit;
        return true;
    };
    glm::dvec2 a(0), b(0);
    if (path_ && !inside_)
        for (std::size_t n = 0; n < path_->lines.size(); ++n) {
            const auto& route = path_->flight->route;
            const bool flown = std::find(route.begin(), route.end(), n) != route.end();
            const auto& points = path_->lines[n].points;
            for (std::size_t i = 0; i + 1 < points.size(); ++i)
                if (seen(points[i], a) && seen(points[i + 1], b))
                    draw.AddLine(onScreen(a), onScreen(b), flown ? kLineInk : kBranchInk, 2);
        }
    if (path_ && !inside_) {
        const glm::dvec3 right = patientFromCamera(desk.camera())[0];
        for (const CentreLine& line : path_->lines)
            drawOutline(draw, line.points.size(), [&](std::size_t i) {
                OutlinePlace place{{}, -1};
                if (seen(line.points[i], a) && seen(line.points[i] + line.radiusMm[i] * right, b))
                    place = {a, glm::length(b - a)};
                return place;
            });
        drawFound(draw, area.from + glm::dvec2(12, desk.showLevels ? 150 : 36), about_, doubt());
    }
    for (const UnseenPatch& patch : unseen())
        if (seen(patch.middleMm, a))
            draw.AddCircle(onScreen(a), 5, kUnseen, 0, 1.5f);
    for (const glm::dvec3& place : places_)
        if (gathers_ && seen(place, a))
            draw.AddCircleFilled(onScreen(a), 4, kHere);
    if (inside_ && path_ && curve_)
        drawMap(draw, desk, area);
    draw.PopClipRect();
}

} // namespace tessera
