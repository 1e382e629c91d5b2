// datasets/torso_chest.cpp: lungs, mediastinum, heart, and the trees of the lungs: arteries, veins, airways.
#include "datasets/branching_tree.h"
#include "datasets/torso_parts.h"

#include <algorithm>

namespace tessera {
namespace {

constexpr float kLungHu = -860, kMediastinalFatHu = -85, kMyocardiumHu = 100, kBloodHu = 180;
constexpr float kLungVesselHu = 230, kAirwayWallHu = -50, kAirwayHu = -1000;
constexpr float kLungFloorMm = -52;
// the recesses beside the diaphragm end at this plane: deep at the back, shallow in front
const HalfSpace kRecesses(glm::normalize(glm::vec3(0, -0.35F, -1)), 28);

void ellipsoid(ShapeList& shapes, const glm::vec3& centre, const glm::vec3& radii) {
    shapes.push_back(std::make_unique<Ellipsoid>(centre, radii));
}

ShapeList mediastinumShapes() {
    ShapeList shapes;
    ellipsoid(shapes, {0, 14, 178}, {30, 34, 50});
    ellipsoid(shapes, {0, -8, 120}, {31, 62, 48});
    ellipsoid(shapes, {2, -54, 120}, {13, 30, 62});
    ellipsoid(shapes, {6, 34, 60}, {27, 30, 118});
    ellipsoid(shapes, {10, -34, 52}, {50, 46, 50});
    ellipsoid(shapes, {38, -40, 40}, {42, 38, 36});
    return shapes;
}

float nearest(const ShapeList& shapes, const glm::vec3& p) {
    float d = 1e9F;
    for (const auto& shape : shapes)
        d = std::min(d, shape->distance(p));
    return d;
}

/// Scattered points of one lung, by side, pitch and seed.
class LungPoints {
  public:
    explicit LungPoints(const Loft& innerWall)
        : innerWall_(innerWall), middle_(mediastinumShapes()), domes_(diaphragmShapes()) {}
    std::vector<glm::vec3> operator()(float side, float pitch, std::uint32_t seed) const {
        const Box box{{side > 0 ? 0.0F : -135.0F, -90, kLungFloorMm}, {side > 0 ? 135.0F : 0.0F, 85, 205}};
        return scatter(box, pitch, seed, [&](const glm::vec3& p) {
            return innerWall_.distance(p) < -8 && kRecesses.distance(p) < -8 && nearest(middle_, p) > 3 &&
                   nearest(domes_, p) > 7;
        });
    }

