// bricking/labels/label_source.h: a segmentation as its files have it: layers of label values, each on a grid
// of its own. Layers may overlap; within a layer a voxel has one value.
#pragma once

#include "bricking/labels/label_table.h"
#include "core/base/volume.h"

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace tessera {

class LabelLayer {
  public:
    virtual ~LabelLayer() = default;
    /// Extent and affine, in any order of axes; type and rescale have no meaning here.
    virtual const VolumeInfo& info() const = 0;
    /// Reads the next `count` slices, z ascending: [z][y][x] label values, 0 for none.
    /// Throws InputError naming the file for truncated or damaged data, and for values that are no labels.
    virtual void readSlices(int count, std::span<std::uint32_t> out) = 0;
    /// True if it shares nothing with other layers: they may then be read at the same time by other threads.
    virtual bool isAlone() const { return false; }
    /// False for numbers of a type with fractions, or scaled ones: a scan may have such values, too.
    virtual bool hasWholeType() const { return true; }
    /// Memory that readSlices() takes besides `out` and what every open file takes.
    virtual std::size_t bytesToRead() const { return 0; }
    /// Findings of reading that a user should know, one a line; complete after the last slice.
    virtual std::vector<std::string> notes() const { return {}; }
};

struct LabelFile {
    std::vector<std::unique_ptr<LabelLayer>> layers; // at least one
    /// Labels that the file describes; values that occur without one get a name by their number. A layer of a
    /// mask holds the value of one of these.
    std::vector<Label> labels;
    std::string frameOfReference;   // DICOM UID; "" unknown
    std::vector<std::string> notes; // findings that a user should know, one a line
    /// The layers have no place of their own: their voxels are the scan's, and their extents must be. Their
    /// axes are those of a store's arrays; what their affines say means nothing.
    bool isOnScan = false;
    std::string shown = {}; // the path, for messages; openLabels() tells it
};

} // namespace tessera
