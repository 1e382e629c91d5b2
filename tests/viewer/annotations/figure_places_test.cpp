// tests/viewer/annotations/figure_places_test.cpp: where each annotation lies: by itself at its own edge or
// corner of the box, and with the lengths and directions that it says.
#include "core/image/colour.h"
#include "core/scene/measurement.h"
#include "tests/support/figures.h"
#include "viewer/session/patient_letters.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <gtest/gtest.h>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace tessera {
namespace {

using test::evenLetters;
using test::fullFigure;

/// Numbers that a seed gives.
struct Chance {
    explicit Chance(unsigned seed) : random(seed) {}
    double from(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); }
    glm::dvec3 place(double reach) { return {from(-reach, reach), from(-reach, reach), from(-reach, reach)}; }
    std::mt19937 random;
};

/// A figure of one part without annotations, at any place of a larger one, of any size and resolution.
Figure plainFigure(Chance& chance, Projection projection = Projection::parallel) {
    const glm::ivec2 size(static_cast<int>(chance.from(300, 1200)), static_cast<int>(chance.from(300, 1200)));
    Figure figure = fullFigure(size, {chance.from(-180, 180), chance.from(-85, 85)}, projection);
    figure.parts[0].annotations = {};
    figure.parts[0].annotations.textPoints = chance.from(5, 14);
    figure.parts[0].from = {static_cast<int>(chance.from(0, 90)), static_cast<int>(chance.from(0, 90))};
    figure.size = size + figure.parts[0].from + 40;
    figure.dpi = chance.from(72, 300);
    return figure;
}

/// A box within a part, and its distances from the part's edges: left, top, right, bottom.
struct Box {
    glm::dvec2 from{1e9}, to{-1e9};
    void add(const glm::dvec2& a, const glm::dvec2& b) { from = glm::min(from, a), to = glm::max(to, b); }
    glm::dvec2 middle() const { return (from + to) / 2.0; }
    glm::dvec2 before(const FigurePart& part) const { return from - glm::dvec2(part.from); }
    glm::dvec2 behind(const FigurePart& part) const { return glm::dvec2(part.from + part.size) - to; }
};
Box boxOf(const LaidWords& words) {
    Box box;
    box.add(words.from(), words.to());
    return box;
}
Box boxOf(const FigureLayout& layout) {
    Box box;
    for (const LaidWords& words : layout.words)
        box.add(words.from(), words.to());
    for (const LaidShape& shape : layout.shapes)
        if (const auto* const area = std::get_if<LaidArea>(&shape)) {
            for (const glm::dvec2& p : area->corners)
                box.add(p, p);
        } else {
            const auto& lines = std::get<LaidLines>(shape);
            for (const std::vector<glm::dvec2>& points : lines.lines)
                for (const glm::dvec2& p : points)
                    box.add(p - lines.edge, p + lines.edge);
        }
    return box;
}
/// The margin of blocks: 0.4 letters, and a pixel to which they are rounded.
double margin(double em) {
    return std::max(2.0, 0.4 * em);
}
constexpr double kRounding = 1 + 1e-6;

TEST(FigurePlaces, LettersAreOfTheSizeThatIsAskedForUnlessThePictureIsSmall) {
    Chance chance(1);
    for (int n = 0; n < 200; ++n) {
        Figure figure = plainFigure(chance);
        FigurePart& part = figure.parts[0];
        part.size = {static_cast<int>(chance.from(20, 900)), static_cast<int>(chance.from(20, 900))};
        const double asked = part.annotations.textPoints * figure.dpi / 72,
                     room = std::min(part.size.x / 16.0, part.size.y / 12.0);
        EXPECT_NEAR(letterPixels(part, figure.dpi), std::min(asked, std::max(6.0, room)), 1e-9);
    }
}

