// tests/viewer/annotations/figure_drawing_test.cpp: annotations as they are drawn: lengths and colours in the
// picture, and the same over a picture as in a layer of their own.
#include "viewer/annotations/figure_drawing.h"

#include "core/image/colour.h"
#include "core/scene/measurement.h"
#include "tests/support/figures.h"
#include "viewer/annotations/pango_words.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <random>
#include <span>
#include <vector>

namespace tessera {
namespace {

using test::fullFigure;

/// The share of white of a pixel that is drawn with white over black.
double white(const glm::vec4& pixel) {
    return srgbFromLinear(static_cast<double>(pixel.r));
}

/// The longest run of white pixels, with what its ends cover in part.
double longestRun(const Image& image) {
    double longest = 0;
    for (int y = 0; y < image.size.y; ++y) {
        double run = 0;
        bool whole = false;
        for (int x = 0; x <= image.size.x; ++x) {
            const double part = x < image.size.x ? white(image.at(x, y)) : 0;
            if (part > 0) {
                run += part;
                whole = whole || part > 0.99;
                continue;
            }
            longest = whole ? std::max(longest, run) : longest;
            run = 0, whole = false;
        }
    }
    return longest;
}

TEST(FigureDrawing, TheScaleBarIsAsLongAsItSays) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int n = 0; n < 60; ++n) {
        const glm::ivec2 size(128 + static_cast<int>(900 * unit(random)),
                              96 + static_cast<int>(600 * unit(random)));
        Figure figure = fullFigure(size, ViewAngles{360 * unit(random) - 180, 90 * unit(random) - 45},
                                   n % 2 ? Projection::parallel : Projection::perspective);
        FigurePart& part = figure.parts.front();
        part.annotations = {};
        part.annotations.scaleBar = true;
        part.camera.parallelScale *= 0.3 + 2 * unit(random);
        part.camera.viewAngle *= 0.3 + 2 * unit(random);
        Image image(size);
        image.pixels.assign(image.pixels.size(), glm::vec4(0, 0, 0, 1));
        drawAnnotations(figure, image);
        const ScaleBar bar = scaleBarOf(part.camera, size);
        // The truth by two places that far apart across the view, at the focal point.
        glm::dvec2 a(0), b(0);
        const glm::dvec3 way = 0.5 * bar.mm * patientFromCamera(part.camera)[0];
        ASSERT_TRUE(pictureFromPatient(part.camera, size, part.camera.focalPoint - way, a));
        ASSERT_TRUE(pictureFromPatient(part.camera, size, part.camera.focalPoint + way, b));
        EXPECT_NEAR(longestRun(image), glm::length(b - a), 0.005 * glm::length(b - a))
            << size.x << " x " << size.y;
    }
}

TEST(FigureDrawing, WordsOfTheRealFontStayApart) {
    PangoWords words;
    const auto measure = [&](const std::string& text, double pixels, bool bold) {
        return words.measure(text, pixels, bold);
    };
    for (const glm::ivec2 size : {glm::ivec2(128, 96), {200, 320}, {512, 512}, {1024, 300}, {4096, 4096}})
        for (const double dpi : {96.0, 300.0})
            for (const ViewAngles angles : {ViewAngles{0, 0}, {35, 25}, {-120, -60}}) {
                Figure figure = fullFigure(size, angles);
                figure.dpi = dpi;
                figure.parts[0].annotations.title = "\xce\xa9 and \xe8\x82\x9d of \xd8\xb1\xd8\xa6\xd8\xa9";
                test::expectApart(figure, layOut(figure, measure));
            }
}

// What is drawn lies in the box that the layout gave it: outside of all boxes the picture is as it was.
TEST(FigureDrawing, DrawsNothingElse) {
    PangoWords words;
    Figure figure = fullFigure({500, 400}, {20, 15});
    FigurePart& part = figure.parts.front();
    part.annotations.measurements = false;
    part.annotations.directions = Directions::letters;
    part.annotations.arrows.clear();
    const FigureLayout layout = layOut(figure, [&](const std::string& text, double pixels, bool bold) {
        return words.measure(text, pixels, bold);
    });
    Image image(figure.size);
    const glm::vec4 before(0.25f, 0.5f, 0.125f, 0.5f);
    image.pixels.assign(image.pixels.size(), before);
    drawAnnotations(figure, image);
    std::vector<std::pair<glm::dvec2, glm::dvec2>> boxes;
    for (const LaidWords& one : layout.words)
        boxes.emplace_back(one.from() - 1.0, one.to() + 1.0);
    for (const LaidShape& shape : layout.shapes) {
        glm::dvec2 from(1e9), to(-1e9);
        const auto add = [&](const glm::dvec2& p, double more) {
            from = glm::min(from, p - more), to = glm::max(to, p + more);
        };
        if (const auto* const area = std::get_if<LaidArea>(&shape))
            for (const glm::dvec2& corner : area->corners)
                add(corner, 0);
        else
            for (const auto& points : std::get<LaidLines>(shape).lines)
                for (const glm::dvec2& point : points)
                    add(point, std::get<LaidLines>(shape).width / 2 + std::get<LaidLines>(shape).edge);
        boxes.emplace_back(from, to);
    }
    std::size_t touched = 0;
    for (int y = 0; y < image.size.y; ++y)
        for (int x = 0; x < image.size.x; ++x) {
            if (image.at(x, y) == before)
                continue;
            ++touched;
            EXPECT_TRUE(std::any_of(boxes.begin(), boxes.end(),
                                    [&](const auto& box) {
                                        return x + 1 > box.first.x && y + 1 > box.first.y &&
                                               x < box.second.x && y < box.second.y;
                                    }))
                << x << ", " << y;
        }
    EXPECT_GT(touched, 2000u);
}

