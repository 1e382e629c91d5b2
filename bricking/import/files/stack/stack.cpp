// bricking/import/files/stack/stack.cpp: volumes whose slices are pictures: TIFF files of several pages, and
// folders of TIFF, PNG or JPEG 2000 files. A walk over a file's structure checks it; OpenImageIO reads its
// rows, some at a time, and OpenJPEG a picture.
#include "bricking/import/files/file_format.h"
#include "bricking/import/files/file_reading.h"
#include "bricking/import/files/stack/imagej_lines.h"
#include "bricking/import/files/stack/imagej_volumes.h"
#include "bricking/import/files/stack/ome_planes.h"
#include "bricking/import/files/stack/ome_text.h"
#include "bricking/import/files/stack/picture_walk.h"
#include "bricking/import/files/stack/slice_gaps.h"
#include "bricking/import/files/stack/slice_names.h"
#include "bricking/import/files/stack/stack_spacing.h"
#include "bricking/import/files/stack/stack_values.h"
#include "bricking/import/source/plausible.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"

#include <algorithm>
#include <limits>
#include <string_view>
#include <utility>

namespace tessera {
namespace {

namespace fs = std::filesystem;

/// Slices are pages of files.
class StackSource final : public RandomSlabSource {
  public:
    StackSource(std::vector<fs::path> files, std::vector<SlicePage> slices, PictureHead head, VolumeInfo info,
                std::string description)
        : files_(std::move(files)), slices_(std::move(slices)), head_(std::move(head)),
          info_(std::move(info)), description_(std::move(description)),
          converter_(head_.shape.type, false, [this](const auto& visit) {
              Opened second;
              for (int z = 0; z < info_.extentVoxels.z; ++z)
                  readBands(z, 0, head_.shape.size.y, second,
                            [&](std::span<const std::byte> rows, int) { visit(rows); });
          }) {}

    const VolumeInfo& info() const override { return info_; }
    std::string describe() const override { return description_; }
    VoxelTally takeTally() override { return converter_.takeTally(); }

    void readSliceAt(int z, std::span<std::byte> out) override { readRows(z, 0, info_.extentVoxels.y, out); }
    RowAccess rowAccess() const override {
        // Parts of a TIFF are packed by themselves; other pictures are decoded from the top, and long strips.
        const bool hasParts = std::string_view(head_.shape.format) == "tiff";
        return hasParts && (head_.stripRows == 0 || hasShortStrips()) ? RowAccess::any : RowAccess::inOrder;
    }
    int rowUnit() const override {
        return std::max({1, head_.tileRows, hasShortStrips() ? head_.stripRows : 0});
    }
    std::size_t roomBytes() const override {
        constexpr std::size_t kDecoded = 16; // bytes a pixel while OpenJPEG decodes
        const auto width = static_cast<std::size_t>(head_.shape.size.x);
        if (std::string_view(head_.shape.format) == kJpeg2000)
            return kDecoded * width * static_cast<std::size_t>(head_.shape.size.y);
        // The rows that are packed together, in this buffer and in the library's.
        const auto unit = static_cast<std::size_t>(std::min(rowUnit(), head_.shape.size.y));
        return 2 * unit * width * bytesPerFileValue(head_.shape.type);
    }
    void readRows(int z, int first, int count, std::span<std::byte> out) override {
        const std::size_t rowBytes = rowBytesOf(info_);
        TESSERA_CHECK(z >= 0 && z < info_.extentVoxels.z && first >= 0 &&
                      first + count <= info_.extentVoxels.y &&
                      out.size() == rowBytes * static_cast<std::size_t>(count));
        readBands(z, first, first + count, opened_, [&](std::span<const std::byte> rows, int row) {
            const std::size_t read = rows.size() / (static_cast<std::size_t>(info_.extentVoxels.x) *
                                                    bytesPerFileValue(head_.shape.type));
            converter_.convert(
                rows, out.subspan(static_cast<std::size_t>(row - first) * rowBytes, read * rowBytes), info_);
        });
    }

  private:
    bool hasShortStrips() const {
        constexpr std::size_t kMostStrip = std::size_t{16} << 20;
        return static_cast<std::size_t>(head_.stripRows) * static_cast<std::size_t>(head_.shape.size.x) *
                   bytesPerFileValue(head_.shape.type) <=
               kMostStrip;
    }
    static constexpr std::size_t kBandBytes = std::size_t{4} << 20;
    struct Opened {
        std::unique_ptr<PictureRows> rows;
        std::size_t file = std::numeric_limits<std::size_t>::max();
        std::vector<std::byte> band;
    };

