// bricking/import/file_part.cpp: see file_part.h.
#include "bricking/import/file_part.h"

#include "bricking/import/source/cropped_source.h"
#include "bricking/import/source/oriented_source.h"
#include "core/base/error.h"

#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <glm/common.hpp>
#include <glm/matrix.hpp>
#include <utility>
#include <vector>

namespace tessera {
namespace {

std::string boxText(const FileBox& box) {
    std::string text;
    for (int axis = 0; axis < 3; ++axis)
        text += (axis ? "," : "") + std::to_string(box.low[axis]) + "," + std::to_string(box.high[axis]);
    return text;
}

/// Where a level's transformation does not put it over the finest one. Halving leaves half a voxel of its
/// where a level begins (files that leave out the translation), and one where it ends (odd extents).
std::vector<std::string> remarksOn(const VolumeInfo& level, const VolumeInfo& finest, int number) {
    constexpr double kMostAtBegin = 0.5 + 1e-6, kMostAtEnd = 1 + 1e-6; // voxels
    const glm::dmat4 levelFromFinest = glm::inverse(level.patientFromVoxel) * finest.patientFromVoxel;
    bool isOver = true;
    double most = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 side(corner & 1, corner >> 1 & 1, corner >> 2 & 1);
        const glm::dvec3 apart =
            glm::abs(glm::dvec3(levelFromFinest * glm::dvec4(side * glm::dvec3(finest.extentVoxels), 1)) -
                     side * glm::dvec3(level.extentVoxels));
        for (int axis = 0; axis < 3; ++axis) {
            most = std::max(most, apart[axis]);
            isOver = isOver && apart[axis] <= (side[axis] > 0 ? kMostAtEnd : kMostAtBegin);
        }
    }
    if (isOver)
        return {};
    char shown[32];
    std::snprintf(shown, sizeof shown, "%.3g", most);
    return {"by its transformation, level " + std::to_string(number) +
            " of the file does not lie over the finest one: their boxes are up to " + shown +
            " of its voxels apart"};
}

} // namespace

SourceOptions finestOf(const SourceOptions& options) {
    SourceOptions finest = options;
    finest.fileLevel = 0;
    finest.fileBox.reset();
    return finest;
}

std::unique_ptr<SlabSource>
openFilePart(const std::function<std::unique_ptr<SlabSource>(const SourceOptions&)>& open,
             const SourceOptions& options, const std::string& where) {
    std::unique_ptr<SlabSource> source = open(finestOf(options));
    if (options.fileLevel == 0 && !options.fileBox)
        return source;
    const VolumeInfo finest = source->info();
    FilePart part;
    part.level = options.fileLevel;
    std::vector<std::string> remarks;
    if (part.level > 0) {
        const std::size_t levels = source->fileLevels().size();
        if (levels == 1)
            throw badFile(where, "a file of several levels (OME-Zarr, Imaris) for --file-level",
                          "one that has its volume at one alone");
        if (static_cast<std::size_t>(part.level) >= levels)
            throw badFile(where, "--file-level from 0 (finest) to " + std::to_string(levels - 1),
                          std::to_string(part.level));
        SourceOptions one = finestOf(options);
        one.fileLevel = part.level;
        source = open(one);
        remarks = remarksOn(source->info(), finest, part.level);
    }
    const VolumeInfo level = orientedInfo(source->info());
    const glm::ivec3 extent = level.extentVoxels;
    part.finestVoxels = orientedInfo(finest).extentVoxels;
    part.levelVoxels = extent;
    part.box = options.fileBox.value_or(FileBox{glm::ivec3(0), extent});
    for (int axis = 0; axis < 3; ++axis)
        if (part.box.low[axis] < 0 || part.box.low[axis] >= part.box.high[axis] ||
            part.box.high[axis] > extent[axis])
            throw badFile(where,
                          "--file-box within " + boxText({glm::ivec3(0), extent}) + " (voxels of level " +
                              std::to_string(part.level) + ")",
                          boxText(part.box));
    return cropSource(std::move(source), alongSourceAxes(level, part.box), part, std::move(remarks));
}

} // namespace tessera
