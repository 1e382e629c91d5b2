// bricking/import/dicom/could_belong.h: the unused files that could be slices of a series. If there is one,
// the series may be incomplete without notice.
#pragma once

#include "bricking/import/dicom/dicom_scan.h"

#include <cstddef>
#include <string>
#include <vector>

namespace tessera {

/// A file whose header names the series belongs to it. For a file with an unreadable header the neighbours
/// decide: the files with the next lower and higher number in the same name. Without neighbours the folder
/// decides. A file that is not DICOM at all belongs only by its neighbours or its name's ending. An empty
/// folder belongs if its name, or the folders beside it, are those of slices. So does a lone slice with
/// another SeriesInstanceUID at the position of the series' next slice, with a neighbouring name.
std::vector<PassedFile> couldBelong(const DicomScan& scan, std::size_t series);

/// Throws InputError naming the first such file and the reason, and the number of others.
void requireComplete(const DicomScan& scan, std::size_t series);

} // namespace tessera
