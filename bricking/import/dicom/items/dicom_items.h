// bricking/import/dicom/items/dicom_items.h: values of DICOM items as DCMTK reads them, strictly: a text that
// is no number is a refusal, never an absent value. To be included in .cpp files alone.
#pragma once

#include <cstdint>
#include <dcmtk/config/osconfig.h>
#include <dcmtk/dcmdata/dctk.h>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tessera {

/// Turns DCMTK's messages off, for good: they may quote header values.
void silenceDcmtk();

/// Without padding; "" where it is absent or empty.
std::string itemText(DcmItem& item, const DcmTagKey& tag);
/// In UTF-8, printable; characters that cannot be converted as escapes.
/// @param characters  the data set's SpecificCharacterSet
std::string itemWords(DcmItem& item, const DcmTagKey& tag, const std::string& characters);
/// Of an element of binary numbers (US), the one at `at`.
std::optional<std::uint32_t> itemNumber(DcmItem& item, const DcmTagKey& tag, unsigned long at = 0);
/// Of an element of texts (DS): all of its numbers, finite. nullopt: absent or empty. Throws InputError
/// naming `where` and `name` for other than `count` numbers.
std::optional<std::vector<double>> itemReals(DcmItem& item, const DcmTagKey& tag, std::size_t count,
                                             const char* name, const std::string& where);
/// A text of numbers between backslashes, spaces around each or not, finite. Throws InputError naming `where`
/// and `name` for a text that is no number.
std::vector<double> realsOf(std::string_view text, const char* name, const std::string& where);
/// MediaStorageSOPClassUID of a file that begins as DICOM, preamble and meta group; else "". Throws nothing.
std::string storageClassOf(const std::filesystem::path& file);
/// The first item of a sequence; null: none.
DcmItem* firstItem(DcmItem& item, const DcmTagKey& sequence);

} // namespace tessera
