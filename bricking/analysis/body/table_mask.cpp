// bricking/analysis/body/table_mask.cpp: see table_mask.h.
#include "bricking/analysis/body/table_mask.h"

#include "bricking/analysis/body/body_box.h"
#include "bricking/analysis/body/body_marks.h"
#include "bricking/analysis/body/body_voxels.h"
#include "bricking/analysis/body/mark_distance.h"
#include "bricking/analysis/body/mark_parts.h"
#include "bricking/analysis/body/marks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace tessera {
namespace {

using Word = Marks::Word;

constexpr std::size_t kMostTableSamples = std::size_t{5} << 20;
constexpr double kLeastBodyLitres = 0.3;
constexpr double kLeastLengthMm = 40;
constexpr double kOfVolume = 0.8; // of the volume's length that a table takes at least
/// An even cross-section: the share that is taken of a window, so long to either side along the table.
struct Even {
    double windowMm, share;
};
constexpr Even kEven{60, 0.5};
constexpr Even kSurelyEven{300, 0.85}; // no limb is
constexpr double kAttachedMm = 25;     // of thin parts that stand off the body: ears, folds of skin
constexpr double kThinMm = 5;          // half of the thickness of shells: hands and feet are thicker
/// Of the lines that meet a table, those that meet something on the other side, at most.
constexpr double kOfOpposite = 0.25;
constexpr double kCrumbMl = 1;     // less than the end of a finger
constexpr double kFilledHu = -600; // a sample half filled by tissue, and by a mattress or air
constexpr double kWallMm = 80;     // along itself, of a holder's walls beside the patient
constexpr double kHardHu = 300;    // above skin and cartilage
constexpr double kFirmHu = -900;   // boards and cushions are above it, air with its noise is not

/// Samples that are dense and not body, in parts that run along the whole volume.
Marks longParts(const Marks& rest) {
    const int least = static_cast<int>(std::ceil(kOfVolume * rest.extent().z));
    return chosenParts(rest, Connected::throughSlices, rest,
                       [&](const MarkPart& part) { return part.high.z - part.low.z >= least; });
}

/// Drops what does not go on along z: of every sample the share is taken that a window along z has in its
/// column and the eight around.
void keepEven(Marks& marks, const BodyGrid& grid, const Even& even) {
    const glm::ivec3 e = grid.extent;
    const int half = std::max(1, static_cast<int>(even.windowMm / grid.spacingMm.z));
    const Marks wide = dilatedInSlices(marks);
    std::vector<int> counts(cellCount({e.x, e.y, 1})); // of each column's window
    const auto count = [&](int z, int each) {
        for (int y = 0; y < e.y; ++y) {
            int* const row = counts.data() + linearIndex({0, y, 0}, e);
            forMarked(wide.row(wide.rowNumber(y, z)), [&](int x) { row[x] += each; });
        }
    };
    for (int z = 0, first = 0, end = 0; z < e.z; ++z) {
        const int low = std::max(0, z - half), high = std::min(e.z, z + half + 1);
        while (end < high)
            count(end++, 1);
        while (first < low)
            count(first++, -1);
        for (int y = 0; y < e.y; ++y) {
            const int* const row = counts.data() + linearIndex({0, y, 0}, e);
            const std::span<Word> marked = marks.row(marks.rowNumber(y, z));
            forMarked(marked, [&](int x) { // each bit was read before it is cleared
                if (row[x] < even.share * (high - low))
                    marked[static_cast<std::size_t>(x / Marks::kWordBits)] &=
                        ~(Word{1} << (x % Marks::kWordBits));
            });
        }
    }
}

double litresOf(const Marks& marks, const BodyGrid& grid) {
    return static_cast<double>(marks.count()) * grid.spacingMm.x * grid.spacingMm.y * grid.spacingMm.z / 1e6;
}

/// Samples that see the body on three sides at least, and nothing but firm samples to the border on any
/// other.
Marks enclosed(const Marks& body, const Marks& outside) {
    Marks all = Marks::all(body.extent());
    std::array<Marks, kSides.size()> met;
    for (std::size_t n = 0; n < kSides.size(); ++n) {
        met[n] = onwards(body, kSides[n]);
        all = combined([](Word so, Word meets, Word air) { return so & (meets | ~air); }, all, met[n],
                       onwards(outside, kSides[n]));
    }
    return combined(
        [](Word so, Word a, Word b, Word c, Word d) { return so & ((a & b & (c | d)) | (c & d & (a | b))); },
        all, met[0], met[1], met[2], met[3]);
}

/// The body with what it encloses in a slice, such as lungs, and with walls around these that are too thin
/// for an opening. Enclosed is what sees on four sides the body, or nothing but firm samples to the border: a
/// narrow field of view opens one.
/// @param outside  the air that the borders of slices reach
Marks closedBody(const Marks& dense, const Marks& outside, const BodyGrid& grid) {
    const BodyMarks opened = bodyAmong(dense, grid);
    const Marks& body = opened.marks;
    const Marks inside = combined([](Word so, Word a, Word b, Word c) { return so & ~(a | b | c); },
                                  enclosed(body, outside), body, dense, outside);
    const Marks near = within(inside, grid.spacingMm, 4 * opened.ballMm * opened.ballMm, grid.threads);
    return combined([](Word a, Word within, Word thick, Word close) { return a | within | (thick & close); },
                    body, inside, dense, near);
}

/// What may be the patient's though it seems to be table: dense, not surely even, and thicker than a shell,
/// or softer than bone and within kAttachedMm of the body, along itself.
Marks perhapsPatient(const Marks& dense, const Marks& hard, const Marks& table, const Marks& body,
                     const BodyGrid& grid) {
    const double least = std::max({grid.spacingMm.x, grid.spacingMm.y, grid.spacingMm.z, kThinMm});
    const Marks core = without(
        dense, within(without(Marks::all(grid.extent), dense), grid.spacingMm, least * least, grid.threads));
    Marks surely = table;
    keepEven(surely, grid, kSurelyEven);
    const Marks thick =
        both(without(dense, surely), within(core, grid.spacingMm, 4 * least * least, grid.threads));
    const Marks soft =
        combined([](Word all, Word even, Word bone) { return all & ~(even | bone); }, dense, surely, hard);
    Marks attached = body;
    growInto(attached, soft, grid, kAttachedMm);
    return combined([](Word one, Word grown, Word own) { return one | (grown & ~own); }, thick, attached,
                    body);
}

/// Adds the walls of a holder that reach around the patient: what is hard, thin and goes on from what is
/// hidden, with the samples around it.
void addWalls(Marks& hidden, const Marks& hard, const Marks& body, const BodyGrid& grid) {
    Marks wall = both(hidden, hard);
    const Marks bone = without(hard, within(without(Marks::all(grid.extent), hard), grid.spacingMm,
                                            kThinMm * kThinMm, grid.threads));
    const Marks near = within(bone, grid.spacingMm, 4 * kThinMm * kThinMm, grid.threads);
    growInto(wall,
             combined([](Word all, Word own, Word thick) { return all & ~(own | thick); }, hard, body, near),
             grid, kWallMm);
    hidden = combined([](Word own, Word around, Word of) { return own | (around & ~of); }, hidden,
                      dilated(wall), body);
}

/// Of what stays, parts that are apart from the body and all else, too small to be of the patient, in the air
/// and near to what is hidden: the table's, where it changes along the scan or reaches around the patient.
Marks crumbs(const Marks& stays, const Marks& body, const Marks& outside, const Marks& hidden,
             const BodyGrid& grid) {
    const double most = kCrumbMl * 1000 / (grid.spacingMm.x * grid.spacingMm.y * grid.spacingMm.z);
    const Marks small = chosenParts(stays, Connected::throughSlices, body, [most](const MarkPart& part) {
        return !part.isMeeting && static_cast<double>(part.voxels) <= most;
    });
    if (!small.any())
        return small;
    const Marks near =
        both(within(hidden, grid.spacingMm, kAttachedMm * kAttachedMm, grid.threads), dilated(outside));
    return chosenParts(small, Connected::throughSlices, near,
                       [](const MarkPart& part) { return part.isMeeting; });
}

/// What is hidden, of a volume's hard, dense, half filled and firm samples; else the reason.
std::string hide(const Marks& hard, const Marks& dense, const Marks& filled, Marks firm, const BodyGrid& grid,
                 Marks& hidden) {
    if (grid.extent.z * grid.spacingMm.z < kLeastLengthMm)
        return "the volume is shorter than " + std::to_string(static_cast<int>(kLeastLengthMm)) +
               " mm along the table";
    const Marks outside = reached(firm);
    const Marks body = closedBody(dense, outside, grid);
    if (litresOf(body, grid) < kLeastBodyLitres)
        return "there is no body";
    // The skin's own samples are firm too, where it is between them.
    firm = without(firm, dilated(body));
    Marks table;
    std::array<std::size_t, kSides.size()> counts{};
    std::size_t best = 0;
    for (std::size_t n = 0; n < kSides.size(); ++n) {
        Marks found = longParts(both(firm, beyond(body, kSides[n])));
        if (!found.any())
            continue;
        keepEven(found, grid, kEven);
        counts[n] = facingBody(found, body, kSides[n]);
        if (table.words().empty() || counts[n] > counts[best]) {
            best = n;
            table = std::move(found);
        }
    }
    const Outwards side = kSides[best];
    if (counts[best] == 0)
        return "nothing beside the body runs along the whole volume";
    if (static_cast<double>(counts[best ^ 1u]) > kOfOpposite * static_cast<double>(counts[best]))
        return "what runs along the whole volume lies on opposite sides of the body";
    const Marks limbs = perhapsPatient(dense, hard, table, body, grid);
    // On lines that meet the table: all beyond the body, or where there is none, beyond the table's face.
    // What is dense and nearer to the patient may lie on it, and so may a hand or a foot.
    const Marks fromTable = onwards(table, side), open = beyond(body, side);
    hidden = combined([](Word onLine, Word outer, Word hasBody,
                         Word behind) { return onLine & outer & (hasBody | behind); },
                      linesOf(table, side), open, linesOf(body, side), fromTable);
    hidden = combined(
        [](Word out, Word thick, Word behind, Word limb) { return out & (~thick | (behind & ~limb)); },
        hidden, dense, fromTable, limbs);
    addWalls(hidden, hard, body, grid);
    // What is dense and not hidden stays, with the samples around it, and those around samples of its border
    // that it may half fill.
    Marks stays = without(dense, hidden);
    const Marks small = crumbs(stays, body, outside, hidden, grid);
    stays = without(stays, small);
    hidden = combined([](Word own, Word around) { return own | around; }, hidden, dilated(small));
    stays =
        combined([](Word own, Word around, Word half, Word even) { return own | (around & half & ~even); },
                 stays, dilated(stays), filled, table);
    stays = dilated(stays);
    hidden = without(hidden, stays);
    // Air and cushions beside it, never a lung that a narrow field of view lays open.
    growInto(hidden, without(open, stays), grid, kCushionMm);
    return "";
}

} // namespace