TEST(FigurePlaces, WordsAreInTheMiddleAboveAndBelow) {
    Chance chance(2);
    for (int n = 0; n < 60; ++n) {
        Figure figure = plainFigure(chance);
        figure.dpi = chance.from(60, 110); // two lines have room
        FigurePart& part = figure.parts[0];
        const double em = letterPixels(part, figure.dpi);
        part.annotations.title = n % 2 ? "Title" : "one\nand two";
        FigureLayout layout = layOut(figure, evenLetters);
        ASSERT_EQ(layout.words.size(), n % 2 ? 1U : 2U);
        EXPECT_NEAR(boxOf(layout).before(part).y, margin(em), kRounding);
        for (const LaidWords& words : layout.words) {
            EXPECT_NEAR(words.pixels, 1.2 * em, 1e-9);
            EXPECT_NEAR(boxOf(words).middle().x, part.from.x + part.size.x / 2.0, kRounding);
            EXPECT_NEAR(words.edge, std::max(1.0, 0.1 * em), 1e-9);
            EXPECT_FALSE(words.bold);
        }
        if (n % 2 == 0) {
            EXPECT_NEAR(layout.words[0].to().y, layout.words[1].from().y, 1e-6) << "one below the other";
        }
        part.annotations.title = "";
        part.annotations.error = true;
        part.error = "an error";
        part.annotations.caption = "a caption";
        layout = layOut(figure, evenLetters);
        ASSERT_EQ(layout.words.size(), 2U);
        EXPECT_EQ(layout.words[0].words, "an error");
        EXPECT_NEAR(boxOf(layout).behind(part).y, margin(em), kRounding);
        EXPECT_NEAR(boxOf(layout.words[0]).behind(part).y, margin(em), kRounding);
        EXPECT_NEAR(layout.words[1].to().y, layout.words[0].from().y, 0.5 * em + kRounding);
        for (const LaidWords& words : layout.words) {
            EXPECT_NEAR(words.pixels, em, 1e-9);
            EXPECT_NEAR(boxOf(words).middle().x, part.from.x + part.size.x / 2.0, kRounding);
        }
        part.annotations.error = false;
        EXPECT_EQ(layOut(figure, evenLetters).words.size(), 1U);
        part.annotations.error = true;
        part.error = "";
        EXPECT_EQ(layOut(figure, evenLetters).words.size(), 1U);
    }
}

// A title of a quarter of the part's height keeps the picture free.
TEST(FigurePlaces, WordsOfManyLinesLeaveThePictureFree) {
    Chance chance(3);
    for (int n = 0; n < 40; ++n) {
        Figure figure = plainFigure(chance);
        FigurePart& part = figure.parts[0];
        std::string& words = n % 2 ? part.annotations.title : part.annotations.caption;
        for (int word = 0; word < 900; ++word)
            words += "word ";
        const FigureLayout layout = layOut(figure, evenLetters);
        const Box box = boxOf(layout);
        const double height = box.to.y - box.from.y, row = height / static_cast<double>(layout.words.size());
        EXPECT_LE(height, 0.25 * part.size.y);
        EXPECT_GT(height + row, 0.25 * (part.size.y - 2 * margin(letterPixels(part, figure.dpi))) - 1)
            << "as many lines as fit";
    }
}

TEST(FigurePlaces, TheScaleBarIsAtTheLowerRight) {
    Chance chance(4);
    for (int n = 0; n < 60; ++n) {
        Figure figure = plainFigure(chance, n % 2 ? Projection::parallel : Projection::perspective);
        FigurePart& part = figure.parts[0];
        part.annotations.scaleBar = true;
        const double em = letterPixels(part, figure.dpi);
        const ScaleBar bar = scaleBarOf(part.camera, part.size);
        const FigureLayout layout = layOut(figure, evenLetters);
        ASSERT_EQ(layout.shapes.size(), 1U);
        ASSERT_EQ(layout.words.size(), 1U);
        const auto& lines = std::get<LaidLines>(layout.shapes[0]);
        EXPECT_NEAR(lines.width, std::max(1.0, std::round(em / 8)), 1e-9);
        ASSERT_EQ(lines.lines.size(), 3U);
        const auto &across = lines.lines[0], &left = lines.lines[1], &right = lines.lines[2];
        EXPECT_NEAR(across[1].x - across[0].x, bar.pixels, 1e-9);
        EXPECT_EQ(across[0].y, across[1].y);
        // The ends stand upright, within the bar's length, around the line between them.
        for (const auto& end : {left, right}) {
            EXPECT_EQ(end[0].x, end[1].x);
            EXPECT_NEAR(end[1].y - end[0].y, std::max(lines.width + 2, std::round(0.6 * em)), 1e-9);
            EXPECT_NEAR((end[0].y + end[1].y) / 2, across[0].y, 0.5 + 1e-9);
        }
        EXPECT_NEAR(left[0].x - lines.width / 2, across[0].x, 1e-9);
        EXPECT_NEAR(right[0].x + lines.width / 2, across[1].x, 1e-9);
        const glm::dvec2 rest = boxOf(layout).behind(part);
        EXPECT_NEAR(rest.x, margin(em), kRounding + 1);
        EXPECT_NEAR(rest.y, margin(em), kRounding + 1);
        EXPECT_LE(layout.words[0].to().y, left[0].y - lines.edge + kRounding);
        EXPECT_NEAR(layout.words[0].to().y, left[0].y - lines.edge, lines.edge + kRounding + 1);
        EXPECT_NEAR(boxOf(layout.words[0]).behind(part).x, margin(em), kRounding);
        EXPECT_EQ(layout.words[0].words, bar.text());
    }
}

