// tests/support/figures.h: figures for tests, and what every layout of one must be.
#pragma once

#include "core/scene/scene.h"
#include "viewer/annotations/figure.h"
#include "viewer/annotations/figure_layout.h"
#include "viewer/session/view_geometry.h"

#include <gtest/gtest.h>
#include <string>
#include <variant>
#include <vector>

namespace tessera::test {

/// Words in a font whose letters are all 0.6 of its size wide.
inline WordSize evenLetters(const std::string& words, double pixels, bool = false) {
    double letters = 0;
    for (const char c : words)
        letters += (static_cast<unsigned char>(c) & 0xC0) != 0x80;
    return {0.6 * pixels * letters, 0.9 * pixels, 0.25 * pixels};
}

/// A figure of one part with all that there is, of a volume of 100 mm around the origin.
inline Figure fullFigure(const glm::ivec2& size, const ViewAngles& angles,
                         Projection projection = Projection::perspective) {
    VolumeInfo info;
    info.extentVoxels = glm::ivec3(100);
    info.patientFromVoxel = glm::dmat4(1);
    info.patientFromVoxel[3] = {-50, -50, -50, 1};
    Figure figure;
    figure.size = size;
    FigurePart part;
    part.size = size;
    part.camera = fitCamera(info, viewAxes(angles), projection, size);
    Annotations& a = part.annotations;
    a.scaleBar = a.legend = a.labelLegend = a.measurements = a.error = true;
    a.directions = Directions::all;
    a.title = "A title";
    a.caption = "A caption of a few words";
    a.arrows = {{{10, -5, 12}, {24, -24}, "a lesion"}};
    LegendBar bar;
    bar.unit = "HU", bar.low = -160, bar.high = 240;
    for (int i = 0; i < 64; ++i)
        bar.colours.emplace_back(i / 63.0, 0.5, 1 - i / 63.0);
    part.legend = {bar};
    part.labels = {{"liver", glm::vec3(0.5f, 0.1f, 0.1f)}, {"spleen", glm::vec3(0.1f, 0.1f, 0.5f)}};
    part.measurements = {{MeasurementKind::distance, {{-20, 0, -20}, {20, 0, -20}}}};
    part.error = "1.2 L*u*v*";
    figure.parts = {part};
    return figure;
}

/// All within the box of one of the figure's parts, and no words over others.
inline void expectApart(const Figure& figure, const FigureLayout& layout) {
    const std::string where = std::to_string(figure.size.x) + " x " + std::to_string(figure.size.y);
    const auto within = [&](const glm::dvec2& from, const glm::dvec2& to) {
        for (const FigurePart& part : figure.parts) {
            const glm::dvec2 a(part.from), b(part.from + part.size);
            if (from.x >= a.x && from.y >= a.y && to.x <= b.x && to.y <= b.y)
                return true;
        }
        return false;
    };
    for (std::size_t i = 0; i < layout.words.size(); ++i) {
        const LaidWords& one = layout.words[i];
        EXPECT_TRUE(within(one.from(), one.to())) << one.words << ", " << where;
        for (std::size_t j = i + 1; j < layout.words.size(); ++j) {
            const LaidWords& other = layout.words[j];
            EXPECT_FALSE(one.from().x < other.to().x && other.from().x < one.to().x &&
                         one.from().y < other.to().y && other.from().y < one.to().y)
                << one.words << " and " << other.words << ", " << where;
        }
    }
    for (const LaidShape& shape : layout.shapes) {
        if (const auto* const area = std::get_if<LaidArea>(&shape)) {
            for (const glm::dvec2& corner : area->corners)
                EXPECT_TRUE(within(corner, corner)) << where;
            continue;
        }
        const auto& lines = std::get<LaidLines>(shape);
        for (const std::vector<glm::dvec2>& points : lines.lines)
            for (const glm::dvec2& point : points)
                EXPECT_TRUE(within(point - lines.edge, point + lines.edge)) << where;
    }
}

} // namespace tessera::test
