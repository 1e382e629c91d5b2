// render/interactive/interactive_renderer.cpp: see interactive_renderer.h: what to choose, and when to draw.
// Moves of bricks are in interactive_bricks.cpp.
#include "render/interactive/interactive_renderer.h"

#include "core/base/error.h"
#include "render/geometry/mesh_caster.h"
#include "render/labels/slice_labels.h"
#include "render/picture/picture.h" // raysOf
#include "render/plan/framing.h"    // framingBytes
#include "render/plan/visibility_rays.h"

#include <algorithm>
#include <utility>

namespace tessera {
namespace {

using std::chrono::milliseconds;

/// Levels: resident, wanted, being chosen and chosen from; gains, visibility, counts; ranked moves.
constexpr std::size_t kBytesPerBrick = 96;
constexpr milliseconds kPatience{50};       // for more bricks before a better picture
constexpr milliseconds kLightPatience{700}; // for finer light

} // namespace

/// The inputs of a choice, which is made on another thread.
struct InteractiveRenderer::Request {
    const FramePlan* scene = nullptr;              // only its statistics and info
    std::shared_ptr<const TransferTable> function; // if it is a new one
    Culling culling = Culling::lit;
    Camera camera;
    std::size_t pages = 0;
    std::vector<float> visible; // empty: predicted
    std::vector<std::uint8_t> resident;
};

InteractiveRenderer::InteractiveRenderer(const Scene& scene, const StoreReader& store, Engine& engine,
                                         MemoryBudget& ram, MemoryBudget& gpu,
                                         const InteractiveOptions& options)
    : scene_(asDrawn(scene)), engine_(engine), ram_(ram), gpu_(gpu), options_(options),
      mapsAlways_(engine.about().compiles) {
    scene_.quality.maxError.reset();
    const FrameContext context(ram, gpu, options.threads);
    p_ = planView(scene_, store, ram, options.threads, kPictureBytesPerPixel + meshBytesPerPixel(scene_));
    Layer& volume = p_.layer();
    const std::size_t bricks = cellCount(brickGrid(p_.info().extentVoxels));
    charge_ = ram.charge(kBytesPerBrick * bricks, "levels that change");
    TextureLimits limits = engine.limits();
    limits.channelsBeside = p_.channelsBeside();
    p_.settleIntegrator(context, TransferTable::kMaxEntries);
    p_.planMemory(limits, context, true);
    // For any function: the tables of the ray caster and of visibility.
    const std::size_t tables =
        p_.gpuTableBytes(TransferTable::kMaxEntries) + TransferTable::kMaxEntries * sizeof(glm::vec4);
    // Nothing is resident: every visible brick is drawn as its mean.
    volume.selection =
        cullBricks(volume.statistics, volume.table, p_.info(), kMean, cullingFor(scene_.shading));
    const std::size_t shown = volume.selection.shownBricks();
    // Memory for as many bricks again, which another function may show.
    if (limits.pageEdge > kBrickExtent)
        p_.chooseGhostLayers(limits, std::min(bricks, 2 * shown), context);
    const std::size_t fixed =
        p_.memory.gpuBytes() + tables + visibilityBytes(scene.imageSize, brickGrid(p_.info().extentVoxels));
    pages_ = pagesThatFit(gpu.freeBytes() - std::min(gpu.freeBytes(), fixed), p_.info().type, limits);
    if (pages_ == 0)
        throw InputError(gpu.option() + ": this scene needs at least " +
                         formatBytes(fixed + atlasBytes(1, p_.info().type, limits)) +
                         " (picture, tables and a page of bricks), but " + formatBytes(gpu.freeBytes()) +
                         " are free");
    chosenPages_ = pages_ - static_cast<std::size_t>(static_cast<double>(pages_) *
                                                     std::clamp(options.spareShare, 0.0, 0.5));
    if (!volume.reduces() && ram.freeBytes() >= p_.memory.ramBytes() + LevelChooser::bytes(shown, bricks)) {
        chooser_ = std::make_unique<LevelChooser>(store, ram, options.threads, p_.layer().masked.get());
        chooser_->setFunction(volume.statistics, volume.table,
                              cullingFor(scene_.shading)); // before the cache takes the remaining memory
        predicts_ = true;
        mostRays_ = (bricks - shown) * kBrickRayParts * kBrickRayBytes;
        raysReserve_ = ram.charge(std::min(mostRays_, (ram.freeBytes() - p_.memory.ramBytes()) / 4),
                                  "statistics of more bricks");
    }
    p_.mapLevels(mapsAlways_);
    p_.openCache();
    engine_.open(p_, pages_);
    TESSERA_CHECK(engine_.bricks());
    if (engine_.light() && options.coarseLightFirst)
        engine_.light()->lightCoarselyFirst();
    p_.aim();
    caster_ = casterWithMeshes(engine_, p_, {options.counting, false, false}, gpu, options.threads, false);
    counter_ = engine_.counter(gpu);
    gain_.assign(bricks, 0);
}

InteractiveRenderer::~InteractiveRenderer() {
    if (choosing_.valid())
        choosing_.wait();
}

void InteractiveRenderer::reserveForRays() {
    if (chooser_)
        if (auto charge = ram_.tryCharge(std::min(mostRays_, ram_.freeBytes() / 2)))
            raysReserve_ = std::move(*charge);
}

void InteractiveRenderer::setCamera(const Camera& camera) {
    p_.setCamera(camera);
    forChoice_.add(kCameraChanged);
    forPicture_.add(kCameraChanged);
    counting_ = false;
    countsLeft_ = 1;
}

void InteractiveRenderer::setFunction(const TransferFunction& function) {
    nextFunction_ = function;
}

std::optional<Camera> InteractiveRenderer::fitted(const FittedView& view) {
    if (nextFunction_) {
        cancel();
        applyFunction();
    }
    if (ram_.freeBytes() < framingBytes(p_.info(), options_.threads))
        return std::nullopt;
    Scene scene = scene_;
    scene.camera = view;
    return plannedCamera(scene, p_.layer().voxels(), p_.layer().statistics, p_.layer().table, p_.view.part,
                         ram_, options_.threads, p_.layer().labelBricks.get());
}

std::vector<InteractiveRenderer::MeshSurface>
InteractiveRenderer::meshesAlong(const glm::ivec2& imageSize, const glm::dvec2& place) const {
    std::vector<MeshSurface> found;
    if (p_.view.meshes.empty())
        return found;
    RayFrame<double> frame = rayFrame(p_.view.camera, p_.info(), imageSize, p_.view.quality.stepVoxels);
    p_.view.part.clip(frame);
    const MeshRays meshes(p_, frame);
    const RayLine<double> line = pixelLine(frame, place);
    MeshRays::Order after;
    while (const auto surface = meshes.next(line, after)) {
        after = surface->at;
        found.push_back(
            {line.base + after.t * line.direction, &p_.view.meshes[static_cast<std::size_t>(after.mesh)]});
        if (!(found.back().mesh->opacity < 1))
            break;
    }
    return found;
}

void InteractiveRenderer::setWindow(const WindowChoice& window) {
    scene_.window = window;
    if (p_.layer().reduces() && !nextFunction_)
        nextFunction_ = p_.layer().function;
}

void InteractiveRenderer::setCuts(const Cuts& cuts) {
    TESSERA_CHECK(!engine_.about().compiles);
    Scene cut = scene_;
    cut.cuts = cuts;
    p_.setPart(drawnPart(cut, p_.info())); // throws before anything changes
    scene_.cuts = cuts;
    cancel();
    forPicture_.add(kCameraChanged);
}

bool InteractiveRenderer::setLight(const Lighting& lighting, const Shading& shading) {
    Scene lit = scene_;
    lit.lighting = lighting;
    lit.shading = shading;
    if (!p_.setLight(lit))
        return false;
    cancel();
    scene_ = lit;
    if (engine_.light())
        engine_.light()->lightingChanged();
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
    lookedAhead_ = 0;
    ahead_.clear();
}

InteractiveRenderer::Choice InteractiveRenderer::choose(LevelChooser* chooser, const Request& r) {
    Choice c;
    const Statistics& statistics = r.scene->layer().statistics;
    const auto oneForAll = [&] { // in pages, not bytes
        const auto pages = [](const auto& counts) { return pagesFor(counts); };
        c.selection = selectOneLevel(statistics, *r.function, r.scene->info(), r.pages, pages, r.culling,
                                     "--gpu-memory", 0);
        c.gain.assign(c.selection.levels.size(), 0);
        return c;
    };
    if (!chooser)
        return oneForAll();
    try {
        if (r.function)
            chooser->setFunction(statistics, *r.function, r.culling);
    } catch (const InputError&) { // the budget has no room for statistics of so many bricks
        return oneForAll();
    }
    c.predicted = true;
    chooser->setCamera(r.camera, r.scene->view.imageSize);
    const std::vector<float> visible = r.visible.empty() ? chooser->predictedVisibility() : r.visible;
    BestLevels best = bestLevels(*chooser, statistics.brickMean, r.pages, visible);
    c.selection = std::move(best.selection);
    c.error = best.error;
    c.visible = visible;
    c.gain.resize(visible.size());
    for (std::size_t b = 0; b < visible.size(); ++b)
        if (const int to = c.selection.levels[b]; to < kLevelCount) {
            const auto& errors = chooser->errors().errors[b];
            const int from = std::min<int>(r.resident[b], kMean);
            c.gain[b] = chooser->weights().area[b] * visible[b] *
                        (errors[static_cast<std::size_t>(from)] - errors[static_cast<std::size_t>(to)]);
        }
    return c;
}

void InteractiveRenderer::startChoosing(const Camera& camera, std::vector<float> visible) {
    Request request{&p_,
                    nullptr,
                    cullingFor(scene_.shading),
                    camera,
                    chosenPages_,
                    std::move(visible),
                    p_.layer().selection.levels};
    if (forChoice_.any(kFunctionChanged) || !predicts_)
        request.function = std::make_shared<const TransferTable>(p_.layer().table);
    raysReserve_ = {};
    choosing_ = std::async(std::launch::async,
                           [chooser = chooser_.get(), r = std::move(request)] { return choose(chooser, r); });
    choosingBegan_ = Clock::now();
}

void InteractiveRenderer::finishChoosing() {
    if (!choosing_.valid() || choosing_.wait_for(milliseconds(0)) != std::future_status::ready)
        return;
    chosenAt_ = Clock::now();
    const bool forPath = std::exchange(forPath_, false);
    Choice choice = choosing_.get();
    predicts_ = choice.predicted;
    reserveForRays();
    // During motion the last view's levels are better than those of the one before it.
    if (forChoice_.any(haste_ ? kFunctionChanged : ~0u))
        return; // its request is obsolete
    if (forPath) {
        lookAhead(choice);
        return;
    }
    wanted_ = std::move(choice.selection);
    gain_ = std::move(choice.gain);
    likely_ = std::move(choice.visible);
    predicted_ = choice.error;
    direct_ = false;
    plan();
}

bool InteractiveRenderer::mayChoose() const {
    constexpr int kOtherShares = 4;
    return !haste_ || !wanted_ || Clock::now() > chosenAt_ + kOtherShares * (chosenAt_ - choosingBegan_);
}

void InteractiveRenderer::chooseWhatIsNew() {
    if (choosing_.valid() || !mayChoose())
        return;
    if (forChoice_.any()) {
        // Visibility in the last view is the best estimate for this one, unless the function has changed.
        startChoosing(p_.view.camera, visible_);
        forChoice_ = Changes();
    } else if (wanted_ && moves_.empty() && countsLeft_ == 0 && lookedAhead_ < path_.size()) {
        forPath_ = true;
        startChoosing(path_[lookedAhead_++], visible_); // as it will be then
    }
}

void InteractiveRenderer::applyFunction() {
    if (!nextFunction_)
        return;
    p_.setFunction(*nextFunction_, scene_);
    nextFunction_.reset();
    const Selection culled =
        cullBricks(p_.layer().statistics, p_.layer().table, p_.info(), kMean, cullingFor(scene_.shading));
    for (std::size_t b = 0; b < culled.levels.size(); ++b) {
        const bool shows = culled.levels[b] != Selection::kEmpty;
        if (shows == (p_.layer().selection.levels[b] != Selection::kEmpty))
            continue;
        drop(b);
        setLevel(b, culled.levels[b]);
    }
    p_.mapFunction();
    forDevice_.add(kEmptySpaceChanged);
    wanted_.reset();
    counting_ = false;
    moves_.clear();
    visible_.clear();
    ahead_.clear();
    lookedAhead_ = 0;
    countsLeft_ = 1;
    forChoice_.add(kFunctionChanged);
    forPicture_.add(kFunctionChanged);
    forDevice_.add(kLevelsChanged);
}

void InteractiveRenderer::countVisibility(Clock::time_point deadline) {
    if (!counting_) {
        if (haste_ || !wanted_ || !moves_.empty() || choosing_.valid() || forChoice_.any() ||
            countsLeft_ == 0)
            return;
        --countsLeft_;
        if (!predicts_ || predicted_.mean == 0)
            return; // every brick is as fine as a pixel shows
        mapResident();
        counter_->begin();
        counting_ = true;
    }
    if (!counter_->count(slicing(), deadline))
        return;
    counting_ = false;
    visible_ = visibilityFactors(counter_->seen(), p_.layer().selection, visible_);
    startChoosing(p_.view.camera, visible_);
}

Slicing InteractiveRenderer::slicing() const {
    Slicing s;
    s.targetMs = options_.dispatchMs;
    return s;
}

void InteractiveRenderer::mapResident() {
    if (!forDevice_.take(kLevelsChanged))
        return;
    p_.mapLevels(mapsAlways_);
    engine_.bricks()->publish();
    forDevice_.add(kEmptySpaceChanged);
    forPicture_.add(kLevelsChanged);
}

void InteractiveRenderer::beginPicture() {
    const double step = haste_ ? haste_->stepVoxels : scene_.quality.stepVoxels;
    if (step != p_.view.quality.stepVoxels)
        p_.setStep(step);
    mapResident();
    p_.aim();
    if (forDevice_.take(kEmptySpaceChanged)) {
        refined_ = false;
    }
    if (engine_.light())
        engine_.light()->setHaste(haste_.has_value());
    Rays rays = raysOf(p_);
    if (haste_) {
        rays.frame = rayFrame(p_.view.camera, p_.info(), haste_->imageSize, step);
        p_.view.part.clip(rays.frame);
    }
    caster_->begin(rays);
    pictureCamera_ = p_.view.camera;
    forPicture_ = Changes();
    drawing_ = true;
    pictureBegan_ = Clock::now();
}

/// Some bricks drawn as means are still loading.
bool InteractiveRenderer::meansArePending() const {
    return !wanted_ || std::any_of(moves_.begin(), moves_.end(), [&](const Move& m) {
        return p_.layer().selection.levels[m.brick] == kMean;
    });
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
    if (first || forPicture_.any(kCameraChanged | kFunctionChanged | kLightChanged))
        return true;
    if (!forDevice_.any(kLevelsChanged) && !forPicture_.any(kLevelsChanged))
        return false;
    // If bricks are still loading, the time of another picture.
    return moves_.empty() || waited > std::max<Clock::duration>(kPatience, pictureTook_);
}

bool InteractiveRenderer::settled() const {
    return wanted_ && moves_.empty() && !counting_ && !choosing_.valid() && !forChoice_.any() &&
           !nextFunction_ && countsLeft_ == 0 && !drawing_ && !forPicture_.any() &&
           !forDevice_.any(kLevelsChanged) && lookedAhead_ == path_.size();
}

bool InteractiveRenderer::lightIsWhole() const {
    return haste_ || !engine_.light() || engine_.light()->isWhole();
}

/// Pictures are drawn when light is complete and, before, after the time of two pictures.
void InteractiveRenderer::refineLight(Clock::time_point deadline) {
    LightPlane& light = *engine_.light();
    light.refine(likely_, deadline, work_);
    if (light.isWhole() ||
        Clock::now() - lastPicture_ > std::max<Clock::duration>(kLightPatience, 2 * pictureTook_))
        forPicture_.add(kLightChanged);
}

/// Of a slice. What cannot be read is told by the next call; the values are shown.
void InteractiveRenderer::layLabelsOver() {
    SliceLabels* const labels = p_.layer().sliceLabels.get();
    if (!labels)
        return;
    try {
        labels->layOver(picture_.pixels, planePlaces(pictureCamera_, scene_.slice, p_.info(), picture_.size),
                        static_cast<double>(picture_.size.x) / scene_.imageSize.x);
    } catch (const Error&) {
        labelFault_ = std::current_exception();
    }
}

InteractiveRenderer::Progress InteractiveRenderer::advance(Clock::time_point deadline) {
    if (labelFault_)
        std::rethrow_exception(std::exchange(labelFault_, nullptr));
    Progress progress;
    do {
        if (!drawing_) {
            applyFunction();
            finishChoosing();
            chooseWhatIsNew();
            if (!counting_)
                moveBricks();
            countVisibility(deadline);
            if (counting_)
                break;
            if (pictureIsDue())
                beginPicture();
        }
        if (drawing_) {
            if (!caster_->draw(slicing(), deadline, work_))
                break;
            picture_ = caster_->image();
            drawing_ = false;
            layLabelsOver();
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
                caster_->refine(); // the next pictures of these bricks are drawn sooner
            break;
        }
        const auto soon = std::min(deadline, Clock::now() + milliseconds(10));
        if (choosing_.valid())
            choosing_.wait_until(soon);
        else
            p_.layer().cache->waitForWanted(soon);
    } while (Clock::now() < deadline);
    progress.lightIsCoarse = engine_.light() && !engine_.light()->isWhole();
    progress.converged = settled() && lightIsWhole() && refined_;
    progress.movesLeft = moves_.size();
    progress.choosing = choosing_.valid();
    return progress;
}

} // namespace tessera
