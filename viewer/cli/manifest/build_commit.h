// viewer/cli/manifest/build_commit.h: the commit that the program was built from.
#pragma once

#include <string>

namespace tessera {

/// Twelve digits, with "-dirty" if files differed from it; empty if the sources were no git checkout.
std::string buildCommit();

} // namespace tessera
