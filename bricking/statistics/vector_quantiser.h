// bricking/statistics/vector_quantiser.h: a code book for vectors of bytes, learnt by the algorithm of Linde,
// Buzo and Gray: clusters are split in two, the largest error first, and then settle in rounds. The splits
// are a tree; a search goes down its most likely branches. Results do not depend on the number of threads.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace tessera {

class VectorQuantiser {
  public:
    static constexpr std::size_t kLength = 128;
    using Vector = std::array<std::uint8_t, kLength>;
    static constexpr int kRounds = 20; // at most

    /// @param sample  at least one vector
    /// @param most    representatives, in [1,65536]; fewer where the sample has fewer different vectors
    VectorQuantiser(std::span<const Vector> sample, std::size_t most, int threads);
    /// Memory for learning, without the sample.
    static std::size_t bytes(std::size_t sample, std::size_t most);

    /// Representatives.
    std::size_t size() const { return leaves_.size(); }
    const Vector& operator[](std::size_t number) const { return nodes_[leaves_[number]].centre; }
    /// The number of the nearest representative, or of one next to as near: the best of the tree's most
    /// likely branches.
    std::uint16_t nearest(const Vector& vector) const;
    /// Sum of the components' absolute differences.
    static unsigned distance(const Vector& a, const Vector& b);

  private:
    static constexpr std::uint32_t kLeaf = UINT32_MAX;
    struct Node {
        Vector centre{};
        std::array<std::uint32_t, 2> below{kLeaf, kLeaf};
        std::uint32_t number = 0; // of a leaf
    };
    void split(std::span<const Vector> sample, std::size_t most);
    void settle(std::span<const Vector> sample, int threads);

    std::vector<Node> nodes_; // a node stands before those below it
    std::vector<std::uint32_t> leaves_;
};

} // namespace tessera
