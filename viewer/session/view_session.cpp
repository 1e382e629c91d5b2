// viewer/session/view_session.cpp: see view_session.h. Everything that is open belongs to one thread; what
// others see of it is copied under one lock.
#include "viewer/session/view_session.h"

#include "core/error.h"
#include "core/interrupt.h"
#include "render/contract/ray_state.h" // rayCount
#include "render/interactive_renderer.h"
#include "render/plan/memory_plan.h"
#include "viewer/session/display_pixels.h"
#include "viewer/session/frame_pace.h"
#include "viewer/session/line_finder.h"
#include "viewer/session/picking.h"
#include "viewer/session/slice_thread.h"
#include "viewer/session/still.h"
#include "viewer/session/volume_histogram.h"
#if TESSERA_WITH_IMAGE_FILES
#include "core/image_file.h"
#endif

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <utility>

namespace tessera {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr int kHistogramBinsSeen = 256;
constexpr double kMovingStepVoxels = 1;
constexpr milliseconds kTurn{20};      // after which wishes are looked at again
constexpr std::size_t kSliceParts = 8; // of the RAM, one is for the three planes
/// Where pictures that follow one another would not fit beside stills: of the RAM, one each for the planes
/// and for lines; stills are left out.
constexpr std::size_t kTightParts = 16;
/// Pictures that are kept at once: the one that is shown, the next, and the one that a window still reads.
constexpr std::size_t kKeptPictures = 3;

/// All that belongs to an open volume. In the order in which it must be let go, backwards.
struct Open {
    /// @param withStills  whether they have half of both budgets
    Open(const ViewSessionOptions& options, const fs::path& named, bool withStills)
        : path(named), stills(withStills), ram("RAM", "--ram", ramForPictures(options, withStills)),
          gpu("GPU memory", "--gpu-memory", options.gpuBytes / (withStills ? 2 : 1)),
          sliceRam("RAM", "--ram", options.ramBytes / (withStills ? kSliceParts : kTightParts)),
          stillRam("RAM", "--ram", options.ramBytes / (withStills ? 2 : kTightParts)),
          stillGpu("GPU memory", "--gpu-memory", withStills ? options.gpuBytes / 2 : 0) {}
    static std::size_t ramForPictures(const ViewSessionOptions& options, bool withStills) {
        return withStills ? options.ramBytes / 2 - options.ramBytes / kSliceParts
                          : options.ramBytes - 2 * (options.ramBytes / kTightParts);
    }

    fs::path path;
    const bool stills;
    Ledger ram, gpu, sliceRam, stillRam, stillGpu;
    std::unique_ptr<StoreReader> store;
    Charge pictures;
    std::shared_ptr<Engine> engine;
    std::unique_ptr<InteractiveRenderer> renderer;
    Scene scene; // that the renderer draws
    std::unique_ptr<Still> still;
    std::unique_ptr<LineFinder> line;
};

std::size_t shownBytes(const glm::ivec2& size) {
    return kKeptPictures * (sizeof(glm::vec4) + sizeof(std::uint32_t)) * rayCount(size);
}

/// Without which a scene's pictures cannot follow one another.
std::size_t ramFloor(const VolumeInfo& info, const Scene& scene) {
    return shownBytes(scene.imageSize) +
           renderFloorBytes(info, scene.imageSize, kPictureBytesPerPixel, 0, scene.quality.integrator);
}

/// A scene without what a renderer can be told while it goes on.
/// @param compiles  Engine::About's
std::string fixedPart(Scene scene, bool compiles) {
    scene.measurements.clear();
    scene.window = std::string("auto");
    scene.lighting = {};
    scene.shading = {};
    if (!compiles)
        scene.cuts = {};
    scene.camera = FittedView{};
    scene.volumes.front().transferFunction = std::string();
    return sceneJson(scene);
}

std::string functionPart(const Scene& scene) {
    Scene alone;
    alone.volumes = {{"v", scene.volumes.front().transferFunction}};
    return sceneJson(alone);
}

std::string lightPart(const Scene& scene) {
    Scene alone;
    alone.volumes = {{"v", std::string()}};
    alone.lighting = scene.lighting;
    alone.shading = scene.shading;
    return sceneJson(alone);
}

TransferFunction resolved(const TransferChoice& choice, const ValueSummary& values) {
    if (const auto* name = std::get_if<std::string>(&choice))
        return presetFunction(*name, values);
    return std::get<TransferFunction>(choice);
}

class ViewSession final : public Viewing {
  public:
    explicit ViewSession(const ViewSessionOptions& options)
        : options_(options), pace_(options.frameMs), thread_([this] { run(); }) {}
    ~ViewSession() override {
        {
            const std::lock_guard lock(mutex_);
            stop_ = true;
        }
        openingCalledOff_ = true;
        wake_.notify_all();
        thread_.join();
    }

