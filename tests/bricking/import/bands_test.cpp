// tests/bricking/import/bands_test.cpp: imports whose slabs have no room in memory: the store is byte for
// byte the one of a large budget, whatever the source can do, and the budget is kept.
#include "bricking/import/slab_feed.h"
#include "bricking/statistics/gathered_ranges.h"
#include "bricking/statistics/statistics.h"
#include "bricking/store/slab_file.h"
#include "bricking/store/store_writer.h"
#include "tests/support/bricking_store_tools.h"

#include <algorithm>
#include <cstring>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace tessera {
namespace {

using namespace test;
using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

const std::string kKey = "0123456789abcdef0123456789abcdef";

/// Gives rows as it is told, and sees to it that they are asked for as its interface says.
class RowSource final : public SlabSource {
  public:
    RowSource(const VolumeInfo& info, RowAccess access, int unit, std::size_t room = 0)
        : values_(info), access_(access), unit_(unit), room_(room) {}
    const VolumeInfo& info() const override { return values_.info(); }
    std::string describe() const override { return "a test volume"; }
    RowAccess rowAccess() const override { return access_; }
    int rowUnit() const override { return unit_; }
    std::size_t roomBytes() const override { return room_; }
    void readSlices(int count, std::span<std::byte> out) override {
        const std::size_t bytes = sliceBytesOf(info());
        for (int i = 0; i < count; ++i)
            copyRows(nextZ_++, 0, info().extentVoxels.y,
                     out.subspan(static_cast<std::size_t>(i) * bytes, bytes));
        slicesRead += count;
    }
    void readRows(int z, int first, int count, std::span<std::byte> out) override {
        const int height = info().extentVoxels.y;
        EXPECT_NE(access_, RowAccess::none);
        EXPECT_EQ(first % unit_, 0);
        EXPECT_TRUE(count % unit_ == 0 || first + count == height) << count;
        EXPECT_TRUE(first >= 0 && count > 0 && first + count <= height);
        if (access_ == RowAccess::inOrder) {
            EXPECT_EQ(std::tuple(z, first), std::tuple(nextZ_, nextRow_));
            nextRow_ = (first + count) % height;
            nextZ_ += nextRow_ == 0 ? 1 : 0;
        }
        copyRows(z, first, count, out);
        rowsRead += count;
    }
    std::int64_t rowsRead = 0, slicesRead = 0;

