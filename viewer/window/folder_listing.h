// viewer/window/folder_listing.h: lists what a window could open in a folder.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace tessera {

struct FolderEntry {
    enum class Kind { folder, store, file } kind = Kind::folder;
    std::filesystem::path path;
    std::string name; // for people: printable
};

struct FolderListing {
    std::filesystem::path folder;     // absolute
    std::vector<FolderEntry> entries; // folders first, each kind by name, numbers in it by their value
    std::size_t otherFiles = 0;       // that may be DICOM slices: such a folder is opened as a whole
    std::string problem;              // why it cannot be read; empty: it can
};

/// Names alone are looked at. Stores (*.zarr) are entries, as are NIfTI and .json files; what is hidden is
/// left out. Throws nothing.
FolderListing listFolder(const std::filesystem::path& folder);

/// The nearest folder at or above a path that is there.
std::filesystem::path folderAt(const std::filesystem::path& path);

} // namespace tessera
