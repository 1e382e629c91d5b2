// bricking/import/source/label_tally.h: a test for label maps: volumes whose values name regions instead of
// measuring. Such a volume has few whole numbers, and each fills neighbouring voxels.
#pragma once

#include "core/base/volume.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace tessera {

/// Beginning of the remark on such a volume.
inline constexpr const char* kLabelMapRemark = "looks like a label map";

class LabelTally {
  public:
    /// Stored values in the order of the volume. Nearly free once there are too many values.
    void add(std::span<const std::byte> stored, ValueType type);
    /// After the last voxel: "looks like a label map (43 whole values, 0 to 117): ..."; "" for other data.
    std::string remark() const;

  private:
    static constexpr std::size_t kMostLabels = 256;
    void see(double value);

    std::array<double, kMostLabels> values_{}; // ascending
    std::size_t count_ = 0;
    bool isOther_ = false; // too many values, or a value that is no label
    std::uint64_t voxels_ = 0, inside_ = 0,
                  edges_ = 0; // inside: above 0; edges: those of them unlike the one before
    double before_ = 0;
};

} // namespace tessera
