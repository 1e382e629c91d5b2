// viewer/cli/options/option_names.h: the likely option for an unknown one: by another program's name, by a
// part of its name, or by spelling.
#pragma once

#include <string>
#include <vector>

namespace tessera {

/// Of the known options the one that an unknown one most likely means; "" where none is near enough to be
/// worth a guess. All with their leading "--"; what follows a "=" does not count.
std::string likelyOption(const std::string& unknown, const std::vector<std::string>& known);

} // namespace tessera
