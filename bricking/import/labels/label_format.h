// bricking/import/labels/label_format.h: a format of files that hold labels of voxels, and the table of
// formats. A format is a folder beside this file (tessera_label_format() in cmake/Format.cmake).
#pragma once

#include "bricking/import/source/slab_source.h"
#include "bricking/labels/label_source.h"

#include <filesystem>
#include <string>
#include <vector>

namespace tessera {

struct LabelFormat {
    std::string named; ///< "NIfTI files (.nii, .nii.gz)": for messages
    /// Opens a file or, where isMeant says so, a folder; reads headers alone. Throws InputError naming the
    /// file if it holds no labels of the format.
    LabelFile (*open)(const std::filesystem::path& path, const SourceOptions& options) = nullptr;
    /// True if a file or folder of any name is of the format, by its first bytes or its content; it throws
    /// nothing. Asked where no ending decides. Null: the ending alone decides.
    bool (*isMeant)(const std::filesystem::path& path) = nullptr;
    /// True: a folder of such files is a segmentation of one mask a file.
    bool areMasks = false;
    std::vector<std::string> endings = {}; ///< of names, lower case: from the format's CMakeLists.txt
};

/// By their folders' names. Defined by the build.
const std::vector<LabelFormat>& labelFormats();

/// The format with the longest ending that matches a file's name, in any case; else the first whose isMeant()
/// accepts the path; null: none does. A folder has no ending.
const LabelFormat* labelFormatOf(const std::filesystem::path& path);

/// A file's name without the ending of the format, in any case.
std::string nameWithoutEnding(const std::filesystem::path& file, const LabelFormat& format);

/// "NIfTI files (.nii, .nii.gz) or ...": of all formats, for messages.
std::string namedLabelFormats();

} // namespace tessera
