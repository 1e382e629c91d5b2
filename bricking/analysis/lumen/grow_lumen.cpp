// bricking/analysis/lumen/grow_lumen.cpp: see grow_lumen.h.
#include "bricking/analysis/lumen/grow_lumen.h"

#include "core/base/interrupt.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <deque>
#include <unordered_map>

namespace tessera {

// Chunks wait in a queue. The next one takes over the reached voxels on the faces of its six neighbours,
// floods itself, and queues neighbours at faces where it reached more. The cache's threads prefetch chunks at
// the queue's head.

namespace {

constexpr std::size_t kReadAhead = 24; // chunks
constexpr int kN = kChunkExtent;

const std::array<glm::ivec3, 6> kFaces = {
    {{-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 1}}};

/// The bits of a chunk's layer at face f, moved to their position in the neighbour across it, row by row.
/// @param use  (row of the neighbour, its bits)
template <typename Row, typename Use> void acrossFace(std::size_t face, const Row& row, const Use& use) {
    for (int a = 0; a < kN; ++a) {
        switch (face) {
        case 0: // the neighbour lies at lower x: our first column is its last one's neighbour
        case 1:
            for (int b = 0; b < kN; ++b)
                use(a + kN * b, face == 0 ? (row(a + kN * b) & 1u) << 31 : row(a + kN * b) >> 31);
            break;
        case 2:
            use((kN - 1) + kN * a, row(kN * a));
            break;
        case 3:
            use(kN * a, row((kN - 1) + kN * a));
            break;
        case 4:
            use(a + kN * (kN - 1), row(a));
            break;
        default:
            use(a, row(a + kN * (kN - 1)));
            break;
        }
    }
}

class Growing {
  public:
    Growing(BrickCache& cache, const VolumeInfo& info, const LumenRule& rule, MemoryBudget& ram,
            const GrowLimits& limits)
        : cache_(cache), info_(info), rule_(rule), limits_(limits),
          masks_(ram, "growing the lumen"), grown_{VoxelSet(info.extentVoxels, ram)},
          charge_(ram.charge(cellCount(grown_.voxels.chunks()) * sizeof(State), "growing the lumen")),
          states_(cellCount(grown_.voxels.chunks())) {}

    GrownLumen run(const glm::ivec3& seed, const std::function<void(std::uint64_t)>& soFar) {
        const std::size_t first = linearIndex(seed >> 5, grown_.voxels.chunks());
        seed_ = seed;
        queue_.push_back(first);
        states_[first].queued = true;
        for (std::uint64_t turn = 0; !queue_.empty() && !grown_.stopped; ++turn) {
            checkInterrupted();
            readAhead();
            const std::size_t chunk = queue_.front();
            queue_.pop_front();
            states_[chunk].queued = false;
            visit(chunk, chunk == first && turn == 0);
            if (soFar && turn % 64 == 0)
                soFar(grown_.count);
            const auto& like = limits_.like;
            grown_.stopped = grown_.count > limits_.mostVoxels ||
                             (like && grown_.unlike > like->mostUnlike && 2 * grown_.unlike > grown_.count);
        }
        ahead_.clear();
        for (const std::size_t chunk : grown_.voxels.filledChunks())
            grown_.voxels.settle(chunk);
        return std::move(grown_);
    }

  private:
    static constexpr std::uint32_t kNoMask = ~0u, kUnread = ~0u - 1, kFinished = ~0u - 2;
    struct State {
        std::uint32_t mask = kUnread;   // slot of voxels that pass the rule; finished: all are reached
        std::uint32_t unlike = kNoMask; // slot of voxels unlike the seed, if requested
        bool queued = false;
    };

    void readAhead() {
        const std::size_t most = std::min(kReadAhead, cache_.pinnableChunks() / 2);
        for (std::size_t i = 0; i < std::min(queue_.size(), most); ++i) {
            const std::size_t chunk = queue_[i];
            if (states_[chunk].mask != kUnread || ahead_.contains(chunk))
                continue;
            if (ahead_.size() >= most)
                return;
            const glm::ivec3 at = gridPosition(chunk, grown_.voxels.chunks());
            const ChunkKey key{0, at.x, at.y, at.z};
            ahead_.emplace(chunk, cache_.request({&key, 1}).front());
        }
    }

