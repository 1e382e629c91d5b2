// tests/support/plain_body.cpp: see plain_body.h.
#include "tests/support/plain_body.h"

#include "bricking/analysis/body/body_box.h"
#include "bricking/analysis/body/mark_distance.h" // kFarAway
#include "core/base/lower_envelope.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>

namespace tessera::test {
namespace {

/// Calls what(index) for the voxels beyond the faces of one.
template <typename What> void beside(std::size_t index, const glm::ivec3& extent, const What& what) {
    const glm::ivec3 at = gridPosition(index, extent);
    for (int face = 0; face < 6; ++face) {
        glm::ivec3 next = at;
        next[face / 2] += face % 2 == 0 ? -1 : 1;
        if (next[face / 2] >= 0 && next[face / 2] < extent[face / 2])
            what(linearIndex(next, extent), face / 2);
    }
}

/// A side, +y, -y, +x or -x, as lines of voxels from the patient outwards: line(place of each).
template <typename Line> void plainLines(int side, const glm::ivec3& e, const Line& line) {
    const int axis = side < 2 ? 1 : 0;
    std::vector<std::size_t> places(static_cast<std::size_t>(e[axis]));
    for (int z = 0; z < e.z; ++z)
        for (int n = 0; n < e[1 - axis]; ++n) {
            for (int step = 0; step < e[axis]; ++step) {
                glm::ivec3 at(0, 0, z);
                at[1 - axis] = n;
                at[axis] = side % 2 == 0 ? step : e[axis] - 1 - step;
                places[static_cast<std::size_t>(step)] = linearIndex(at, e);
            }
            line(places);
        }
}

PlainMarks reachedAir(const PlainMarks& firm, const glm::ivec3& e) {
    PlainMarks air(firm.size());
    for (bool grows = true; grows;) {
        grows = false;
        const auto look = [&](std::size_t i) {
            const glm::ivec3 at = gridPosition(i, e);
            bool reaches = at.x == 0 || at.y == 0 || at.x == e.x - 1 || at.y == e.y - 1;
            beside(i, e, [&](std::size_t next, int axis) { reaches = reaches || (axis < 2 && air[next]); });
            if (!firm[i] && !air[i] && reaches)
                air[i] = 1, grows = true;
        };
        for (std::size_t i = 0; i < firm.size(); ++i)
            look(i);
        for (std::size_t i = firm.size(); i-- > 0;)
            look(i);
    }
    return air;
}

PlainMarks closedPlainBody(const PlainMarks& dense, const PlainMarks& outside, const BodyGrid& grid) {
    double ball = 0;
    PlainMarks body = plainBody(dense, grid, ball);
    std::vector<int> meets(body.size()), sides(body.size());
    for (int side = 0; side < 4; ++side)
        plainLines(side, grid.extent, [&](const std::vector<std::size_t>& line) {
            bool met = false, air = false;
            for (const std::size_t i : line) {
                met = met || body[i];
                air = air || outside[i];
                meets[i] += met;
                sides[i] += met || !air;
            }
        });
    PlainMarks inside(body.size());
    for (std::size_t i = 0; i < body.size(); ++i)
        inside[i] = !body[i] && !dense[i] && !outside[i] && sides[i] == 4 && meets[i] >= 3;
    const std::vector<float> away = plainDistances(inside, 1, grid);
    for (std::size_t i = 0; i < body.size(); ++i)
        body[i] = body[i] || inside[i] || (dense[i] && static_cast<double>(away[i]) <= 4 * ball * ball);
    return body;
}

void keepEvenOf(PlainMarks& marks, const BodyGrid& grid, double windowMm, double share) {
    const glm::ivec3 e = grid.extent;
    const int half = std::max(1, static_cast<int>(windowMm / grid.spacingMm.z));
    const PlainMarks before = marks;
    for (std::size_t i = 0; i < marks.size(); ++i) {
        if (!marks[i])
            continue;
        const glm::ivec3 at = gridPosition(i, e);
        const int low = std::max(0, at.z - half), high = std::min(e.z, at.z + half + 1);
        int count = 0;
        for (int z = low; z < high; ++z) {
            bool any = false;
            for (int n = 0; n < 9; ++n) {
                const glm::ivec3 near(at.x + n % 3 - 1, at.y + n / 3 - 1, z);
                any = any || (near.x >= 0 && near.y >= 0 && near.x < e.x && near.y < e.y &&
                              before[linearIndex(near, e)]);
            }
            count += any;
        }
        marks[i] = count >= share * (high - low);
    }
}

PlainMarks patientOf(const PlainMarks& dense, const PlainMarks& hard, const PlainMarks& table,
                     const PlainMarks& body, const BodyGrid& grid) {
    const double least = std::max({grid.spacingMm.x, grid.spacingMm.y, grid.spacingMm.z, 5.});
    std::vector<float> away = plainDistances(dense, 0, grid);
    PlainMarks core(dense.size()), surely = table, soft(dense.size()), attached = body;
    for (std::size_t i = 0; i < core.size(); ++i)
        core[i] = static_cast<double>(away[i]) > least * least;
    keepEvenOf(surely, grid, 300, 0.85);
    away = plainDistances(core, 1, grid);
    for (std::size_t i = 0; i < core.size(); ++i) {
        soft[i] = dense[i] && !surely[i] && !hard[i];
        core[i] = dense[i] && !surely[i] && static_cast<double>(away[i]) <= 4 * least * least;
    }
    plainGrowInto(attached, soft, grid, 25);
    for (std::size_t i = 0; i < core.size(); ++i)
        core[i] = core[i] || (attached[i] && !body[i]);
    return core;
}

/// Thin hard walls, 80 mm along themselves from what is hidden.
void addPlainWalls(PlainMarks& hidden, const PlainMarks& hard, const PlainMarks& body, const BodyGrid& grid) {
    const std::vector<float> depths = plainDistances(hard, 0, grid);
    PlainMarks bone(hard.size()), wall(hard.size()), open(hard.size());
    for (std::size_t i = 0; i < hard.size(); ++i)
        bone[i] = depths[i] > 25;
    const std::vector<float> away = plainDistances(bone, 1, grid);
    for (std::size_t i = 0; i < hard.size(); ++i) {
        wall[i] = hidden[i] && hard[i];
        open[i] = hard[i] && !body[i] && away[i] > 100;
    }
    plainGrowInto(wall, open, grid, 80);
    const PlainMarks around = plainDilated(wall, grid.extent);
    for (std::size_t i = 0; i < hard.size(); ++i)
        hidden[i] = hidden[i] || (around[i] && !body[i]);
}

/// Parts of a millilitre at most, apart from the body, that touch air within 25 mm of what is hidden.
PlainMarks plainCrumbs(const PlainMarks& stays, const PlainMarks& body, const PlainMarks& outside,
                       const PlainMarks& hidden, const BodyGrid& grid) {
    const std::vector<float> away = plainDistances(hidden, 1, grid);
    const PlainMarks air = plainDilated(outside, grid.extent);
    PlainMarks crumbs(stays.size());
    plainParts(stays, grid, [&](std::span<const std::size_t> voxels) {
        const auto any = [&](const auto& is) { return std::any_of(voxels.begin(), voxels.end(), is); };
        const bool isSmall = static_cast<double>(voxels.size()) <=
                             1000 / (grid.spacingMm.x * grid.spacingMm.y * grid.spacingMm.z);
        if (isSmall && !any([&](std::size_t i) { return body[i] != 0; }) &&
            any([&](std::size_t i) { return air[i] && away[i] <= 625; }))
            for (const std::size_t voxel : voxels)
                crumbs[voxel] = 1;
    });
    return crumbs;
}

std::string hidePlain(const std::array<PlainMarks, 4>& above, const BodyGrid& grid, PlainMarks& hidden) {
    const PlainMarks &filled = above[1], &dense = above[2], &hard = above[3];
    PlainMarks firm = above[0];
    const glm::ivec3 e = grid.extent;
    if (e.z * grid.spacingMm.z < 40)
        return "the volume is shorter than 40 mm along the table";
    const PlainMarks outside = reachedAir(firm, e);
    const PlainMarks body = closedPlainBody(dense, outside, grid);
    if (static_cast<double>(std::count(body.begin(), body.end(), 1)) * grid.spacingMm.x * grid.spacingMm.y *
            grid.spacingMm.z / 1e6 <
        0.3)
        return "there is no body";
    const PlainMarks skin = plainDilated(body, e);
    for (std::size_t i = 0; i < firm.size(); ++i)
        firm[i] = firm[i] && !skin[i];
    const auto beyondBody = [&](int side) {
        PlainMarks marks(body.size());
        plainLines(side, e, [&](const std::vector<std::size_t>& line) {
            for (auto at = line.rbegin(); at != line.rend() && !body[*at]; ++at)
                marks[*at] = 1;
        });
        return marks;
    };
    PlainMarks table;
    std::array<int, 4> counts{};
    int best = 0;
    for (int side = 0; side < 4; ++side) {
        PlainMarks rest = beyondBody(side), found(body.size());
        for (std::size_t i = 0; i < rest.size(); ++i)
            rest[i] = rest[i] && firm[i];
        plainParts(rest, grid, [&](std::span<const std::size_t> voxels) {
            int low = e.z, high = 0;
            for (const std::size_t voxel : voxels) {
                low = std::min(low, gridPosition(voxel, e).z);
                high = std::max(high, gridPosition(voxel, e).z + 1);
            }
            if (high - low >= static_cast<int>(std::ceil(0.8 * e.z)))
                for (const std::size_t voxel : voxels)
                    found[voxel] = 1;
        });
        if (std::find(found.begin(), found.end(), 1) == found.end())
            continue;
        keepEvenOf(found, grid, 60, 0.5);
        plainLines(side, e, [&](const std::vector<std::size_t>& line) {
            const auto meets = [&](const PlainMarks& marks) {
                return std::any_of(line.begin(), line.end(), [&](std::size_t i) { return marks[i] != 0; });
            };
            counts[static_cast<std::size_t>(side)] += meets(found) && meets(body);
        });
        if (table.empty() ||
            counts[static_cast<std::size_t>(side)] > counts[static_cast<std::size_t>(best)]) {
            best = side;
            table = found;
        }
    }
    if (counts[static_cast<std::size_t>(best)] == 0)
        return "nothing beside the body runs along the whole volume";
    if (counts[static_cast<std::size_t>(best ^ 1)] > 0.25 * counts[static_cast<std::size_t>(best)])
        return "what runs along the whole volume lies on opposite sides of the body";
    const PlainMarks limbs = patientOf(dense, hard, table, body, grid);
    hidden.assign(dense.size(), 0);
    plainLines(best, e, [&](const std::vector<std::size_t>& line) {
        const int steps = static_cast<int>(line.size());
        int first = steps, last = -1;
        for (int step = steps - 1; step >= 0; --step) {
            first = table[line[static_cast<std::size_t>(step)]] ? step : first;
            last = last < 0 && body[line[static_cast<std::size_t>(step)]] ? step : last;
        }
        for (int step = last >= 0 ? last + 1 : first; first < steps && step < steps; ++step) {
            const std::size_t i = line[static_cast<std::size_t>(step)];
            hidden[i] = !dense[i] || (step >= first && !limbs[i]);
        }
    });
    addPlainWalls(hidden, hard, body, grid);
    PlainMarks stays(dense.size()), open = beyondBody(best);
    for (std::size_t i = 0; i < stays.size(); ++i)
        stays[i] = dense[i] && !hidden[i];
    const PlainMarks crumbs = plainCrumbs(stays, body, outside, hidden, grid),
                     aroundCrumbs = plainDilated(crumbs, e);
    for (std::size_t i = 0; i < stays.size(); ++i) {
        stays[i] = stays[i] && !crumbs[i];
        hidden[i] = hidden[i] || aroundCrumbs[i];
    }
    const PlainMarks around = plainDilated(stays, e);
    for (std::size_t i = 0; i < stays.size(); ++i)
        stays[i] = stays[i] || (around[i] && filled[i] && !table[i]);
    stays = plainDilated(stays, e);
    for (std::size_t i = 0; i < hidden.size(); ++i) {
        hidden[i] = hidden[i] && !stays[i];
        open[i] = open[i] && !stays[i];
    }
    plainGrowInto(hidden, open, grid, 50);
    return "";
}

} // namespace

Marks bitsOf(const PlainMarks& plain, const glm::ivec3& extent) {
    Marks marks(extent);
    for (std::size_t i = 0; i < plain.size(); ++i)
        if (plain[i])
            marks.add(gridPosition(i, extent));
    return marks;
}

PlainMarks bytesOf(const Marks& marks) {
    PlainMarks plain(cellCount(marks.extent()));
    for (std::size_t i = 0; i < plain.size(); ++i)
        plain[i] = marks.has(gridPosition(i, marks.extent()));
    return plain;
}

std::vector<float> plainDistances(const PlainMarks& marks, std::uint8_t of, const BodyGrid& grid) {
    std::vector<float> field(marks.size());
    std::transform(marks.begin(), marks.end(), field.begin(),
                   [of](std::uint8_t mark) { return mark == of ? 0.f : kFarAway; });
    LowerEnvelope envelope;
    for (int axis = 0; axis < 3; ++axis) {
        std::vector<double> line(static_cast<std::size_t>(grid.extent[axis]));
        for (std::size_t start = 0; start < field.size(); ++start) {
            glm::ivec3 at = gridPosition(start, grid.extent);
            if (at[axis] != 0)
                continue;
            const auto valueAt = [&](std::size_t i) -> float& {
                at[axis] = static_cast<int>(i);
                return field[linearIndex(at, grid.extent)];
            };
            for (std::size_t i = 0; i < line.size(); ++i)
                line[i] = valueAt(i) < kFarAway ? static_cast<double>(valueAt(i))
                                                : std::numeric_limits<double>::infinity();
            envelope.transform(line, grid.spacingMm[axis]);
            for (std::size_t i = 0; i < line.size(); ++i)
                valueAt(i) = line[i] < static_cast<double>(kFarAway) ? static_cast<float>(line[i]) : kFarAway;
        }
    }
    return field;
}

void plainParts(const PlainMarks& marks, const BodyGrid& grid,
                const std::function<void(std::span<const std::size_t>)>& part) {
    PlainMarks seen(marks.size());
    for (std::size_t start = 0; start < marks.size(); ++start) {
        if (!marks[start] || seen[start])
            continue;
        std::vector<std::size_t> voxels = {start};
        seen[start] = 1;
        for (std::size_t n = 0; n < voxels.size(); ++n)
            beside(voxels[n], grid.extent, [&](std::size_t next, int) {
                if (marks[next] && !seen[next]) {
                    seen[next] = 1;
                    voxels.push_back(next);
                }
            });
        part(voxels);
    }
}

PlainMarks plainDilated(const PlainMarks& marks, const glm::ivec3& extent) {
    PlainMarks out(marks.size());
    for (std::size_t i = 0; i < marks.size(); ++i)
        for (std::size_t n = 0; n < 27; ++n) {
            const glm::ivec3 at = gridPosition(i, extent) + gridPosition(n, glm::ivec3(3)) - 1;
            if (at == glm::clamp(at, glm::ivec3(0), extent - 1) && marks[linearIndex(at, extent)])
                out[i] = 1;
        }
    return out;
}

void plainGrowInto(PlainMarks& marks, const PlainMarks& open, const BodyGrid& grid, double mostMm) {
    std::vector<std::size_t> next;
    std::vector<float> away(marks.size(), 0);
    for (std::size_t i = 0; i < marks.size(); ++i)
        if (marks[i])
            next.push_back(i);
    for (std::size_t n = 0; n < next.size(); ++n) {
        const std::size_t from = next[n];
        beside(from, grid.extent, [&](std::size_t to, int axis) {
            const float far = away[from] + static_cast<float>(grid.spacingMm[axis]);
            if (marks[to] || !open[to] || static_cast<double>(far) > mostMm)
                return;
            marks[to] = 1;
            away[to] = far;
            next.push_back(to);
        });
    }
}

PlainMarks plainBody(const PlainMarks& dense, const BodyGrid& grid, double& ballMm) {
    std::vector<float> depths = plainDistances(dense, 0, grid);
    const double thickest = std::sqrt(static_cast<double>(*std::max_element(depths.begin(), depths.end())));
    if (thickest >= std::sqrt(static_cast<double>(kFarAway)))
        return dense;
    const double least = std::min({grid.spacingMm.x, grid.spacingMm.y, grid.spacingMm.z});
    const double ball = ballMm = std::max(thickest / 10, 1.01 * least), thick = thickest / 5;
    PlainMarks core(dense.size()), kept(dense.size()), body(dense.size()), rest(dense.size());
    for (std::size_t i = 0; i < core.size(); ++i)
        core[i] = static_cast<double>(depths[i]) > ball * ball;
    plainParts(core, grid, [&](std::span<const std::size_t> voxels) {
        const bool isThick = std::any_of(voxels.begin(), voxels.end(), [&](std::size_t i) {
            return static_cast<double>(depths[i]) >= thick * thick;
        });
        for (const std::size_t voxel : voxels)
            kept[voxel] = isThick;
    });
    depths = plainDistances(kept, 1, grid);
    for (std::size_t i = 0; i < body.size(); ++i) {
        body[i] = dense[i] && static_cast<double>(depths[i]) <= ball * ball;
        rest[i] = dense[i] && !body[i];
    }
    const PlainMarks opened = body;
    plainParts(rest, grid, [&](std::span<const std::size_t> voxels) {
        glm::ivec3 low = grid.extent, high(0);
        bool touches = false;
        for (const std::size_t voxel : voxels) {
            low = glm::min(low, gridPosition(voxel, grid.extent));
            high = glm::max(high, gridPosition(voxel, grid.extent) + 1);
            beside(voxel, grid.extent, [&](std::size_t i, int) { touches = touches || opened[i]; });
        }
        if (touches && glm::length(glm::dvec3(high - low) * grid.spacingMm) < thickest)
            for (const std::size_t voxel : voxels)
                body[voxel] = 1;
    });
    return body;
}

PlainTable plainTable(const ChunkSource& source, int level) {
    const VolumeInfo& info = source.info();
    const BodyGrid grid(info, level, 1);
    std::array<PlainMarks, 4> above;
    above.fill(PlainMarks(grid.size()));
    std::vector<std::byte> chunk(source.chunkBytes());
    const std::array<double, 4> least = {-900, -600, kBodyHu, 300};
    const glm::ivec3 chunks = chunkGrid(info.extentVoxels, level);
    for (std::size_t n = 0; n < cellCount(chunks); ++n) {
        const glm::ivec3 at = gridPosition(n, chunks);
        source.readChunk({level, at.x, at.y, at.z}, chunk);
        for (std::size_t v = 0; v < cellCount(glm::ivec3(kChunkExtent)); ++v) {
            const glm::ivec3 place = at * kChunkExtent + gridPosition(v, glm::ivec3(kChunkExtent));
            if (glm::any(glm::greaterThanEqual(place, grid.extent)))
                continue;
            const double stored = storedValue(info.type, &chunk[v * bytesPerValue(info.type)]);
            const double hu = info.rescaleSlope * stored + info.rescaleIntercept;
            for (std::size_t set = 0; set < above.size(); ++set)
                above[set][linearIndex(place, grid.extent)] = hu > least[set];
        }
    }
    PlainTable found;
    found.why = hidePlain(above, grid, found.hidden);
    if (!found.why.empty())
        return {{}, 0, found.why};
    std::size_t count = 0;
    for (std::size_t i = 0; i < found.hidden.size(); ++i)
        count += found.hidden[i] && above[2][i];
    found.litres = static_cast<double>(count) * grid.spacingMm.x * grid.spacingMm.y * grid.spacingMm.z / 1e6;
    return found;
}

} // namespace tessera::test
