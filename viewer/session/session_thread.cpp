// viewer/session/session_thread.cpp: see session_thread.h. One turn takes the requests and refines the
// picture a little.
#include "viewer/session/session_thread.h"

#include "core/base/error.h"
#include "viewer/session/disc_values.h"
#include "viewer/session/scene_change.h"
#include "viewer/session/shown_picture.h"
#include "viewer/session/volume_values.h"

#include <chrono>
#include <utility>
#include <variant>

namespace tessera {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kMovingStepVoxels = 1;
constexpr std::chrono::milliseconds kTurn{20}; // requests are polled after each turn

} // namespace

SessionThread::SessionThread(const ViewSessionOptions& options, SessionBoard& board)
    : options_(options), board_(board), pace_(options.frameMs), thread_([this] { run(); }) {}

SessionThread::~SessionThread() {
    board_.ask([this](SessionWishes& wishes, SessionNews&) {
        wishes.stop = true;
        callOffOpening();
    });
    thread_.join();
}

void SessionThread::run() {
    for (;;) {
        // From here on a cancellation is for the request that is taken now.
        SessionWishes wishes = board_.take(resting_, [this] { openingCalledOff_ = false; });
        if (wishes.stop)
            break;
        try {
            turn(wishes);
        } catch (const Cancelled&) { // another volume, or the end
        } catch (const Interrupted&) {
            giveUp("interrupted");
        } catch (const std::exception& e) {
            giveUp(e.what());
        }
        options_.news();
    }
    thumbnails_.reset();
    dropSlices();
    dropSaving();
    open_.reset(); // here: engines belong to the thread
}

void SessionThread::turn(SessionWishes& wishes) {
    if (wishes.toOpen)
        openVolume(*wishes.toOpen);
    if (wishes.stillEnded != 0 && wishes.stillEnded == stillNumber_ && open_ && open_->still)
        finishStill();
    if (wishes.finerEnded != 0 && wishes.finerEnded == finerNumber_ && open_ && open_->finer)
        changeOver();
    if (wishes.lineCalledOff && open_ && open_->line)
        open_->line->callOff();
    if (wishes.lineEnded != 0 && wishes.lineEnded == lineNumber_ && open_ && open_->line)
        finishLine();
    if (wishes.line)
        startLine(*wishes.line);
    if (wishes.save)
        startSaving(*wishes.save);
    if (wishes.ahead && open_ && open_->renderer)
        open_->renderer->setPath(std::move(*wishes.ahead));
    if (wishes.toShow && open_)
        take(*wishes.toShow);
    if (wishes.round) // after a change, which calls the still off
        showRound(*wishes.round);
    if (wishes.question && open_ && open_->renderer)
        answer(*wishes.question);
    if (wishes.disc)
        answer(*wishes.disc);
    proceed();
    if (wishes.stateAsked && open_ && open_->renderer)
        tellState(progress_);
}

void SessionThread::take(const SessionWishes::ToShow& wish) {
    OpenVolume& o = *open_;
    if (wish.scene.volumes.front().path != o.scene.volumes.front().path)
        return; // for the previous volume
    const std::uint64_t before = std::exchange(asked_, wish.number);
    moving_ = wish.moving;
    if (!o.renderer) { // the last scene could not be drawn, for want of memory
        makeRenderer(wish.scene);
        return;
    }
    const SceneChange change =
        changeOf(wish.scene, o.scene, o.renderer->camera(), o.engine->about().compiles);
    const bool changed = change.any();
    if (changed) {
        if (o.still && !saving_)
            o.still->callOff();
        stillBegun_ = false;
        measured_.clear();
    }
    if (change.another || (change.relit && !o.renderer->setLight(wish.scene.lighting, wish.scene.shading))) {
        makeRenderer(wish.scene);
    } else if (changed) {
        for (const std::size_t n : change.recoloured)
            if (n < o.renderer->sceneVolumes())
                o.renderer->setFunction(o.renderer->functionOf(wish.scene.volumes[n].transferFunction, n), n);
        for (const std::size_t n : change.faded)
            o.renderer->setOpacity(wish.scene.volumes[n].opacity, n);
        if (change.rewindowed)
            o.renderer->setWindow(wish.scene.window);
        if (change.recut)
            o.renderer->setCuts(wish.scene.cuts);
        if (change.turned)
            aim(wish.scene);
        quickFirst_ = true;
        if (!drawsMoving_)
            o.renderer->cancel();
    }
    o.scene = wish.scene;
    o.scene.camera = o.renderer->camera();
    hastySize_ =
        pace_.sizeFor(o.scene.imageSize); // once per request: a better estimate causes no new picture
    resting_ = false;
    if (!changed)
        answerAsBefore(before);
}

/// Sets the scene's camera. A camera by side is fitted, with another renderer where this one leaves no memory
/// for the fit.
void SessionThread::aim(const Scene& scene) {
    const auto* const view = std::get_if<FittedView>(&scene.camera);
    const std::optional<Camera> camera =
        view ? open_->renderer->fitted(*view) : std::get<Camera>(scene.camera);
    if (camera)
        open_->renderer->setCamera(*camera);
    else
        makeRenderer(scene);
}

