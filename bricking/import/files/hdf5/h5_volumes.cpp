// bricking/import/files/hdf5/h5_volumes.cpp: findH5Volumes() of h5_volumes.h.
#include "bricking/import/files/hdf5/h5_volumes.h"

#include "bricking/import/files/hdf5/h5_attributes.h"
#include "bricking/import/files/hdf5/h5_group.h"
#include "bricking/import/files/header_words.h"
#include "core/base/interrupt.h"
#include "core/base/shown_text.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

namespace tessera {
namespace {

constexpr std::size_t kMostVolumes = 10000;
constexpr std::uint64_t kMostAlong = std::uint64_t{1} << 30;

/// A path, printable.
std::string shownPath(const std::string& path) {
    constexpr std::size_t kMostShown = 500;
    return printable(path.substr(0, kMostShown)) + (path.size() > kMostShown ? "..." : "");
}

/// Sets of BigDataViewer of lower resolution: "/t00000/s00/1/cells".
bool isReduced(const std::vector<std::string>& path) {
    return path.size() == 4 && path[3] == "cells" && path[0].starts_with("t") && path[1].starts_with("s") &&
           path[2] != "0" && wholeNumberOf(path[2]);
}

/// A volume in a group "Channel N". Its numbers are padded to whole chunks.
/// @param image  says its extents where the group does not
H5Volume volumeOfImaris(const H5File& file, const H5Object& channel, const std::optional<H5Object>& image) {
    const auto data = objectBelow(file, channel, {"Data"});
    if (!data)
        file.refuse("\"Data\" in channels of Imaris", "none");
    const auto shape = shapeOf(*data);
    if (!shape || !shape->type.number || shape->space.extents.size() != 3)
        file.refuse("three axes of numbers in \"Data\" of Imaris", "others");
    H5Volume volume;
    volume.at = data->at;
    volume.groupAt = channel.at;
    volume.place.at.resize(3);
    for (std::size_t n = 0; n < 3; ++n) {
        const char letter = "ZYX"[n];
        auto said = textAttribute(channel, std::string("ImageSize") + letter);
        if (!said && image)
            said = textAttribute(*image, std::string(1, letter));
        const std::int64_t extent = said ? wholeNumberOf(withoutBlanks(*said)).value_or(0) : 0;
        if (extent < 1 || static_cast<std::uint64_t>(extent) > shape->space.extents[n] ||
            static_cast<std::uint64_t>(extent) > kMostAlong)
            file.refuse(std::string("ImageSize") + letter + " of Imaris from 1 to " +
                            std::to_string(shape->space.extents[n]),
                        said ? shownWord(*said) : "none");
        volume.place.extents[n] = static_cast<std::uint64_t>(extent);
    }
    return volume;
}

class VolumeFinder {
  public:
    explicit VolumeFinder(const H5File& file) : file_(file) {}

    H5Volumes find() {
        const H5Object root = readH5Object(file_, file_.rootAt());
        const auto images = objectBelow(file_, root, {"DataSet", "ResolutionLevel 0"});
        if (images && objectBelow(file_, root, {"DataSetInfo", "Image"})) {
            volumes_.areOfImaris = true;
            findImaris(root, *images);
        } else {
            seen_.insert(root.at);
            std::vector<std::string> path;
            walk(root, path);
        }
        return std::move(volumes_);
    }

  private:
    void walk(const H5Object& group, std::vector<std::string>& path) {
        constexpr std::size_t kDeepest = 32, kMostObjects = 1000000;
        std::vector<H5Link> links = linksOf(file_, group);
        std::ranges::sort(links, {}, &H5Link::name);
        for (const H5Link& link : links) {
            checkInterrupted();
            volumes_.leadingOut += link.leadsOut ? 1 : 0;
            if (link.at == kH5Nowhere || !seen_.insert(link.at).second)
                continue; // a link by name, or another one to what was seen
            if (path.size() >= kDeepest || seen_.size() > kMostObjects)
                file_.refuse("a million objects at most, in groups 32 deep at most", "more");
            const H5Object object = readH5Object(file_, link.at);
            path.push_back(link.name);
            if (isH5Group(object))
                walk(object, path);
            else if (const auto shape = shapeOf(object))
                addSet(group, object, *shape, path);
            path.pop_back();
        }
    }

    void addOther(const std::string& name, const std::string& why) {
        constexpr std::size_t kMostText = 300;
        if (volumes_.others.size() < kMostText)
            volumes_.others += (volumes_.others.empty() ? "" : ", ") + name + " (" + why + ")";
    }

