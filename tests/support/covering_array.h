// tests/support/covering_array.h: rows of a test that, for every two factors, hold every pair of their levels
// at least once. These are far fewer than all combinations, and most faults need at most two conditions.
// Greedy, a row at a time (Cohen, Dalal, Fredman, Patton 1997, "The AETG system", IEEE TSE 23(7)): a row
// starts with a missing pair. Every further factor, in random order, takes the level that covers most.
#pragma once

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <random>
#include <vector>

namespace tessera::test {

/// What pairs of levels are still missing.
class MissingPairs {
  public:
    explicit MissingPairs(const std::vector<int>& levels) : levels_(levels), first_(levels.size() + 1, 0) {
        for (std::size_t f = 0; f < levels.size(); ++f)
            first_[f + 1] = first_[f] + static_cast<std::size_t>(levels[f]);
        missing_.assign(first_.back() * first_.back(), false);
        for (std::size_t f = 0; f < levels.size(); ++f)
            for (std::size_t g = f + 1; g < levels.size(); ++g)
                for (int a = 0; a < levels[f]; ++a)
                    for (int b = 0; b < levels[g]; ++b, ++count_)
                        missing_[index(f, a, g, b)] = true;
    }
    std::size_t count() const { return count_; }
    bool has(std::size_t f, int a, std::size_t g, int b) const {
        return f < g ? missing_[index(f, a, g, b)] : missing_[index(g, b, f, a)];
    }
    /// The row's pairs are missing no more.
    void take(const std::vector<int>& row) {
        for (std::size_t f = 0; f < row.size(); ++f)
            for (std::size_t g = f + 1; g < row.size(); ++g)
                if (auto pair = missing_[index(f, row[f], g, row[g])]) {
                    pair = false;
                    --count_;
                }
    }
    /// Some missing pair, as a row that has -1 elsewhere. There must be one.
    std::vector<int> somePair() const {
        for (std::size_t f = 0; f < levels_.size(); ++f)
            for (std::size_t g = f + 1; g < levels_.size(); ++g)
                for (int a = 0; a < levels_[f]; ++a)
                    for (int b = 0; b < levels_[g]; ++b)
                        if (has(f, a, g, b)) {
                            std::vector<int> row(levels_.size(), -1);
                            row[f] = a, row[g] = b;
                            return row;
                        }
        return {};
    }

  private:
    std::size_t index(std::size_t f, int a, std::size_t g, int b) const {
        return (first_[f] + static_cast<std::size_t>(a)) * first_.back() + first_[g] +
               static_cast<std::size_t>(b);
    }
    std::vector<int> levels_;
    std::vector<std::size_t> first_;
    std::vector<bool> missing_;
    std::size_t count_ = 0;
};

/// Rows of one level per factor.
/// @param levels  number of levels of every factor, at least 1 each
inline std::vector<std::vector<int>> coveringArray(const std::vector<int>& levels, unsigned seed) {
    constexpr int kCandidates = 12; // a row is the best of so many
    std::mt19937 random(seed);
    MissingPairs missing(levels);
    std::vector<std::vector<int>> rows;
    std::vector<std::size_t> order(levels.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    while (missing.count() > 0) {
        const std::vector<int> start = missing.somePair();
        std::vector<int> best;
        int bestCovered = -1;
        for (int candidate = 0; candidate < kCandidates; ++candidate) {
            std::vector<int> row = start;
            int covered = 1;
            std::shuffle(order.begin(), order.end(), random);
            for (const std::size_t f : order) {
                if (row[f] >= 0)
                    continue;
                // Ties go to a random level: the first would come too often.
                const int shift = static_cast<int>(random() % static_cast<unsigned>(levels[f]));
                int bestLevel = 0, most = -1;
                for (int n = 0; n < levels[f]; ++n) {
                    const int level = (n + shift) % levels[f];
                    int gain = 0;
                    for (std::size_t g = 0; g < row.size(); ++g)
                        gain += row[g] >= 0 && missing.has(f, level, g, row[g]) ? 1 : 0;
                    if (gain > most)
                        most = gain, bestLevel = level;
                }
                row[f] = bestLevel;
                covered += most;
            }
            if (covered > bestCovered)
                bestCovered = covered, best = row;
        }
        missing.take(best);
        rows.push_back(best);
    }
    return rows;
}

} // namespace tessera::test
