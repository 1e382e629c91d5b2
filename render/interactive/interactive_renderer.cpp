// render/interactive/interactive_renderer.cpp: see interactive_renderer.h: changes, and when to draw what.
// Levels and bricks are in interactive_volume.cpp.
#include "render/interactive/interactive_renderer.h"

#include "core/base/error.h"
#include "render/exposure/exposed_caster.h"
#include "render/geometry/mesh_caster.h"
#include "render/labels/slice_labels.h"
#include "render/picture/picture.h" // raysOf
#include "render/picture/several_volumes.h"
#include "render/plan/framing.h" // framingBytes
#include "render/plan/fusion.h"

#include <algorithm>
#include <array>
#include <glm/vector_relational.hpp>
#include <utility>

namespace tessera {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kPatience{50};       // for more bricks before a better picture
constexpr milliseconds kLightPatience{700}; // for finer light

/// As asDrawn() has it, without paths of light and a bound on the error; a slice of several volumes lies
/// where that of a still does.
Scene interactiveScene(const Scene& given, Stores stores, bool firstAlone) {
    Scene scene = withoutPaths(asDrawn(firstAlone ? sceneOfVolume(given, 0) : given));
    scene.quality.maxError.reset();
    if (stores.size() > 1 && scene.mode == Mode::slice)
        placeSlice(scene.slice, stores.front()->info());
    return scene;
}

/// The volumes to draw: those of labels with functions of their own and, where each volume has its rays,
/// those of opacities, last.
/// @param opacitiesOf  gets the latter's volumes
DrawnVolumes volumesOf(const Scene& scene, Stores stores, bool firstAlone,
                       std::vector<std::size_t>& opacitiesOf) {
    if (firstAlone)
        return {scene, {stores.front()}};
    DrawnVolumes all = withLabelOptics(scene, stores);
    opacitiesOf.clear();
    if (reductionOf(scene) == Reduction::composite)
        return all;
    for (std::size_t n = 1; n < scene.volumes.size(); ++n)
        if (takesOpacities(scene, n)) {
            SceneVolume volume = scene.volumes[n];
            volume.labels = {};
            all.scene.volumes.push_back(std::move(volume));
            all.stores.push_back(stores[n]);
            opacitiesOf.push_back(n);
        }
    return all;
}

} // namespace

Scene withoutPaths(Scene scene) {
    scene.lighting.transport.reset();
    scene.lighting.environment.reset(); // of stills alone, as are reflections
    return withoutReflections(std::move(scene));
}

InteractiveRenderer::InteractiveRenderer(const Scene& scene, Stores stores, Engine& engine, MemoryBudget& ram,
                                         MemoryBudget& gpu, const InteractiveOptions& options)
    : scene_(interactiveScene(scene, stores, options.firstAlone)),
      drawn_(volumesOf(scene_, stores, options.firstAlone, opacitiesOf_)), engine_(engine), ram_(ram),
      gpu_(gpu), options_(options) {
    try {
        openVolumes();
    } catch (...) {
        close();
        throw;
    }
}

InteractiveRenderer::InteractiveRenderer(const Scene& scene, const StoreReader& store, Engine& engine,
                                         MemoryBudget& ram, MemoryBudget& gpu,
                                         const InteractiveOptions& options)
    : InteractiveRenderer(scene, std::array{&store}, engine, ram, gpu, options) {}

InteractiveRenderer::~InteractiveRenderer() {
    close();
}

/// What the engine holds is charged to the budgets of the plans, which go first.
void InteractiveRenderer::close() {
    passes_.clear();
    volumes_.clear();
    engine_.close();
}

