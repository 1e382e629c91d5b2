// tests/viewer/annotations/layout_drawing_test.cpp: areas and lines of a layout, pixel by pixel, in pictures;
// and the whole layout as an SVG page has it.
#include "viewer/annotations/layout_drawing.h"

#include "core/image/colour.h"
#include "tests/support/figures.h"
#include "viewer/annotations/figure_drawing.h"

#include <algorithm>
#include <cairo.h>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <iterator>
#include <random>
#include <string>
#include <unistd.h>
#include <vector>

namespace tessera {
namespace {

namespace fs = std::filesystem;
using test::fullFigure;

/// A canvas of Cairo's, of 8 bits, transparent before.
class Canvas {
  public:
    explicit Canvas(const glm::ivec2& size)
        : size_(size), surface_(cairo_image_surface_create(CAIRO_FORMAT_ARGB32, size.x, size.y)),
          cairo_(cairo_create(surface_)) {}
    Canvas(const Canvas&) = delete;
    Canvas& operator=(const Canvas&) = delete;
    ~Canvas() {
        cairo_destroy(cairo_);
        cairo_surface_destroy(surface_);
    }
    void draw(const FigureLayout& layout, const glm::dvec2& from, const glm::dvec2& to) {
        drawLayout(cairo_, layout, words_, from, to);
        cairo_surface_flush(surface_);
    }
    std::uint32_t at(int x, int y) const {
        std::uint32_t pixel = 0;
        std::memcpy(
            &pixel,
            cairo_image_surface_get_data(surface_) + y * cairo_image_surface_get_stride(surface_) + 4 * x, 4);
        return pixel;
    }
    /// The upper left and the lower right of what is drawn.
    std::pair<glm::ivec2, glm::ivec2> drawn() const {
        glm::ivec2 from(size_), to(0);
        for (int y = 0; y < size_.y; ++y)
            for (int x = 0; x < size_.x; ++x)
                if (at(x, y) >> 24 != 0)
                    from = glm::min(from, {x, y}), to = glm::max(to, {x + 1, y + 1});
        return {from, to};
    }

