// viewer/annotations/words.cpp: see words.h.
#include "viewer/annotations/words.h"

#include <algorithm>
#include <sstream>
#include <utility>

namespace tessera {
namespace {

constexpr const char* kEllipsis = "\xe2\x80\xa6"; // U+2026

/// Where the letters of UTF-8 begin, and the end.
std::vector<std::size_t> letterStarts(const std::string& words) {
    std::vector<std::size_t> starts;
    for (std::size_t i = 0; i < words.size(); ++i)
        if ((static_cast<unsigned char>(words[i]) & 0xC0) != 0x80)
            starts.push_back(i);
    starts.push_back(words.size());
    return starts;
}

} // namespace

std::string cutWords(const std::string& words, double pixels, double width, const MeasureWords& measure) {
    const auto fits = [&](const std::string& text) { return measure(text, pixels, false).width <= width; };
    if (fits(words))
        return words;
    const std::vector<std::size_t> starts = letterStarts(words);
    // The most letters that fit; widths grow with them but for kerning, which the last test makes up for.
    std::size_t low = 0, high = starts.size() - 1;
    while (low < high) {
        const std::size_t middle = (low + high + 1) / 2;
        if (fits(words.substr(0, starts[middle]) + kEllipsis))
            low = middle;
        else
            high = middle - 1;
    }
    while (low > 0 && words[starts[low] - 1] == ' ')
        --low;
    const std::string cut = words.substr(0, starts[low]) + kEllipsis;
    return fits(cut) ? cut : std::string();
}

BrokenWords brokenWords(const std::string& words, double pixels, double width, std::size_t most,
                        const MeasureWords& measure) {
    BrokenWords broken;
    std::vector<std::string>& lines = broken.lines;
    std::istringstream paragraphs(words);
    bool full = most == 0; // the last line holds more than it has room for
    for (std::string paragraph; !full && std::getline(paragraphs, paragraph);) {
        std::istringstream parts(paragraph);
        std::string line;
        for (std::string word; !full && parts >> word;) {
            const std::string longer = line.empty() ? word : line + " " + word;
            const bool fits = line.empty() || measure(longer, pixels, false).width <= width;
            if (fits || lines.size() + 1 >= most) {
                line = longer;
                full = !fits;
            } else {
                lines.push_back(std::exchange(line, word));
            }
        }
        if (line.empty())
            continue;
        if (lines.size() < most)
            lines.push_back(line);
        else
            lines.back() += " " + line;
    }
    broken.cut = most == 0 && words.find_first_not_of(" \n") != std::string::npos;
    for (std::string& line : lines) { // a word may be wider, and so may the last line
        std::string cut = cutWords(line, pixels, width, measure);
        broken.cut = broken.cut || cut != line;
        line = std::move(cut);
    }
    std::erase(lines, "");
    return broken;
}

} // namespace tessera
