// bricking/import/files/stack/ome_text.h: the description of OME-TIFF files: images, their channels and
// points of time, and the pages that hold their planes. Private to stacks.
#pragma once

#include "bricking/import/files/stack/xml_tags.h"

#include <cstdint>
#include <glm/vec2.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tessera {

/// Planes of an image that are pages of a file, one after another (TiffData).
struct OmeBlock {
    std::string file, uuid;                        // "": this file
    std::optional<std::int64_t> page, planes;      // the first; how many
    std::int64_t slice = 0, channel = 0, time = 0; // of the first
};

/// One of the file's images (Pixels). A size of 0 is no number.
struct OmeTiffImage {
    std::string order;                    // "XYZCT": the axes of planes that follow one another
    std::int64_t width = -1, height = -1; // -1: not said
    std::int64_t slices = 1, channels = 1, times = 1;
    std::vector<std::string> channelNames;
    std::vector<OmeBlock> blocks; // empty: planes are the pages
    std::optional<glm::dvec2> pixelMm;
    std::optional<double> sliceMm;
    double stepSeconds = 0; // between points of time; 0: not said
    /// Each is a channel at a point of time.
    std::int64_t volumes() const { return channels * times; }
};

struct OmeText {
    std::string uuid;        // of the file
    std::string describedBy; // the file that has the description; "": this one
    std::vector<OmeTiffImage> images;
    bool isWhole = false; // up to its end
};

bool isOfOme(std::string_view description);
OmeText readOmeText(std::string_view description);

} // namespace tessera
