// bricking/import/files/file_format.h: a format of files that are volumes by themselves, and the table of
// formats. A format is a folder beside this file (cmake/Format.cmake).
#pragma once

#include "bricking/import/files/file_volume.h"
#include "bricking/import/source/slab_source.h"

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace tessera {

struct FileFormat {
    std::string inFolders; ///< "NIfTI files": for messages about folders; "": not looked for in folders
    std::string named;     ///< ".nii, .nii.gz": for messages about single files
    /// Opens a file in its own voxel order, reading headers alone. Throws InputError naming the file if it is
    /// no volume of the format.
    std::unique_ptr<SlabSource> (*open)(const std::filesystem::path& file,
                                        const SourceOptions& options) = nullptr;
    /// True if a file of a folder with the format's ending is a volume; others are skipped. Null: all are.
    bool (*isMeant)(const std::filesystem::path& file) = nullptr;
    /// Other files of the volume, which are no volumes themselves. Null: there are none.
    std::vector<std::filesystem::path> (*parts)(const std::filesystem::path& file) = nullptr;
    bool takesSpacing = false; ///< SourceOptions::spacingMm, of files that do not say theirs
    /// Opens slices that are files of one folder. Null: the format has none. Throws InputError naming file or
    /// folder.
    std::unique_ptr<SlabSource> (*openStack)(const std::filesystem::path& folder,
                                             const std::vector<std::filesystem::path>& slices,
                                             const SourceOptions& options) = nullptr;
    std::vector<std::string> sliceEndings = {}; ///< of slices' names, lower case
    /// True for a folder that is one file of the format. Null: files alone are.
    bool (*isFolder)(const std::filesystem::path& folder) = nullptr;
    /// Of a file of several volumes, or of one at several times. SourceOptions::series chooses one of their
    /// numbers. Empty: it holds one at one time, as all files of the format do where this is null. Throws
    /// InputError as open() does.
    std::vector<FileVolume> (*volumes)(const std::filesystem::path& file) = nullptr;
    bool hasLevels = false; ///< files may have several: SlabSource::fileLevels()
    /// Of a format without volumes(), a file that holds a volume at several times: their labels.
    /// SourceOptions::phase chooses, from 1. Empty: one time, as of all files of the format where this is
    /// null. Throws InputError as open() does.
    std::vector<std::string> (*phases)(const std::filesystem::path& file) = nullptr;
    std::vector<std::string> endings = {}; ///< of names, lower case: from the format's CMakeLists.txt
};

/// By their folders' names. Defined by the build.
const std::vector<FileFormat>& fileFormats();

/// Of a folder, the format that it is a file of. Of a file, that with the longest ending that matches its
/// name, in any case. Null: none.
const FileFormat* fileFormatOf(const std::filesystem::path& file);

/// For a file without a spacing: it names the option.
BadFile spacingUnknown(const std::string& path, const std::string& found);

/// The format whose slices have a file's ending, in any case; null: none.
const FileFormat* stackFormatOf(const std::filesystem::path& file);

/// "a DICOM folder, .nii or .json": for messages: `first`, then a text of every format.
std::string withFormats(const std::string& first, std::string FileFormat::*text);

// Recognizes unsupported formats, so that a refusal can name them and advise.

struct ForeignFormat {
    std::string what;   // "a VTK image"; "" if unknown
    std::string advice; // "convert it to .nii.gz (3D Slicer saves it as NIfTI)"; may be ""
    bool known() const { return !what.empty(); }
    std::string text() const { return advice.empty() ? what : what + ": " + advice; }
};

/// By the name and first bytes of a file or folder. It knows a .zarr without metadata, DICOMDIR, and volumes,
/// archives and pictures by their extensions and magic numbers.
ForeignFormat foreignFormatOf(const std::filesystem::path& path);

/// The foreign volumes among files: "a VTK image (a.vti), ..."; "" for none. With the advice for
/// the first.
std::string countForeign(const std::vector<std::filesystem::path>& files);

} // namespace tessera
