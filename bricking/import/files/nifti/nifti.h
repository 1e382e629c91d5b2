// bricking/import/files/nifti/nifti.h: NIfTI-1 and NIfTI-2, single file (.nii, .nii.gz), with a header parser
// of our own. Orientation: sform, else qform, else spacing alone; from the format's RAS to LPS.
#pragma once

#include "bricking/import/files/file_reading.h"
#include "bricking/import/source/slab_source.h"
#include "bricking/import/source/slice_converter.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>

namespace tessera {

constexpr std::size_t kNiftiHeaderBytes = 540; // of version 2; version 1 needs the first 348

struct NiftiHeader {
    VolumeInfo info;
    FileType type = FileType::i16;
    bool bigEndian = false;
    std::uint64_t dataOffsetBytes = 0;
    int version = 1;
    std::string orientation; // "sform", "qform" or "spacing only"
    int times = 1;           // volumes behind one another, dim[4]
    double stepSeconds = 0;  // between them; 0: not known
};

/// Parses the first bytes of a (decompressed) file: at least 348, at most kNiftiHeaderBytes of them.
/// Throws InputError naming `where` for another format, a detached header (.hdr/.img), several values per
/// voxel (dim[5..7] above 1), an unsupported type, and for geometry that is no volume.
NiftiHeader parseNiftiHeader(std::span<const std::byte> bytes, const std::string& where);

/// A file whose header is read, and whose length was checked against it.
struct NiftiFile {
    InputFile file;
    NiftiHeader header;
    bool isGzip = false;
};
/// Throws InputError as parseNiftiHeader() does, and for a file that is shorter than its header says (for
/// gzip: shorter than any compression could make it).
NiftiFile openNiftiFile(const std::filesystem::path& path);
/// Of a gzip file, from the first voxel of a time on, from 0.
GzipStream niftiVoxels(const std::filesystem::path& path, const NiftiHeader& header, int time = 0);
/// A surplus of a row or more means that header and voxels do not belong together: a dimension is wrong, or
/// there are more volumes than the header tells. Throws InputError naming the file.
void checkNiftiSurplus(const std::string& path, const NiftiHeader& header, std::uint64_t surplusBytes);

/// Opens a file in its own voxel order. Reads the header only. Throws InputError as above, and if the file is
/// shorter than its header says (for gzip: shorter than any compression could make it).
/// @param phase  from 1, of a file with several times; 0: none. Throws InputError as chosenPhase() does.
std::unique_ptr<SlabSource> openNifti(const std::filesystem::path& path, int phase);

} // namespace tessera
