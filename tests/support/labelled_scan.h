// tests/support/labelled_scan.h: a scan on disk with a file of labels beside it: boxes side by side, of which
// a picture from the front shows all.
#pragma once

#include "bricking/import/importer.h"
#include "core/base/brick.h"
#include "core/base/program_folders.h"
#include "core/scene/scene.h"
#include "tests/support/formula_source.h"

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <string>
#include <utility>
#include <vector>

namespace tessera::test {

/// Tissue of 400 behind y = 14 voxels, and columns of labels in it from y = 16.
class LabelledScan {
  public:
    static constexpr glm::ivec3 kExtent{60, 40, 36};
    /// @param labels  values and names, each a column along z, from left to right; none has voxels behind the
    ///     first `columns`
    LabelledScan(const std::vector<std::pair<std::uint32_t, std::string>>& labels, int columns)
        : store(folder_ / "scan.zarr"), file(folder_ / "labels.seg.nrrd") {
        ::setenv("XDG_CACHE_HOME", (folder_ / "cache").c_str(), 1);
        info.extentVoxels = kExtent;
        info.type = ValueType::i16;
        info.patientFromVoxel = glm::dmat4(2);
        info.patientFromVoxel[3] = {-11, 7, 5, 1};
        FormulaSource source(info, [](const glm::dvec3& p) { return p.y > 14 ? 400.0 : 0.0; });
        MemoryBudget ram("RAM", "--ram", std::size_t{256} << 20);
        importToStore(source, store, ram, {});
        width_ = kExtent.x / columns;
        std::string voxels(2 * cellCount(kExtent), '\0');
        for (int z = 2; z < kExtent.z - 2; ++z)
            for (int y = 16; y < 26; ++y)
                for (int x = 0; x < width_ * columns; ++x)
                    if (x % width_ != 0 || width_ == 1) {
                        const auto value =
                            static_cast<std::uint16_t>(labels[static_cast<std::size_t>(x / width_)].first);
                        std::memcpy(&voxels[2 * linearIndex({x, y, z}, kExtent)], &value, 2);
                    }
        std::ofstream out(file, std::ios::binary);
        out << "NRRD0004\ntype: unsigned short\ndimension: 3\nspace: left-posterior-superior\nsizes: "
            << kExtent.x << " " << kExtent.y << " " << kExtent.z
            << "\nspace directions: (2,0,0) (0,2,0) (0,0,2)\nkinds: domain domain domain\nendian: little\n"
               "encoding: raw\nspace origin: (-10,8,6)\n";
        for (std::size_t n = 0; n < labels.size(); ++n)
            for (const auto& [key, value] :
                 {std::pair<std::string, std::string>{"ID", "s" + std::to_string(n)},
                  {"Name", labels[n].second},
                  {"LabelValue", std::to_string(labels[n].first)},
                  {"Layer", "0"}})
                out << "Segment" << n << "_" << key << ":=" << value << "\n";
        out << "\n" << voxels;
    }
    /// The middle of a column, in level-0 voxels, at its front.
    glm::dvec3 column(int number) const { return {width_ * (number + 0.5) + 0.5, 16.5, kExtent.z / 2.0}; }
    /// A scene file with these labels: seen from the front, without light, and little of the tissue.
    std::filesystem::path scene(const glm::ivec2& size) const {
        Scene scene;
        scene.volumes = {
            {store, TransferFunction::fromOpacity({{200, 0}, {300, 0.02}}, {{200, {1, 1, 1}}}, 1)}};
        scene.volumes[0].labels.path = file;
        scene.imageSize = size;
        scene.camera = fitCamera(info, View::anterior, Projection::parallel, size);
        scene.shading.on = false;
        std::ofstream(folder_ / "scene.json") << sceneJson(scene);
        return folder_ / "scene.json";
    }

  private:
    const ScratchFolder folder_;
    int width_ = 1;

  public:
    VolumeInfo info;
    const std::filesystem::path store, file;
};

} // namespace tessera::test
