// render/plan/scene_rules.cpp: see scene_rules.h.
#include "render/plan/scene_rules.h"

#include "core/base/error.h"
#include "render/plan/layer_histograms.h"

#include <algorithm>
#include <string>

namespace tessera {
namespace {

/// Integrators that use a segment's ends assume a continuous field.
void checkIntegrator(const Quality& quality) {
    if (quality.edgeFunction == EdgeFunction::nearest && quality.integrator != Integrator::automatic &&
        quality.integrator != Integrator::midpoint)
        throw InputError(
            "integrator: expected midpoint where bricks are not blended (edge function nearest), "
            "found " +
            integratorNames()[static_cast<std::size_t>(quality.integrator)]);
}

/// Hulls are a way to sample one medium. Segments of any length have no table of their own.
void checkHulls(const Scene& scene) {
    if (scene.quality.sampling != Sampling::hulls)
        return;
    struct Rule {
        bool breaks;
        const char *expected, *found;
    };
    const Rule rules[] = {
        {scene.volumes.size() > 1, "one volume", "several"},
        {scene.mode != Mode::composite, "mode composite", "another"},
        {!scene.surfaces.empty(), "no isosurfaces, which are sought by steps in voxels", "some"},
        {!scene.volumes.at(0).labels.path.empty(), "no labels, whose borders are sought by steps in voxels",
         "some"},
        {scene.lighting.transport.has_value(), "no paths of light", "them"},
        {scene.quality.maxError.has_value(), "no error bound, for which steps are chosen", "one"},
        {scene.quality.integrator == Integrator::preintegrated2d,
         "an integrator whose tables hold for segments of any length", "pre-integrated-2d"},
    };
    for (const Rule& rule : rules)
        if (rule.breaks)
            throw badFile("quality.sampling \"hulls\"", rule.expected, rule.found);
}

/// Scattered light is gathered from one volume, in the colours of its function.
void checkScatter(const Scene& scene) {
    if (!scatters(scene.lighting) || scene.lighting.transport || reductionOf(scene) != Reduction::composite)
        return;
    const auto refuse = [](const std::string& expected, const std::string& found) {
        return InputError("lighting.lights: expected " + expected + " beside \"scatter\", found " + found);
    };
    if (scene.volumes.size() > 1)
        throw refuse("one volume", std::to_string(scene.volumes.size()));
    if (!scene.volumes.at(0).labels.path.empty())
        throw refuse("no labels, whose colours scattered light would lack,", "some");
    if (replacesLightOfVoxels(scene))
        throw refuse("no surfaceOcclusion, which replaces light of voxels,", "it");
}

void checkSurfaceOcclusion(const FramePlan& plan) {
    if (!plan.view.lighting.surfaceOcclusion)
        return;
    const std::string where = "lighting.surfaceOcclusion: ";
    if (!plan.layer().optics.shading)
        throw InputError(where +
                         "occlusion is light, and this picture has none (shading is off); leave it out, "
                         "or shade with ambient 1 and diffuse 0");
    if (plan.layer().optics.surfaces.empty() && plan.view.meshes.empty())
        throw InputError(where +
                         "expected an isosurface that is not wholly transparent, or a mesh, found none");
    if (plan.view.lighting.surfaceOcclusion->scale > 1 && !plan.view.lighting.surfaceOcclusion->filter)
        throw InputError(where +
                         "expected scale 1 without filter, which finds what is between its rays, found " +
                         std::to_string(plan.view.lighting.surfaceOcclusion->scale));
}

/// What leaves the volume sees it.
void checkEnvironment(const Scene& scene) {
    if (const auto& sky = scene.lighting.environment; sky && !sky->file.path.empty() && !sky->file.map)
        throw badFile(sky->file.path.string(), "a file of the scene's own lighting.environment",
                      "one of a path's keyframes, which is not read");
}

/// Ways that leave isosurfaces go through the volume alone.
void checkReflections(const FramePlan& plan, const Scene& scene) {
    if (!reflects(scene))
        return;
    const auto refuse = [](const std::string& expected, const std::string& found) {
        return InputError("isosurfaces: expected " + expected + " beside \"reflection\", found " + found);
    };
    if (!plan.view.meshes.empty())
        throw refuse("no meshes, which it would lack,", std::to_string(plan.view.meshes.size()));
    if (scene.lighting.transport)
        throw refuse("no paths of light (lighting.transport), which have \"finish\" in its place,", "them");
}

/// What paths of light do not go with.
void checkTransport(const Scene& scene, const FramePlan& plan) {
    if (!scene.lighting.transport) {
        if (scene.quality.pixels.denoise)
            throw InputError("quality.denoise: expected paths of light (lighting.transport), whose noise it "
                             "takes out, found none");
        return;
    }
    const auto refuse = [](const std::string& expected, const std::string& found) {
        return InputError("lighting.transport: expected " + expected + ", found " + found);
    };
    if (plan.layer().reduces())
        throw refuse("mode composite", "one of single values");
    if (!plan.layer().optics.surfaces.empty() &&
        scene.lighting.transport->response == TransportResponse::contract)
        throw refuse("no isosurfaces beside response \"contract\"",
                     std::to_string(plan.layer().optics.surfaces.size()));
    if (!plan.view.meshes.empty())
        throw refuse("no meshes", std::to_string(plan.view.meshes.size()));
    if (scene.lighting.transport->response == TransportResponse::contract) {
        if (!scene.shading.on)
            throw refuse("shading, which response \"contract\" is about", "none");
        if (const auto& occlusion = scene.lighting.occlusion;
            occlusion && (occlusion->method != OcclusionMethod::local || occlusion->emission > 0 ||
                          occlusion->directions != OcclusionDirections::sphere))
            throw refuse("occlusion of method local, directions sphere and emission 0, which the mean of "
                         "single ways comes to",
                         "another");
        if (scatters(scene.lighting))
            throw refuse("no light with \"scatter\" beside response \"contract\", whose paths scatter once",
                         "one");
    }
    if (scene.quality.pixels.samples == PixelSampling::kAutomatic)
        throw refuse("a number of samples (pixels that choose theirs by noise are too dark)", "auto");
    if (plan.view.quality.maxError)
        throw refuse("no error bound (its noise is no part of it)", "one");
}

} // namespace

void checkLight(const Scene& scene) {
    if (lightChannels(scene.lighting) > 0 && !scene.shading.on)
        throw InputError(
            "lighting: occlusion, shadows and scattered light need shading, and it is off; leave "
            "them out, or shade with ambient 1 and diffuse 0");
    checkHistograms(scene);
    checkScatter(scene);
    const auto& occlusion = scene.lighting.occlusion;
    if (occlusion && occlusion->emission > 0 && occlusion->method != OcclusionMethod::local)
        throw InputError("lighting.occlusion: emission needs method \"local\", because other methods use "
                         "only the light at a ray's end; set emission to 0, or use \"local\"");
    const bool hemisphere = occlusion && occlusion->directions == OcclusionDirections::hemisphere;
    if (hemisphere && occlusion->emission > 0)
        throw InputError("lighting.occlusion.directions: expected sphere with emission, which comes from all "
                         "sides, found hemisphere");
    if (occlusion && occlusion->method == OcclusionMethod::histogram && (hemisphere || occlusion->weights))
        throw InputError("lighting.occlusion.method: expected a method of rays with " +
                         std::string(hemisphere ? "directions hemisphere" : "weights") + ", found histogram");
}

void checkScene(const Scene& scene) {
    checkIntegrator(scene.quality);
    checkHulls(scene);
    checkLight(scene);
}

void checkShared(const Scene& scene) {
    const Lighting& lighting = scene.lighting;
    const SceneVolume& volume = scene.volumes.at(0);
    std::size_t slabs = 0;
    bool keepsInside = true;
    for (const Cuts* cuts : {&scene.cuts, &volume.cuts}) {
        slabs += 3 * cuts->boxes.size() + cuts->planes.size();
        keepsInside = keepsInside && cuts->scissors.empty() &&
                      std::all_of(cuts->boxes.begin(), cuts->boxes.end(),
                                  [](const CropBox& box) { return box.keep == Keep::inside; });
    }
    struct Rule {
        bool breaks;
        const char *expected, *found;
    };
    const Rule rules[] = {
        {scene.volumes.size() > 1, "one volume", "several, or labels with functions of their own"},
        {scene.mode != Mode::composite || !scene.surfaces.empty(),
         "mode composite without isosurfaces, whose rays are composited in parts", "another"},
        {drawsMeshes(scene), "no meshes, behind which rays go on in parts of their own", "some"},
        {lighting.transport.has_value(), "no paths of light, which cross all of the volume", "them"},
        {!volume.labels.path.empty(), "no labels", "some"},
        {scene.quality.sampling == Sampling::hulls, "rays with segments of one length", "sampling hulls"},
        {!keepsInside || slabs > static_cast<std::size_t>(kMostSlabs),
         "cuts that keep the inside of at most two boxes and two planes", "others"},
        {std::any_of(lighting.lights.begin(), lighting.lights.end(),
                     [](const Light& light) { return light.shadow || light.scatter > 0; }),
         "lights without shadows and scattering, which cross all of the volume", "one with"},
        {lighting.occlusion && lighting.occlusion->method == OcclusionMethod::histogram,
         "occlusion along rays", "method histogram"},
        {scene.quality.maxError.has_value(),
         "no error bound, whose rays wait for bricks of all of the volume", "one"},
    };
    for (const Rule& rule : rules)
        if (rule.breaks)
            throw badFile("--ranks", rule.expected, rule.found);
}

void checkPlan(const Scene& scene, const FramePlan& plan) {
    checkSurfaceOcclusion(plan);
    checkReflections(plan, scene);
    if (scene.lighting.transport || reflects(scene))
        checkEnvironment(scene);
    checkTransport(scene, plan);
}

} // namespace tessera
