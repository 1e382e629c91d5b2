// bricking/analysis/body/body_marks.cpp: see body_marks.h.
#include "bricking/analysis/body/body_marks.h"

#include "bricking/analysis/body/mark_parts.h"

#include <cstdint>
#include <utility>
#include <vector>

namespace tessera {
namespace {

using Word = Marks::Word;

/// Marks of each sample and its neighbours along an axis.
Marks spread(const Marks& marks, int axis) {
    const glm::ivec3& extent = marks.extent();
    Marks out = marks;
    if (axis == 0) {
        for (std::size_t n = 0; n < marks.rows(); ++n) {
            const std::span<const Word> from = marks.row(n);
            const std::span<Word> to = out.row(n);
            for (std::size_t i = 0; i < from.size(); ++i) {
                to[i] |= from[i] << 1 | from[i] >> 1;
                if (i > 0)
                    to[i] |= from[i - 1] >> (Marks::kWordBits - 1);
                if (i + 1 < from.size())
                    to[i] |= from[i + 1] << (Marks::kWordBits - 1);
            }
            to.back() &= marks.lastWord();
        }
        return out;
    }
    const auto words = static_cast<std::size_t>(marks.rowWords());
    const std::size_t height = words * static_cast<std::size_t>(extent.y);
    const std::size_t stride = axis == 1 ? words : height, block = axis == 1 ? height : marks.words().size();
    const std::span<const Word> from = marks.words();
    const std::span<Word> to = out.words();
    for (std::size_t start = 0; start < from.size(); start += block)
        for (std::size_t i = start; i + stride < start + block; ++i) {
            to[i] |= from[i + stride];
            to[i + stride] |= from[i];
        }
    return out;
}

/// All bits of a row from its first marked one on, or up to its last.
void fillOutwards(std::span<Word> row, bool up, Word lastWord) {
    bool isMarked = false;
    for (std::size_t n = 0; n < row.size(); ++n) {
        Word& word = row[up ? n : row.size() - 1 - n];
        if (isMarked)
            word = ~Word{0};
        else if (word != 0) {
            isMarked = true;
            word = up ? ~Word{0} << std::countr_zero(word) : ~Word{0} >> std::countl_zero(word);
        }
    }
    row.back() &= lastWord;
}

} // namespace

Marks reached(const Marks& firm) {
    const glm::ivec3 extent = firm.extent();
    const Marks open = without(Marks::all(extent), firm);
    return chosenParts(open, Connected::inSlices, open, [&](const MarkPart& part) {
        return part.low.x == 0 || part.low.y == 0 || part.high.x == extent.x || part.high.y == extent.y;
    });
}

Marks onwards(const Marks& marks, const Outwards& side) {
    const glm::ivec3& extent = marks.extent();
    Marks out = marks;
    if (side.axis == 0) {
        for (std::size_t n = 0; n < out.rows(); ++n)
            fillOutwards(out.row(n), side.up, out.lastWord());
        return out;
    }
    for (int z = 0; z < extent.z; ++z)
        for (int step = 1; step < extent.y; ++step) {
            const int y = side.up ? step : extent.y - 1 - step;
            const std::span<const Word> before = out.row(out.rowNumber(side.up ? y - 1 : y + 1, z));
            const std::span<Word> row = out.row(out.rowNumber(y, z));
            for (std::size_t i = 0; i < row.size(); ++i)
                row[i] |= before[i];
        }
    return out;
}

Marks linesOf(const Marks& marks, const Outwards& side) {
    return onwards(onwards(marks, side), side.opposite());
}

Marks beyond(const Marks& body, const Outwards& side) {
    return without(Marks::all(body.extent()), onwards(body, side.opposite()));
}

std::size_t facingBody(const Marks& marks, const Marks& body, const Outwards& side) {
    return both(linesOf(marks, side), linesOf(body, side)).count() /
           static_cast<std::size_t>(marks.extent()[side.axis]);
}

Marks dilatedInSlices(const Marks& marks) {
    return spread(spread(marks, 0), 1);
}

Marks dilated(const Marks& marks) {
    return spread(dilatedInSlices(marks), 2);
}

Marks besideFaces(const Marks& marks) {
    return combined([](Word x, Word y, Word z) { return x | y | z; }, spread(marks, 0), spread(marks, 1),
                    spread(marks, 2));
}

namespace {
/// A sample that was added, and how far it lies along its way.
struct Grown {
    std::int32_t index;
    float awayMm;
};
} // namespace

std::size_t growthBytes(const glm::ivec3& extent) {
    return 2 * cellCount(extent) * sizeof(Grown);
}

void growInto(Marks& marks, const Marks& open, const BodyGrid& grid, double mostMm) {
    const glm::ivec3& extent = grid.extent;
    const Marks free = without(open, marks), seeds = both(marks, besideFaces(free));
    std::vector<Grown> front, next; // samples of as many steps each
    front.reserve(std::max(seeds.count(), free.count()));
    next.reserve(free.count());
    for (int z = 0; z < extent.z; ++z)
        for (int y = 0; y < extent.y; ++y)
            forMarked(seeds.row(seeds.rowNumber(y, z)), [&](int x) {
                front.push_back({static_cast<std::int32_t>(linearIndex({x, y, z}, extent)), 0});
            });
    for (; !front.empty(); front.swap(next), next.clear())
        for (const Grown& from : front) {
            const glm::ivec3 at = gridPosition(static_cast<std::size_t>(from.index), extent);
            for (int face = 0; face < 6; ++face) {
                const int axis = face / 2;
                glm::ivec3 to = at;
                to[axis] += face % 2 == 0 ? -1 : 1;
                if (to[axis] < 0 || to[axis] >= extent[axis] || marks.has(to) || !open.has(to))
                    continue;
                const float away = from.awayMm + static_cast<float>(grid.spacingMm[axis]);
                if (away > mostMm)
                    continue;
                marks.add(to);
                next.push_back({static_cast<std::int32_t>(linearIndex(to, extent)), away});
            }
        }
}

} // namespace tessera
