// tests/viewer/annotations/figure_layout_test.cpp: what a figure says lies in its part's box, and no words
// lie over others, whatever the figure's size. Words have the sizes of a font of even letters.
#include "viewer/annotations/figure_layout.h"

#include "core/image/colour.h"
#include "core/scene/mode.h"
#include "tests/support/figures.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <random>
#include <string>
#include <variant>

namespace tessera {
namespace {

using test::evenLetters;
using test::fullFigure;

TEST(FigureLayout, StaysInItsBoxAndWordsApart) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> unit(0, 1);
    for (const glm::ivec2 size : {glm::ivec2(128, 96),
                                  {96, 128},
                                  {256, 200},
                                  {512, 512},
                                  {1600, 300},
                                  {300, 1600},
                                  {1920, 1080},
                                  {4096, 4096}})
        for (int n = 0; n < 20; ++n) {
            Figure figure = fullFigure(size, ViewAngles{360 * unit(random) - 180, 170 * unit(random) - 85});
            figure.dpi = n % 3 == 0 ? 96 : 72 + 528 * unit(random);
            figure.parts[0].annotations.textPoints = n % 2 ? 9 : 4 + 60 * unit(random);
            test::expectApart(figure, layOut(figure, evenLetters));
        }
}

TEST(FigureLayout, OfSeveralPartsStaysInEach) {
    Figure figure = fullFigure({400, 300}, {30, 20});
    figure.size = {830, 620};
    for (const glm::ivec2 at : {glm::ivec2(430, 0), {0, 320}, {430, 320}}) {
        figure.parts.push_back(figure.parts.front());
        figure.parts.back().from = at;
    }
    const FigureLayout all = layOut(figure, evenLetters);
    test::expectApart(figure, all);
    Figure alone = figure;
    alone.parts.resize(1);
    const FigureLayout one = layOut(alone, evenLetters);
    ASSERT_EQ(all.words.size(), 4 * one.words.size());
    for (std::size_t i = 0; i < one.words.size(); ++i) {
        EXPECT_EQ(all.words[i].words, one.words[i].words);
        EXPECT_LT(
            glm::length(all.words[i + 3 * one.words.size()].at - one.words[i].at - glm::dvec2(430, 320)),
            1e-9);
    }
}

/// Two pictures along a line with a tick, and one across it.
Figure figureOfInnerPictures(const glm::ivec2& each) {
    Figure figure;
    figure.size = {3 * each.x + 16, each.y};
    FigurePart part;
    part.size = figure.size;
    for (int n = 0; n < 3; ++n) {
        InnerPicture inner;
        inner.from = {n * (each.x + 8), 0};
        inner.size = each;
        inner.words = n == 0 ? "0\u00b0" : n == 1 ? "90\u00b0" : "37 mm";
        inner.left = "R", inner.right = "L";
        inner.lettersOnTop = n < 2;
        if (n < 2)
            inner.ticks = {{0.4 * each.y, n == 0 ? "37 mm" : ""}};
        else
            inner.top = "A", inner.bottom = "P";
        part.inner.push_back(inner);
    }
    figure.parts = {part};
    return figure;
}

TEST(FigureLayout, WordsOfInnerPicturesStayInThem) {
    for (const glm::ivec2 each : {glm::ivec2(200, 300), {90, 400}, {40, 60}, {12, 9}, {700, 700}})
        for (const bool all : {false, true}) {
            Figure figure = figureOfInnerPictures(each);
            EXPECT_TRUE(figure.any());
            if (all) { // with all else that there is
                const std::vector<InnerPicture> inner = figure.parts[0].inner;
                figure = fullFigure(figure.size, {});
                figure.parts[0].inner = inner;
            }
            const FigureLayout layout = layOut(figure, evenLetters);
            test::expectApart(figure, layout);
            if (all)
                continue;
            for (const LaidWords& words : layout.words) {
                const auto in = [&](const InnerPicture& inner) {
                    const glm::dvec2 from(inner.from), to(inner.from + inner.size);
                    return words.from().x >= from.x && words.from().y >= from.y && words.to().x <= to.x &&
                           words.to().y <= to.y;
                };
                EXPECT_TRUE(std::ranges::any_of(figure.parts[0].inner, in)) << words.words;
            }
            if (each.x >= 90) {
                EXPECT_EQ(layout.words.size(), 3U + 6 + 2 + 1);
                EXPECT_TRUE(layout.leftOut.empty());
                ASSERT_EQ(layout.shapes.size(), 4U) << "a tick at either side of two";
                for (const LaidShape& shape : layout.shapes)
                    EXPECT_NEAR(std::get<LaidLines>(shape).lines.at(0).at(0).y, 0.4 * each.y, 1);
                // Letters of a straightened picture are at its upper corners, others at the middle.
                for (const LaidWords& words : layout.words)
                    if (words.words == "R") {
                        EXPECT_EQ(words.at.y < 0.25 * each.y, words.at.x < 2 * each.x) << words.at.x;
                    }
            } else if (each.x < 20) {
                EXPECT_TRUE(layout.words.empty());
                EXPECT_EQ(layout.leftOut.size(), 7U) << "each word once, up to six";
                EXPECT_EQ(layout.leftOut.back(), "other words of its pictures, 1");
            }
        }
    FigurePart bare;
    bare.inner.resize(2);
    EXPECT_FALSE((Figure{{9, 9}, 96, {bare}}.any()));
}

TEST(FigureLayout, HasRoomForAllInAPictureOfUsualSize) {
    Figure figure = fullFigure({640, 640}, {});
    const FigureLayout layout = layOut(figure, evenLetters);
    EXPECT_EQ(layout.leftOut, std::vector<std::string>());
    std::vector<std::string> said;
    for (const LaidWords& words : layout.words)
        said.push_back(words.words);
    for (const char* expected :
         {"A title", "R", "L", "S", "I", "20 mm at the centre", "HU", "-160", "40", "240", "liver", "spleen",
          "1.2 L*u*v*", "40.0 mm", "a lesion", "A", "A caption of a few words"})
        EXPECT_NE(std::find(said.begin(), said.end(), expected), said.end()) << expected;
    EXPECT_EQ(std::count(said.begin(), said.end(), "A"), 1) << "on the cube";
}

TEST(FigureLayout, SaysWhatHasNoRoom) {
    Figure figure = fullFigure({128, 96}, {});
    for (int n = 0; n < 300; ++n)
        figure.parts[0].labels.push_back({"structure " + std::to_string(n), glm::vec3(1, 0, 0)});
    FigureLayout layout = layOut(figure, evenLetters);
    EXPECT_FALSE(layout.leftOut.empty());
    figure = fullFigure({900, 900}, {});
    figure.parts[0].labels.resize(0);
    for (int n = 0; n < 300; ++n)
        figure.parts[0].labels.push_back({"structure " + std::to_string(n), glm::vec3(1, 0, 0)});
    layout = layOut(figure, evenLetters);
    test::expectApart(figure, layout);
    const auto told = std::find_if(layout.words.begin(), layout.words.end(), [](const LaidWords& words) {
        return words.words.starts_with("and ") && words.words.ends_with(" more");
    });
    ASSERT_NE(told, layout.words.end());
    const auto names = std::count_if(layout.words.begin(), layout.words.end(), [](const LaidWords& words) {
        return words.words.starts_with("structure ");
    });
    EXPECT_GT(names, 30);
    EXPECT_EQ(names + std::stoi(told->words.substr(4)), 300);
    ASSERT_EQ(layout.leftOut.size(), 1u);
    EXPECT_EQ(layout.leftOut[0], std::to_string(300 - names) + " of 300 names of labels");
}

// Two numbers of a legend are never read as one, whatever they are and however small the picture is.
TEST(FigureLayout, NumbersOfALegendStandApart) {
    for (int width = 100; width <= 600; width += 20)
        for (const double highest : {9.0, 1000.0, 123456.0, 1e-7}) {
            Figure figure = fullFigure({width, 300}, {});
            FigurePart& part = figure.parts.front();
            part.annotations = {};
            part.annotations.legend = true;
            part.legend.resize(1);
            part.legend[0].low = highest / 10, part.legend[0].high = highest;
            part.legend[0].colours.assign(16, glm::dvec3(0.5));
            const FigureLayout layout = layOut(figure, evenLetters);
            for (const LaidWords& a : layout.words)
                for (const LaidWords& b : layout.words)
                    if (&a != &b && a.from().y == b.from().y && a.from().x < b.from().x) {
                        EXPECT_GE(b.from().x - a.to().x, 0.4 * a.pixels)
                            << width << ": " << a.words << " " << b.words;
                    }
        }
}

// Of a slice, what does not lie in it is left out, and told.
TEST(FigureLayout, MarksBesideASliceAreLeftOut) {
    Figure figure = fullFigure({640, 640}, {});
    FigurePart& part = figure.parts.front();
    part.annotations = {};
    part.annotations.measurements = true;
    const glm::dvec3 normal = glm::normalize(glm::dvec3(1, 2, -2));
    for (const double away : {-3.0, -0.9, 0.0, 0.9, 3.0}) {
        part.plane = ShownPlane{{5, 0, 0}, normal, 1};
        const glm::dvec3 there = glm::dvec3(5, 0, 0) + away * normal,
                         along = glm::normalize(glm::dvec3(2, -1, 0));
        part.annotations.arrows = {{there, {30, -20}, "here"}};
        part.measurements = {{MeasurementKind::distance, {glm::dvec3(5, 0, 0), there + 9.0 * along}}};
        const FigureLayout layout = layOut(figure, evenLetters);
        EXPECT_EQ(layout.leftOut.size(), std::abs(away) > 1 ? 2u : 0u) << away;
        EXPECT_EQ(layout.shapes.empty(), std::abs(away) > 1) << away;
    }
}

TEST(FigureLayout, TellsNoDirectionsThatTheVolumeDoesNot) {
    Figure figure = fullFigure({512, 512}, {});
    figure.parts[0].orientationKnown = false;
    const FigureLayout layout = layOut(figure, evenLetters);
    for (const LaidWords& words : layout.words)
        EXPECT_GT(words.words.size(), 1u) << words.words;
    ASSERT_EQ(layout.leftOut.size(), 1u);
    EXPECT_EQ(layout.leftOut[0].substr(0, 25), "the patient's directions:");
}

// The tip is where the camera sees the place; the words are at the other end.
TEST(FigureLayout, ArrowsPointAtTheirPlaces) {
    for (const Projection projection : {Projection::parallel, Projection::perspective}) {
        Figure figure = fullFigure({640, 640}, {40, 10}, projection);
        FigurePart& part = figure.parts.front();
        part.annotations = {};
        part.annotations.arrows = {{{20, -10, 15}, {30, -20}, "here"}};
        const FigureLayout layout = layOut(figure, evenLetters);
        ASSERT_EQ(layout.shapes.size(), 1u);
        const auto& lines = std::get<LaidLines>(layout.shapes[0]);
        glm::dvec2 at(0);
        ASSERT_TRUE(pictureFromPatient(part.camera, part.size, {20, -10, 15}, at));
        EXPECT_LT(glm::length(lines.lines[0].back() - at), 1e-9);
        EXPECT_LT(glm::length(lines.lines[1][1] - at), 1e-9) << "the head's tip";
        EXPECT_LT(glm::length(lines.lines[0].front() - at - glm::dvec2(30, -20) * (96 / 72.0)), 1e-9);
        ASSERT_EQ(layout.words.size(), 1u);
        EXPECT_GT(layout.words[0].from().x, at.x);
        EXPECT_LT(layout.words[0].to().y, at.y);
        part.annotations.arrows[0].place = {5000, 0, 0};
        EXPECT_EQ(layOut(figure, evenLetters).leftOut,
                  (std::vector<std::string>{"the arrow \"here\": the picture does not show its place"}));
    }
}

// Lines are cut at the box, and before the eye.
TEST(FigureLayout, MeasurementsAreWhereTheCameraSeesThem) {
    Figure figure = fullFigure({400, 300}, {}, Projection::perspective);
    FigurePart& part = figure.parts.front();
    part.annotations = {};
    part.annotations.measurements = true;
    const glm::dvec3 a(-30, 0, 10), b(40, 5, -20),
        behind = 2.0 * part.camera.position - part.camera.focalPoint;
    part.measurements = {{MeasurementKind::distance, {a, b}}};
    FigureLayout layout = layOut(figure, evenLetters);
    glm::dvec2 p(0), q(0);
    ASSERT_TRUE(pictureFromPatient(part.camera, part.size, a, p) &&
                pictureFromPatient(part.camera, part.size, b, q));
    const auto line = [&] { return std::get<LaidLines>(layout.shapes.at(0)).lines.at(0); };
    EXPECT_LT(glm::length(line()[0] - p) + glm::length(line()[1] - q), 1e-9);
    part.measurements = {{MeasurementKind::distance, {a, behind + glm::dvec3(9, 0, 0)}}};
    layout = layOut(figure, evenLetters);
    test::expectApart(figure, layout);
    EXPECT_LT(glm::length(line()[0] - p), 1e-9);
    part.measurements = {{MeasurementKind::distance, {behind, behind + glm::dvec3(9, 0, 0)}}};
    layout = layOut(figure, evenLetters);
    EXPECT_TRUE(layout.shapes.empty());
    EXPECT_EQ(layout.leftOut.size(), 1u);
    // A circle across the view keeps its radius.
    part.camera.projection = Projection::parallel;
    const double mmPerPixel = 2 * part.camera.parallelScale / part.size.y;
    part.measurements = {{MeasurementKind::circle, {{20, 0, 0}, {0, 0, 20}, {-20, 0, 0}}}};
    layout = layOut(figure, evenLetters);
    ASSERT_TRUE(pictureFromPatient(part.camera, part.size, {0, 0, 0}, p));
    for (const std::vector<glm::dvec2>& piece : std::get<LaidLines>(layout.shapes.at(0)).lines)
        EXPECT_NEAR(glm::length(piece[0] - p) * mmPerPixel, 20, 1e-6);
}

// A colour of the legend is the function's at the value that is written there.
TEST(FigureLayout, LegendsHaveTheFunctionsColours) {
    Figure figure = fullFigure({640, 480}, {});
    FigurePart& part = figure.parts.front();
    part.annotations = {};
    part.annotations.legend = true;
    const TransferFunction function = TransferFunction::fromOpacity(
        {{-160, 0}, {240, 1}}, {{-160, {0, 0, 1}}, {0, {0.2, 1, 0}}, {240, {1, 0, 0.5}}}, 1);
    Scene scene;
    scene.volumes = {{"v.zarr", function}};
    ValueSummary values;
    values.lowest = -1000, values.highest = 2000;
    part.legend = colourLegend(scene, std::vector<LegendVolume>{{values, "HU"}});
    const FigureLayout layout = layOut(figure, evenLetters);
    const auto& whole = std::get<LaidArea>(layout.shapes.at(2));
    const double left = whole.corners[0].x, right = whole.corners[1].x;
    const auto valueWords = [&](const std::string& text) {
        return *std::find_if(layout.words.begin(), layout.words.end(),
                             [&](const LaidWords& words) { return words.words == text; });
    };
    EXPECT_NEAR(valueWords("-160").from().x, left, 1);
    EXPECT_NEAR(valueWords("240").to().x, right, 1);
    for (double x = left + 0.5; x < right; ++x) {
        glm::vec3 shown(0); // the last one that lies there
        for (const LaidShape& shape : layout.shapes)
            if (const auto* const area = std::get_if<LaidArea>(&shape))
                if (area->corners[0].x < x && x < area->corners[1].x)
                    shown = area->colour;
        const double value = -160 + 400 * (x - left) / (right - left);
        const glm::dvec3 truth = colourOfValue({ValueColour::transferFunction, {}}, function, value);
        EXPECT_LT(glm::length(glm::dvec3(shown) - truth), 1.5 * 2.5 / 64) << value;
    }
}

TEST(Words, AreBrokenAndCut) {
    const auto lines = [](const std::string& words, double letters, std::size_t most) {
        return brokenWords(words, 10, 6 * letters, most, evenLetters).lines;
    };
    using Lines = std::vector<std::string>;
    EXPECT_EQ(lines("one two three", 20, 3), (Lines{"one two three"}));
    EXPECT_EQ(lines("one two three", 8, 3), (Lines{"one two", "three"}));
    EXPECT_EQ(lines("one\ntwo  three", 20, 3), (Lines{"one", "two three"}));
    EXPECT_EQ(lines("one two three four", 8, 2), (Lines{"one two", "three f\xe2\x80\xa6"}));
    EXPECT_EQ(lines("incomprehensible", 6, 2), (Lines{"incom\xe2\x80\xa6"}));
    EXPECT_EQ(lines("a\nb\nc", 9, 2), (Lines{"a", "b c"}));
    EXPECT_EQ(lines("a\nb\nc d e f g h i", 9, 2), (Lines{"a", "b c d e\xe2\x80\xa6"}));
    EXPECT_EQ(lines("abc", 0.5, 2), Lines());
    EXPECT_EQ(lines("", 9, 2), Lines());
    EXPECT_EQ(cutWords("\xc3\xa4\xc3\xb6\xc3\xbc\xc3\x9f\xc3\xa4", 10, 18, evenLetters),
              "\xc3\xa4\xc3\xb6\xe2\x80\xa6")
        << "whole letters";
}

TEST(FigureLayout, TellsOnceThatDirectionsAreUnknown) {
    for (const Directions asked : {Directions::letters, Directions::cube, Directions::all}) {
        Figure figure = fullFigure({512, 512}, {});
        figure.parts[0].orientationKnown = false;
        figure.parts[0].annotations.directions = asked;
        EXPECT_EQ(layOut(figure, evenLetters).leftOut,
                  std::vector<std::string>{"the patient's directions: the volume does not tell them"});
    }
    Figure figure = fullFigure({512, 512}, {});
    figure.parts[0].orientationKnown = false;
    figure.parts[0].annotations.directions = Directions::none;
    EXPECT_TRUE(layOut(figure, evenLetters).leftOut.empty());
}

std::string wordsOfLength(std::size_t letters) {
    std::string words;
    while (words.size() < letters)
        words += "caption ";
    return words.substr(0, letters);
}

// No words end without a word about it.
TEST(FigureLayout, SaysWhereWordsAreCut) {
    using Said = std::vector<std::string>;
    Figure figure = fullFigure({400, 300}, {});
    FigurePart& part = figure.parts.front();
    const auto leftOut = [&] { return layOut(figure, evenLetters).leftOut; };
    part.annotations = {};
    part.annotations.title = part.annotations.caption = "short";
    EXPECT_EQ(leftOut(), Said());
    part.annotations.title = wordsOfLength(900);
    EXPECT_EQ(leftOut(), Said{"the end of the title"});
    part.annotations = {};
    part.annotations.caption = wordsOfLength(900);
    EXPECT_EQ(leftOut(), Said{"the end of the caption"});
    part.annotations = {};
    part.annotations.arrows = {{{0, 0, 0}, {24, -24}, wordsOfLength(200)}};
    EXPECT_EQ(leftOut(), Said{"the end of the words of the arrow \"" + wordsOfLength(200) + "\""});
    part.annotations = {};
    part.annotations.labelLegend = true;
    part.labels = {{wordsOfLength(60), glm::vec3(1)}, {"liver", glm::vec3(1)}};
    EXPECT_EQ(leftOut(), Said{"the end of the name " + wordsOfLength(60)});
    part.annotations = {};
    part.annotations.legend = true;
    part.legend.front().unit = wordsOfLength(60);
    EXPECT_EQ(leftOut(), Said{"the end of the title " + wordsOfLength(60)});
    part.annotations = {};
    part.annotations.title = "words";
    figure.size = part.size = {8, 400};
    EXPECT_EQ(leftOut(), Said{"the title"});
}

// The words of a figure of panels lie beside its panels, and have no more room than they need.
TEST(FigureLayout, StripsHoldTheirWordsAndLittleMore) {
    std::mt19937 random(5);
    std::uniform_int_distribution<int> extent(200, 2000), letters(0, 1000), dots(72, 600);
    for (int n = 0; n < 400; ++n) {
        Figure figure;
        FigurePart part;
        part.size = {extent(random), extent(random)};
        figure.dpi = dots(random);
        part.annotations.textPoints = n % 3 == 0 ? 9 : 4 + n % 40;
        part.annotations.title = wordsOfLength(static_cast<std::size_t>(letters(random) / (1 + n % 20)));
        part.annotations.caption = wordsOfLength(static_cast<std::size_t>(letters(random) / (1 + n % 7)));
        if (n % 5 == 0)
            part.annotations.caption = "one\ntwo\nthree\nfour";
        SCOPED_TRACE(std::to_string(n) + ": " + std::to_string(part.size.x) + " x " +
                     std::to_string(part.size.y) + ", " + std::to_string(figure.dpi));
        const StripHeights strips = stripsNeeded(part, figure.dpi, evenLetters);
        const int panels = part.size.y;
        part.size.y += strips.above + strips.below;
        figure.size = part.size;
        figure.parts = {part};
        const FigureLayout layout = layOut(figure, evenLetters);
        double title = 0, caption = 0, most = 0;
        for (const LaidWords& words : layout.words) {
            if (words.to().y <= strips.above)
                title = std::max(title, words.to().y);
            else
                caption = std::max(caption, part.size.y - words.from().y);
            EXPECT_TRUE(words.to().y <= strips.above || words.from().y >= strips.above + panels)
                << words.words;
            most = std::max(most, words.pixels);
        }
        EXPECT_EQ(title > 0, !part.annotations.title.empty());
        EXPECT_EQ(caption > 0, !part.annotations.caption.empty());
        EXPECT_LE(strips.above, 1.3 * title + most);
        EXPECT_LE(strips.below, 1.3 * caption + most);
    }
}

TEST(FigureLayout, MarksOfPanelsAreInTheirCorner) {
    for (const glm::ivec2 size : {glm::ivec2(160, 120), {400, 300}, {1200, 1200}})
        for (const std::string title :
             {"", "A title", "a title of so many words that it needs all of a row"}) {
            Figure figure = fullFigure(size, {});
            figure.parts[0].mark = "B";
            figure.parts[0].annotations.title = title;
            const FigureLayout layout = layOut(figure, evenLetters);
            test::expectApart(figure, layout);
            ASSERT_FALSE(layout.words.empty());
            const LaidWords& mark = layout.words.front();
            EXPECT_EQ(mark.words, "B");
            EXPECT_TRUE(mark.bold);
            EXPECT_LT(mark.from().x + mark.from().y, 1.2 * mark.pixels);
            for (std::size_t n = 1; n < layout.words.size(); ++n) {
                EXPECT_GT(mark.pixels, layout.words[n].pixels);
                EXPECT_FALSE(layout.words[n].bold);
            }
            EXPECT_EQ(std::ranges::count(layout.leftOut, "the title"), 0);
        }
    Figure alone;
    alone.parts.emplace_back();
    EXPECT_FALSE(alone.any());
    alone.parts[0].mark = "A";
    EXPECT_TRUE(alone.any());
}

// What a letter says holds at an edge: one that has no room near its own is left out, and that is told.
TEST(FigureLayout, LettersStayAtTheirEdges) {
    int leftOut = 0;
    for (const int side : {200, 300, 450, 800})
        for (const std::size_t letters : {0u, 40u, 200u, 900u})
            for (const double dpi : {96.0, 300.0}) {
                Figure figure = fullFigure({side, side}, {0, 0});
                figure.dpi = dpi;
                figure.parts[0].annotations.caption = std::string(letters, 'x');
                figure.parts[0].annotations.directions = Directions::letters;
                const FigureLayout layout = layOut(figure, evenLetters);
                for (const std::string letter : {"S", "I", "R", "L"}) {
                    const auto at = std::ranges::find(layout.words, letter, &LaidWords::words);
                    if (at == layout.words.end()) {
                        ++leftOut;
                        EXPECT_NE(std::ranges::find(layout.leftOut, "the letters " + letter),
                                  layout.leftOut.end());
                        continue;
                    }
                    const double y = (at->from().y + at->to().y) / 2 / side;
                    const double own = letter == "S" ? 0 : letter == "I" ? 1 : 0.5;
                    EXPECT_NEAR(y, own, 0.33) << letter << " of " << side << ", " << letters;
                }
            }
    EXPECT_GT(leftOut, 0);
}

} // namespace
} // namespace tessera
