// tests/support/label_tools.h: tools that the tests of labels share: layers that are held, volumes of labels
// read back, and an oracle of placement.
#pragma once

#include "bricking/labels/label_import.h"
#include "bricking/labels/label_volume.h"
#include "core/base/brick.h"
#include "tests/support/bricking_test_volumes.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>
#include <map>
#include <random>
#include <set>
#include <thread>

namespace tessera::test {

using Values = std::vector<std::uint32_t>;
using LabelSet = std::set<std::uint32_t>; // of values

/// A layer whose voxels are held; it is read forward only.
struct HeldLayer final : LabelLayer {
    HeldLayer(const VolumeInfo& volume, Values voxels) : grid(volume), values(std::move(voxels)) {}
    const VolumeInfo& info() const override { return grid; }
    bool isAlone() const override { return !readers; }
    void readSlices(int count, std::span<std::uint32_t> out) override {
        if (readers) {
            EXPECT_EQ(readers->fetch_add(1), 0) << "layers that share something are read at the same time";
            std::this_thread::sleep_for(std::chrono::milliseconds(2));
        }
        const std::size_t slice = cellCount({grid.extentVoxels.x, grid.extentVoxels.y, 1});
        ASSERT_LE(next + count, grid.extentVoxels.z);
        ASSERT_EQ(out.size(), slice * static_cast<std::size_t>(count));
        std::copy_n(values.begin() + static_cast<std::ptrdiff_t>(slice) * next, out.size(), out.begin());
        next += count;
        if (readers)
            --*readers;
    }
    VolumeInfo grid;
    Values values;
    int next = 0;
    std::shared_ptr<std::atomic<int>> readers = {}; // what layers share; null: nothing
};

inline VolumeInfo gridOf(const glm::ivec3& extent, const glm::dmat4& patientFromVoxel) {
    VolumeInfo info;
    info.extentVoxels = extent;
    info.patientFromVoxel = patientFromVoxel;
    return info;
}

inline LabelFile fileOf(const std::vector<HeldLayer>& layers, std::vector<Label> labels = {}) {
    LabelFile file;
    for (const HeldLayer& layer : layers)
        file.layers.push_back(std::make_unique<HeldLayer>(layer));
    file.labels = std::move(labels);
    file.shown = "test.seg";
    return file;
}

/// Blobs of labels: balls of random values, and none between them.
inline Values blobs(const glm::ivec3& extent, std::vector<std::uint32_t> values, unsigned seed,
                    int count = 12) {
    std::mt19937 random(seed);
    const auto unit = [&] { return static_cast<double>(random()) / 4294967296.0; };
    Values voxels(cellCount(extent));
    for (int i = 0; i < count; ++i) {
        const glm::dvec3 centre = glm::dvec3(unit(), unit(), unit()) * glm::dvec3(extent);
        const double radius = (0.05 + 0.25 * unit()) * std::max({extent.x, extent.y, extent.z});
        const std::uint32_t value = values[random() % values.size()];
        for (std::size_t at = 0; at < voxels.size(); ++at) {
            const glm::dvec3 off = glm::dvec3(gridPosition(at, extent)) + 0.5 - centre;
            if (glm::dot(off, off) < radius * radius)
                voxels[at] = value;
        }
    }
    return voxels;
}

/// A volume of labels as it is in its store.
struct ReadBack {
    LabelTable table;
    VolumeInfo info;
    std::array<std::vector<double>, kLevelCount> levels; // numbers of sets
    LabelCells cells;                                    // without their charge
    std::string hash;

