// bricking/import/dicom/could_belong.h: the unused files that could be slices of a series. With one of them
// the series is surely not complete, and leaving it out would go unnoticed.
#pragma once

#include "bricking/import/dicom/dicom_scan.h"

#include <cstddef>
#include <string>
#include <vector>

namespace tessera {

/// A file whose header names the series belongs to it. Of one whose header cannot be read the neighbours
/// decide: the files of the same name but for one number, next below and above; where it has none, the folder
/// that it lies in. A file that is no DICOM file at all belongs only by its neighbours or its name's ending.
/// An empty folder belongs where its name, or the folders beside it, are those of slices.
/// So does a lone slice under another SeriesInstanceUID that lies where the next slice of the series would,
/// with a file beside the series' own by name.
std::vector<PassedFile> couldBelong(const DicomScan& scan, std::size_t series);

/// Throws InputError naming the first such file and why it cannot be read, and the number of others.
void requireComplete(const DicomScan& scan, std::size_t series);

} // namespace tessera
