// viewer/cli/input/phase_input.cpp: see phase_input.h.
#include "viewer/cli/input/phase_input.h"

#include "core/base/error.h"

#include <algorithm>

namespace tessera {
namespace {

/// The row of files whose phases are meant.
const ListedRow& rowWithPhases(const InputListing& listing, int series, const std::string& path) {
    const ListedRow* found = nullptr;
    std::size_t count = 0;
    for (const ListedRow& row : listing.rows)
        if (!row.phases.empty() && (series == 0 || row.series == series)) {
            ++count;
            found = &row;
        }
    if (count == 0)
        throw badFile(path, "images of several phases for --phase all", "one at each position");
    if (count > 1)
        throw badFile(path, "one series with phases, or a choice with --series N",
                      std::to_string(count) + " of them");
    return *found;
}

} // namespace

PhaseStores storesOfPhases(const SceneVolume& volume, const InputOptions& named, MemoryBudget& ram,
                           const CommonOptions& common) {
    const std::string path = volume.path.string();
    if (looksLikeStore(volume.path))
        throw badFile(path, "source files for --phase to choose from", "a store, which holds one volume");
    const bool isNamed = static_cast<const SourceChoice&>(named) != SourceChoice{};
    InputOptions options = isNamed ? named : InputOptions(volume.source);
    const InputListing listing = listInput(volume.path, options);
    PhaseStores phases;
    for (const ListedRow& row : listing.rows)
        if (row.time > 0 && options.series == 0)
            phases.labels.push_back(row.what);
    if (phases.labels.empty()) {
        const ListedRow& row = rowWithPhases(listing, options.series, path);
        if (row.series > 0)
            options.series = row.series;
        phases.labels = row.phases;
    }
    for (std::size_t n = 0; n < phases.labels.size(); ++n) {
        options.phase = static_cast<int>(n) + 1;
        common.detail("phase " + std::to_string(options.phase) + " of " +
                      std::to_string(phases.labels.size()) + ": " + phases.labels[n]);
        phases.stores.push_back(storeFor(volume.path, options, ram, common));
    }
    return phases;
}

} // namespace tessera
