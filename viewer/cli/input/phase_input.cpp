// viewer/cli/input/phase_input.cpp: see phase_input.h.
#include "viewer/cli/input/phase_input.h"

#include "core/base/error.h"
#include "viewer/cli/input/remote_input.h"
#if TESSERA_WITH_IMPORT
#include "bricking/import/catalogue.h"
#endif

#include <algorithm>
#include <system_error>

namespace tessera {
namespace {

/// The row of files whose phases are meant.
const ListedRow& rowWithPhases(const InputListing& listing, int series, const std::string& path) {
    const ListedRow* found = nullptr;
    std::size_t count = 0;
    for (const ListedRow& row : listing.rows)
        if (!row.phases.empty() && (series == 0 || row.series == series ||
                                    (row.series == 0 && series == 1 && listing.rows.size() == 1))) {
            ++count;
            found = &row;
        }
    if (count == 0 && series > 0 && !listing.rows.empty())
        throw InputError(std::string(badFile(path, "the number of a series of several phases for --phase all",
                                             "--series " + std::to_string(series))
                                         .what()) +
                         "\n" + listing.table);
    if (count == 0)
        throw badFile(path, "images of several phases for --phase all", "one at each position");
    if (count > 1)
        throw badFile(path, "one series with phases, or a choice with --series N",
                      std::to_string(count) + " of them");
    return *found;
}

} // namespace

#if TESSERA_WITH_IMPORT
PhaseList phasesOf(const std::filesystem::path& given, const SourceChoice& choice) {
    const std::filesystem::path path = reached(given);
    if (looksLikeStore(path))
        return {};
    SourceOptions source;
    source.series = choice.series;
    source.phase = choice.phase;
    source.largest = choice.largest;
    source.allowMissing = choice.allowMissing;
    source.spacingMm = choice.spacingMm;
    const Catalogue catalogue = lookThrough(path, source);
    const CatalogueRow& row = chooseRow(catalogue, source);
    if (row.phases.size() < 2)
        return {};
    return {row.phases, phaseOf(row, source), row.series};
}

PhaseList phasesOfOpen(const std::filesystem::path& path, const SourceChoice& choice) {
    std::error_code ignored;
    const bool isFile = !std::filesystem::is_directory(path, ignored) || mayHaveLevels(path);
    return choice.phase > 0 || (isFile && (choice.series > 0 || choice.largest)) ? phasesOf(path, choice)
                                                                                 : PhaseList{};
}
#else
PhaseList phasesOf(const std::filesystem::path&, const SourceChoice&) {
    return {};
}
PhaseList phasesOfOpen(const std::filesystem::path&, const SourceChoice&) {
    return {};
}
#endif

void namePhase(Annotations& words, const std::filesystem::path& path, const SourceChoice& choice) {
    if (!words.namesPhase())
        return;
    const PhaseList phases = phasesOf(path, choice);
    const auto number = static_cast<std::size_t>(std::max(phases.phase, 0));
    if (number == 0 || number > phases.labels.size())
        throw badFile(std::string(kPhasePlace) + " in words",
                      "source files of several phases, and --phase N or all",
                      looksLikeStore(path)    ? "a store, which holds one volume"
                      : phases.labels.empty() ? "files of one"
                                              : "no choice of one");
    namePhase(words, phases.labels[number - 1]);
}

void namePhase(Annotations& words, const std::string& label) {
    if (!words.namePhase(label))
        throw badFile(std::string(kPhasePlace) + " in words",
                      "at most " + std::to_string(Annotations::kMostLetters) + " letters with " + label,
                      "more");
}

PhaseStores storesOfPhases(const SceneVolume& volume, const InputOptions& named, MemoryBudget& ram,
                           const CommonOptions& common) {
    const std::string path = volume.path.string();
    if (looksLikeStore(volume.path))
        throw badFile(path, "source files for --phase to choose from", "a store, which holds one volume");
    const bool isNamed = static_cast<const SourceChoice&>(named) != SourceChoice{};
    InputOptions options = isNamed ? named : InputOptions(volume.source);
    options.allPhases = true;
    const InputListing listing = listInput(volume.path, options);
    PhaseStores phases;
    const ListedRow& row = rowWithPhases(listing, options.series, path);
    if (row.series > 0)
        options.series = row.series;
    phases.labels = row.phases;
    for (std::size_t n = 0; n < phases.labels.size(); ++n) {
        options.phase = static_cast<int>(n) + 1;
        common.detail("phase " + std::to_string(options.phase) + " of " +
                      std::to_string(phases.labels.size()) + ": " + phases.labels[n]);
        phases.stores.push_back(storeFor(volume.path, options, ram, common));
    }
    return phases;
}

} // namespace tessera
