// bricking/import/part_facts.h: what is known of a finished part of an import: its files, and what its voxels
// told. It is kept as "part.json" in the part's folder, written last and with a checksum. A part without it,
// or with a file of another size, does not count.
#pragma once

#include "bricking/import/source/slab_source.h"
#include "bricking/store/volume_parts.h"
#include "core/base/volume.h"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace tessera {

/// What a source tells from voxels. Of parts, it is added.
struct VoxelFindings {
    std::uint64_t nonFiniteVoxels = 0, clampedVoxels = 0;
    double absentStored = 0; // where nonFiniteVoxels is not 0
    bool lossy = false;
    VoxelTally tally;
    std::vector<std::string> notes; // without those of the tally

    void add(const VoxelFindings& part);
    /// @param info  as it was before the first slice
    VolumeInfo applied(VolumeInfo info) const;
};

struct PartFacts {
    WrittenPart written;
    VoxelFindings findings;
    std::uint64_t bytesIn = 0;
};

/// What the parts of an import must agree in.
struct PartsOfImport {
    std::string key; // of WorkFolder
    VolumeInfo info;
    VolumeParts parts;
};

void writePartFacts(const std::filesystem::path& folder, const PartsOfImport& all, int part,
                    const PartFacts& facts);
/// nullopt for a part that does not count.
/// @param store  where joinParts() moves files
std::optional<PartFacts> readPartFacts(const std::filesystem::path& folder, const PartsOfImport& all,
                                       int part, const std::filesystem::path& store);

} // namespace tessera