std::size_t tableMaskBytes(const VolumeInfo& info) {
    const int level = bodyLevelOf(info, kMostTableSamples);
    return bodyBytes(levelExtent(info.extentVoxels, level), info.type);
}

FoundTable findTable(const ChunkSource& volume, MemoryBudget& ram, int threads) {
    const VolumeInfo& info = volume.info();
    const int level = bodyLevelOf(info, kMostTableSamples);
    const BodyGrid grid(info, level, threads);
    FoundTable found;
    Marks hidden;
    {
        const Charge charge = ram.charge(tableMaskBytes(info), "finding the table");
        const std::vector<Marks> above =
            samplesAbove(std::array{kFirmHu, kFilledHu, kBodyHu, kHardHu}, volume, level, grid);
        const Marks& dense = above[2];
        found.why = hide(above[3], dense, above[1], above[0], grid, hidden);
        if (!found.why.empty())
            return found;
        found.litres = litresOf(both(dense, hidden), grid);
    }
    std::vector<std::uint8_t> shares(grid.size());
    for (std::size_t n = 0; n < hidden.rows(); ++n) {
        std::uint8_t* const row = shares.data() + n * static_cast<std::size_t>(grid.extent.x);
        forMarked(hidden.row(n), [&](int x) { row[x] = 255; });
    }
    found.mask = std::make_shared<const Mask>(info.extentVoxels, level, std::move(shares), ram);
    return found;
}

} // namespace tessera