    void open(const fs::path& path, const glm::ivec2& pictureSize) override {
        {
            const std::lock_guard lock(mutex_);
            toOpen_ = {path, pictureSize};
            wish_.reset();
            state_.kind = ViewingState::Kind::opening;
            state_.what = "opening " + path.filename().string();
            state_.share = 0;
            state_.problem.clear();
        }
        openingCalledOff_ = true; // of one before
        wake_.notify_all();
    }
    std::shared_ptr<const VolumeSeen> volume() const override {
        const std::lock_guard lock(mutex_);
        return volume_;
    }
    std::uint64_t show(const Scene& scene, bool moving) override {
        std::get<Camera>(scene.camera).validate("camera");
        std::uint64_t number = 0;
        {
            const std::lock_guard lock(mutex_);
            number = ++wishes_;
            wish_ = Wish{scene, moving, number};
        }
        wake_.notify_all();
        return number;
    }
    std::shared_ptr<const ShownPicture> picture() const override {
        const std::lock_guard lock(mutex_);
        return picture_;
    }
    ViewingState state() const override {
        const std::lock_guard lock(mutex_);
        ViewingState state = state_;
        if (slices_ && state.problem.empty())
            state.problem = slices_->takeProblem();
        if (state.kind == ViewingState::Kind::opening) {
            const Progress::Stage stage = opening_ ? opening_->now() : Progress::Stage{};
            if (!stage.what.empty())
                state.what = stage.what, state.share = stage.share;
        }
        return state;
    }
    void showLevels(bool shown) override {
        const std::lock_guard lock(mutex_);
        if (shown == levelsShown_)
            return;
        levelsShown_ = stateAsked_ = shown;
        if (!shown)
            state_.levels.reset();
        wake_.notify_all();
    }
    void showSlices(const SliceWish& wish) override {
        const std::lock_guard lock(mutex_);
        if (slices_)
            slices_->show(wish);
    }
    std::shared_ptr<const ShownSlices> slices() const override {
        const std::lock_guard lock(mutex_);
        return slices_ ? slices_->shown() : nullptr;
    }
    std::uint64_t pick(const glm::dvec2& place) override {
        std::uint64_t number = 0;
        {
            const std::lock_guard lock(mutex_);
            number = ++questions_;
            question_ = place;
        }
        wake_.notify_all();
        return number;
    }
    std::optional<PickedPlace> picked() const override {
        const std::lock_guard lock(mutex_);
        return picked_;
    }
    std::uint64_t findLine(const LineWish& wish) override {
        std::uint64_t number = 0;
        {
            const std::lock_guard lock(mutex_);
            number = ++linesAsked_;
            lineWish_ = wish;
            line_.searching = true;
            line_.what = "looking for the line";
            line_.share = 0;
        }
        wake_.notify_all();
        return number;
    }
    void callOffLine() override {
        {
            const std::lock_guard lock(mutex_);
            lineCalledOff_ = true;
        }
        wake_.notify_all();
    }
    LineState line() const override {
        const std::lock_guard lock(mutex_);
        LineState line = line_;
        if (lineProgress_) {
            const Progress::Stage stage = lineProgress_->now();
            if (!stage.what.empty())
                line.what = stage.what, line.share = stage.share;
        }
        return line;
    }
    void lookAhead(std::vector<Camera> next) override {
        {
            const std::lock_guard lock(mutex_);
            ahead_ = std::move(next);
        }
        wake_.notify_all();
    }
    void saveScreenshot(const fs::path& path) const override;
    void problemSeen() override {
        const std::lock_guard lock(mutex_);
        state_.problem.clear();
    }

