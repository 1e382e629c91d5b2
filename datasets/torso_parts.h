// datasets/torso_parts.h: the torso's organs by region, each added as tissues in painting order. Coordinates
// are patient millimetres: +x the patient's left, +y posterior, +z superior. The box is 360 x 260 x 420
// around 0. Sizes are those of a small adult, with the trunk shortened to fit from shoulders to hips.
#pragma once

#include "datasets/tissue_painter.h"

#include <deque>

namespace tessera {

constexpr float kCortexHu = 1000, kMarrowHu = 200; // of bone

/// The two domes under the lungs.
ShapeList diaphragmShapes();

/// A tube of the airways.
struct AirwayTube {
    std::vector<Knot> knots; ///< two: straight; more: a Catmull-Rom curve through them
    int parent;              ///< its index in the list; -1: the trachea
    int generation;          ///< of the trachea 0, one more at every fork
};
/// Trachea, main bronchi and the trees of the lungs, each after its parent.
std::vector<AirwayTube> torsoAirwayTubes(const Loft& innerWall);
/// From the aortic root to the fork.
const std::vector<Knot>& aortaCourse();
/// The inner wall of chest and belly.
std::shared_ptr<const Loft> torsoInnerWall();

/// Built once per phantom; voxelMm is the width of every blend.
struct TorsoBuilder {
    float voxelMm;
    std::deque<Tissue> tissues;                          // a deque, so that references from add() stay valid
    std::shared_ptr<const Loft> skin, muscle, innerWall; // outside in; the inner wall bounds chest and belly
    bool colonCollapsed = false;

    Tissue& add(std::vector<Shell> shells, float smoothMm = 0) {
        tissues.push_back({{}, std::move(shells), smoothMm, nullptr, 0});
        return tissues.back();
    }
};

/// The spine's curve: middle of the vertebral bodies at height z, mm.
glm::vec3 spineMiddle(float z);

/// Vertebrae from the first thoracic (0) to the last lumbar (16), head to foot.
inline constexpr int kThoracic = 12, kLumbar = 5, kVertebrae = kThoracic + kLumbar;
float vertebraZ(int i);
/// Half-width, half-depth, half-height of the body of vertebra i, mm.
glm::vec3 vertebraHalf(int i);

// In painting order.
void addBodyWall(TorsoBuilder& torso);  // skin, fat, muscle, the space inside
void addLungs(TorsoBuilder& torso);     // lungs and the mediastinum's fat
void addAbdomen(TorsoBuilder& torso);   // diaphragm and solid and hollow organs but the colon
void addLungTrees(TorsoBuilder& torso); // pulmonary vessels, then airways
void addHeart(TorsoBuilder& torso);
void addVessels(TorsoBuilder& torso); // great vessels and their branches
void addSpine(TorsoBuilder& torso);
void addRibsAndGirdles(TorsoBuilder& torso); // ribs, sternum, shoulders, pelvis
void addColon(TorsoBuilder& torso);          // wall, lumen with folds, polyps

} // namespace tessera
