// bricking/labels/label_volume.cpp: see label_volume.h.
#include "bricking/labels/label_volume.h"

#include "bricking/labels/label_files.h"
#include "core/base/dicom_uid.h"
#include "core/base/error.h"

#include <algorithm>
#include <glm/common.hpp>
#include <glm/matrix.hpp>
#include <string>
#include <utility>

namespace tessera {

bool isSameGrid(const VolumeInfo& a, const VolumeInfo& b) {
    if (a.extentVoxels != b.extentVoxels)
        return false;
    const glm::dmat4 bFromA = glm::inverse(b.patientFromVoxel) * a.patientFromVoxel;
    for (int i = 0; i < 8; ++i) {
        const glm::dvec3 corner = glm::dvec3(a.extentVoxels) * glm::dvec3(i & 1, i >> 1 & 1, i >> 2);
        const glm::dvec3 off = glm::abs(glm::dvec3(bFromA * glm::dvec4(corner, 1)) - corner);
        if (!(std::max({off.x, off.y, off.z}) <= kSameVoxels))
            return false;
    }
    return true;
}

namespace {

std::string extentOf(const VolumeInfo& info) {
    const glm::ivec3& e = info.extentVoxels;
    return std::to_string(e.x) + " x " + std::to_string(e.y) + " x " + std::to_string(e.z) + " voxels";
}

} // namespace

void requireSameGrid(const StoreReader& labels, const VolumeInfo& volume) {
    if (!isSameGrid(labels.info(), volume))
        throw badFile(labels.path().string(), "labels on the volume's grid of " + extentOf(volume),
                      extentOf(labels.info()) + " in size or place of their own");
}

void requireSameFrame(const std::string& frame, const VolumeInfo& scan, const std::string& where) {
    if (areFramesApart(frame, scan.frameOfReference))
        throw badFile(where, "the scan's frame of reference, " + scan.frameOfReference,
                      frame + ": its positions may be of another patient or study; --same-frame "
                              "(labels.sameFrame) takes it for the scan's");
}

LabelVolume::LabelVolume(const std::filesystem::path& store, MemoryBudget& ram) : voxels_(store, ram) {
    LabelFiles files = readLabelFiles(voxels_, ram);
    table_ = std::move(files.table);
    cells_ = std::move(files.cells);
}

} // namespace tessera
