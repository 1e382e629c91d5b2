// viewer/annotations/pages.h: pages of a figure: PDF by Cairo, SVG as text, for figure_drawing.cpp.
#pragma once

#include "core/base/output_file.h"
#include "viewer/annotations/figure_layout.h"
#include "viewer/annotations/pango_words.h"

#include <cairo.h>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <glm/vec2.hpp>
#include <span>
#include <string>
#include <string_view>

namespace tessera {

/// An unfinished file that a C library writes to from its start on.
class PageOutput {
  public:
    explicit PageOutput(OutputFile& file) : file_(file) {}
    /// Returns false if that failed, and ever after: throws nothing.
    bool write(std::span<const std::byte> bytes) noexcept;
    bool write(std::string_view text) noexcept {
        return write(std::as_bytes(std::span(text.data(), text.size())));
    }
    /// Throws the Error of the first write that failed.
    void check() const;

  private:
    OutputFile& file_;
    std::uint64_t position_ = 0;
    std::exception_ptr problem_;
};

struct Page {
    glm::ivec2 size{0}; // pixels
    double dpi = 96;
    cairo_surface_t* picture = nullptr; // of that size
    const FigureLayout& layout;
    const std::string& title;
    const std::string& manifest; // ASCII
};

/// Throw Error where Cairo fails.
void writePdf(PageOutput& out, const Page& page, PangoWords& words);
void writeSvg(PageOutput& out, const Page& page);

} // namespace tessera
