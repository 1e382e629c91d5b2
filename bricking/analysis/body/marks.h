// bricking/analysis/body/marks.h: a set of voxels of one level as bits: 64 neighbours along x at once.
// Internal to this room.
#pragma once

#include "core/base/brick.h"

#include <bit>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

namespace tessera {

class Marks {
  public:
    using Word = std::uint64_t;
    static constexpr int kWordBits = 64;

    Marks() = default;
    /// Nothing is marked.
    explicit Marks(const glm::ivec3& extent);
    static Marks all(const glm::ivec3& extent);
    /// Memory of a set.
    static std::size_t bytes(const glm::ivec3& extent);

    const glm::ivec3& extent() const { return extent_; }
    int rowWords() const { return rowWords_; }
    /// Row n = y + extent.y z. Voxel x is bit x % 64 of word x / 64; bits beyond the extent are clear.
    std::span<Word> row(std::size_t n) { return std::span(words_).subspan(n * width(), width()); }
    std::span<const Word> row(std::size_t n) const { return std::span(words_).subspan(n * width(), width()); }
    std::size_t rowNumber(int y, int z) const {
        return static_cast<std::size_t>(z) * static_cast<std::size_t>(extent_.y) +
               static_cast<std::size_t>(y);
    }
    std::size_t rows() const { return cellCount({1, extent_.y, extent_.z}); }
    std::span<Word> words() { return words_; }
    std::span<const Word> words() const { return words_; }
    /// The bits of a row's last word that lie within the extent.
    Word lastWord() const { return ~Word{0} >> (rowWords_ * kWordBits - extent_.x); }

    bool has(const glm::ivec3& at) const {
        return row(rowNumber(at.y, at.z))[wordOf(at.x)] >> (at.x % kWordBits) & 1u;
    }
    void add(const glm::ivec3& at) {
        row(rowNumber(at.y, at.z))[wordOf(at.x)] |= Word{1} << (at.x % kWordBits);
    }
    bool any() const;
    std::size_t count() const;
    bool operator==(const Marks&) const = default;

  private:
    std::size_t width() const { return static_cast<std::size_t>(rowWords_); }
    static std::size_t wordOf(int x) { return static_cast<std::size_t>(x / kWordBits); }

    glm::ivec3 extent_{0};
    int rowWords_ = 0;
    std::vector<Word> words_;
};

/// The set that op(word, ...) gives, word by word. It must be clear where all sets are.
template <typename Op, typename... Sets>
Marks combined(const Op& op, const Marks& first, const Sets&... more) {
    Marks out(first.extent());
    const std::span<Marks::Word> words = out.words();
    for (std::size_t i = 0; i < words.size(); ++i)
        words[i] = op(first.words()[i], more.words()[i]...);
    return out;
}
/// What both have, and what the first alone has.
Marks both(const Marks& a, const Marks& b);
Marks without(const Marks& a, const Marks& b);

/// Calls each(x) for the marked voxels of a row, ascending.
template <typename Each> void forMarked(std::span<const Marks::Word> row, const Each& each) {
    for (std::size_t i = 0; i < row.size(); ++i)
        for (Marks::Word rest = row[i]; rest != 0; rest &= rest - 1)
            each(static_cast<int>(i) * Marks::kWordBits + std::countr_zero(rest));
}

} // namespace tessera
