// render/backends/splat/splat_renderer.cpp: see splat_renderer.h.
#include "render/backends/splat/splat_renderer.h"

#include "render/backends/splat/slice_walk.h"
#include "render/backends/splat/splat_pixels.h"
#include "render/backends/splat/splat_projection.h"
#include "render/geometry/point_shape.h"
#include "render/plan/fusion.h"

#include <algorithm>
#include <chrono>
#include <utility>

namespace tessera {

SplatRenderer::SplatRenderer(const EngineInput& input, const SplatSettings& settings)
    : threads_(input.threads), settings_(settings) {}

Engine::About SplatRenderer::about() const {
    Engine::About about;
    about.measures = true;
    return about;
}

bool SplatRenderer::draw(const FrameTask& task, RenderResult& result, Image&) {
    using Clock = std::chrono::steady_clock;
    endFrame();
    Planner& p = task.plan;
    p.chosen.chooser.reset(); // no rays tell how visible bricks are
    if (task.reuse.opened)
        task.reuse.opened();
    task.context.progress.stage("drawing");
    const auto start = Clock::now();
    if (task.options.verify != Verify::none)
        pictureCharge_ = task.context.gpu.charge(rayCount(p.view.imageSize) * sizeof(glm::vec4),
                                                 "the picture, whose error is measured");
    const SplatView view = splatView(p.view.camera, p.info(), p.view.imageSize);
    const auto orders = SliceOrder::of(view, p.info(), settings_.fade);
    Charge mixed;
    if (orders.size() > 1)
        mixed = task.context.gpu.charge(rayCount(p.view.imageSize) * sizeof(glm::vec4),
                                        "a picture by another order of slices");
    report_ = {};
    Image sum;
    for (const auto& [order, share] : orders) {
        SliceWalk walk(p, view, settings_, order, threads_, task.context.gpu);
        Image image = walk.draw(task.context.progress.shares(), result.work);
        for (glm::vec4& pixel : image.pixels)
            pixel *= static_cast<float>(share);
        if (sum.pixels.empty())
            std::swap(sum, image);
        for (std::size_t n = 0; n < image.pixels.size(); ++n)
            sum.pixels[n] += image.pixels[n];
        report_.counts += walk.counts();
        report_.secondsListing += walk.secondsListing();
    }
    result.image = std::move(sum);
    report_.secondsDrawing = secondsSince(start) - report_.secondsListing;
    result.secondsLoading = report_.secondsListing;
    result.secondsDrawing = report_.secondsDrawing;
    result.work.marchMs = 1e3 * report_.secondsDrawing;
    reportLevels(p, result);
    if (p.chosen.predicted)
        result.predictedError = predictedOf(p);
    result.unseenBricks = p.chosen.unseenBricks;
    result.emptyBricks -= result.unseenBricks;
    if (task.options.verify != Verify::none)
        picture_ = result.image;
    return false;
}

std::unique_ptr<PixelSource> SplatRenderer::pixels(const FrameTask& task) {
    return splatPixels(task, picture_, threads_);
}

void SplatRenderer::endFrame() {
    picture_ = {};
    pictureCharge_ = {};
}

namespace {

bool drawsTriangles(const Scene& scene) {
    const std::vector<SceneMesh> meshes = drawnMeshes(scene);
    return std::any_of(meshes.begin(), meshes.end(), [](const SceneMesh& mesh) {
        return !dynamic_cast<const PointShape*>(mesh.shape.get());
    });
}

} // namespace

std::string splatDeclines(const Scene& scene, const RenderOptions& options) {
    const SceneVolume& volume = scene.volumes.at(0);
    const Quality whole;
    struct Rule {
        bool breaks;
        const char* why;
    };
    const Rule rules[] = {
        {scene.volumes.size() > 1, "it draws one volume"},
        {scene.mode != Mode::composite, "it draws mode composite alone"},
        {!scene.surfaces.empty(), "it draws no isosurfaces, which lie between samples"},
        {drawsTriangles(scene), "it draws no meshes but points of files"},
        {!volume.labels.path.empty(), "it draws no labels"},
        {scene.lighting.transport.has_value(), "it follows no paths of light"},
        {lightChannels(scene.lighting) > 0, "it has no occlusion, shadows or scattered light"},
        {scene.lighting.surfaceOcclusion.has_value(), "it has no occlusion of isosurfaces"},
        {scene.shading.gradient != Gradient::central, "its gradients are of kind central"},
        {scene.quality.pixels.samples != 1, "its pixels have one sample, and a filter instead"},
        {scene.quality.sampling != whole.sampling, "it has no rays whose sampling could be chosen"},
        {scene.quality.integrator != whole.integrator, "it integrates along no ray"},
        {!scene.quality.automaticStep && scene.quality.stepVoxels != whole.stepVoxels,
         "it has no rays that take steps"},
        {scene.quality.edgeFunction != whole.edgeFunction || scene.quality.fetch != whole.fetch,
         "it fetches no values between samples"},
        {scene.quality.maxError.has_value(), "its error is measured and has no bound"},
        {options.layers.paths || options.layers.errors, "it has no layers besides the colour"},
        {options.tiles != nullptr, "its pictures are drawn as a whole"},
        {options.group != nullptr, "processes cannot share its volume"},
        {options.kept != nullptr, "it has no samples to keep"},
        {static_cast<bool>(options.onFirstPicture), "it draws no first pictures"},
    };
    for (const Rule& rule : rules)
        if (rule.breaks)
            return rule.why;
    return {};
}

EngineTraits splatTraits() {
    EngineTraits traits;
    traits.kind = EngineKind::splat;
    traits.name = "splat";
    traits.singleRays = true;
    traits.declines = splatDeclines;
    traits.renderer = [](const EngineInput& input) -> std::unique_ptr<Renderer> {
        return std::make_unique<SplatRenderer>(input);
    };
    return traits;
}

} // namespace tessera
