// bricking/import/files/zarr/zarr.cpp: volumes in OME-Zarr 0.4 and 0.5, and in arrays of Zarr v2 and v3, that
// other programs wrote. A folder is one file of the format; channels and times are volumes of it.
#include "bricking/import/files/file_format.h"
#include "bricking/import/source/phase_choice.h"
#include "bricking/import/source/plausible.h"
#include "bricking/import/source/slice_converter.h"
#include "bricking/import/zarr/ome_image.h"
#include "bricking/import/zarr/zarr_slices.h"
#include "bricking/store/store_reader.h" // isStore
#include "core/base/address.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/json_reader.h"
#include "core/base/shown_text.h"

#include <algorithm>
#include <array>
#include <glm/geometric.hpp>
#include <map>
#include <optional>
#include <system_error>
#include <utility>

namespace tessera {
namespace {

namespace fs = std::filesystem;

/// An array with all its volumes: an image at one of its levels.
struct ZarrImage {
    ZarrArray array;
    OmeGrid grid;
    std::vector<std::string> channels; // names; may be fewer than there are
    bool hasPlace = false;             // says where its voxels lie
    std::size_t levels = 1;            // of the image
    std::string what, where;           // "OME-Zarr"; of its metadata
};

std::vector<VolumeInfo> levelsOf(const fs::path& path, const SourceOptions& options);

class ZarrSource final : public SlabSource {
  public:
    /// @param path, options  that it was opened by
    ZarrSource(const ZarrImage& image, ZarrVolumePlace place, VolumeInfo info, fs::path path,
               const SourceOptions& options)
        : image_(image), place_(std::move(place)), info_(std::move(info)), path_(std::move(path)),
          options_(options), slices_(std::in_place, image_.array, place_, options_.scratchFolder),
          converter_(image_.array.type, image_.array.bigEndian,
                     [this](const auto& visit) { visitAll(visit); }) {}

    const VolumeInfo& info() const override { return info_; }
    std::vector<VolumeInfo> fileLevels() const override {
        return image_.levels > 1 ? levelsOf(path_, options_) : SlabSource::fileLevels();
    }
    bool crop(const FileBox& box) override {
        info_ = croppedInfo(info_, box);
        place_.first = {box.low.z, box.low.y, box.low.x};
        place_.extents = {info_.extentVoxels.z, info_.extentVoxels.y, info_.extentVoxels.x};
        slices_.emplace(image_.array, place_, options_.scratchFolder);
        slice_ = {};
        isCropped_ = true;
        return true;
    }

    void readSlices(int count, std::span<std::byte> out) override {
        const std::size_t bytes = sliceBytesOf(info_);
        TESSERA_CHECK(out.size() == bytes * static_cast<std::size_t>(count));
        slice_.resize(sliceFileBytes()); // not before: a file may be opened for what it says alone
        for (int i = 0; i < count; ++i) {
            checkInterrupted();
            slices_->readSlice(slice_);
            requireChunks(*slices_);
            converter_.convert(slice_, out.subspan(static_cast<std::size_t>(i) * bytes, bytes), info_);
        }
    }

    std::size_t roomBytes() const override {
        return sliceFileBytes() + ZarrSlices::bytesNeeded(image_.array, place_);
    }

    std::string describe() const override {
        const FileType type = image_.array.type;
        return image_.what + ", " + name(type) + (losesPrecision(type) ? ", converted to float32" : "");
    }

    VoxelTally takeTally() override { return converter_.takeTally(); }
    std::vector<std::string> notes() const override {
        std::vector<std::string> notes = SlabSource::notes();
        if (image_.hasPlace)
            notes.insert(notes.end(), image_.grid.notes.begin(), image_.grid.notes.end());
        notes.insert(notes.end(), image_.array.notes.begin(), image_.array.notes.end());
        if (std::string missing = slices_->sayMissing(); slices_->isAtEnd() && !missing.empty())
            notes.push_back(std::move(missing));
        return notes;
    }

