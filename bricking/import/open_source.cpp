// bricking/import/open_source.cpp: see open_source.h.
#include "bricking/import/open_source.h"

#include "bricking/import/dicom.h"
#include "bricking/import/dicom_scan.h"
#include "bricking/import/input_file.h"
#include "bricking/import/nifti.h"
#include "bricking/import/oriented_source.h"
#include "bricking/import/raw.h"
#include "core/error.h"

#include <algorithm>
#include <system_error>

namespace tessera {
namespace {

namespace fs = std::filesystem;

bool endsWith(const fs::path& path, const std::string& ending) {
    std::string name = path.filename().string();
    std::transform(name.begin(), name.end(), name.begin(),
                   [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
    return name.size() > ending.size() &&
           name.compare(name.size() - ending.size(), ending.size(), ending) == 0;
}

bool hasNiftiName(const fs::path& path) {
    return endsWith(path, ".nii") || endsWith(path, ".nii.gz");
}

/// The formats of single files; null where the file is none of them.
std::unique_ptr<SlabSource> openSingleFile(const fs::path& path) {
    if (hasNiftiName(path))
        return openNifti(path);
    if (endsWith(path, ".json"))
        return openRaw(path);
    return nullptr;
}

/// Volumes in files that stand alone, NIfTI and raw with sidecar.
void listSingleFile(const fs::path& path, std::vector<SourceCandidate>& found) {
    try {
        if (endsWith(path, ".json") && !looksLikeRawSidecar(path))
            return;
        const auto source = openSingleFile(path);
        if (!source)
            return;
        const VolumeInfo info = orientedInfo(source->info());
        found.push_back({path, 0, info.acquisition.modality, info});
    } catch (const Error&) { // not a volume after all: left out, openSource() says why
    }
}

} // namespace

std::unique_ptr<SlabSource> openSource(const fs::path& path, const SourceOptions& options) {
    std::error_code error;
    if (!fs::exists(path, error))
        throw badFile(path.string(), "a file or a folder", "nothing there");
    std::unique_ptr<SlabSource> source;
    if (fs::is_directory(path, error) || looksLikeDicom(path))
        source = openDicom(path, options.series, options.resampleZ);
    else
        source = openSingleFile(path);
    if (!source)
        throw badFile(path.string(),
                      "a DICOM file or folder, .nii, .nii.gz or the .json sidecar of a raw file",
                      "a file of another kind");
    return orientToLps(std::move(source), options.scratchFolder);
}

std::vector<SourceCandidate> listVolumes(const fs::path& path) {
    std::vector<SourceCandidate> found;
    std::error_code error;
    if (!fs::exists(path, error))
        return found;
    if (fs::is_directory(path, error)) {
        for (const fs::path& file : sourceFilesBelow(path))
            listSingleFile(file, found);
    } else {
        listSingleFile(path, found);
    }
    if (fs::is_directory(path, error) || looksLikeDicom(path))
        for (const DicomListing& listing : listDicom(path)) {
            const VolumeInfo info = orientedInfo(listing.info);
            found.push_back({path, listing.series, info.acquisition.modality, info});
        }
    std::stable_sort(found.begin(), found.end(), [](const SourceCandidate& a, const SourceCandidate& b) {
        return a.info.voxelCount() > b.info.voxelCount();
    });
    return found;
}

} // namespace tessera
