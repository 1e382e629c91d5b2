// core/scene/measurement_json.cpp: see measurement_json.h.
#include "core/scene/measurement_json.h"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace tessera {

const std::vector<std::string>& measurementKeys() {
    static const std::vector<std::string> keys = {"kind", "points"};
    return keys;
}

std::vector<Measurement> parseMeasurements(const JsonValue& value) {
    constexpr double kMostMm = 1e7;
    if (!value.isList() || value.items().size() > kMaxMeasurements)
        value.refuse("a list of at most 1000 measurements");
    std::vector<Measurement> all;
    for (const JsonValue& item : value.items()) {
        item.requireKeys(measurementKeys());
        Measurement m;
        const std::vector<std::string>& names = measurementNames();
        m.kind = static_cast<MeasurementKind>(
            std::find(names.begin(), names.end(), item.at("kind").oneOf(names)) - names.begin());
        const JsonValue points = item.at("points");
        if (!points.isList() || points.items().size() != pointsOf(m.kind))
            points.refuse(std::to_string(pointsOf(m.kind)) + " points [x, y, z]");
        for (const JsonValue& point : points.items()) {
            if (!point.isList() || point.items().size() != 3)
                point.refuse("[x, y, z]");
            glm::dvec3 mm(0);
            for (int i = 0; i < 3; ++i)
                mm[i] = point.items()[static_cast<std::size_t>(i)].number(-kMostMm, kMostMm);
            m.points.push_back(mm);
        }
        all.push_back(std::move(m));
    }
    return all;
}

nlohmann::json measurementsJson(const std::vector<Measurement>& measurements) {
    nlohmann::json list = nlohmann::json::array();
    for (const Measurement& m : measurements) {
        nlohmann::json points = nlohmann::json::array();
        for (const glm::dvec3& p : m.points)
            points.push_back({p.x, p.y, p.z});
        list.push_back({{"kind", measurementNames()[static_cast<std::size_t>(m.kind)]}, {"points", points}});
    }
    return list;
}

} // namespace tessera