TEST(FigurePlaces, LettersAreInTheMiddleOfTheirEdges) {
    Chance chance(5);
    for (int n = 0; n < 40; ++n) {
        Figure figure = plainFigure(chance);
        FigurePart& part = figure.parts[0];
        part.annotations.directions = Directions::letters;
        const double em = letterPixels(part, figure.dpi);
        const EdgeLetters expected = edgeLetters(part.camera);
        const FigureLayout layout = layOut(figure, evenLetters);
        ASSERT_EQ(layout.words.size(), 4U);
        EXPECT_TRUE(layout.shapes.empty());
        for (const LaidWords& words : layout.words) {
            EXPECT_NEAR(words.pixels, 1.2 * em, 1e-9);
            const Box box = boxOf(words);
            const glm::dvec2 off = box.middle() - glm::dvec2(part.from) - glm::dvec2(part.size) / 2.0;
            const bool across = std::abs(off.x) > std::abs(off.y);
            EXPECT_NEAR(across ? off.y : off.x, 0, kRounding);
            const glm::dvec2 rest = glm::min(box.before(part), box.behind(part));
            EXPECT_NEAR(across ? rest.x : rest.y, margin(em), kRounding);
            EXPECT_EQ(words.words, across ? (off.x < 0 ? expected.left : expected.right)
                                          : (off.y < 0 ? expected.top : expected.bottom));
        }
    }
}

// Its faces are those that the camera sees, where it sees them; nearer to the viewer they are lighter.
TEST(FigurePlaces, TheCubeIsThePatientFromTheCamera) {
    Chance chance(6);
    int faces = 0, lettered = 0;
    for (int n = 0; n < 60; ++n) {
        Figure figure = plainFigure(chance);
        FigurePart& part = figure.parts[0];
        part.annotations.directions = Directions::cube;
        const double em = letterPixels(part, figure.dpi);
        const FigureLayout layout = layOut(figure, evenLetters);
        const glm::dvec3 towards = glm::normalize(part.camera.position - part.camera.focalPoint),
                         right = glm::normalize(glm::cross(part.camera.viewUp, towards)),
                         up = glm::cross(towards, right);
        std::vector<std::pair<const LaidArea*, const LaidLines*>> seen;
        for (std::size_t i = 0; i + 1 < layout.shapes.size(); i += 2)
            seen.emplace_back(&std::get<LaidArea>(layout.shapes[i]),
                              &std::get<LaidLines>(layout.shapes[i + 1]));
        std::size_t next = 0, letter = 0;
        const double half = 0.62 * 2.6 * em; // of an edge
        glm::dvec2 middle(0);
        for (int axis = 0; axis < 3; ++axis)
            for (const int side : {-1, 1}) {
                glm::dvec3 normal(0);
                normal[axis] = side;
                const double facing = glm::dot(normal, towards);
                if (facing <= 0.02)
                    continue;
                ASSERT_LT(next, seen.size());
                const LaidArea& face = *seen[next].first;
                const LaidLines& frame = *seen[next].second;
                ++next, ++faces;
                const auto inPicture = [&](const glm::dvec3& p) {
                    return half * glm::dvec2(glm::dot(p, right), -glm::dot(p, up));
                };
                ASSERT_EQ(face.corners.size(), 4U);
                const glm::dvec2 centre =
                    (face.corners[0] + face.corners[1] + face.corners[2] + face.corners[3]) / 4.0;
                if (next == 1)
                    middle = centre - inPicture(normal);
                EXPECT_LT(glm::distance(centre, middle + inPicture(normal)), 1e-6);
                for (int corner = 0; corner < 4; ++corner) {
                    glm::dvec3 p = normal;
                    p[(axis + 1) % 3] = corner == 0 || corner == 1 ? 1 : -1;
                    p[(axis + 2) % 3] = corner == 0 || corner == 3 ? 1 : -1;
                    double nearest = 1e9;
                    for (const glm::dvec2& laid : face.corners)
                        nearest = std::min(nearest, glm::distance(laid, middle + inPicture(p)));
                    EXPECT_LT(nearest, 1e-6);
                }
                // Around it, not across.
                for (std::size_t c = 0; c < 4; ++c)
                    EXPECT_NEAR(glm::distance(face.corners[c] + face.corners[(c + 2) % 4], 2.0 * centre), 0,
                                1e-6);
                ASSERT_EQ(frame.lines.size(), 1U);
                ASSERT_EQ(frame.lines[0].size(), 5U);
                for (std::size_t c = 0; c < 5; ++c)
                    EXPECT_EQ(frame.lines[0][c], face.corners[c % 4]);
                EXPECT_EQ(frame.edge, 0);
                EXPECT_NEAR(255 * srgbFromLinear(static_cast<double>(face.colour.g)), 50 + 90 * facing, 0.1);
                if (facing <= 0.3)
                    continue;
                ASSERT_LT(letter, layout.words.size());
                const LaidWords& words = layout.words[letter++];
                EXPECT_EQ(words.words, directionLetters(normal));
                EXPECT_EQ(words.ink, Ink::light);
                EXPECT_LT(glm::distance(boxOf(words).middle(), centre), 1e-6);
                ++lettered;
            }
        EXPECT_EQ(2 * next, layout.shapes.size());
        EXPECT_EQ(letter, layout.words.size());
        // In the upper right corner: its ball touches the margins.
        const double reach = 1.1 * 2.6 * em;
        EXPECT_NEAR(part.from.x + part.size.x - margin(em), middle.x + reach, kRounding);
        EXPECT_NEAR(part.from.y + margin(em), middle.y - reach, kRounding);
    }
    EXPECT_GT(lettered, 60);
    EXPECT_GT(faces, lettered);
}

