// render/contract/optics.cpp: see optics.h.
#include "render/contract/optics.h"

#include "core/base/error.h"
#include "core/base/volume.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

namespace tessera {

Optics makeOptics(const TransferTable& table, const VolumeInfo& info, const Shading& shading,
                  double terminationTransmittance, Integrator integrator) {
    Optics o;
    o.table = table.entries;
    // Physical = slope * stored + intercept, folded into the table's own scale once, in double.
    const double perValue = static_cast<double>(table.entriesPerValue);
    // Held to the range of floats, so that no place is infinity minus infinity.
    const auto held = [](double number) {
        constexpr double most = std::numeric_limits<float>::max();
        return static_cast<float>(std::clamp(number, -most, most));
    };
    o.scale = held(info.rescaleSlope * perValue);
    o.offset = held((info.rescaleIntercept - static_cast<double>(table.firstValue)) * perValue);
    setShading(o, shading);
    o.gradientOpacity = gradientNumbers(table.gradientOpacity, info);
    const glm::dmat3 linear(info.patientFromVoxel);
    o.voxelFromPatientTransposed = glm::mat3(glm::transpose(glm::inverse(linear)));
    o.patientFromVoxel = glm::mat3(linear);
    o.termination = static_cast<float>(terminationTransmittance);
    o.volumeShows = !table.isTransparent();
    setIntegrator(o, integrator);
    return o;
}

leaf::GradientNumbers<double> gradientNumbers(const GradientOpacity& factor, const VolumeInfo& info) {
    static_assert(GradientOpacity::kMostPoints == leaf::kMostGradientPoints);
    const std::vector<GradientPoint> points = factor.perMm(meanSpacingMm(info)).points();
    const double most = std::numeric_limits<float>::max();
    leaf::GradientNumbers<double> numbers;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const double length = std::min(points[i].length / std::abs(info.rescaleSlope), most);
        numbers.length[i] = length;
        numbers.factor[i] = points[i].factor;
        if (i > 0 && length > numbers.length[i - 1])
            numbers.slope[i - 1] = std::clamp(
                (points[i].factor - points[i - 1].factor) / (length - numbers.length[i - 1]), -most, most);
    }
    numbers.count = static_cast<std::int32_t>(points.size());
    return numbers;
}

void setShading(Optics& o, const Shading& shading) {
    o.shading = shading.on;
    setGradient(o, shading.gradient);
    o.phong = glm::vec3(shading.ambient, shading.diffuse, shading.specular);
    o.specularPower = std::clamp(static_cast<int>(std::lround(shading.specularPower)), 1, 1024);
}

void setIntegrator(Optics& o, Integrator integrator) {
    TESSERA_CHECK(integrator != Integrator::automatic);
    o.integrator = integrator;
    o.bins.clear();
    o.sums.clear();
    if (integrator == Integrator::preintegrated || integrator == Integrator::preintegrated2d)
        o.bins = extinctionBins(o.table);
    if (integrator == Integrator::preintegrated)
        o.sums = colourSums(o.table);
}

void setLighting(Optics& o, const Shading& shading, const Lighting& lighting,
                 const std::vector<Material>& materials, const Camera& camera, const VolumeInfo& info) {
    o.lighting = {};
    o.materials.clear();
    o.hasLights = shading.on && (!isHeadLightAlone(lighting.lights) || !materials.empty() ||
                                 shading.model != ShadingModel::phong || shading.gradientWeight ||
                                 ambientChannels(lighting) > 0);
    if (!o.hasLights && !lighting.transport) // paths of light ask for what materials send
        return;
    o.lighting.model.halfway = shading.model == ShadingModel::blinnPhong ? 1 : 0;
    if (const auto& weight = shading.gradientWeight) {
        const double perStored = 1 / std::abs(info.rescaleSlope);
        o.lighting.model.weightLow = static_cast<float>(weight->low * perStored);
        o.lighting.model.weightScale = static_cast<float>(std::min(
            1 / ((weight->high - weight->low) * perStored), double{std::numeric_limits<float>::max()}));
    }
    const auto stored = [&](double value) {
        return static_cast<float>((value - info.rescaleIntercept) / info.rescaleSlope);
    };
    for (const Material& m : materials) {
        o.materials.push_back({stored(m.from),
                               stored(m.to),
                               static_cast<float>(m.ambient),
                               static_cast<float>(m.diffuse),
                               static_cast<float>(m.specular),
                               m.specularPower,
                               {static_cast<float>(m.emission.r), static_cast<float>(m.emission.g),
                                static_cast<float>(m.emission.b)}});
        o.lighting.emits = o.lighting.emits || m.emission != glm::dvec3(0);
    }
    placeLights(o, lighting, camera, info);
}

