// viewer/options/option_values.h: what an option's value may be, checked before any work: the refusal names
// the option, what is expected and what was found.
#pragma once

#include <CLI/CLI.hpp>
#include <limits>
#include <string>

namespace tessera {

/// A whole number from `lowest` on that an int holds.
CLI::Validator wholeNumberFrom(int lowest);
/// A finite number within [lowest, highest]. @param what  "voxels from 1/64 to 16"
CLI::Validator numberWithin(double lowest, double highest, const std::string& what);

/// Throws InputError for any option or argument of the program or of a command that was given an empty value:
/// one that means nothing, and would be taken for one that was not given.
void refuseEmptyValues(const CLI::App& program);

} // namespace tessera
