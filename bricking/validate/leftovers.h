// bricking/validate/leftovers.h: unfinished files and folders of dead processes, in a store and beside it.
#pragma once

#include <filesystem>
#include <vector>

namespace tessera {

/// Those in the store's folders, and those of imports of this store beside it, in order. Only those whose
/// owner is provably dead: none on file systems where locks prove nothing.
std::vector<std::filesystem::path> leftoversOf(const std::filesystem::path& store);

/// Removes one, if its owner is still dead. Returns false if it stays.
bool removeLeftover(const std::filesystem::path& leftover);

} // namespace tessera