  private:
    /// Ends the planes' thread, before what it reads goes.
    void dropSlices() {
        std::unique_ptr<SliceThread> last; // ends after the lock
        const std::lock_guard lock(mutex_);
        last.swap(slices_);
    }
    struct ToOpen {
        fs::path path;
        glm::ivec2 pictureSize{0};
    };
    struct Wish {
        Scene scene;
        bool moving = false;
        std::uint64_t number = 0;
    };

    void run();
    bool waitForWork();
    void openVolume(const ToOpen& what);
    void makeRenderer(const Scene& scene);
    void take(const Wish& wish);
    void answer(const glm::dvec2& place, std::uint64_t number);
    void proceed();
    void publishPicture(const InteractiveRenderer::Progress& progress);
    void prepareDisplay(ShownPicture& picture) const;
    void nothingMoreComes();
    void answerAsBefore(std::uint64_t before);
    void startStill();
    void finishStill();
    void startLine(const LineWish& wish, std::uint64_t number);
    void finishLine();
    void tellState(const InteractiveRenderer::Progress& progress);
    void tellProblem(const std::string& problem);
    void giveUp(const std::string& problem);

    const ViewSessionOptions options_;

    mutable std::mutex mutex_; // of all up to the next blank line
    std::condition_variable wake_;
    bool stop_ = false;
    std::uint64_t stillEnded_ = 0; // its number; 0: none
    std::optional<ToOpen> toOpen_;
    std::optional<Wish> wish_;
    std::optional<glm::dvec2> question_;
    std::uint64_t wishes_ = 0, questions_ = 0;
    bool levelsShown_ = false, stateAsked_ = false;
    std::optional<LineWish> lineWish_;
    std::uint64_t linesAsked_ = 0;
    bool lineCalledOff_ = false;
    std::uint64_t lineEnded_ = 0; // its number; 0: none
    LineState line_;
    std::shared_ptr<Progress> lineProgress_; // while one is looked for
    std::optional<std::vector<Camera>> ahead_;
    std::shared_ptr<const VolumeSeen> volume_;
    std::shared_ptr<const ShownPicture> picture_;
    std::optional<PickedPlace> picked_;
    ViewingState state_;
    std::shared_ptr<Progress> opening_;
    std::unique_ptr<SliceThread> slices_; // of what is open

    // Of the thread alone.
    std::unique_ptr<Open> open_;
    std::uint64_t asked_ = 0; // the wish that is being drawn
    bool moving_ = false, resting_ = true;
    bool quickFirst_ = false;                // something is new: one picture of few pixels before one of all
    bool drawsMoving_ = false;               // the picture in the works is one of few pixels
    std::uint64_t stillNumber_ = 0;          // of the last still that was begun
    bool stillBegun_ = false;                // of the scene as it is
    std::uint64_t lineNumber_ = 0;           // of the line that is looked for
    InteractiveRenderer::Progress progress_; // the last
    std::string measured_;                   // of the still of asked_
    std::size_t damaged_ = 0;                // chunks that could not be read
    FramePace pace_;
    glm::ivec2 hastySize_{1}; // of pictures while something moves

