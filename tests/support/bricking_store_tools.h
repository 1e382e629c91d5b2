// tests/support/bricking_store_tools.h: tools that the tests of stores share: importing within a budget that
// is checked, and a volume whose every field of the description differs from its default.
#pragma once

#include "tests/support/bricking_test_volumes.h"

#include <gtest/gtest.h>

namespace tessera::test {

constexpr std::size_t kPlenty = 256u << 20;

inline ImportReport import(const fs::path& path, SlabSource& source, bool force = false, int threads = 2,
                           std::size_t budget = kPlenty, bool durable = false) {
    MemoryBudget ram("RAM", "--ram", budget);
    ImportOptions options;
    options.force = force;
    options.threads = threads;
    options.durable = durable;
    const ImportReport report = importToStore(source, path, ram, options);
    EXPECT_EQ(ram.usedBytes(), 0u);
    EXPECT_LE(ram.peakBytes(), budget);
    return report;
}

inline VolumeInfo obliqueInfo() {
    VolumeInfo info = plainInfo({21, 35, 40}, ValueType::i16);
    info.patientFromVoxel = patientFromVoxelOf({-101.3, 0.1, 1e-3}, {0.68, 0.1, -0.02}, {-0.1, 0.7, 1.0 / 3},
                                               {0.01, -0.4, 1.1}); // oblique and sheared
    info.rescaleSlope = 0.1;
    info.rescaleIntercept = -1024.5;
    info.unit = "HU";
    info.fillStored = -1024;
    info.originalOrder = {{2, 0, 1}, {true, false, true}};
    info.acquisition = {"CT", "B30f", 120, 1.5};
    info.nonFiniteVoxels = 3;
    info.clampedVoxels = std::uint64_t{1} << 40;
    return info;
}

} // namespace tessera::test
