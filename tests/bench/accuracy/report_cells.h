// tests/bench/accuracy/report_cells.h: numbers as the tables and captions of the accuracy page write them.
#pragma once

#include "tests/bench/report/report.h"
#include "viewer/cli/options/options.h" // formatNumber

#include <optional>
#include <string>

namespace tessera::accuracy {

constexpr const char* kNotReached = "not reached";

inline std::string number(double value, int digits = 3) {
    return formatNumber(value, digits);
}
inline bench::Cell orNotReached(const std::optional<double>& value) {
    return value ? bench::Cell(*value) : bench::Cell(kNotReached);
}

} // namespace tessera::accuracy
