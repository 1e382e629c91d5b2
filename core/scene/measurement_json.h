// core/scene/measurement_json.h: measurements as JSON, as scenes have them:
//   [{"kind": "distance", "points": [[x, y, z], [x, y, z]]}]
// Include from .cpp files only.
#pragma once

#include "core/base/json_reader.h"
#include "core/scene/measurement.h"

#include <vector>

namespace tessera {

constexpr std::size_t kMaxMeasurements = 1000;

/// Throws InputError naming the place for other kinds, other numbers of points and places beyond 1e7 mm.
std::vector<Measurement> parseMeasurements(const JsonValue& value);
nlohmann::json measurementsJson(const std::vector<Measurement>& measurements);
/// Keys of one.
const std::vector<std::string>& measurementKeys();

} // namespace tessera
