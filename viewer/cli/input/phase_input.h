// viewer/cli/input/phase_input.h: the phases of a volume: images of the same place at several times, each a
// store of its own.
#pragma once

#include "core/base/budget.h"
#include "core/scene/annotations.h"
#include "core/scene/scene.h"
#include "viewer/cli/input/volume_input.h"
#include "viewer/cli/options/options.h"

#include <filesystem>
#include <string>
#include <vector>

namespace tessera {

struct PhaseStores {
    std::vector<std::string> labels;           // "phase 40 %", "time 2"
    std::vector<std::filesystem::path> stores; // as many, in the order of --phase
};

/// The phases of one volume of source files, and which of them is chosen.
struct PhaseList {
    std::vector<std::string> labels; // in the order of --phase; empty: it has one
    int phase = 0;                   // from 1
    int series = 0;                  // the number for --series beside --phase; 0: none is needed
};
/// Of the volume that a choice names. Reads headers. Throws InputError where it names none.
PhaseList phasesOf(const std::filesystem::path& path, const SourceChoice& choice);
/// The same of an open volume, by the choice that opened it: headers are read where it may be of a phase.
PhaseList phasesOfOpen(const std::filesystem::path& path, const SourceChoice& choice);

/// Sets the label of the phase that a choice names into words that have kPhasePlace. Reads headers. Throws
/// InputError naming the place for a volume without phases and for words that grow too long, and as
/// phasesOf() does.
void namePhase(Annotations& words, const std::filesystem::path& path, const SourceChoice& choice);
/// The same of a known label.
void namePhase(Annotations& words, const std::string& label);

/// The stores of all phases of a volume's source files, imported now where the cache has none (storeFor()).
/// Throws InputError naming the path for a store, for files without phases, and where several series have
/// some and none is chosen; as storeFor() does for a phase that cannot be imported.
PhaseStores storesOfPhases(const SceneVolume& volume, const InputOptions& named, MemoryBudget& ram,
                           const CommonOptions& common);

} // namespace tessera
