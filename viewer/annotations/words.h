// viewer/annotations/words.h: sizes of words, and words that are broken into lines and cut.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

namespace tessera {

/// Of a line of words, pixels: its length, and how far it reaches above and below its baseline.
struct WordSize {
    double width = 0, ascent = 0, descent = 0;
    double height() const { return ascent + descent; }
};

/// Measures one line of UTF-8 in a font's size, pixels.
using MeasureWords = std::function<WordSize(const std::string& words, double pixels, bool bold)>;

/// The words, or as many letters of them as are no wider than that, and an ellipsis. "" where that has no
/// room either.
std::string cutWords(const std::string& words, double pixels, double width, const MeasureWords& measure);

struct BrokenWords {
    std::vector<std::string> lines;
    bool cut = false; // some of the words are not in them
};
/// Lines that are no wider than that, broken at spaces and line feeds. The last one of `most` is cut where
/// more would follow; fewer where a word has no room.
BrokenWords brokenWords(const std::string& words, double pixels, double width, std::size_t most,
                        const MeasureWords& measure);

} // namespace tessera
