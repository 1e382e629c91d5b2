// bricking/import/files/nrrd/nrrd_phase.h: one layer of an NRRD file as a volume: a phase of a series.
#pragma once

#include "bricking/import/files/nrrd/nrrd_grid.h"
#include "bricking/import/files/nrrd/nrrd_header.h"

#include <filesystem>
#include <memory>
#include <string>

namespace tessera {

/// True if the layers are volumes of several times: of kind "list", "time", "domain" or none that says more.
bool layersArePhases(const NrrdHeader& header, const NrrdGrid& grid);

/// Forward only: numbers of other layers are read over.
/// @param layer  from 0
/// @param grid   with the type of the volume's values
std::unique_ptr<SlabSource> openNrrdPhase(const NrrdHeader& header, const NrrdGrid& grid,
                                          const std::filesystem::path& path, int layer,
                                          std::string description);

} // namespace tessera