    LabelSet setOf(double number) const {
        LabelSet values;
        for (const std::uint16_t label : table.sets.at(static_cast<std::size_t>(number)))
            values.insert(table.labels.at(label).value);
        return values;
    }
    std::vector<LabelSet> voxels() const {
        std::vector<LabelSet> all;
        for (const double number : levels[0])
            all.push_back(setOf(number));
        return all;
    }
};

inline ReadBack readBack(const fs::path& store) {
    MemoryBudget ram("RAM", "--ram", std::size_t{512} << 20);
    const LabelVolume volume(store, ram);
    ReadBack all{volume.table(), volume.voxels().info(), {}, {}, volume.voxels().contentHash()};
    for (int level = 0; level < kLevelCount; ++level)
        all.levels[static_cast<std::size_t>(level)] = readLevel(volume.voxels(), level);
    all.cells.cells = volume.cells().cells;
    all.cells.first = volume.cells().first;
    all.cells.shares = volume.cells().shares;
    return all;
}

inline LabelImportOptions quickly(int threads = 2) {
    LabelImportOptions options;
    options.durable = false;
    options.threads = threads;
    return options;
}

/// Imports with exactly the memory that is the stated floor.
inline LabelImportReport importAtFloor(LabelFile& file, const VolumeInfo& scan, const fs::path& store,
                                       const LabelImportOptions& options = quickly()) {
    const std::size_t floor = labelImportFloorBytes(file, scan, options.threads);
    MemoryBudget ram("RAM", "--ram", floor);
    const LabelImportReport report = importLabels(file, scan, store, ram, options);
    EXPECT_EQ(ram.usedBytes(), 0u);
    return report;
}

inline ReadBack imported(const std::vector<HeldLayer>& layers, const VolumeInfo& scan, int threads = 2) {
    const ScratchFolder scratch;
    LabelFile file = fileOf(layers);
    importAtFloor(file, scan, scratch / "l.zarr", quickly(threads));
    EXPECT_EQ(entriesIn(scratch.path()), 1u);
    return readBack(scratch / "l.zarr");
}

/// What label_placement.h says, one voxel at a time.
struct Placed {
    std::uint32_t value = 0;
    double lead = 1; // of the winner's weight, as a share of all; near 0 rounding decides
};

inline Placed winnerOf(const std::map<std::uint32_t, double>& weights) {
    double all = 0, most = -1, second = 0;
    Placed placed;
    for (const auto& [value, weight] : weights) { // ascending: a tie stays with the lower value
        all += weight;
        if (weight > most + 1e-9) {
            second = std::max(second, most);
            most = weight;
            placed.value = value;
        } else {
            second = std::max(second, weight);
        }
    }
    placed.lead = (most - std::max(second, 0.0)) / all;
    return placed;
}

class PlacementOracle {
  public:
    /// @param isCounted  the layer is finer: a majority of the voxels inside
    PlacementOracle(const HeldLayer& layer, const VolumeInfo& scan, bool isCounted)
        : layer_(layer), scan_(scan), isCounted_(isCounted),
          layerFromPatient_(glm::inverse(layer.grid.patientFromVoxel)),
          inside_(isCounted ? cellCount(scan.extentVoxels) : 0) {
        const glm::dmat4 scanFromPatient = glm::inverse(scan.patientFromVoxel);
        for (std::size_t i = 0; isCounted && i < layer.values.size(); ++i) {
            const glm::dvec4 mm = layer.grid.patientFromVoxel *
                                  glm::dvec4(glm::dvec3(gridPosition(i, layer.grid.extentVoxels)) + 0.5, 1);
            const glm::ivec3 in(glm::floor(glm::dvec3(scanFromPatient * mm)));
            if (glm::clamp(in, glm::ivec3(0), scan.extentVoxels - 1) == in)
                ++inside_[linearIndex(in, scan.extentVoxels)][layer.values[i]];
        }
    }
    Placed at(const glm::ivec3& voxel) const;

  private:
    const HeldLayer& layer_;
    const VolumeInfo& scan_;
    bool isCounted_;
    glm::dmat4 layerFromPatient_;
    std::vector<std::map<std::uint32_t, double>> inside_;
};

inline Placed PlacementOracle::at(const glm::ivec3& voxel) const {
    const glm::ivec3 e = layer_.grid.extentVoxels;
    std::map<std::uint32_t, double> weights;
    if (isCounted_)
        weights = inside_[linearIndex(voxel, scan_.extentVoxels)];
    const bool isCounted = !weights.empty();
    double doubt = 1;
    if (weights.empty()) {
        const glm::dvec3 at =
            glm::dvec3(layerFromPatient_ * scan_.patientFromVoxel * glm::dvec4(glm::dvec3(voxel) + 0.5, 1));
        for (int axis = 0; axis < 3; ++axis) {
            doubt = std::min({doubt, std::abs(at[axis]), std::abs(at[axis] - e[axis])});
            if (at[axis] < -1e-12 || at[axis] > e[axis] + 1e-12)
                return {0, doubt};
        }
        // The weight of a sample is the product of hats around it; samples at the rim go on outwards.
        const glm::dvec3 from = glm::clamp(at, glm::dvec3(0.5), glm::dvec3(e) - 0.5);
        const glm::ivec3 first = glm::max(glm::ivec3(glm::floor(from)) - 1, 0);
        const glm::ivec3 last = glm::min(first + 3, e - 1);
        for (int z = first.z; z <= last.z; ++z)
            for (int y = first.y; y <= last.y; ++y)
                for (int x = first.x; x <= last.x; ++x) {
                    const glm::dvec3 off = glm::abs(glm::dvec3(x, y, z) + 0.5 - from);
                    const double weight =
                        std::max(0.0, 1 - off.x) * std::max(0.0, 1 - off.y) * std::max(0.0, 1 - off.z);
                    if (weight > 0)
                        weights[layer_.values[linearIndex({x, y, z}, e)]] += weight;
                }
    }
    Placed placed = winnerOf(weights);
    if (!isCounted)
        placed.lead = std::min(placed.lead, doubt);
    return placed;
}

} // namespace tessera::test
