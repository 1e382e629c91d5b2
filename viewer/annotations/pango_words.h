// viewer/annotations/pango_words.h: words in the figures' font, by Pango: measured and drawn.
#pragma once

#include "viewer/annotations/figure_drawing.h"
#include "viewer/annotations/figure_layout.h"
#include "viewer/annotations/words.h"

#include <cairo.h>
#include <memory>
#include <string>
#include <vector>

namespace tessera {

/// For one thread.
class PangoWords {
  public:
    /// Throws Error where there is no font.
    PangoWords();
    ~PangoWords();
    PangoWords(const PangoWords&) = delete;
    PangoWords& operator=(const PangoWords&) = delete;

    /// The first of these that is there.
    static constexpr const char* kFamilies = "DejaVu Sans, sans-serif";

    WordSize measure(const std::string& words, double pixels, bool bold = false);
    /// With their edge.
    void draw(cairo_t* cairo, const LaidWords& words);
    /// The fonts that words are drawn with, each once.
    std::vector<DrawingReport::Font> fontsOf(const std::vector<LaidWords>& words);
    /// Of words, the letters that no font of this machine has: boxes stand for them.
    std::size_t missingLetters(const std::string& words);

  private:
    struct Pango;
    std::unique_ptr<Pango> pango_;
};

} // namespace tessera