/// The picture that answered the previous request answers this one as well. If there is none yet, one is on
/// its way.
void SessionThread::answerAsBefore(std::uint64_t before) {
    board_.tell([&](SessionNews& news) {
        if (!news.picture || news.picture->asked != before)
            return;
        auto same = std::make_shared<ShownPicture>(*news.picture);
        same->asked = asked_;
        news.picture = std::move(same);
    });
}

void SessionThread::answer(const SessionWishes::Question& question) {
    std::vector<MeshOnRay> meshes;
    for (const auto& [voxel, mesh] : open_->renderer->meshesAlong(open_->scene.imageSize, question.place))
        meshes.push_back({voxel, mesh->opacity, mesh->name()});
    PickedPlace picked = pickPlace(open_->renderer->volume(), open_->renderer->part(),
                                   open_->renderer->camera(), open_->scene.imageSize, question.place, meshes);
    if (picked.hit && picked.mesh.empty())
        try {
            picked.labels = open_->labelsAt(picked.voxel);
        } catch (const Error&) { // damaged: told when it is drawn
        }
    picked.number = question.number;
    board_.tell([&](SessionNews& news) { news.picked = picked; });
}

void SessionThread::answer(const SessionWishes::Disc& question) {
    DiscValues values;
    try {
        if (open_ && open_->renderer) {
            const Layer& volume = open_->renderer->volume();
            values = discValues(*volume.cache, volume.info(), question.circle);
        }
    } catch (const Error&) { // damaged
    }
    values.number = question.number;
    board_.tell([&](SessionNews& news) { news.disc = values; });
}

void SessionThread::proceed() {
    if (resting_ || !open_ || !open_->renderer) {
        resting_ = true;
        return;
    }
    OpenVolume& o = *open_;
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
        board_.tell([&](SessionNews& news) { news.state.problem = e.what(); });
        return;
    }
    progress_ = progress;
    if (progress.newPicture) {
        publishPicture(progress);
        quickFirst_ = false;
        if (o.renderer->isCoarse()) { // the first picture is there: now all that the next ones need
            const Cancellation asks(&openingCalledOff_);
            options_.news();
            makeRenderer(Scene(o.scene));
            return;
        }
    }
    resting_ = progress.converged && hasty == moving_;
    if (resting_ && !moving_)
        nothingMoreComes();
    if (resting_ && !moving_ && options_.stills && o.stills && !stillBegun_ && !o.still && !o.line &&
        !o.finer)
        startStill();
    tellState(progress);
}

void SessionThread::publishPicture(const InteractiveRenderer::Progress& progress) {
    auto picture = std::make_shared<ShownPicture>();
    const InteractiveRenderer& r = *open_->renderer;
    picture->image = r.picture();
    picture->stage = picture->image.size != open_->scene.imageSize || moving_ ? Stage::moving
                     : progress.movesLeft > 0 || progress.choosing || progress.lightIsCoarse || r.isCoarse()
                         ? Stage::loading
                         : Stage::whole;
    picture->camera = r.camera();
    picture->asked = asked_;
    picture->drawingMs = r.pictureMs();
    pace_.drew(picture->image.size, picture->drawingMs);
    prepareDisplay(*picture);
    board_.tell([&](SessionNews& news) {
        news.picture = std::move(picture);
        ++news.state.pictures;
    });
}

/// Marks the last picture as complete: it was shown as still loading, but no further bricks come.
void SessionThread::nothingMoreComes() {
    board_.tell([](SessionNews& news) {
        if (!news.picture || news.picture->stage != Stage::loading)
            return;
        auto whole = std::make_shared<ShownPicture>(*news.picture);
        whole->stage = Stage::whole;
        news.picture = std::move(whole);
    });
}

void SessionThread::prepareDisplay(ShownPicture& picture) const {
    const Scene& scene = open_->scene;
    picture.displaySize = scene.imageSize;
    picture.background = scene.background;
    picture.display = displayPixels(picture.image, scene.background, scene.imageSize, options_.threads);
}

void SessionThread::tellState(const InteractiveRenderer::Progress& progress) {
    const OpenVolume& o = *open_;
    ViewingState s = o.usage();
    s.movesLeft = progress.movesLeft;
    s.choosing = progress.choosing;
    s.lightIsCoarse = progress.lightIsCoarse;
    s.atRest = resting_ && !o.still && !o.line && !o.finer;
    s.measured = measured_;
    s.damagedChunks = damaged_;
    s.refused = refused_;
    const Selection& has = o.renderer->resident();
    board_.tell([&](SessionNews& news) {
        if (news.levelsShown) {
            s.levels = std::make_shared<const std::vector<std::uint8_t>>(has.levels);
            s.brickGrid = has.bricks;
        }
        s.kind = news.state.kind;
        s.what = news.state.what;
        s.problem = news.state.problem;
        s.engine = news.state.engine;
        s.pictures = news.state.pictures;
        news.state = std::move(s);
    });
}

/// The request cannot be drawn: nothing more comes until the next one.
void SessionThread::giveUp(const std::string& problem) {
    resting_ = true;
    refused_ = asked_;
    board_.tell([&](SessionNews& news) {
        news.state.problem = problem;
        news.state.atRest = true;
        news.state.refused = refused_;
    });
}

} // namespace tessera
