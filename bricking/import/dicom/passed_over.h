// bricking/import/dicom/passed_over.h: files that were found and not used, each with its reason. No file is
// dropped without a word.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace tessera {

enum class PassedReason {
    notSlice,          // by its name: README, .DS_Store, DICOMDIR and the like; never a slice
    notDicom,          // begins as no format that is read
    empty,             // 0 bytes
    zeroFilled,        // nothing but zeros where a header should be
    notReadable,       // no permission, a link to nothing, a disk that fails
    emptyFolder,       // where a slice, or a slice's folder, could be
    folderNotReadable, // what it holds is not known
    folderLink,        // links to folders are not followed
    damaged,           // a DICOM image or another volume's file that cannot be used
    notImage,          // a DICOM object that is no picture of slices; `found` says what
    noPlace,           // an image without a position in the patient, or of several values per pixel
    zarr               // a Zarr folder, which is not entered
};

struct PassedFile {
    std::filesystem::path path = {};
    PassedReason reason = PassedReason::notDicom;
    std::string expected = {}, found = {}; // damaged: both, as badFile() says them; notImage, noPlace: found
    /// The series that its header names, as an index of DicomScan::series; empty: unknown or another.
    std::optional<std::size_t> series = {};
    bool seriesIsAnother = false; // its header is whole and names a series that has no slices
};

/// "3 not DICOM (a, b, c), 2 empty (x, y)": by reason, with up to three names where a reader may
/// want to look.
/// "" for none. File names are made printable.
std::string countPassed(const std::vector<PassedFile>& passed);

/// "an empty file (0 bytes)": what was found there.
std::string foundIn(const PassedFile& file);

/// The reason in a word for machines: "notDicom".
const char* keyOf(PassedReason reason);

} // namespace tessera