    /// Rows [begin, end) of slice z, some at a time: f(rows, number of the first). Whole units, but for the
    /// last one of a slice.
    template <typename Each> void readBands(int z, int begin, int end, Opened& opened, const Each& each) {
        checkInterrupted();
        const auto [file, page] = slices_[static_cast<std::size_t>(z)];
        if (opened.file != file) {
            opened.rows.reset(); // closes the file before
            if (std::string_view(head_.shape.format) == "png")
                checkPngSums(InputFile(files_[file])); // libpng would print what it finds
            opened.rows = std::string_view(head_.shape.format) == kJpeg2000
                              ? openJpeg2000Rows(files_[file], head_.shape)
                              : openPictureRows(files_[file], head_.shape);
            opened.file = file;
        }
        const int height = end - begin, unit = std::max(1, head_.tileRows); // strips go row by row
        const std::size_t rowBytes =
            static_cast<std::size_t>(head_.shape.size.x) * bytesPerFileValue(head_.shape.type);
        const auto units = static_cast<int>(std::clamp<std::size_t>(
            kBandBytes / (rowBytes * static_cast<std::size_t>(unit)), 1, static_cast<std::size_t>(height)));
        const std::int64_t rows = std::min<std::int64_t>(std::int64_t{units} * unit, height);
        opened.band.resize(static_cast<std::size_t>(rows) * rowBytes);
        for (int first = begin; first < end;) {
            const int count = static_cast<int>(std::min<std::int64_t>(rows, end - first));
            const std::span<std::byte> band =
                std::span(opened.band).first(static_cast<std::size_t>(count) * rowBytes);
            opened.rows->read(page, first, count, band);
            each(std::span<const std::byte>(band), first);
            first += count;
        }
    }

