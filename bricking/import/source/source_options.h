// bricking/import/source/source_options.h: the user's options for opening source files.
#pragma once

#include <filesystem>

namespace tessera {

struct SourceOptions {
    int series = 0; // DICOM: 1-based number from the list; 0: the only volume, or refuse with the list
    bool resampleZ = false; // DICOM: uneven slices are interpolated to an even spacing
    /// Folder for spooled data if the slowest axis changes; "": the folder for temporary files.
    std::filesystem::path scratchFolder = {};
    bool largest = false;      // of several volumes the largest CT, or the largest if there is no CT
    int phase = 0;             // DICOM: 1-based, of a series with several images at each position; 0: none
    bool allowMissing = false; // DICOM: files that could be slices and cannot be read are left out
};

} // namespace tessera
