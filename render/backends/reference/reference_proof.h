// render/backends/reference/reference_proof.h: the proof of the reference, as numbers that every report of
// errors prints: closed forms, the same rays with twice the panels, and a second integrator on the same rays.
// The second integrator shares samples and transfer function with the first, but neither its interpolation,
// nor its cuts of rays, nor its quadrature.
#pragma once

#include "render/backends/reference/reference.h"

#include <cstddef>
#include <string>
#include <vector>

namespace tessera {

/// An analytic line integral and the integrator's largest error on it.
struct ClosedFormError {
    std::string name;         // "T1"
    std::string about;        // "constant slab, extinction 1e-6 to 1e6"
    double relativeError = 0; // the largest over the cases
    double limit = 0;         // what it must stay below: 1e-12, or 1e-10 (T8, T11)
};
/// T1, T3 to T8, T11 with a boundary layer down to 1e-8, and a surface in a medium, as reference_integrator.h
/// computes them.
std::vector<ClosedFormError> closedFormErrors();

/// How far the reference is from itself and from another on rays of a scene: largest absolute differences of
/// any component of premultiplied colour and alpha.
struct RayProof {
    std::size_t rays = 0;
    double halving = 0; // twice the panels in every smooth piece
    double independent =
        0; // adaptive Simpson from panels of 1/64 voxel on, cut where the field meets a point or a surface
    static constexpr double kHalvingLimit = 1e-10, kIndependentLimit = 1e-7;
    bool holds() const { return halving <= kHalvingLimit && independent <= kIndependentLimit; }
    /// What errors against the reference are to be trusted to.
    double error() const { return halving > independent ? halving : independent; }
};
/// Surfaces of which the volume shows nothing come to the same colour wherever they lie, and need no panels.
/// Both numbers are then of these surfaces in a thin fog, unlit, whose colour follows the value.
RayProof proveOnRays(const ReferenceInput& scene, const std::vector<ReferenceRay>& rays, int threads);

/// At most `count` of the rays, spread evenly over them.
std::vector<ReferenceRay> sampledRays(const std::vector<ReferenceRay>& rays, std::size_t count);

} // namespace tessera
