// bricking/import/source/length_units.h: units of length as descriptions of pictures name them: ImageJ,
// OME-TIFF and OME-Zarr.
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
    static constexpr std::array kUnits = {Unit{"mm", 1},
                                          Unit{"millimeter", 1},
                                          Unit{"millimetre", 1},
                                          Unit{"millimeters", 1},
                                          Unit{"cm", 10},
                                          Unit{"centimeter", 10},
                                          Unit{"centimetre", 10},
                                          Unit{"dm", 100},
                                          Unit{"decimeter", 100},
                                          Unit{"decimetre", 100},
                                          Unit{"m", 1000},
                                          Unit{"meter", 1000},
                                          Unit{"metre", 1000},
                                          Unit{"um", 1e-3},
                                          Unit{"micron", 1e-3},
                                          Unit{"microns", 1e-3},
                                          Unit{"micrometer", 1e-3},
                                          Unit{"micrometre", 1e-3},
                                          Unit{"micrometers", 1e-3},
                                          Unit{"\\u00B5m", 1e-3},
                                          Unit{"\xb5m", 1e-3}, // ImageJ's; Latin-1
                                          Unit{"\xc2\xb5m", 1e-3},
                                          Unit{"\xce\xbcm", 1e-3}, // UTF-8: the sign of micro, the letter mu
                                          Unit{"nm", 1e-6},
                                          Unit{"nanometer", 1e-6},
                                          Unit{"nanometre", 1e-6},
                                          Unit{"nanometers", 1e-6},
                                          Unit{"pm", 1e-9},
                                          Unit{"picometer", 1e-9},
                                          Unit{"picometre", 1e-9},
                                          Unit{"angstrom", 1e-7},
                                          Unit{"\xc3\x85", 1e-7},
                                          Unit{"inch", 25.4},
                                          Unit{"in", 25.4}};
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
