// bricking/import/files/length_units.h: units of length in descriptions of files.
#pragma once

#include "bricking/import/source/plausible.h"

#include <array>
#include <string_view>

namespace tessera {

/// Millimetres; 0: no unit of length that is known.
inline double millimetresOf(std::string_view unit) {
    struct Unit {
        std::string_view name;
        double mm;
    };
    static constexpr std::array kUnits = {
        Unit{"mm", 1},          Unit{"millimeter", 1}, Unit{"cm", 10},          Unit{"m", 1000},
        Unit{"um", 1e-3},       Unit{"micron", 1e-3},  Unit{"microns", 1e-3},   Unit{"micrometer", 1e-3},
        Unit{"\\u00B5m", 1e-3}, Unit{"\xb5m", 1e-3},   Unit{"\xc2\xb5m", 1e-3}, Unit{"\xce\xbcm", 1e-3},
        Unit{"nm", 1e-6},       Unit{"inch", 25.4},    Unit{"in", 25.4}};
    for (const Unit& row : kUnits)
        if (unit == row.name)
            return row.mm;
    return 0;
}

/// Of a voxel.
inline bool isLength(double mm) {
    return mm >= kLeastSpacingMm && mm <= kMostSpacingMm; // false for NaN
}

} // namespace tessera