void InteractiveRenderer::openVolumes() {
    const FrameContext context(ram_, gpu_, options_.threads);
    const std::size_t several = drawn_.stores.size();
    p_ = planViews(drawn_.scene, drawn_.stores, context, kPictureBytesPerPixel + meshBytesPerPixel(scene_),
                   options_.coarse ? PlanDetail::coarse : PlanDetail::whole);
    if (several > 1 && !p_.fused)
        composing_ =
            ram_.charge((several + 1) * (sizeof(glm::vec4) + sizeof(float)) * rayCount(scene_.imageSize),
                        "the pictures of several volumes");
    const bool mapsAlways = engine_.about().compiles;
    const TextureLimits limits = engine_.limits();
    for (std::size_t n = 0; n < several; ++n) {
        FurtherVolume* const further = n == 0 ? nullptr : &p_.further[n - 1];
        volumes_.push_back(std::make_unique<InteractiveVolume>(
            several == 1 ? scene_ : sceneInFusion(drawn_.scene, n), further ? further->plan : p_,
            further ? further->ram : ram_, further ? further->gpu : gpu_, limits, options_,
            n + opacitiesOf_.size() >= several, mapsAlways));
    }
    for (std::size_t n = 0; n < several; ++n)
        volumes_[n]->open(n == 0 ? engine_ : *engine_.further(n - 1), several == 1);
    const CasterOptions options{options_.counting, false, false};
    for (std::size_t n = 0; n < (p_.fused ? 1 : several); ++n)
        passes_.push_back({casterOf(volumes_[n]->engine(), volumes_[n]->plan(), options,
                                    n == 0 ? gpu_ : p_.further[n - 1].gpu, options_.threads, false),
                           volumes_[n].get(),
                           {}});
}

template <typename Predicate> bool InteractiveRenderer::anyVolume(const Predicate& predicate) const {
    return std::any_of(volumes_.begin(), volumes_.end(),
                       [&](const auto& volume) { return predicate(*volume); });
}

void InteractiveRenderer::setCamera(const Camera& camera) {
    for (const auto& volume : volumes_)
        volume->setCamera(camera);
    forPicture_.add(kCameraChanged);
}

Stores InteractiveRenderer::storesOfScene() const {
    return Stores(drawn_.stores).first(scene_.volumes.size());
}

ValueSummary InteractiveRenderer::valuesOf(std::size_t number) const {
    return summarise(volume(number).statistics, volume(number).info(), scene_.volumes.at(number).unit);
}

TransferFunction InteractiveRenderer::functionOf(const TransferChoice& choice, std::size_t number) const {
    const auto* const name = std::get_if<std::string>(&choice);
    return name ? presetFunction(*name, valuesOf(number)) : std::get<TransferFunction>(choice);
}

void InteractiveRenderer::setFunction(const TransferFunction& function, std::size_t volume) {
    if (volume >= scene_.volumes.size())
        return;
    scene_.volumes.at(volume).transferFunction = function;
    const DrawnVolumes before =
        std::exchange(drawn_, volumesOf(scene_, storesOfScene(), options_.firstAlone, opacitiesOf_));
    for (std::size_t n = 0; n < volumes_.size(); ++n) {
        const TransferChoice& choice = drawn_.scene.volumes[n].transferFunction;
        if (n == volume || choice != before.scene.volumes[n].transferFunction)
            volumes_[n]->setFunction(std::get<TransferFunction>(choice));
    }
}

void InteractiveRenderer::setOpacity(double opacity, std::size_t volume) {
    if (volume >= scene_.volumes.size())
        return;
    scene_.volumes.at(volume).opacity = opacity;
    const DrawnVolumes before =
        std::exchange(drawn_, volumesOf(scene_, storesOfScene(), options_.firstAlone, opacitiesOf_));
    const bool ofColours = reductionOf(scene_) != Reduction::composite;
    for (std::size_t n = 0; n < volumes_.size() && !ofColours; ++n)
        if (drawn_.scene.volumes[n].opacity != before.scene.volumes[n].opacity)
            volumes_[n]->setOpacity(drawn_.scene.volumes[n].opacity);
    if (ofColours) // what rays read stays
        forPicture_.add(kFunctionChanged);
}

