// bricking/import/structures/structure_planes.cpp: see structure_planes.h.
#include "bricking/import/structures/structure_planes.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace tessera {
namespace {

/// Twice the area of a polygon along its normal (Newell's method).
glm::dvec3 areaVector(const std::vector<glm::dvec3>& points) {
    glm::dvec3 sum{0};
    for (std::size_t i = 0; i < points.size(); ++i)
        sum += glm::cross(points[i] - points.front(), points[(i + 1) % points.size()] - points.front());
    return sum;
}

/// Right-handed axes with this third one: the patient's nearest ones, so that axial planes have x and y.
glm::dmat3 axesOf(glm::dvec3 normal) {
    int main = 0;
    for (int i = 1; i < 3; ++i)
        if (std::abs(normal[i]) > std::abs(normal[main]))
            main = i;
    if (normal[main] < 0)
        normal = -normal;
    glm::dvec3 along{0};
    along[(main + 1) % 3] = 1;
    const glm::dvec3 u = glm::normalize(along - glm::dot(along, normal) * normal);
    return {u, glm::cross(normal, u), normal};
}

/// Of numbers, which are reordered; 0: there are none.
double medianOf(std::vector<double>& numbers) {
    if (numbers.empty())
        return 0;
    const auto middle = numbers.begin() + static_cast<std::ptrdiff_t>(numbers.size() / 2);
    std::nth_element(numbers.begin(), middle, numbers.end());
    return *middle;
}

double widthOf(const std::vector<glm::dvec2>& ring) {
    double area = 0, length = 0;
    for (std::size_t i = 0; i < ring.size(); ++i) {
        const glm::dvec2 a = ring[i] - ring.front(), b = ring[(i + 1) % ring.size()] - ring.front();
        area += 0.5 * (a.x * b.y - a.y * b.x);
        length += glm::distance(a, b);
    }
    return length > 0 ? 2 * std::abs(area) / length : 0;
}

} // namespace

StructurePlanes planesOf(const Structure& structure, MemoryBudget& ram) {
    StructurePlanes out;
    std::size_t bytes = 0;
    glm::dvec3 largest{0};
    for (const StructureContour& contour : structure.contours) {
        bytes += contour.points.size() * sizeof(glm::dvec2) + sizeof(StructurePlane) + sizeof(std::size_t);
        if (contour.form != ContourForm::ring || contour.points.size() < 3)
            continue;
        const glm::dvec3 area = areaVector(contour.points);
        if (glm::dot(area, area) > glm::dot(largest, largest))
            largest = area;
    }
    out.charge = ram.charge(bytes, "planes of contours");
    const bool hasPlane = glm::length(largest) > 0;
    if (hasPlane)
        out.patientFromPlane = axesOf(glm::normalize(largest));
    const glm::dmat3 planeFromPatient = glm::transpose(out.patientFromPlane);
    for (std::size_t number = 0; number < structure.contours.size(); ++number) {
        const StructureContour& contour = structure.contours[number];
        StructurePlane plane;
        double low = 0, high = 0;
        std::vector<glm::dvec2> ring;
        for (const glm::dvec3& point : contour.points) {
            const glm::dvec3 at = planeFromPatient * point;
            low = ring.empty() ? at.z : std::min(low, at.z);
            high = ring.empty() ? at.z : std::max(high, at.z);
            ring.emplace_back(at.x, at.y);
        }
        if (!hasPlane || contour.form != ContourForm::ring || ring.size() < 3 || high - low > 2 * kPlanarMm) {
            out.otherContours.push_back(number);
            continue;
        }
        plane.at = 0.5 * (low + high);
        plane.rings.push_back(std::move(ring));
        out.planes.push_back(std::move(plane));
    }
    std::stable_sort(out.planes.begin(), out.planes.end(),
                     [](const StructurePlane& a, const StructurePlane& b) { return a.at < b.at; });
    std::vector<StructurePlane> joined;
    for (StructurePlane& plane : out.planes) {
        if (!joined.empty() && plane.at - joined.back().at <= kSamePlaneMm)
            joined.back().rings.push_back(std::move(plane.rings.front()));
        else
            joined.push_back(std::move(plane));
    }
    out.planes = std::move(joined);
    std::vector<double> distances, widths;
    for (const StructurePlane& plane : out.planes)
        for (const auto& ring : plane.rings)
            widths.push_back(widthOf(ring));
    out.widthMm = medianOf(widths);
    for (std::size_t i = 1; i < out.planes.size(); ++i)
        distances.push_back(out.planes[i].at - out.planes[i - 1].at);
    out.spacingMm = medianOf(distances);
    return out;
}

} // namespace tessera