TEST(FigureDrawing, ALayerOverThePictureIsThePictureAnnotated) {
    const Figure figure = fullFigure({300, 260}, {30, 20});
    Image picture(figure.size), layer(figure.size);
    for (int y = 0; y < figure.size.y; ++y)
        for (int x = 0; x < figure.size.x; ++x)
            picture.at(x, y) = glm::vec4(glm::dvec4(x / 600.0, y / 600.0, 0.3, 0.5 + x / 1000.0));
    Image annotated = picture;
    drawAnnotations(figure, annotated);
    drawAnnotations(figure, layer);
    for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
        const glm::vec4& over = layer.pixels[i];
        ASSERT_LT(glm::length(over + (1 - over.a) * picture.pixels[i] - annotated.pixels[i]), 1e-6f);
    }
    EXPECT_TRUE(std::any_of(layer.pixels.begin(), layer.pixels.end(),
                            [](const glm::vec4& p) { return p == glm::vec4(1); }));
    EXPECT_TRUE(std::any_of(layer.pixels.begin(), layer.pixels.end(),
                            [](const glm::vec4& p) { return p == glm::vec4(0); }));
}

// Pictures are drawn tile by tile: no seam shows, wherever a part lies.
TEST(FigureDrawing, IsTheSameAnywhereInALargerPicture) {
    Figure figure = fullFigure({420, 330}, {30, 20});
    Image first(glm::ivec2(1300, 1200)), moved(first.size);
    figure.size = first.size;
    drawAnnotations(figure, first);
    const glm::ivec2 by(371, 405);
    figure.parts[0].from = by;
    drawAnnotations(figure, moved);
    for (int y = 0; y < 330; ++y)
        for (int x = 0; x < 420; ++x)
            ASSERT_LT(glm::length(first.at(x, y) - moved.at(x + by.x, y + by.y)), 0.02f) << x << ", " << y;
}

// Pictures that are larger than memory come by rows: to the bit what is drawn at once.
TEST(FigureDrawing, RowsAreThoseOfTheWhole) {
    std::mt19937 random(9);
    for (const glm::ivec2 size : {glm::ivec2(700, 1100), glm::ivec2(513, 80), glm::ivec2(260, 1025)}) {
        Figure figure = fullFigure(size, {30, 20});
        figure.dpi = 200;
        Image whole(size), byRows(size);
        for (std::size_t i = 0; i < whole.pixels.size(); ++i)
            whole.pixels[i] = byRows.pixels[i] = glm::vec4(static_cast<float>(i % 97) / 100);
        const std::vector<glm::vec4> before = whole.pixels;
        drawAnnotations(figure, whole);
        const DrawRows draw = annotationRows(figure);
        const auto width = static_cast<std::size_t>(size.x);
        for (int y = 0, count = 0; y < size.y; y += count) {
            count = std::min(std::uniform_int_distribution<int>(1, 90)(random), size.y - y);
            draw(y,
                 std::span(byRows.pixels)
                     .subspan(width * static_cast<std::size_t>(y), width * static_cast<std::size_t>(count)));
        }
        EXPECT_EQ(byRows.pixels, whole.pixels) << size.x << " x " << size.y;
        EXPECT_NE(before, whole.pixels);
    }
}

// Words can be told from any background: their middle and their edge lie far apart in lightness.
TEST(FigureDrawing, WordsShowOnAnyBackground) {
    for (const bool onLight : {false, true})
        for (const glm::vec3 background :
             {glm::vec3(0), glm::vec3(1), glm::vec3(0.2f), glm::vec3(1, 0, 0), glm::vec3(0, 1, 0)}) {
            Figure figure = fullFigure({200, 160}, {});
            figure.parts[0].annotations = {};
            figure.parts[0].annotations.title = "Title";
            figure.parts[0].onLight = onLight;
            Image image(figure.size);
            image.pixels.assign(image.pixels.size(), glm::vec4(background, 1));
            drawAnnotations(figure, image);
            std::size_t light = 0, dark = 0;
            for (const glm::vec4& p : image.pixels)
                if (glm::vec3(p) != background)
                    light += p.g > 0.9f && p.r > 0.9f && p.b > 0.9f,
                        dark += p.r < 0.02f && p.g < 0.02f && p.b < 0.02f;
            EXPECT_TRUE(light > 15 || background == glm::vec3(1)) << light;
            EXPECT_TRUE(dark > 15 || background == glm::vec3(0)) << dark;
        }
}

TEST(FigureDrawing, TellsItsFontsAndLibraries) {
    const DrawingReport report = describeDrawing(fullFigure({400, 400}, {}));
    EXPECT_EQ(report.cairo.substr(0, 2), "1.");
    EXPECT_EQ(report.pango.substr(0, 2), "1.");
    ASSERT_FALSE(report.fonts.empty());
    for (const DrawingReport::Font& font : report.fonts) {
        EXPECT_FALSE(font.family.empty());
        EXPECT_FALSE(font.file.empty());
        EXPECT_EQ(font.file.find('/'), std::string::npos);
    }
    EXPECT_TRUE(report.leftOut.empty());
}

} // namespace
} // namespace tessera
