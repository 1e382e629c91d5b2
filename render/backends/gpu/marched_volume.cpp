// render/backends/gpu/marched_volume.cpp: see marched_volume.h.
#include "render/backends/gpu/marched_volume.h"

#include "core/base/error.h"
#include "render/backends/gpu/skipping_binding.h"

#include <string>

namespace tessera {
namespace {

glm::vec3 vector(const float (&v)[3]) {
    return {v[0], v[1], v[2]};
}

} // namespace

MarchedVolume::MarchedVolume(const VolumeToMarch& of) : of_(of) {
    if (of.occupancy)
        skipping_ = GlTexture3d(GL_RG32UI, of.occupancy->grid(), sizeof(SkippingTexel), GL_NEAREST, *of.gpu,
                                "the map of empty space");
}

std::size_t MarchedVolume::bricks() const {
    return cellCount(brickGrid(of_.info->extentVoxels));
}

void MarchedVolume::introduce(const VolumeUniforms& uniforms, std::size_t firstWanted,
                              std::size_t firstCut) const {
    if (of_.occupancy)
        setSkippingUniforms(uniforms, *of_.occupancy);
    if (uniforms.number() < 0)
        return;
    uniforms.set("uFromLattice", glm::mat3(glm::dmat3(of_.fromLattice)));
    uniforms.set("uLatticeOffset", glm::vec3(glm::dvec3(of_.fromLattice[3])));
    uniforms.set("uVolumeExtent", glm::vec3(of_.info->extentVoxels));
    uniforms.set("uUnitMm", static_cast<float>(of_.unitMm));
    uniforms.set("uFirstWanted", static_cast<int>(firstWanted));
    uniforms.set("uWantedGrid", brickGrid(of_.info->extentVoxels));
    uniforms.set("uFirstCut", static_cast<int>(firstCut));
    uniforms.set("uCutCount", static_cast<int>(of_.cuts.size()));
}

void MarchedVolume::setFunction(const VolumeUniforms& uniforms, std::uint32_t features,
                                const Optics& optics) {
    tables_.set(optics, features, *of_.gpu);
    uniforms.set("uPreintegrationScale", optics.preintegrationScale);
    uniforms.set("uSumsStart", static_cast<int>(optics.bins.size()));
    uniforms.set("uPreintegrationFirstLayer", optics.seen.firstLayer());
    uniforms.set("uTableScale", optics.scale);
    uniforms.set("uTableOffset", optics.offset);
    uniforms.set("uTableLast", static_cast<int>(optics.table.size()) - 1);
    uniforms.set("uVoxelFromPatientTransposed", optics.voxelFromPatientTransposed);
    uniforms.set("uPatientFromVolume", optics.patientFromVoxel);
    uniforms.set("uHasLabels", optics.labels.count > 0 ? 1 : 0);
    uniforms.set("uLabelPlain", static_cast<int>(optics.labels.plain));
    uniforms.set("uLabelTinted", static_cast<int>(optics.labels.tinted));
    uniforms.set("uLabelSolid", static_cast<int>(optics.labels.solid));
    uniforms.set("uLabelDense", static_cast<int>(optics.labels.dense));
    uniforms.set("uLabelColour", static_cast<int>(optics.labels.colour));
    uniforms.set("uLabelDensity", optics.labels.density);
    uniforms.set("uLabelNearest", optics.labels.nearest ? 1 : 0);
    uniforms.set("uLabelSlopes", optics.shading && optics.labels.solid >= 0 ? 6 : 0);
    const leaf::GradientNumbers<double>& factor = optics.gradientOpacity;
    uniforms.set("uGradientPoints", static_cast<int>(factor.count));
    for (std::size_t i = 0; i < static_cast<std::size_t>(factor.count); ++i)
        uniforms.set(element("uGradientOpacity", i),
                     glm::vec3(factor.length[i], factor.factor[i], factor.slope[i]));
    if (factor.count == 0) // another volume has one
        uniforms.set("uGradientOpacity[0]", glm::vec3(0, 1, 0));
    if (features & kFeatureLights)
        setLights(uniforms, optics);
}

void MarchedVolume::setLights(const VolumeUniforms& uniforms, const Optics& optics) {
    const leaf::LightingNumbers& lighting = optics.lighting;
    uniforms.set("uHasLights", optics.hasLights ? 1 : 0);
    uniforms.set("uLights", static_cast<int>(lighting.count));
#define SET(type, name, otherwise) uniforms.set("uLightModel." #name, lighting.model.name);
    LIGHT_MODEL(SET)
#undef SET
    uniforms.set("uOcclusionChannel", static_cast<int>(lighting.occlusionChannel));
    uniforms.set("uAmbientChannels", static_cast<int>(lighting.ambientChannels));
    for (int i = 0; i < lighting.count; ++i) {
        const leaf::LightNumbers& light = lighting.lights[i];
        const auto number = static_cast<std::size_t>(i);
        uniforms.set(element("uLightSort", number), static_cast<int>(light.sort));
        uniforms.set(element("uLightChannel", number), static_cast<int>(light.channel));
        uniforms.set(element("uLightPlace", number), vector(light.place));
        uniforms.set(element("uLightColour", number), vector(light.colour));
        uniforms.set(element("uLightFading", number), vector(light.fading));
    }
    uniforms.set("uMaterials", static_cast<int>(optics.materials.size()));
    for (std::size_t i = 0; i < optics.materials.size(); ++i) {
        const leaf::MaterialNumbers& m = optics.materials[i];
        uniforms.set(element("uMaterialPlaces", i),
                     glm::vec2(placeOf(optics, m.from), placeOf(optics, m.to)));
        uniforms.set(element("uMaterialPhong", i), glm::vec3(m.ambient, m.diffuse, m.specular));
        uniforms.set(element("uMaterialPower", i), static_cast<int>(m.power));
        uniforms.set(element("uMaterialEmission", i), vector(m.emission));
    }
}

void MarchedVolume::takeOccupancy(const Occupancy& occupancy) {
    TESSERA_CHECK(occupancy.grid() == skipping_.extent());
    uploadSkipping(skipping_, occupancy, occupancy.changedSince(skippingVersion_));
    skippingVersion_ = occupancy.version();
}

void MarchedVolume::setSurfaceMap(const Occupancy& surfaces) {
    TESSERA_CHECK(of_.occupancy && surfaces.grid() == of_.occupancy->grid());
    if (surfaceMap_.bytes() == 0)
        surfaceMap_ = GlTexture3d(GL_RG32UI, surfaces.grid(), sizeof(SkippingTexel), GL_NEAREST, *of_.gpu,
                                  "the map of isosurfaces");
    uploadSkipping(surfaceMap_, surfaces, {0, surfaces.grid().z});
}

void MarchedVolume::setBounds(const ValueBounds& bounds) {
    const auto upload = [&](GlTexture3d& texture, const glm::ivec3& grid, const float* texels) {
        if (texture.extent() != grid)
            texture = GlTexture3d(GL_R32F, grid, sizeof(float), GL_NEAREST, *of_.gpu, "the bounds of values");
        texture.upload(glm::ivec3(0), grid, GL_RED, GL_FLOAT, texels);
    };
    upload(brickBounds_, bounds.bricks(), bounds.brick().data());
    if (!bounds.cell().empty())
        upload(cellBounds_, bounds.cells(), bounds.cell().data());
    boundsOfCells_ = !bounds.cell().empty();
}

void MarchedVolume::bind(const VolumeUniforms& uniforms, std::uint32_t features,
                         const FieldSource& source) const {
    bindField(uniforms, features, *of_.info, source);
    const GLuint map = unitOf(uniforms, kSkippingUnit), other = unitOf(uniforms, kSurfaceMapUnit);
    if ((features & kFeatureSkipping) && (features & kFeatureValues)) {
        TESSERA_CHECK(brickBounds_.bytes() > 0);
        brickBounds_.bind(map);
        (boundsOfCells_ ? cellBounds_ : brickBounds_).bind(other);
        uniforms.set("uBrickBounds", static_cast<int>(map));
        uniforms.set("uCellBounds", static_cast<int>(other));
        uniforms.set("uBoundsOfCells", boundsOfCells_ ? 1 : 0);
        uniforms.set("uSkippingLast", of_.info->extentVoxels - 1);
    } else if (features & kFeatureSkipping) {
        skipping_.bind(map);
        (surfaceMap_.bytes() > 0 ? surfaceMap_ : skipping_).bind(other);
        uniforms.set("uSurfaceMap", static_cast<int>(other));
    }
    tables_.bind(uniforms);
}

} // namespace tessera