std::optional<Camera> InteractiveRenderer::fitted(const FittedView& view) {
    if (anyVolume([](const InteractiveVolume& v) { return v.waitsForFunction(); })) {
        cancel();
        for (const auto& volume : volumes_)
            volume->applyFunction();
    }
    if (anyVolume([&](const InteractiveVolume& v) {
            return v.plan().ram->freeBytes() < framingBytes(v.plan().info(), options_.threads);
        }))
        return std::nullopt;
    Scene scene = drawn_.scene;
    scene.camera = view;
    return plannedCamera(scene, p_);
}

std::vector<InteractiveRenderer::MeshSurface>
InteractiveRenderer::meshesAlong(const glm::ivec2& imageSize, const glm::dvec2& place) const {
    std::vector<MeshSurface> found;
    if (p_.view.meshes.empty())
        return found;
    const RayFrame<double> frame = p_.frameOf(imageSize);
    const glm::dmat4 toFirst = p_.fused ? p_.fused->fromLattice : glm::dmat4(1);
    const MeshRays meshes(p_, frame);
    const RayLine<double> line = pixelLine(frame, place);
    MeshRays::Order after;
    while (const auto surface = meshes.next(line, after)) {
        after = surface->at;
        found.push_back({glm::dvec3(toFirst * glm::dvec4(line.base + after.t * line.direction, 1)),
                         &p_.view.meshes[static_cast<std::size_t>(after.mesh)]});
        if (!(found.back().mesh->opacity < 1))
            break;
    }
    return found;
}

void InteractiveRenderer::setWindow(const WindowChoice& window) {
    scene_.window = drawn_.scene.window = window;
    for (std::size_t n = 0; n < volumes_.size(); ++n)
        if (!drawn_.scene.volumes[n].window || volumes_.size() == 1)
            volumes_[n]->setWindow(window);
}

void InteractiveRenderer::setCuts(const Cuts& cuts) {
    TESSERA_CHECK(!engine_.about().compiles);
    // What throws does before anything changes.
    Scene wished = scene_;
    wished.cuts = cuts;
    DrawnVolumes cut = volumesOf(wished, storesOfScene(), options_.firstAlone, opacitiesOf_);
    std::vector<DrawnPart> parts;
    for (std::size_t n = 0; n < volumes_.size(); ++n)
        parts.push_back(drawnPart(volumes_.size() > 1 ? sceneInFusion(cut.scene, n) : cut.scene,
                                  volumes_[n]->plan().info()));
    if (p_.fused)
        p_.fused->part = drawnPart(cut.scene, p_.fused->voxels);
    for (std::size_t n = 0; n < volumes_.size(); ++n)
        volumes_[n]->plan().setPart(std::move(parts[n]));
    scene_ = std::move(wished);
    drawn_ = std::move(cut);
    cancel();
    forPicture_.add(kCameraChanged);
}

bool InteractiveRenderer::setLight(const Lighting& lighting, const Shading& shading) {
    Scene lit = scene_;
    lit.lighting = lighting;
    lit.shading = shading;
    lit = withoutPaths(std::move(lit));
    if ((p_.fused && lighting.surfaceOcclusion) ||
        anyVolume([&](const InteractiveVolume& v) { return !v.plan().takesLight(lit); }))
        return false;
    for (const auto& volume : volumes_)
        volume->setLight(lit);
    cancel();
    scene_ = lit;
    drawn_.scene.lighting = scene_.lighting;
    drawn_.scene.shading = shading;
    forPicture_.add(kLightChanged);
    return true;
}

void InteractiveRenderer::cancel() {
    if (drawing_)
        forPicture_.add(kCameraChanged); // begins anew
    drawing_ = false;
}

void InteractiveRenderer::setHaste(const std::optional<Haste>& haste) {
    if (haste == haste_)
        return;
    if (haste) {
        TESSERA_CHECK(glm::all(glm::greaterThan(haste->imageSize, glm::ivec2(0))) &&
                      glm::all(glm::lessThanEqual(haste->imageSize, scene_.imageSize)));
    }
    haste_ = haste;
    forPicture_.add(kCameraChanged);
}

