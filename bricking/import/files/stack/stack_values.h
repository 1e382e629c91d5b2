// bricking/import/files/stack/stack_values.h: from stored to physical values of a stack: what ImageJ's
// description says of them. Private to stacks.
#pragma once

#include "bricking/import/files/stack/picture_walk.h"

#include <string>

namespace tessera {

struct StackRescale {
    double slope = 1, intercept = 0;
    std::string unit; // "HU"; "" unknown
    bool operator==(const StackRescale&) const = default;
};

/// Throws InputError naming the file for a calibration that is no straight line or not whole, and for one of
/// numbers other than those that ImageJ calibrates.
StackRescale rescaleOf(const PictureHead& head, const std::string& where);

} // namespace tessera
