// tests/support/labelled.h: scenes with labels for the image tests: balls of labels in a volume, some thin
// and some overlapping.
#pragma once

#include "tests/support/label_tools.h"
#include "tests/support/scene_fixture.h"

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace tessera::test {

/// Balls with four values that overlap in a second layer, a rod one voxel thick, and a lone voxel.
class BallsOfLabels {
  public:
    explicit BallsOfLabels(const VolumeInfo& scan, unsigned seed = 5) : store(folder_ / "labels.zarr") {
        const glm::ivec3 e = scan.extentVoxels;
        HeldLayer balls(scan, blobs(e, {1, 2, 3, 40}, seed)), more(scan, blobs(e, {7}, seed + 1, 2));
        for (int z = 0; z < e.z; ++z)
            balls.values[linearIndex({e.x / 2, e.y / 3, z}, e)] = 5;
        balls.values[linearIndex({e.x / 3, e.y / 2, e.z / 2}, e)] = 6;
        LabelFile file = fileOf({balls, more}, {{1, "one"}, {2, "two", "pair"}, {3, "three", "pair"}});
        MemoryBudget ram("RAM", "--ram", std::size_t{512} << 20);
        importLabels(file, scan, store, ram, quickly());
    }

  private:
    const ScratchFolder folder_;

  public:
    const std::filesystem::path store;
};

/// All bricks at level 0, whatever shows of them.
inline Selection atLevel0(Selection selection) {
    std::fill(selection.levels.begin(), selection.levels.end(), std::uint8_t{0});
    selection.counts = {};
    selection.counts[0] = selection.levels.size();
    return selection;
}

inline void label(Scene& scene, const std::filesystem::path& store, LabelLook look = LabelLook::solid) {
    Labels& labels = scene.volumes[0].labels;
    labels.path = labels.store = store;
    labels.look = look;
}

} // namespace tessera::test