// The value words are under the bar's ends and middle, its unit above, all at the lower left.
TEST(FigurePlaces, TheLegendIsAtTheLowerLeft) {
    Chance chance(7);
    for (int n = 0; n < 60; ++n) {
        Figure figure = plainFigure(chance);
        FigurePart& part = figure.parts[0];
        part.annotations.legend = true;
        part.onLight = n % 3 == 0;
        const double em = letterPixels(part, figure.dpi);
        const FigureLayout layout = layOut(figure, evenLetters);
        const Box all = boxOf(layout);
        EXPECT_NEAR(all.before(part).x, margin(em), kRounding);
        EXPECT_NEAR(all.behind(part).y, margin(em), kRounding);
        ASSERT_EQ(layout.shapes.size(), 66U); // edge, line, 64 colours
        Box boxes[3];
        for (std::size_t i = 0; i < 3; ++i) {
            const auto& area = std::get<LaidArea>(layout.shapes[i]);
            boxes[i].add(area.corners[0], area.corners[2]);
            EXPECT_EQ(area.corners[1], glm::dvec2(area.corners[2].x, area.corners[0].y));
            EXPECT_EQ(area.corners[3], glm::dvec2(area.corners[0].x, area.corners[2].y));
            if (i < 2) {
                EXPECT_EQ(area.colour, glm::vec3((i == 0) == part.onLight ? 1 : 0));
            }
        }
        const Box& bar = boxes[2];
        EXPECT_NEAR(bar.to.y - bar.from.y, std::max(3.0, std::round(0.8 * em)), 1e-6);
        const double width = bar.to.x - bar.from.x;
        EXPECT_NEAR(width, std::max(width * 0, std::min(14 * em, 0.45 * (part.size.x - 2 * margin(em)))), 1)
            << "no value needs more";
        for (std::size_t i = 0; i < 2; ++i) { // frames around it, the same on all sides
            const double line = std::max(1.0, std::round(std::max(1.0, std::round(em / 8)) / 2)),
                         more = i == 1 ? line : line + std::round(std::max(1.0, 0.1 * em));
            EXPECT_LT(glm::distance(boxes[i].from, bar.from - more), 1e-6);
            EXPECT_LT(glm::distance(boxes[i].to, bar.to + more), 1e-6);
        }
        for (std::size_t i = 0; i < 64; ++i) {
            const auto& area = std::get<LaidArea>(layout.shapes[2 + i]);
            EXPECT_NEAR(area.corners[0].x, bar.from.x + static_cast<double>(i) / 64 * width, 0.5 + 1e-6);
            EXPECT_EQ(area.corners[2], bar.to);
            EXPECT_EQ(area.colour, glm::vec3(part.legend[0].colours[i]));
        }
        ASSERT_FALSE(layout.words.empty());
        EXPECT_EQ(layout.words[0].words, "HU");
        EXPECT_NEAR(layout.words[0].to().y, boxes[0].from.y, kRounding);
        EXPECT_NEAR(layout.words[0].from().x, boxes[0].from.x, kRounding);
        const auto room = [&](const char* value) {
            return evenLetters(value, em).width + 2 * layout.words[0].edge;
        };
        const bool hasMiddle = std::max(room("-160"), room("240")) + room("40") / 2 + em / 2 <= width / 2;
        ASSERT_EQ(layout.words.size(), hasMiddle ? 4U : 3U);
        EXPECT_EQ(layout.words[1].words, "-160");
        EXPECT_EQ(layout.words.back().words, "240");
        EXPECT_NEAR(layout.words[1].from().x, bar.from.x, 1e-6);
        EXPECT_NEAR(layout.words.back().to().x, bar.to.x, 1e-6);
        if (layout.words.size() == 4) {
            EXPECT_NEAR(boxOf(layout.words[2]).middle().x, bar.middle().x, 1e-6);
        }
        for (std::size_t i = 1; i < layout.words.size(); ++i)
            EXPECT_NEAR(layout.words[i].from().y, boxes[0].to.y, 1e-6);
    }
}

