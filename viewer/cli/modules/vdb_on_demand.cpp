// viewer/cli/modules/vdb_on_demand.cpp: the writers of OpenVDB files for programs: the first one loads the
// library.
#include "viewer/cli/modules/vdb_module.h"

namespace tessera {

namespace {
const VdbModule& vdbModule() {
    static const auto* const table = static_cast<const VdbModule*>(loadModule("tessera_vdb"));
    return *table;
}
} // namespace

ExportReport writeVdb(BoxSource& box, const ExportRequest& request) {
    return vdbModule().floats(box, request);
}
ExportReport writeHalfVdb(BoxSource& box, const ExportRequest& request) {
    return vdbModule().halves(box, request);
}

} // namespace tessera
