// bricking/import/files/nrrd/nrrd.cpp: volumes in NRRD files (.nrrd, .nhdr).
#include "bricking/import/files/data_files.h"
#include "bricking/import/files/file_format.h"
#include "bricking/import/files/nrrd/nrrd_grid.h"
#include "bricking/import/files/nrrd/nrrd_header.h"
#include "bricking/import/files/nrrd/nrrd_phase.h"
#include "bricking/import/source/phase_choice.h"
#include "core/base/error.h"

#include <algorithm>
#include <cctype>
#include <string_view>
#include <vector>

namespace tessera {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kSegment = "Segment"; // of "Segment0_Name"

/// True for a segmentation of 3D Slicer: its header describes segments.
bool hasSegments(const NrrdHeader& header) {
    return std::any_of(header.pairs.begin(), header.pairs.end(), [](const auto& pair) {
        return pair.first.starts_with(kSegment) && pair.first.size() > kSegment.size() &&
               std::isdigit(static_cast<unsigned char>(pair.first[kSegment.size()]));
    });
}

std::unique_ptr<SlabSource> openNrrd(const fs::path& path, const SourceOptions& options) {
    const std::string where = path.string();
    NrrdHeader header = readNrrdHeader(InputFile(path));
    if (hasSegments(header))
        throw badFile(where, "a volume", "a segmentation of 3D Slicer, which --labels takes");
    NrrdGrid grid = nrrdGridOf(header, where, options.spacingMm);
    const bool hasPhases = layersArePhases(header, grid);
    if (grid.layers > 1 && !hasPhases)
        throw badFile(where, "a volume of one value per voxel", std::to_string(grid.layers) + " values");
    const auto layer = static_cast<int>(chosenPhase(
        hasPhases ? phaseLabels(static_cast<std::size_t>(grid.layers)) : std::vector<std::string>{},
        options.phase, where));
    if (!grid.saysSpacing && !options.spacingMm)
        throw spacingUnknown(where, "an NRRD file whose axes have no spacing in a unit that is known");
    if (grid.saysSpacing && options.spacingMm)
        throw badFile(where, "a file that does not say its spacing, for --spacing", "one that does");
    checkDataLengths(header, path);
    grid.info.type = storedTypeOf(dataType(header));
    if (header.sampleUnits == "HU" || header.sampleUnits == "\"HU\"")
        grid.info.unit = "HU";
    grid.info.remarks.insert(grid.info.remarks.end(), grid.notes.begin(), grid.notes.end());
    const bool isPacked = header.encoding == DataEncoding::gzip;
    const std::string what = std::string("NRRD (") + (isPacked ? "gzip), " : "raw), ") + name(header.type);
    return hasPhases ? openNrrdPhase(header, grid, path, layer, what)
                     : openDataFiles(header, path, grid.info, what);
}

std::vector<std::string> phasesOfNrrd(const fs::path& path) {
    const NrrdHeader header = readNrrdHeader(InputFile(path));
    const NrrdGrid grid = nrrdGridOf(header, path.string(), glm::dvec3(1));
    return layersArePhases(header, grid) ? phaseLabels(static_cast<std::size_t>(grid.layers))
                                         : std::vector<std::string>{};
}

bool isVolume(const fs::path& path) {
    try {
        return !hasSegments(readNrrdHeader(InputFile(path)));
    } catch (const Error&) {
        return true; // opening it tells what is wrong
    }
}

std::vector<fs::path> dataFilesOf(const fs::path& path) {
    try {
        return readNrrdHeader(InputFile(path)).dataFiles;
    } catch (const Error&) {
        return {};
    }
}

} // namespace

FileFormat nrrdFormat() {
    return {.inFolders = "NRRD files",
            .named = ".nrrd, .nhdr",
            .open = openNrrd,
            .isMeant = isVolume,
            .parts = dataFilesOf,
            .takesSpacing = true,
            .phases = phasesOfNrrd};
}

} // namespace tessera