    /// Reads a chunk for the first time.
    void read(std::size_t chunk) {
        const glm::ivec3 at = gridPosition(chunk, grown_.voxels.chunks());
        ChunkPointer values;
        if (const auto found = ahead_.find(chunk); found != ahead_.end()) {
            values = found->second.get();
            ahead_.erase(found);
        } else
            values = cache_.get({0, at.x, at.y, at.z});
        State& state = states_[chunk];
        state.mask = masks_.take();
        chunkBits(*values, info_, at, rule_, masks_.at(state.mask));
        if (limits_.like) {
            state.unlike = masks_.take();
            ChunkRows& unlike = masks_.at(state.unlike);
            chunkBits(*values, info_, at, limits_.like->rule, unlike);
            const ChunkRows& mask = masks_.at(state.mask);
            for (std::size_t row = 0; row < unlike.size(); ++row)
                unlike[row] = mask[row] & ~unlike[row];
        }
    }

    void visit(std::size_t chunk, bool withSeed) {
        State& state = states_[chunk];
        if (state.mask == kFinished)
            return;
        if (state.mask == kUnread)
            read(chunk);
        const ChunkRows& mask = masks_.at(state.mask);
        VoxelSet& voxels = grown_.voxels;
        ChunkRows reached, before;
        for (int row = 0; row < kRowsPerChunk; ++row)
            reached[static_cast<std::size_t>(row)] = voxels.row(chunk, row);
        before = reached;
        const glm::ivec3 at = gridPosition(chunk, voxels.chunks());
        const auto neighbour = [&](std::size_t face, std::size_t& index) {
            const glm::ivec3 place = at + kFaces[face];
            for (int axis = 0; axis < 3; ++axis)
                if (place[axis] < 0 || place[axis] >= voxels.chunks()[axis])
                    return false;
            index = linearIndex(place, voxels.chunks());
            return true;
        };
        std::uint32_t any = 0;
        for (std::size_t face = 0; face < 6; ++face) {
            std::size_t from = 0;
            if (!neighbour(face, from) || voxels.kind(from) == VoxelSet::Kind::none)
                continue;
            acrossFace(
                face ^ 1u, [&](int row) { return voxels.row(from, row); },
                [&](int row, std::uint32_t bits) {
                    const auto r = static_cast<std::size_t>(row);
                    const std::uint32_t more = bits & mask[r] & ~reached[r];
                    reached[r] |= more;
                    any |= more;
                });
        }
        if (withSeed) {
            const glm::ivec3 local = seed_ & 31;
            reached[static_cast<std::size_t>(local.y + kN * local.z)] |= 1u << local.x;
            any = 1;
        }
        if (!any)
            return;
        floodRows(mask.data(), reached.data(), kN);
        take(chunk, reached, before);
        for (std::size_t face = 0; face < 6; ++face) {
            std::size_t to = 0;
            if (!neighbour(face, to) || states_[to].queued || states_[to].mask == kFinished)
                continue;
            std::uint32_t fresh = 0;
            acrossFace(
                face,
                [&](int row) {
                    return reached[static_cast<std::size_t>(row)] & ~before[static_cast<std::size_t>(row)];
                },
                [&](int row, std::uint32_t bits) { fresh |= bits & ~voxels.row(to, row); });
            if (fresh) {
                queue_.push_back(to);
                states_[to].queued = true;
            }
        }
    }

    /// Stores and counts the reached voxels of a chunk, and frees its rule voxels once all are reached.
    void take(std::size_t chunk, const ChunkRows& reached, const ChunkRows& before) {
        State& state = states_[chunk];
        const ChunkRows& mask = masks_.at(state.mask);
        std::uint64_t more = 0, unlike = 0;
        std::uint32_t left = 0;
        for (std::size_t row = 0; row < reached.size(); ++row) {
            const std::uint32_t fresh = reached[row] & ~before[row];
            more += static_cast<std::uint64_t>(std::popcount(fresh));
            if (state.unlike != kNoMask)
                unlike += static_cast<std::uint64_t>(std::popcount(fresh & masks_.at(state.unlike)[row]));
            left |= mask[row] & ~reached[row];
        }
        grown_.count += more;
        grown_.unlike += unlike;
        grown_.voxels.setChunk(chunk, reached);
        if (left)
            return;
        masks_.giveBack(state.mask);
        state.mask = kFinished;
        if (state.unlike != kNoMask)
            masks_.giveBack(state.unlike);
        state.unlike = kNoMask;
    }

