// bricking/import/source/voxel_tally.h: what a volume's voxels tell of it, beyond the counts of VolumeInfo.
// Tallies of parts of a volume are added; neither their order nor how a volume is cut into rows has a say.
#pragma once

#include "core/base/volume.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace tessera {

/// Beginning of the remark on a label map.
inline constexpr const char* kLabelMapRemark = "looks like a label map";

/// A test for label maps: volumes whose values name regions instead of measuring. Such a volume has few whole
/// numbers, and each fills neighbouring voxels.
struct LabelTally {
    std::vector<double> values; // ascending
    bool isOther = false;       // too many values, or a value that is no label
    std::uint64_t voxels = 0, inside = 0,
                  edges = 0; // inside: above 0, with one before in their row; edges: those of them unlike it

    /// Stored values of whole rows, in any order. Nearly free once there are too many values.
    /// @param rowValues  of a row
    void add(std::span<const std::byte> stored, ValueType type, std::size_t rowValues);
    /// Of another part.
    void add(const LabelTally& part);
    /// "looks like a label map (43 whole values, 0 to 117): ..."; "" for other data.
    std::string remark() const;

  private:
    void see(double value);
};

/// What values lost that float32 cannot hold exactly.
struct RoundingTally {
    std::uint64_t whole = 0, real = 0; // values that changed: whole numbers, and those of type float64
    double most = 0;                   // the largest change, physical units
    double mostPart = 0;               // the largest share of a value that its change was

    bool any() const { return whole + real > 0; }
    void add(const RoundingTally& part);
    /// "values are kept as float32, which changed 12 of them: the largest change is 3e-05, 1 in 2^24 of the
    /// value"; "" where nothing changed.
    std::string note() const;
    bool operator==(const RoundingTally&) const = default;
};

struct VoxelTally {
    LabelTally labels;
    RoundingTally rounded;
    void add(const VoxelTally& part);
    /// The remark on labels, and a loss that VolumeInfo does not count, a line each.
    std::vector<std::string> notes() const;
};

} // namespace tessera
