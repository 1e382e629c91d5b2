// bricking/import/dicom/folder_walk.h: lists every file below a folder. It reports everything that it cannot
// read: unreadable folders, dangling links and files of other kinds.
#pragma once

#include "bricking/import/dicom/passed_over.h"

#include <filesystem>
#include <vector>

namespace tessera {

struct FolderFiles {
    std::vector<std::filesystem::path> files; // regular files, sorted; also through links
    std::vector<PassedFile> passed;
};

/// Everything below a folder. Stores (*.zarr) are not entered, because they have thousands of files and are
/// no source. Neither are the rubbish bins and index folders of operating systems. Links to folders are
/// counted and not followed.
FolderFiles walkFolder(const std::filesystem::path& folder);

/// Names that are never a slice's: ._*, .DS_Store, Thumbs.db, desktop.ini, DICOMDIR, README*, LICENSE*,
/// texts, tables, pictures, checksums and the like.
bool isNeverASlice(const std::filesystem::path& name);
/// Those of them that file systems and DICOM itself use: files that are not even opened (DICOMDIR has the
/// mark).
bool isNeverOpened(const std::filesystem::path& path);
/// True if a file has the mark of DICOM at byte 128, whatever its name.
bool hasSlicesMark(const std::filesystem::path& path);

/// The kind of a file by its first bytes.
enum class FileStart { dicom, other, empty, zeros, notReadable };
struct Beginning {
    FileStart kind = FileStart::other;
    std::string problem; // notReadable: the system's words
};
Beginning beginningOf(const std::filesystem::path& file);

} // namespace tessera
