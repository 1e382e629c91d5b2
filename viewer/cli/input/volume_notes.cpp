// viewer/cli/input/volume_notes.cpp: see volume_notes.h.
#include "viewer/cli/input/volume_notes.h"

#include "bricking/import/source/slice_converter.h" // kLabelMapRemark
#include "viewer/cli/options/options.h"             // formatNumber

namespace tessera {

std::string sayAbsent(const VolumeInfo& info) {
    const double value = info.rescaleSlope * info.absentStored + info.rescaleIntercept;
    return std::to_string(info.nonFiniteVoxels) +
           " voxels without a number (NaN or infinite), stored as the lowest value, " +
           formatNumber(value, 6) + (info.unit.empty() ? "" : " " + info.unit);
}

std::string sayLoss(const VolumeInfo& info) {
    return info.lossyRatio > 0 ? "with loss, ratio " + formatNumber(info.lossyRatio) + " as the header says"
                               : "with loss";
}

std::string sayLabels(const VolumeInfo& info) {
    for (const std::string& remark : info.remarks)
        if (remark.rfind(kLabelMapRemark, 0) == 0)
            return remark;
    return "";
}

std::vector<std::string> sayChanges(const VolumeInfo& info) {
    std::vector<std::string> lines;
    if (info.lossy)
        lines.push_back("the source was compressed " + sayLoss(info));
    if (info.nonFiniteVoxels)
        lines.push_back(sayAbsent(info));
    if (info.clampedVoxels)
        lines.push_back(std::to_string(info.clampedVoxels) +
                        " voxels clamped to the range that can be stored");
    return lines;
}

} // namespace tessera