    BrickCache& cache_;
    const VolumeInfo& info_;
    const LumenRule rule_;
    const GrowLimits limits_;
    RowsPool masks_;
    GrownLumen grown_;
    Charge charge_;
    std::vector<State> states_;
    std::deque<std::size_t> queue_;
    std::unordered_map<std::size_t, ChunkFuture> ahead_;
    glm::ivec3 seed_{0};
};

} // namespace

GrownLumen growLumen(BrickCache& cache, const VolumeInfo& info, const LumenRule& rule, const glm::ivec3& seed,
                     MemoryBudget& ram, const GrowLimits& limits,
                     const std::function<void(std::uint64_t)>& soFar) {
    return Growing(cache, info, rule, ram, limits).run(seed, soFar);
}

namespace {

constexpr double kStep = 1 / 20.0,
                 kFinestStep = 1 / 160.0; // of the way from the lumen's value to the threshold
constexpr double kLike = 1 / 8.0;         // the same
constexpr double kNoisesInside =
    3;                           // at this distance from the lumen's value nearly all of the lumen is inside
constexpr double kNoisesOff = 1; // distance of a threshold to a leak
constexpr double kExplosion = 1.5;
constexpr double kFewMm3 = 5000; // smaller regions may grow freely: a trachea around the seed

} // namespace

GuardedLumen growWithoutLeaks(BrickCache& cache, const VolumeInfo& info, const SeedNeighbourhood& around,
                              const glm::ivec3& seed, bool always, MemoryBudget& ram,
                              const std::function<void(std::uint64_t)>& soFar) {
    const auto ruleAt = [&](double share) {
        LumenRule rule = around.rule;
        rule.threshold = around.lumen + share * (around.rule.threshold - around.lumen);
        return rule;
    };
    const glm::dvec3 mm = info.spacingMm();
    const auto few = static_cast<std::uint64_t>(kFewMm3 / (mm.x * mm.y * mm.z)) + 1000;
    const double way = std::abs(around.rule.threshold - around.lumen);
    const double inside = way > 0 ? std::clamp(kNoisesInside * around.noise / way, kStep, 1.0) : 1;
    if (!always) {
        GrowLimits limits;
        limits.like = LikeSeed{ruleAt(std::max(kLike, inside)), 0};
        limits.like->mostUnlike = 4 * few;
        GrownLumen grown = growLumen(cache, info, around.rule, seed, ram, limits, soFar);
        if (!grown.stopped && 2 * grown.unlike <= grown.count)
            return {std::move(grown), around.rule, false};
    }
    // starts where most of the lumen around the seed is inside
    double share = inside;
    GrownLumen best = growLumen(cache, info, ruleAt(share), seed, ram, {}, soFar);
    bool leaked = false;
    for (double step = kStep; share < 1 && step >= kFinestStep;) {
        checkInterrupted();
        const double next = std::min(1.0, share + step);
        GrowLimits limits;
        limits.mostVoxels =
            std::max(few, static_cast<std::uint64_t>(kExplosion * static_cast<double>(best.count)));
        GrownLumen grown = growLumen(cache, info, ruleAt(next), seed, ram, limits, soFar);
        if (grown.stopped) {
            leaked = true;
            step /= 2;
            continue;
        }
        share = next;
        best = std::move(grown);
    }
    // before noise opens a path through the wall, single voxels are open
    if (const double back = kNoisesOff * around.noise / way; leaked && back > kFinestStep) {
        share = std::max(inside, share - back);
        best = growLumen(cache, info, ruleAt(share), seed, ram, {}, soFar);
    }
    return {std::move(best), ruleAt(share), leaked};
}

} // namespace tessera