    std::vector<fs::path> files_;
    std::vector<SlicePage> slices_;
    PictureHead head_;
    VolumeInfo info_;
    std::string description_;
    Opened opened_;
    SliceConverter converter_;
};

VolumeInfo infoOf(const PictureHead& head, int slices, const StackLattice& lattice,
                  const SourceOptions& options, const std::string& where) {
    if (lattice.others > 1)
        throw badFile(where, "one channel at one point of time",
                      std::to_string(lattice.others) + " of them, as its description says");
    if (!lattice.hasSpacing() && !options.spacingMm)
        throw spacingUnknown(where, "a stack that says " + lattice.said());
    VolumeInfo info;
    info.extentVoxels = {head.shape.size.x, head.shape.size.y, slices};
    info.type = storedTypeOf(head.shape.type);
    info.orientationKnown = false;
    info.lossy = head.isLossy;
    StackRescale rescale = rescaleOf(head, where);
    info.rescaleSlope = rescale.slope;
    info.rescaleIntercept = rescale.intercept;
    info.unit = std::move(rescale.unit);
    const glm::dvec3 mm =
        options.spacingMm ? *options.spacingMm : glm::dvec3(*lattice.pixelMm, *lattice.sliceMm);
    info.patientFromVoxel = patientFromVoxelOf({0, 0, 0}, {mm.x, 0, 0}, {0, mm.y, 0}, {0, 0, mm.z});
    if (head.shape.isPalette)
        info.remarks.emplace_back("pictures with a palette that is an even scale of grey, taken as grey");
    if (options.spacingMm && (lattice.pixelMm || lattice.sliceMm))
        info.remarks.push_back("the stack says " + lattice.said() + "; --spacing is taken");
    requirePlausibleGeometry(info, {"--spacing", "--spacing", "--spacing"}, where);
    info.validate(where);
    return info;
}

std::string described(const std::string& what, FileType type) {
    return what + ", " + name(type) + (losesPrecision(type) ? ", converted to float32" : "");
}

/// One channel at one point of time of a stack of ImageJ. Large ones have an entry for their first page
/// alone: the others follow it in the file.
std::unique_ptr<SlabSource> openImageJ(InputFile file, const PictureHead& head,
                                       const SourceOptions& options) {
    const fs::path path = file.path();
    const std::string where = path.string();
    const ImageJVolumes volumes = imageJVolumesOf(file, head);
    const std::int64_t count = volumes.count();
    if (options.series == 0 && count > 1)
        throw badFile(where, "one channel at one point of time, or the name of the file and --series N",
                      std::to_string(count) + " volumes");
    if (options.series > count)
        throw badFile(where, "--series between 1 and " + std::to_string(count),
                      std::to_string(options.series));
    const std::int64_t volume = std::max(options.series, 1) - 1;
    StackLattice lattice = latticeOf(head);
    lattice.others = 1; // one of its volumes
    VolumeInfo info = infoOf(head, static_cast<int>(volumes.slices), lattice, options, where);
    const FileType type = head.shape.type;
    std::string what = "TIFF of " + std::to_string(volumes.slices) + " pages" +
                       (volumes.areAppended ? " behind one another (ImageJ)" : "");
    if (count > 1)
        what += ", volume " + std::to_string(volume + 1) + " of " + std::to_string(count);
    if (!volumes.areAppended)
        return std::make_unique<StackSource>(std::vector{path}, volumes.pagesOf(volume), head,
                                             std::move(info), described(what, type));
    const std::uint64_t page = static_cast<std::uint64_t>(head.shape.size.x) *
                               static_cast<std::uint64_t>(head.shape.size.y) * bytesPerFileValue(type);
    const std::uint64_t first =
        *head.runOffset + static_cast<std::uint64_t>(volumes.pageOf(volume, 0)) * page;
    return makePlainFileSource(std::move(file), info,
                               {type, head.bigEndian, first, static_cast<std::uint64_t>(volumes.channels)},
                               described(what, type));
}

/// One channel at one point of time.
/// @param volume  from 1 on, of omeVolumes(); 0: the only one
std::unique_ptr<SlabSource> openOme(const fs::path& path, const PictureHead& head, const OmeText& text,
                                    std::int64_t volume, const SourceOptions& options) {
    const std::string where = path.string();
    const std::int64_t volumes = omeVolumesOf(text, where);
    if (volume == 0 && volumes > 1)
        throw badFile(where, "one channel at one point of time, or the name of the file and --series N",
                      std::to_string(volumes) + " volumes");
    if (volume > volumes)
        throw badFile(where, "--series between 1 and " + std::to_string(volumes), std::to_string(volume));
    OmePlanes planes = omePlanesOf(text, std::max<std::int64_t>(volume, 1) - 1, path, head);
    const auto slices = static_cast<int>(planes.slices.size());
    if (planes.files.size() == 1 && text.images.size() == 1 && slices * volumes != head.pages)
        throw badFile(where, std::to_string(slices * volumes) + " pages, as its description says",
                      std::to_string(head.pages));
    std::string what = "OME-TIFF of " + std::to_string(slices) + " slices";
    if (planes.files.size() > 1)
        what += " in " + std::to_string(planes.files.size()) + " files";
    if (volumes > 1)
        what += ", volume " + std::to_string(volume) + " of " + std::to_string(volumes);
    VolumeInfo info = infoOf(planes.head, slices, latticeOf(planes.image), options, where);
    const FileType type = planes.head.shape.type;
    return std::make_unique<StackSource>(std::move(planes.files), std::move(planes.slices),
                                         std::move(planes.head), std::move(info), described(what, type));
}

/// The pages of one file, or the first pages of several.
std::vector<SlicePage> pagesInOrder(std::size_t count, bool isOneFile) {
    std::vector<SlicePage> slices(count);
    for (std::size_t z = 0; z < count; ++z)
        slices[z] = isOneFile ? SlicePage{0, static_cast<int>(z)} : SlicePage{z, 0};
    return slices;
}

/// OME's description of pages that are planes; nullopt: none. Throws InputError for a file that another one
/// describes.
std::optional<OmeText> omeTextOf(const fs::path& path, const PictureHead& head) {
    if (isOfImageJ(head.description) || !isOfOme(head.description))
        return std::nullopt;
    OmeText text = readOmeText(head.description);
    if (!text.describedBy.empty())
        throw badFile(path.string(), "the file of a set that describes it: " + shownWord(text.describedBy),
                      "another one of the set");
    const bool hasPlanes = !text.images.empty() && (head.pages > 1 || !otherOmeFiles(text, path).empty());
    return hasPlanes ? std::optional(std::move(text)) : std::nullopt;
}

std::vector<FileVolume> volumesOfPages(const fs::path& path) {
    const InputFile file(path);
    const PictureHead head = walkPicture(file);
    if (isOfImageJ(head.description))
        return imageJVolumesOf(file, head).all();
    const std::optional<OmeText> text = omeTextOf(path, head);
    return text ? omeVolumes(*text, path.string()) : std::vector<FileVolume>{};
}

std::unique_ptr<SlabSource> openPages(const fs::path& path, const SourceOptions& options) {
    InputFile file(path);
    const PictureHead head = walkPicture(file);
    const std::string where = path.string();
    if (const std::optional<OmeText> text = omeTextOf(path, head))
        return openOme(path, head, *text, options.series, options);
    const StackLattice lattice = latticeOf(head);
    if (isOfImageJ(head.description) && (head.pages > 1 || lattice.images > 1))
        return openImageJ(std::move(file), head, options);
    if (head.pages == 1)
        throw badFile(where, "a TIFF file of several pages, or the name of a folder of slices",
                      "one picture");
    VolumeInfo info = infoOf(head, head.pages, lattice, options, where);
    return std::make_unique<StackSource>(
        std::vector{path}, pagesInOrder(static_cast<std::size_t>(head.pages), true), head, std::move(info),
        described("TIFF of " + std::to_string(head.pages) + " pages", head.shape.type));
}

std::unique_ptr<SlabSource> openFolder(const fs::path& folder, const std::vector<fs::path>& files,
                                       const SourceOptions& options) {
    SliceNames names = orderedSlices(folder, files);
    if (names.missingCount > 0 && !options.resampleZ)
        throw badFile(folder.string(),
                      "slices " + names.pattern + " without gaps, or --resample-z, which interpolates",
                      std::to_string(names.missingCount) + " missing: " + names.missing);
    constexpr std::uint64_t kMostPlaces = 65536;
    if (names.missingCount > 0 && names.places.back() >= kMostPlaces)
        throw badFile(folder.string(), std::to_string(kMostPlaces) + " slices at most where some are missing",
                      std::to_string(names.places.back() + 1));
    PictureHead head;
    for (std::size_t i = 0; i < names.files.size(); ++i) {
        checkInterrupted();
        const PictureHead next = walkPicture(InputFile(names.files[i]));
        const std::string where = names.files[i].string();
        if (next.pages > 1)
            throw badFile(where, "a slice: one page", std::to_string(next.pages) + " pages");
        if (i == 0)
            head = next;
        const std::string first = printableName(names.files.front().filename());
        if (std::string_view(next.shape.format) != head.shape.format)
            throw badFile(where, "a picture of the kind of " + first + " (" + head.shape.format + ")",
                          next.shape.format);
        if (next.shape.size != head.shape.size || next.shape.type != head.shape.type)
            throw badFile(where,
                          std::to_string(head.shape.size.x) + "x" + std::to_string(head.shape.size.y) +
                              " pixels of " + name(head.shape.type) + ", as in " + first,
                          std::to_string(next.shape.size.x) + "x" + std::to_string(next.shape.size.y) +
                              " pixels of " + name(next.shape.type));
        if (next.tileRows != head.tileRows)
            throw badFile(where, "tiles as in " + first, "others");
        if (rescaleOf(next, where) != rescaleOf(head, where))
            throw badFile(where, "ImageJ's calibration as in " + first, "another");
        head.isLossy = head.isLossy || next.isLossy;
        head.shape.isPalette = head.shape.isPalette || next.shape.isPalette;
        head.stripRows = std::max(head.stripRows, next.stripRows);
    }
    VolumeInfo info =
        infoOf(head, static_cast<int>(names.files.size()), latticeOf(head), options, folder.string());
    if (names.missingCount > 0)
        info.remarks.push_back(std::to_string(names.missingCount) +
                               " slices missing by their numbers, interpolated: " + names.missing);
    const std::string what = std::to_string(names.files.size()) + " slices, " + names.pattern;
    const std::size_t count = names.files.size();
    auto slices = std::make_unique<StackSource>(std::move(names.files), pagesInOrder(count, false), head,
                                                std::move(info), described(what, head.shape.type));
    if (names.missingCount == 0)
        return slices;
    return fillGaps(std::move(slices), names.places);
}

/// Pages behind the first, of which ImageJ appends some without an entry, or pages of other files.
bool isVolumeByItself(const fs::path& path) {
    try {
        const TiffBeginning first = tiffBeginningOf(InputFile(path));
        if (!isOfImageJ(first.description) && isOfOme(first.description)) {
            const OmeText text = readOmeText(first.description);
            return text.describedBy.empty() && (first.isFollowed || !otherOmeFiles(text, path).empty());
        }
        return first.isFollowed || first.description.find("\nimages=") != std::string::npos;
    } catch (const Error&) {
        return false; // as a slice it is refused by its name
    }
}

std::vector<fs::path> otherFilesOf(const fs::path& path) {
    try {
        const TiffBeginning first = tiffBeginningOf(InputFile(path));
        return isOfOme(first.description) ? otherOmeFiles(readOmeText(first.description), path)
                                          : std::vector<fs::path>();
    } catch (const Error&) {
        return {};
    }
}

} // namespace

FileFormat stackFormat() {
    return {.inFolders = "slices in TIFF, PNG or JPEG 2000 files",
            .named = ".tif or .tiff of several pages",
            .open = openPages,
            .isMeant = isVolumeByItself,
            .parts = otherFilesOf,
            .takesSpacing = true,
            .openStack = openFolder,
            .sliceEndings = {".tif", ".tiff", ".png", ".jp2", ".j2k", ".j2c", ".jpc"},
            .volumes = volumesOfPages};
}

} // namespace tessera
