// viewer/annotations/pango_words.cpp: see pango_words.h. Letters are not hinted, so that they have the same
// places in pictures and on pages.
#include "viewer/annotations/pango_words.h"

#include "core/base/error.h"

#include <algorithm>
#include <cairo.h>
#include <cstdlib>
#include <filesystem>
#include <fontconfig/fontconfig.h>
#include <glib-object.h>
#include <memory>
#include <mutex>
#include <pango/pangocairo.h>
#include <pango/pangofc-font.h>

namespace tessera {
namespace {

struct Unref {
    void operator()(void* object) const { g_object_unref(object); }
};
template <typename T> using Object = std::unique_ptr<T, Unref>;
using Description = std::unique_ptr<PangoFontDescription, decltype(&pango_font_description_free)>;
using Options = std::unique_ptr<cairo_font_options_t, decltype(&cairo_font_options_destroy)>;

double pixelsOf(int units) {
    return static_cast<double>(units) / PANGO_SCALE;
}

bool isThereAFont() {
    for (const FcSetName set : {FcSetSystem, FcSetApplication})
        if (const FcFontSet* const fonts = FcConfigGetFonts(nullptr, set); fonts && fonts->nfont > 0)
            return true;
    return false;
}

/// An archive of the program has a font (cmake/packages/), for systems without any, or without fontconfig's
/// files. As a single file it needs no cache, which a user without a folder could not keep.
void findFonts() {
    namespace fs = std::filesystem;
    std::error_code ignored;
    const fs::path own =
        fs::read_symlink("/proc/self/exe", ignored).parent_path() / "../share/tessera/fonts/DejaVuSans.ttf";
    if (!fs::exists(own, ignored))
        return;
    if (!std::getenv("FONTCONFIG_FILE") && !fs::exists("/etc/fonts/fonts.conf", ignored)) {
        FcConfig* const none = FcConfigCreate(); // else fontconfig complains of its missing files
        FcConfigSetCurrent(none);
        FcConfigDestroy(none); // the current one stays
    }
    if (!isThereAFont())
        FcConfigAppFontAddFile(nullptr, reinterpret_cast<const FcChar8*>(own.c_str()));
}

std::string textOf(FcPattern* pattern, const char* key) {
    FcChar8* text = nullptr;
    return pattern && FcPatternGetString(pattern, key, 0, &text) == FcResultMatch
               ? std::string(reinterpret_cast<const char*>(text))
               : std::string();
}

} // namespace

struct PangoWords::Pango {
    Object<PangoFontMap> map;
    Object<PangoContext> context;
    Object<PangoLayout> layout;

    PangoLayoutLine* line(const std::string& words, double pixels, bool bold) {
        const Description font(pango_font_description_from_string(kFamilies), pango_font_description_free);
        pango_font_description_set_absolute_size(font.get(), pixels * PANGO_SCALE);
        pango_font_description_set_weight(font.get(), bold ? PANGO_WEIGHT_BOLD : PANGO_WEIGHT_NORMAL);
        pango_layout_set_font_description(layout.get(), font.get());
        pango_layout_set_text(layout.get(), words.data(), static_cast<int>(words.size()));
        return pango_layout_get_line_readonly(layout.get(), 0);
    }
};

PangoWords::PangoWords() : pango_(std::make_unique<Pango>()) {
    static std::once_flag once;
    std::call_once(once, findFonts);
    if (!isThereAFont())
        throw Error("annotations: expected a font on this machine, such as that of the package "
                    "fonts-dejavu-core, found none");
    pango_->map.reset(pango_cairo_font_map_new());
    pango_->context.reset(pango_font_map_create_context(pango_->map.get()));
    const Options options(cairo_font_options_create(), cairo_font_options_destroy);
    cairo_font_options_set_antialias(options.get(), CAIRO_ANTIALIAS_GRAY);
    cairo_font_options_set_hint_style(options.get(), CAIRO_HINT_STYLE_NONE);
    cairo_font_options_set_hint_metrics(options.get(), CAIRO_HINT_METRICS_OFF);
    pango_cairo_context_set_font_options(pango_->context.get(), options.get());
    pango_context_set_round_glyph_positions(pango_->context.get(), FALSE);
    pango_->layout.reset(pango_layout_new(pango_->context.get()));
    pango_layout_set_single_paragraph_mode(pango_->layout.get(), TRUE);
}

PangoWords::~PangoWords() = default;

WordSize PangoWords::measure(const std::string& words, double pixels, bool bold) {
    PangoRectangle logical;
    pango_layout_line_get_extents(pango_->line(words, pixels, bold), nullptr, &logical);
    return {pixelsOf(logical.width), pixelsOf(-logical.y), pixelsOf(logical.y + logical.height)};
}

void PangoWords::draw(cairo_t* cairo, const LaidWords& words) {
    PangoLayoutLine* const line = pango_->line(words.words, words.pixels, words.bold);
    const double ink = words.ink == Ink::light ? 1 : 0;
    cairo_new_path(cairo);
    cairo_move_to(cairo, words.at.x, words.at.y);
    pango_cairo_layout_line_path(cairo, line);
    cairo_set_line_width(cairo, 2 * words.edge);
    cairo_set_line_join(cairo, CAIRO_LINE_JOIN_ROUND);
    cairo_set_source_rgb(cairo, 1 - ink, 1 - ink, 1 - ink);
    cairo_stroke(cairo);
    cairo_move_to(cairo, words.at.x, words.at.y);
    cairo_set_source_rgb(cairo, ink, ink, ink);
    pango_cairo_show_layout_line(cairo, line);
    cairo_new_path(cairo);
}

std::size_t PangoWords::missingLetters(const std::string& words) {
    constexpr double kAnySize = 12;
    pango_->line(words, kAnySize, false);
    return static_cast<std::size_t>(pango_layout_get_unknown_glyphs_count(pango_->layout.get()));
}

std::vector<DrawingReport::Font> PangoWords::fontsOf(const std::vector<LaidWords>& words) {
    std::vector<DrawingReport::Font> fonts;
    for (const LaidWords& laid : words)
        for (const GSList* run = pango_->line(laid.words, laid.pixels, laid.bold)->runs; run;
             run = run->next) {
            PangoFont* const font = static_cast<const PangoGlyphItem*>(run->data)->item->analysis.font;
            if (!font || !PANGO_IS_FC_FONT(font))
                continue;
            FcPattern* const pattern = pango_fc_font_get_pattern(PANGO_FC_FONT(font));
            const DrawingReport::Font one = {
                textOf(pattern, FC_FAMILY),
                std::filesystem::path(textOf(pattern, FC_FILE)).filename().string()};
            if (std::find(fonts.begin(), fonts.end(), one) == fonts.end())
                fonts.push_back(one);
        }
    return fonts;
}

} // namespace tessera
