// bricking/import/files/stack/imagej_volumes.h: the volumes of a hyperstack of ImageJ: which pages are the
// slices of a channel at a point of time. Private to stacks.
#pragma once

#include "bricking/import/files/file_volume.h"
#include "bricking/import/files/stack/ome_planes.h" // SlicePage
#include "bricking/import/files/stack/picture_walk.h"

#include <cstdint>
#include <string>
#include <vector>

namespace tessera {

/// Pages go up by channels, then slices, then points of time.
struct ImageJVolumes {
    std::int64_t channels = 1, slices = 1, frames = 1;
    bool areAppended = false; // the first page has an entry, the others follow it in the file
    std::int64_t count() const { return channels * frames; }
    /// Of a volume, from 0 on.
    std::int64_t pageOf(std::int64_t volume, std::int64_t slice) const {
        return (volume / channels * slices + slice) * channels + volume % channels;
    }
    std::vector<SlicePage> pagesOf(std::int64_t volume) const;
    double stepSeconds = 0; // between frames; 0: not said
    /// Channels at their frames. Empty: one channel of one frame.
    std::vector<FileVolume> all() const;
};

/// Of a file that ImageJ describes. Throws InputError naming it where the numbers of its description do not
/// agree with each other, with its pages or, where these are appended, with its size.
ImageJVolumes imageJVolumesOf(const InputFile& file, const PictureHead& head);

} // namespace tessera