  private:
    void copyRows(int z, int first, int count, std::span<std::byte> out) const {
        ASSERT_EQ(out.size(), rowBytesOf(info()) * static_cast<std::size_t>(count));
        const std::size_t bytes = bytesPerValue(info().type);
        for (int y = first; y < first + count; ++y)
            for (int x = 0; x < info().extentVoxels.x; ++x) {
                const auto value = static_cast<std::uint32_t>(values_.valueAt(x, y, z));
                std::memcpy(out.data(), &value, bytes);
                out = out.subspan(bytes);
            }
    }
    HashSource values_;
    RowAccess access_;
    int unit_, nextZ_ = 0, nextRow_ = 0;
    std::size_t room_;
};

using Files = std::map<std::string, std::string>;
Files filesIn(const fs::path& folder) {
    Files files;
    for (const auto& entry : fs::recursive_directory_iterator(folder))
        if (entry.is_regular_file())
            files[entry.path().lexically_relative(folder)] = fileText(entry.path());
    return files;
}

struct Imported {
    Files files;
    std::size_t peak = 0;
};
Imported importedIn(std::size_t bytes, SlabSource& source, int threads, int partSlices) {
    const ScratchFolder scratch;
    MemoryBudget ram("RAM", "--ram", bytes);
    ImportOptions options;
    options.durable = false;
    options.threads = threads;
    options.partSlices = partSlices;
    importToStore(source, scratch / "v.zarr", ram, options);
    EXPECT_EQ(entriesIn(scratch.path()), 1u);
    return {filesIn(scratch / "v.zarr"), ram.peakBytes()};
}

/// Odd sizes, one row beyond a chunk, borders of bands, a single slice behind a slab.
TEST(ImportBands, GiveTheBytesOfWholeSlabs) {
    const std::vector<std::pair<glm::ivec3, ValueType>> volumes = {{{70, 321, 65}, ValueType::u16},
                                                                   {{97, 512, 33}, ValueType::u8},
                                                                   {{1, 700, 130}, ValueType::u16},
                                                                   {{65, 1025, 20}, ValueType::u8}};
    const std::vector<std::pair<RowAccess, int>> ways = {{RowAccess::any, 1},       {RowAccess::any, 48},
                                                         {RowAccess::any, 4096},    {RowAccess::inOrder, 1},
                                                         {RowAccess::inOrder, 500}, {RowAccess::none, 1}};
    int bands = 0;
    for (const auto& [extent, type] : volumes) {
        const VolumeInfo info = plainInfo(extent, type);
        RowSource plenty(info, RowAccess::none, 1);
        const Files expected = importedIn(kPlenty, plenty, 2, 512).files;
        for (std::size_t n = 0; n < ways.size(); ++n) {
            const auto& [access, unit] = ways[n];
            const int partSlices = n % 2 == 0 ? 512 : 64, threads = n % 3 == 0 ? 2 : 1;
            SCOPED_TRACE(testing::Message()
                         << extent.x << "x" << extent.y << "x" << extent.z << " " << static_cast<int>(access)
                         << " unit " << unit << " parts of " << partSlices);
            RowSource source(info, access, unit, 1000);
            const std::size_t floor = importFloorBytes(source, info, threads);
            for (const std::size_t bytes : {floor, floor + floor / 3}) {
                RowSource read(info, access, unit, 1000);
                const Imported found = importedIn(bytes, read, threads, partSlices);
                ASSERT_TRUE(found.files == expected);
                EXPECT_LE(found.peak, bytes);
                const std::int64_t rows = std::int64_t{extent.y} * extent.z;
                EXPECT_EQ(read.rowsRead + read.slicesRead * extent.y, rows) << "each is read once";
                bands += bytes < StoreWriter::floorBytes(info, threads) ? 1 : 0;
            }
        }
    }
    EXPECT_GE(bands, 20) << "few of these budgets are too small for slabs";
}

/// Ranges of boxes that bricks touch, in bands of any size, through a file and in memory.
TEST(ImportBands, RangesInAFileAreThoseInMemory) {
    const ScratchFolder scratch;
    std::mt19937 random(9);
    for (const int perBrick : {4, 1})
        for (const glm::ivec3& bricks : {glm::ivec3(2, 7, 5), {3, 1, 9}, {1, 12, 1}, {1, 1, 1}})
            for (const int rows : {1, 2, 5, 12}) {
                const glm::ivec3 grid = bricks * perBrick, most(bricks.x, rows, 2);
                MemoryBudget ram("RAM", "--ram", kPlenty);
                GatheredRanges held(grid, perBrick, ram);
                GatheredRanges filed(grid, perBrick, most, scratch.path(), ram);
                std::vector<float> least(cellCount(grid), INFINITY), greatest(cellCount(grid), -INFINITY);
                const auto add = [&](const RangeWindow& window, const glm::ivec3& box, float value) {
                    const std::size_t at = linearIndex(box - window.first, window.extent);
                    window.least[at] = std::min(window.least[at], value);
                    window.most[at] = std::max(window.most[at], value);
                };
                for (int z = 0; z < bricks.z; z += 2)
                    for (int y = 0; y < bricks.y; y += rows) {
                        const glm::ivec3 first(0, y, z),
                            end(bricks.x, std::min(y + rows, bricks.y), std::min(z + 2, bricks.z));
                        held.begin(first, end), filed.begin(first, end);
                        for (std::size_t n = 0; n < cellCount(end - first); ++n) {
                            const glm::ivec3 own = (first + gridPosition(n, end - first)) * perBrick;
                            const glm::ivec3 low = glm::max(own - 1, glm::ivec3(0));
                            const glm::ivec3 size = glm::min(own + perBrick + 1, grid) - low;
                            for (std::size_t i = 0; i < cellCount(size); ++i) {
                                const glm::ivec3 box = low + gridPosition(i, size);
                                const auto value = static_cast<float>(random() % 1000);
                                add(held.window(), box, value), add(filed.window(), box, value);
                                const std::size_t at = linearIndex(box, grid);
                                least[at] = std::min(least[at], value);
                                greatest[at] = std::max(greatest[at], value);
                            }
                        }
                        held.end(), filed.end();
                    }
                for (const GatheredRanges* each : {&held, &filed})
                    for (const auto side : {GatheredRanges::Side::least, GatheredRanges::Side::most}) {
                        std::vector<float> found(cellCount(grid));
                        const std::size_t slice = cellCount({grid.x, grid.y, 1});
                        for (int z = 0; z < grid.z; ++z)
                            each->read(side, z, 0,
                                       std::span(found).subspan(static_cast<std::size_t>(z) * slice, slice));
                        EXPECT_EQ(found, side == GatheredRanges::Side::least ? least : greatest)
                            << perBrick << " " << rows << " " << (each == &filed);
                    }
            }
}

TEST(ImportBands, StatisticsOfBandsAreThoseOfAll) {
    const ScratchFolder scratch;
    HashSource source(plainInfo({20, 100, 2600}, ValueType::u8), [](int x, int y, int z) {
        const auto h = mixed(static_cast<std::uint64_t>(x / 3 + 100 * (y / 5) + 10000 * (z / 4)));
        return h % 31 == 0 ? static_cast<double>(h >> 57) : 40;
    });
    import(scratch / "v.zarr", source);
    Files expected = filesIn(scratch / "v.zarr");
    std::erase_if(expected, [](const auto& file) { return !file.first.starts_with("stats/"); });
    const std::size_t floor = buildStatisticsFloorBytes(source.info(), 1);
    EXPECT_LT(floor, statisticsFloorBytes(source.info(), 1));
    MemoryBudget ram("RAM", "--ram", floor);
    {
        const StoreReader store(scratch / "v.zarr", ram);
        buildStatistics(store, scratch / "again", ram, 1);
    }
    EXPECT_LE(ram.peakBytes(), floor);
    EXPECT_EQ(ram.usedBytes(), 0u);
    EXPECT_TRUE(filesIn(scratch / "again") == expected);
}

TEST(ImportBands, StatisticsOfManySlicesNeedNoMore) {
    const auto least = [](int across, int slices) {
        return buildStatisticsFloorBytes(plainInfo({across, across, slices}, ValueType::u16), 4);
    };
    const std::size_t grown = least(16384, 1 << 20) - least(16384, 1024);
    EXPECT_LE(grown, std::size_t{1} << 20);
    EXPECT_LT(least(16384, 1 << 20), std::size_t{2} << 30);
    EXPECT_LT(least(2048, 1 << 20), std::size_t{64} << 20);
}

TEST(ImportBands, SourcesOfAnyRowsNeedTheLeast) {
    const VolumeInfo info = plainInfo({512, 2048, 64}, ValueType::u16);
    const RowSource any(info, RowAccess::any, 1), inOrder(info, RowAccess::inOrder, 1),
        slices(info, RowAccess::none, 1), room(info, RowAccess::none, 1, 123456);
    const auto least = [&](const SlabSource& source) { return leastImportBytes(source, info, 1); };
    EXPECT_LT(least(any), StoreWriter::floorBytes(info, 1) / 8);
    EXPECT_LE(least(any), least(inOrder));
    EXPECT_EQ(least(slices) + 123456, least(room));
    EXPECT_LT(least(slices), StoreWriter::floorBytes(info, 1) / 4);
    EXPECT_GE(least(slices), sliceBytesOf(info));
}

TEST(ImportBands, GoOnAfterABreak) {
    const VolumeInfo info = plainInfo({60, 400, 150}, ValueType::u16);
    for (const RowAccess access : {RowAccess::any, RowAccess::inOrder, RowAccess::none}) {
        const ScratchFolder scratch;
        RowSource whole(info, access, 1);
        const Files expected = importedIn(kPlenty, whole, 1, 64).files;
        const std::size_t floor = importFloorBytes(whole, info, 1);
        ASSERT_LT(floor, StoreWriter::floorBytes(info, 1));
        ImportOptions options;
        options.durable = false;
        options.threads = 1;
        options.partSlices = 64;
        options.key = kKey;
        options.reopen = [&] { return std::make_unique<RowSource>(info, access, 1); };
        /// Breaks off in the second part.
        class Broken final : public SlabSource {
          public:
            explicit Broken(SlabSource& source) : source_(source) {}
            const VolumeInfo& info() const override { return source_.info(); }
            std::string describe() const override { return source_.describe(); }
            RowAccess rowAccess() const override { return source_.rowAccess(); }
            void readSlices(int count, std::span<std::byte> out) override {
                see(slice_ += count);
                source_.readSlices(count, out);
            }
            void readRows(int z, int first, int count, std::span<std::byte> out) override {
                see(z + (first + count == info().extentVoxels.y ? 1 : 0));
                source_.readRows(z, first, count, out);
            }

          private:
            static void see(int slice) {
                if (slice > 100)
                    throw Error("test: the disk fails");
            }
            SlabSource& source_;
            int slice_ = 0;
        };
        RowSource good(info, access, 1);
        Broken broken(good);
        MemoryBudget ram("RAM", "--ram", floor), again("RAM", "--ram", floor);
        EXPECT_THROW(importToStore(broken, scratch / "v.zarr", ram, options), Error);
        RowSource next(info, access, 1);
        EXPECT_EQ(importToStore(next, scratch / "v.zarr", again, options).partsFound, 1);
        EXPECT_TRUE(filesIn(scratch / "v.zarr") == expected);
        EXPECT_EQ(entriesIn(scratch.path()), 1u);
    }
}

TEST(SlabFiles, GiveBackWhatWasWritten) {
    const ScratchFolder scratch;
    SlabFile file(scratch.path());
    const std::vector<std::byte> some(1000, std::byte{7}), others(10, std::byte{9});
    file.write(5000, some);
    file.write(5100, others);
    std::vector<std::byte> found(200);
    file.read(5050, found);
    EXPECT_EQ(std::ranges::count(found, std::byte{7}), 190);
    EXPECT_EQ(std::ranges::count(found, std::byte{9}), 10);
    EXPECT_EQ(found[50], std::byte{9});
    EXPECT_THROW(file.read(5999, found), Error);
    EXPECT_EQ(entriesIn(scratch.path()), 0u);
    EXPECT_THROW(SlabFile(scratch / "nowhere"), Error);
    requireDiskRoom(scratch.path(), 1, "a byte");
    EXPECT_THAT([&] { requireDiskRoom(scratch.path(), std::uint64_t{1} << 60, "a test"); },
                ThrowsMessage<Error>(AllOf(HasSubstr("a test"), HasSubstr("--ram"))));
}

} // namespace
} // namespace tessera
