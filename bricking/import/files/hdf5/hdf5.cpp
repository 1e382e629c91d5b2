// bricking/import/files/hdf5/hdf5.cpp: sets of numbers with three axes or more in HDF5 files, as slices. The
// file's structures are walked over and read here, not by the library: damaged ones crash it, or make it take
// as much memory as they say.
#include "bricking/import/files/file_format.h"
#include "bricking/import/files/hdf5/h5_slices.h"
#include "bricking/import/files/hdf5/h5_volumes.h"
#include "bricking/import/source/plausible.h"
#include "bricking/import/source/slice_converter.h"
#include "core/base/error.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <system_error>
#include <utility>

namespace tessera {
namespace {

namespace fs = std::filesystem;

class Hdf5Source final : public RandomSlabSource {
  public:
    /// @param levels  what fileLevels() returns
    Hdf5Source(std::unique_ptr<H5File> file, const H5Set& set, const H5VolumePlace& place, VolumeInfo info,
               std::string description, const fs::path& scratch,
               std::function<std::vector<VolumeInfo>(const H5File&)> levels)
        : file_(std::move(file)), set_(set), place_(place), info_(std::move(info)),
          description_(std::move(description)), scratch_(scratch), levels_(std::move(levels)),
          slices_(std::in_place, *file_, set_, place_, scratch_),
          converter_(slices_->type(), slices_->isBigEndian(), [this](const auto& visit) {
              H5Slices again(*file_, set_, place_, scratch_);
              std::vector<std::byte> slice(again.sliceBytes());
              for (int z = 0; z < info_.extentVoxels.z; ++z) {
                  again.readSlice(static_cast<std::uint64_t>(z), slice);
                  visit(slice);
              }
          }) {}

    std::vector<VolumeInfo> fileLevels() const override { return levels_(*file_); }
    bool crop(const FileBox& box) override {
        info_ = croppedInfo(info_, box);
        for (int axis = 0; axis < 3; ++axis) { // z, y, x
            const auto n = static_cast<std::size_t>(2 - axis);
            place_.first[n] += static_cast<std::uint64_t>(box.low[axis]);
            place_.extents[n] = static_cast<std::uint64_t>(info_.extentVoxels[axis]);
        }
        slices_.emplace(*file_, set_, place_, scratch_);
        return true;
    }
    const VolumeInfo& info() const override { return info_; }
    std::string describe() const override { return description_; }
    VoxelTally takeTally() override { return converter_.takeTally(); }

    void readSliceAt(int z, std::span<std::byte> out) override {
        TESSERA_CHECK(z >= 0 && z < info_.extentVoxels.z && out.size() == sliceBytesOf(info_));
        slice_.resize(slices_->sliceBytes());
        slices_->readSlice(static_cast<std::uint64_t>(z), slice_);
        converter_.convert(slice_, out, info_);
    }

