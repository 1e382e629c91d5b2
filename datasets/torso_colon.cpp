// datasets/torso_colon.cpp: the air-filled colon with its wall, folds and polyps, and what phantom.h tells of
// it.
#include "datasets/colon_shape.h"
#include "datasets/phantom.h"
#include "datasets/torso_parts.h"

#include <algorithm>
#include <cmath>

namespace tessera {
namespace {

constexpr float kWallMm = 2.4F, kWallHu = 42, kLumenHu = -990, kPolypHu = 48;

struct PolypPlan {
    float arcFraction, angleDegrees, diameterMm;
    bool pedunculated;
};
constexpr PolypPlan kPolyps[] = {{0.065F, 200, 9, false}, {0.17F, 40, 6, false},   {0.262F, 300, 10, true},
                                 {0.36F, 100, 5, false},  {0.455F, 255, 8, false}, {0.565F, 20, 4, false},
                                 {0.68F, 150, 10, true},  {0.765F, 330, 7, false}, {0.84F, 70, 6, false},
                                 {0.955F, 180, 10, false}};

struct Polyp {
    glm::vec3 wall, inward, along,
        head; // where it sits, towards the centre-line, along it, middle of its head
};

Polyp place(const ColonCourse& course, const PolypPlan& plan) {
    const float arc = plan.arcFraction * course.lengthMm();
    const float angle = plan.angleDegrees * 3.14159265F / 180;
    const float cosine = std::cos(angle), sine = std::sin(angle);
    const ColonCourse::Station station = course.atArc(arc);
    const glm::vec3 outward = station.normal * cosine + station.binormal * sine;
    Polyp polyp;
    polyp.wall = station.at + outward * course.lumen(arc, cosine, sine, true).radiusMm;
    polyp.inward = -outward;
    polyp.along = glm::cross(station.normal, station.binormal);
    // a stalk leans over along the wall, as it hangs; a sessile one is half sunk into the wall
    polyp.head = plan.pedunculated ? polyp.wall + polyp.inward * 5.5F + polyp.along * 9.0F : polyp.wall;
    return polyp;
}

} // namespace

void addColon(TorsoBuilder& torso) {
    const auto course = std::make_shared<const ColonCourse>(torso.colonCollapsed);
    const auto grid = std::make_shared<const ColonGrid>(course);
    Tissue& wall = torso.add({{kWallMm, kWallHu}});
    wall.shapes.push_back(std::make_unique<Colon>(grid, false));
    Tissue& lumen = torso.add({{0, kLumenHu}});
    lumen.shapes.push_back(std::make_unique<Colon>(grid, true));
    Tissue& polyps = torso.add({{0, kPolypHu}}, 1.5F);
    for (const PolypPlan& plan : kPolyps) {
        const Polyp polyp = place(*course, plan);
        const float radius = 0.5F * plan.diameterMm;
        polyps.shapes.push_back(std::make_unique<Ellipsoid>(polyp.head, glm::vec3(radius)));
        if (plan.pedunculated)
            addTube(polyps.shapes,
                    {{polyp.wall - polyp.inward, 2.4F},
                     {polyp.wall + polyp.inward * 3.0F + polyp.along * 3.0F, 1.8F},
                     {polyp.head, 2}},
                    torso.voxelMm, 2);
    }
}

std::vector<glm::dvec3> torsoColonCentreline() {
    const ColonCourse course;
    std::vector<glm::dvec3> points;
    for (const ColonCourse::Station& station : course.stations())
        points.emplace_back(station.at);
    return points;
}

double torsoColonRadiusMm(double u) {
    return static_cast<double>(ColonCourse::radiusMm(static_cast<float>(std::clamp(u, 0.0, 1.0))));
}

std::vector<ColonPolyp> torsoColonPolyps() {
    const ColonCourse course;
    std::vector<ColonPolyp> polyps;
    for (const PolypPlan& plan : kPolyps)
        polyps.push_back({glm::dvec3(place(course, plan).head), static_cast<double>(plan.arcFraction),
                          static_cast<double>(plan.diameterMm), plan.pedunculated});
    return polyps;
}

} // namespace tessera
