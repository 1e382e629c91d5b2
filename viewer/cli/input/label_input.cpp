// viewer/cli/input/label_input.cpp: see label_input.h.
#include "viewer/cli/input/label_input.h"

#include "bricking/labels/label_import.h"
#include "bricking/labels/label_volume.h"
#include "bricking/store/store_reader.h"
#include "core/base/error.h"
#include "viewer/cli/input/import_cache.h"
#include "viewer/cli/input/volume_input.h"
#if TESSERA_WITH_IMPORT
#include "bricking/import/labels/open_labels.h"
#endif

#include <cstdio>

namespace tessera {
namespace {

namespace fs = std::filesystem;

/// All that an import depends on besides the files.
std::string keyOf(const VolumeInfo& scan, const Labels& labels) {
    std::string key = "labels " + std::to_string(kLabelImportVersion) + "|" +
                      std::to_string(labels.sameFrame) + "|" + scan.frameOfReference + "|" +
                      formatExtent(scan.extentVoxels);
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 3; ++row) {
            char text[40];
            std::snprintf(text, sizeof text, "|%a", scan.patientFromVoxel[column][row]);
            key += text;
        }
    return key;
}

/// True for a store of a scan in which another program has put labels (OME-Zarr's "labels").
bool isScanWithLabels(const fs::path& store) {
    std::error_code ignored;
    return fs::is_directory(store / "labels", ignored) && !fs::exists(store / "sets", ignored);
}

} // namespace

#if TESSERA_WITH_IMPORT
void importLabelsFor(const VolumeInfo& scan, Labels& labels, MemoryBudget& ram, const CommonOptions& common) {
    if (labels.path.empty())
        return;
    std::error_code ignored;
    if (!fs::exists(labels.path, ignored))
        throw badFile(labels.path.string(), "a file or folder of labels", "nothing there");
    if (looksLikeStore(labels.path) && !isScanWithLabels(labels.path)) { // an import that was kept
        if (!labels.sameFrame)
            requireSameFrame(StoreReader(labels.path, ram).info().frameOfReference, scan,
                             labels.path.string());
        labels.store = labels.path;
        return;
    }
    const MakeStore make = [&](const StoreToMake& wanted) {
        const fs::path& store = wanted.store;
        SourceOptions source;
        source.scratchFolder = store.parent_path();
        LabelFile file = openLabels(labels.path, source);
        LabelImportOptions import;
        import.durable = wanted.durable;
        import.progress = common.progress.get();
        import.sameFrame = labels.sameFrame;
        const LabelImportReport report = importLabels(file, scan, store, ram, import);
        common.progress->end();
        common.note("wrote " + store.string() + ": " + std::to_string(report.labels) + " labels, " +
                    formatBytes(report.bytesOut) + ", in " + formatNumber(report.seconds, 3) + " s");
        for (const std::string& line : report.notes)
            common.note(line);
    };
    labels.store = cachedStore(labels.path, keyOf(scan, labels), common, make);
}
#else
void importLabelsFor(const VolumeInfo&, Labels& labels, MemoryBudget&, const CommonOptions&) {
    if (!labels.path.empty())
        throw InputError(labels.path.string() + ": this program was built without importers");
}
#endif

} // namespace tessera