void placeLights(Optics& o, const Lighting& lighting, const Camera& camera, const VolumeInfo& info) {
    if (!o.hasLights && !lighting.transport)
        return;
    const glm::dmat3 axes = patientFromCamera(camera);
    const glm::dmat4 voxelFromPatient = glm::inverse(info.patientFromVoxel);
    const auto put = [](float(&to)[3], const glm::dvec3& from) {
        for (int i = 0; i < 3; ++i)
            to[i] = static_cast<float>(from[i]);
    };
    o.lighting.count = 0;
    o.lighting.channels = ambientChannels(lighting);
    o.lighting.occlusionChannel = o.lighting.channels > 0 ? 0 : -1;
    o.lighting.ambientChannels = std::max(1, o.lighting.channels);
    for (const Light& light : shiningLights(lighting.lights)) {
        leaf::LightNumbers& n = o.lighting.lights[o.lighting.count++];
        const bool withCamera = light.frame == LightFrame::camera;
        put(n.colour, light.intensity * light.colour);
        n.channel = light.shadow && light.kind != LightKind::head ? o.lighting.channels++ : -1;
        switch (light.kind) {
        case LightKind::head:
            n.sort = leaf::LightSort::head;
            break;
        case LightKind::directional: {
            n.sort = leaf::LightSort::directional;
            const glm::dvec3 d = withCamera ? axes * light.direction : light.direction;
            const double length = glm::length(d);
            put(n.place, length > 0 ? d / length : glm::dvec3(0));
            break;
        }
        case LightKind::point:
            n.sort = leaf::LightSort::point;
            put(n.place,
                glm::dvec3(
                    voxelFromPatient *
                    glm::dvec4(withCamera ? camera.position + axes * light.position : light.position, 1)));
            put(n.fading, light.attenuation);
            break;
        }
    }
}

std::vector<SurfaceLook> surfaceLooks(const std::vector<Isosurface>& surfaces, const VolumeInfo& info) {
    std::vector<SurfaceLook> looks;
    const double voxelMm = std::cbrt(std::abs(glm::determinant(glm::dmat3(info.patientFromVoxel))));
    for (const Isosurface& s : surfaces)
        if (s.drawnOpacity() > 0) {
            looks.push_back({static_cast<float>((s.value - info.rescaleIntercept) / info.rescaleSlope),
                             glm::vec3(s.drawnColour()), static_cast<float>(s.drawnOpacity()),
                             static_cast<float>(-std::log1p(-std::min(s.opacity, 1 - 0x1p-24)) / voxelMm),
                             s.finish, s.reflection, static_cast<float>(s.opacity), true});
        }
    std::stable_sort(looks.begin(), looks.end(),
                     [](const SurfaceLook& a, const SurfaceLook& b) { return a.isovalue < b.isovalue; });
    return looks;
}

void preparePreintegration2d(Optics& o, double segmentMm, int firstLayer, int layers) {
    if (o.integrator != Integrator::preintegrated2d) {
        o.seen = Preintegration2d();
        return;
    }
    o.preintegrationScale =
        static_cast<float>(Preintegration2d::kEdge - 1) / static_cast<float>(o.table.size() - 1);
    if (o.seen.length() == segmentMm && o.seen.firstLayer() == firstLayer && o.seen.layers() == layers)
        o.seen.update(o.table);
    else
        o.seen = Preintegration2d(o.table, segmentMm, firstLayer, layers);
}

} // namespace tessera