TEST(FigurePlaces, SeveralLegendsStandInTheScenesOrder) {
    Figure figure = fullFigure({600, 500}, {});
    FigurePart& part = figure.parts[0];
    part.annotations = {};
    part.annotations.legend = true;
    part.legend = {part.legend[0], part.legend[0], part.legend[0]};
    for (std::size_t n = 0; n < 3; ++n)
        part.legend[n].unit = std::string(1, static_cast<char>('x' + n));
    const FigureLayout layout = layOut(figure, evenLetters);
    const auto top = [&](const std::string& unit) {
        return std::ranges::find(layout.words, unit, &LaidWords::words)->from().y;
    };
    EXPECT_LT(top("x"), top("y"));
    EXPECT_LT(top("y"), top("z"));
    EXPECT_LT(top("z") - top("y"), 6 * letterPixels(part, figure.dpi)) << "close together";
}

// Names are in one column below each other, from the upper left on, each beside its colour; then in the next.
TEST(FigurePlaces, NamesOfLabelsFillColumnsBesideTheirColours) {
    Chance chance(8);
    int columns = 0;
    for (int n = 0; n < 40; ++n) {
        Figure figure = plainFigure(chance);
        FigurePart& part = figure.parts[0];
        part.annotations.labelLegend = true;
        part.annotations.textPoints = 5;
        part.onLight = n % 3 == 0;
        const double em = letterPixels(part, figure.dpi);
        part.labels.clear();
        for (int label = 0; label < (n % 2 ? 3 : 60); ++label)
            part.labels.push_back(
                {"n" + std::to_string(label), glm::vec3(static_cast<float>(label) / 64, 0.5F, 0.25F)});
        const FigureLayout layout = layOut(figure, evenLetters);
        if (!layout.leftOut.empty())
            continue;
        ASSERT_EQ(layout.words.size(), part.labels.size());
        ASSERT_EQ(layout.shapes.size(), 3 * part.labels.size());
        EXPECT_NEAR(boxOf(layout).before(part).x, margin(em), kRounding);
        EXPECT_NEAR(boxOf(layout).before(part).y, margin(em), kRounding + 1);
        Box before;
        for (std::size_t i = 0; i < part.labels.size(); ++i) {
            Box row = boxOf(layout.words[i]), square;
            EXPECT_EQ(layout.words[i].words, part.labels[i].name);
            for (std::size_t k = 0; k < 3; ++k) {
                const auto& area = std::get<LaidArea>(layout.shapes[3 * i + k]);
                row.add(area.corners[0], area.corners[2]);
                if (k == 2) {
                    square.add(area.corners[0], area.corners[2]);
                    EXPECT_EQ(area.colour, part.labels[i].colour);
                }
            }
            EXPECT_NEAR(square.to.x - square.from.x, std::round(0.8 * em), 1e-6);
            EXPECT_NEAR(square.to.y - square.from.y, std::round(0.8 * em), 1e-6);
            EXPECT_NEAR(square.middle().y, boxOf(layout.words[i]).middle().y, 1.01) << "in one line";
            const auto& frame = std::get<LaidArea>(layout.shapes[3 * i]);
            EXPECT_NEAR(boxOf(layout.words[i]).from.x - frame.corners[2].x, 0.3 * em, 1e-6) << "a gap";
            if (i > 0 && row.from.y > before.from.y) {
                EXPECT_NEAR(square.from.x, before.from.x, 1e-6) << "one column";
                EXPECT_NEAR(row.from.y, before.to.y, 2.01) << "without a gap";
            } else if (i > 0) {
                ++columns;
                EXPECT_GT(row.from.x, before.to.x - 1e-6);
                EXPECT_GT(before.to.y + (before.to.y - before.from.y) + 2,
                          part.from.y + part.size.y - margin(em))
                    << "the one before was full";
                EXPECT_NEAR(row.from.y, boxOf(layout).from.y, 1.01);
            }
            before = row;
            before.from.x = square.from.x;
        }
    }
    EXPECT_GT(columns, 5);
}

