// viewer/window/folder_listing.h: lists the entries of a folder that a window can open.
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
    std::size_t otherFiles = 0;       // possible DICOM slices: such a folder is opened as a whole
    std::string problem;              // reason if it cannot be read; empty: it can
};

/// Uses names only. Stores (*.zarr), NIfTI and .json files are entries; hidden files are left out. Throws
/// nothing.
FolderListing listFolder(const std::filesystem::path& folder);

/// The nearest existing folder at or above a path.
std::filesystem::path folderAt(const std::filesystem::path& path);

} // namespace tessera