    void addSet(const H5Object& group, const H5Object& object, const H5Shape& shape,
                const std::vector<std::string>& path) {
        std::string all;
        for (const std::string& name : path)
            all += "/" + name;
        std::vector<std::uint64_t> extents = shape.space.extents;
        const std::size_t axes = extents.size();
        while (extents.size() > 3 && extents.back() == 1)
            extents.pop_back();
        if (extents.size() < 3 || isReduced(path))
            return;
        const std::string name = shownPath(all);
        if (!shape.type.number)
            return addOther(name, shape.type.what);
        if (std::ranges::any_of(extents, [](std::uint64_t n) { return n < 1 || n > kMostAlong; }))
            return addOther(name, "an axis of nothing, or longer than 2^30");
        constexpr std::uint64_t kMostColours = 4;
        if (extents.size() > 3 && extents.back() <= kMostColours)
            return addOther(name, std::to_string(axes) + " axes, the last one with " +
                                      std::to_string(extents.back()) +
                                      " numbers: channels must come before z, y, x");
        H5Volume volume{name, object.at, group.at, path.size() > 1 && path.back() == "VoxelData", {}};
        volume.place.slowest = extents.size() - 3;
        std::copy(extents.end() - 3, extents.end(), volume.place.extents.begin());
        volume.place.at.resize(axes);
        addAlong(volume, extents, 0, all);
    }

    /// One volume for each place along the axes before z.
    void addAlong(H5Volume& volume, const std::vector<std::uint64_t>& extents, std::size_t axis,
                  const std::string& name) {
        if (axis == volume.place.slowest) {
            volume.name = shownPath(name);
            return add(volume);
        }
        for (std::uint64_t n = 0; n < extents[axis]; ++n) {
            volume.place.at[axis] = n;
            addAlong(volume, extents, axis + 1,
                     extents[axis] > 1 ? name + "[" + std::to_string(n) + "]" : name);
        }
    }

    void add(const H5Volume& volume) {
        if (volumes_.all.size() >= kMostVolumes)
            file_.refuse(std::to_string(kMostVolumes) + " volumes at most in a file", "more");
        volumes_.all.push_back(volume);
    }

    /// Groups with a number after a word, in the order of numbers.
    std::vector<std::pair<std::int64_t, H5Object>> numbered(const H5Object& group, std::string_view word) {
        std::vector<std::pair<std::int64_t, std::uint64_t>> places;
        for (const H5Link& link : linksOf(file_, group))
            if (link.name.starts_with(word) && link.at != kH5Nowhere)
                if (const auto number = wholeNumberOf(std::string_view(link.name).substr(word.size())))
                    places.emplace_back(*number, link.at);
        if (places.size() > kMostVolumes)
            file_.refuse(std::to_string(kMostVolumes) + " volumes at most in a file", "more");
        std::ranges::sort(places);
        std::vector<std::pair<std::int64_t, H5Object>> found;
        for (const auto& [number, at] : places)
            found.emplace_back(number, readH5Object(file_, at));
        return found;
    }

    void findImaris(const H5Object& root, const H5Object& images) {
        const auto times = numbered(images, "TimePoint ");
        for (const auto& [time, group] : times) {
            const auto channels = numbered(group, "Channel ");
            for (const auto& [channel, of] : channels) {
                std::string name;
                if (channels.size() > 1) {
                    const auto about =
                        objectBelow(file_, root, {"DataSetInfo", "Channel " + std::to_string(channel)});
                    const std::string called = about ? textAttribute(*about, "Name").value_or("") : "";
                    name = "channel " + std::to_string(channel + 1) +
                           (called.empty() ? "" : " (" + shownWord(called) + ")");
                }
                H5Volume volume =
                    volumeOfImaris(file_, of, objectBelow(file_, root, {"DataSetInfo", "Image"}));
                volume.name = name;
                if (times.size() > 1)
                    volume.time = "time " + std::to_string(time + 1);
                volume.timePoint = "TimePoint " + std::to_string(time);
                volume.channel = "Channel " + std::to_string(channel);
                add(volume);
            }
        }
    }

    const H5File& file_;
    H5Volumes volumes_;
    std::set<std::uint64_t> seen_;
};

} // namespace

H5Volumes findH5Volumes(const H5File& file) {
    return VolumeFinder(file).find();
}

std::vector<H5Volume> levelsOf(const H5File& file, const H5Volumes& volumes, const H5Volume& volume) {
    constexpr std::size_t kMostLevels = 64;
    std::vector<H5Volume> levels = {volume};
    const H5Object root = readH5Object(file, file.rootAt());
    while (volumes.areOfImaris && levels.size() < kMostLevels) {
        const auto channel = objectBelow(file, root,
                                         {"DataSet", "ResolutionLevel " + std::to_string(levels.size()),
                                          volume.timePoint, volume.channel});
        if (!channel)
            break;
        levels.push_back(volumeOfImaris(file, *channel, std::nullopt));
        levels.back().name = volume.name;
    }
    return levels;
}

} // namespace tessera
