// viewer/cli/modules/importers_on_demand.cpp: bricking/import/catalogue.h, open_source.h and others for
// programs: the first import loads what reads scans.
#include "bricking/import/source/format_endings.h"
#include "core/base/address.h"
#include "viewer/cli/modules/import_module.h"
#include "viewer/cli/modules/slice_module.h"
#include "viewer/cli/modules/vtk_image_module.h"

#include <algorithm>
#include <cctype>
#include <string>
#include <system_error>
#include <vector>

namespace tessera {
namespace {

const ImportModule& importModule() {
    static const auto* const table = static_cast<const ImportModule*>(loadModule("tessera_importers"));
    return *table;
}

bool hasEnding(const std::filesystem::path& file, const std::vector<std::string>& endings) {
    std::string name = file.filename().string();
    std::ranges::transform(name, name.begin(),
                           [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return std::ranges::any_of(endings, [&](const std::string& ending) { return name.ends_with(ending); });
}
bool mayNameOthers(const std::filesystem::path& file) {
    return hasEnding(file, namingFileEndings());
}

/// By its name, or by metadata of a group of Zarr.
bool mayBeLevelled(const std::filesystem::path& path) {
    std::error_code ignored;
    if (isAddress(path) || !std::filesystem::is_directory(path, ignored))
        return isAddress(path) || hasEnding(path, levelledFileEndings());
    return std::filesystem::exists(path / ".zattrs", ignored) ||
           std::filesystem::exists(path / "zarr.json", ignored);
}

/// At a path: itself, or a file below it.
bool hasNamingFile(const std::filesystem::path& path) {
    namespace fs = std::filesystem;
    std::error_code ignored;
    if (isAddress(path))
        return true;
    if (!fs::is_directory(path, ignored))
        return mayNameOthers(path);
    for (fs::recursive_directory_iterator entry(path, fs::directory_options::skip_permission_denied, ignored),
         end;
         !ignored && entry != end; entry.increment(ignored))
        if (mayNameOthers(entry->path()))
            return true;
    return false;
}

} // namespace

Catalogue lookThrough(const std::filesystem::path& path, const SourceOptions& options) {
    return importModule().look(path, options);
}
const CatalogueRow& chooseRow(const Catalogue& catalogue, const SourceOptions& options) {
    return importModule().choose(catalogue, options);
}
int phaseOf(const CatalogueRow& row, const SourceOptions& options) {
    return importModule().phase(row, options);
}
std::unique_ptr<SlabSource> openRow(const Catalogue& catalogue, const CatalogueRow& row,
                                    const SourceOptions& options) {
    return importModule().open(catalogue, row, options);
}
/// Loads no importer for others than mayBeLevelled().
bool mayHaveLevels(const std::filesystem::path& path) {
    return mayBeLevelled(path) && importModule().mayHave(path);
}
std::vector<VolumeInfo> fileLevelsOf(const Catalogue& catalogue, const CatalogueRow& row,
                                     const SourceOptions& options) {
    return importModule().levels(catalogue, row, options);
}
std::string tableOf(const Catalogue& catalogue) {
    return importModule().table(catalogue);
}
std::string passedOverText(const Catalogue& catalogue, const CatalogueRow& row) {
    return importModule().passedOver(catalogue, row);
}
bool passesOverSomething(const Catalogue& catalogue, const CatalogueRow& row) {
    return importModule().passesOver(catalogue, row);
}
/// Loads no importer where no file's name has an ending of formats that name others.
std::vector<std::filesystem::path> namedFilesOf(const std::filesystem::path& path) {
    return hasNamingFile(path) ? importModule().namedFiles(path) : std::vector<std::filesystem::path>();
}
std::string countPassed(const std::vector<PassedFile>& passed) {
    return importModule().count(passed);
}
const char* keyOf(PassedReason reason) {
    return importModule().key(reason);
}
std::unique_ptr<SlabSource> openSource(const std::filesystem::path& path, const SourceOptions& options) {
    return importModule().openPath(path, options);
}
LabelFile openLabels(const std::filesystem::path& path, const SourceOptions& options) {
    return importModule().openLabelled(path, options);
}
StructureSet readStructureSet(const std::filesystem::path& file, MemoryBudget& ram) {
    return importModule().readStructures(file, ram);
}

/// The importers, which are a module, call it: the first slice that is a picture loads another.
std::unique_ptr<PictureRows> openPictureRows(const std::filesystem::path& file, const PictureShape& shape) {
    static const auto* const table = static_cast<const SliceModule*>(loadModule("tessera_slices"));
    return table->open(file, shape);
}
std::unique_ptr<SlabSource> openVtkImage(const std::filesystem::path& file) {
    static const auto* const table = static_cast<const VtkImageModule*>(loadModule("tessera_vtk_images"));
    return table->open(file);
}

} // namespace tessera
