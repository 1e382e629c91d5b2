// render/contract/optics.h: colour, opacity and shading of a value in a segment, from the leaves that
// shaders have too (leaves.h). In double it uses the best the library has.
#pragma once

#include "core/base/volume.h"
#include "core/scene/camera.h"
#include "core/scene/scene.h" // Shading, Lighting
#include "core/scene/transfer_function.h"
#include "render/contract/leaves.h"
#include "render/contract/preintegration.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/vec4.hpp>
#include <limits>
#include <vector>

namespace tessera {

/// An isosurface as rays meet it.
struct SurfaceLook {
    float isovalue = 0; // stored units
    glm::vec3 colour{1};
    float opacity = 1;
    float occlusion = 0; // extinction per mm of the medium behind it, for occlusion and shadows
    std::optional<SurfaceFinish> finish = {}; // its own
    std::optional<Reflection> reflection = {};
    float own = 1;       // its opacity as the scene has it; where it transmits rays of the eye meet another
    bool reports = true; // rays keep their first hit among such surfaces
};

/// The transfer table addressed by stored values: entry = stored * scale + offset. Float, as the
/// shader has it.
struct Optics {
    std::vector<glm::vec4> table; // rgb colour, a extinction per mm
    float scale = 0, offset = 0;
    bool shading = false;
    Gradient gradient = Gradient::central; // operator of opacity by gradient, of most kinds of shading too
    Gradient normals = Gradient::central;  // operator of shading
    glm::vec3 phong{0};                    // ambient, diffuse, specular
    int specularPower = 1;
    /// The scene's own lights, instead of a white head light, and the materials.
    bool hasLights = false;
    leaf::LightingNumbers lighting;
    std::vector<leaf::MaterialNumbers> materials; // by value; their places as stored values
    leaf::GradientNumbers<double> gradientOpacity;
    leaf::LabelNumbers labels;
    glm::mat3 voxelFromPatientTransposed{1}; // linear parts
    glm::mat3 patientFromVoxel{1};
    Reduction reduction = Reduction::composite;   // else the table is of single values (core/scene/mode.h)
    float termination = 0;                        // transmittance below which a ray ends; 0: never
    Integrator integrator = Integrator::midpoint; // never automatic
    std::vector<glm::vec4> bins;                  // of the pre-integrated ones: extinctionBins()
    std::vector<glm::vec4> sums;                  // of preintegrated: colourSums()
    Preintegration2d seen;                        // of preintegrated2d
    float preintegrationScale = 0;                // its places per entry

    std::vector<SurfaceLook> surfaces; // by isovalue, ascending
    bool volumeShows = true;           // the table has an extinction

    /// There is gradient opacity.
    bool grades() const { return gradientOpacity.count > 0; }
    /// Normals are by an operator of their own.
    bool smooths() const { return normals != gradient; }
    /// True if segments need a gradient.
    bool takesGradients() const { return shading || grades(); }