/// The directed angle from one way to another, degrees.
double turnOf(const glm::dvec2& from, const glm::dvec2& to) {
    return std::atan2(from.x * to.y - from.y * to.x, glm::dot(from, to)) * 180 / 3.14159265358979323846;
}

// An arrow is as asked where that fits; else turned by eighths, the nearest first.
TEST(FigurePlaces, ArrowsHaveTheirShapeAndTheirWordsBehindThem) {
    Chance chance(9);
    int turned = 0, straight = 0;
    for (int n = 0; n < 150; ++n) {
        Figure figure = plainFigure(chance, n % 2 ? Projection::parallel : Projection::perspective);
        FigurePart& part = figure.parts[0];
        const double em = letterPixels(part, figure.dpi);
        part.annotations.arrows = {{chance.place(45), {}, "here"}};
        part.annotations.arrows[0].offset = {chance.from(-60, 60), chance.from(-60, 60)};
        const glm::dvec2 asked = part.annotations.arrows[0].offset * figure.dpi / 72.0;
        const FigureLayout layout = layOut(figure, evenLetters);
        if (layout.shapes.empty())
            continue;
        const auto& lines = std::get<LaidLines>(layout.shapes[0]);
        const glm::dvec2 end = lines.lines[0][0], tip = lines.lines[0][1], way = end - tip;
        glm::dvec2 at(0);
        ASSERT_TRUE(pictureFromPatient(part.camera, part.size, part.annotations.arrows[0].place, at));
        EXPECT_LT(glm::distance(tip, at + glm::dvec2(part.from)), 1e-6);
        // The head: two sides of one length, to either side of the shaft.
        ASSERT_EQ(lines.lines.size(), 2U);
        ASSERT_EQ(lines.lines[1].size(), 3U);
        EXPECT_EQ(lines.lines[1][1], tip);
        const glm::dvec2 one = lines.lines[1][0] - tip, other = lines.lines[1][2] - tip;
        EXPECT_NEAR(glm::length(one), std::min(0.7 * em, glm::length(way)), 1e-6);
        EXPECT_NEAR(glm::length(other), glm::length(one), 1e-6);
        EXPECT_NEAR(std::abs(turnOf(way, one)), 24.06, 0.1);
        EXPECT_NEAR(turnOf(way, one), -turnOf(way, other), 1e-6);
        EXPECT_GE(glm::length(way), 0.5 * em - 1e-6);
        const double factor = glm::length(way) / glm::length(asked), turn = turnOf(asked, way);
        EXPECT_LT(std::min({std::abs(factor - 1), std::abs(factor - 0.6), std::abs(factor - 1.6)}), 1e-6);
        EXPECT_NEAR(turn / 45, std::round(turn / 45), 1e-6);
        // The words' middle lies on the arrow's line; they begin where it ends.
        ASSERT_EQ(layout.words.size(), 1U);
        const Box box = boxOf(layout.words[0]);
        const glm::dvec2 beyond = box.middle() - end;
        const double across = std::abs(way.x * beyond.y - way.y * beyond.x) / glm::length(way);
        EXPECT_LT(across, 1.5) << "pixels, for they are rounded";
        EXPECT_GT(glm::dot(beyond, way), 0);
        const glm::dvec2 apart = glm::abs(beyond) - (box.to - box.from) / 2.0;
        EXPECT_NEAR(std::max(apart.x, apart.y), 0.3 * em, 1.5);
        // Was there room as asked?
        const glm::dvec2 unit = asked / glm::length(asked), half = (box.to - box.from) / 2.0 + 0.3 * em;
        const glm::dvec2 middle =
            tip + asked + std::min(half.x / std::abs(unit.x), half.y / std::abs(unit.y)) * unit;
        const glm::dvec2 low = glm::min(middle - half, tip), high = glm::max(middle + half, tip);
        const double rest = margin(em) + 0.7 * em + 1;
        if (low.x > part.from.x + rest && low.y > part.from.y + rest &&
            high.x < part.from.x + part.size.x - rest && high.y < part.from.y + part.size.y - rest) {
            ++straight;
            EXPECT_NEAR(factor, 1, 1e-6);
            EXPECT_NEAR(turn, 0, 1e-6);
        } else {
            turned += std::abs(turn) > 1 ? 1 : 0;
        }
    }
    EXPECT_GT(straight, 30);
    EXPECT_GT(turned, 10);
}

