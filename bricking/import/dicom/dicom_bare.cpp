// bricking/import/dicom/dicom_bare.cpp: see dicom_bare.h. Elements as in DICOM PS3.5, chapter 7: tag, (VR,)
// length.
#include "bricking/import/dicom/dicom_bare.h"

#include <algorithm>
#include <array>
#include <string_view>

namespace tessera {
namespace {

constexpr int kEnough = 4; // elements that fit; by chance one in 2^60 files does
constexpr std::array<std::string_view, 34> kRepresentations = {
    "AE", "AS", "AT", "CS", "DA", "DS", "DT", "FD", "FL", "IS", "LO", "LT", "OB", "OD", "OF", "OL", "OV",
    "OW", "PN", "SH", "SL", "SQ", "SS", "ST", "SV", "TM", "UC", "UI", "UL", "UN", "UR", "US", "UT", "UV"};
constexpr std::array<std::string_view, 13> kLong = {"OB", "OD", "OF", "OL", "OV", "OW", "SQ",
                                                    "SV", "UC", "UN", "UR", "UT", "UV"};

std::uint32_t number(std::span<const std::byte> head, std::size_t at, int bytes) {
    std::uint32_t value = 0;
    for (int i = bytes - 1; i >= 0; --i)
        value = value << 8 | std::to_integer<std::uint32_t>(head[at + static_cast<std::size_t>(i)]);
    return value;
}

} // namespace

bool looksLikeBareDicom(std::span<const std::byte> head, std::uint64_t fileBytes) {
    std::size_t at = 0;
    std::uint32_t before = 0;
    bool isExplicit = false;
    for (int elements = 0; elements < kEnough; ++elements) {
        if (at + 12 > head.size())
            return elements > 0 && at < fileBytes && head.size() < fileBytes;
        const std::uint32_t group = number(head, at, 2), tag = group << 16 | number(head, at + 2, 2);
        const bool groupFits = group == 0x0002 || group == 0x0008;
        if (!groupFits || (elements > 0 && tag <= before))
            return elements > 0 && group > 0x0008 && group <= 0x0020 && tag > before;
        const std::string_view vr(reinterpret_cast<const char*>(head.data()) + at + 4, 2);
        const bool known =
            std::find(kRepresentations.begin(), kRepresentations.end(), vr) != kRepresentations.end();
        if (elements == 0 || (before >> 16 == 0x0002 && group == 0x0008)) // group 2 is always explicit
            isExplicit = known;
        if (isExplicit != known)
            return false;
        std::size_t valueAt = at + 8;
        std::uint64_t length = number(head, at + 4, 4);
        if (isExplicit) {
            const bool isLong = std::find(kLong.begin(), kLong.end(), vr) != kLong.end();
            length = isLong ? number(head, at + 8, 4) : number(head, at + 6, 2);
            valueAt = at + (isLong ? 12 : 8);
        }
        if (length == 0xffffffff)
            return elements > 0; // a sequence of unknown length
        if (length % 2 != 0 || valueAt + length > fileBytes)
            return false;
        before = tag;
        at = valueAt + static_cast<std::size_t>(length);
    }
    return true;
}

} // namespace tessera
