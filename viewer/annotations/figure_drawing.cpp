// viewer/annotations/figure_drawing.cpp: see figure_drawing.h.
#include "viewer/annotations/figure_drawing.h"

#include "core/base/error.h"
#include "core/base/output_file.h"
#include "core/base/shown_text.h"
#include "core/image/colour.h"
#include "core/image/page_format.h"
#include "viewer/annotations/figure_layout.h"
#include "viewer/annotations/layout_drawing.h"
#include "viewer/annotations/pages.h"
#include "viewer/annotations/pango_words.h"

#include <algorithm>
#include <array>
#include <cairo.h>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <glm/common.hpp>
#include <glm/vec4.hpp>
#include <memory>
#include <new>
#include <pango/pango.h>
#include <span>

namespace tessera {
namespace {

using Surface = std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)>;
using Context = std::unique_ptr<cairo_t, decltype(&cairo_destroy)>;

MeasureWords measureBy(PangoWords& words) {
    return
        [&](const std::string& text, double pixels, bool bold) { return words.measure(text, pixels, bold); };
}

FigureLayout laidOut(const Figure& figure, PangoWords& words) {
    return layOut(figure, measureBy(words));
}

/// The linear value of every 8-bit code of sRGB.
const std::array<float, 256>& linearOfCode() {
    static const std::array<float, 256> values = [] {
        std::array<float, 256> all{};
        for (std::size_t code = 0; code < all.size(); ++code)
            all[code] = static_cast<float>(linearFromSrgb(static_cast<double>(code) / 255));
        return all;
    }();
    return values;
}

/// A pixel of Cairo's (sRGB, premultiplied) in linear light, premultiplied.
glm::vec4 linearOf(std::uint32_t pixel) {
    const std::uint32_t alpha = pixel >> 24;
    const float share = static_cast<float>(alpha) / 255;
    glm::vec4 colour(0, 0, 0, share);
    for (int c = 0; c < 3; ++c) {
        const std::uint32_t code =
            std::min<std::uint32_t>(255, ((pixel >> (16 - 8 * c) & 255) * 255 + alpha / 2) / alpha);
        colour[c] = share * linearOfCode()[code];
    }
    return colour;
}

/// One of Cairo's images, transparent.
Surface imageOf(cairo_format_t format, const glm::ivec2& size) {
    Surface surface(cairo_image_surface_create(format, size.x, size.y), cairo_surface_destroy);
    if (cairo_surface_status(surface.get()) != CAIRO_STATUS_SUCCESS)
        throw std::bad_alloc();
    return surface;
}

/// Calls visit(x, y, pixel) for every pixel of an image of Cairo's.
template <typename Visit>
void eachPixel(cairo_surface_t* surface, const glm::ivec2& size, const Visit& visit) {
    cairo_surface_flush(surface);
    unsigned char* const bytes = cairo_image_surface_get_data(surface);
    const int stride = cairo_image_surface_get_stride(surface);
    for (int y = 0; y < size.y; ++y) {
        auto* const row = reinterpret_cast<std::uint32_t*>(bytes + static_cast<std::ptrdiff_t>(y) * stride);
        for (int x = 0; x < size.x; ++x)
            visit(x, y, row[x]);
    }
    cairo_surface_mark_dirty(surface);
}

/// The picture in sRGB of 8 bits.
Surface surfaceOf(const Image& picture) {
    const bool opaque = std::all_of(picture.pixels.begin(), picture.pixels.end(),
                                    [](const glm::vec4& p) { return p.a >= 1; });
    Surface surface = imageOf(opaque ? CAIRO_FORMAT_RGB24 : CAIRO_FORMAT_ARGB32, picture.size);
    eachPixel(surface.get(), picture.size, [&](int x, int y, std::uint32_t& pixel) {
        const glm::dvec4 p(picture.at(x, y));
        const double alpha = p.a > 0 ? std::min(p.a, 1.0) : 0; // NaN is 0
        const glm::dvec3 code = codeOfColour(alpha > 0 ? glm::vec3(glm::dvec3(p) / alpha) : glm::vec3(0));
        const auto part = [&](double value) { return static_cast<std::uint32_t>(std::lround(255 * value)); };
        const double a = part(alpha) / 255.0;
        pixel = part(alpha) << 24 | part(a * code.r) << 16 | part(a * code.g) << 8 | part(a * code.b);
    });
    return surface;
}

/// Draws in tiles, so that what is held does not grow with the picture. Where tiles lie does not depend on
/// the rows that are drawn together, for edges of lines may depend on it.
class RowDrawing {
  public:
    explicit RowDrawing(const Figure& figure) : size_(figure.size), layout_(laidOut(figure, words_)) {}

