// bricking/import/dicom/folder_walk.h: lists every file below a folder, and what could not be read. Nothing
// is left out without a word: unreadable folders, dangling links and files of other kinds are reported.
#pragma once

#include "bricking/import/dicom/passed_over.h"

#include <filesystem>
#include <vector>

namespace tessera {

struct FolderFiles {
    std::vector<std::filesystem::path> files; // regular files, sorted; by links too
    std::vector<PassedFile> passed;
};

/// Everything below a folder. Stores (*.zarr) are not entered, for they have thousands of files and are no
/// source; neither are the rubbish bins and index folders of operating systems; links to folders are counted
/// and not followed.
FolderFiles walkFolder(const std::filesystem::path& folder);

/// Names that are never a slice's: ._*, .DS_Store, Thumbs.db, desktop.ini, DICOMDIR, README*, LICENSE*,
/// texts, tables, pictures, checksums and the like.
bool isNeverASlice(const std::filesystem::path& name);
/// Of these, the names that file systems and DICOM itself give: not even looked into (DICOMDIR has the mark).
bool isNeverOpened(const std::filesystem::path& path);
/// Whether a file has the mark of DICOM at byte 128, whatever its name.
bool hasSlicesMark(const std::filesystem::path& path);

/// How a file begins, as far as it takes to tell a DICOM file from others.
enum class FileStart { dicom, other, empty, zeros, notReadable };
struct Beginning {
    FileStart kind = FileStart::other;
    std::string problem; // notReadable: the system's words
};
Beginning beginningOf(const std::filesystem::path& file);

} // namespace tessera
