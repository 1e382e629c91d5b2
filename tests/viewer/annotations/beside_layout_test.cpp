// tests/viewer/annotations/beside_layout_test.cpp: annotations beside a picture: none lies over it, nothing
// else moves, and strips that are wider than they need to be change nothing.
#include "core/scene/annotations.h"
#include "tests/support/figures.h"
#include "viewer/annotations/figure_layout.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <gtest/gtest.h>
#include <random>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace tessera {
namespace {

using test::evenLetters;
using test::fullFigure;

/// The part with its strips, and the figure around it.
Figure amid(FigurePart part, double dpi, const Strips& strips) {
    part.from = strips.corner();
    part.strips = strips;
    Figure figure;
    figure.size = part.size + strips.size();
    figure.dpi = dpi;
    figure.parts.push_back(std::move(part));
    return figure;
}

/// A figure without what has a place in the patient, of any size, letters and words.
FigurePart randomPart(std::mt19937& random) {
    const auto number = [&](int low, int high) { return std::uniform_int_distribution(low, high)(random); };
    FigurePart part =
        fullFigure({number(60, 1600), number(60, 1200)},
                   ViewAngles{static_cast<double>(number(-180, 180)), static_cast<double>(number(-80, 80))},
                   number(0, 1) ? Projection::parallel : Projection::perspective)
            .parts.front();
    Annotations& a = part.annotations;
    a.margin = AnnotationMargin::all;
    a.measurements = false;
    a.arrows.clear();
    a.textPoints = number(5, 30);
    for (bool* const asked : {&a.scaleBar, &a.legend, &a.labelLegend, &a.error})
        *asked = number(0, 3) > 0;
    a.directions = static_cast<Directions>(number(0, 3));
    a.title = number(0, 2) ? std::string(static_cast<std::size_t>(number(1, 30)), 'T') : "";
    for (int n = number(0, 40); n > 0; --n)
        a.caption += " words";
    part.legend.resize(static_cast<std::size_t>(number(0, 3)), part.legend.front());
    part.labels.clear();
    for (int n = number(0, 1) ? number(0, 12) : number(0, 200); n > 0; --n)
        part.labels.push_back({"label " + std::to_string(n * n), glm::vec3(0.5f)});
    part.mark = number(0, 1) ? "B" : "";
    return part;
}

constexpr double kStripRounding = 1e-9; // pixels

struct Area {
    glm::dvec2 from, to;
    bool meets(const Area& other) const {
        const glm::dvec2 a = glm::max(from, other.from), b = glm::min(to, other.to);
        return a.x + kStripRounding < b.x && a.y + kStripRounding < b.y;
    }
    bool holds(const Area& other) const {
        return from.x <= other.from.x + kStripRounding && from.y <= other.from.y + kStripRounding &&
               to.x >= other.to.x - kStripRounding && to.y >= other.to.y - kStripRounding;
    }
};
Area boxOf(const LaidShape& shape) {
    Area box{glm::dvec2(1e9), glm::dvec2(-1e9)};
    const auto add = [&](const glm::dvec2& point, double around) {
        box.from = glm::min(box.from, point - around);
        box.to = glm::max(box.to, point + around);
    };
    if (const auto* const area = std::get_if<LaidArea>(&shape)) {
        for (const glm::dvec2& corner : area->corners)
            add(corner, 0);
        return box;
    }
    const auto& lines = std::get<LaidLines>(shape);
    for (const std::vector<glm::dvec2>& points : lines.lines)
        for (const glm::dvec2& point : points)
            add(point, lines.edge);
    return box;
}
std::vector<Area> boxesOf(const FigureLayout& layout) {
    std::vector<Area> boxes;
    for (const LaidWords& words : layout.words)
        boxes.push_back({words.from(), words.to()});
    for (const LaidShape& shape : layout.shapes)
        boxes.push_back(boxOf(shape));
    return boxes;
}
void expectSameWords(const FigureLayout& a, const FigureLayout& b, const glm::ivec2& by) {
    ASSERT_EQ(a.words.size(), b.words.size());
    for (std::size_t n = 0; n < a.words.size(); ++n) {
        EXPECT_EQ(a.words[n].words, b.words[n].words);
        EXPECT_LT(glm::length(a.words[n].at + glm::dvec2(by) - b.words[n].at), kStripRounding)
            << a.words[n].words;
    }
    EXPECT_EQ(a.shapes.size(), b.shapes.size());
}

TEST(BesideLayout, NothingLiesOverThePicture) {
    std::mt19937 random(17);
    std::size_t all = 0, complete = 0;
    for (int n = 0; n < 300; ++n) {
        const FigurePart part = randomPart(random);
        const double dpi = n % 2 ? 96 : 300;
        const Strips strips = stripsBeside(part, dpi, evenLetters);
        const Figure figure = amid(part, dpi, strips);
        const FigureLayout layout = layOut(figure, evenLetters);
        const Area picture{glm::dvec2(strips.corner()), glm::dvec2(strips.corner() + part.size)};
        const Area page{glm::dvec2(0), glm::dvec2(figure.size)};
        SCOPED_TRACE(std::to_string(part.size.x) + " x " + std::to_string(part.size.y));
        for (const Area& box : boxesOf(layout)) {
            EXPECT_FALSE(box.meets(picture));
            EXPECT_TRUE(page.holds(box)) << box.from.x << ", " << box.from.y;
        }
        for (std::size_t i = 0; i < layout.words.size(); ++i)
            for (std::size_t j = 0; j < i; ++j) {
                const LaidWords &one = layout.words[i], &other = layout.words[j];
                EXPECT_FALSE((Area{one.from(), one.to()}.meets({other.from(), other.to()})))
                    << one.words << " and " << other.words;
            }
        // At most a picture's width is added for legends.
        EXPECT_LE(strips.right, 2 * part.size.x + 40);
        all += layout.words.size();
        complete += layout.leftOut.empty() ? 1 : 0;
        // Wider strips, such as those of other panels, move nothing.
        const Strips wider{strips.left + 7, strips.right + 30, strips.above + 11, strips.below + 2};
        expectSameWords(layout, layOut(amid(part, dpi, wider), evenLetters),
                        wider.corner() - strips.corner());
        // Too narrow ones leave out, and never lie over the picture either.
        const Strips narrow{strips.left / 2, strips.right / 2, strips.above / 2, strips.below / 2};
        const Area picture2{glm::dvec2(narrow.corner()), glm::dvec2(narrow.corner() + part.size)};
        for (const Area& box : boxesOf(layOut(amid(part, dpi, narrow), evenLetters)))
            EXPECT_FALSE(box.meets(picture2));
    }
    EXPECT_GT(all, 3000u);
    EXPECT_GT(complete, 100u) << "nearly all are cut somewhere";
}

// All that is said over a picture is said beside it.
TEST(BesideLayout, SaysWhatLiesOverThePictureElse) {
    for (const glm::ivec2 size : {glm::ivec2(512), glm::ivec2(1400, 1000), glm::ivec2(700, 1600)}) {
        FigurePart part = fullFigure(size, {30, 20}).parts.front();
        const FigureLayout over = layOut(amid(part, 96, {}), evenLetters);
        part.annotations.margin = AnnotationMargin::all;
        const Strips strips = stripsBeside(part, 96, evenLetters);
        const FigureLayout beside = layOut(amid(part, 96, strips), evenLetters);
        EXPECT_TRUE(over.leftOut.empty());
        EXPECT_TRUE(beside.leftOut.empty());
        const auto wordsOf = [](const FigureLayout& layout) {
            std::vector<std::pair<std::string, double>> words;
            for (const LaidWords& one : layout.words)
                words.emplace_back(one.words, one.pixels);
            std::ranges::sort(words);
            return words;
        };
        EXPECT_EQ(wordsOf(beside), wordsOf(over));
        EXPECT_EQ(beside.shapes.size(), over.shapes.size());
    }
}

// Legends alone: a strip at the right, and the rest is as if none were asked for.
TEST(BesideLayout, LegendsLeaveTheRestInThePicture) {
    std::mt19937 random(23);
    for (int n = 0; n < 100; ++n) {
        FigurePart part = randomPart(random);
        part.annotations.arrows = {{{10, -5, 12}, {24, -24}, "a lesion"}};
        part.annotations.margin = AnnotationMargin::legends;
        const Strips strips = stripsBeside(part, 96, evenLetters);
        EXPECT_EQ(strips, (Strips{0, strips.right, 0, 0}));
        const FigureLayout layout = layOut(amid(part, 96, strips), evenLetters);
        FigurePart rest = part;
        rest.annotations.margin = AnnotationMargin::none;
        rest.annotations.legend = rest.annotations.labelLegend = false;
        const FigureLayout alone = layOut(amid(rest, 96, {}), evenLetters);
        FigureLayout within = layout;
        std::erase_if(within.words, [&](const LaidWords& one) { return one.from().x >= part.size.x; });
        std::erase_if(within.shapes, [&](const LaidShape& one) { return boxOf(one).from.x >= part.size.x; });
        expectSameWords(within, alone, {0, 0});
        EXPECT_EQ(strips.right == 0, layout.words.size() == alone.words.size());
    }
}

// What a page has room for does not depend on the camera: frames of films have one size.
TEST(BesideLayout, StripsAreThoseOfAnyCamera) {
    std::mt19937 random(5);
    const FigurePart first = randomPart(random);
    FigurePart part = first;
    part.annotations.directions = Directions::all;
    part.annotations.scaleBar = false; // its words follow the scale
    const Strips strips = stripsBeside(part, 96, evenLetters);
    for (int n = 0; n < 100; ++n) {
        part.camera = fullFigure(part.size, {n * 7.0 - 180, n - 50.0}).parts.front().camera;
        EXPECT_EQ(stripsBeside(part, 96, evenLetters), strips) << n;
    }
}

TEST(BesideLayout, NeedsNoStripsWhereNothingStandsThere) {
    FigurePart part = fullFigure({512, 400}, {}).parts.front();
    EXPECT_EQ(stripsBeside(part, 96, evenLetters), Strips());
    part.annotations = {};
    for (const AnnotationMargin beside : {AnnotationMargin::legends, AnnotationMargin::all}) {
        part.annotations.margin = beside;
        EXPECT_EQ(stripsBeside(part, 96, evenLetters), Strips());
    }
    part.annotations.margin = AnnotationMargin::legends;
    part.annotations.title = "A title";
    EXPECT_EQ(stripsBeside(part, 96, evenLetters), Strips());
}

} // namespace
} // namespace tessera
