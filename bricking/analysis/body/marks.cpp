// bricking/analysis/body/marks.cpp: see marks.h.
#include "bricking/analysis/body/marks.h"

#include <algorithm>

namespace tessera {
namespace {

int wordsFor(int samples) {
    return (samples + Marks::kWordBits - 1) / Marks::kWordBits;
}

} // namespace

Marks::Marks(const glm::ivec3& extent)
    : extent_(extent), rowWords_(wordsFor(extent.x)), words_(bytes(extent) / sizeof(Word)) {}

Marks Marks::all(const glm::ivec3& extent) {
    Marks marks(extent);
    std::fill(marks.words_.begin(), marks.words_.end(), ~Word{0});
    for (std::size_t n = 0; n < marks.rows(); ++n)
        marks.row(n).back() = marks.lastWord();
    return marks;
}

std::size_t Marks::bytes(const glm::ivec3& extent) {
    return cellCount({wordsFor(extent.x), extent.y, extent.z}) * sizeof(Word);
}

bool Marks::any() const {
    return std::any_of(words_.begin(), words_.end(), [](Word word) { return word != 0; });
}

std::size_t Marks::count() const {
    std::size_t count = 0;
    for (const Word word : words_)
        count += static_cast<std::size_t>(std::popcount(word));
    return count;
}

Marks both(const Marks& a, const Marks& b) {
    return combined([](Marks::Word one, Marks::Word other) { return one & other; }, a, b);
}

Marks without(const Marks& a, const Marks& b) {
    return combined([](Marks::Word one, Marks::Word other) { return one & ~other; }, a, b);
}

} // namespace tessera
