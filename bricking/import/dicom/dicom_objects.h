// bricking/import/dicom/dicom_objects.h: names for the kinds of DICOM objects, by storage class and
// ImageType, in a reader's words.
#pragma once

#include <string>

namespace tessera {

/// Whether every file of this class should be a readable slice: CT, MR and PET with their enhanced and legacy
/// converted forms, cone-beam CT.
bool isSliceClass(const std::string& storageClass);

/// The text if it is one of the standard's codes for a modality, else "": anything else may be a name.
std::string modalityOf(const std::string& text);

/// "dose report", "PDF document", ...; "" for a slice class and for one that is not known.
std::string objectWords(const std::string& storageClass);

/// Whether an ImageType ("ORIGINAL\PRIMARY\LOCALIZER") has the word as one of its values.
bool hasType(const std::string& imageType, const std::string& word);
/// "MPR", "MIP", ...: how an image of that type was made from others; "" for an original.
std::string derivationOf(const std::string& imageType);

} // namespace tessera
