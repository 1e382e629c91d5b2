// bricking/import/source/slab_source.h: SlabSource, the interface of every importer: a volume's description,
// then its slices, forward only. Files, series and phantoms share it, so a volume never has to fit in memory.
#pragma once

#include "bricking/import/source/voxel_tally.h"
#include "core/base/error.h"
#include "core/base/volume.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace tessera {

/// The user's options for opening source files.
struct SourceOptions {
    int series = 0; // DICOM: 1-based number from the list; 0: the only volume, or refuse with the list
    /// Uneven slices, and those missing from stacks of pictures, are interpolated to an even spacing.
    bool resampleZ = false;
    /// Folder for spooled data if the slowest axis changes; "": the folder for temporary files.
    std::filesystem::path scratchFolder = {};
    bool largest = false;      // of several volumes the largest CT, or the largest if there is no CT
    int phase = 0;             // DICOM: 1-based, of a series with several images at each position; 0: none
    bool allowMissing = false; // DICOM: files that could be slices and cannot be read are left out
    /// Of files that do not say it: distances of voxels' centres along the file's x, y, z, mm.
    std::optional<glm::dvec3> spacingMm = {};
    int fileLevel = 0;                   // of a file of several levels; 0: the finest
    std::optional<FileBox> fileBox = {}; // of that level, its axes in nearest LPS order; none: all
};

/// How a source gives rows of slices without a whole one in memory.
enum class RowAccess : std::uint8_t {
    none,    // whole slices only
    inOrder, // forward only: each behind the one before, from the first row of a slice on
    any      // in any order
};

class SlabSource {
  public:
    virtual ~SlabSource() = default;
    /// Complete from the start, except for values from voxels, which are final after the last slice:
    /// nonFiniteVoxels, absentStored, clampedVoxels, lossy.
    virtual const VolumeInfo& info() const = 0;
    /// Reads the next `count` slices (z ascending) into out: [z][y][x], x fastest, little-endian stored
    /// values. out.size() == count * extent.y * extent.x * bytesPerValue. Throws InputError naming the file
    /// on truncated or damaged data. Non-finite values arrive already replaced by absentStored.
    virtual void readSlices(int count, std::span<std::byte> out) = 0;
    /// Goes on with slice z. What a slice told is counted where the slice before it was read too, as in one
    /// pass from the first slice.
    /// @return false: it can only read on
    virtual bool seek(int z) {
        static_cast<void>(z);
        return false;
    }
    virtual RowAccess rowAccess() const { return RowAccess::none; }
    /// Reads rows [first, first + count) of slice z into out: [y][x], otherwise as readSlices(). In order: of
    /// the slice that comes next, behind the rows before; of any order: each row once, or counts repeat, and
    /// without a say in what comes next.
    virtual void readRows(int z, int first, int count, std::span<std::byte> out) {
        static_cast<void>(z), static_cast<void>(first), static_cast<void>(count), static_cast<void>(out);
        TESSERA_CHECK(rowAccess() != RowAccess::none);
    }
    /// Rows that come together: readRows() takes whole units, fewer rows at the end of a slice only.
    virtual int rowUnit() const { return 1; }
    /// Threads that reading several slices may take; 0: all processors. One where it is never called.
    virtual void setThreads(int threads) { static_cast<void>(threads); }
    /// Memory beside `out` that grows with a slice.
    virtual std::size_t roomBytes() const { return 0; }
    /// The levels of a file that has its volume at several resolutions, finest first, as info() has them
    /// where they are opened (SourceOptions::fileLevel); one: it has no others. Reads headers. Throws
    /// InputError as opening a level does.
    virtual std::vector<VolumeInfo> fileLevels() const { return {info()}; }
    /// Becomes the source of a box of its voxels (croppedInfo()), and reads no chunk outside of it. Before
    /// the first slice is read.
    /// @return false: it cannot (CroppedSource does it for any source)
    virtual bool crop(const FileBox& box) {
        static_cast<void>(box);
        return false;
    }
    /// Of the slices read since the last call.
    virtual VoxelTally takeTally() { return {}; }
    /// One line for people: "134 DICOM slices, series 2". Never a patient identifier.
    virtual std::string describe() const = 0;
    /// Findings of reading that a user should know, one per line: remarks, and what takeTally() does not
    /// tell. Complete after the last slice.
    virtual std::vector<std::string> notes() const { return info().remarks; }
};

/// A SlabSource whose slices can be read in any order. A reversed slice axis is then free. Files that can
/// only be read forward (gzip) are not of this kind.
class RandomSlabSource : public SlabSource {
  public:
    /// Reads slice z, 0 <= z < extent.z, into out: [y][x]. Each slice must be read once, or counts repeat.
    virtual void readSliceAt(int z, std::span<std::byte> out) = 0;

    void readSlices(int count, std::span<std::byte> out) final {
        TESSERA_CHECK(count >= 0 && next_ + count <= info().extentVoxels.z);
        readSlicesAt(next_, count, out);
        next_ += count;
    }
    bool seek(int z) final {
        TESSERA_CHECK(z >= 0 && z <= info().extentVoxels.z);
        next_ = z;
        return true;
    }

  protected:
    /// As readSliceAt(), of several.
    virtual void readSlicesAt(int first, int count, std::span<std::byte> out) {
        const std::size_t sliceBytes = count == 0 ? 0 : out.size() / static_cast<std::size_t>(count);
        for (int i = 0; i < count; ++i)
            readSliceAt(first + i, out.subspan(static_cast<std::size_t>(i) * sliceBytes, sliceBytes));
    }

  private:
    int next_ = 0;
};

/// Of a box within a volume: its extent and place.
inline VolumeInfo croppedInfo(VolumeInfo info, const FileBox& box) {
    info.extentVoxels = box.high - box.low;
    info.patientFromVoxel[3] = info.patientFromVoxel * glm::dvec4(box.low, 1);
    return info;
}

/// Bytes of one row of stored values, and of one slice.
inline std::size_t rowBytesOf(const VolumeInfo& info) {
    return static_cast<std::size_t>(info.extentVoxels.x) * bytesPerValue(info.type);
}
inline std::size_t sliceBytesOf(const VolumeInfo& info) {
    return rowBytesOf(info) * static_cast<std::size_t>(info.extentVoxels.y);
}

} // namespace tessera
