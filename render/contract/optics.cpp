// render/contract/optics.cpp: see optics.h.
#include "render/contract/optics.h"

#include "core/error.h"

namespace tessera {

Optics makeOptics(const TransferTable& table, const VolumeInfo& info, const Shading& shading,
                  double terminationTransmittance, Integrator integrator) {
    Optics o;
    o.table = table.entries;
    // Physical = slope * stored + intercept, folded into the table's own scale once, in double.
    const double perValue = static_cast<double>(table.entriesPerValue);
    o.scale = static_cast<float>(info.rescaleSlope * perValue);
    o.offset = static_cast<float>((info.rescaleIntercept - static_cast<double>(table.firstValue)) * perValue);
    o.shading = shading.on;
    o.gradient = shading.gradient;
    o.phong = glm::vec3(shading.ambient, shading.diffuse, shading.specular);
    o.specularPower = std::clamp(static_cast<int>(std::lround(shading.specularPower)), 1, 1024);
    const glm::dmat3 linear(info.patientFromVoxel);
    o.voxelFromPatientTransposed = glm::mat3(glm::transpose(glm::inverse(linear)));
    o.patientFromVoxel = glm::mat3(linear);
    o.termination = static_cast<float>(terminationTransmittance);
    o.volumeShows = !table.isTransparent();
    setIntegrator(o, integrator);
    return o;
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

std::vector<SurfaceLook> surfaceLooks(const std::vector<Isosurface>& surfaces, const VolumeInfo& info) {
    std::vector<SurfaceLook> looks;
    for (const Isosurface& s : surfaces)
        if (s.opacity > 0)
            looks.push_back({static_cast<float>((s.value - info.rescaleIntercept) / info.rescaleSlope),
                             glm::vec3(s.colour), static_cast<float>(s.opacity)});
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
