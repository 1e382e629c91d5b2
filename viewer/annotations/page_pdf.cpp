// viewer/annotations/page_pdf.cpp: a figure as PDF, for pages.h: the picture without loss, words as text in
// embedded fonts. The manifest is the document's Keywords.
#include "core/base/error.h"
#include "viewer/annotations/layout_drawing.h"
#include "viewer/annotations/pages.h"

#include <cairo-pdf.h>
#include <cairo.h>
#include <cstddef>
#include <memory>

namespace tessera {
namespace {

cairo_status_t onWrite(void* out, const unsigned char* bytes, unsigned int count) {
    return static_cast<PageOutput*>(out)->write({reinterpret_cast<const std::byte*>(bytes), count})
               ? CAIRO_STATUS_SUCCESS
               : CAIRO_STATUS_WRITE_ERROR;
}

using Surface = std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)>;
using Context = std::unique_ptr<cairo_t, decltype(&cairo_destroy)>;

} // namespace

bool PageOutput::write(std::span<const std::byte> bytes) noexcept {
    if (problem_)
        return false;
    try {
        file_.writeAt(position_, bytes);
    } catch (const Error&) {
        problem_ = std::current_exception();
        return false;
    }
    position_ += bytes.size();
    return true;
}

void PageOutput::check() const {
    if (problem_)
        std::rethrow_exception(problem_);
}

void writePdf(PageOutput& out, const Page& page, PangoWords& words) {
    const double scale = kPointsPerInch / page.dpi;
    const Surface surface(
        cairo_pdf_surface_create_for_stream(onWrite, &out, page.size.x * scale, page.size.y * scale),
        cairo_surface_destroy);
    // Later versions may pack the manifest into streams, where readManifest() does not look.
    cairo_pdf_surface_restrict_to_version(surface.get(), CAIRO_PDF_VERSION_1_4);
    cairo_pdf_surface_set_metadata(surface.get(), CAIRO_PDF_METADATA_CREATOR, "Tessera");
    cairo_pdf_surface_set_metadata(surface.get(), CAIRO_PDF_METADATA_KEYWORDS, page.manifest.c_str());
    if (!page.title.empty())
        cairo_pdf_surface_set_metadata(surface.get(), CAIRO_PDF_METADATA_TITLE, page.title.c_str());
    // A file does not depend on the time.
    cairo_pdf_surface_set_metadata(surface.get(), CAIRO_PDF_METADATA_CREATE_DATE, nullptr);
    const Context cairo(cairo_create(surface.get()), cairo_destroy);
    cairo_scale(cairo.get(), scale, scale);
    cairo_set_source_surface(cairo.get(), page.picture, 0, 0);
    cairo_pattern_set_filter(cairo_get_source(cairo.get()), CAIRO_FILTER_NEAREST); // pixels stay squares
    cairo_paint(cairo.get());
    drawLayout(cairo.get(), page.layout, words, glm::dvec2(0), glm::dvec2(page.size));
    cairo_show_page(cairo.get());
    cairo_surface_finish(surface.get());
    out.check();
    for (const cairo_status_t status : {cairo_status(cairo.get()), cairo_surface_status(surface.get())})
        if (status != CAIRO_STATUS_SUCCESS)
            throw Error(cairo_status_to_string(status));
}

} // namespace tessera
