// core/base/dicom_uid.h: unique identifiers of DICOM (PS3.5, chapter 9), as text; those of frames of
// reference.
#pragma once

#include <string>
#include <string_view>
#include <utility>

namespace tessera {

/// True for 1 to 64 digits and full stops, of which the first is a digit. Rules on the numbers between the
/// stops are left out: programs that remove names break them.
inline bool isDicomUid(std::string_view text) {
    return !text.empty() && text.size() <= 64 && text.front() != '.' &&
           text.find_first_not_of("0123456789.") == std::string_view::npos;
}

/// The text where it is a UID, else "": not known.
inline std::string uidOrNone(std::string text) {
    return isDicomUid(text) ? std::move(text) : std::string();
}

/// True if two frames of reference are known, and are not one. "": not known.
inline bool areFramesApart(const std::string& a, const std::string& b) {
    return !a.empty() && !b.empty() && a != b;
}

} // namespace tessera
