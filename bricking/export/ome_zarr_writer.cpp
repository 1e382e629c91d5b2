// bricking/export/ome_zarr_writer.cpp: a store of a box: OME-Zarr with levels and statistics of its own.
#include "bricking/export/exported_values.h"
#include "bricking/export/volume_writer.h"
#include "bricking/import/importer.h"

namespace tessera {

ExportReport writeOmeZarr(BoxSource& box, const ExportRequest& request) {
    const ImportOptions options{.force = request.force, .progress = &request.progress};
    const ImportReport written = importToStore(box, request.out, request.ram, options);
    return {written.bytesOut, sayValues(box.info(), storedValues(box.info()), true), {}};
}

} // namespace tessera