  private:
    glm::ivec2 size_;
    cairo_surface_t* surface_;
    cairo_t* cairo_;
    PangoWords words_;
};

constexpr glm::ivec2 kSize{90, 70};

LaidArea rectangle(const glm::dvec2& from, const glm::dvec2& to, const glm::vec3& colour) {
    LaidArea area;
    area.corners = {from, {to.x, from.y}, to, {from.x, to.y}};
    area.colour = colour;
    return area;
}
std::uint32_t opaque(const glm::ivec3& code) {
    return 255U << 24 | static_cast<std::uint32_t>(code.r) << 16 | static_cast<std::uint32_t>(code.g) << 8 |
           static_cast<std::uint32_t>(code.b);
}

// Later shapes lie over earlier ones, each in its own colour and to its own edges.
TEST(LayoutDrawing, AreasAreTheirColoursToTheirEdges) {
    std::mt19937 random(1);
    const auto below = [&](int most) { return static_cast<int>(random() % static_cast<unsigned>(most)); };
    for (int n = 0; n < 30; ++n) {
        FigureLayout layout;
        std::vector<std::uint32_t> expected(static_cast<std::size_t>(kSize.x * kSize.y));
        for (int k = 0; k < 6; ++k) {
            const glm::ivec2 from(below(kSize.x), below(kSize.y)),
                to = glm::min(from + 1 + glm::ivec2(below(40), below(40)), kSize);
            const glm::ivec3 code(below(256), below(256), below(256));
            glm::vec3 linear(0);
            for (int c = 0; c < 3; ++c)
                linear[c] = static_cast<float>(linearFromSrgb(code[c] / 255.0));
            layout.shapes.emplace_back(rectangle(glm::dvec2(from), glm::dvec2(to), linear));
            for (int y = from.y; y < to.y; ++y)
                for (int x = from.x; x < to.x; ++x)
                    expected[static_cast<std::size_t>(y * kSize.x + x)] = opaque(code);
        }
        Canvas canvas(kSize);
        canvas.draw(layout, {0, 0}, glm::dvec2(kSize));
        for (int y = 0; y < kSize.y; ++y)
            for (int x = 0; x < kSize.x; ++x)
                ASSERT_EQ(canvas.at(x, y), expected[static_cast<std::size_t>(y * kSize.x + x)])
                    << x << ", " << y;
    }
    EXPECT_EQ(codeOfColour({-1, 2, 0.5F}), glm::dvec3(0, 1, 188 / 255.0)) << "0.5 is code 187.5";
    FigureLayout layout;
    LaidArea half = rectangle({10, 10}, {20, 20}, glm::vec3(1));
    half.opacity = 0.4F;
    layout.shapes = {half};
    Canvas canvas(kSize);
    canvas.draw(layout, {0, 0}, glm::dvec2(kSize));
    EXPECT_EQ(canvas.at(15, 15), 0x66666666U);
}

// A line is as wide as it says, with an edge of the other ink around it, at its ends as well.
TEST(LayoutDrawing, LinesHaveTheirWidthAndAnEdgeAllAround) {
    std::mt19937 random(2);
    const auto below = [&](int most) { return static_cast<int>(random() % static_cast<unsigned>(most)); };
    for (int n = 0; n < 60; ++n) {
        const int axis = n % 2, half = 1 + below(4), edge = below(4);
        LaidLines lines;
        lines.width = 2 * half;
        lines.edge = edge;
        lines.ink = n % 3 == 0 ? Ink::dark : Ink::light;
        glm::ivec2 a(20 + below(20), 20 + below(20)), b = a;
        b[axis] += 1 + below(20);
        glm::ivec2 from = a, to = b;
        from[1 - axis] -= half, to[1 - axis] += half;
        if (n % 5 == 0)
            std::swap(a, b);
        lines.lines = {{glm::dvec2(a), glm::dvec2(b)}};
        FigureLayout layout;
        layout.shapes = {lines};
        Canvas canvas(kSize);
        canvas.draw(layout, {0, 0}, glm::dvec2(kSize));
        const std::uint32_t ink = opaque(glm::ivec3(lines.ink == Ink::light ? 255 : 0)),
                            other = opaque(glm::ivec3(lines.ink == Ink::light ? 0 : 255));
        for (int y = 0; y < kSize.y; ++y)
            for (int x = 0; x < kSize.x; ++x) {
                const bool inside = x >= from.x && x < to.x && y >= from.y && y < to.y,
                           around =
                               x >= from.x - edge && x < to.x + edge && y >= from.y - edge && y < to.y + edge;
                ASSERT_EQ(canvas.at(x, y), inside ? ink : around ? other : 0U) << x << ", " << y;
            }
    }
}

// A closed line has no ends: its corners are whole, and it becomes no longer.
TEST(LayoutDrawing, ClosedLinesHaveWholeCorners) {
    LaidLines lines;
    lines.width = 4;
    lines.edge = 2;
    lines.lines = {{{20, 20}, {60, 20}, {60, 50}, {20, 50}, {20, 20}}};
    FigureLayout layout;
    layout.shapes = {lines};
    Canvas canvas(kSize);
    canvas.draw(layout, {0, 0}, glm::dvec2(kSize));
    const auto within = [](int x, int y, int by) {
        return x >= 20 - by && x < 60 + by && y >= 20 - by && y < 50 + by;
    };
    for (int y = 0; y < kSize.y; ++y)
        for (int x = 0; x < kSize.x; ++x)
            ASSERT_EQ(canvas.at(x, y), within(x, y, 2) && !within(x, y, -2)   ? 0xffffffffU
                                       : within(x, y, 4) && !within(x, y, -4) ? 0xff000000U
                                                                              : 0U)
                << x << ", " << y;
    EXPECT_EQ(lengthened(lines), lines.lines);
    lines.lines = {{{0, 0}, {3, 4}, {3, 14}}};
    EXPECT_LT(glm::distance(lengthened(lines)[0][0], {-1.2, -1.6}), 1e-9);
    EXPECT_EQ(lengthened(lines)[0][1], glm::dvec2(3, 4));
    EXPECT_LT(glm::distance(lengthened(lines)[0][2], {3, 16}), 1e-9);
}

// What meets a tile is drawn in it, so tiles join to the picture.
TEST(LayoutDrawing, TilesHaveAllThatMeetsThem) {
    PangoWords words;
    const Figure figure = fullFigure({400, 330}, {30, 20});
    const FigureLayout layout = layOut(figure, [&](const std::string& text, double pixels, bool bold) {
        return words.measure(text, pixels, bold);
    });
    Canvas whole(figure.size);
    whole.draw(layout, {0, 0}, glm::dvec2(figure.size));
    constexpr int kTile = 30;
    int empty = 0;
    for (int top = 0; top < figure.size.y; top += kTile)
        for (int left = 0; left < figure.size.x; left += kTile) {
            const glm::dvec2 from(left, top), to = from + static_cast<double>(kTile);
            Canvas tile(figure.size);
            tile.draw(layout, from, to);
            bool any = false;
            for (int y = top; y < std::min(top + kTile, figure.size.y); ++y)
                for (int x = left; x < std::min(left + kTile, figure.size.x); ++x) {
                    ASSERT_EQ(tile.at(x, y), whole.at(x, y)) << x << ", " << y;
                    any = any || whole.at(x, y) != 0;
                }
            EXPECT_TRUE(!any || drawsWithin(layout, from, to));
            empty += drawsWithin(layout, from, to) ? 0 : 1;
        }
    EXPECT_GT(empty, 5) << "what meets nothing is not drawn";
}

// Words are drawn where their box is: from its left to its right, on its baseline.
TEST(LayoutDrawing, WordsFillTheirBoxes) {
    PangoWords measure;
    for (const double pixels : {20.0, 26.0, 37.0})
        for (const bool bold : {false, true}) {
            LaidWords words;
            words.words = "HIHEH";
            words.at = {30, 60};
            words.pixels = pixels;
            words.bold = bold;
            words.edge = 2;
            words.ink = bold ? Ink::light : Ink::dark;
            words.size = measure.measure(words.words, pixels, bold);
            FigureLayout layout;
            layout.words = {words};
            Canvas canvas({300, 90});
            canvas.draw(layout, {0, 0}, {300, 90});
            const auto [from, to] = canvas.drawn();
            EXPECT_NEAR(from.x, words.from().x, 0.12 * pixels + 1);
            EXPECT_NEAR(to.x, words.to().x, 0.12 * pixels + 1);
            EXPECT_NEAR(to.y, words.at.y + words.edge, 1) << "the baseline";
            EXPECT_NEAR(to.y - from.y, 0.73 * pixels + 2 * words.edge, 0.05 * pixels + 2) << "capitals";
            EXPECT_GE(from.y, words.from().y);
            EXPECT_NEAR(words.size.height(), 1.165 * pixels, 0.03 * pixels);
            int light = 0, dark = 0; // in the middle of a stem, and around it
            for (int y = from.y; y < to.y; ++y)
                for (int x = from.x; x < to.x; ++x)
                    light += canvas.at(x, y) == 0xffffffffU, dark += canvas.at(x, y) == 0xff000000U;
            EXPECT_GT(light, 10);
            EXPECT_GT(dark, 10);
            const int middle = static_cast<int>(std::lround(words.at.y - 0.36 * pixels));
            int x = from.x;
            while (canvas.at(x, middle) >> 24 != 255)
                ++x;
            EXPECT_EQ(canvas.at(x, middle), words.ink == Ink::light ? 0xff000000U : 0xffffffffU)
                << "the edge is outside";
        }
    EXPECT_GT(measure.measure("HIHEH", 20, true).width, measure.measure("HIHEH", 20, false).width);
    EXPECT_NEAR(measure.measure("HIHEH", 40).width, 2 * measure.measure("HIHEH", 20).width, 0.5);
}

/// A number of an element of SVG.
double numberOf(const std::string& element, const std::string& name) {
    const std::size_t at = element.find(" " + name + "=\"");
    return at == std::string::npos ? NAN : std::stod(element.substr(at + name.size() + 3));
}
std::string textOf(const std::string& element, const std::string& name) {
    const std::size_t at = element.find(" " + name + "=\"");
    if (at == std::string::npos)
        return "";
    const std::size_t from = at + name.size() + 3;
    return element.substr(from, element.find('"', from) - from);
}
/// All elements of a name, from the first on: their tags, and the text that follows.
std::vector<std::pair<std::string, std::string>> elementsOf(const std::string& svg, const std::string& name) {
    std::vector<std::pair<std::string, std::string>> found;
    for (std::size_t at = svg.find("<" + name + " "); at != std::string::npos;
         at = svg.find("<" + name + " ", at + 1)) {
        const std::size_t end = svg.find('>', at);
        found.emplace_back(svg.substr(at, end - at + 1), svg.substr(end + 1, svg.find('<', end) - end - 1));
    }
    return found;
}
void expectPath(const std::string& element, const std::vector<std::vector<glm::dvec2>>& pieces, bool area) {
    std::string path = textOf(element, "d");
    for (const std::vector<glm::dvec2>& points : pieces) {
        for (std::size_t n = 0; n < points.size(); ++n) {
            char* end = nullptr;
            ASSERT_EQ(path.substr(0, 1), n == 0 ? "M" : "L");
            const double x = std::strtod(path.c_str() + 1, &end), y = std::strtod(end, &end);
            EXPECT_LT(glm::distance(glm::dvec2(x, y), points[n]), 0.001);
            path = end;
        }
        if (area || (points.size() > 2 && points.front() == points.back())) {
            ASSERT_EQ(path.substr(0, 1), "Z");
            path = path.substr(1);
        }
    }
    EXPECT_EQ(path, "");
}
std::string hexOf(const glm::vec3& colour) {
    char text[16];
    const auto code = [&](int c) {
        return static_cast<int>(std::lround(255 * srgbFromLinear(static_cast<double>(colour[c]))));
    };
    std::snprintf(text, sizeof text, "#%02x%02x%02x", code(0), code(1), code(2));
    return text;
}

// The numbers of a page are those of the layout.
TEST(SvgLayout, IsTheLayout) {
    const fs::path file =
        fs::temp_directory_path() / ("tessera-svg-layout-" + std::to_string(::getpid()) + ".svg");
    PangoWords words;
    MemoryBudget ram("RAM", "--ram", std::size_t{1} << 30);
    for (const bool onLight : {false, true}) {
        Figure figure = fullFigure({420, 350}, {35, 25});
        FigurePart& part = figure.parts[0];
        part.onLight = onLight;
        part.mark = "B";
        part.annotations.title = "a < \"b\" & c > d";
        writePage(file, Image(figure.size), figure, "{}", ram);
        std::ifstream in(file, std::ios::binary);
        const std::string svg{std::istreambuf_iterator<char>(in), {}};
        const FigureLayout layout = layOut(figure, [&](const std::string& text, double pixels, bool bold) {
            return words.measure(text, pixels, bold);
        });
        EXPECT_NE(svg.find("<title>a &lt; &quot;b&quot; &amp; c &gt; d</title>"), std::string::npos);
        const auto texts = elementsOf(svg, "text"), paths = elementsOf(svg, "path");
        ASSERT_EQ(texts.size(), layout.words.size());
        for (std::size_t n = 0; n < texts.size(); ++n) {
            const LaidWords& laid = layout.words[n];
            const auto& [tag, text] = texts[n];
            EXPECT_NEAR(numberOf(tag, "x"), laid.at.x, 0.001);
            EXPECT_NEAR(numberOf(tag, "y"), laid.at.y, 0.001);
            EXPECT_NEAR(numberOf(tag, "font-size"), laid.pixels, 0.001);
            EXPECT_NEAR(numberOf(tag, "textLength"), laid.size.width, 0.001);
            EXPECT_NEAR(numberOf(tag, "stroke-width"), 2 * laid.edge, 0.001);
            EXPECT_EQ(textOf(tag, "font-weight"), laid.bold ? "bold" : "");
            EXPECT_EQ(textOf(tag, "fill"), laid.ink == Ink::light ? "#ffffff" : "#000000");
            EXPECT_EQ(textOf(tag, "stroke"), laid.ink == Ink::light ? "#000000" : "#ffffff");
            EXPECT_EQ(text, laid.words == part.annotations.title ? "a &lt; &quot;b&quot; &amp; c &gt; d"
                                                                 : laid.words);
        }
        std::size_t next = 0;
        for (const LaidShape& shape : layout.shapes) {
            if (const auto* const area = std::get_if<LaidArea>(&shape)) {
                ASSERT_LT(next, paths.size());
                const std::string& tag = paths[next++].first;
                EXPECT_EQ(textOf(tag, "fill"), hexOf(area->colour));
                EXPECT_EQ(textOf(tag, "fill-opacity"), "");
                expectPath(tag, {area->corners}, true);
                continue;
            }
            const auto& lines = std::get<LaidLines>(shape);
            ASSERT_LT(next + (lines.edge > 0 ? 1 : 0), paths.size());
            const std::string light = "#ffffff", dark = "#000000";
            const bool isLight = lines.ink == Ink::light;
            for (const bool edge : {true, false}) {
                if (edge && lines.edge <= 0)
                    continue;
                const std::string& tag = paths[next++].first;
                EXPECT_EQ(textOf(tag, "fill"), "none");
                EXPECT_EQ(textOf(tag, "stroke"), isLight != edge ? light : dark);
                EXPECT_NEAR(numberOf(tag, "stroke-width"), lines.width + (edge ? 2 * lines.edge : 0), 0.001);
                expectPath(tag, edge ? lengthened(lines) : lines.lines, false);
            }
        }
        EXPECT_EQ(next, paths.size());
    }
    fs::remove(file);
}

} // namespace
} // namespace tessera
