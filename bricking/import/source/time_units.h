// bricking/import/source/time_units.h: units of time as descriptions of pictures name them: ImageJ, OME-TIFF
// and OME-Zarr.
#pragma once

#include <array>
#include <string_view>

namespace tessera {

/// Seconds; 0: no unit of time that is known.
inline double secondsOf(std::string_view unit) {
    struct Unit {
        std::string_view name;
        double seconds;
    };
    static constexpr std::array kUnits = {
        Unit{"s", 1},        Unit{"sec", 1},           Unit{"second", 1},         Unit{"seconds", 1},
        Unit{"ms", 1e-3},    Unit{"msec", 1e-3},       Unit{"millisecond", 1e-3}, Unit{"milliseconds", 1e-3},
        Unit{"us", 1e-6},    Unit{"\xc2\xb5s", 1e-6},  Unit{"\xce\xbcs", 1e-6},   Unit{"microsecond", 1e-6},
        Unit{"ns", 1e-9},    Unit{"nanosecond", 1e-9}, Unit{"min", 60},           Unit{"minute", 60},
        Unit{"minutes", 60}, Unit{"h", 3600},          Unit{"hour", 3600},        Unit{"hours", 3600},
        Unit{"d", 86400},    Unit{"day", 86400}};
    for (const Unit& row : kUnits)
        if (unit == row.name)
            return row.seconds;
    return 0;
}

/// Between times that follow each other; 0: what is said is none.
inline double stepSecondsOf(double step, std::string_view unit) {
    constexpr double kMost = 1e12;
    const double seconds = step * secondsOf(unit);
    return seconds > 0 && seconds <= kMost ? seconds : 0; // NaN is neither
}

} // namespace tessera
