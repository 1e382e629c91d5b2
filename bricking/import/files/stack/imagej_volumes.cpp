// bricking/import/files/stack/imagej_volumes.cpp: see imagej_volumes.h. Rules: ij.io.FileSaver and
// ij.ImagePlus of ImageJ 1.53.
#include "bricking/import/files/stack/imagej_volumes.h"

#include "bricking/import/files/header_words.h"
#include "bricking/import/files/stack/imagej_lines.h"
#include "bricking/import/source/phase_choice.h"
#include "bricking/import/source/time_units.h"
#include "core/base/error.h"

#include <optional>

namespace tessera {
namespace {

constexpr std::int64_t kMostPages = std::int64_t{1} << 31, kMostImageJVolumes = 10000;

/// 0: it is not said.
std::int64_t countIn(const std::string& description, const char* key, const std::string& where) {
    const std::string text = imageJLine(description, key);
    if (text.empty())
        return 0;
    const std::int64_t count = wholeNumberOf(text).value_or(0);
    if (count < 1 || count > kMostPages)
        throw badFile(where, std::string(key) + "= of ImageJ's description from 1 to 2^31", shownWord(text));
    return count;
}

} // namespace

std::vector<SlicePage> ImageJVolumes::pagesOf(std::int64_t volume) const {
    std::vector<SlicePage> pages;
    for (std::int64_t slice = 0; slice < slices; ++slice)
        pages.push_back({0, static_cast<int>(pageOf(volume, slice))});
    return pages;
}

std::vector<FileVolume> ImageJVolumes::all() const {
    std::vector<FileVolume> volumes;
    for (std::int64_t channel = 0; channel < channels && count() > 1; ++channel) {
        FileVolume& volume = volumes.emplace_back();
        if (channels > 1)
            volume.name = "channel " + std::to_string(channel + 1);
        for (std::int64_t frame = 0; frame < frames; ++frame)
            volume.numbers.push_back(static_cast<int>(frame * channels + channel) + 1);
        if (frames > 1)
            volume.times = phaseLabels(static_cast<std::size_t>(frames), stepSeconds);
    }
    return volumes;
}

ImageJVolumes imageJVolumesOf(const InputFile& file, const PictureHead& head) {
    const std::string where = file.path().string();
    const auto said = [&](const char* key) { return countIn(head.description, key, where); };
    ImageJVolumes volumes;
    const std::int64_t images = said("images"), channels = said("channels"), slices = said("slices"),
                       frames = said("frames");
    volumes.channels = channels > 0 ? channels : 1;
    volumes.frames = frames > 0 ? frames : 1;
    const std::string unit = imageJLine(head.description, "tunit");
    volumes.stepSeconds = stepSecondsOf(realNumberOf(imageJLine(head.description, "finterval")).value_or(0),
                                        unit.empty() ? "s" : unit);
    const std::int64_t pages = images > 0 ? images : head.pages;
    if (volumes.channels > kMostImageJVolumes / volumes.frames)
        throw badFile(where, "10000 channels and points of time at most",
                      std::to_string(volumes.channels) + " and " + std::to_string(volumes.frames));
    volumes.slices = slices > 0 ? slices : pages / volumes.count();
    if (volumes.slices < 1 || volumes.slices * volumes.count() != pages)
        throw badFile(
            where, std::to_string(pages) + " pages, as channels, slices and frames of ImageJ's description",
            std::to_string(volumes.channels) + " times " + std::to_string(volumes.slices) + " times " +
                std::to_string(volumes.frames));
    volumes.areAppended = head.pages == 1 && pages > 1;
    const std::string expected = std::to_string(pages) + " pages, as ImageJ's description says";
    if (!volumes.areAppended) {
        if (pages != head.pages)
            throw badFile(where, expected, std::to_string(head.pages));
        return volumes;
    }
    if (!head.runOffset || head.isHalf)
        throw badFile(where, expected, "one");
    const double needed = static_cast<double>(pages) * head.shape.size.x * head.shape.size.y *
                          static_cast<double>(bytesPerFileValue(head.shape.type));
    if (needed > static_cast<double>(file.sizeBytes() - *head.runOffset))
        throw badFile(where, expected, "bytes for fewer (is it truncated?)");
    return volumes;
}

} // namespace tessera