void InteractiveRenderer::setPath(std::vector<Camera> next) {
    path_ = std::move(next);
    for (const auto& volume : volumes_)
        volume->forgetPath();
}

Slicing InteractiveRenderer::slicing() const {
    Slicing s;
    s.targetMs = options_.dispatchMs;
    return s;
}

void InteractiveRenderer::beginPicture() {
    const double step = haste_ ? haste_->stepVoxels : scene_.quality.stepVoxels;
    for (const auto& volume : volumes_) {
        if (step != volume->plan().view.quality.stepVoxels)
            volume->plan().setStep(step);
        if (volume->beginPicture())
            refined_ = false;
        if (LightPlane* const light = volume->light())
            light->setHaste(haste_.has_value());
    }
    for (const Pass& pass : passes_) {
        const Planner& plan = pass.volume->plan();
        Rays rays = raysOf(plan);
        if (haste_)
            rays.frame = plan.frameOf(haste_->imageSize);
        pass.caster->begin(rays);
    }
    pass_ = 0;
    pictureCamera_ = p_.view.camera;
    forPicture_ = Changes();
    drawing_ = true;
    pictureBegan_ = Clock::now();
}

/// Returns whether the picture is finished.
bool InteractiveRenderer::drawPasses(Clock::time_point deadline) {
    for (; pass_ < passes_.size(); ++pass_) {
        Pass& pass = passes_[pass_];
        if (!pass.caster->draw(slicing(), deadline, work_))
            return false;
        (passes_.size() == 1 ? picture_ : pass.image) = pass.caster->image();
    }
    return true;
}

/// Lays the pictures of volumes over one another, with the labels of each, as those of a still.
void InteractiveRenderer::composePicture() {
    if (passes_.size() == 1) {
        layLabelsOver(*volumes_.front(), picture_, nullptr);
        return;
    }
    for (std::size_t n = 0; n < scene_.volumes.size(); ++n) {
        std::vector<float> opacities;
        const auto of = std::find(opacitiesOf_.begin(), opacitiesOf_.end(), n);
        if (of != opacitiesOf_.end())
            opacities = tessera::opacitiesOf(
                passes_[scene_.volumes.size() + static_cast<std::size_t>(of - opacitiesOf_.begin())].image);
        Image& picture = passes_[n].image;
        if (volumes_[n]->plan().layer().sliceLabels) {
            layLabelsOver(*volumes_[n], picture, opacities.empty() ? nullptr : &opacities);
            opacities.clear();
        }
        weigh(picture, scene_.volumes[n].opacity, opacities);
        if (n == 0)
            picture_ = std::move(picture);
        else
            layOver(picture_, picture, scene_.fusion);
    }
}

/// Of a slice. What cannot be read is told by the next call; the values are shown.
void InteractiveRenderer::layLabelsOver(const InteractiveVolume& volume, Image& picture,
                                        const std::vector<float>* shares) {
    SliceLabels* const labels = volume.plan().layer().sliceLabels.get();
    if (!labels)
        return;
    try {
        labels->layOver(picture.pixels,
                        planePlaces(pictureCamera_, scene_.slice, volume.plan().info(), picture.size),
                        static_cast<double>(picture.size.x) / scene_.imageSize.x, shares);
    } catch (const Error&) {
        labelFault_ = std::current_exception();
    }
}

bool InteractiveRenderer::meansArePending() const {
    return anyVolume([](const InteractiveVolume& v) { return v.meansArePending(); });
}

bool InteractiveRenderer::hasChanged(std::uint32_t changes) const {
    return forPicture_.any(changes) ||
           anyVolume([&](const InteractiveVolume& v) { return v.changed(changes); });
}

