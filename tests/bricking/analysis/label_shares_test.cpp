// tests/bricking/analysis/label_shares_test.cpp: chosen labels as a volume of shares, and their surface.
#include "bricking/analysis/surface/label_shares.h"
#include "tests/support/closed_mesh.h"
#include "tests/support/label_tools.h"

namespace tessera::test {
namespace {

const glm::ivec3 kExtent(45, 38, 70); // the chunks at the ends are cut, and so are samples of coarse levels

struct Segmentation {
    ScratchFolder scratch;
    VolumeInfo scan = gridOf(kExtent, glm::scale(glm::dmat4(1), glm::dvec3(0.8, 0.9, -1.5)));
    MemoryBudget ram{"RAM", "--ram", std::size_t{256} << 20};
    std::unique_ptr<LabelVolume> labels;
    Values first, second;

    Segmentation() {
        first = blobs(kExtent, {3, 5}, 1), second = blobs(kExtent, {9}, 2, 5); // some of which overlap
        LabelFile file = fileOf({HeldLayer(scan, first), HeldLayer(scan, second)});
        importLabels(file, scan, scratch / "l.zarr", ram, quickly());
        labels = std::make_unique<LabelVolume>(scratch / "l.zarr", ram);
    }
    std::vector<bool> choose(const std::set<std::uint32_t>& values) const {
        std::vector<bool> chosen;
        for (const Label& label : labels->table().labels)
            chosen.push_back(values.contains(label.value));
        return chosen;
    }
};

std::vector<float> levelOf(const ChunkSource& source, int level) {
    const glm::ivec3 extent = levelExtent(source.info().extentVoxels, level),
                     chunks = chunkGrid(source.info().extentVoxels, level);
    std::vector<float> all(cellCount(extent)), chunk(cellCount(glm::ivec3(kChunkExtent)));
    for (std::size_t n = 0; n < cellCount(chunks); ++n) {
        const glm::ivec3 at = gridPosition(n, chunks);
        source.readChunk({level, at.x, at.y, at.z}, std::as_writable_bytes(std::span(chunk)));
        for (std::size_t i = 0; i < chunk.size(); ++i) {
            const glm::ivec3 sample = kChunkExtent * at + gridPosition(i, glm::ivec3(kChunkExtent));
            if (glm::min(sample, extent - 1) == sample)
                all[linearIndex(sample, extent)] = chunk[i];
        }
    }
    return all;
}

TEST(LabelShares, AreMeansOverTheVoxelsOfASample) {
    Segmentation s;
    for (const std::set<std::uint32_t>& values : {std::set<std::uint32_t>{5}, {3, 9}, {}}) {
        const LabelShares shares(*s.labels, s.choose(values), s.ram, 1);
        EXPECT_EQ(shares.any(), !values.empty());
        const auto chosen = [&](std::size_t at) {
            return values.contains(s.first[at]) || values.contains(s.second[at]);
        };
        for (const int level : {0, 1, 3, 5}) {
            const std::vector<float> read = levelOf(shares, level);
            const glm::ivec3 extent = levelExtent(kExtent, level);
            ASSERT_EQ(read.size(), cellCount(extent));
            for (std::size_t n = 0; n < read.size(); ++n) {
                const glm::ivec3 low = gridPosition(n, extent) << level,
                                 high = glm::min(low + (1 << level), kExtent);
                double sum = 0;
                for (int z = low.z; z < high.z; ++z)
                    for (int y = low.y; y < high.y; ++y)
                        for (int x = low.x; x < high.x; ++x)
                            sum += chosen(linearIndex({x, y, z}, kExtent));
                ASSERT_NEAR(static_cast<double>(read[n]), sum / static_cast<double>(cellCount(high - low)),
                            1e-7)
                    << level;
            }
        }
        const CellRanges ranges = shares.ranges();
        for (std::size_t cell = 0; cell < cellCount(ranges.cells); ++cell) {
            const glm::ivec3 low = kCellExtent * gridPosition(cell, ranges.cells),
                             high = glm::min(low + kCellExtent, kExtent);
            bool none = true, all = true;
            for (int z = low.z; z < high.z; ++z)
                for (int y = low.y; y < high.y; ++y)
                    for (int x = low.x; x < high.x; ++x)
                        (chosen(linearIndex({x, y, z}, kExtent)) ? none : all) = false;
            ASSERT_EQ(ranges.low[cell], all ? 1.f : 0.f);
            ASSERT_EQ(ranges.high[cell], none ? 0.f : 1.f);
        }
    }
}

TEST(LabelShares, SurfacesAreClosedAroundTheVoxelsOfLabels) {
    Segmentation s;
    for (const std::set<std::uint32_t>& values : {std::set<std::uint32_t>{5}, {3, 5, 9}})
        for (const int level : {0, 1}) {
            const LabelShares shares(*s.labels, s.choose(values), s.ram, 1);
            const SurfaceLattice lattice(s.scan, {glm::dvec3(0), glm::dvec3(kExtent)}, level, "test");
            SurfaceRequest request;
            request.value = 0.5, request.threads = 1;
            HeldMesh mesh;
            const SurfaceCounts found =
                extractSurface(shares, lattice, shares.ranges(), request, s.ram, mesh);
            EXPECT_EQ(faultOf(mesh), "");
            double voxels = 0;
            for (std::size_t at = 0; at < s.first.size(); ++at)
                voxels += values.contains(s.first[at]) || values.contains(s.second[at]);
            EXPECT_NEAR(found.volumeMm3, voxels * 0.8 * 0.9 * 1.5, 0.03 * voxels) << level;
            if (level == 0) {
                EXPECT_LT(found.cellsSeen, found.cells);
            }
        }
}

} // namespace
} // namespace tessera::test