    Cancellation::Flag openingCalledOff_{false};
    std::thread thread_; // last: it uses all of the above
};

bool ViewSession::waitForWork() {
    std::unique_lock lock(mutex_);
    wake_.wait(lock, [&] {
        return stop_ || toOpen_ || wish_ || question_ || stateAsked_ || stillEnded_ != 0 || lineWish_ ||
               lineCalledOff_ || lineEnded_ != 0 || ahead_ || !resting_;
    });
    return !stop_;
}

void ViewSession::run() {
    while (waitForWork()) {
        std::optional<ToOpen> path;
        std::optional<Wish> wish;
        std::optional<glm::dvec2> question;
        std::uint64_t number = 0;
        std::uint64_t stillEnded = 0;
        bool asksState = false, lineCalledOff = false;
        std::uint64_t lineEnded = 0;
        std::optional<LineWish> line;
        std::optional<std::vector<Camera>> ahead;
        std::uint64_t lineNumber = 0;
        {
            const std::lock_guard lock(mutex_);
            path = std::exchange(toOpen_, {});
            wish = std::exchange(wish_, {});
            question = std::exchange(question_, {});
            number = questions_;
            stillEnded = std::exchange(stillEnded_, 0);
            asksState = std::exchange(stateAsked_, false);
            line = std::exchange(lineWish_, {});
            lineNumber = linesAsked_;
            lineCalledOff = std::exchange(lineCalledOff_, false);
            lineEnded = std::exchange(lineEnded_, 0);
            ahead = std::exchange(ahead_, {});
        }
        try {
            if (path)
                openVolume(*path);
            if (stillEnded != 0 && stillEnded == stillNumber_ && open_ && open_->still)
                finishStill();
            if (lineCalledOff && open_ && open_->line)
                open_->line->callOff();
            if (lineEnded != 0 && lineEnded == lineNumber_ && open_ && open_->line)
                finishLine();
            if (line)
                startLine(*line, lineNumber);
            if (ahead && open_ && open_->renderer)
                open_->renderer->setPath(std::move(*ahead));
            if (wish && open_)
                take(*wish);
            if (question && open_)
                answer(*question, number);
            proceed();
            if (asksState && open_ && open_->renderer)
                tellState(progress_);
        } catch (const Cancelled&) { // another volume, or the end
        } catch (const Interrupted&) {
            giveUp("interrupted");
        } catch (const std::exception& e) {
            giveUp(e.what());
        }
        options_.news();
    }
    dropSlices();
    open_.reset(); // here: engines belong to the thread
}

void ViewSession::openVolume(const ToOpen& what) {
    const fs::path& path = what.path;
    openingCalledOff_ = false;
    const Cancellation asks(&openingCalledOff_);
    auto progress = std::make_shared<Progress>(Verbosity::quiet, true);
    {
        const std::lock_guard lock(mutex_);
        opening_ = progress;
    }
    try {
        auto next = std::make_unique<Open>(options_, path, true);
        Scene scene = isSceneFile(path) ? loadScene(path) : defaultScene(path);
        scene.imageSize = what.pictureSize;
        if (!scene.quality.pixels.named)
            scene.quality.pixels.samples = PixelSampling::kAutomatic, scene.quality.pixels.named = true;
        CommonOptions common = options_.common;
        common.progress = progress;
        SceneVolume& volume = scene.volumes.front();
        volume.path = storeFor(volume.path, options_.input, next->ram, common);
        progress->stage("opening " + path.filename().string());
        next->store = std::make_unique<StoreReader>(volume.path, next->ram);
        const std::size_t least = ramFloor(next->store->info(), scene);
        if (next->ram.limitBytes() < least && Open::ramForPictures(options_, false) >= least) {
            next = std::make_unique<Open>(options_, path, false);
            next->store = std::make_unique<StoreReader>(volume.path, next->ram);
        }
        const VolumeInfo& info = next->store->info();
        if (const auto* name = std::get_if<std::string>(&volume.transferFunction); name && name->empty())
            volume.transferFunction = std::string(info.unit == "HU" || volume.unit == "HU" ? "bone" : "auto");
        dropSlices(); // of the one before, which goes
        open_ = std::move(next);
        makeRenderer(scene);
        auto seen = std::make_shared<VolumeSeen>();
        seen->path = path;
        seen->info = info;
        seen->values = summarise(open_->renderer->volume().statistics, info, volume.unit);
        open_->scene.camera = open_->renderer->camera();
        open_->scene.volumes.front().transferFunction = resolved(volume.transferFunction, seen->values);
        seen->scene = open_->scene;
        try {
            seen->histogram = volumeHistogram(open_->renderer->volume(), seen->values.lowest,
                                              seen->values.highest, kHistogramBinsSeen);
        } catch (const Error&) { // damaged: told when it is drawn
            seen->histogram = seen->values.histogram;
        }
        std::unique_ptr<SliceThread> slices;
        if (open_->sliceRam.freeBytes() > 2 * SliceThread::floorBytes(info, options_.threads))
            slices = std::make_unique<SliceThread>(*open_->store, open_->sliceRam, options_.threads,
                                                   options_.news);
        const std::lock_guard lock(mutex_);
        slices_ = std::move(slices);
        opening_.reset();
        volume_ = std::move(seen);
        picture_.reset();
        picked_.reset();
        line_ = {};
        lineProgress_.reset();
        asked_ = ++wishes_;
        state_ = {};
        state_.kind = ViewingState::Kind::open;
        state_.engine = open_->engine->about().device;
        moving_ = resting_ = stillBegun_ = false;
        measured_.clear();
    } catch (const Cancelled&) {
        const std::lock_guard lock(mutex_);
        opening_.reset();
        throw;
    } catch (const std::exception& e) {
        const std::lock_guard lock(mutex_);
        opening_.reset();
        if (open_ && volume_ && open_->renderer) { // what was open stays
            state_.kind = ViewingState::Kind::open;
            state_.problem = e.what();
        } else {
            open_.reset();
            volume_.reset();
            state_ = {};
            state_.kind = ViewingState::Kind::failed;
            state_.what = e.what();
        }
        resting_ = true;
    }
}

/// Of the open volume, for a scene of which more has changed than a renderer can be told.
void ViewSession::makeRenderer(const Scene& scene) {
    Open& o = *open_;
    o.renderer.reset();
    o.engine.reset();
    o.pictures = {};
    o.pictures = o.ram.charge(shownBytes(scene.imageSize), "the pictures that a window shows");
    RenderOptions render;
    render.engine = options_.engine;
    render.device = options_.device;
    render.threads = options_.threads;
    o.engine = makeEngine(scene, render, o.ram, o.gpu);
    InteractiveOptions interactive;
    interactive.threads = options_.threads;
    o.renderer = std::make_unique<InteractiveRenderer>(scene, *o.store, *o.engine, o.ram, o.gpu, interactive);
    o.scene = scene;
    damaged_ = 0; // each is told once a renderer
    pace_.forget();
    resting_ = false;
    drawsMoving_ = false;
    quickFirst_ = true;
    hastySize_ = pace_.sizeFor(scene.imageSize);
}

void ViewSession::take(const Wish& wish) {
    Open& o = *open_;
    if (wish.scene.volumes.front().path != o.scene.volumes.front().path)
        return;        // of the volume before
    if (!o.renderer) { // the last scene could not be drawn, for want of memory
        makeRenderer(wish.scene);
        asked_ = wish.number;
        moving_ = wish.moving;
        return;
    }
    const bool compiles = o.engine->about().compiles;
    const Camera& camera = std::get<Camera>(wish.scene.camera);
    const bool another = fixedPart(wish.scene, compiles) != fixedPart(o.scene, compiles),
               turned = camera != o.renderer->camera(),
               recoloured = functionPart(wish.scene) != functionPart(o.scene),
               rewindowed = wish.scene.window != o.scene.window, recut = !(wish.scene.cuts == o.scene.cuts),
               relit = lightPart(wish.scene) != lightPart(o.scene);
    const bool changed = another || turned || recoloured || rewindowed || recut || relit;
    if (changed) {
        if (o.still)
            o.still->callOff();
        stillBegun_ = false;
        measured_.clear();
    }
    if (another || (relit && !o.renderer->setLight(wish.scene.lighting, wish.scene.shading))) {
        makeRenderer(wish.scene);
    } else if (changed) {
        if (turned)
            o.renderer->setCamera(camera);
        if (recoloured)
            o.renderer->setFunction(std::get<TransferFunction>(wish.scene.volumes.front().transferFunction));
        if (rewindowed)
            o.renderer->setWindow(wish.scene.window);
        if (recut)
            o.renderer->setCuts(wish.scene.cuts);
        quickFirst_ = true;
        if (!drawsMoving_)
            o.renderer->cancel();
    }
    o.scene = wish.scene;
    hastySize_ = pace_.sizeFor(o.scene.imageSize); // once a wish: nothing is drawn again for a better guess
    const std::uint64_t before = std::exchange(asked_, wish.number);
    moving_ = wish.moving;
    resting_ = false;
    if (!changed)
        answerAsBefore(before);
}

/// The picture that answered the wish before is of this one as well; where none has, one is on its way.
void ViewSession::answerAsBefore(std::uint64_t before) {
    const std::lock_guard lock(mutex_);
    if (!picture_ || picture_->asked != before)
        return;
    auto same = std::make_shared<ShownPicture>(*picture_);
    same->asked = asked_;
    picture_ = std::move(same);
}

void ViewSession::answer(const glm::dvec2& place, std::uint64_t number) {
    PickedPlace picked = pickPlace(open_->renderer->volume(), open_->renderer->part(),
                                   open_->renderer->camera(), open_->scene.imageSize, place);
    picked.number = number;
    const std::lock_guard lock(mutex_);
    picked_ = picked;
}

void ViewSession::proceed() {
    if (resting_ || !open_ || !open_->renderer) {
        resting_ = true;
        return;
    }
    Open& o = *open_;
    const bool hasty = moving_ || quickFirst_;
    if (hasty)
        o.renderer->setHaste(InteractiveRenderer::Haste{hastySize_, kMovingStepVoxels});
    else
        o.renderer->setHaste(std::nullopt);
    drawsMoving_ = hasty;
    InteractiveRenderer::Progress progress;
    try {
        progress = o.renderer->advance(Clock::now() + kTurn);
    } catch (const Error& e) { // a chunk that cannot be read: its bricks stay as coarse as they are
        ++damaged_;
        tellProblem(e.what());
        return;
    }
    progress_ = progress;
    if (progress.newPicture) {
        publishPicture(progress);
        quickFirst_ = false;
    }
    resting_ = progress.converged && hasty == moving_;
    if (resting_ && !moving_)
        nothingMoreComes();
    if (resting_ && !moving_ && options_.stills && o.stills && !stillBegun_ && !o.still && !o.line)
        startStill();
    tellState(progress);
}

void ViewSession::publishPicture(const InteractiveRenderer::Progress& progress) {
    auto picture = std::make_shared<ShownPicture>();
    const InteractiveRenderer& r = *open_->renderer;
    picture->image = r.picture();
    picture->stage = picture->image.size != open_->scene.imageSize || moving_                ? Stage::moving
                     : progress.movesLeft > 0 || progress.choosing || progress.lightIsCoarse ? Stage::loading
                                                                                             : Stage::whole;
    picture->camera = r.camera();
    picture->asked = asked_;
    picture->drawingMs = r.pictureMs();
    pace_.drew(picture->image.size, picture->drawingMs);
    prepareDisplay(*picture);
    const std::lock_guard lock(mutex_);
    picture_ = std::move(picture);
    ++state_.pictures;
}

/// The last picture was taken for one whose bricks are on their way; it turned out to be the last.
void ViewSession::nothingMoreComes() {
    const std::lock_guard lock(mutex_);
    if (!picture_ || picture_->stage != Stage::loading)
        return;
    auto whole = std::make_shared<ShownPicture>(*picture_);
    whole->stage = Stage::whole;
    picture_ = std::move(whole);
}

void ViewSession::prepareDisplay(ShownPicture& picture) const {
    const Scene& scene = open_->scene;
    picture.displaySize = scene.imageSize;
    picture.display = displayPixels(picture.image, scene.background, scene.imageSize, options_.threads);
}

void ViewSession::startStill() {
    Open& o = *open_;
    RenderOptions render;
    render.engine = options_.engine;
    render.device = options_.device;
    render.threads = options_.threads;
    render.searching = render.checking = true;
    render.verify = Verify::quick;
    stillBegun_ = true;
    ++stillNumber_;
    o.still = std::make_unique<Still>(o.scene, asked_, *o.store, o.stillRam, o.stillGpu, render,
                                      [this, number = stillNumber_] {
                                          {
                                              const std::lock_guard lock(mutex_);
                                              stillEnded_ = number;
                                          }
                                          wake_.notify_all();
                                      });
}

void ViewSession::finishStill() {
    Open& o = *open_;
    FinishedStill finished = o.still->take();
    o.still.reset();
    if (finished.picture)
        prepareDisplay(*finished.picture);
    const std::lock_guard lock(mutex_);
    if (finished.picture && stillBegun_) {
        finished.picture->asked = asked_;
        picture_ = finished.picture;
        ++state_.pictures;
        state_.measured = measured_ = finished.measured;
        state_.drawingStill = false;
        state_.atRest = true;
    } else if (!finished.problem.empty()) {
        state_.problem = finished.problem;
        state_.drawingStill = false;
        state_.atRest = true;
    } else {
        resting_ = false; // called off: the wish that did so gets one of its own
    }
}

void ViewSession::startLine(const LineWish& wish, std::uint64_t number) {
    LineState none;
    none.number = number;
    if (!open_) {
        const std::lock_guard lock(mutex_);
        line_ = none;
        return;
    }
    Open& o = *open_;
    o.line.reset();
    if (o.still) { // its memory is the line's from now on
        o.still.reset();
        stillBegun_ = false;
    }
    lineNumber_ = number;
    o.line = std::make_unique<LineFinder>(wish, *o.store, o.stillRam, options_.threads, [this, number] {
        {
            const std::lock_guard lock(mutex_);
            lineEnded_ = number;
        }
        wake_.notify_all();
    });
    const std::lock_guard lock(mutex_);
    lineProgress_ = o.line->progress();
}

void ViewSession::finishLine() {
    Open& o = *open_;
    LineState found = o.line->take();
    o.line.reset();
    found.number = lineNumber_;
    resting_ = false; // a still may follow
    const std::lock_guard lock(mutex_);
    line_ = std::move(found);
    lineProgress_.reset();
    if (lineWish_) // another is asked for already
        line_.searching = true;
}

void ViewSession::tellState(const InteractiveRenderer::Progress& progress) {
    Open& o = *open_;
    const InteractiveRenderer& r = *o.renderer;
    ViewingState s;
    s.ramUsed = o.ram.usedBytes() + o.sliceRam.usedBytes() + o.stillRam.usedBytes(),
    s.ramLimit = options_.ramBytes;
    s.gpuUsed = o.gpu.usedBytes() + o.stillGpu.usedBytes(), s.gpuLimit = options_.gpuBytes;
    const Selection& has = r.resident();
    s.bricks = has.levels.size();
    s.bricksShown = has.shownBricks();
    if (const auto& wanted = r.wanted())
        for (std::size_t b = 0; b < has.levels.size(); ++b)
            s.bricksAsWanted += has.levels[b] != Selection::kEmpty && has.levels[b] <= wanted->levels[b];
    s.finestLevel = kLevelCount - 1;
    for (int level = kLevelCount - 1; level >= 0; --level)
        if (has.counts[static_cast<std::size_t>(level)] > 0)
            s.finestLevel = level, s.coarsestLevel = std::max(s.coarsestLevel, level);
    const BrickCache::Counters counters = r.cacheCounters();
    s.chunksThere = counters.hits;
    s.chunksMissed = counters.joins + counters.misses;
    s.movesLeft = progress.movesLeft;
    s.choosing = progress.choosing;
    s.lightIsCoarse = progress.lightIsCoarse;
    s.drawingStill = o.still != nullptr;
    s.noStills = options_.stills && !o.stills;
    s.atRest = resting_ && !o.still && !o.line;
    s.measured = measured_;
    s.damagedChunks = damaged_;
    const std::lock_guard lock(mutex_);
    if (levelsShown_) {
        s.levels = std::make_shared<const std::vector<std::uint8_t>>(has.levels);
        s.brickGrid = has.bricks;
    }
    s.kind = state_.kind;
    s.what = state_.what;
    s.problem = state_.problem;
    s.engine = state_.engine;
    s.pictures = state_.pictures;
    state_ = std::move(s);
}

/// What was asked cannot be drawn: nothing more comes until something else is asked.
void ViewSession::giveUp(const std::string& problem) {
    resting_ = true;
    const std::lock_guard lock(mutex_);
    state_.problem = problem;
    state_.atRest = true;
}

void ViewSession::tellProblem(const std::string& problem) {
    const std::lock_guard lock(mutex_);
    state_.problem = problem;
}

void ViewSession::saveScreenshot(const fs::path& path) const {
#if TESSERA_WITH_IMAGE_FILES
    const std::shared_ptr<const ShownPicture> shown = picture();
    const std::shared_ptr<const VolumeSeen> seen = volume();
    if (!shown || !seen)
        throw InputError("there is no picture to save");
    checkImagePath(path);
    const auto background = seen->scene.background;
    writeImage(path, background ? overBackground(shown->image, *background) : shown->image,
               shown->manifest.empty() ? R"({"notice":"not for diagnosis","coarse":true})" : shown->manifest);
#else
    throw InputError(path.string() + ": this program was built without picture files");
#endif
}

} // namespace

Scene defaultScene(const fs::path& path) {
    Scene scene;
    scene.quality.automaticStep = true;
    scene.volumes.push_back({path, std::string()});
    return scene;
}

std::unique_ptr<Viewing> makeViewSession(const ViewSessionOptions& options) {
    return std::make_unique<ViewSession>(options);
}

} // namespace tessera
