// bricking/import/files/file_volume.h: the volumes of a file that holds several: channels, images and grids,
// each at one time or at several.
#pragma once

#include <string>
#include <vector>

namespace tessera {

struct FileVolume {
    std::string name; // "channel 2 (DAPI)"; "": the file has no other
    /// What SourceOptions::series calls it in FileFormat::open(), at each of its times; at least one.
    std::vector<int> numbers;
    std::vector<std::string> times = {}; // labels, as many; empty: one time
};

} // namespace tessera
