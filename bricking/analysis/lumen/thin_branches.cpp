// bricking/analysis/lumen/thin_branches.cpp: see thin_branches.h.
#include "bricking/analysis/lumen/thin_branches.h"

#include "core/base/interrupt.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <queue>
#include <unordered_map>
#include <utility>
#include <vector>

namespace tessera {
namespace {

constexpr double kMostBranchMm3 = 1000; // with attached voxels; more is a lung
constexpr std::size_t kMostBranchVoxels = 30000;
constexpr double kLeastBranchMm3 = 8; // and at least ...
constexpr std::size_t kLeastBranchVoxels = 6;
constexpr double kMostWayMm = 6; // from the lumen to a branch
constexpr double kWallNoises =
    3; // least contrast of a branch's wall, in deviations of the remaining noise ...
constexpr double kRounding = 1e-12; // tolerance of converting a value to a depth and back
constexpr double kMostStands = 4;   // times that, of a voxel
constexpr double kWallShare =
    0.25; // ... and relative to the difference of the lumen's value and the threshold

const std::array<glm::ivec3, 6> kSixSteps = {
    {{-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 1}}};

/// rim and piece: during a fill. passed: no branch behind it yet.
enum class Visit : std::uint8_t { none, lumen, waits, passed, piece, rim, leak, dam };

class Flood {
  public:
    Flood(LumenValues& values, GrownLumen& lumen, const LumenRule& rule, double wall, double to,
          MemoryBudget& ram)
        : values_(values), lumen_(lumen), rule_(rule), ram_(ram), n_(values.info().extentVoxels),
          mm_(values.info().spacingMm()), end_(std::abs(to - rule.threshold) + kRounding * std::abs(to)),
          wall_(wall) {
        const double voxel = mm_.x * mm_.y * mm_.z;
        most_ = std::min(kMostBranchVoxels, static_cast<std::size_t>(kMostBranchMm3 / voxel) + 1);
        least_ = std::max(kLeastBranchVoxels, static_cast<std::size_t>(kLeastBranchMm3 / voxel));
    }

    ThinBranches run() {
        addShell();
        double level = 0;
        for (std::uint64_t turn = 0; !queue_.empty(); ++turn) {
            if (turn % 4096 == 0)
                checkInterrupted();
            const auto [height, index] = queue_.top();
            queue_.pop();
            const glm::ivec3 at = gridPosition(index, n_);
            if (visitOf(state(at)) != Visit::waits)
                continue;
            level = std::max(level, height);
            pass(at, level);
        }
        for (const std::size_t chunk : lumen_.voxels.filledChunks())
            lumen_.voxels.settle(chunk);
        lumen_.count += found_.voxels;
        if (found_.branches > 0)
            found_.to = rule_.threshold + (rule_.below ? widest_ : -widest_);
        return found_;
    }

  private:
    struct Cell {
        Charge charge;
        std::array<std::uint8_t, std::size_t{kRowsPerChunk} * kChunkExtent>
            state; // Visit + 8 * step from where
    };
    static Visit visitOf(std::uint8_t state) { return static_cast<Visit>(state & 7u); }
    static std::uint8_t stateOf(Visit visit, std::size_t step) {
        return static_cast<std::uint8_t>(static_cast<std::uint8_t>(visit) | (step << 3));
    }

    /// A voxel's state; by the lumen if it was not visited.
    std::uint8_t& state(const glm::ivec3& v) {
        const std::size_t chunk = linearIndex({v.x >> 5, v.y >> 5, v.z >> 5}, lumen_.voxels.chunks());
        if (chunk != lastChunk_ || !last_) {
            std::unique_ptr<Cell>& cell = cells_[chunk];
            if (!cell) {
                Charge charge = ram_.charge(sizeof(Cell), "thin branches");
                cell = std::make_unique<Cell>();
                cell->charge = std::move(charge);
                for (int row = 0; row < kRowsPerChunk; ++row) {
                    const std::uint32_t bits = lumen_.voxels.row(chunk, row);
                    for (int x = 0; x < kChunkExtent; ++x)
                        cell->state[static_cast<std::size_t>(x + kChunkExtent * row)] =
                            static_cast<std::uint8_t>(bits >> x & 1u ? Visit::lumen : Visit::none);
                }
            }
            lastChunk_ = chunk;
            last_ = cell.get();
        }
        return last_->state[static_cast<std::size_t>((v.x & 31) + 32 * ((v.y & 31) + 32 * (v.z & 31)))];
    }
    bool inVolume(const glm::ivec3& v) const {
        return v.x >= 0 && v.y >= 0 && v.z >= 0 && v.x < n_.x && v.y < n_.y && v.z < n_.z;
    }
    /// Distance beyond the threshold.
    double height(const glm::ivec3& v) { return -rule_.depth(values_.voxel(v)); }

    void wait(const glm::ivec3& v, double height, std::size_t step) {
        state(v) = stateOf(Visit::waits, step);
        if (queue_.size() == room_) {
            charges_.push_back(ram_.charge(kRoom * 2 * sizeof(Waiting), "thin branches"));
            room_ += kRoom;
        }
        queue_.emplace(height, linearIndex(v, n_));
    }

