// viewer/modules/importers_on_demand.cpp: bricking/import/catalogue.h and open_source.h for programs: the
// first import loads what reads scans.
#include "viewer/modules/import_module.h"

namespace tessera {
namespace {

const ImportModule& module() {
    static const auto* const table = static_cast<const ImportModule*>(loadModule("tessera_importers"));
    return *table;
}

} // namespace

Catalogue lookThrough(const std::filesystem::path& path, bool allowMissing) {
    return module().look(path, allowMissing);
}
const CatalogueRow& chooseRow(const Catalogue& catalogue, const SourceOptions& options) {
    return module().choose(catalogue, options);
}
std::unique_ptr<SlabSource> openRow(const Catalogue& catalogue, const CatalogueRow& row,
                                    const SourceOptions& options) {
    return module().open(catalogue, row, options);
}
std::string tableOf(const Catalogue& catalogue) {
    return module().table(catalogue);
}
std::string passedOverText(const Catalogue& catalogue, const CatalogueRow& row) {
    return module().passedOver(catalogue, row);
}
bool passesOverSomething(const Catalogue& catalogue, const CatalogueRow& row) {
    return module().passesOver(catalogue, row);
}
std::string countPassed(const std::vector<PassedFile>& passed) {
    return module().count(passed);
}
const char* keyOf(PassedReason reason) {
    return module().key(reason);
}
std::unique_ptr<SlabSource> openSource(const std::filesystem::path& path, const SourceOptions& options) {
    return module().openPath(path, options);
}

} // namespace tessera
