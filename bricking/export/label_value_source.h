// bricking/export/label_value_source.h: a volume of labels whose voxels are the labels' own values, not
// numbers of sets.
#pragma once

#include "bricking/cache/chunk_source.h"
#include "bricking/labels/label_table.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace tessera {

class LabelValueSource final : public ChunkSource {
  public:
    /// @param sets  voxels of a label volume (bricking/labels/label_volume.h); it must outlive this
    /// @param where  the labels, for messages
    /// Throws InputError naming them where labels overlap, or have values above 65535.
    LabelValueSource(const ChunkSource& sets, const LabelTable& table, const std::string& where);

    /// uint8, or uint16 for values above 255; 0 is no label.
    const VolumeInfo& info() const override { return info_; }
    void readChunk(const ChunkKey& key, std::span<std::byte> out) const override;

  private:
    const ChunkSource& sets_;
    VolumeInfo info_;
    std::vector<std::uint16_t> values_; // of every set
};

} // namespace tessera
