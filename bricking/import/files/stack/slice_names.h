// bricking/import/files/stack/slice_names.h: the order of slices by the numbers in their names, and the
// numbers that are missing. Private to stacks.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace tessera {

struct SliceNames {
    std::vector<std::filesystem::path> files; // ascending by number: slice2 before slice10
    std::string pattern;                      // "slice#.tif"
    std::string missing;                      // "57, 60 to 62"; "" none
    std::size_t missingCount = 0;
    std::vector<std::uint64_t> places = {}; // of the files, in steps from the first
};

/// Of the slices of a folder. Their names must be alike but for one number and the ending. Numbers may go up
/// by any step: the largest one is taken that all share, and what lies between in steps is missing. Throws
/// InputError naming the folder or a file for other names, for several numbers that differ, and for a number
/// twice.
SliceNames orderedSlices(const std::filesystem::path& folder, std::vector<std::filesystem::path> files);

} // namespace tessera
