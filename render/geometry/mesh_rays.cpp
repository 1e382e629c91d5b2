// render/geometry/mesh_rays.cpp: see mesh_rays.h.
#include "render/geometry/mesh_rays.h"

#include "core/base/error.h"
#include "render/contract/optics.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

namespace tessera {
namespace {

/// As leaf::AllLight, with the shares of each light.
struct SharedLight {
    MeshLight::Shares shares;
    double of(int light, double share) const { return share * shares[static_cast<std::size_t>(light)]; }
    double ambient(double ambient, int) const { return ambient; }
};

/// What a filter of hits works on.
struct KeptHits {
    const DrawnPart& part;
    const RayLine<double>& line;
};

bool keepsHit(const void* context, double t) {
    const auto& kept = *static_cast<const KeptHits*>(context);
    return kept.part.keeps(kept.line.base + t * kept.line.direction, kCutTolerance);
}

/// Behind which hits of a mesh count, after a surface of any mesh.
HitOrder behind(const MeshRays::Order& after, std::int32_t mesh) {
    constexpr std::uint32_t kLast = std::numeric_limits<std::uint32_t>::max();
    if (mesh == after.mesh)
        return {after.t, after.part};
    if (mesh < after.mesh)
        return {after.t, kLast};
    return {std::nextafter(after.t, -std::numeric_limits<double>::max()), kLast}; // those of equal t, too
}

} // namespace

MeshRays::MeshRays(const FramePlan& plan, const RayFrame<double>& frame, const MeshLight* light)
    : plan_(plan), light_(light), patientFromVoxel_(plan.rayVoxels().patientFromVoxel),
      lighting_(plan.layer().optics.lighting) {
    TESSERA_CHECK(frame.cuts);
    for (const SceneMesh& mesh : plan.view.meshes)
        TESSERA_CHECK(mesh.shape);
    lighting_.model.weightLow = leaf::LightModel().weightLow;
    lighting_.model.weightScale = leaf::LightModel().weightScale;
}

std::optional<MeshRays::Surface> MeshRays::next(const RayLine<double>& line, const Order& after) const {
    const ShapeRay ray{glm::dvec3(patientFromVoxel_ * glm::dvec4(line.base, 1)),
                       glm::dmat3(patientFromVoxel_) * line.direction};
    const double squared = glm::dot(ray.direction, ray.direction);
    if (!(squared > 0) || !(squared < kFar)) // a ray without a direction meets nothing
        return std::nullopt;
    Order from = after;
    from.t = std::max(after.t, std::max(line.nearest, -kFar)); // nothing behind the eye
    if (from.t > after.t)
        from.mesh = -1;
    const DrawnPart& part = plan_.fused ? plan_.fused->part : plan_.view.part;
    const KeptHits kept{part, line};
    const bool cuts = part.any();
    ShapeHit best;
    best.at.t = kFar;
    std::int32_t found = -1;
    const auto& meshes = plan_.view.meshes;
    for (std::size_t n = 0; n < meshes.size(); ++n) {
        const auto number = static_cast<std::int32_t>(n);
        const HitFilter filter = cuts && meshes[n].clipped ? HitFilter{keepsHit, &kept} : HitFilter{};
        if (meshes[n].shape->next(ray, behind(from, number), best.at.t, filter, best))
            found = number;
    }
    if (found < 0)
        return std::nullopt;
    Surface surface{{best.at.t, best.at.part, found}};
    light(meshes[static_cast<std::size_t>(found)], best, ray, surface);
    return surface;
}

void MeshRays::light(const SceneMesh& mesh, const ShapeHit& hit, const ShapeRay& ray,
                     Surface& surface) const {
    const glm::dvec3& normal = hit.normal;
    const glm::dvec3 own = mesh.colour.value_or(hit.colour ? *hit.colour : kMeshColour);
    const Optics& optics = plan_.layer().optics;
    const auto opacity = static_cast<float>(mesh.opacity);
    constexpr double kMost = std::numeric_limits<double>::max();
    const double length = glm::length(normal), far = glm::length(ray.direction);
    surface.colour = {glm::vec3(own), opacity};
    if (!optics.shading || !(length > 0) || !std::isfinite(length))
        return;
    const glm::dvec3 n = normal / length, d = ray.direction / far;
    surface.normal = glm::dot(n, d) > 0 ? -n : n;
    leaf::Material<double> material{optics.phong.x, optics.phong.y, optics.phong.z, optics.specularPower};
    if (mesh.material)
        material = {mesh.material->ambient, mesh.material->diffuse, mesh.material->specular,
                    mesh.material->specularPower};
    surface.ambient = glm::vec3(mesh.opacity * material.ambient * own);
    if (!optics.hasLights) {
        const auto light =
            leaf::headLight(n, d, material.ambient, material.diffuse, material.specular, material.power);
        surface.colour = {glm::vec3(own * light.scale + light.add), opacity};
        return;
    }
    const glm::dvec3 place = ray.origin + hit.at.t * ray.direction;
    const auto toPoint = [&](const leaf::LightNumbers& light) { // in voxels of the first volume
        return glm::dvec3(plan_.info().patientFromVoxel *
                          glm::dvec4(light.place[0], light.place[1], light.place[2], 1)) -
               place;
    };
    const leaf::Lit<double> lit =
        light_ ? leaf::litBy<double>(lighting_, n, d, material, kMost, toPoint,
                                     SharedLight{light_->at(place, surface.normal)})
               : leaf::litBy<double>(lighting_, n, d, material, kMost, toPoint, leaf::AllLight());
    for (int c = 0; c < 3; ++c)
        surface.colour[c] = static_cast<float>(own[c] * lit.scale[c] + lit.add[c]);
}

} // namespace tessera
