// bricking/import/labels/nrrd/nrrd_segments.h: the segments that 3D Slicer describes in the header of a
// .seg.nrrd file. Private to the NRRD reader.
#pragma once

#include "bricking/labels/label_table.h"

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace tessera {

struct NrrdSegments {
    std::vector<Label> labels; // ascending by value; empty: the header describes none
    /// Of each layer the labels of its numbers, where described: numbers of different layers may be equal,
    /// values of labels are not.
    std::vector<std::map<std::uint32_t, std::uint32_t>> layers;
    std::vector<std::string> notes;
};

/// From the pairs SegmentN_Name, _LabelValue, _Layer, _Color, _Tags. Without a layer, segment N has layer N
/// where there are several; without a number it has 1 (files of older versions). Numbers that several layers
/// use are replaced by free ones. Throws InputError naming `where` for a number, layer or colour that is
/// none, and for two segments of one number in one layer.
NrrdSegments nrrdSegmentsOf(const std::map<std::string, std::string>& pairs, int layers,
                            const std::string& where);

} // namespace tessera
