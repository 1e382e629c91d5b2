// viewer/annotations/page_svg.cpp: a figure as SVG, for pages.h: the picture as PNG, words as text. The
// manifest is the text of a <metadata>. Cairo's own SVG has outlines of letters in place of text.
#include "core/base/error.h"
#include "core/base/shown_text.h"
#include "viewer/annotations/layout_drawing.h"
#include "viewer/annotations/pages.h"

#include <array>
#include <cairo.h>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <string>
#include <variant>
#include <vector>

namespace tessera {
namespace {

/// Base64 (RFC 4648) of bytes that come part by part.
class Base64 {
  public:
    explicit Base64(PageOutput& out) : out_(out) {}
    bool add(const unsigned char* bytes, std::size_t count) {
        for (std::size_t i = 0; i < count; ++i) {
            word_ = word_ << 8 | bytes[i];
            if (++held_ == 3)
                flush();
        }
        return text_.size() < kPart || send();
    }
    bool finish() {
        const unsigned missing = held_ == 0 ? 0 : 3 - held_;
        word_ <<= 8 * missing;
        if (held_ > 0)
            flush();
        for (unsigned i = 0; i < missing; ++i)
            text_[text_.size() - 1 - i] = '=';
        return send();
    }

  private:
    static constexpr std::size_t kPart = 1 << 16;
    void flush() {
        constexpr const char* kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
        for (int shift = 18; shift >= 0; shift -= 6)
            text_ += kDigits[word_ >> shift & 63];
        word_ = held_ = 0;
    }
    bool send() {
        const bool done = out_.write(text_);
        text_.clear();
        return done;
    }
    PageOutput& out_;
    std::string text_;
    unsigned word_ = 0, held_ = 0;
};

cairo_status_t onPng(void* out, const unsigned char* bytes, unsigned int count) {
    return static_cast<Base64*>(out)->add(bytes, count) ? CAIRO_STATUS_SUCCESS : CAIRO_STATUS_WRITE_ERROR;
}

std::string escaped(const std::string& text) {
    std::string out;
    for (const char c : text)
        if (c == '&')
            out += "&amp;";
        else if (c == '<')
            out += "&lt;";
        else if (c == '>')
            out += "&gt;";
        else if (c == '"')
            out += "&quot;";
        else
            out += c;
    return out;
}

std::string number(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.3f", value);
    return text;
}

std::string colourText(const glm::dvec3& code) {
    char text[16];
    std::snprintf(text, sizeof text, "#%02lx%02lx%02lx", std::lround(255 * code.r), std::lround(255 * code.g),
                  std::lround(255 * code.b));
    return text;
}

std::string pathText(const std::vector<glm::dvec2>& points, bool closed) {
    std::string text;
    for (std::size_t n = 0; n < points.size(); ++n)
        text += (n == 0 ? "M" : "L") + number(points[n].x) + " " + number(points[n].y);
    return text + (closed ? "Z" : "");
}

std::string strokeText(const std::vector<std::vector<glm::dvec2>>& lines, double width, bool light) {
    std::string path;
    for (const std::vector<glm::dvec2>& points : lines)
        path += pathText(points, points.size() > 2 && points.front() == points.back());
    return "<path fill=\"none\" stroke=\"" + std::string(light ? "#ffffff" : "#000000") +
           "\" stroke-width=\"" + number(width) + "\" stroke-miterlimit=\"10\" d=\"" + path + "\"/>\n";
}

std::string textOf(const LaidArea& area) {
    return "<path fill=\"" + colourText(codeOfColour(area.colour)) + "\"" +
           (area.opacity < 1 ? " fill-opacity=\"" + number(static_cast<double>(area.opacity)) + "\"" : "") +
           " d=\"" + pathText(area.corners, true) + "\"/>\n";
}

std::string textOf(const LaidLines& lines) {
    const bool light = lines.ink == Ink::light;
    std::string text;
    if (lines.edge > 0)
        text += strokeText(lengthened(lines), lines.width + 2 * lines.edge, !light);
    return text + strokeText(lines.lines, lines.width, light);
}

std::string textOf(const LaidWords& words) {
    const char *const ink = words.ink == Ink::light ? "#ffffff" : "#000000", *const edge =
                                                                                 words.ink == Ink::light
                                                                                     ? "#000000"
                                                                                     : "#ffffff";
    return "<text x=\"" + number(words.at.x) + "\" y=\"" + number(words.at.y) + "\" font-size=\"" +
           number(words.pixels) + (words.bold ? "\" font-weight=\"bold" : "") + "\" textLength=\"" +
           number(words.size.width) + "\" fill=\"" + ink + "\" stroke=\"" + edge + "\" stroke-width=\"" +
           number(2 * words.edge) + "\">" + escaped(words.words) + "</text>\n";
}

} // namespace

void writeSvg(PageOutput& out, const Page& page) {
    const std::string width = std::to_string(page.size.x), height = std::to_string(page.size.y);
    std::string head = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
                       "<svg xmlns=\"http://www.w3.org/2000/svg\" "
                       "xmlns:xlink=\"http://www.w3.org/1999/xlink\" width=\"" +
                       number(page.size.x / page.dpi) + "in\" height=\"" + number(page.size.y / page.dpi) +
                       "in\" viewBox=\"0 0 " + width + " " + height + "\">\n";
    if (!page.title.empty())
        head += "<title>" + escaped(page.title) + "</title>\n";
    head += "<metadata id=\"tessera-manifest\">" + escaped(page.manifest) + "</metadata>\n<image width=\"" +
            width + "\" height=\"" + height +
            "\" image-rendering=\"optimizeSpeed\" style=\"image-rendering:pixelated\" "
            "xlink:href=\"data:image/png;base64,";
    out.write(head);
    Base64 png(out);
    const cairo_status_t status = cairo_surface_write_to_png_stream(page.picture, onPng, &png);
    png.finish();
    out.write("\"/>\n");
    for (const LaidShape& shape : page.layout.shapes)
        out.write(std::visit([](const auto& one) { return textOf(one); }, shape));
    out.write("<g font-family=\"" + std::string(PangoWords::kFamilies) +
              "\" stroke-linejoin=\"round\" "
              "style=\"paint-order:stroke\" xml:space=\"preserve\">\n");
    for (const LaidWords& words : page.layout.words)
        out.write(textOf(words));
    out.write("</g>\n</svg>\n");
    out.check();
    if (status != CAIRO_STATUS_SUCCESS)
        throw Error(cairo_status_to_string(status));
}

} // namespace tessera