    /// Voxels that border the lumen are queued.
    void addShell() {
        for (const std::size_t chunk : lumen_.voxels.filledChunks()) {
            const glm::ivec3 corner = kChunkExtent * gridPosition(chunk, lumen_.voxels.chunks());
            for (int row = 0; row < kRowsPerChunk; ++row) {
                const std::uint32_t bits = lumen_.voxels.row(chunk, row);
                for (int x = 0; x < kChunkExtent && bits >> x; ++x)
                    if (bits >> x & 1u)
                        for (std::size_t step = 0; step < 6; ++step)
                            if (const glm::ivec3 v = corner +
                                                     glm::ivec3(x, row % kChunkExtent, row / kChunkExtent) +
                                                     kSixSteps[step];
                                inVolume(v) && !lumen_.voxels.contains(v) && visitOf(state(v)) == Visit::none)
                                if (const double h = height(v); h <= end_)
                                    wait(v, h, step);
            }
        }
    }

    /// Handles the next voxel of the flood and the region behind it.
    void pass(const glm::ivec3& at, double level) {
        const bool leak = fill(at, level);
        const bool branch = piece_.size() >= least_;
        if (leak || (branch && standsOut(level) < wall_)) {
            ++found_.leaks;
            letGo();
            return;
        }
        for (const glm::ivec3& v : piece_)
            mark(v, Visit::passed);
        for (const auto& [v, height] : rim_) {
            const std::size_t step = state(v) >> 3;
            if (height <= end_)
                wait(v, height, step);
            else
                mark(v, Visit::none);
        }
        if (!branch || !isNear(at))
            return;
        addWay(at);
        for (const glm::ivec3& v : piece_)
            add(v);
        widest_ = level;
        ++found_.branches;
    }

    /// Fills the region behind a voxel up to a level.
    /// @return true if it is too large, or reaches an earlier leak
    bool fill(const glm::ivec3& at, double level) {
        piece_.assign(1, at);
        rim_.clear();
        mark(at, Visit::piece);
        for (std::size_t i = 0; i < piece_.size(); ++i)
            for (std::size_t step = 0; step < 6; ++step) {
                const glm::ivec3 v = piece_[i] + kSixSteps[step];
                if (!inVolume(v))
                    continue;
                std::uint8_t& there = state(v);
                if (visitOf(there) == Visit::leak)
                    return true;
                if (visitOf(there) != Visit::none)
                    continue;
                if (const double h = height(v); h > level) {
                    there = stateOf(Visit::rim, step);
                    rim_.emplace_back(v, h);
                } else {
                    there = stateOf(Visit::piece, step);
                    piece_.push_back(v);
                }
                if (piece_.size() > most_)
                    return true;
            }
        return false;
    }

    /// Mean distance of the piece's border beyond the level; bone counts no more than a wall.
    double standsOut(double level) const {
        double sum = 0;
        for (const auto& [v, height] : rim_)
            sum += std::min(height - level, kMostStands * wall_);
        return rim_.empty() ? 0 : sum / static_cast<double>(rim_.size());
    }

    /// The filled region is a leak; the flood does not pass its first voxel.
    void letGo() {
        for (const auto& [v, height] : rim_)
            mark(v, Visit::none);
        for (const glm::ivec3& v : piece_)
            mark(v, Visit::leak);
        mark(piece_.front(), Visit::dam);
    }

    void mark(const glm::ivec3& v, Visit visit) {
        std::uint8_t& s = state(v);
        s = stateOf(visit, s >> 3);
    }

    bool isNear(const glm::ivec3& to) {
        double length = 0;
        for (glm::ivec3 v = to; length <= kMostWayMm && visitOf(state(v)) != Visit::lumen;) {
            const glm::ivec3& step = kSixSteps[state(v) >> 3];
            length += glm::length(glm::dvec3(step) * mm_);
            v -= step;
        }
        return length <= kMostWayMm;
    }
    /// The path from a voxel back to the lumen.
    void addWay(const glm::ivec3& to) {
        for (glm::ivec3 v = to; visitOf(state(v)) != Visit::lumen;) {
            const std::size_t step = state(v) >> 3;
            add(v);
            v -= kSixSteps[step];
        }
    }
    void add(const glm::ivec3& v) {
        std::uint8_t& s = state(v);
        if (visitOf(s) == Visit::lumen)
            return;
        s = stateOf(Visit::lumen, 0);
        const std::size_t chunk = linearIndex({v.x >> 5, v.y >> 5, v.z >> 5}, lumen_.voxels.chunks());
        lumen_.voxels.edit(chunk)[static_cast<std::size_t>((v.y & 31) + 32 * (v.z & 31))] |= 1u << (v.x & 31);
        ++found_.voxels;
    }

    using Waiting = std::pair<double, std::size_t>;
    static constexpr std::size_t kRoom = 65536;
    LumenValues& values_;
    GrownLumen& lumen_;
    const LumenRule rule_;
    MemoryBudget& ram_;
    const glm::ivec3 n_;
    const glm::dvec3 mm_;
    double end_, wall_, widest_ = 0;
    std::size_t most_ = 0, least_ = 0, room_ = 0, lastChunk_ = 0;
    Cell* last_ = nullptr;
    std::unordered_map<std::size_t, std::unique_ptr<Cell>> cells_;
    std::vector<Charge> charges_;
    std::priority_queue<Waiting, std::vector<Waiting>, std::greater<>> queue_;
    std::vector<glm::ivec3> piece_;                  // the region behind a voxel, that voxel first
    std::vector<std::pair<glm::ivec3, double>> rim_; // its border, and the distances beyond the threshold
    ThinBranches found_;
};

} // namespace

ThinBranches addThinBranches(LumenValues& values, GrownLumen& lumen, const LumenRule& rule, double wall,
                             double to, MemoryBudget& ram) {
    return Flood(values, lumen, rule, wall, to, ram).run();
}

double branchWall(const SeedNeighbourhood& around, const LumenRule& rule) {
    return std::max(kWallNoises * around.noise, kWallShare * std::abs(rule.threshold - around.lumen));
}

} // namespace tessera
