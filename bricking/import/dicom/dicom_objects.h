// bricking/import/dicom/dicom_objects.h: readable names for the kinds of DICOM objects, by storage class and
// ImageType.
#pragma once

#include <string>

namespace tessera {

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

} // namespace tessera
