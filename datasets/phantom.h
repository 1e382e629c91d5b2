// datasets/phantom.h: generated volumes, slice by slice, of any size. Each is a formula, so the value, and
// often the gradient and the integral, is known at every point.
#pragma once

#include "bricking/import/source/slab_source.h"

#include <functional>
#include <glm/vec3.hpp>
#include <memory>
#include <string>
#include <vector>

namespace tessera {

/// "torso", "torso-collapsed" (a piece of its colon has no lumen), "marschner-lobb", "sphere", "ramp",
/// "checkerboard".
std::vector<std::string> phantomNames();
/// True if it has the parts of a body.
bool isTorso(const std::string& name);

/// @param extentVoxels  each at least 1
/// The body's size in mm is the same at every extent: more voxels show it finer.
/// Throws InputError with the nearest name for an unknown name.
std::unique_ptr<SlabSource> makePhantom(const std::string& name, const glm::ivec3& extentVoxels,
                                        int threads = 0);

/// The function that the voxels of a torso of such an extent sample, without noise: HU at a point, patient
/// space, mm.
std::function<double(const glm::dvec3&)> torsoFormulaHu(const glm::ivec3& extentVoxels);

/// Centre-line of the torso's colon, from caecum to rectum, patient space mm, about one point every 2 mm.
std::vector<glm::dvec3> torsoColonCentreline();
/// Radius of the colon's lumen without folds at arc fraction u in [0,1], mm.
double torsoColonRadiusMm(double u);

/// The closed piece of the colon of torso-collapsed, as shares of the centre-line's length; the colon opens
/// within kColonClosingMm to either side.
inline constexpr double kCollapsedFrom = 0.60, kCollapsedTo = 0.63, kColonClosingMm = 10;

/// One of the torso's polyps: a half-sunk sphere, or a sphere on a stalk.
struct ColonPolyp {
    glm::dvec3 centreMm; ///< centre of its head, patient space
    double arcFraction;  ///< position along the centre-line, in [0,1]
    double diameterMm;   ///< of its head
    bool pedunculated;   ///< has a stalk
};
/// From caecum to rectum.
std::vector<ColonPolyp> torsoColonPolyps();

/// The centre-line of a tube of a torso, patient space, mm.
struct PhantomCurve {
    std::vector<glm::dvec3> pointsMm; ///< at least two
    std::vector<double> radiiMm;      ///< of the lumen at the points; the colon's without pouches and folds
    int parent = -1;                  ///< the parent curve, by its index in the list; -1: none
    int generation = 0;               ///< one more at every fork
};
/// Trachea, bronchi and the trees of the lungs, each after its parent.
std::vector<PhantomCurve> torsoAirways();
/// From the heart to the fork above the pelvis.
PhantomCurve torsoAorta();
/// From caecum to rectum.
PhantomCurve torsoColon();
/// All of them and the polyps as JSON (README.md). Throws InputError for a phantom that is no torso.
std::string phantomCurvesJson(const std::string& name);

} // namespace tessera