/// The distance of a point from the nearest of some lines.
double distanceTo(const std::vector<std::vector<glm::dvec2>>& lines, const glm::dvec2& p) {
    double least = 1e9;
    for (const std::vector<glm::dvec2>& points : lines)
        for (std::size_t i = 0; i + 1 < points.size(); ++i) {
            const glm::dvec2 way = points[i + 1] - points[i];
            const double part =
                std::clamp(glm::dot(p - points[i], way) / std::max(1e-12, glm::dot(way, way)), 0.0, 1.0);
            least = std::min(least, glm::distance(p, points[i] + part * way));
        }
    return least;
}

// What of a line lies before the eye and in the box is drawn, and nothing else.
TEST(FigurePlaces, LinesAreCutAtTheBoxAndBeforeTheEye) {
    Chance chance(10);
    int inside = 0, outside = 0, behind = 0;
    for (int n = 0; n < 300; ++n) {
        Figure figure = plainFigure(chance, n % 2 ? Projection::parallel : Projection::perspective);
        FigurePart& part = figure.parts[0];
        part.annotations.measurements = true;
        const double reach = n % 3 == 0 ? 60 : 400;
        part.measurements = {{MeasurementKind::distance, {chance.place(reach), chance.place(reach)}}};
        const FigureLayout layout = layOut(figure, evenLetters);
        std::vector<std::vector<glm::dvec2>> lines;
        double edge = 0;
        if (!layout.shapes.empty()) {
            const auto& laid = std::get<LaidLines>(layout.shapes[0]);
            lines = laid.lines, edge = laid.width / 2 + laid.edge;
        }
        ASSERT_LE(lines.size(), 1U);
        double least = 1e9, most = -1e9; // along the line, of what shows
        for (int i = 0; i <= 4000; ++i) {
            const glm::dvec3 mm =
                glm::mix(part.measurements[0].points[0], part.measurements[0].points[1], i / 4000.0);
            glm::dvec2 at(0);
            const double depth = glm::dot(mm - part.camera.position,
                                          glm::normalize(part.camera.focalPoint - part.camera.position));
            if (part.camera.projection == Projection::perspective && depth < 1) {
                behind += depth < 0 ? 1 : 0;
                continue;
            }
            ASSERT_TRUE(pictureFromPatient(part.camera, part.size, mm, at));
            const glm::dvec2 room = glm::min(at, glm::dvec2(part.size) - at) - edge;
            if (std::min(room.x, room.y) < -0.01) {
                ++outside;
            } else if (std::min(room.x, room.y) > 0.01) {
                ++inside;
                EXPECT_LT(distanceTo(lines, at + glm::dvec2(part.from)), 1e-3);
            }
            if (std::min(room.x, room.y) >= 0)
                least = std::min(least, i / 4000.0), most = std::max(most, i / 4000.0);
        }
        if (lines.empty()) {
            EXPECT_LT(most - least, 1e-3);
            EXPECT_EQ(layout.leftOut.size(), 1U);
            continue;
        }
        // The words are at the second point, or at the line's first end where that is not in the picture.
        const Measurement& m = part.measurements[0];
        glm::dvec2 second(0);
        const bool isSeen = pictureFromPatient(part.camera, part.size, m.points[1], second) &&
                            second.x >= 0 && second.y >= 0 && second.x <= part.size.x &&
                            second.y <= part.size.y;
        const glm::dvec2 anchor = isSeen ? second + glm::dvec2(part.from) : lines[0][0];
        for (const LaidWords& words : layout.words) {
            const glm::dvec2 off =
                glm::abs(boxOf(words).middle() - anchor) - (words.to() - words.from()) / 2.0;
            EXPECT_LT(std::max(off.x, off.y), 5.1 * letterPixels(part, figure.dpi) + 1.5);
        }
        for (const glm::dvec2& p : lines[0]) {
            const glm::dvec2 room =
                glm::min(p - glm::dvec2(part.from), glm::dvec2(part.from + part.size) - p) - edge;
            EXPECT_GT(std::min(room.x, room.y), -1e-6);
        }
    }
    EXPECT_GT(inside, 10000);
    EXPECT_GT(outside, 10000);
    EXPECT_GT(behind, 1000);
}

