// viewer/cli/modules/exporters_on_demand.cpp: the writers of bricking/export/volume_writer.h for programs:
// the first export loads them.
#include "viewer/cli/modules/export_module.h"

namespace tessera {

namespace {
const ExportModule& exportModule() {
    static const auto* const table = static_cast<const ExportModule*>(loadModule("tessera_exporters"));
    return *table;
}
} // namespace

ExportReport writeNrrd(BoxSource& box, const ExportRequest& request) {
    return exportModule().nrrd(box, request);
}
ExportReport writeNifti(BoxSource& box, const ExportRequest& request) {
    return exportModule().nifti(box, request);
}
ExportReport writeNifti2(BoxSource& box, const ExportRequest& request) {
    return exportModule().nifti2(box, request);
}
ExportReport writeVti(BoxSource& box, const ExportRequest& request) {
    return exportModule().vti(box, request);
}
ExportReport writeTiff(BoxSource& box, const ExportRequest& request) {
    return exportModule().tiff(box, request);
}

} // namespace tessera
