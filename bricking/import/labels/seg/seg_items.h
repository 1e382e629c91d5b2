// bricking/import/labels/seg/seg_items.h: values of DICOM items as DCMTK reads them, strictly: a text that is
// no number is a refusal, never an absent value. To be included in .cpp files alone.
#pragma once

#include <cstdint>
#include <dcmtk/config/osconfig.h>
#include <dcmtk/dcmdata/dctk.h>
#include <optional>
#include <string>
#include <vector>

namespace tessera {

/// Turns DCMTK's messages off, for good: they may quote header values.
void silenceDcmtk();

/// Without padding; "" where it is absent or empty.
std::string segText(DcmItem& item, const DcmTagKey& tag);
/// Of an element of binary numbers (US), the one at `at`.
std::optional<std::uint32_t> segNumber(DcmItem& item, const DcmTagKey& tag, unsigned long at = 0);
/// Of an element of texts (DS): all of its numbers, finite. nullopt: absent or empty. Throws InputError
/// naming `where` and `name` for other than `count` numbers.
std::optional<std::vector<double>> segReals(DcmItem& item, const DcmTagKey& tag, std::size_t count,
                                            const char* name, const std::string& where);
/// The first item of a sequence; null: none.
DcmItem* segItem(DcmItem& item, const DcmTagKey& sequence);

} // namespace tessera