    /// For the GPU ray caster's tables.
    std::size_t gpuBytes() const {
        return (table.size() + bins.size() + sums.size() + seen.colours().size()) * sizeof(glm::vec4);
    }
};

Optics makeOptics(const TransferTable& table, const VolumeInfo& info, const Shading& shading,
                  double terminationTransmittance, Integrator integrator = Integrator::midpoint);
/// As the contract has it of a volume's stored values.
leaf::GradientNumbers<double> gradientNumbers(const GradientOpacity& factor, const VolumeInfo& info);
/// Takes the operator of gradients.
inline void setGradient(Optics& optics, Gradient gradient) {
    optics.gradient = operatorOfLengths(gradient);
    optics.normals = gradient;
}
/// Takes the material for a head light; lights follow with setLighting().
void setShading(Optics& optics, const Shading& shading);
/// Takes the scene's lights and materials; nothing where a white head light makes Phong's highlights on one
/// material, wherever there is a gradient: that is shade() without lights.
void setLighting(Optics& optics, const Shading& shading, const Lighting& lighting,
                 const std::vector<Material>& materials, const Camera& camera, const VolumeInfo& info);
/// The same lights from another camera.
void placeLights(Optics& optics, const Lighting& lighting, const Camera& camera, const VolumeInfo& info);
/// Takes an integrator, not automatic, with the parts of the table that it needs besides two-dimensional
/// pre-integration.
void setIntegrator(Optics& optics, Integrator integrator);
/// Sorted as Optics has them; those that are wholly transparent are left out.
std::vector<SurfaceLook> surfaceLooks(const std::vector<Isosurface>& surfaces, const VolumeInfo& info);
/// preintegrated2d: makes the table of two-dimensional pre-integration, or mends it where only entries differ
/// from those it was made of.
/// @param segmentMm  a typical segment; layers for strides of 2^firstLayer segments and the next
void preparePreintegration2d(Optics& optics, double segmentMm, int firstLayer, int layers);

/// A value in units of the table's entries, also beyond them.
template <typename Real> Real placeOf(const Optics& o, Real stored) {
    return leaf::farPlaceOf(stored, static_cast<Real>(o.scale), static_cast<Real>(o.offset));
}

/// In the table: of a value that is no number, the first.
template <typename Real> Real clampedPlaceOf(const Optics& o, Real stored) {
    return leaf::heldPlace(stored * static_cast<Real>(o.scale) + static_cast<Real>(o.offset),
                           static_cast<Real>(o.table.size() - 1));
}

/// @param x  a place in the table
template <typename Real> glm::vec<4, Real> tableEntryAt(const Optics& o, Real x) {
    const int last = static_cast<int>(o.table.size()) - 1;
    const int i = std::min(static_cast<int>(x), last - 1);
    const glm::vec<4, Real> a(o.table[static_cast<std::size_t>(i)]),
        b(o.table[static_cast<std::size_t>(i) + 1]);
    return leaf::partWay(a, b, x - static_cast<Real>(i));
}

template <typename Real> glm::vec<4, Real> lookUp(const Optics& o, Real stored) {
    return tableEntryAt(o, clampedPlaceOf(o, stored));
}

/// Extinction per mm that attenuates light: the function's, and behind each isosurface that of a medium. The
/// medium lets as much light through a voxel's length as the surface does.
/// @param factor  gradient opacity, on the function's
template <typename Real> Real occlusionExtinction(const Optics& o, Real stored, Real factor = Real(1)) {
    Real extinction = factor * lookUp(o, stored).a;
    for (const SurfaceLook& s : o.surfaces)
        if (stored >= static_cast<Real>(s.isovalue))
            extinction += static_cast<Real>(s.occlusion);
    return extinction;
}

template <typename Real> leaf::Material<Real> materialAt(const Optics& o, Real place);

/// Light that tissue of a value sends into occlusion's rays: its material's, where it stands in
/// the light's way.
template <typename Real> glm::vec<3, Real> occlusionEmission(const Optics& o, Real stored) {
    if (!o.lighting.emits || !(occlusionExtinction(o, stored) > Real(0)))
        return glm::vec<3, Real>(0);
    const leaf::Material<Real> m = materialAt(o, placeOf(o, stored));
    return {m.emission[0], m.emission[1], m.emission[2]};
}

/// The share of light that tissue of a value scatters, where it stands in the light's way: the colours of the
/// function and of the isosurfaces in front of the value, by their extinctions.
template <typename Real> glm::vec<3, Real> occlusionAlbedo(const Optics& o, Real stored) {
    const glm::vec<4, Real> function = lookUp(o, stored);
    glm::vec<3, Real> sum = function.a * glm::vec<3, Real>(function);
    Real extinction = function.a;
    for (const SurfaceLook& s : o.surfaces)
        if (stored >= static_cast<Real>(s.isovalue)) {
            sum += static_cast<Real>(s.occlusion) * glm::vec<3, Real>(s.colour);
            extinction += static_cast<Real>(s.occlusion);
        }
    return extinction > Real(0) ? sum / extinction : glm::vec<3, Real>(0);
}

/// 1 - exp(-depth).
inline double opacityOf(double depth) {
    return -std::expm1(-depth);
}
inline float opacityOf(float depth) {
    return leaf::oneMinusExp(depth);
}

/// By one of the linear parts, from voxel space.
template <typename Real> glm::vec<3, Real> inPatient(const glm::mat3& linear, const glm::vec<3, Real>& v) {
    return leaf::transformed(glm::mat<3, 3, Real>(linear), v);
}

/// The gradient in patient space as a unit normal that faces against the ray; 0 where there is none.
template <typename Real>
glm::vec<3, Real> unitNormal(const Optics& o, const glm::vec<3, Real>& gradient,
                             const glm::vec<3, Real>& direction) {
    const glm::vec<3, Real> g = inPatient<Real>(o.voxelFromPatientTransposed, gradient);
    const Real length = leaf::length3(g);
    return leaf::facingNormal(g, inPatient<Real>(o.patientFromVoxel, direction), length, length > Real(0));
}

/// Gradient opacity, where there is one: a factor on the extinction. gradient: voxel space, stored units.
template <typename Real> Real gradientFactor(const Optics& o, const glm::vec<3, Real>& gradient) {
    return leaf::gradientOpacity<Real>(o.gradientOpacity,
                                       inPatient<Real>(o.voxelFromPatientTransposed, gradient),
                                       std::numeric_limits<Real>::max());
}

/// Phong with a head light. gradient: voxel space, any scale; direction: the ray's, unit, voxel space.
template <typename Real>
glm::vec<3, Real> shade(const Optics& o, const glm::vec<3, Real>& colour, const glm::vec<3, Real>& gradient,
                        const glm::vec<3, Real>& direction) {
    const auto g = inPatient<Real>(o.voxelFromPatientTransposed, gradient);
    const auto d = inPatient<Real>(o.patientFromVoxel, direction);
    if (!leaf::isHeadLit(g, d, std::numeric_limits<Real>::max()))
        return colour;
    const auto light = leaf::headLight(g, d, static_cast<Real>(o.phong.x), static_cast<Real>(o.phong.y),
                                       static_cast<Real>(o.phong.z), o.specularPower);
    return colour * light.scale + light.add;
}

/// Of the value at a place of the table (integrators.h: placeOf()).
template <typename Real> leaf::Material<Real> materialAt(const Optics& o, Real place) {
    for (const leaf::MaterialNumbers& m : o.materials)
        if (place >= placeOf(o, static_cast<Real>(m.from)) && place < placeOf(o, static_cast<Real>(m.to)))
            return {static_cast<Real>(m.ambient),
                    static_cast<Real>(m.diffuse),
                    static_cast<Real>(m.specular),
                    m.power,
                    {static_cast<Real>(m.emission[0]), static_cast<Real>(m.emission[1]),
                     static_cast<Real>(m.emission[2])}};
    return {static_cast<Real>(o.phong.x), static_cast<Real>(o.phong.y), static_cast<Real>(o.phong.z),
            o.specularPower};
}

/// By the scene's lights, or as shade() above where it has none of its own.
/// @param position  voxels
/// @param received  shares of the light: leaf::AllLight, or leaf::ReceivedLight<Real>
template <typename Real, typename Received = leaf::AllLight>
glm::vec<3, Real> shade(const Optics& o, const glm::vec<3, Real>& colour, const glm::vec<3, Real>& gradient,
                        const glm::vec<3, Real>& direction, const glm::vec<3, Real>& position,
                        const leaf::Material<Real>& material, const Received& received = {}) {
    using Vec = glm::vec<3, Real>;
    const Vec g = inPatient<Real>(o.voxelFromPatientTransposed, gradient);
    const Vec d = inPatient<Real>(o.patientFromVoxel, direction);
    const auto toPoint = [&](const leaf::LightNumbers& light) {
        return inPatient<Real>(o.patientFromVoxel,
                               Vec(light.place[0], light.place[1], light.place[2]) - position);
    };
    const leaf::Lit<Real> lit =
        leaf::litBy<Real>(o.lighting, g, d, material, std::numeric_limits<Real>::max(), toPoint, received);
    Vec seen(colour.x * lit.scale[0] + lit.add[0], colour.y * lit.scale[1] + lit.add[1],
             colour.z * lit.scale[2] + lit.add[2]);
    if (o.lighting.emits)
        seen += Vec(material.emission[0], material.emission[1], material.emission[2]);
    return seen;
}

/// The same with the voxels' shares of light, if the scene has light of voxels.
/// @param field  received(p, lighting) where it has
template <typename Real, typename Field>
glm::vec<3, Real> shadeReceived(const Optics& o, const glm::vec<3, Real>& colour,
                                const glm::vec<3, Real>& gradient, const glm::vec<3, Real>& direction,
                                const glm::vec<3, Real>& position, const leaf::Material<Real>& material,
                                Field& field) {
    if (o.lighting.channels == 0)
        return shade(o, colour, gradient, direction, position, material);
    return shade(o, colour, gradient, direction, position, material, field.received(position, o.lighting));
}

/// The effect of labels on a segment; none where the scene has none.
template <typename Real> class LabelledSample {
  public:
    /// @param field  labels(p), where there are labels
    template <typename Field>
    LabelledSample(const Optics& o, Field& field, const glm::vec<3, Real>& p) : o_(o.labels) {
        if (o_.count > 0) {
            shares_ = field.labels(p);
            medium_ = leaf::labelledMedium(shares_, static_cast<Real>(o_.density));
        }
    }
    /// @param extinction  of the function
    bool shows(Real extinction) const {
        return o_.count == 0 ? extinction > Real(0)
                             : leaf::labelledFunction(shares_, extinction) > Real(0) || medium_ > Real(0);
    }
    /// The extinction of the segment.
    Real take(Real extinction) {
        if (o_.count == 0)
            return extinction;
        const Real function = leaf::labelledFunction(shares_, extinction), sum = function + medium_;
        part_ = sum > Real(0) ? leaf::labelledPart(shares_, extinction, medium_, sum) : Real(0);
        isMedium_ = medium_ > function;
        return sum;
    }
    // Of what was taken:
    bool isMedium() const { return isMedium_; } // more than the function is
    glm::vec<3, Real> colour(const glm::vec<3, Real>& c) const {
        return o_.colour < 0 ? c
                             : glm::vec<3, Real>(leaf::labelledColour(shares_, c.x, shares_.red, part_),
                                                 leaf::labelledColour(shares_, c.y, shares_.green, part_),
                                                 leaf::labelledColour(shares_, c.z, shares_.blue, part_));
    }

  private:
    const leaf::LabelNumbers& o_;
    leaf::LabelShares<Real> shares_{};
    Real medium_ = 0, part_ = 0;
    bool isMedium_ = false;
};

/// The visible colour: lit, where the scene is.
/// @param material  gives the material there: f(), asked where the scene has lights of its own
template <typename Real, typename MaterialHere, typename Field>
glm::vec<3, Real> seenColour(const Optics& o, const glm::vec<3, Real>& colour,
                             const glm::vec<3, Real>& gradient, const glm::vec<3, Real>& direction,
                             const glm::vec<3, Real>& position, const MaterialHere& material, Field& field) {
    if (!o.shading)
        return colour;
    return o.hasLights ? shadeReceived(o, colour, gradient, direction, position, material(), field)
                       : shade(o, colour, gradient, direction);
}

} // namespace tessera
