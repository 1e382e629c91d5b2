// render/optics.cpp: see optics.h.
#include "render/optics.h"

namespace tessera {

Optics makeOptics(const TransferTable& table, const VolumeInfo& info, const Shading& shading,
                  double terminationTransmittance) {
    Optics o;
    o.table = table.entries;
    // Physical = slope * stored + intercept, folded into the table's own scale once, in double.
    const double perValue = static_cast<double>(table.entriesPerValue);
    o.scale = static_cast<float>(info.rescaleSlope * perValue);
    o.offset = static_cast<float>((info.rescaleIntercept - static_cast<double>(table.firstValue)) * perValue);
    o.shading = shading.on;
    o.phong = glm::vec3(shading.ambient, shading.diffuse, shading.specular);
    o.specularPower = std::clamp(static_cast<int>(std::lround(shading.specularPower)), 1, 1024);
    const glm::dmat3 linear(info.patientFromVoxel);
    o.voxelFromPatientTransposed = glm::mat3(glm::transpose(glm::inverse(linear)));
    o.patientFromVoxel = glm::mat3(linear);
    o.termination = static_cast<float>(terminationTransmittance);
    return o;
}

} // namespace tessera
