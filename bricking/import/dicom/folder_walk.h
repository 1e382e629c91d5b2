// bricking/import/dicom/folder_walk.h: lists every file below a folder. It reports everything that it cannot
// read: unreadable folders, dangling links and files of other kinds. Skipped files, each with its reason.
// Every skipped file is reported.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace tessera {

enum class PassedReason {
    notSlice,          // by its name: README, .DS_Store, DICOMDIR and the like; never a slice
    notDicom,          // no known format by its first bytes
    empty,             // 0 bytes
    zeroFilled,        // nothing but zeros where a header should be
    notReadable,       // no permission, a dangling link, a disk error
    emptyFolder,       // in place of a slice or its folder
    folderNotReadable, // unreadable folder
    folderLink,        // links to folders are not followed
    damaged,           // a DICOM image or another volume file that cannot be used
    notImage,          // a DICOM object without slices; `found` says which
    noPlace,           // an image without a position in the patient, or of several values per pixel
    zarr               // a Zarr folder, which is not entered
};

struct PassedFile {
    std::filesystem::path path = {};
    PassedReason reason = PassedReason::notDicom;
    std::string expected = {}, found = {}; // damaged: both, for badFile(); notImage, noPlace: found
    /// The series named in its header, as an index of DicomScan::series; empty: unknown or another.
    std::optional<std::size_t> series = {};
    bool seriesIsAnother = false; // its header is intact and names a series without slices
};

/// "3 not DICOM (a, b, c), 2 empty (x, y)": by reason, with up to three names if they are useful. "" for
/// none. File names are made printable.
std::string countPassed(const std::vector<PassedFile>& passed);

/// "an empty file (0 bytes)": what the file is.
std::string foundIn(const PassedFile& file);

/// The reason as a JSON word: "notDicom".
const char* keyOf(PassedReason reason);

// Recognizes DICOM data sets without the preamble of 128 bytes and the mark "DICM", as from old archives and
// network dumps.

/// True if the first bytes of a file of that size are a data set in little endian, explicit or implicit.
/// Elements begin in group 0002 or 0008, ascend, and have lengths that fit.
bool looksLikeBareDicom(std::span<const std::byte> head, std::uint64_t fileBytes);

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
