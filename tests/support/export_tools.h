// tests/support/export_tools.h: a store to export from, boxes of it, and what their samples and places are,
// by ways that the exporter does not take.
#pragma once

#include "bricking/export/volume_writer.h"
#include "tests/support/bricking_store_tools.h"

#include <cmath>
#include <glm/ext/matrix_transform.hpp>
#include <gtest/gtest.h>
#include <string>
#include <vector>

namespace tessera::test {

/// Another extent, spacing and tilt along each axis, larger than a chunk: a swapped axis or a sign shows.
inline VolumeInfo asymmetricInfo(ValueType type, double slope = 1, double intercept = 0) {
    VolumeInfo info = plainInfo({37, 70, 45}, type);
    glm::dmat4 turn = glm::rotate(glm::dmat4(1), 0.31, glm::dvec3(0.3, -0.2, 0.9));
    turn = glm::rotate(turn, -0.17, glm::dvec3(1, 0.4, 0));
    info.patientFromVoxel = patientFromVoxelOf({-101.3, 17.0 / 3, 0.001}, glm::dvec3(turn[0]) * 0.68,
                                               glm::dvec3(turn[1]) * 0.7421875, glm::dvec3(turn[2]) * 1.25);
    info.rescaleSlope = slope;
    info.rescaleIntercept = intercept;
    info.unit = "HU";
    info.fillStored = 0;
    return info;
}

/// All of a level, and boxes across chunks and at odd places.
inline std::vector<LevelBox> someBoxes(const VolumeInfo& info) {
    return {wholeLevel(info, 0), levelBoxOf(info, 0, {3, 30, 7}, {36, 65, 41}, "--crop-voxels"),
            wholeLevel(info, 1), levelBoxOf(info, 2, {5, 9, 13}, {37, 70, 39}, "--crop-voxels"),
            wholeLevel(info, 5)};
}

/// All of them for stored values that are physical ones; two for others.
inline std::vector<LevelBox> boxesFor(const VolumeInfo& info) {
    const std::vector<LevelBox> all = someBoxes(info);
    return info.rescaleSlope == 1 && info.rescaleIntercept == 0 ? all : std::vector{all[1], all[3]};
}

/// Physical values of a box, [z][y][x], from chunks that are read one by one.
inline std::vector<double> expectedValues(const StoreReader& store, const LevelBox& box) {
    const std::vector<double> all = readLevel(store, box.level);
    const glm::ivec3 extent = levelExtent(store.info().extentVoxels, box.level);
    std::vector<double> values;
    for (int z = box.low.z; z < box.high.z; ++z)
        for (int y = box.low.y; y < box.high.y; ++y)
            for (int x = box.low.x; x < box.high.x; ++x)
                values.push_back(store.info().rescaleSlope * all[linearIndex({x, y, z}, extent)] +
                                 store.info().rescaleIntercept);
    return values;
}

/// Patient space: the middle of the voxels of level 0 that sample `at` of the box stands for.
inline glm::dvec3 expectedCentre(const VolumeInfo& whole, const LevelBox& box, const glm::ivec3& at) {
    const double step = std::ldexp(1.0, box.level);
    const glm::dvec3 first = step * glm::dvec3(box.low + at) + 0.5, last = first + (step - 1);
    return glm::dvec3(whole.patientFromVoxel * glm::dvec4(0.5 * (first + last), 1));
}

/// Of voxel (0,0,0) and of the next ones along each axis.
inline void expectPlace(const VolumeInfo& whole, const LevelBox& box, const std::vector<glm::dvec3>& found,
                        double relative, const std::string& what) {
    const std::vector<glm::ivec3> at = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (std::size_t i = 0; i < at.size(); ++i) {
        const glm::dvec3 expected = expectedCentre(whole, box, at[i]);
        for (int axis = 0; axis < 3; ++axis)
            EXPECT_NEAR(found[i][axis], expected[axis], relative * 102) // mm: the largest coordinate
                << what << " point " << i << " axis " << axis;
    }
}
inline std::vector<glm::dvec3> fourCentres(const VolumeInfo& info) {
    std::vector<glm::dvec3> centres;
    for (const glm::dvec3& at : {glm::dvec3(0, 0, 0), {1, 0, 0}, {0, 1, 0}, {0, 0, 1}})
        centres.emplace_back(info.patientFromVoxel * glm::dvec4(at + 0.5, 1));
    return centres;
}

inline ExportReport exportBox(const std::string& format, const StoreReader& store, const LevelBox& box,
                              const fs::path& out, bool compress = false, std::size_t budget = kPlenty) {
    MemoryBudget ram("RAM", "--ram", budget);
    Progress silent;
    ExportReport report;
    {
        BoxSource source(store, box, ram, 2);
        const ExportFormat& form = exportFormatOf(format, out);
        const bool force = !form.writesFolder; // tests write file after file
        report = form.write(source, {out, compress, force, ram, silent});
    }
    EXPECT_EQ(ram.usedBytes(), 0u);
    EXPECT_LE(ram.peakBytes(), budget);
    return report;
}

struct Rescale {
    double slope, intercept;
};
inline const std::vector<Rescale> kRescales = {{1, 0}, {1, -1024}, {-2, 7}, {0.37, -5.5}};
inline const std::vector<ValueType> kTypes = {ValueType::u8, ValueType::i16, ValueType::u16, ValueType::f32};

/// visit(store, folder, type) of a store of each type and rescale, in a folder of its own.
template <typename Visit> void forEachStoreToExport(const Visit& visit) {
    for (const ValueType type : kTypes)
        for (const Rescale& rescale : kRescales) {
            const ScratchFolder scratch;
            HashSource source(asymmetricInfo(type, rescale.slope, rescale.intercept));
            import(scratch / "v.zarr", source);
            MemoryBudget ram("RAM", "--ram", kPlenty);
            visit(StoreReader(scratch / "v.zarr", ram), scratch, type);
        }
}

} // namespace tessera::test
