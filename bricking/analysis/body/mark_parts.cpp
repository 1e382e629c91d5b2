// bricking/analysis/body/mark_parts.cpp: see mark_parts.h. Runs of marked voxels along x are joined with
// those that they touch in the rows before: union and find, the least run of a part being its root.
#include "bricking/analysis/body/mark_parts.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

namespace tessera {
namespace {

using Word = Marks::Word;

struct Run {
    std::int32_t first, end;
    std::uint32_t parent; // a run of the same part; of a root itself, and its part's number at last
};

/// First bit of a row from x on that is `set`, or the row's bits.
int nextBit(std::span<const Word> row, int x, bool set) {
    const int bits = static_cast<int>(row.size()) * Marks::kWordBits;
    while (x < bits) {
        const Word word = row[static_cast<std::size_t>(x / Marks::kWordBits)];
        const Word rest = (set ? word : ~word) >> (x % Marks::kWordBits);
        if (rest != 0)
            return x + std::countr_zero(rest);
        x = (x / Marks::kWordBits + 1) * Marks::kWordBits;
    }
    return bits;
}

/// True if a row has a marked voxel in [first, end).
bool hasAny(std::span<const Word> row, int first, int end) {
    return nextBit(row, first, true) < end;
}

void fill(std::span<Word> row, int first, int end) {
    for (int x = first; x < end;) {
        const int bit = x % Marks::kWordBits, count = std::min(end - x, Marks::kWordBits - bit);
        row[static_cast<std::size_t>(x / Marks::kWordBits)] |= (~Word{0} >> (Marks::kWordBits - count))
                                                               << bit;
        x += count;
    }
}

std::size_t runsOf(const Marks& marks) {
    std::size_t count = 0;
    for (std::size_t n = 0; n < marks.rows(); ++n) {
        Word before = 0; // the bit before, as bit 0
        for (const Word word : marks.row(n)) {
            count += static_cast<std::size_t>(std::popcount(word & ~(word << 1 | before)));
            before = word >> (Marks::kWordBits - 1);
        }
    }
    return count;
}

class Runs {
  public:
    Runs(const Marks& marks, Connected connected) : rowFirst_(marks.rows() + 1) {
        runs_.reserve(runsOf(marks));
        const auto height = static_cast<std::size_t>(marks.extent().y);
        for (std::size_t n = 0; n < marks.rows(); ++n) {
            const std::span<const Word> row = marks.row(n);
            const int bits = static_cast<int>(row.size()) * Marks::kWordBits;
            for (int x = nextBit(row, 0, true); x < bits; x = nextBit(row, x, true)) {
                const int end = nextBit(row, x, false);
                runs_.push_back({x, end, static_cast<std::uint32_t>(runs_.size())});
                x = end;
            }
            rowFirst_[n + 1] = static_cast<std::uint32_t>(runs_.size());
            if (n % height != 0)
                join(n, n - 1);
            if (n >= height && connected == Connected::throughSlices)
                join(n, n - height);
        }
    }

    /// Calls each(run, number of its row), in order.
    template <typename Each> void forAll(const Each& each) {
        for (std::size_t n = 0; n + 1 < rowFirst_.size(); ++n)
            for (std::uint32_t i = rowFirst_[n]; i < rowFirst_[n + 1]; ++i)
                each(runs_[i], n);
    }
    /// Numbers the parts in the order of their roots; a run's parent is then its part.
    std::size_t numberParts() {
        std::uint32_t parts = 0;
        for (std::uint32_t i = 0; i < runs_.size(); ++i) {
            const std::uint32_t parent = runs_[i].parent;
            runs_[i].parent = parent == i ? parts++ : runs_[parent].parent; // the parent is before it
        }
        return parts;
    }

  private:
    std::uint32_t rootOf(std::uint32_t i) {
        while (runs_[i].parent != i)
            i = runs_[i].parent = runs_[runs_[i].parent].parent;
        return i;
    }
    /// Joins the runs of two rows that overlap.
    void join(std::size_t row, std::size_t other) {
        std::uint32_t a = rowFirst_[row], b = rowFirst_[other];
        while (a < rowFirst_[row + 1] && b < rowFirst_[other + 1]) {
            if (runs_[a].first < runs_[b].end && runs_[b].first < runs_[a].end) {
                const std::uint32_t one = rootOf(a), two = rootOf(b);
                runs_[std::max(one, two)].parent = std::min(one, two);
            }
            if (runs_[a].end < runs_[b].end)
                ++a;
            else
                ++b;
        }
    }

    std::vector<Run> runs_;
    std::vector<std::uint32_t> rowFirst_; // number of a row's first run
};

} // namespace

std::size_t partsBytes(const glm::ivec3& extent) {
    const std::size_t rows = cellCount({1, extent.y, extent.z});
    const std::size_t runs = rows * ((static_cast<std::size_t>(extent.x) + 1) / 2);
    return (rows + 1) * sizeof(std::uint32_t) + runs * sizeof(Run) +
           std::min(runs, cellCount(extent) / 2 + 1) * (sizeof(MarkPart) + 1);
}

Marks chosenParts(const Marks& marks, Connected connected, const Marks& other,
                  const std::function<bool(const MarkPart&)>& keep) {
    Runs runs(marks, connected);
    const glm::ivec3& extent = marks.extent();
    std::vector<MarkPart> parts(runs.numberParts(), {extent, glm::ivec3(0)});
    runs.forAll([&](const Run& run, std::size_t row) {
        MarkPart& part = parts[run.parent];
        const int y = static_cast<int>(row % static_cast<std::size_t>(extent.y)),
                  z = static_cast<int>(row / static_cast<std::size_t>(extent.y));
        part.low = glm::min(part.low, glm::ivec3(run.first, y, z));
        part.high = glm::max(part.high, glm::ivec3(run.end, y + 1, z + 1));
        part.voxels += static_cast<std::uint32_t>(run.end - run.first);
        part.isMeeting = part.isMeeting || hasAny(other.row(row), run.first, run.end);
    });
    std::vector<std::uint8_t> isKept(parts.size());
    std::transform(parts.begin(), parts.end(), isKept.begin(), keep);
    Marks kept(extent);
    runs.forAll([&](const Run& run, std::size_t row) {
        if (isKept[run.parent])
            fill(kept.row(row), run.first, run.end);
    });
    return kept;
}

} // namespace tessera
