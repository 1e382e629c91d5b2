// tests/render/backends/host_plane_test.cpp: bricks in host memory against their volume, sample by sample:
// own samples, ghost layers, and the cells that need no other brick, whatever was there before.
#include "render/backends/native/host_plane.h"

#include "render/residency/brick_residency.h"
#include "tests/support/numbered_chunks.h"

#include <glm/common.hpp>
#include <gtest/gtest.h>
#include <random>

namespace tessera::test {
namespace {

constexpr glm::ivec3 kPlaneExtent(97, 70, 40); // 4 x 3 x 2 bricks; the last along x has one voxel

Selection bricksOf(const std::vector<std::uint8_t>& levels) {
    Selection s;
    s.bricks = brickGrid(kPlaneExtent);
    s.levels = levels;
    for (std::size_t b = 0; b < levels.size(); ++b) {
        ++s.counts[levels[b]];
        s.means.push_back(-7 - static_cast<float>(b)); // no sample has them
    }
    return s;
}
std::uint32_t threeBytes(const glm::ivec3& cell) {
    return static_cast<std::uint32_t>((cell.x + 8) | (cell.y + 8) << 8 | (cell.z + 8) << 16);
}

class HostPlanes : public testing::Test {
  protected:
    TextureLimits limitsOf(int pageEdge) const {
        TextureLimits limits;
        limits.pageEdge = pageEdge;
        limits.indexEntryBytes = 40;
        return limits;
    }
    /// Of one level, or of level 0 and empty bricks.
    void check(const HostPlane& plane, const Selection& selection, int level, bool ghosted) const {
        const glm::ivec3 extent = levelExtent(kPlaneExtent, level);
        const int edge = kBrickExtent >> level;
        const auto value = [&](const glm::ivec3& at) { // of the volume, its outermost samples repeated
            const glm::ivec3 i = glm::clamp(at, glm::ivec3(0), extent - 1);
            const std::size_t b = linearIndex(i / edge, selection.bricks);
            return selection.levels[b] == Selection::kEmpty ? selection.means[b]
                                                            : NumberedChunks::valueOf(level, i);
        };
        for (std::size_t b = 0; b < selection.levels.size(); ++b) {
            const native::PacketBrick& brick = plane.bricks()[b];
            if (selection.levels[b] == Selection::kEmpty) {
                EXPECT_EQ(brick.low >> 24, native::PacketBrick::kValue);
                EXPECT_EQ(brick.mean, selection.means[b]);
                continue;
            }
            const glm::ivec3 first = gridPosition(b, selection.bricks) * edge;
            const glm::ivec3 own = glm::min(glm::ivec3(edge), extent - first);
            ASSERT_EQ(brick.low >> 24, static_cast<std::uint32_t>(level)) << b;
            const glm::ivec3 low(ghosted ? -kGhostBefore : 0), behind(ghosted ? kGhostBehind : 0),
                end = (ghosted ? glm::ivec3(edge) : own) + behind;
            if (glm::all(glm::greaterThan(end - 1, low))) {
                EXPECT_EQ(brick.low & 0xffffffu, threeBytes(low)) << b;
                EXPECT_EQ(brick.high, threeBytes(end - 1)) << b;
                EXPECT_EQ(brick.low == HostPlane::kLowWithGhost, ghosted);
            } else { // no cell has both its ends there
                for (int axis = 0; axis < 3; ++axis)
                    EXPECT_GE(brick.low >> (8 * axis) & 255u, brick.high >> (8 * axis) & 255u) << b;
            }
            const auto* const samples = static_cast<const float*>(plane.samplesOf(brick));
            for (int z = low.z; z < end.z; ++z)
                for (int y = low.y; y < end.y; ++y)
                    for (int x = low.x; x < end.x; ++x) {
                        const glm::ivec3 at = first + glm::ivec3(x, y, z);
                        ASSERT_EQ(samples[z * plane.slicePitch(level) + y * plane.rowPitch(level) + x],
                                  value(at))
                            << "brick " << b << ": " << x << "," << y << "," << z;
                        if (glm::all(glm::greaterThanEqual(glm::ivec3(x, y, z), glm::ivec3(0))) &&
                            glm::all(glm::lessThan(glm::ivec3(x, y, z), own))) {
                            ASSERT_EQ(plane.sampleAt(brick, level, at), value(at));
                        }
                    }
        }
    }
    NumberedChunks source{kPlaneExtent};
    MemoryBudget ram{"RAM", "--ram", std::size_t{64} << 20};
    BrickCache cache{source, ram, std::size_t{8} << 20, 2};
};

TEST_F(HostPlanes, HoldEverySampleOfALevel) {
    for (int level = 0; level + 1 < kLevelCount; ++level)
        for (const int pageEdge : {kBrickExtent, kGhostedEdge}) {
            SCOPED_TRACE(std::to_string(level) + ", pages of " + std::to_string(pageEdge));
            const Selection all = bricksOf(std::vector<std::uint8_t>(24, static_cast<std::uint8_t>(level)));
            const std::size_t pages = pagesFor(all.counts), before = ram.usedBytes();
            HostPlane plane(source.info(), pages, limitsOf(pageEdge), 2, ram);
            const std::size_t page = static_cast<std::size_t>(pageEdge) * static_cast<std::size_t>(pageEdge) *
                                     static_cast<std::size_t>(pageEdge) * sizeof(float);
            EXPECT_EQ(plane.bytes(),
                      cellCount(atlasPages(pages, ValueType::f32, limitsOf(pageEdge))) * page + 24 * 40);
            EXPECT_EQ(ram.usedBytes() - before, plane.bytes());
            EXPECT_EQ(plane.grid(), glm::ivec3(4, 3, 2));
            BrickResidency bricks(source.info(), all, pages, limitsOf(pageEdge), {&plane}, ram);
            Work work;
            bricks.load(cache, work);
            const auto edge = static_cast<std::uint64_t>(kBrickExtent >> level);
            EXPECT_EQ(work.bytesUploaded, 24 * edge * edge * edge * sizeof(float));
            plane.settle(nullptr, level);
            check(plane, all, level, level == 0 && pageEdge == kGhostedEdge);
        }
}

// Empty bricks come and go beside bricks that stay: ghost layers follow.
TEST_F(HostPlanes, GhostLayersFollowTheirNeighbours) {
    std::mt19937 random(12);
    for (const int threads : {1, 3}) {
        std::vector<std::uint8_t> levels(24, 0);
        Selection now = bricksOf(levels);
        HostPlane plane(source.info(), 24, limitsOf(kGhostedEdge), threads, ram);
        BrickResidency bricks(source.info(), now, 24, limitsOf(kGhostedEdge), {&plane}, ram);
        Work work;
        for (int turn = 0; turn < 12; ++turn) {
            bricks.load(cache, work);
            plane.settle(nullptr, 0);
            check(plane, now, 0, true);
            if (HasFatalFailure())
                return;
            for (int change = 0; change < 1 + turn % 3; ++change) {
                std::uint8_t& level = levels[random() % 24];
                level = level == 0 ? Selection::kEmpty : 0;
            }
            now = bricksOf(levels);
            bricks.adopt(now);
        }
    }
}

/// x + 3y + 5z in any type.
template <typename T> class Slanted : public ChunkSource {
  public:
    explicit Slanted(ValueType type) {
        info_.extentVoxels = kPlaneExtent;
        info_.type = type;
    }
    const VolumeInfo& info() const override { return info_; }
    static T valueOf(const glm::ivec3& at) { return static_cast<T>(at.x + 3 * at.y + 5 * at.z); }
    void readChunk(const ChunkKey& key, std::span<std::byte> out) const override {
        for (std::size_t n = 0; n < out.size() / sizeof(T); ++n) {
            const T value = valueOf(glm::ivec3(key.i, key.j, key.k) * kChunkExtent +
                                    gridPosition(n, glm::ivec3(kChunkExtent)));
            std::memcpy(out.data() + n * sizeof(T), &value, sizeof value);
        }
    }

  private:
    VolumeInfo info_;
};

/// Whether the brick beside an empty one of a value gets a ghost layer: where its samples can be that value.
template <typename T> bool isGhostedBeside(ValueType type, float mean, float* found) {
    const Slanted<T> source(type);
    MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
    BrickCache cache(source, ram, std::size_t{8} << 20, 1);
    std::vector<std::uint8_t> levels(24, 0);
    levels[0] = Selection::kEmpty;
    Selection now = bricksOf(levels);
    now.means[0] = mean;
    TextureLimits limits;
    limits.pageEdge = kGhostedEdge;
    HostPlane plane(source.info(), 24, limits, 1, ram);
    BrickResidency bricks(source.info(), now, 24, limits, {&plane}, ram);
    Work work;
    bricks.load(cache, work);
    plane.settle(nullptr, 0);
    const native::PacketBrick& beside = plane.bricks()[1];
    for (const glm::ivec3& at : {glm::ivec3(32, 0, 0), glm::ivec3(63, 31, 31), glm::ivec3(40, 3, 21)})
        EXPECT_EQ(plane.sampleAt(beside, 0, at), static_cast<float>(Slanted<T>::valueOf(at)));
    EXPECT_EQ(plane.bricks()[3].low, HostPlane::kLowWithGhost) << "it has no empty neighbour";
    if (beside.low != HostPlane::kLowWithGhost)
        return false;
    const std::uint32_t left = beside.base - 1; // voxel 31 of the empty brick
    *found = plane.kind() == native::SampleKind::f32 ? static_cast<const float*>(plane.samples())[left]
             : plane.kind() == native::SampleKind::i16
                 ? static_cast<const std::int16_t*>(plane.samples())[left]
                 : static_cast<const std::uint16_t*>(plane.samples())[left];
    return true;
}

TEST(HostPlaneTypes, GhostLayersHoldValuesThatTheTypeHas) {
    struct Row {
        float mean;
        bool i16, u16, f32;
    };
    for (const Row& row :
         {Row{3, true, true, true}, Row{3.5f, false, false, true}, Row{-1, true, false, true},
          Row{32767, true, true, true}, Row{32768, false, true, true}, Row{65535, false, true, true},
          Row{65536, false, false, true}, Row{-32768, true, false, true}, Row{-32769, false, false, true},
          Row{0, true, true, true}}) {
        SCOPED_TRACE(row.mean);
        float found = 1e9f;
        EXPECT_EQ(isGhostedBeside<std::int16_t>(ValueType::i16, row.mean, &found), row.i16);
        EXPECT_EQ(found, row.i16 ? row.mean : 1e9f);
        found = 1e9f;
        EXPECT_EQ(isGhostedBeside<std::uint16_t>(ValueType::u16, row.mean, &found), row.u16);
        EXPECT_EQ(found, row.u16 ? row.mean : 1e9f);
        found = 1e9f; // bytes are held in 16 bits
        EXPECT_EQ(isGhostedBeside<std::uint8_t>(ValueType::u8, row.mean, &found), row.u16);
        EXPECT_EQ(isGhostedBeside<float>(ValueType::f32, row.mean, &found), row.f32);
        EXPECT_EQ(found, row.mean);
    }
}

} // namespace
} // namespace tessera::test
