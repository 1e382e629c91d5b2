// core/base/nearest_name.h: the known name that is closest to a mistyped one, for "did you mean".
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace tessera {

/// Insertions, deletions and replacements of single characters that turn a into b; ASCII case is ignored.
/// Both are cut at 64 characters first, so that a hostile word costs nothing.
std::size_t editDistance(std::string_view a, std::string_view b);
/// The known name with the smallest editDistance (the first of equals); "" when known is empty.
std::string nearestName(std::string_view word, const std::vector<std::string>& known);
/// The index of text in names. Throws InputError naming where, and the nearest name, if it is missing.
std::size_t indexOfName(const std::string& text, const std::vector<std::string>& names,
                        const std::string& where);
/// "a, b, c": for messages that list what is known.
std::string joinNames(const std::vector<std::string>& names);

} // namespace tessera
