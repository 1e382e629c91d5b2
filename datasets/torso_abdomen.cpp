// datasets/torso_abdomen.cpp: diaphragm, liver, gall bladder, spleen, stomach, pancreas, kidneys, small bowel
// and bladder; the colon.
#include "datasets/colon_shape.h"
#include "datasets/phantom.h"
#include "datasets/torso_parts.h"

#include <algorithm>
#include <cmath>

namespace tessera {
namespace {

constexpr float kFatHu = -98, kLiverHu = 110, kSpleenHu = 120, kKidneyCortexHu = 190, kMedullaHu = 150;
constexpr float kGasHu = -960, kContentsHu = 22, kWallHu = 75;

Tissue& organ(TorsoBuilder& torso, std::vector<Shell> shells, float smoothMm, float gapMm) {
    Tissue& tissue = torso.add(std::move(shells), smoothMm);
    tissue.clip = torso.innerWall;
    tissue.clipOffsetMm = -gapMm;
    return tissue;
}

void ellipsoid(Tissue& tissue, const glm::vec3& centre, const glm::vec3& radii,
               const glm::vec3& along = glm::vec3(0, 0, 1)) {
    tissue.shapes.push_back(std::make_unique<Ellipsoid>(centre, radii, axesAlong(along)));
}

void addStomach(TorsoBuilder& torso) {
    const std::vector<Knot> course = {{{62, 8, -6}, 22},    {{62, 0, -14}, 26},   {{56, -20, -30}, 24},
                                      {{38, -40, -48}, 18}, {{12, -46, -54}, 14}, {{-14, -38, -46}, 10},
                                      {{-24, -26, -40}, 8}};
    Tissue& stomach = organ(torso, {{0, kWallHu}, {-4, kContentsHu}}, 3, 4);
    addTube(stomach.shapes, course, torso.voxelMm, 5);
    Tissue& gas = torso.add({{-4.5F, kGasHu}}, 3); // the patient lies on the back: gas rises to the front
    addTube(gas.shapes, course, torso.voxelMm, 5);
    gas.clip = std::make_shared<HalfSpace>(glm::vec3(0, 1, 0), -29.0F);
}

void addKidneys(TorsoBuilder& torso) {
    Tissue& kidneys = torso.add({{0, kKidneyCortexHu}});
    Tissue& pyramids = torso.add({{0, kMedullaHu}});
    Tissue& sinus = torso.add({{0, -60}}, 5);
    for (const float side : {-1.0F, 1.0F}) {
        const float down = side < 0 ? -8.0F : 0.0F; // the right one lies lower, under the liver
        const glm::vec3 along = glm::normalize(glm::vec3(side * -0.25F, 0.12F, 1));
        const glm::vec3 centre(side * 64, 33, -42 + down);
        ellipsoid(kidneys, centre, {23, 21, 45}, along);
        for (int k = 0; k < 7; ++k) { // a row of pyramids in front and one behind
            const float t = static_cast<float>(k) - 3;
            for (const float face : {-1.0F, 1.0F})
                ellipsoid(pyramids,
                          centre + along * (t * 10.5F) + glm::vec3(side * (6 - 0.8F * t * t), face * 7, 0),
                          {6.5F, 5, 4.6F}, along);
        }
        ellipsoid(sinus, centre - glm::vec3(side * 9, 2, 0), {9, 5, 15}, along);
        ellipsoid(sinus, centre - glm::vec3(side * 21, 3, 0), {10, 5, 9}, along);
    }
}

void addSmallBowel(TorsoBuilder& torso) {
    // loops to and fro in two layers, inside the frame of the colon
    std::vector<Knot> course;
    for (int layer = 0; layer < 2; ++layer)
        for (int row = 0; row < 6; ++row)
            for (int k = 0; k < 5; ++k) {
                const auto n = static_cast<std::uint32_t>(layer * 30 + row * 5 + k);
                const int turn = (row + layer) % 2 == 0 ? k : 4 - k;
                const float bend = k % 2 == 0 ? -7.0F : 7.0F;
                const auto fr = static_cast<float>(row);
                const float z = (layer == 0 ? -78 - 19 * fr : -173 + 19 * fr) + bend + 8 * hashUnit(n, 3);
                const float y =
                    (layer == 0 ? -46.0F : -20.0F) + 12 * hashUnit(n, 4) - 6 - (row > 1 ? 2.0F : 0.0F);
                course.push_back({{-58 + 29 * static_cast<float>(turn) + 8 * hashUnit(n, 5), y, z},
                                  9 + 3 * hashUnit(n, 6)});
            }
    Tissue& bowel = organ(torso, {{0, 95}, {-2.2F, kContentsHu}}, 0, 5);
    addTube(bowel.shapes, course, torso.voxelMm, 4);
    Tissue& gas = torso.add({{-2.6F, kGasHu}});
    addTube(gas.shapes, {course.begin() + 6, course.begin() + 9}, torso.voxelMm, 4);
    addTube(gas.shapes, {course.begin() + 17, course.begin() + 19}, torso.voxelMm, 4);
    gas.clip = std::make_shared<HalfSpace>(glm::vec3(0, 1, 0), -50.0F);
}

} // namespace

ShapeList diaphragmShapes() {
    ShapeList shapes;
    shapes.push_back(std::make_unique<Ellipsoid>(glm::vec3(-58, -2, -62), glm::vec3(80, 88, 96)));
    shapes.push_back(std::make_unique<Ellipsoid>(glm::vec3(58, 0, -62), glm::vec3(79, 87, 90)));
    shapes.push_back(std::make_unique<Ellipsoid>(glm::vec3(0, -52, -62), glm::vec3(84, 44, 82)));
    return shapes;
}

void addAbdomen(TorsoBuilder& torso) {
    Tissue& diaphragm = organ(torso, {{0, 55}, {-3.2F, kFatHu}}, 18, 1);
    diaphragm.shapes = diaphragmShapes();
    Tissue& below = organ(torso, {{0, kFatHu}}, 0, 4); // the domes are open downwards
    below.shapes.push_back(std::make_unique<HalfSpace>(glm::vec3(0, 0, 1), -62.0F));

    Tissue& liver = organ(torso, {{0, kLiverHu}}, 16, 4.5F);
    ellipsoid(liver, {-66, 0, -22}, {58, 68, 50});
    ellipsoid(liver, {-70, 8, -50}, {44, 54, 42});
    ellipsoid(liver, {-14, -38, -4}, {52, 32, 26}, {0.35F, 0, 1});
    ellipsoid(liver, {26, -44, 0}, {34, 22, 13}, {0.2F, 0, 1});
    Tissue& gallBladder = organ(torso, {{0, 60}, {-1.6F, 8}}, 0, 5);
    ellipsoid(gallBladder, {-42, -48, -58}, {12, 13, 22}, {0.1F, 0.5F, 1});
    Tissue& spleen = organ(torso, {{0, kSpleenHu}}, 10, 4.5F);
    ellipsoid(spleen, {97, 33, -25}, {21, 34, 31}, {0.1F, -0.5F, 1});
    addStomach(torso);
    Tissue& pancreas = torso.add({{0, 100}}, 5);
    addTube(pancreas.shapes,
            {{{-26, -12, -58}, 12},
             {{-10, -16, -50}, 11},
             {{14, -20, -42}, 8.5F},
             {{44, -2, -32}, 9},
             {{78, 18, -22}, 7}},
            torso.voxelMm, 5);
    addKidneys(torso);
    addSmallBowel(torso);
    Tissue& bladder = torso.add({{0, 45}, {-3, 8}}, 6);
    ellipsoid(bladder, {0, -26, -197}, {34, 25, 20});
}

// The air-filled colon with its wall, folds and polyps, and what phantom.h tells of it.

namespace {

constexpr float kWallMm = 2.4F, kColonWallHu = 42, kLumenHu = -990, kPolypHu = 48;

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
    Tissue& wall = torso.add({{kWallMm, kColonWallHu}});
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
