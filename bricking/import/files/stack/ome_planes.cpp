// bricking/import/files/stack/ome_planes.cpp: see ome_planes.h. Rules: the OME-TIFF specification,
// "TiffData".
#include "bricking/import/files/stack/ome_planes.h"

#include "bricking/import/files/header_words.h"
#include "bricking/import/source/phase_choice.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/shown_text.h"

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

namespace tessera {
namespace {

namespace fs = std::filesystem;

constexpr double kMostPlanes = 1 << 20; // of an image

/// A volume of an image.
struct Chosen {
    const OmeTiffImage* image = nullptr;
    std::int64_t channel = 0, time = 0;
};

Chosen chosenOf(const OmeText& text, std::int64_t volume) {
    for (const OmeTiffImage& image : text.images) {
        if (volume < image.volumes())
            return {&image, volume % image.channels, volume / image.channels};
        volume -= image.volumes();
    }
    return {};
}

void requirePlanes(const OmeTiffImage& image, const std::string& where) {
    const double planes = static_cast<double>(std::max<std::int64_t>(image.slices, 1)) *
                          static_cast<double>(image.channels) * static_cast<double>(image.times);
    if (planes > kMostPlanes)
        throw badFile(where, "2^20 planes at most", numberText(planes));
}

class PlaneFinder {
  public:
    PlaneFinder(const OmeText& text, const Chosen& chosen, fs::path file, const PictureHead& head)
        : text_(text), image_(*chosen.image), chosen_(chosen), path_(std::move(file)),
          where_(path_.string()) {
        found_.image = image_;
        found_.files = {path_};
        found_.head = head;
        pages_ = {head.pages};
    }

    OmePlanes find() {
        for (const std::int64_t size : {image_.slices, image_.channels, image_.times})
            if (size < 1)
                refuse("SizeZ, SizeC and SizeT of OME's description as whole numbers of at least 1",
                       "others");
        requirePlanes(image_, where_);
        for (const auto& [said, is, name] : {std::tuple(image_.width, found_.head.shape.size.x, "SizeX"),
                                             std::tuple(image_.height, found_.head.shape.size.y, "SizeY")})
            if (said >= 0 && said != is)
                refuse(std::string(name) + " of OME's description as in the pages",
                       std::to_string(said) + " and " + std::to_string(is));
        all_ = image_.slices * image_.volumes();
        readOrder();
        slices_.resize(static_cast<std::size_t>(image_.slices));
        takeBlocks();
        for (std::size_t z = 0; z < slices_.size(); ++z) {
            if (!slices_[z])
                refuse("a page for every slice, as OME's description says",
                       "none for slice " + std::to_string(z + 1) + " of " + std::to_string(slices_.size()));
            found_.slices.push_back(*slices_[z]);
        }
        for (const SlicePage& slice : found_.slices)
            if (slice.page >= pagesOf(slice.file))
                throw badFile(found_.files[slice.file].string(),
                              "page " + std::to_string(slice.page + 1) + ", as OME's description says",
                              std::to_string(pagesOf(slice.file)) + " of them");
        return std::move(found_);
    }

  private:
    [[noreturn]] void refuse(const std::string& expected, const std::string& found) const {
        throw badFile(where_, expected, found);
    }

    /// Steps of the number of a plane along z, channel and time.
    void readOrder() {
        std::string order = image_.order;
        const int longer = (image_.slices > 1) + (image_.channels > 1) + (image_.times > 1);
        if (order.empty() && longer <= 1)
            order = "XYZCT";
        std::string sorted = order.size() == 5 ? order.substr(2) : "";
        std::ranges::sort(sorted);
        if (!order.starts_with("XY") || sorted != "CTZ")
            refuse("DimensionOrder XYZCT, XYCZT or another of x, y and the others", shownWord(order));
        std::int64_t step = 1;
        for (const char axis : order.substr(2)) {
            const std::size_t at = axis == 'Z' ? 0 : axis == 'C' ? 1 : 2;
            steps_[at] = step;
            step *= sizes()[at];
        }
    }
    std::array<std::int64_t, 3> sizes() const { return {image_.slices, image_.channels, image_.times}; }

    void takeBlocks() {
        if (image_.blocks.empty() && text_.images.size() > 1)
            refuse("TiffData of every image", "none");
        if (image_.blocks.empty())
            takeBlock({}, all_);
        for (const OmeBlock& block : image_.blocks) {
            checkInterrupted();
            const std::array<std::int64_t, 3> first = {block.slice, block.channel, block.time};
            for (std::size_t axis = 0; axis < first.size(); ++axis)
                if (first[axis] < 0 || first[axis] >= sizes()[axis])
                    refuse("TiffData of planes that the image has", "others");
            if (block.page && *block.page < 0)
                refuse("IFD of TiffData as a number from 0 on", "another");
            // All pages of the file, or the one that is said.
            takeBlock(block, block.planes ? *block.planes : block.page ? 1 : pagesOf(fileOf(block)));
        }
    }

    void takeBlock(const OmeBlock& block, std::int64_t planes) {
        const std::int64_t begin =
            block.slice * steps_[0] + block.channel * steps_[1] + block.time * steps_[2];
        if (planes < 1 || planes > all_ - begin)
            refuse("TiffData of planes that the image has", std::to_string(planes) + " from plane " +
                                                                std::to_string(begin + 1) + " of " +
                                                                std::to_string(all_) + " on");
        for (std::int64_t n = 0; n < planes; ++n) {
            const auto along = [&](std::size_t axis) { return (begin + n) / steps_[axis] % sizes()[axis]; };
            if (along(1) != chosen_.channel || along(2) != chosen_.time)
                continue;
            std::optional<SlicePage>& slice = slices_[static_cast<std::size_t>(along(0))];
            const SlicePage page{fileOf(block), static_cast<int>(std::min<std::int64_t>(
                                                    block.page.value_or(0) + n, kMostPage))};
            if (slice && (slice->file != page.file || slice->page != page.page))
                refuse("every plane once", "two pages of slice " + std::to_string(along(0) + 1));
            slice = page;
        }
    }