  private:
    const Loft& innerWall_;
    ShapeList middle_, domes_;
};

} // namespace

void addLungs(TorsoBuilder& torso) {
    Tissue& lungs = torso.add({{-3, kLungHu}});
    lungs.shapes.push_back(std::make_unique<Loft>(*torso.innerWall));
    lungs.clip = std::make_shared<HalfSpace>(kRecesses);
    Tissue& fat = torso.add({{0, kMediastinalFatHu}}, 12);
    fat.shapes = mediastinumShapes();
    fat.clip = torso.innerWall;
    fat.clipOffsetMm = -2;
}

void addHeart(TorsoBuilder& torso) {
    const glm::mat3 axes = axesAlong(glm::normalize(glm::vec3(0.74F, -0.52F, -0.43F))); // base to apex
    Tissue& muscle = torso.add({{0, kMyocardiumHu}}, 8);
    muscle.shapes.push_back(std::make_unique<Ellipsoid>(glm::vec3(38, -29, 47), glm::vec3(28, 28, 43), axes));
    ellipsoid(muscle.shapes, {10, -50, 47}, {35, 20, 31});
    ellipsoid(muscle.shapes, {-29, -27, 57}, {22, 26, 30});
    ellipsoid(muscle.shapes, {4, 6, 72}, {34, 18, 22});
    muscle.clip = torso.innerWall;
    muscle.clipOffsetMm = -5;
    Tissue& blood = torso.add({{0, kBloodHu}});
    ellipsoid(blood.shapes, {8, -52, 50}, {29, 14.5F, 25});
    ellipsoid(blood.shapes, {-29, -27, 57}, {19.5F, 23, 27});
    ellipsoid(blood.shapes, {4, 6, 72}, {31, 15, 19});
    blood.shapes.push_back(
        std::make_unique<Ellipsoid>(glm::vec3(33, -26, 50), glm::vec3(16.5F, 16.5F, 32), axes));
    blood.clip = torso.innerWall;
    blood.clipOffsetMm = -8;
    Tissue& papillary = torso.add({{0, kMyocardiumHu}});
    for (const glm::vec3& at : {glm::vec3(42, -20, 36), glm::vec3(46, -38, 46)})
        papillary.shapes.push_back(std::make_unique<Ellipsoid>(at, glm::vec3(4, 4, 13), axes));
}

void addLungTrees(TorsoBuilder& torso) {
    const LungPoints pointsOf(*torso.innerWall);
    const float voxelMm = torso.voxelMm;
    Tissue& vessels = torso.add({{0, kLungVesselHu}}, 1.5F);
    addTube(vessels.shapes, {{{12, -46, 62}, 13}, {{22, -34, 84}, 13}, {{18, -14, 100}, 12}}, voxelMm);
    addTube(vessels.shapes, {{{18, -14, 100}, 11}, {{-6, -4, 98}, 9.5F}, {{-36, 4, 88}, 8}}, voxelMm);
    addTube(vessels.shapes, {{{18, -14, 100}, 11}, {{34, 4, 101}, 9}, {{46, 14, 94}, 8}}, voxelMm);
    addTree(vessels.shapes, growTree({-36, 4, 88}, pointsOf(-1, 12.5F, 11), {7.0F, 0.75F, 0.42F, 2.6F}),
            voxelMm);
    addTree(vessels.shapes, growTree({46, 14, 94}, pointsOf(1, 12.5F, 12), {7.0F, 0.75F, 0.42F, 2.6F}),
            voxelMm);
    addTube(vessels.shapes, {{{-14, 8, 72}, 8}, {{-38, 10, 66}, 7}}, voxelMm);
    addTube(vessels.shapes, {{{20, 8, 72}, 8}, {{42, 16, 68}, 7}}, voxelMm);
    addTree(vessels.shapes, growTree({-38, 10, 66}, pointsOf(-1, 13.5F, 21), {6.2F, 0.75F, 0.40F, 2.6F}),
            voxelMm);
    addTree(vessels.shapes, growTree({42, 16, 68}, pointsOf(1, 13.5F, 22), {6.2F, 0.75F, 0.40F, 2.6F}),
            voxelMm);

    Tissue& gullet = torso.add({{0, 45}, {-5, 10}, {-6, -500}});
    addTube(gullet.shapes,
            {{{4, 22, 216}, 7},
             {{4, 28, 150}, 7},
             {{5, 29, 100}, 7},
             {{10, 24, 50}, 7.5F},
             {{22, 8, 22}, 8},
             {{36, 2, 8}, 8}},
            voxelMm);
    Tissue& airways = torso.add({{1.3F, kAirwayWallHu}, {0, kAirwayHu}}, 1);
    for (const AirwayTube& tube : torsoAirwayTubes(*torso.innerWall))
        if (tube.knots.size() > 2)
            addTube(airways.shapes, tube.knots, voxelMm);
        else
            airways.shapes.push_back(std::make_unique<TubeSegment>(
                tube.knots[0].at, tube.knots[1].at, tube.knots[0].radiusMm, tube.knots[1].radiusMm, voxelMm));
}

std::vector<AirwayTube> torsoAirwayTubes(const Loft& innerWall) {
    const LungPoints pointsOf(innerWall);
    const glm::vec3 carina(2, 15, 114), right(-38, 14, 88), left(48, 20, 84);
    std::vector<AirwayTube> tubes;
    tubes.push_back({{{{0, 2, 216}, 8.5F}, {{0, 8, 180}, 8.2F}, {{1, 16, 140}, 8}, {carina, 8}}, -1, 0});
    tubes.push_back({{{carina, 7}, {{-17, 17, 102}, 6.6F}, {right, 6}}, 0, 1});
    tubes.push_back({{{carina, 6.4F}, {{22, 16, 99}, 5.7F}, {left, 5.4F}}, 0, 1});
    const auto addTreeOf = [&](int bronchus, const std::vector<TreeBranch>& tree) {
        const int first = static_cast<int>(tubes.size()); // the root carries the bronchus on
        for (const TreeBranch& branch : tree)
            tubes.push_back({{branch.from, branch.to},
                             branch.parent < 0 ? bronchus : first + branch.parent,
                             1 + branch.generation});
    };
    addTreeOf(1, growTree(right, pointsOf(-1, 17, 31), {5.8F, 0.9F, 0.38F, 2.7F}));
    addTreeOf(2, growTree(left, pointsOf(1, 17, 32), {5.2F, 0.9F, 0.38F, 2.7F}));
    return tubes;
}

} // namespace tessera
