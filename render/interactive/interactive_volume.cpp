// render/interactive/interactive_volume.cpp: see interactive_volume.h: memory, changes, and the choice of
// levels. Moves of bricks are in interactive_bricks.cpp.
#include "render/interactive/interactive_volume.h"

#include "core/base/budget_error.h"
#include "core/base/error.h"
#include "render/picture/several_volumes.h"
#include "render/plan/label_optics.h"
#include "render/plan/quick_level.h"
#include "render/plan/visibility_rays.h"

#include <algorithm>
#include <utility>

namespace tessera {
namespace {

using std::chrono::milliseconds;

/// Levels: resident, wanted, being chosen and chosen from; gains, visibility, counts; ranked moves.
constexpr std::size_t kBytesPerBrick = 96;

} // namespace

/// The inputs of a choice, which is made on another thread.
struct InteractiveVolume::Request {
    const FramePlan* scene = nullptr;              // only its statistics and info
    std::shared_ptr<const TransferTable> function; // if it is a new one
    Culling culling = Culling::lit;
    Camera camera;
    std::size_t pages = 0;
    std::vector<float> visible; // empty: predicted
    std::vector<std::uint8_t> resident;
    int finest = 0; // level
};

InteractiveVolume::InteractiveVolume(const Scene& scene, Planner& plan, MemoryBudget& ram, MemoryBudget& gpu,
                                     const TextureLimits& engineLimits, const InteractiveOptions& options,
                                     bool opacities, bool mapsAlways)
    : scene_(scene), ram_(ram), gpu_(gpu), options_(options), opacities_(opacities), mapsAlways_(mapsAlways),
      p_(plan) {
    const FrameContext context(ram, gpu, options.threads);
    Layer& volume = p_.layer();
    if (opacities_)
        p_.setFunction(opacitiesAsGreys(volume.function), scene_);
    const std::size_t bricks = cellCount(brickGrid(p_.info().extentVoxels));
    charge_ = ram.charge(kBytesPerBrick * bricks, "levels that change");
    TextureLimits limits = engineLimits;
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
        throw OverBudget(gpu.option() + ": this scene needs at least " +
                         formatBytes(fixed + atlasBytes(1, p_.info().type, limits)) +
                         " (picture, tables and a page of bricks), but " + formatBytes(gpu.freeBytes()) +
                         " are free");
    chosenPages_ = pages_ - static_cast<std::size_t>(static_cast<double>(pages_) *
                                                     std::clamp(options.spareShare, 0.0, 0.5));
    if (!p_.isCoarse && !volume.reduces() && !p_.view.exposure &&
        ram.freeBytes() >= p_.memory.ramBytes() + LevelChooser::bytes(shown, bricks)) {
        chooser_ = std::make_unique<LevelChooser>(*volume.store, ram, options.threads, volume.masked.get());
        chooser_->setFunction(volume.statistics, volume.table,
                              cullingFor(scene_.shading)); // before the cache takes the remaining memory
        predicts_ = true;
        mostRays_ = (bricks - shown) * kBrickRayParts * kBrickRayBytes;
        raysReserve_ = ram.charge(std::min(mostRays_, (ram.freeBytes() - p_.memory.ramBytes()) / 4),
                                  "statistics of more bricks");
    }
    p_.mapLevels(mapsAlways_);
    p_.openCache();
    gain_.assign(bricks, 0);
}

InteractiveVolume::~InteractiveVolume() {
    if (choosing_.valid())
        choosing_.wait();
}

void InteractiveVolume::open(Engine& engine, bool alone) {
    engine_ = &engine;
    engine.open(p_, pages_);
    TESSERA_CHECK(engine.bricks());
    if (light() && alone && options_.coarseLightFirst)
        light()->lightCoarselyFirst();
    p_.aim();
    counter_ = engine.counter(gpu_);
}

void InteractiveVolume::reserveForRays() {
    if (chooser_)
        if (auto charge = ram_.tryCharge(std::min(mostRays_, ram_.freeBytes() / 2)))
            raysReserve_ = std::move(*charge);
}

void InteractiveVolume::setCamera(const Camera& camera) {
    p_.setCamera(camera);
    forChoice_.add(kCameraChanged);
    counting_ = false;
    countsLeft_ = 1;
}

void InteractiveVolume::setFunction(const TransferFunction& function) {
    nextFunction_ = ofLabels(function, scene_.volumes.front().labels,
                             summarise(p_.layer().statistics, p_.info(), scene_.volumes.front().unit));
    if (opacities_)
        nextFunction_ = opacitiesAsGreys(*nextFunction_);
}

void InteractiveVolume::setOpacity(double opacity) {
    scene_.volumes.front().opacity = opacity;
    if (!nextFunction_)
        nextFunction_ = p_.layer().function;
}

void InteractiveVolume::setWindow(const WindowChoice& window) {
    scene_.window = window;
    if ((p_.layer().reduces() || p_.view.exposure) && !nextFunction_)
        nextFunction_ = p_.layer().function;
}

void InteractiveVolume::setLight(const Scene& scene) {
    Scene lit = scene_;
    lit.lighting = scene.lighting;
    lit.shading = scene.shading;
    TESSERA_CHECK(p_.setLight(lit)); // which may throw
    scene_ = std::move(lit);
    if (light())
        light()->lightingChanged();
}

void InteractiveVolume::forgetPath() {
    lookedAhead_ = 0;
    ahead_.clear();
}

InteractiveVolume::Choice InteractiveVolume::choiceOf(LevelChooser* chooser, const Request& r) {
    Choice c;
    const Statistics& statistics = r.scene->layer().statistics;
    const auto oneForAll = [&] { // in pages, not bytes
        const auto pages = [](const auto& counts) { return pagesFor(counts); };
        c.selection = selectOneLevel(statistics, *r.function, r.scene->info(), r.pages, pages, r.culling,
                                     "--gpu-memory", 0, r.finest);
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

void InteractiveVolume::startChoosing(const Camera& camera, std::vector<float> visible) {
    Request request{&p_,
                    nullptr,
                    cullingFor(scene_.shading),
                    camera,
                    chosenPages_,
                    std::move(visible),
                    p_.layer().selection.levels,
                    p_.isCoarse ? quickLevel(p_.info().extentVoxels) : 0};
    if (forChoice_.any(kFunctionChanged) || !predicts_)
        request.function = std::make_shared<const TransferTable>(p_.layer().table);
    raysReserve_ = {};
    choosing_ = std::async(std::launch::async, [chooser = chooser_.get(), r = std::move(request)] {
        return choiceOf(chooser, r);
    });
    choosingBegan_ = Clock::now();
}

void InteractiveVolume::finishChoosing(bool hasty) {
    if (!choosing_.valid() || choosing_.wait_for(milliseconds(0)) != std::future_status::ready)
        return;
    chosenAt_ = Clock::now();
    const bool forPath = std::exchange(forPath_, false);
    Choice choice = choosing_.get();
    predicts_ = choice.predicted;
    reserveForRays();
    // During motion the last view's levels are better than those of the one before it.
    if (forChoice_.any(hasty ? kFunctionChanged : ~0u))
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
    planMoves();
}

bool InteractiveVolume::mayChoose(bool hasty) const {
    constexpr int kOtherShares = 4;
    return !hasty || !wanted_ || Clock::now() > chosenAt_ + kOtherShares * (chosenAt_ - choosingBegan_);
}

void InteractiveVolume::choose(const std::vector<Camera>& path, bool hasty) {
    finishChoosing(hasty);
    if (choosing_.valid() || !mayChoose(hasty))
        return;
    if (forChoice_.any()) {
        // Visibility in the last view is the best estimate for this one, unless the function has changed.
        startChoosing(p_.view.camera, visible_);
        forChoice_ = Changes();
    } else if (wanted_ && moves_.empty() && countsLeft_ == 0 && lookedAhead_ < path.size()) {
        forPath_ = true;
        startChoosing(path[lookedAhead_++], visible_); // as it will be then
    }
}

void InteractiveVolume::applyFunction() {
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
    forgetPath();
    countsLeft_ = 1;
    forChoice_.add(kFunctionChanged);
    forPicture_.add(kFunctionChanged);
    forDevice_.add(kLevelsChanged);
}

void InteractiveVolume::countVisibility(const Slicing& slicing, Clock::time_point deadline, bool hasty) {
    if (!counting_) {
        if (hasty || !wanted_ || !moves_.empty() || choosing_.valid() || forChoice_.any() || countsLeft_ == 0)
            return;
        --countsLeft_;
        if (!predicts_ || predicted_.mean == 0)
            return; // every brick is as fine as a pixel shows
        mapResident();
        counter_->begin();
        counting_ = true;
    }
    if (!counter_->count(slicing, deadline))
        return;
    counting_ = false;
    visible_ = visibilityFactors(counter_->seen(), p_.layer().selection, visible_);
    startChoosing(p_.view.camera, visible_);
}

void InteractiveVolume::waitUntil(Clock::time_point soon) const {
    if (choosing_.valid())
        choosing_.wait_until(soon);
    else
        p_.layer().cache->waitForWanted(soon);
}

void InteractiveVolume::mapResident() {
    if (!forDevice_.take(kLevelsChanged))
        return;
    p_.mapLevels(mapsAlways_);
    engine_->bricks()->publish();
    forDevice_.add(kEmptySpaceChanged);
    forPicture_.add(kLevelsChanged);
}

bool InteractiveVolume::beginPicture() {
    mapResident();
    p_.aim();
    forPicture_ = Changes();
    return forDevice_.take(kEmptySpaceChanged);
}

bool InteractiveVolume::meansArePending() const {
    return !wanted_ || std::any_of(moves_.begin(), moves_.end(), [&](const Move& m) {
        return p_.layer().selection.levels[m.brick] == kMean;
    });
}

bool InteractiveVolume::settled(const std::vector<Camera>& path) const {
    return wanted_ && moves_.empty() && !counting_ && !choosing_.valid() && !forChoice_.any() &&
           !nextFunction_ && countsLeft_ == 0 && !forPicture_.any() && !forDevice_.any(kLevelsChanged) &&
           lookedAhead_ == path.size();
}

} // namespace tessera