    /// By its name, or its UUID: a file that was given another name is still itself.
    std::size_t fileOf(const OmeBlock& block) {
        if (block.file.empty() || (!block.uuid.empty() && block.uuid == text_.uuid) ||
            block.file == path_.filename().string())
            return 0;
        const auto [at, isNew] = numbers_.emplace(block.file, found_.files.size());
        if (isNew)
            add(block);
        return at->second;
    }

    int pagesOf(std::size_t file) const { return pages_[file]; }

    void add(const OmeBlock& block) {
        const fs::path name = block.file;
        if (name.is_absolute() || std::ranges::find(name, fs::path("..")) != name.end())
            refuse("names of files in its folder, in TiffData", shownWord(block.file));
        const fs::path path = path_.parent_path() / name;
        const std::string where = path.string();
        const PictureHead next = walkPicture(InputFile(path));
        PictureHead& head = found_.head;
        if (next.shape.size != head.shape.size || next.shape.type != head.shape.type ||
            next.tileRows != head.tileRows || std::string_view(next.shape.format) != head.shape.format)
            throw badFile(where,
                          "pages of the size, type and tiles of those in " + printableName(path_.filename()),
                          "others");
        if (isOfOme(next.description)) {
            const std::string uuid = readOmeText(next.description).uuid;
            if (!uuid.empty() && !block.uuid.empty() && uuid != block.uuid)
                throw badFile(where, "the file of that name in the set of " + printableName(path_.filename()),
                              "one of another set (its UUID is another)");
        }
        head.isLossy = head.isLossy || next.isLossy;
        head.shape.isPalette = head.shape.isPalette || next.shape.isPalette;
        found_.files.push_back(path);
        pages_.push_back(next.pages);
    }

    static constexpr std::int64_t kMostPage = std::int64_t{1} << 30;
    const OmeText& text_;
    const OmeTiffImage& image_;
    Chosen chosen_;
    fs::path path_;
    std::string where_;
    OmePlanes found_;
    std::vector<int> pages_; // of the files
    std::map<std::string, std::size_t> numbers_;
    std::int64_t all_ = 0; // planes
    std::array<std::int64_t, 3> steps_ = {1, 1, 1};
    std::vector<std::optional<SlicePage>> slices_;
};

} // namespace

std::int64_t omeVolumesOf(const OmeText& text, const std::string& where) {
    std::int64_t volumes = 0;
    for (const OmeTiffImage& image : text.images) {
        requirePlanes(image, where);
        volumes += image.volumes();
        if (static_cast<double>(volumes) > kMostPlanes)
            throw badFile(where, "2^20 planes at most", "more in all images");
    }
    return volumes;
}

std::vector<FileVolume> omeVolumes(const OmeText& text, const std::string& where) {
    constexpr std::size_t kMostOmeVolumes = 10000;
    std::vector<FileVolume> volumes;
    if (omeVolumesOf(text, where) < 2)
        return volumes;
    std::int64_t first = 1; // number
    for (const OmeTiffImage& image : text.images) {
        for (std::int64_t channel = 0; channel < image.channels && image.times > 0; ++channel) {
            if (volumes.size() >= kMostOmeVolumes)
                throw badFile(where, std::to_string(kMostOmeVolumes) + " images and channels at most",
                              "more");
            FileVolume& volume = volumes.emplace_back();
            if (text.images.size() > 1)
                volume.name = "image " + std::to_string(&image - text.images.data() + 1);
            if (image.channels > 1) {
                const auto at = static_cast<std::size_t>(channel);
                const bool isNamed = at < image.channelNames.size() && !image.channelNames[at].empty();
                volume.name += (volume.name.empty() ? "" : ", ") +
                               ("channel " + std::to_string(channel + 1)) +
                               (isNamed ? " (" + shownWord(image.channelNames[at]) + ")" : "");
            }
            for (std::int64_t time = 0; time < image.times; ++time)
                volume.numbers.push_back(static_cast<int>(first + time * image.channels + channel));
            if (image.times > 1)
                volume.times = phaseLabels(static_cast<std::size_t>(image.times), image.stepSeconds);
        }
        first += image.volumes();
    }
    return volumes;
}

std::vector<fs::path> otherOmeFiles(const OmeText& text, const fs::path& file) {
    std::set<std::string> names;
    for (const OmeTiffImage& image : text.images)
        for (const OmeBlock& block : image.blocks)
            if (!block.file.empty() && block.file != file.filename().string() &&
                (block.uuid.empty() || block.uuid != text.uuid))
                names.insert(block.file);
    std::vector<fs::path> files;
    for (const std::string& name : names)
        files.push_back(file.parent_path() / name);
    return files;
}

OmePlanes omePlanesOf(const OmeText& text, std::int64_t volume, const fs::path& file,
                      const PictureHead& head) {
    const Chosen chosen = chosenOf(text, volume);
    if (!chosen.image)
        throw badFile(file.string(),
                      "SizeZ, SizeC and SizeT of OME's description as whole numbers of at least 1", "others");
    if (!text.isWhole)
        throw badFile(file.string(), "a whole description of OME, up to </OME>", "its beginning");
    return PlaneFinder(text, chosen, file, head).find();
}

} // namespace tessera
