// bricking/import/open_source.cpp: see open_source.h.
#include "bricking/import/open_source.h"

#include "bricking/import/catalogue.h"

#include <algorithm>
#include <system_error>

namespace tessera {

std::unique_ptr<SlabSource> openSource(const std::filesystem::path& path, const SourceOptions& options) {
    const Catalogue catalogue = lookThrough(path, options);
    return openRow(catalogue, chooseRow(catalogue, options), options);
}

std::vector<SourceCandidate> listVolumes(const std::filesystem::path& path) {
    std::vector<SourceCandidate> found;
    std::error_code error;
    if (!std::filesystem::exists(path, error))
        return found;
    for (const CatalogueRow& row : lookThrough(path).rows)
        if (row.info)
            found.push_back({row.path, row.series, row.modality, *row.info});
    std::stable_sort(found.begin(), found.end(), [](const SourceCandidate& a, const SourceCandidate& b) {
        return a.info.voxelCount() > b.info.voxelCount();
    });
    return found;
}

} // namespace tessera
