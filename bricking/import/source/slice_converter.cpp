// bricking/import/source/slice_converter.cpp: see slice_converter.h.
#include "bricking/import/source/slice_converter.h"

#include <utility>

namespace tessera {

SliceConverter::SliceConverter(FileType type, bool bigEndian, VisitVoxels visitAll)
    : type_(type), bigEndian_(bigEndian), visitAll_(std::move(visitAll)) {}

void SliceConverter::convert(std::span<const std::byte> in, std::span<std::byte> out, VolumeInfo& info) {
    VoxelCounts counts;
    storeVoxels(type_, bigEndian_, in, info.absentStored, out, counts);
    if (counts.nonFinite > 0 && info.nonFiniteVoxels == 0) {
        findLowest(info);
        counts = {};
        storeVoxels(type_, bigEndian_, in, info.absentStored, out, counts);
    }
    info.nonFiniteVoxels += counts.nonFinite;
    info.clampedVoxels += counts.clamped;
    rounded_ += counts.rounded;
    const bool isBare = info.rescaleSlope == 1 && info.rescaleIntercept == 0 && info.unit.empty();
    if (!isBare)
        return;
    labels_.add(out, info.type);
    converted_ += out.size() / bytesPerValue(info.type);
    if (converted_ != info.voxelCount())
        return;
    if (std::string remark = labels_.remark(); !remark.empty())
        info.remarks.push_back(std::move(remark));
}

std::vector<std::string> SliceConverter::notes() const {
    if (rounded_ == 0)
        return {};
    return {std::to_string(rounded_) +
            " whole numbers beyond 2^24 rounded to float32: labels may have become one"};
}

void SliceConverter::findLowest(VolumeInfo& info) const {
    ValueRange range;
    visitAll_([&](std::span<const std::byte> voxels) { widen(range, type_, bigEndian_, voxels); });
    // A negative slope turns the data over: its lowest physical value is the highest stored one.
    info.absentStored = range.isEmpty() ? info.fillStored : info.rescaleSlope < 0 ? range.most : range.least;
}

} // namespace tessera