bool InteractiveRenderer::pictureIsDue() const {
    const auto waited = Clock::now() - lastPicture_;
    const bool first = picture_.pixels.empty();
    if (first && waited < options_.firstPatience) {
        return !meansArePending();
    }
    // A picture of few pixels exists: the next should show more than bricks' means, which are also slow to
    // draw.
    if (!haste_ && picture_.size != scene_.imageSize && waited < options_.firstPatience && meansArePending())
        return false;
    if (first || hasChanged(kCameraChanged | kFunctionChanged | kLightChanged))
        return true;
    if (!anyVolume([](const InteractiveVolume& v) { return v.levelsAreNew(); }))
        return false;
    // If bricks are still loading, the time of another picture.
    return !anyVolume([](const InteractiveVolume& v) { return !v.moves().empty(); }) ||
           waited > std::max<Clock::duration>(kPatience, pictureTook_);
}

bool InteractiveRenderer::settled() const {
    return !drawing_ && !forPicture_.any() &&
           !anyVolume([&](const InteractiveVolume& v) { return !v.settled(path_); });
}

bool InteractiveRenderer::lightIsWhole() const {
    return haste_ || !anyVolume([](const InteractiveVolume& v) { return !v.lightIsWhole(); });
}

/// Pictures are drawn when light is complete and, before, after the time of two pictures.
void InteractiveRenderer::refineLight(Clock::time_point deadline) {
    bool whole = true;
    for (const auto& volume : volumes_) {
        LightPlane* const light = volume->light();
        if (!light)
            continue;
        light->refine(volume->likely(), deadline, work_);
        whole = whole && light->isWhole();
    }
    if (whole || Clock::now() - lastPicture_ > std::max<Clock::duration>(kLightPatience, 2 * pictureTook_))
        forPicture_.add(kLightChanged);
}

/// All that bricks need before a picture.
void InteractiveRenderer::bringBricks(Clock::time_point deadline) {
    const bool hasty = haste_.has_value();
    for (const auto& volume : volumes_) {
        volume->applyFunction();
        volume->choose(path_, hasty);
        if (!volume->isCounting())
            volume->moveBricks(work_);
        volume->countVisibility(slicing(), deadline, hasty);
    }
}

InteractiveRenderer::Progress InteractiveRenderer::advance(Clock::time_point deadline) {
    if (labelFault_)
        std::rethrow_exception(std::exchange(labelFault_, nullptr));
    const auto counts = [](const InteractiveVolume& v) { return v.isCounting(); };
    Progress progress;
    do {
        if (!drawing_) {
            bringBricks(deadline);
            if (anyVolume(counts))
                break;
            if (pictureIsDue())
                beginPicture();
        }
        if (drawing_) {
            if (!drawPasses(deadline))
                break;
            drawing_ = false;
            composePicture();
            progress.newPicture = true;
            lastPicture_ = Clock::now();
            pictureTook_ = lastPicture_ - pictureBegan_;
            break; // to be shown
        }
        if (settled() && !lightIsWhole()) {
            refineLight(deadline);
            continue;
        }
        if (settled()) {
            if (!std::exchange(refined_, true))
                for (const Pass& pass : passes_)
                    pass.caster->refine(); // the next pictures of these bricks are drawn sooner
            break;
        }
        const auto busy = std::find_if(volumes_.begin(), volumes_.end(),
                                       [&](const auto& volume) { return !volume->settled(path_); });
        if (busy != volumes_.end())
            (*busy)->waitUntil(std::min(deadline, Clock::now() + milliseconds(10)));
    } while (Clock::now() < deadline);
    progress.lightIsCoarse = anyVolume([](const InteractiveVolume& v) { return !v.lightIsWhole(); });
    progress.converged = settled() && lightIsWhole() && refined_;
    for (const auto& volume : volumes_)
        progress.movesLeft += volume->moves().size();
    progress.choosing = anyVolume([](const InteractiveVolume& v) { return v.isChoosing(); });
    return progress;
}

} // namespace tessera
