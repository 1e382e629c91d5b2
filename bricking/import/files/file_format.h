// bricking/import/files/file_format.h: a format of files that are volumes by themselves, and the table of
// formats. A format is a folder beside this file (cmake/Format.cmake).
#pragma once

#include "bricking/import/source/slab_source.h"

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace tessera {

struct FileFormat {
    std::string inFolders; ///< "NIfTI files": what messages expect in a folder
    std::string named;     ///< ".nii, .nii.gz": and where one file is named
    /// Opens a file in its own voxel order, reading headers alone. Throws InputError naming the file where it
    /// is no volume of the format.
    std::unique_ptr<SlabSource> (*open)(const std::filesystem::path& file) = nullptr;
    /// Whether a file with the format's ending that nobody named is meant: others are passed over. Null: all.
    bool (*isMeant)(const std::filesystem::path& file) = nullptr;
    /// Other files of the volume, which are none of their own. Null: there are none.
    std::vector<std::filesystem::path> (*parts)(const std::filesystem::path& file) = nullptr;
    std::vector<std::string> endings = {}; ///< of names, lower case: from the format's CMakeLists.txt
};

/// By their folders' names. Defined by the build.
const std::vector<FileFormat>& fileFormats();

/// The format with the longest of the endings that a file's name has, in either case; null: none has.
const FileFormat* fileFormatOf(const std::filesystem::path& file);

/// "a DICOM folder, .nii or .json": what messages expect, `first` and then a text of every format.
std::string withFormats(const std::string& first, std::string FileFormat::*text);

} // namespace tessera
