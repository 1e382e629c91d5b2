// render/backends/reference/reference_proof.h: the verification of the reference, as numbers for reports of
// errors. It has closed forms, twice the panels on the same rays, and a second integrator on the same rays.
// The second integrator shares samples and transfer function with the first, but not interpolation, cuts of
// rays or quadrature.
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
    double limit = 0;         // its bound: 1e-12, or 1e-10 (T8, T11)
};
/// T1, T3 to T8, T11 with a boundary layer down to 1e-8, and a surface in a medium, by
/// reference_integrator.h.
std::vector<ClosedFormError> closedFormErrors();

/// Differences of the reference to itself and to the second integrator on rays of a scene: the largest of any
/// component of premultiplied colour and alpha.
struct RayProof {
    std::size_t rays = 0;
    double halving = 0; // twice the panels in every smooth piece
    double independent =
        0; // adaptive Simpson from panels of 1/64 voxel on, cut where the field meets a point or a surface
    static constexpr double kHalvingLimit = 1e-10, kIndependentLimit = 1e-7;
    bool holds() const { return halving <= kHalvingLimit && independent <= kIndependentLimit; }
    /// The accuracy of errors against the reference.
    double error() const { return halving > independent ? halving : independent; }
};
/// Surfaces in an invisible volume have the same colour anywhere, and need no panels. Both numbers are then
/// for these surfaces in an unlit thin fog whose colour follows the value.
RayProof proveOnRays(const ReferenceInput& scene, const std::vector<ReferenceRay>& rays, int threads);

/// At most `count` of the rays, spread evenly over them.
std::vector<ReferenceRay> sampledRays(const std::vector<ReferenceRay>& rays, std::size_t count);

} // namespace tessera
