// bricking/import/files/file_reading.h: the two ways in which single files are read: uncompressed voxels by
// position, others in one forward pass.
#pragma once

#include "bricking/import/source/slab_source.h"
#include "bricking/import/source/slice_converter.h"
#include "bricking/import/source/source_files.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

namespace tessera {

// Uncompressed voxels in one file, [z][y][x] with x fastest, for raw files and uncompressed NIfTI files.

/// Position and type of the voxels.
struct VoxelLayout {
    FileType type = FileType::i16;
    bool bigEndian = false;
    std::uint64_t offsetBytes = 0;
    std::uint64_t sliceStep = 1; // of slices in the file, from one of the volume to the next
};

/// Bytes that the voxels take in the file; info.validate() must have passed.
std::uint64_t voxelBytesInFile(const VolumeInfo& info, FileType type);

/// The caller has checked that the file is long enough; info.type is storedTypeOf(layout.type).
std::unique_ptr<SlabSource> makePlainFileSource(InputFile file, const VolumeInfo& info,
                                                const VoxelLayout& layout, std::string description);

// One forward pass over a gzip file, with bounded memory; every damage is reported.

class GzipStream {
  public:
    enum class Wrapper : std::uint8_t { gzip, any }; // any: zlib's too (RFC 1950), told by its first bytes
    /// @param offsetBytes  of the first gzip member in the file
    explicit GzipStream(InputFile file, std::uint64_t offsetBytes = 0, Wrapper wrapper = Wrapper::gzip);
    ~GzipStream();
    GzipStream(GzipStream&&) noexcept;

    const InputFile& file() const;
    /// Fills out with the next decompressed bytes. Throws InputError naming the file if it is damaged (bad
    /// block, wrong checksum) or ends before.
    void read(std::span<std::byte> out);
    /// Skips to the end of the current member, so that its checksum is compared; returns the number of bytes
    /// skipped. Throws InputError as read() does.
    std::uint64_t finish();

  private:
    bool inflateStep(std::span<std::byte> out, std::size_t& done);
    struct State;
    std::unique_ptr<State> state_;
};

// Voxels of any file that is read forward.

class VoxelStream {
  public:
    virtual ~VoxelStream() = default;
    /// The next voxels as they are in the file. Throws InputError naming the file for damage and at its end.
    virtual void read(std::span<std::byte> out) = 0;
    /// After the last voxel: throws InputError naming the file for more voxels and for a wrong checksum.
    virtual void finish() = 0;
};

/// @param open  begins with the first voxel; called again where a second pass is needed
/// @param info  its type is storedTypeOf(type)
std::unique_ptr<SlabSource> makeForwardFileSource(std::function<std::unique_ptr<VoxelStream>()> open,
                                                  const VolumeInfo& info, FileType type, bool bigEndian,
                                                  std::string description);

} // namespace tessera
