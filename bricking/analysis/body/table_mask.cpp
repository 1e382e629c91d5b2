// bricking/analysis/body/table_mask.cpp: see table_mask.h.
#include "bricking/analysis/body/table_mask.h"

#include "bricking/analysis/body/body_box.h"
#include "bricking/analysis/body/body_marks.h"
#include "bricking/analysis/body/body_voxels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

namespace tessera {
namespace {

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
constexpr double kFilledHu = -600; // a sample half filled by tissue, and by a mattress or air
constexpr double kHardHu = 300;    // above skin and cartilage
constexpr double kFirmHu = -900;   // boards and cushions are above it, air with its noise is not

/// Samples that are dense and not body, in parts that run along the whole volume.
Marks longParts(const Marks& rest, const BodyGrid& grid) {
    Marks found(rest.size());
    const int least = static_cast<int>(std::ceil(kOfVolume * grid.extent.z));
    forParts(rest, grid, [&](std::span<const std::int32_t> voxels) {
        int low = grid.extent.z, high = 0;
        for (const std::int32_t voxel : voxels) {
            const int z = gridPosition(static_cast<std::size_t>(voxel), grid.extent).z;
            low = std::min(low, z), high = std::max(high, z + 1);
        }
        if (high - low >= least)
            for (const std::int32_t voxel : voxels)
                found[static_cast<std::size_t>(voxel)] = 1;
    });
    return found;
}

/// Drops what does not go on along z: of every sample the share is taken that a window along z has in its
/// column and the eight around.
void keepEven(Marks& marks, const BodyGrid& grid, const Even& even) {
    const glm::ivec3 e = grid.extent;
    const int half = std::max(1, static_cast<int>(even.windowMm / grid.spacingMm.z));
    const std::size_t slice = cellCount({e.x, e.y, 1});
    Marks wide(marks.size()); // a sample, and the eight around it in its slice
    for (std::size_t i = 0; i < marks.size(); ++i) {
        if (!marks[i])
            continue;
        const glm::ivec3 at = gridPosition(i, e);
        for (int v = std::max(at.y - 1, 0); v <= std::min(at.y + 1, e.y - 1); ++v)
            for (int u = std::max(at.x - 1, 0); u <= std::min(at.x + 1, e.x - 1); ++u)
                wide[linearIndex({u, v, at.z}, e)] = 1;
    }
    for (std::size_t column = 0; column < slice; ++column) {
        int count = 0, first = 0, end = 0; // of the window
        for (int z = 0; z < e.z; ++z) {
            const int low = std::max(0, z - half), high = std::min(e.z, z + half + 1);
            for (; end < high; ++end)
                count += wide[column + slice * static_cast<std::size_t>(end)];
            for (; first < low; ++first)
                count -= wide[column + slice * static_cast<std::size_t>(first)];
            std::uint8_t& mark = marks[column + slice * static_cast<std::size_t>(z)];
            mark = mark && count >= even.share * (high - low);
        }
    }
}

double litresOf(const Marks& marks, const BodyGrid& grid) {
    return static_cast<double>(std::count(marks.begin(), marks.end(), 1)) * grid.spacingMm.x *
           grid.spacingMm.y * grid.spacingMm.z / 1e6;
}

/// The body with what it encloses in a slice, such as lungs, and with walls around these that are too thin
/// for an opening. Enclosed is what sees on four sides the body, or nothing but firm samples to the border: a
/// narrow field of view opens one.
Marks closedBody(const Marks& dense, const Marks& firm, const BodyGrid& grid) {
    BodyMarks opened = bodyAmong(dense, grid);
    Marks& body = opened.marks;
    const Marks outside = reached(firm, grid);
    // On how many sides a line outwards meets the body; the same, or no air.
    std::vector<std::uint8_t> meets(body.size()), sides(body.size());
    for (const Outwards& each : kSides)
        forLines(each, grid.extent, [&](int steps, const auto& at) {
            bool met = false, air = false;
            for (int step = 0; step < steps; ++step) {
                met |= body[at(step)] != 0;
                air |= outside[at(step)] != 0;
                meets[at(step)] = static_cast<std::uint8_t>(meets[at(step)] + met);
                sides[at(step)] = static_cast<std::uint8_t>(sides[at(step)] + (met || !air));
            }
        });
    Marks within(body.size());
    for (std::size_t i = 0; i < within.size(); ++i)
        within[i] = !body[i] && !dense[i] && !outside[i] && sides[i] == 4 && meets[i] >= 3;
    if (std::find(within.begin(), within.end(), 1) == within.end())
        return body;
    const std::vector<float> away = distancesTo(within, 1, grid);
    for (std::size_t i = 0; i < body.size(); ++i)
        body[i] = body[i] || within[i] || (dense[i] && away[i] <= 4 * opened.ballMm * opened.ballMm);
    return body;
}

/// What may be the patient's though it seems to be table: dense, not surely even, and thicker than a shell,
/// or softer than bone and within kAttachedMm of the body, along itself.
Marks perhapsPatient(const Marks& dense, const Marks& hard, const Marks& table, const Marks& body,
                     const BodyGrid& grid) {
    const double least = std::max({grid.spacingMm.x, grid.spacingMm.y, grid.spacingMm.z, kThinMm});
    std::vector<float> away = distancesTo(dense, 0, grid);
    Marks core(dense.size()), surely = table;
    for (std::size_t i = 0; i < core.size(); ++i)
        core[i] = static_cast<double>(away[i]) > least * least;
    keepEven(surely, grid, kSurelyEven);
    away = distancesTo(core, 1, grid);
    Marks soft(dense.size());
    for (std::size_t i = 0; i < core.size(); ++i) {
        soft[i] = dense[i] && !surely[i] && !hard[i];
        core[i] = dense[i] && !surely[i] && static_cast<double>(away[i]) <= 4 * least * least;
    }
    Marks attached = body;
    growInto(attached, soft, grid, kAttachedMm);
    for (std::size_t i = 0; i < core.size(); ++i)
        core[i] = core[i] || (attached[i] && !body[i]);
    return core;
}

/// What is hidden, of a volume's hard, dense, half filled and firm samples; else the reason.
std::string hide(const Marks& hard, const Marks& dense, const Marks& filled, Marks firm, const BodyGrid& grid,
                 Marks& hidden) {
    const glm::ivec3 extent = grid.extent;
    if (extent.z * grid.spacingMm.z < kLeastLengthMm)
        return "the volume is shorter than " + std::to_string(static_cast<int>(kLeastLengthMm)) +
               " mm along the table";
    const Marks body = closedBody(dense, firm, grid);
    if (litresOf(body, grid) < kLeastBodyLitres)
        return "there is no body";
    // The skin's own samples are firm too, where it is between them.
    const Marks skin = dilated(body, extent);
    for (std::size_t i = 0; i < firm.size(); ++i)
        firm[i] = firm[i] && !skin[i];
    Marks table;
    std::array<std::size_t, kSides.size()> counts{};
    std::size_t best = 0;
    for (std::size_t n = 0; n < kSides.size(); ++n) {
        Marks found = longParts(both(firm, beyond(body, kSides[n], extent)), grid);
        if (std::find(found.begin(), found.end(), 1) == found.end())
            continue;
        keepEven(found, grid, kEven);
        counts[n] = facingBody(found, body, kSides[n], extent);
        if (table.empty() || counts[n] > counts[best]) {
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
    hidden.assign(dense.size(), 0);
    forLines(side, extent, [&](int steps, const auto& at) {
        int first = steps, last = -1;
        for (int step = steps - 1; step >= 0; --step) {
            first = table[at(step)] ? step : first;
            last = last < 0 && body[at(step)] ? step : last;
        }
        if (first == steps)
            return;
        for (int step = last >= 0 ? last + 1 : first; step < steps; ++step)
            hidden[at(step)] = !dense[at(step)] || (step >= first && !limbs[at(step)]);
    });
    // What is dense and not hidden stays, with the samples around it, and those around samples of its border
    // that it may half fill.
    Marks stays(dense.size());
    for (std::size_t i = 0; i < stays.size(); ++i)
        stays[i] = dense[i] && !hidden[i];
    const Marks around = dilated(stays, extent);
    for (std::size_t i = 0; i < stays.size(); ++i)
        stays[i] = stays[i] || (around[i] && filled[i] && !table[i]);
    stays = dilated(stays, extent);
    for (std::size_t i = 0; i < hidden.size(); ++i)
        hidden[i] = hidden[i] && !stays[i];
    // Air and cushions beside it, never a lung that a narrow field of view lays open.
    Marks open = beyond(body, side, extent);
    for (std::size_t i = 0; i < open.size(); ++i)
        open[i] = open[i] && !stays[i];
    growInto(hidden, open, grid, kCushionMm);
    return "";
}

} // namespace

std::size_t tableMaskBytes(const VolumeInfo& info) {
    const int level = bodyLevelOf(info, kMostTableSamples);
    return kBodyBytesPerSample * cellCount(levelExtent(info.extentVoxels, level)) +
           cellCount(glm::ivec3(kChunkExtent)) * bytesPerValue(info.type);
}

FoundTable findTable(const ChunkSource& volume, MemoryBudget& ram, int threads) {
    const VolumeInfo& info = volume.info();
    const int level = bodyLevelOf(info, kMostTableSamples);
    const BodyGrid grid(info, level, threads);
    FoundTable found;
    Marks hidden;
    {
        const Charge charge = ram.charge(tableMaskBytes(info), "finding the table");
        const Marks above =
            samplesAbove(std::array{kFirmHu, kFilledHu, kBodyHu, kHardHu}, volume, level, grid);
        const auto atLeast = [&](int count) {
            Marks marks(above.size());
            std::transform(above.begin(), above.end(), marks.begin(),
                           [count](std::uint8_t each) { return each >= count; });
            return marks;
        };
        const Marks dense = atLeast(3);
        found.why = hide(atLeast(4), dense, atLeast(2), atLeast(1), grid, hidden);
        if (!found.why.empty())
            return found;
        Marks seen(dense.size());
        for (std::size_t i = 0; i < seen.size(); ++i)
            seen[i] = dense[i] && hidden[i];
        found.litres = litresOf(seen, grid);
    }
    for (std::uint8_t& share : hidden)
        share = share ? 255 : 0;
    found.mask = std::make_shared<const Mask>(info.extentVoxels, level, std::move(hidden), ram);
    return found;
}

} // namespace tessera
