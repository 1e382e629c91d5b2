// bricking/import/dicom/passed_over.h: skipped files, each with its reason. Every skipped file is reported.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
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

} // namespace tessera
