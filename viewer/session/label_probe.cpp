// viewer/session/label_probe.cpp: see label_probe.h.
#include "viewer/session/label_probe.h"

#if TESSERA_WITH_IMPORT
#include "bricking/import/labels/open_labels.h"
#include "bricking/import/source/format_endings.h"
#include "bricking/labels/lattice_match.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"

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

} // namespace

bool mayBeLabelsOf(const VolumeInfo& volume, const std::filesystem::path& file) {
    std::error_code none;
    if (!hasEndingOfVolumes(file) || !std::filesystem::is_regular_file(file, none))
        return false;
    try {
        const LabelFile labels = openLabels(file, {});
        return labels.layers.size() == 1 && labels.layers.front()->hasWholeType() &&
               latticeMatch(labels.layers.front()->info(), volume).isSame &&
               hasFewValues(*labels.layers.front());
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
