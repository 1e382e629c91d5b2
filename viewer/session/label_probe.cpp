// viewer/session/label_probe.cpp: see label_probe.h.
#include "viewer/session/label_probe.h"

#if TESSERA_WITH_IMPORT
#include "bricking/import/labels/open_labels.h"
#include "bricking/import/source/format_endings.h"
#include "bricking/labels/lattice_match.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "viewer/cli/input/structure_input.h" // beginsAsDicom

#include <algorithm>
#include <cctype>
#include <set>
#include <string>
#include <vector>

namespace tessera {
namespace {

bool hasEndingOfVolumes(const std::filesystem::path& file) {
    std::string name = file.filename().string();
    std::transform(name.begin(), name.end(), name.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return std::ranges::any_of(volumeFileEndings(),
                               [&](const std::string& ending) { return name.ends_with(ending); });
}

bool hasFewValues(LabelLayer& layer) {
    const glm::ivec3 extent = layer.info().extentVoxels;
    std::vector<std::uint32_t> slice(static_cast<std::size_t>(extent.x) * static_cast<std::size_t>(extent.y));
    std::set<std::uint32_t> values;
    for (int z = 0; z < extent.z; ++z) {
        checkInterrupted();
        layer.readSlices(1, slice);
        std::uint32_t last = 0;
        for (const std::uint32_t value : slice) {
            if (value != last)
                values.insert(value);
            last = value;
        }
        if (values.size() > kMostProbedLabels)
            return false;
    }
    return !values.empty();
}

bool isOnLattice(const LabelFile& labels, const VolumeInfo& volume) {
    return labels.layers.size() == 1 && labels.layers.front()->hasWholeType() &&
           latticeMatch(labels.layers.front()->info(), volume).isSame;
}

enum class Masked { none, something, several }; // values besides 0

/// Of the first slice with something in it: that of a scan has many values. Throws InputError for values that
/// are no labels.
Masked maskedBy(LabelLayer& layer) {
    const glm::ivec3 extent = layer.info().extentVoxels;
    std::vector<std::uint32_t> slice(static_cast<std::size_t>(extent.x) * static_cast<std::size_t>(extent.y));
    for (int z = 0; z < extent.z; ++z) {
        checkInterrupted();
        layer.readSlices(1, slice);
        const auto isSet = [](std::uint32_t value) { return value != 0; };
        const auto first = std::ranges::find_if(slice, isSet);
        if (first == slice.end())
            continue;
        return std::all_of(first, slice.end(), [&](auto value) { return value == 0 || value == *first; })
                   ? Masked::something
                   : Masked::several;
    }
    return Masked::none;
}

bool mayBeMasksOf(const VolumeInfo& volume, const std::filesystem::path& folder) {
    std::error_code none;
    bool isSomething = false;
    for (std::filesystem::directory_iterator at(folder, none), end; !none && at != end; at.increment(none)) {
        const std::filesystem::path& file = at->path();
        if (file.filename().string().starts_with('.'))
            continue;
        if (!std::filesystem::is_regular_file(file, none) || beginsAsDicom(file))
            return false;
        LabelFile labels;
        try {
            labels = openLabels(file, {});
        } catch (const InputError&) { // of another kind, which the import leaves out; or damaged, as it says
            continue;
        }
        const Masked masked =
            isOnLattice(labels, volume) ? maskedBy(*labels.layers.front()) : Masked::several;
        if (masked == Masked::several)
            return false;
        isSomething = isSomething || masked == Masked::something;
    }
    return !none && isSomething;
}

} // namespace

bool mayBeLabelsOf(const VolumeInfo& volume, const std::filesystem::path& file) {
    std::error_code none;
    const bool isFolder = std::filesystem::is_directory(file, none);
    if (!isFolder && (!hasEndingOfVolumes(file) || !std::filesystem::is_regular_file(file, none)))
        return false;
    try {
        if (isFolder)
            return mayBeMasksOf(volume, file);
        const LabelFile labels = openLabels(file, {});
        return labels.labels.empty() && // of a file that describes labels there is no doubt
               isOnLattice(labels, volume) && hasFewValues(*labels.layers.front());
    } catch (const Error&) {
        return false;
    }
}

} // namespace tessera
#else
namespace tessera {
bool mayBeLabelsOf(const VolumeInfo&, const std::filesystem::path&) {
    return false;
}
} // namespace tessera
#endif
