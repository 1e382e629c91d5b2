// bricking/analysis/lumen/directions.cpp: see directions.h.
#include "bricking/analysis/lumen/directions.h"

#include <cmath>
#include <glm/geometric.hpp>

namespace tessera {

const std::array<glm::dvec3, 42>& directions42() {
    static const std::array<glm::dvec3, 42> all = [] {
        const double golden = (1 + std::sqrt(5.0)) / 2;
        std::array<glm::dvec3, 12> corners;
        std::size_t n = 0;
        for (const double a : {-1.0, 1.0})
            for (const double b : {-golden, golden}) {
                corners[n++] = {0, a, b};
                corners[n++] = {a, b, 0};
                corners[n++] = {b, 0, a};
            }
        std::array<glm::dvec3, 42> found;
        std::size_t filled = 0;
        for (std::size_t i = 0; i < corners.size(); ++i) {
            found[filled++] = glm::normalize(corners[i]);
            for (std::size_t j = 0; j < i; ++j) // edges have length 2, other corners lie further apart
                if (glm::length(corners[i] - corners[j]) < 2.1)
                    found[filled++] = glm::normalize(corners[i] + corners[j]);
        }
        return found;
    }();
    return all;
}

} // namespace tessera
