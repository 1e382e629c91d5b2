// viewer/window/overlays.cpp: see overlays.h.
#include "viewer/window/overlays.h"

#include "core/base/brick.h"
#include "core/base/shown_text.h"
#include "core/image/colour.h"
#include "viewer/session/view_geometry.h"
#include "viewer/window/beside.h"
#include "viewer/window/label_panel.h"
#include "viewer/window/part_drawing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <imgui.h>
#include <iterator>
#include <string>
#include <variant>

namespace tessera {
namespace {

constexpr ImU32 kText = IM_COL32(235, 235, 235, 255), kFaint = IM_COL32(235, 235, 235, 130),
                kWarning = IM_COL32(255, 190, 70, 255);

void text(ImDrawList& draw, const ImVec2& at, ImU32 colour, const std::string& words) {
    draw.AddText({at.x + 1, at.y + 1}, IM_COL32(0, 0, 0, 200), words.c_str());
    draw.AddText(at, colour, words.c_str());
}

} // namespace

std::string samplesText(const ShownPicture& picture) {
    if (!picture.samples)
        return {};
    const SamplesSeen& seen = *picture.samples;
    return "paths: " + std::to_string(seen.taken) + " of " + std::to_string(seen.asked) + " samples a pixel" +
           (seen.noise ? ", noise " + numberText(*seen.noise, 2) : "");
}

namespace {

/// The picture's quality, unless it is final.
std::string badge(const WindowState& desk) {
    const ShownPicture* const picture = desk.picture();
    const ViewingState& s = desk.state();
    if (s.damagedChunks > 0)
        return std::to_string(s.damagedChunks) +
               (s.damagedChunks == 1 ? " damaged part of the store is" : " damaged parts of the store are") +
               " drawn from coarser levels";
    if (!picture)
        return {};
    switch (picture->stage) {
    case Stage::moving:
        return "coarse";
    case Stage::loading:
        return s.movesLeft == 1  ? "coarse: 1 brick is loading"
               : s.movesLeft > 1 ? "coarse: " + std::to_string(s.movesLeft) + " bricks are loading"
                                 : (s.lightIsCoarse ? "coarse light" : "coarse: levels are being chosen");
    case Stage::whole: {
        const bool paths =
            desk.scene().lighting.transport && reductionOf(desk.scene()) == Reduction::composite;
        const std::string has = paths ? "light without paths" : "one ray a pixel";
        return s.drawingStill ? has + "; the still is being drawn"
               : s.noStills   ? has + ": --ram is too small for a still of this volume"
                              : has;
    }
    case Stage::round:
        return samplesText(*picture);
    case Stage::still:
        return {};
    }
    return {};
}

/// From the finest level, green, to bricks that stand as one value, red.
constexpr ImU32 kLevelColours[] = {IM_COL32(70, 220, 110, 200), IM_COL32(170, 220, 60, 200),
                                   IM_COL32(240, 210, 50, 200), IM_COL32(250, 150, 40, 200),
                                   IM_COL32(240, 90, 60, 200),  IM_COL32(220, 50, 80, 200)};

/// A mark in the middle of every brick that shows something, as large as a fifth of it.
void drawLevels(ImDrawList& draw, const WindowState& desk, const Area& area) {
    const ViewingState& s = desk.state();
    const VolumeInfo& info = desk.volume()->info;
    const glm::ivec3 grid = s.brickGrid;
    const double edge =
        kBrickExtent * std::cbrt(std::abs(glm::determinant(glm::dmat3(info.patientFromVoxel))));
    const glm::dmat3 axes = patientFromCamera(desk.camera());
    std::size_t n = 0;
    for (int z = 0; z < grid.z; ++z)
        for (int y = 0; y < grid.y; ++y)
            for (int x = 0; x < grid.x; ++x, ++n) {
                const std::uint8_t level = (*s.levels)[n];
                if (level >= std::size(kLevelColours))
                    continue; // shows nothing
                const glm::dvec3 voxel = static_cast<double>(kBrickExtent) * (glm::dvec3(x, y, z) + 0.5);
                const glm::dvec3 mm(info.patientFromVoxel * glm::dvec4(voxel, 1));
                glm::dvec2 middle(0), beside(0);
                if (!pictureFromPatient(desk.camera(), area.pixels(), mm, middle) ||
                    !pictureFromPatient(desk.camera(), area.pixels(), mm + 0.1 * edge * axes[0], beside))
                    continue;
                const auto half = static_cast<float>(
                    std::clamp(glm::length(beside - middle) / area.pixelsPerUnit, 1.0, 12.0));
                const glm::dvec2 at = area.from + middle / area.pixelsPerUnit;
                const ImVec2 p(static_cast<float>(at.x), static_cast<float>(at.y));
                draw.AddRectFilled({p.x - half, p.y - half}, {p.x + half, p.y + half}, kLevelColours[level]);
            }
    for (std::size_t level = 0; level < std::size(kLevelColours); ++level) {
        const ImVec2 p(static_cast<float>(area.from.x) + 14,
                       static_cast<float>(area.from.y) + 36 + 18 * static_cast<float>(level));
        draw.AddRectFilled(p, {p.x + 10, p.y + 10}, kLevelColours[level]);
        text(draw, {p.x + 16, p.y - 3}, kText, level == 5 ? "one value" : "level " + std::to_string(level));
    }
}

ImVec2 at(const glm::dvec2& place) {
    return {static_cast<float>(place.x), static_cast<float>(place.y)};
}

/// The value under the pointer, and a ring around its place.
/// @param name  of its scan, where there are two; "": none
void drawPointed(ImDrawList& draw, const Area& area, const Camera& camera, const VolumeSeen& volume,
                 const PickedPlace& picked, const std::string& name) {
    char place[96];
    std::snprintf(place, sizeof place, " at %.1f, %.1f, %.1f mm%s", picked.mm.x, picked.mm.y, picked.mm.z,
                  picked.level > 0 ? " (coarse)" : "");
    const std::string labels = labelNames(volume, picked);
    text(draw, at(area.from + glm::dvec2(12, area.size.y - 22)), kText,
         name + (name.empty() ? "" : ": ") +
             (picked.mesh.empty() ? valueText(picked.value, volume.info.unit) : picked.mesh) + place +
             (labels.empty() ? "" : ", ") + labels);
    glm::dvec2 pixel(0);
    if (pictureFromPatient(camera, area.pixels(), picked.mm, pixel))
        draw.AddCircle(at(area.from + pixel / area.pixelsPerUnit), 4, kWarning, 0, 1.5f);
}

/// Where the place under the pointer is in the other scan.
void drawCross(ImDrawList& draw, const Area& area, const Camera& camera, const glm::dvec3& mm) {
    constexpr double kFrom = 4, kTo = 14; // open in the middle
    glm::dvec2 pixel(0);
    if (!pictureFromPatient(camera, area.pixels(), mm, pixel))
        return;
    const glm::dvec2 middle = area.from + pixel / area.pixelsPerUnit;
    for (const glm::dvec2& way : {glm::dvec2(1, 0), glm::dvec2(-1, 0), glm::dvec2(0, 1), glm::dvec2(0, -1)})
        draw.AddLine(at(middle + kFrom * way), at(middle + kTo * way), kWarning, 1.5f);
}

} // namespace

void drawBeside(const Beside& beside, const WindowState& desk, const Area& area, const PictureHand& hand) {
    constexpr float kMargin = 14, kTop = 12, kOfCube = 70; // what is left to the directions, at the right
    ImDrawList& draw = *ImGui::GetBackgroundDrawList();
    const ImVec2 from = at(area.from), end = at(area.from + area.size);
    draw.AddLine({from.x - 1, from.y}, {from.x - 1, end.y}, IM_COL32(235, 235, 235, 130), 2);
    draw.PushClipRect(from, end);
    const std::string words = beside.about(desk);
    for (const bool shade : {true, false})
        draw.AddText(ImGui::GetFont(), ImGui::GetFontSize(),
                     {from.x + kMargin + (shade ? 1.0f : 0.0f), from.y + kTop + (shade ? 1.0f : 0.0f)},
                     shade ? IM_COL32(0, 0, 0, 200) : kText, words.c_str(), nullptr,
                     end.x - from.x - kMargin - kOfCube);
    const VolumeSeen* const volume = beside.volume();
    if (const Camera* const seen = beside.camera(); seen && volume && desk.volume()) {
        const Camera& camera = *seen;
        drawPart(draw, area, beside.overlay(desk), kRowOfWords);
        if (const auto& picked = beside.picked();
            picked && picked->hit && hand.isOver() && hand.beside() == &beside)
            drawPointed(draw, area, camera, *volume, *picked, beside.name());
        if (const auto& picked = desk.picked(); picked && picked->hit && hand.isOver() && !hand.beside())
            drawCross(draw, area, camera, picked->mm + beside.shift(desk));
    }
    draw.PopClipRect();
}

void drawOverlays(WindowState& desk, const Area& area, const PictureHand& hand) {
    ImDrawList& draw = *ImGui::GetBackgroundDrawList();
    const auto left = static_cast<float>(area.from.x), top = static_cast<float>(area.from.y),
               right = static_cast<float>(area.from.x + area.size.x),
               bottom = static_cast<float>(area.from.y + area.size.y);
    draw.PushClipRect({left, top}, {right, bottom});
    text(draw, {right - ImGui::CalcTextSize("not for diagnosis").x - 10, bottom - 22}, kFaint,
         "not for diagnosis");
    if (const VolumeSeen* volume = desk.volume()) {
        if (desk.showLevels && desk.state().levels)
            drawLevels(draw, desk, area);
        drawPart(draw, area, desk.overlay(), kRowOfWords);
        if (const std::string words = badge(desk); !words.empty())
            text(draw, {left + 12, top + 10}, kWarning, words);
        const Beside* const beside = hand.isOver() ? hand.beside() : nullptr;
        if (const auto& picked = desk.picked(); picked && picked->hit && hand.isOver() && !beside)
            drawPointed(draw, area, desk.camera(), *volume, *picked,
                        desk.beside() ? volume->path.stem().string() : "");
        if (beside && beside->picked() && beside->picked()->hit)
            drawCross(draw, area, desk.camera(), beside->picked()->mm - beside->shift(desk));
    }
    const ViewingState& s = desk.state();
    const ImVec2 middle((left + right) / 2, (top + bottom) / 2);
    const auto centred = [&](const std::string& words, float y, ImU32 colour) {
        const ImVec2 size = ImGui::CalcTextSize(words.c_str(), nullptr, false, (right - left) * 0.8f);
        draw.AddText(nullptr, 0, {middle.x - size.x / 2, y}, colour, words.c_str(), nullptr,
                     (right - left) * 0.8f);
    };
    if (s.kind == ViewingState::Kind::opening) {
        centred(s.what, middle.y - 30, kText);
        const float half = std::min(200.0f, (right - left) / 3);
        draw.AddRect({middle.x - half, middle.y}, {middle.x + half, middle.y + 12}, kFaint);
        draw.AddRectFilled({middle.x - half, middle.y},
                           {middle.x - half + 2 * half * static_cast<float>(s.share), middle.y + 12}, kText);
    } else if (s.kind == ViewingState::Kind::failed) {
        centred(s.what, top + 0.12f * (bottom - top), kWarning);
    } else if (s.kind == ViewingState::Kind::nothing) {
        centred("drop a DICOM folder, a NIfTI file, a store or a scene here, or choose one",
                top + 0.12f * (bottom - top), kFaint);
    }
    if (const auto& message = desk.message()) {
        const float wrap = (right - left) * 0.8f;
        const ImVec2 size = ImGui::CalcTextSize(message->text.c_str(), nullptr, false, wrap);
        const ImVec2 at(middle.x - size.x / 2, bottom - 60 - size.y);
        draw.AddRectFilled({at.x - 10, at.y - 6}, {at.x + size.x + 10, at.y + size.y + 6},
                           IM_COL32(20, 20, 24, 230), 4);
        draw.AddText(nullptr, 0, at, message->problem ? kWarning : kText, message->text.c_str(), nullptr,
                     wrap);
    }
    draw.PopClipRect();
}

} // namespace tessera
