// render/residency/transition.cpp: see transition.h.
#include "render/residency/transition.h"

#include "core/base/error.h"
#include "render/residency/pages.h" // chunkOf

#include <algorithm>
#include <unordered_map>
#include <unordered_set>

namespace tessera {
namespace {

constexpr int kMean = kLevelCount - 1;

} // namespace

std::vector<Move> movesTo(const Selection& resident, const Selection& wanted, std::span<const float> gain,
                          int coarse) {
    const std::size_t count = wanted.levels.size();
    TESSERA_CHECK(resident.levels.size() == count && gain.size() == count);
    std::vector<Move> moves, coarser, toCoarse, rest;
    std::unordered_map<ChunkKey, float, ChunkKeyHash> urgency; // of a chunk: the most that one brick gains
    for (std::size_t b = 0; b < count; ++b) {
        const std::uint8_t from = resident.levels[b], to = wanted.levels[b];
        if (from == to)
            continue;
        TESSERA_CHECK(from != Selection::kEmpty && to != Selection::kEmpty);
        const auto brick = static_cast<std::uint32_t>(b);
        if (to == kMean) {
            moves.push_back({brick, to});
        } else if (from < to) {
            coarser.push_back({brick, to});
        } else if (from == kMean && to < coarse && coarse < kMean) {
            toCoarse.push_back({brick, static_cast<std::uint8_t>(coarse)});
        } else {
            rest.push_back({brick, to});
            float& most = urgency[chunkOf(b, to, wanted.bricks)];
            most = std::max(most, gain[b]);
        }
    }
    const auto byChunk = [&](const Move& a, const Move& b) {
        return chunkOf(a.brick, a.level, wanted.bricks) < chunkOf(b.brick, b.level, wanted.bricks);
    };
    std::sort(coarser.begin(), coarser.end(), byChunk);
    std::sort(toCoarse.begin(), toCoarse.end(), byChunk);
    struct Ranked {
        float urgency;
        ChunkKey chunk;
        Move move;
    };
    std::vector<Ranked> ranked;
    ranked.reserve(rest.size());
    for (const Move& m : rest) {
        const ChunkKey chunk = chunkOf(m.brick, m.level, wanted.bricks);
        ranked.push_back({urgency.at(chunk), chunk, m});
    }
    std::sort(ranked.begin(), ranked.end(), [](const Ranked& a, const Ranked& b) {
        if (a.urgency != b.urgency)
            return a.urgency > b.urgency;
        return a.chunk != b.chunk ? a.chunk < b.chunk : a.move.brick < b.move.brick;
    });
    moves.insert(moves.end(), coarser.begin(), coarser.end());
    moves.insert(moves.end(), toCoarse.begin(), toCoarse.end());
    for (const Ranked& r : ranked)
        moves.push_back(r.move);
    return moves;
}

std::vector<ChunkKey> chunksOf(std::span<const Move> moves, const glm::ivec3& bricks, std::size_t most) {
    std::vector<ChunkKey> keys;
    std::unordered_set<ChunkKey, ChunkKeyHash> known;
    for (const Move& m : moves) {
        if (keys.size() >= most)
            break;
        if (m.level == kMean)
            continue;
        const ChunkKey key = chunkOf(m.brick, m.level, bricks);
        if (known.insert(key).second)
            keys.push_back(key);
    }
    return keys;
}

} // namespace tessera