  private:
    std::unique_ptr<H5File> file_;
    H5Set set_;
    H5VolumePlace place_;
    VolumeInfo info_;
    std::string description_;
    fs::path scratch_;
    std::function<std::vector<VolumeInfo>(const H5File&)> levels_;
    std::optional<H5Slices> slices_;
    SliceConverter converter_;
    std::vector<std::byte> slice_; // in the file's numbers
};

/// Those of the file that was asked for last: each volume of a list is opened by itself.
std::shared_ptr<const H5Volumes> volumesIn(const H5File& file, const fs::path& path) {
    struct Last {
        fs::path path;
        std::uint64_t bytes = 0;
        fs::file_time_type time;
        std::shared_ptr<const H5Volumes> volumes;
    };
    static std::mutex mutex;
    static Last last;
    std::error_code none;
    const fs::file_time_type time = fs::last_write_time(path, none);
    const std::lock_guard lock(mutex);
    if (!last.volumes || last.path != path || last.bytes != file.sizeBytes() || last.time != time)
        last = {path, file.sizeBytes(), time, std::make_shared<const H5Volumes>(findH5Volumes(file))};
    return last.volumes;
}

/// Sets, or channels of Imaris.
std::vector<FileVolume> volumesOfHdf5(const fs::path& path) {
    const std::shared_ptr<const H5Volumes> volumes = volumesIn(H5File(path), path);
    std::vector<FileVolume> found;
    std::map<std::string, std::size_t> channels; // places in `found`
    for (std::size_t n = 0; n < volumes->all.size(); ++n) {
        const H5Volume& volume = volumes->all[n];
        const int number = static_cast<int>(n) + 1;
        if (volume.time.empty()) {
            found.push_back({volume.name, {number}});
            continue;
        }
        const auto [at, isNew] = channels.emplace(volume.channel, found.size());
        if (isNew)
            found.push_back({volume.name, {}});
        found[at->second].numbers.push_back(number);
        found[at->second].times.push_back(volume.time);
    }
    return volumes->all.size() > 1 ? found : std::vector<FileVolume>{};
}

bool holdsVolumes(const fs::path& path) {
    try {
        return !volumesIn(H5File(path), path)->all.empty();
    } catch (const Error&) {
        return true; // opening it says why
    }
}

const H5Volume& volumeOf(const H5Volumes& volumes, std::size_t chosen, const H5File& file) {
    const std::size_t count = volumes.all.size();
    if (count == 0)
        file.refuse("a set of whole numbers or floats with three axes or more",
                    !volumes.others.empty()  ? volumes.others
                    : volumes.leadingOut > 0 ? "links to other files, which are not followed"
                                             : "none");
    if (chosen == 0 && count > 1)
        file.refuse("one volume, or the name of the file and --series N", std::to_string(count) + " of them");
    if (chosen > count)
        file.refuse("--series between 1 and " + std::to_string(count), std::to_string(chosen));
    return volumes.all[std::max<std::size_t>(chosen, 1) - 1];
}

/// As stored.
double fillOf(const H5Set& set) {
    if (set.type.isHalf)
        return 0;
    ValueRange range;
    widen(range, *set.type.number, set.type.isBig, set.fill);
    const double fill = range.isEmpty() ? 0 : range.least;
    return std::abs(fill) < kMostValue ? static_cast<double>(static_cast<float>(fill)) : 0;
}

void place(VolumeInfo& info, const std::optional<H5Lattice>& lattice, const SourceOptions& options,
           const std::string& where) {
    info.orientationKnown = lattice && lattice->isOfPatient && !options.spacingMm;
    if (const auto& mm = options.spacingMm) {
        info.patientFromVoxel = patientFromVoxelOf({0, 0, 0}, {mm->x, 0, 0}, {0, mm->y, 0}, {0, 0, mm->z});
        if (lattice)
            info.remarks.push_back(std::string(lattice->field) +
                                   " says distances of voxels; --spacing is taken");
    } else {
        info.patientFromVoxel =
            patientFromVoxelOf(lattice->firstMm, lattice->stepMm[0], lattice->stepMm[1], lattice->stepMm[2]);
    }
    const char* const field = options.spacingMm ? "--spacing" : lattice->field;
    requirePlausibleGeometry(info, {field, field, field}, where);
}

H5Set setOf(const H5File& file, const H5Volume& volume) {
    return readH5Set(readH5Object(file, volume.at), volume.name.empty() ? "the image" : volume.name);
}

VolumeInfo infoOf(const H5File& file, const H5Volumes& volumes, const H5Volume& volume,
                  const SourceOptions& options) {
    const H5Set set = setOf(file, volume);
    TESSERA_CHECK(set.type.number);
    const std::optional<H5Lattice> lattice = latticeOf(file, volumes, volume);
    if (!lattice && !options.spacingMm)
        throw spacingUnknown(file.where(), volumes.areOfImaris
                                               ? "an image of Imaris without a size in a known unit"
                                               : "a set that does not say it");
    VolumeInfo info;
    info.extentVoxels = {static_cast<int>(volume.place.extents[2]), static_cast<int>(volume.place.extents[1]),
                         static_cast<int>(volume.place.extents[0])};
    info.type = storedTypeOf(*set.type.number);
    info.fillStored = fillOf(set);
    place(info, lattice, options, file.where());
    if (volumes.leadingOut > 0)
        info.remarks.push_back("links to other files, which are not followed: " +
                               std::to_string(volumes.leadingOut));
    info.validate(file.where());
    return info;
}

std::unique_ptr<SlabSource> openHdf5(const fs::path& path, const SourceOptions& options) {
    auto file = std::make_unique<H5File>(path);
    const std::shared_ptr<const H5Volumes> volumes = volumesIn(*file, path);
    const H5Volume& finest = volumeOf(*volumes, static_cast<std::size_t>(options.series), *file);
    const auto levels = [volumes, finest, options](const H5File& of) {
        std::vector<VolumeInfo> all;
        for (const H5Volume& level : levelsOf(of, *volumes, finest))
            all.push_back(infoOf(of, *volumes, level, options));
        return all;
    };
    const H5Volume volume =
        options.fileLevel == 0
            ? finest
            : levelsOf(*file, *volumes, finest).at(static_cast<std::size_t>(options.fileLevel));
    const H5Set set = setOf(*file, volume);
    VolumeInfo info = infoOf(*file, *volumes, volume, options);
    const FileType type = *set.type.number;
    const std::string description = std::string(volumes->areOfImaris ? "Imaris " : "HDF5 ") +
                                    (set.type.isHalf ? "float16" : name(type)) +
                                    (losesPrecision(type) ? ", converted to float32" : "");
    return std::make_unique<Hdf5Source>(std::move(file), set, volume.place, std::move(info), description,
                                        options.scratchFolder, levels);
}

} // namespace

FileFormat hdf5Format() {
    return {.inFolders = "HDF5 files",
            .named = ".h5 or .ims",
            .open = openHdf5,
            .isMeant = holdsVolumes,
            .takesSpacing = true,
            .volumes = volumesOfHdf5,
            .hasLevels = true};
}

} // namespace tessera