    void draw(int first, std::span<glm::vec4> rows) {
        const auto width = static_cast<std::size_t>(size_.x);
        const int end = first + static_cast<int>(rows.size() / width);
        TESSERA_CHECK(rows.size() % width == 0 && end <= size_.y);
        for (int y = first / kTile * kTile; y < end; y += kTile)
            for (int x = 0; x < size_.x; x += kTile)
                drawTile({x, y}, first, rows.first(width * static_cast<std::size_t>(end - first)));
    }

  private:
    static constexpr int kTile = 512; // pixels

    void drawTile(const glm::ivec2& from, int first, std::span<glm::vec4> rows) {
        const auto width = static_cast<std::size_t>(size_.x);
        const glm::ivec2 size = glm::min(glm::ivec2(kTile), size_ - from);
        const int top = std::max(from.y, first),
                  end = std::min(from.y + size.y, first + static_cast<int>(rows.size() / width));
        if (!drawsWithin(layout_, glm::dvec2(from.x, top), glm::dvec2(from.x + size.x, end)))
            return;
        const Surface tile = imageOf(CAIRO_FORMAT_ARGB32, size);
        const Context cairo(cairo_create(tile.get()), cairo_destroy);
        cairo_translate(cairo.get(), -from.x, -from.y);
        drawLayout(cairo.get(), layout_, words_, glm::dvec2(from), glm::dvec2(from + size));
        eachPixel(tile.get(), size, [&](int i, int j, std::uint32_t pixel) {
            const int y = from.y + j;
            if (pixel >> 24 == 0 || y < top || y >= end)
                return;
            const glm::vec4 over = linearOf(pixel);
            glm::vec4& under =
                rows[static_cast<std::size_t>(y - first) * width + static_cast<std::size_t>(from.x + i)];
            under = over + (1 - over.a) * under;
        });
    }

    glm::ivec2 size_;
    PangoWords words_; // before the layout, which is measured by them
    FigureLayout layout_;
};

} // namespace

DrawingReport describeDrawing(const Figure& figure) {
    PangoWords words;
    FigureLayout layout = laidOut(figure, words);
    DrawingReport report;
    report.cairo = cairo_version_string();
    report.pango = pango_version_string();
    report.fonts = words.fontsOf(layout.words);
    report.leftOut = std::move(layout.leftOut);
    for (const LaidWords& laid : layout.words)
        if (const std::size_t missing = words.missingLetters(laid.words); missing > 0)
            report.leftOut.push_back(std::to_string(missing) + " letters of \"" + printable(laid.words) +
                                     "\", which no font of this machine has");
    return report;
}

StripHeights measureStrips(const FigurePart& part, double dpi) {
    PangoWords words;
    return stripsNeeded(part, dpi, measureBy(words));
}

Strips measureBeside(const FigurePart& part, double dpi) {
    PangoWords words;
    return stripsBeside(part, dpi, measureBy(words));
}

DrawRows annotationRows(const Figure& figure) {
    const auto drawing = std::make_shared<RowDrawing>(figure);
    return [drawing](int first, std::span<glm::vec4> rows) { drawing->draw(first, rows); };
}

void drawAnnotations(const Figure& figure, Image& picture) {
    TESSERA_CHECK(picture.size == figure.size);
    RowDrawing(figure).draw(0, picture.pixels);
}

void writePage(const std::filesystem::path& path, const Image& picture, const Figure& figure,
               const std::string& manifest, MemoryBudget& ram) {
    constexpr std::size_t kBytesPerPixel = 12; // Cairo's image, and what it compresses
    if (picture.size.x > kMostPagePixels || picture.size.y > kMostPagePixels)
        throw badFile(path.string(), "a picture of at most 32767 pixels an axis for PDF and SVG",
                      std::to_string(std::max(picture.size.x, picture.size.y)));
    TESSERA_CHECK(picture.size == figure.size);
    const Charge charge = ram.charge(kBytesPerPixel * picture.pixels.size(), "the figure's page");
    const bool svg = pageFormat(path) == PageFormat::svg;
    OutputFile file(path);
    PageOutput out(file);
    PangoWords words;
    const FigureLayout layout = laidOut(figure, words);
    const Surface surface = surfaceOf(picture);
    const std::string title =
        figure.parts.size() == 1 ? printable(figure.parts.front().annotations.title) : std::string();
    const Page page{picture.size, figure.dpi, surface.get(), layout, title, manifest};
    try {
        if (svg)
            writeSvg(out, page);
        else
            writePdf(out, page, words);
    } catch (const Error& problem) {
        out.check(); // names the system's reason
        throw Error(printable(path.string()) + ": cannot be written: " + problem.what());
    }
    file.finish();
}

} // namespace tessera