// Whatever a measurement is of, its words are beside its middle, and its lines meet its points.
TEST(FigurePlaces, MeasurementsMeetTheirPoints) {
    Chance chance(11);
    int placed = 0;
    for (int n = 0; n < 90; ++n) {
        Figure figure = plainFigure(chance);
        FigurePart& part = figure.parts[0];
        part.annotations.measurements = true;
        const double em = letterPixels(part, figure.dpi);
        const MeasurementKind kind = n % 3 == 0   ? MeasurementKind::distance
                                     : n % 3 == 1 ? MeasurementKind::angle
                                                  : MeasurementKind::circle;
        Measurement m{kind, {chance.place(12), chance.place(12), chance.place(12)}};
        m.points.resize(n % 3 == 0 ? 2 : 3);
        part.measurements = {m};
        const FigureLayout layout = layOut(figure, evenLetters);
        ASSERT_EQ(layout.shapes.size(), 1U);
        const auto& lines = std::get<LaidLines>(layout.shapes[0]);
        EXPECT_EQ(lines.ink, Ink::light);
        if (kind != MeasurementKind::circle) {
            EXPECT_EQ(lines.lines.size(), m.points.size() - 1);
        }
        const double mmPerPixel = 2 * part.camera.parallelScale / part.size.y;
        const double radius =
            kind == MeasurementKind::circle ? glm::distance(circleCentre(m), m.points[0]) : 0;
        bool all = true; // in the box
        glm::dvec2 at(0), middle(0);
        for (std::size_t i = 0; i < m.points.size(); ++i) {
            ASSERT_TRUE(pictureFromPatient(part.camera, part.size, m.points[i], at));
            all = all && at.x > 9 && at.y > 9 && at.x < part.size.x - 9 && at.y < part.size.y - 9;
            if (i == 1)
                middle = at;
        }
        if (!all)
            continue;
        for (const glm::dvec3& mm : m.points) {
            ASSERT_TRUE(pictureFromPatient(part.camera, part.size, mm, at));
            EXPECT_LT(distanceTo(lines.lines, at + glm::dvec2(part.from)),
                      1e-3 + 0.002 * radius / mmPerPixel);
        }
        if (layout.words.empty())
            continue;
        EXPECT_EQ(layout.words[0].words, describe(m));
        const Box box = boxOf(layout.words[0]);
        const glm::dvec2 off = box.middle() - glm::dvec2(part.from) - middle,
                         apart = glm::abs(off) - (box.to - box.from) / 2.0;
        // To the upper right, if there is room.
        if (middle.x + 0.7 * em + (box.to.x - box.from.x) + margin(em) + 1 < part.size.x &&
            middle.y - 0.7 * em - (box.to.y - box.from.y) - margin(em) - 1 > 0) {
            ++placed;
            EXPECT_NEAR(apart.x, 0.7 * em, 1.01);
            EXPECT_NEAR(apart.y, 0.7 * em, 1.01);
            EXPECT_GT(off.x, 0);
            EXPECT_LT(off.y, 0);
        }
    }
    EXPECT_GT(placed, 30);
}

} // namespace
} // namespace tessera
