// bricking/import/dicom/dicom_remarks.h: words about DICOM data: names of the kinds of objects, and remarks
// about a series.
#pragma once

#include "bricking/import/dicom/dicom_geometry.h"
#include "bricking/import/dicom/dicom_scan.h"

#include <string>
#include <vector>

namespace tessera {

// Readable names for the kinds of DICOM objects, by storage class and ImageType.

/// True if every file of this class should be a readable slice: CT, MR and PET with their enhanced and legacy
/// converted forms, cone-beam CT.
bool isSliceClass(const std::string& storageClass);

/// The text if it is a standard code of a modality, else "": other text may be a name.
std::string modalityOf(const std::string& text);

/// "dose report", "PDF document", ...; "" for a slice class and for an unknown one.
std::string objectWords(const std::string& storageClass);

/// True if an ImageType ("ORIGINAL\PRIMARY\LOCALIZER") has the word as one of its values.
bool hasType(const std::string& imageType, const std::string& word);
/// "MPR", "MIP", ...: the derivation of an image of that type; "" for an original.
std::string derivationOf(const std::string& imageType);

// Remarks about a series: harmless irregularities that are accepted, reported once and kept in the store.
// Private to the DICOM importer.

/// For the slices of the volume, one per line; quotes only numbers and code words.
/// @param ofSeveralPhases  other images at the same positions were left out
std::vector<std::string> remarksOn(const DicomSeries& series, const SlicePlan& plan, bool ofSeveralPhases);

/// The kernel, voltage and thickness of most slices.
void takeCommonAcquisition(DicomSeries& series);

} // namespace tessera
