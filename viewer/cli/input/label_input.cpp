// viewer/cli/input/label_input.cpp: see label_input.h.
#include "viewer/cli/input/label_input.h"

#include "bricking/labels/label_import.h"
#include "bricking/labels/label_volume.h"
#include "bricking/store/store_files.h"
#include "bricking/store/store_reader.h"
#include "core/base/address.h"
#include "core/base/error.h"
#include "core/base/shown_text.h"
#include "viewer/cli/input/fetched_file.h"
#include "viewer/cli/input/import_cache.h"
#include "viewer/cli/input/remote_input.h"
#include "viewer/cli/input/volume_input.h"
#if TESSERA_WITH_IMPORT
#include "bricking/import/catalogue.h"
#include "bricking/import/labels/open_labels.h"
#endif

#include <algorithm>
#include <array>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

namespace tessera {

#if TESSERA_WITH_IMPORT
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
    if (isAddress(store)) {
        const StoreFolder folder = openFolder(store);
        const auto has = [&](const char* file) { return openIn(folder, file, store).has_value(); };
        return !has("sets/zarr.json") && (has("labels/zarr.json") || has("labels/.zattrs"));
    }
    std::error_code ignored;
    return fs::is_directory(store / "labels", ignored) && !fs::exists(store / "sets", ignored);
}

/// Behind an address, labels are a store, a Zarr, or a file that is fetched whole.
bool isOneFile(const fs::path& labels) {
    const std::optional<RemotePlace> place = remotePlaceOf(labels);
    return place && std::ranges::none_of(std::array{"zarr.json", ".zarray", ".zgroup", ".zattrs"},
                                         [&](const char* name) {
                                             return place->files->sizeOf(place->nameOf(name)).has_value();
                                         });
}

void requireAlone(const fs::path& file, const fs::path& labels) {
    if (const std::vector<fs::path> named = namedFilesOf(file); !named.empty())
        throw badFile(labels.string(), "labels in one file",
                      "a file that names another one, " + printable(named.front().filename().string()));
}

} // namespace

void importLabelsFor(const VolumeInfo& scan, Labels& labels, MemoryBudget& ram, const CommonOptions& common) {
    if (labels.path.empty())
        return;
    labels.path = reached(labels.path);
    std::error_code ignored;
    if (!isAddress(labels.path) && !fs::exists(labels.path, ignored))
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
        std::optional<FetchedFile> fetched;
        if (isOneFile(labels.path)) {
            fetched.emplace(labels.path, "labels in one file, or in Zarr");
            requireAlone(fetched->path(), labels.path);
        }
        const auto reading = [&](const auto& body) { return fetched ? fetched->reading(body) : body(); };
        LabelFile file = reading([&] { return openLabels(fetched ? fetched->path() : labels.path, source); });
        file.shown = labels.path.string();
        LabelImportOptions import;
        import.durable = wanted.durable;
        import.progress = common.progress.get();
        import.sameFrame = labels.sameFrame;
        const LabelImportReport report =
            reading([&] { return importLabels(file, scan, store, ram, import); });
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
