// tests/support/bricking_selection_tools.h: tools that the tests of selection share: random errors and views,
// a sheared volume, and predictions for a volume that a formula gives.
#pragma once

#include "bricking/levels/level_selection.h"
#include "bricking/statistics/brick_rays.h"
#include "tests/support/bricking_test_volumes.h"

namespace tessera::test {

/// In [0,1), by a hash.
inline double uniform(std::uint64_t seed) {
    return static_cast<double>(mixed(seed * 0x9E3779B97F4A7C15u + 1) >> 11) * 0x1p-53;
}

/// Errors that fall with finer levels by random factors; every fifth brick shows nothing.
inline LevelErrors randomErrors(const glm::ivec3& bricks, std::uint64_t seed, bool withEmpty = true) {
    LevelErrors e;
    e.bricks = bricks;
    for (std::size_t b = 0; b < cellCount(bricks); ++b) {
        e.shows.push_back(withEmpty && mixed(seed + b) % 5 == 0 ? 0 : 1);
        std::array<float, kLevelCount> errors{};
        double error = 0;
        for (std::size_t level = 1; level < kLevelCount; ++level)
            errors[level] = static_cast<float>(error += 4 * uniform(seed + 100 * b + level));
        e.errors.push_back(e.shows.back() ? errors : std::array<float, kLevelCount>{});
    }
    return e;
}
inline ViewWeights plainWeights(const glm::ivec3& bricks, std::uint64_t seed) {
    ViewWeights w;
    w.bricks = bricks;
    w.pixels = 1000;
    for (std::size_t b = 0; b < cellCount(bricks); ++b) {
        w.area.push_back(static_cast<float>(uniform(seed + b)) * 100);
        w.finest.push_back(static_cast<std::uint8_t>(mixed(seed + b) % 3));
    }
    return w;
}
inline VolumeInfo shearedInfo() {
    VolumeInfo info = plainInfo({150, 100, 75}, ValueType::i16);
    info.patientFromVoxel =
        patientFromVoxelOf({-60, -40, -30}, {0.9, 0.1, 0}, {-0.2, 0.8, 0.1}, {0.3, 0, 1.4});
    return info;
}

/// Patient millimetres are voxels, so that cameras and lengths can be given in voxels.
inline VolumeInfo unitInfo(const glm::ivec3& extent) {
    VolumeInfo info = plainInfo(extent, ValueType::u8);
    info.patientFromVoxel = patientFromVoxelOf({0.5, 0.5, 0.5}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1});
    return info;
}

/// White, and as dense as extinctionPerMm where values are above 150; nothing below 120.
inline TransferTable whiteAbove150(double extinctionPerMm) {
    return makeTable(TransferFunction::fromExtinction(
        {{0, 0}, {120, 0}, {150, extinctionPerMm}, {255, extinctionPerMm}}, {{0, glm::dvec3(1)}}));
}

/// Errors as the sampled rays give them, not smoothed, of a volume of unitInfo(): from its store, as a
/// picture gets them.
/// @param parts  of kBrickRayParts
inline LevelErrors predictedOf(const glm::ivec3& extent, const HashSource::Formula& value,
                               const TransferTable& table, int parts = kBrickRayParts) {
    const ScratchFolder scratch;
    const VolumeInfo info = unitInfo(extent);
    HashSource source(info, value);
    MemoryBudget ram("RAM", "--ram", std::size_t{256} << 20);
    ImportOptions options;
    options.durable = false;
    importToStore(source, scratch / "v.zarr", ram, options);
    const StoreReader store(scratch / "v.zarr", ram);
    std::vector<std::uint8_t> shows;
    for (const std::uint8_t level :
         cullBricks(loadStatistics(store, ram, 1), table, info, 0, Culling::unlit).levels)
        shows.push_back(level == Selection::kEmpty ? 0 : 1);
    BrickRays rays = noBrickRays(info, parts, ram);
    addBrickRays(store, shows, rays, ram);
    return rayErrors(rays, shows, table, info);
}

} // namespace tessera::test
