// tests/bricking/import/files/hdf5_damage_test.cpp: HDF5 files that are cut, damaged, or lie: a clear refusal
// or voxels of what is whole, whether checksums tell of it or not.
#include "bricking/import/files/hdf5/h5_bytes.h"
#include "tests/support/hdf5_corpus.h"

#include <cstring>
#include <fstream>
#include <functional>
#include <gmock/gmock.h>
#include <iterator>
#include <random>
#include <string>
#include <utility>

namespace tessera::test {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

std::string contentOf(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

/// Opens and reads all volumes that are small. False: refused.
bool isRead(const fs::path& path) {
    constexpr std::uint64_t kMostVoxels = 1 << 16;
    try {
        for (Hdf5Volume& volume : openHdf5Volumes(path))
            if (volume.source->info().voxelCount() <= kMostVoxels)
                static_cast<void>(valuesOf(*volume.source));
        return true;
    } catch (const InputError& refusal) {
        EXPECT_THAT(refusal.what(), HasSubstr(path.filename().string()));
        return false;
    }
}

TEST(DamagedHdf5, CutAnywhereItIsRefused) {
    const ScratchFolder folder;
    for (const bool areRefused : {false, true})
        for (const fs::path& path : hdf5Files(areRefused)) {
            const std::string whole = contentOf(path);
            for (std::size_t bytes = 0; bytes < whole.size(); bytes += 64) {
                writeFile(folder / path.filename(), whole.substr(0, bytes));
                EXPECT_FALSE(isRead(folder / path.filename())) << path << " cut at " << bytes;
            }
        }
}

// Where checksums are not compared, what lies behind them is met as a hostile file would have it.
TEST(DamagedHdf5, AnyBytesAreRefusedOrRead) {
    const ScratchFolder folder;
    std::mt19937 random(7);
    const auto pick = [&](std::size_t below) {
        return std::uniform_int_distribution<std::size_t>(0, below - 1)(random);
    };
    for (const bool count : {true, false}) {
        h5ChecksumsCount = count;
        int read = 0, refused = 0;
        for (const fs::path& path : hdf5Files(false)) {
            const std::string whole = contentOf(path);
            for (int n = 0; n < 100; ++n) {
                std::string damaged = whole;
                for (std::size_t changes = 1 + pick(3); changes > 0; --changes) {
                    const std::size_t at = pick(damaged.size());
                    if (pick(3) == 0)
                        damaged.replace(at, 8, 8, "\xff\0\x7f\1"[pick(4)]); // numbers at their ends
                    else
                        damaged[at] = static_cast<char>(pick(256));
                }
                writeFile(folder / path.filename(), damaged);
                ++(isRead(folder / path.filename()) ? read : refused);
            }
        }
        EXPECT_GT(read, 100);
        EXPECT_GT(refused, 100);
    }
    h5ChecksumsCount = true;
}

void replaceAt(std::string& bytes, std::size_t at, std::uint64_t number, std::size_t width) {
    for (std::size_t n = 0; n < width; ++n)
        bytes[at + n] = static_cast<char>(number >> (8 * n));
}

// Checksums, and fletcher32, tell of a bit that differs.
TEST(DamagedHdf5, ABitThatDiffersIsFoundByChecksums) {
    const ScratchFolder folder;
    std::string summed = contentOf(hdf5Corpus() / "fletcher_earliest.h5");
    const std::size_t voxel = summed.find(std::string("\0\0\1\0\2\0\3\0", 8));
    ASSERT_NE(voxel, std::string::npos);
    summed[voxel + 3] = 1;
    writeFile(folder / "a.h5", summed);
    EXPECT_THAT(refusal([&] {
                    for (Hdf5Volume& volume : openHdf5Volumes(folder / "a.h5"))
                        valuesOf(*volume.source);
                }),
                HasSubstr("fletcher32"));
    const std::string whole = contentOf(hdf5Corpus() / "chunks_latest.h5");
    for (const char* mark : {"OHDR", "FADB", "FAHD"}) {
        std::string damaged = whole;
        const std::size_t at = damaged.find(mark);
        ASSERT_NE(at, std::string::npos) << mark;
        damaged[at + 20] ^= 4;
        writeFile(folder / "a.h5", damaged);
        EXPECT_THAT(refusal([&] {
                        for (Hdf5Volume& volume : openHdf5Volumes(folder / "a.h5"))
                            valuesOf(*volume.source);
                    }),
                    HasSubstr("checksum"))
            << mark;
    }
}

// A set says 2^40 voxels, chunks of 2^29 numbers, a million records: nothing is taken for what it says.
TEST(DamagedHdf5, LiesAboutSizesTakeNoMemory) {
    const ScratchFolder folder;
    h5ChecksumsCount = false;
    const auto eight = [](std::uint64_t number) {
        std::string bytes(8, '\0');
        replaceAt(bytes, 0, number, 8);
        return bytes;
    };
    const auto refusedWith = [&](const char* name, const std::function<void(std::string&)>& lie) {
        std::string bytes = contentOf(hdf5Corpus() / name);
        lie(bytes);
        writeFile(folder / "a.h5", bytes);
        return refusal([&] {
            for (Hdf5Volume& volume : openHdf5Volumes(folder / "a.h5")) {
                std::vector<std::byte> slice(sliceBytesOf(volume.source->info()));
                volume.source->readSlices(1, slice);
            }
        });
    };
    // Contiguous numbers: their extents.
    EXPECT_THAT(refusedWith("spacing_earliest.h5",
                            [&](std::string& bytes) {
                                const std::string extents = eight(5) + eight(6) + eight(7);
                                for (std::size_t at = bytes.find(extents); at != std::string::npos;
                                     at = bytes.find(extents, at + 1))
                                    replaceAt(bytes, at, 1 << 20, 8);
                            }),
                HasSubstr("within the file"));
    // Chunks: their sides.
    EXPECT_THAT(refusedWith("single_earliest.h5",
                            [&](std::string& bytes) {
                                const std::string sides("\5\0\0\0\6\0\0\0\7\0\0\0", 12);
                                for (std::size_t at = bytes.find(sides); at != std::string::npos;
                                     at = bytes.find(sides, at + 1))
                                    replaceAt(bytes, at, 1 << 22, 4);
                            }),
                HasSubstr("too few for them"));
    // Records of a B-tree's node.
    EXPECT_THAT(refusedWith("endless_two_latest.h5",
                            [](std::string& bytes) {
                                for (std::size_t at = bytes.find("BTHD"); at != std::string::npos;
                                     at = bytes.find("BTHD", at + 1))
                                    replaceAt(bytes, at + 24, 65535, 2);
                            }),
                HasSubstr("records"));
    // A header's length.
    EXPECT_THAT(refusedWith("compact_earliest.h5",
                            [](std::string& bytes) { replaceAt(bytes, 96 + 8, 0xfffffff0u, 4); }),
                HasSubstr("16 MiB"));
    h5ChecksumsCount = true;
}

TEST(DamagedHdf5, BlocksAreReadUpToSixteenMebibytes) {
    const ScratchFolder folder;
    fs::copy_file(hdf5Corpus() / "contiguous_earliest.h5", folder / "a.h5");
    fs::resize_file(folder / "a.h5", 40 << 20); // takes no place
    const H5File file(folder / "a.h5");
    EXPECT_EQ(file.block(0, 16 << 20, "a block").left(), std::size_t{16} << 20);
    EXPECT_THAT(refusal([&] { file.block(0, (16 << 20) + 1, "a block"); }), HasSubstr("16 MiB at most"));
}

// Nodes, parts of headers and groups that point back at themselves.
TEST(DamagedHdf5, WhatPointsBackIsRefused) {
    const ScratchFolder folder;
    std::string bytes = contentOf(hdf5Corpus() / "contiguous_earliest.h5");
    const std::size_t tree = bytes.find("TREE");
    ASSERT_NE(tree, std::string::npos);
    bytes[tree + 5] = 1;                      // a level that has nodes below it,
    replaceAt(bytes, tree + 24 + 8, tree, 8); // and that is itself
    writeFile(folder / "a.h5", bytes);
    EXPECT_THAT(refusal([&] { openHdf5Volumes(folder / "a.h5"); }), HasSubstr("once"));
}

} // namespace
} // namespace tessera::test
