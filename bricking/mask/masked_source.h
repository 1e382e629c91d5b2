// bricking/mask/masked_source.h: MaskedSource: a volume whose hidden part reads as one value, air. Everything
// that draws reads it in place of the store; the store and its voxels stay as they are.
#pragma once

#include "bricking/cache/chunk_source.h"
#include "bricking/mask/mask.h"

#include <cstddef>
#include <memory>
#include <span>

namespace tessera {

class MaskedSource : public ChunkSource {
  public:
    /// @param airStored  the value of what is hidden, as stored, of the source's type
    /// @param threads    that read at once; 0: all processors
    /// source must outlive this. Throws InputError if ram cannot hold what reading takes.
    MaskedSource(const ChunkSource& source, std::shared_ptr<const HiddenPart> mask, double airStored,
                 MemoryBudget& ram, int threads);

    const VolumeInfo& info() const override { return source_.info(); }
    /// A sample of share s is v + s * (air - v), rounded to the stored type. Above Mask::kExactLevel a sample
    /// that is hidden in part is the mean of those below it, so that no sample leaves the range of its cells.
    void readChunk(const ChunkKey& key, std::span<std::byte> out) const override;
    void willRead(std::span<const ChunkKey> keys) const override { source_.willRead(keys); }

    const HiddenPart& mask() const { return *mask_; }
    double airStored() const { return air_; }

  private:
    const ChunkSource& source_;
    std::shared_ptr<const HiddenPart> mask_;
    double air_;
    Charge scratch_;
};

} // namespace tessera