  private:
    std::size_t sliceFileBytes() const {
        return static_cast<std::size_t>(info_.extentVoxels.x) *
               static_cast<std::size_t>(info_.extentVoxels.y) * image_.array.valueBytes();
    }
    void visitAll(const std::function<void(std::span<const std::byte>)>& visit) const {
        ZarrSlices again(image_.array, place_, options_.scratchFolder);
        std::vector<std::byte> slice(sliceFileBytes());
        for (int z = 0; z < info_.extentVoxels.z; ++z) {
            checkInterrupted();
            again.readSlice(slice);
            requireChunks(again);
            visit(slice);
        }
    }
    /// An array of which nothing is there is all fill by the rules of Zarr; its chunks are lost, or
    /// elsewhere. A box may be where there is nothing.
    void requireChunks(const ZarrSlices& slices) const {
        if (const ZarrChunks::Tally& tally = slices.tally();
            !isCropped_ && slices.isAtEnd() && tally.lacksAll())
            throw badFile((slices.array().path / tally.firstMissing).string(), "a chunk",
                          "none of the volume's " + std::to_string(tally.read) + " chunks");
    }

    ZarrImage image_;
    ZarrVolumePlace place_;
    VolumeInfo info_;
    fs::path path_;
    SourceOptions options_;
    std::optional<ZarrSlices> slices_;
    bool isCropped_ = false;
    SliceConverter converter_;
    std::vector<std::byte> slice_; // in the file's numbers
};

/// The images of a group as bioformats2raw (3) writes it: those that OME/ names, else 0, 1, ...
std::vector<std::string> imagesOfLayout(const ZarrNode& group) {
    constexpr std::size_t kMostImages = 10000, kMostLookedFor = 20;
    std::vector<std::string> images;
    const auto ome = omeAttributesOf(group);
    if (!ome || !ome->has("bioformats2raw.layout"))
        return images;
    if (const auto about = readZarrNode(group, "OME"); about && !about->isArray)
        if (const auto said = omeAttributesOf(*about); said && said->has("series"))
            for (const JsonValue name : said->at("series").items(kMostImages, "images"))
                images.push_back(pathBelow(name.text(), name.place()));
    if (images.empty())
        while (images.size() < kMostLookedFor && isZarr(group.path / std::to_string(images.size())))
            images.push_back(std::to_string(images.size()));
    return images;
}

/// The group of the image that a path means: itself, or the only one of a group of bioformats2raw.
ZarrNode imageGroupOf(const ZarrNode& node, std::vector<std::string>& notes) {
    const std::vector<std::string> images = imagesOfLayout(node);
    if (images.empty())
        return node;
    if (images.size() == 1) {
        notes.push_back("the image is " + printable(images.front()) + ", the only one of its group");
        return requireZarrNode(node, images.front(), "the image that its group names");
    }
    constexpr std::size_t kMostShown = 20;
    std::string all;
    for (std::size_t i = 0; i < std::min(images.size(), kMostShown); ++i)
        all += (i == 0 ? "" : ", ") + printable(images[i]);
    throw badFile(
        node.path.string(), "one image: name it, as in " + printable((node.path / images.front()).string()),
        std::to_string(images.size()) + " of them: " + all + (images.size() > kMostShown ? ", ..." : ""));
}

/// @param level  that the image has; an array by itself has one
ZarrImage imageAt(const fs::path& given, int level = 0) {
    const fs::path path = given.has_filename() ? given : given.parent_path(); // "a.zarr/" means a.zarr
    ZarrNode node = requireZarrNode(path, "a group or an array of Zarr");
    ZarrImage found;
    if (node.isArray) {
        found.array = zarrArrayOf(node);
        findSeparator(found.array);
        found.grid = bareGridOf(found.array);
        found.what = "array of Zarr v" + std::to_string(node.version);
        found.where = found.array.where;
        return found;
    }
    std::optional<OmeImage> image = omeImageOf(node);
    std::vector<std::string> notes;
    if (!image) {
        node = imageGroupOf(node, notes);
        image = omeImageOf(node);
    }
    if (!image)
        throw badFile(node.attributesFile,
                      "\"multiscales\" of OME-Zarr 0.4 or 0.5; where the group holds images, the name of one",
                      "a group without them");
    found.levels = image->levels.size();
    TESSERA_CHECK(level >= 0 && static_cast<std::size_t>(level) < found.levels);
    const OmeLevel& chosen = image->levels[static_cast<std::size_t>(level)];
    const ZarrNode data = requireZarrNode(node, chosen.path, "the array that \"multiscales\" names");
    if (!data.isArray)
        throw badFile(data.metadataFile, "an array", "a group");
    found.array = zarrArrayOf(data);
    findSeparator(found.array);
    found.grid = omeGridOf(*image, chosen, found.array, node.attributesFile);
    found.grid.notes.insert(found.grid.notes.begin(), notes.begin(), notes.end());
    found.channels = image->channels;
    found.hasPlace = true;
    found.what = node.version == 2 ? "OME-Zarr 0.4" : "OME-Zarr 0.5";
    found.where = node.attributesFile;
    return found;
}

constexpr std::size_t kMostVolumes = 10000;

std::size_t volumesIn(const ZarrImage& image) {
    std::size_t all = 1;
    for (const OmeGrid::Other& other : image.grid.others) {
        if (static_cast<std::uint64_t>(other.length) > kMostVolumes / all)
            throw badFile(image.where, "at most " + std::to_string(kMostVolumes) + " volumes in an array",
                          "more along axis \"" + other.name + "\"");
        all *= static_cast<std::size_t>(other.length);
    }
    return all;
}

/// The place of a volume along all axes.
/// @param number  from 0; the last axis runs fastest
std::vector<std::int64_t> placeOf(const ZarrImage& image, std::size_t number) {
    std::vector<std::int64_t> at(image.array.shape.size());
    for (auto other = image.grid.others.rbegin(); other != image.grid.others.rend(); ++other) {
        at[other->axis] = static_cast<std::int64_t>(number) % other->length;
        number /= static_cast<std::size_t>(other->length);
    }
    return at;
}

bool isOfTime(const OmeGrid::Other& axis) {
    return axis.name == "t" || axis.name == "time";
}

/// Without its time.
std::string nameOf(const ZarrImage& image, const std::vector<std::int64_t>& at) {
    std::string text;
    for (const OmeGrid::Other& other : image.grid.others) {
        if (other.length == 1 || isOfTime(other))
            continue;
        const auto index = static_cast<std::size_t>(at[other.axis]);
        text += (text.empty() ? "" : ", ");
        if (other.name == "c" || other.name == "channel")
            text += "channel " + std::to_string(index + 1) +
                    (index < image.channels.size() && !image.channels[index].empty()
                         ? " (" + image.channels[index] + ")"
                         : "");
        else
            text += "axis " + other.name + " at " + std::to_string(index);
    }
    return text;
}

/// What is at one place along the axes but that of time is one volume.
std::vector<FileVolume> volumesOf(const fs::path& path) {
    const ZarrImage image = imageAt(path);
    const auto times = std::ranges::find_if(
        image.grid.others, [](const OmeGrid::Other& other) { return isOfTime(other) && other.length > 1; });
    const bool hasTimes = times != image.grid.others.end();
    std::vector<std::string> labels;
    if (hasTimes)
        labels = phaseLabels(static_cast<std::size_t>(times->length), times->stepSeconds);
    std::vector<FileVolume> found;
    std::map<std::vector<std::int64_t>, std::size_t> places; // in `found`
    const std::size_t count = volumesIn(image);
    for (std::size_t number = 0; number < count && count > 1; ++number) {
        std::vector<std::int64_t> at = placeOf(image, number);
        if (hasTimes)
            at[times->axis] = 0;
        const auto [place, isNew] = places.emplace(at, found.size());
        if (isNew)
            found.push_back({nameOf(image, at), {}, labels});
        found[place->second].numbers.push_back(static_cast<int>(number) + 1);
    }
    return found;
}

/// The number of the volume, from 0.
std::size_t numberOf(const ZarrImage& image, const SourceOptions& options) {
    const std::size_t count = volumesIn(image);
    if (count > 1 && options.series == 0)
        throw badFile(image.where, "one volume, or --series N", std::to_string(count) + " of them");
    const std::size_t number = count > 1 ? static_cast<std::size_t>(options.series) - 1 : 0;
    if (number >= count)
        throw badFile(image.where, "--series between 1 and " + std::to_string(count),
                      std::to_string(options.series));
    return number;
}

VolumeInfo infoOf(const ZarrImage& image, const SourceOptions& options) {
    VolumeInfo info = image.grid.info;
    info.type = storedTypeOf(image.array.type);
    if (!image.hasPlace) {
        if (!options.spacingMm)
            throw spacingUnknown(image.where, "an array by itself, which does not say it");
        info.orientationKnown = false;
    } else if (!image.grid.spacingProblem.empty()) {
        if (!options.spacingMm)
            throw spacingUnknown(image.where, image.grid.spacingProblem);
    } else if (options.spacingMm) {
        info.remarks.emplace_back("OME-Zarr says distances of voxels; --spacing is taken");
    }
    if (options.spacingMm) { // along the same axes
        std::array<glm::dvec3, 3> step{};
        for (int axis = 0; axis < 3; ++axis)
            step[static_cast<std::size_t>(axis)] =
                (*options.spacingMm)[axis] * glm::normalize(glm::dvec3(info.patientFromVoxel[axis]));
        info.patientFromVoxel = patientFromVoxelOf({0, 0, 0}, step[0], step[1], step[2]);
    }
    const char* const field = options.spacingMm ? "--spacing" : "coordinateTransformations";
    requirePlausibleGeometry(info, {field, field, field}, image.where);
    info.validate(image.where);
    return info;
}

std::vector<VolumeInfo> levelsOf(const fs::path& path, const SourceOptions& options) {
    std::vector<VolumeInfo> levels;
    std::size_t count = 1;
    for (std::size_t level = 0; level < count; ++level) {
        const ZarrImage image = imageAt(path, static_cast<int>(level));
        count = image.levels;
        levels.push_back(infoOf(image, options));
    }
    return levels;
}

std::unique_ptr<SlabSource> openZarr(const fs::path& path, const SourceOptions& options) {
    const ZarrImage image = imageAt(path, options.fileLevel);
    ZarrVolumePlace place{image.grid.axes, placeOf(image, numberOf(image, options))};
    return std::make_unique<ZarrSource>(image, std::move(place), infoOf(image, options), path, options);
}

/// Of an array behind an address, which may have millions of files: the metadata, and the first, the middle
/// and the last of the others. Their versions tell a volume from one that replaces it.
std::vector<fs::path> tellingFiles(const fs::path& path) {
    std::vector<fs::path> files;
    try {
        const ZarrArray array = imageAt(path).array;
        files.push_back(array.where);
        for (const std::int64_t half : {0, 1, 2}) {
            std::vector<std::int64_t> at;
            for (std::size_t axis = 0; axis < array.shape.size(); ++axis) {
                const std::int64_t each = array.chunk[axis] * (array.shard.empty() ? 1 : array.shard[axis]);
                at.push_back((array.shape[axis] - 1) / each * half / 2);
            }
            files.push_back(array.path / ZarrChunks::fileOf(array, at));
        }
    } catch (const InputError&) { // opening it says why
    }
    return files;
}

bool isForeignZarr(const fs::path& path) {
    std::error_code none;
    return (isAddress(path) || fs::is_directory(path, none)) && isZarr(path) && !isStore(path);
}

} // namespace

FileFormat zarrFormat() {
    return {.inFolders = "",
            .named = "the folder of a Zarr",
            .open = openZarr,
            .parts = tellingFiles,
            .takesSpacing = true,
            .isFolder = isForeignZarr,
            .volumes = volumesOf,
            .hasLevels = true};
}

} // namespace tessera
