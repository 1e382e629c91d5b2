// viewer/cli/options/option_names.h: the likely option for an unknown one: by another program's name, by a
// part of its name, or by spelling.
#pragma once

#include <string>
#include <vector>

namespace tessera {

/// The known option that an unknown one most likely means; "" if none is near. All with their leading "--";
/// text after "=" is ignored.
std::string likelyOption(const std::string& unknown, const std::vector<std::string>& known);

} // namespace tessera
