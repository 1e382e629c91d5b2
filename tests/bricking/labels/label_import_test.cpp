// tests/bricking/labels/label_import_test.cpp: layers get to the scan's lattice as label_placement.h says;
// sets, types, cells and limits of what is imported.
#include "tests/support/label_tools.h"
#include "tests/support/recorded_numbers.h"

#include "core/base/error.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tessera {
namespace {

using namespace test;
using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

const glm::dmat4 kScanAffine =
    patientFromVoxelOf({-31.5, -20, 12}, {0.8, 0.02, 0}, {-0.02, 0.8, 0.1}, {0, -0.2, 1.5});

VolumeInfo scanOf(const glm::ivec3& extent) {
    return gridOf(extent, kScanAffine);
}

/// One layer on the scan's own grid.
ReadBack importedCopy(const glm::ivec3& extent, const Values& values) {
    return imported({HeldLayer(scanOf(extent), values)}, scanOf(extent));
}

TEST(LabelImport, AnEqualGridIsCopiedInEveryOrderOfItsAxes) {
    const glm::ivec3 extent(19, 13, 37);
    const Values values = blobs(extent, {1, 2, 7, 4294967295u}, 1);
    std::vector<LabelSet> expected;
    for (const std::uint32_t value : values)
        expected.push_back(value == 0 ? LabelSet{} : LabelSet{value});
    std::array<int, 3> order = {0, 1, 2};
    std::string hash;
    do {
        for (int flips = 0; flips < 8; flips += flips == 4 ? 3 : flips == 2 ? 2 : 1) { // none, one or all
            // Axis a of the layer is axis order[a] of the scan, and may run the other way.
            glm::ivec3 size;
            glm::dmat4 affine(1);
            affine[3] = kScanAffine[3];
            for (int a = 0; a < 3; ++a) {
                const int of = order[static_cast<std::size_t>(a)];
                size[a] = extent[of];
                affine[a] = (flips >> a & 1) ? -kScanAffine[of] : kScanAffine[of];
                if (flips >> a & 1)
                    affine[3] += kScanAffine[of] * static_cast<double>(extent[of]);
            }
            Values turned(values.size());
            for (std::size_t i = 0; i < turned.size(); ++i) {
                const glm::ivec3 at = gridPosition(i, size);
                glm::ivec3 from;
                for (int a = 0; a < 3; ++a)
                    from[order[static_cast<std::size_t>(a)]] = (flips >> a & 1) ? size[a] - 1 - at[a] : at[a];
                turned[i] = values[linearIndex(from, extent)];
            }
            affine[3] += glm::dvec4(1e-4, -1e-4, 2e-4, 0); // files round
            const ReadBack back = imported({HeldLayer(gridOf(size, affine), turned)}, scanOf(extent));
            ASSERT_TRUE(back.voxels() == expected) << order[0] << order[1] << order[2] << " " << flips;
            EXPECT_EQ(back.info.patientFromVoxel, kScanAffine);
            EXPECT_TRUE(hash.empty() || hash == back.hash);
            hash = back.hash;
        }
    } while (std::next_permutation(order.begin(), order.end()));
}

struct Grid {
    const char* name;
    glm::ivec3 extent;
    glm::dmat4 affine;
    bool isCounted;
};

std::vector<Grid> otherGrids() {
    using glm::dvec3;
    const auto scanThen = [](const glm::dmat4& voxels) { return kScanAffine * voxels; };
    const auto scaled = [](double x, double y, double z) {
        return glm::scale(glm::dmat4(1), dvec3(x, y, z));
    };
    const auto moved = [](double x, double y, double z) {
        return glm::translate(glm::dmat4(1), dvec3(x, y, z));
    };
    const auto turned = [](double angle, const dvec3& about) {
        return glm::rotate(glm::dmat4(1), angle, about);
    };
    return {
        {"moved by fractions", {20, 16, 24}, scanThen(moved(-1.3, 0.41, 2.77)), false},
        {"far off the scan at one side", {20, 16, 24}, scanThen(moved(15.2, -3.3, 14.9)), false},
        {"turned a little", {22, 20, 24}, scanThen(moved(-2, -2, -1) * turned(0.2, {0.3, 0.5, 1})), false},
        {"turned by half a right angle",
         {28, 26, 30},
         scanThen(moved(6, -9, 0) * turned(0.79, {0, 0, 1})),
         false},
        {"on its head", {22, 20, 24}, scanThen(moved(21, 17, 1) * turned(3.1, {0, 0, 1})), false},
        {"coarser", {9, 8, 11}, scanThen(moved(-0.2, 0.1, 0.3) * scaled(2.3, 2.1, 2.4)), false},
        {"coarser by whole voxels", {10, 8, 12}, scanThen(scaled(2, 2, 2)), false},
        {"a little finer", {33, 27, 40}, scanThen(scaled(0.63, 0.61, 0.57)), false},
        {"finer", {50, 40, 60}, scanThen(moved(-0.11, 0.07, 0.05) * scaled(0.37, 0.41, 0.43)), true},
        {"finer by whole voxels", {60, 45, 66}, scanThen(scaled(1. / 3, 1. / 3, 1. / 3)), true},
        {"finer along z, coarser along x", {8, 15, 90}, scanThen(scaled(2.6, 1, 0.23)), true},
        {"finer and turned",
         {60, 60, 66},
         scanThen(moved(-2, -3, -1) * turned(0.3, {1, 0.2, 0.4}) * scaled(0.41, 0.4, 0.39)),
         true},
        {"finer by far, so that less than a slice is held at once",
         {180, 150, 198},
         scanThen(scaled(1. / 9, 1. / 10, 1. / 9)),
         true},
        {"much finer along x", {700, 15, 22}, scanThen(scaled(1. / 35.5, 1, 1)), true},
        {"one slice", {20, 15, 1}, scanThen(moved(0, 0, 9.7)), false},
    };
}

TEST(LabelImport, AnotherGridGetsTheHeaviestLabel) {
    const VolumeInfo scan = scanOf({20, 15, 22});
    for (const Grid& grid : otherGrids()) {
        SCOPED_TRACE(grid.name);
        const HeldLayer layer(gridOf(grid.extent, grid.affine),
                              blobs(grid.extent, {3, 9, 200, 70000}, 5, 25));
        const ReadBack back = imported({layer}, scan);
        const PlacementOracle oracle(layer, scan, grid.isCounted);
        std::size_t compared = 0, labelled = 0, doubtful = 0;
        for (std::size_t i = 0; i < back.levels[0].size(); ++i) {
            const glm::ivec3 voxel = gridPosition(i, scan.extentVoxels);
            const Placed expected = oracle.at(voxel);
            if (expected.lead < 1e-7 && !grid.isCounted) {
                ++doubtful;
                continue;
            }
            const LabelSet set = expected.value == 0 ? LabelSet{} : LabelSet{expected.value};
            ASSERT_EQ(back.setOf(back.levels[0][i]), set) << voxel.x << " " << voxel.y << " " << voxel.z;
            ++compared;
            labelled += expected.value != 0;
        }
        EXPECT_LT(doubtful, compared / 5);
        EXPECT_GT(labelled, 30u);
    }
}

TEST(LabelImport, ATieGoesToTheLowerValueAndNoLabelIsOne) {
    // Half a voxel off along x: every voxel of the scan lies between two of the layer.
    const VolumeInfo scan = gridOf({4, 1, 1}, patientFromVoxelOf({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}));
    const VolumeInfo half =
        gridOf({5, 1, 1}, patientFromVoxelOf({-0.5, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}));
    const ReadBack back = imported({HeldLayer(half, {8, 5, 5, 0, 9})}, scan);
    EXPECT_EQ(back.voxels(), (std::vector<LabelSet>{{5}, {5}, {}, {}}));
    // Finer by two: two voxels each.
    const VolumeInfo finer =
        gridOf({8, 1, 1}, patientFromVoxelOf({-0.25, 0, 0}, {0.5, 0, 0}, {0, 1, 0}, {0, 0, 1}));
    const ReadBack counted = imported({HeldLayer(finer, {7, 3, 3, 3, 0, 3, 7, 7})}, scan);
    EXPECT_EQ(counted.voxels(), (std::vector<LabelSet>{{3}, {3}, {}, {7}}));
}

TEST(LabelImport, TheOutermostHalfVoxelCountsAndNothingBeyond) {
    const glm::dmat4 affine = patientFromVoxelOf({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1});
    // The scan's centres lie 0.4 and 0.6 of a voxel beyond the layer's outermost centres.
    for (const auto& [shift, first] : {std::pair(0.4, 1), std::pair(0.6, 0)}) {
        const VolumeInfo layer =
            gridOf({2, 1, 1}, patientFromVoxelOf({1 + shift, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}));
        const ReadBack back = imported({HeldLayer(layer, {6, 6})}, gridOf({5, 1, 1}, affine));
        EXPECT_EQ(back.voxels()[1], first == 1 ? LabelSet{6} : LabelSet{}) << shift;
        EXPECT_EQ(back.voxels()[0], LabelSet{});
        EXPECT_EQ(back.voxels()[2], LabelSet{6});
        EXPECT_EQ(back.voxels()[4], LabelSet{});
    }
}

TEST(LabelImport, LayersOverlap) {
    const VolumeInfo scan = scanOf({21, 18, 26});
    const glm::dmat4 other = kScanAffine * glm::translate(glm::dmat4(1), glm::dvec3(2.3, -1.2, 0.6));
    std::vector<HeldLayer> layers;
    for (unsigned i = 0; i < 7; ++i) // three on the scan's grid, four on another; a value in several layers
        layers.emplace_back(i % 2 ? gridOf(scan.extentVoxels, kScanAffine) : gridOf(scan.extentVoxels, other),
                            blobs(scan.extentVoxels, {i + 1, 100}, i, 4));
    const ReadBack back = imported(layers, scan);
    std::size_t several = 0;
    for (std::size_t i = 0; i < back.levels[0].size(); ++i) {
        LabelSet expected;
        bool isDoubtful = false;
        for (const HeldLayer& layer : layers) {
            const Placed placed = PlacementOracle(layer, scan, false).at(gridPosition(i, scan.extentVoxels));
            isDoubtful = isDoubtful || placed.lead < 1e-7;
            if (placed.value != 0)
                expected.insert(placed.value);
        }
        if (isDoubtful)
            continue;
        ASSERT_EQ(back.setOf(back.levels[0][i]), expected) << i;
        several += expected.size() > 1;
    }
    EXPECT_GT(several, 500u);
    for (int threads : {1, 5})
        EXPECT_EQ(imported(layers, scan, threads).hash, back.hash) << threads;
}

TEST(LabelImport, LayersThatShareAFileAreReadOneByOne) {
    const VolumeInfo scan = scanOf({9, 8, 7});
    std::vector<HeldLayer> layers(4, HeldLayer(scan, Values(9 * 8 * 7, 1)));
    const auto shared = std::make_shared<std::atomic<int>>(0);
    for (HeldLayer& layer : layers)
        layer.readers = shared;
    EXPECT_EQ(imported(layers, scan, 4).table.sets.size(), 2u);
}

TEST(LabelImport, MoreLayersThanFilesMayBeOpen) {
    const VolumeInfo scan = scanOf({6, 5, 9});
    std::vector<HeldLayer> layers;
    std::vector<LabelSet> expected(cellCount(scan.extentVoxels));
    for (std::uint32_t i = 0; i < 450; ++i) {
        Values values(expected.size());
        for (std::size_t at : {std::size_t{i % 270}, std::size_t{i * 7 % 270}}) {
            values[at] = i + 1;
            expected[at].insert(i + 1);
        }
        layers.emplace_back(scan, values);
    }
    const ReadBack back = imported(layers, scan);
    EXPECT_TRUE(back.voxels() == expected);
    EXPECT_EQ(back.info.type, back.table.sets.size() < 256 ? ValueType::u8 : ValueType::u16);
}

TEST(LabelImport, LevelsAreMajoritiesAndTiesGoToTheRarer) {
    for (const glm::ivec3& extent : {glm::ivec3(37, 22, 70), glm::ivec3(1, 65, 3), glm::ivec3(64, 33, 32)}) {
        std::mt19937 random(7);
        Values values(cellCount(extent)); // noise, so that there are many ties
        for (std::uint32_t& value : values)
            value = static_cast<std::uint32_t>(random() % 3 == 0 ? 0 : 1 + random() % 5 * (random() % 2));
        const ReadBack back = importedCopy(extent, values);
        std::map<double, std::size_t> voxels;
        for (const double set : back.levels[0])
            ++voxels[set];
        glm::ivec3 e = extent;
        for (std::size_t level = 1; level < kLevelCount; ++level) {
            const glm::ivec3 half = ceilDiv(e, 2);
            ASSERT_EQ(back.levels[level].size(), cellCount(half));
            for (std::size_t i = 0; i < cellCount(half); ++i) {
                std::map<double, int> votes;
                for (int c = 0; c < 8; ++c)
                    ++votes[back.levels[level - 1][linearIndex(
                        glm::min(2 * gridPosition(i, half) + glm::ivec3(c & 1, c >> 1 & 1, c >> 2), e - 1),
                        e)]];
                const auto best = std::max_element(votes.begin(), votes.end(), [&](auto& a, auto& b) {
                    return std::tuple(a.second, voxels[b.first], b.first) <
                           std::tuple(b.second, voxels[a.first], a.first);
                });
                ASSERT_EQ(back.levels[level][i], best->first) << level << " " << i;
            }
            e = half;
        }
    }
}

/// Slices of more than 2^19 voxels go through the temporary file in pieces, on a grid of their own in tiles.
TEST(LabelImport, WideSlicesArriveWhole) {
    const glm::ivec3 extent(850, 631, 2);
    Values values(cellCount(extent));
    std::mt19937 random(4);
    for (std::size_t i = 0; i < values.size(); ++i)
        values[i] = i % 5 && i > 0 ? values[i - 1] : static_cast<std::uint32_t>(random() % 4);
    const ReadBack back = importedCopy(extent, values);
    std::vector<std::uint32_t> valueOf; // of a set
    for (std::size_t set = 0; set < back.table.sets.size(); ++set)
        valueOf.push_back(set == 0 ? 0 : *back.setOf(static_cast<double>(set)).begin());
    for (std::size_t i = 0; i < values.size(); ++i)
        ASSERT_EQ(valueOf.at(static_cast<std::size_t>(back.levels[0][i])), values[i]) << i;
}

/// A volume of labels lies where its scan does; what is known of the scan's axes is known of its.
TEST(LabelImport, TheStoreIsDescribedAsItsScan) {
    VolumeInfo scan = scanOf({19, 18, 17});
    scan.orientationKnown = false;
    scan.originalOrder = {{2, 0, 1}, {true, false, true}};
    scan.acquisition = {"CT", "B30f", 120, 1.5};
    const ScratchFolder scratch;
    LabelFile file = fileOf({HeldLayer(scan, blobs(scan.extentVoxels, {3, 4}, 2))});
    const LabelImportReport report = importAtFloor(file, scan, scratch / "l.zarr");
    const VolumeInfo info = readBack(scratch / "l.zarr").info;
    EXPECT_EQ(info.extentVoxels, scan.extentVoxels);
    EXPECT_EQ(info.patientFromVoxel, scan.patientFromVoxel);
    EXPECT_FALSE(info.orientationKnown);
    EXPECT_EQ(info.originalOrder.sourceAxis, scan.originalOrder.sourceAxis);
    EXPECT_EQ(info.acquisition.modality, "SEG");
    EXPECT_EQ(info.acquisition.kernel, "");
    std::uintmax_t bytes = 0; // of the levels' shards, which are most of it
    for (const auto& entry : fs::recursive_directory_iterator(scratch / "l.zarr"))
        bytes += entry.is_regular_file() ? entry.file_size() : 0;
    EXPECT_GT(report.bytesOut, 0u);
    EXPECT_LE(report.bytesOut, bytes);
}

TEST(LabelImport, CellsCountTheirVoxels) {
    for (const glm::ivec3& extent : {glm::ivec3(8, 8, 8), glm::ivec3(19, 9, 41), glm::ivec3(1, 7, 33)}) {
        std::mt19937 random(9);
        Values values = blobs(extent, {1, 2, 3}, 3);
        for (std::uint32_t& value : values)
            value = random() % 5 == 0 ? static_cast<std::uint32_t>(random() % 4) : value;
        values[0] = 2;
        const ReadBack back = importedCopy(extent, values);
        ASSERT_EQ(back.cells.cells, cellGrid(extent));
        std::vector<std::map<std::uint16_t, std::uint16_t>> expected(cellCount(back.cells.cells));
        for (std::size_t i = 0; i < values.size(); ++i)
            ++expected[linearIndex(gridPosition(i, extent) / kCellExtent, back.cells.cells)]
                      [static_cast<std::uint16_t>(back.levels[0][i])];
        for (std::size_t cell = 0; cell < expected.size(); ++cell) {
            std::vector<LabelCells::Share> shares;
            for (const auto& [set, voxels] : expected[cell])
                shares.push_back({set, voxels});
            const auto found = back.cells.of(cell);
            ASSERT_EQ((std::vector<LabelCells::Share>(found.begin(), found.end())), shares) << cell;
        }
    }
}

TEST(LabelImport, TheTypeFollowsTheNumberOfSets) {
    const glm::ivec3 extent(40, 30, 8);
    for (const std::uint32_t labels : {254u, 255u, 256u, 600u}) { // and the empty set
        Values values(cellCount(extent));
        for (std::size_t i = 0; i < values.size(); ++i)
            values[i] = static_cast<std::uint32_t>(i) % (labels + 1) * 1000003u;
        const ReadBack back = importedCopy(extent, values);
        EXPECT_EQ(back.table.sets.size(), labels + 1);
        EXPECT_EQ(back.info.type, labels + 1 < 256 ? ValueType::u8 : ValueType::u16) << labels;
        for (std::size_t i = 0; i < values.size(); ++i)
            ASSERT_EQ(back.setOf(back.levels[0][i]), values[i] == 0 ? LabelSet{} : LabelSet{values[i]});
    }
}

TEST(LabelImport, TheMostLabelsAndNoMore) {
    const glm::ivec3 extent(256, 32, 8); // 65536 voxels
    Values values(cellCount(extent));
    for (std::size_t i = 0; i < values.size(); ++i)
        values[i] = static_cast<std::uint32_t>(std::min<std::size_t>(i, 65534));
    const ScratchFolder scratch;
    MemoryBudget ram("RAM", "--ram", std::size_t{1} << 30);
    LabelFile file = fileOf({HeldLayer(scanOf(extent), values)});
    importLabels(file, scanOf(extent), scratch / "l.zarr", ram, quickly());
    const ReadBack back = readBack(scratch / "l.zarr");
    EXPECT_EQ(back.table.sets.size(), 65535u);
    EXPECT_EQ(back.setOf(back.levels[0][65533]), LabelSet{65533});
    for (std::size_t i = 0; i < values.size(); ++i)
        values[i] = static_cast<std::uint32_t>(i * 150); // up to 10^7
    LabelFile many = fileOf({HeldLayer(scanOf(extent), values)});
    EXPECT_THAT([&] { importLabels(many, scanOf(extent), scratch / "m.zarr", ram, quickly()); },
                ThrowsMessage<InputError>(AllOf(HasSubstr("test.seg"), HasSubstr("65535"))));
    EXPECT_FALSE(fs::exists(scratch / "m.zarr"));
    EXPECT_EQ(ram.usedBytes(), 0u);
}

TEST(LabelImport, EmptyLabelsStayInTheTable) {
    const VolumeInfo scan = scanOf({9, 8, 7});
    const ScratchFolder scratch;
    LabelFile file =
        fileOf({HeldLayer(scan, Values(9 * 8 * 7, 5))},
               {{9, "spleen", "organs", glm::vec3(0.25f, 0.5f, 0.125f)}, {5, "liver"}, {2, "x\ny"}});
    const LabelImportReport report = importAtFloor(file, scan, scratch / "l.zarr");
    EXPECT_THAT(report.notes, testing::Contains(AllOf(HasSubstr("2 labels"), HasSubstr("spleen"))));
    EXPECT_EQ(report.labelled, 9u * 8 * 7);
    const ReadBack back = readBack(scratch / "l.zarr");
    ASSERT_EQ(back.table.labels.size(), 3u);
    EXPECT_EQ(back.table.labels[0].value, 2u);
    EXPECT_EQ(back.table.labels[1], (Label{5, "liver"}));
    EXPECT_EQ(back.table.labels[2], (Label{9, "spleen", "organs", glm::vec3(0.25f, 0.5f, 0.125f)}));
    EXPECT_EQ(back.table.sets, (std::vector<std::vector<std::uint16_t>>{{}, {1}}));
}

/// What a report says of labels without a voxel: at most five by name.
TEST(LabelImport, EmptyLabelsAreNamed) {
    const VolumeInfo scan = scanOf({9, 8, 7});
    for (const auto& [count, text] : std::vector<std::pair<std::uint32_t, std::string>>{
             {1, "1 label has no voxel on the scan: n11"},
             {2, "2 labels have no voxel on the scan: n11, n12"},
             {5, "5 labels have no voxel on the scan: n11, n12, n13, n14, n15"},
             {6, "6 labels have no voxel on the scan: n11, n12, n13, n14, n15 and 1 more"},
             {9, "9 labels have no voxel on the scan: n11, n12, n13, n14, n15 and 4 more"}}) {
        const ScratchFolder scratch;
        std::vector<Label> labels;
        for (std::uint32_t i = 0; i < count; ++i)
            labels.push_back({11 + i, "n" + std::to_string(11 + i)});
        Values values(9 * 8 * 7, 0);
        for (std::size_t i = 0; i < 100; ++i)
            values[i] = i < 30 ? 3 : 4;
        LabelFile file = fileOf({HeldLayer(scan, values)}, labels);
        const LabelImportReport report = importAtFloor(file, scan, scratch / "l.zarr");
        EXPECT_EQ(report.notes, std::vector<std::string>{text});
        EXPECT_EQ(report.voxels, 9u * 8 * 7);
        EXPECT_EQ(report.labelled, 100u);
        EXPECT_EQ(report.labels, count + 2);
        EXPECT_EQ(report.sets, 3u);
    }
}

/// Names without signs of control, a name for each, colours from 0 to 1, the first of two of a value.
TEST(LabelImport, LabelsOfATableAreShownSafely) {
    const VolumeInfo scan = scanOf({9, 8, 7});
    const ScratchFolder scratch;
    LabelFile file =
        fileOf({HeldLayer(scan, Values(9 * 8 * 7, 5))}, {{5, "",
                                                          "a\x01"
                                                          "b",
                                                          glm::vec3(-0.5f, 1.5f, 0.25f)},
                                                         {6, "x", "", glm::vec3(std::nanf(""), INFINITY, 1)},
                                                         {6, "another"},
                                                         {0, "none"}});
    importAtFloor(file, scan, scratch / "l.zarr");
    const ReadBack back = readBack(scratch / "l.zarr");
    ASSERT_EQ(back.table.labels.size(), 2u);
    EXPECT_EQ(back.table.labels[0].name, "label 5");
    EXPECT_EQ(back.table.labels[0].group.find('\x01'), std::string::npos);
    EXPECT_EQ(back.table.labels[0].colour, glm::vec3(0, 1, 0.25f));
    EXPECT_EQ(back.table.labels[1].name, "x");
    EXPECT_EQ(back.table.labels[1].colour, glm::vec3(0, 0, 1));
}

/// A note says how voxels get to another grid: by weights, or from the factor two on by counts.
TEST(LabelImport, TheWayToAnotherGridIsSaid) {
    const VolumeInfo scan = gridOf({20, 16, 12}, glm::dmat4(1));
    for (const auto& [factor, word] : std::vector<std::pair<double, std::string>>{{1, ""},
                                                                                  {1.5, "largest weight"},
                                                                                  {1.99, "largest weight"},
                                                                                  {2, "most voxels"},
                                                                                  {3, "most voxels"}}) {
        const ScratchFolder scratch;
        const glm::ivec3 extent(glm::dvec3(20, 16, 12) * factor + 0.5);
        const glm::dmat4 affine = glm::scale(glm::dmat4(1), glm::dvec3(1 / factor));
        LabelFile file = fileOf({HeldLayer(gridOf(extent, affine), Values(cellCount(extent), 5))});
        const LabelImportReport report = importAtFloor(file, scan, scratch / "l.zarr");
        if (word.empty()) {
            EXPECT_TRUE(report.notes.empty());
            continue;
        }
        ASSERT_EQ(report.notes.size(), 1u) << factor;
        EXPECT_THAT(report.notes[0], AllOf(HasSubstr(word), HasSubstr(std::to_string(extent.x) + " x " +
                                                                      std::to_string(extent.y) + " x ")));
    }
}

TEST(LabelImport, WhatDoesNotFitIsRefused) {
    const VolumeInfo scan = scanOf({9, 8, 7});
    const Values ones(9 * 8 * 7, 1);
    const ScratchFolder scratch;
    const auto refusalOf = [&](LabelFile file, const LabelImportOptions& options = quickly(),
                               std::size_t budget = std::size_t{256} << 20) -> std::string {
        MemoryBudget ram("RAM", "--ram", budget);
        try {
            importLabels(file, scan, scratch / "l.zarr", ram, options);
        } catch (const InputError& error) {
            EXPECT_EQ(entriesIn(scratch.path()), 0u);
            EXPECT_EQ(ram.usedBytes(), 0u);
            return error.what();
        }
        return "";
    };
    const VolumeInfo away =
        gridOf({9, 8, 7}, glm::translate(glm::dmat4(1), glm::dvec3(500, 0, 0)) * kScanAffine);
    EXPECT_THAT(refusalOf(fileOf({HeldLayer(scan, ones), HeldLayer(away, ones)})),
                AllOf(HasSubstr("test.seg"), HasSubstr("mm"), HasSubstr("another patient")));
    EXPECT_THAT(refusalOf(fileOf({HeldLayer(scan, Values(ones.size()))})), HasSubstr("no labelled voxel"));
    EXPECT_THAT(refusalOf(fileOf({})), HasSubstr("none"));

    LabelFile small = fileOf({HeldLayer(scan, ones)});
    const std::size_t floor = labelImportFloorBytes(small, scan, 2);
    EXPECT_THAT(refusalOf(std::move(small), quickly(), floor - 1), HasSubstr("--ram"));

    MemoryBudget plenty("RAM", "--ram", std::size_t{256} << 20);
    LabelFile first = fileOf({HeldLayer(scan, ones)});
    importLabels(first, scan, scratch / "l.zarr", plenty, quickly());
    LabelFile again = fileOf({HeldLayer(scan, ones)});
    MemoryBudget ram("RAM", "--ram", std::size_t{256} << 20);
    EXPECT_THAT([&] { importLabels(again, scan, scratch / "l.zarr", ram, quickly()); },
                ThrowsMessage<InputError>(HasSubstr("existing store")));
    EXPECT_EQ(readBack(scratch / "l.zarr").table.sets.size(), 2u);
}

// Frames of reference: of the labels, of the scan, whether they are taken for one, of the store; "": refused.
TEST(LabelImport, FramesOfReferenceAreCompared) {
    const ScratchFolder scratch;
    const VolumeInfo scan = gridOf({9, 8, 7}, kScanAffine);
    const Values ones(9 * 8 * 7, 1);
    struct Case {
        std::string labels, scan;
        bool same;
        std::string store;
    };
    for (const Case& c : {Case{"1.2.4", "1.2.4", false, "1.2.4"}, Case{"1.2.4", "", false, "1.2.4"},
                          Case{"", "1.2.3", false, "1.2.3"}, Case{"1.2.4", "1.2.3", true, "1.2.3"},
                          Case{"1.2.4", "1.2.3", false, ""}}) {
        SCOPED_TRACE(c.labels + " on " + c.scan);
        LabelFile file = fileOf({HeldLayer(scan, ones)});
        file.frameOfReference = c.labels;
        VolumeInfo framed = scan;
        framed.frameOfReference = c.scan;
        LabelImportOptions options = quickly();
        options.sameFrame = c.same;
        options.force = true;
        MemoryBudget ram("RAM", "--ram", std::size_t{256} << 20);
        const auto import = [&] { importLabels(file, framed, scratch / "l.zarr", ram, options); };
        if (c.store.empty()) {
            EXPECT_THAT(import, ThrowsMessage<InputError>(
                                    AllOf(HasSubstr("test.seg"), HasSubstr("reference, 1.2.3"),
                                          HasSubstr("found 1.2.4"), HasSubstr("--same-frame"))));
        } else {
            EXPECT_NO_THROW(import());
            EXPECT_EQ(StoreReader(scratch / "l.zarr", ram).info().frameOfReference, c.store);
        }
    }
}

/// A floor is enough (importAtFloor()); this is about how much it is.
TEST(LabelImport, FloorsAreThoseOfTheRecord) {
    test::RecordedNumbers record("tests/bricking/labels/recorded/floors.txt");
    const VolumeInfo scan = scanOf({300, 210, 90}), small = scanOf({9, 8, 7});
    const auto floorOf = [&](const VolumeInfo& on, std::size_t layers, const glm::ivec3& grid, int threads) {
        LabelFile file;
        for (std::size_t i = 0; i < layers; ++i)
            file.layers.push_back(std::make_unique<HeldLayer>(gridOf(grid, on.patientFromVoxel), Values{}));
        return static_cast<double>(labelImportFloorBytes(file, on, threads));
    };
    record.expect("one",
                  {floorOf(scan, 1, scan.extentVoxels, 1), floorOf(scan, 1, scan.extentVoxels, 3),
                   floorOf(small, 1, small.extentVoxels, 2), floorOf(small, 1, {900, 700, 300}, 2)},
                  0, 0.5);
    record.expect("many",
                  {floorOf(scan, 7, scan.extentVoxels, 2), floorOf(scan, 200, scan.extentVoxels, 2),
                   floorOf(scan, 201, scan.extentVoxels, 2), floorOf(small, 450, small.extentVoxels, 2)},
                  0, 0.5);
}

} // namespace
} // namespace tessera
