// viewer/session/session_opening.cpp: the part of session_thread.h that opens another volume, and has another
// renderer made for a scene of which more has changed than one can be told.
#include "viewer/session/session_thread.h"

#include "core/base/error.h"
#include "viewer/cli/input/file_level.h"
#include "viewer/session/label_probe.h"

#include <exception>
#include <filesystem>
#include <optional>
#include <string>
#include <system_error>
#include <utility>

namespace tessera {
namespace {

/// Of what is open.
PhaseList phasesIn(const SceneVolume& volume) {
    try {
        return phasesOfOpen(volume.path, volume.source);
    } catch (const Error&) { // it is open; others are not offered
        return {};
    }
}

InputOptions inputOfPhase(const OpenVolume& open, int phase) {
    InputOptions input(open.scene.volumes.front().source);
    input.series = open.phases.series;
    input.phase = phase;
    return input;
}

} // namespace

void SessionThread::openVolume(const SessionWishes::ToOpen& what) {
    const Cancellation asks(&openingCalledOff_);
    thumbnails_.reset();
    auto progress = std::make_shared<Progress>(Verbosity::quiet, true);
    board_.tell([&](SessionNews& news) {
        news.opening = progress;
        news.offers.reset();
        news.thumbnails.clear();
        news.state.kind = ViewingState::Kind::opening;
    });
    std::string noLabels;
    if (!what.pick.asVolume && !what.pick.inSameView && open_ && open_->renderer && !isSceneFile(what.path) &&
        !looksLikeStore(what.path) && mayBeLabelsOf(open_->store->info(), what.path) &&
        openLabels(what, progress, true, noLabels))
        return;
    const bool isPhase = what.pick.inSameView && open_ && open_->renderer;
    try {
        const InputOptions input =
            isPhase ? inputOfPhase(*open_, what.pick.phase) : optionsFor(what.pick, options_.input);
        const std::optional<int> level = isSceneFile(what.path) || options_.firstBytes == 0
                                             ? std::nullopt
                                             : levelToBeginWith(what.path, input, options_.firstBytes);
        std::unique_ptr<OpenVolume> next =
            OpenVolume::open(options_, what.path, input, what.pictureSize, progress, level);
        if (isPhase) {
            next->takeLook(*open_, progress);
            next->phases.phase = what.pick.phase;
            next->fitted = open_->fitted;
        } else {
            next->phases = phasesIn(next->scene.volumes.front());
        }
        show(std::move(next));
        if (level)
            startFiner(what, input);
    } catch (const Cancelled&) {
        board_.tell([](SessionNews& news) { news.opening.reset(); });
        throw;
    } catch (const std::exception& e) {
        std::string why = e.what();
        if (!isPhase && (offerChoice(what, why) || openLabels(what, progress, false, why)))
            return;
        const bool stays = open_ && open_->renderer && // the previous volume remains open
                           board_.look([](const SessionNews& news) { return news.volume != nullptr; });
        if (!stays) { // outside the lock, because the destructors take it
            dropSlices();
            dropSaving();
            open_.reset();
        }
        board_.tell([&](SessionNews& news) {
            news.opening.reset();
            if (stays) {
                news.state.kind = ViewingState::Kind::open;
                news.state.problem = why;
            } else {
                news.volume.reset();
                news.state = {};
                news.state.kind = ViewingState::Kind::failed;
                news.state.what = e.what();
            }
        });
        resting_ = true;
    }
}

/// Has it drawn in place of what is open.
void SessionThread::show(std::unique_ptr<OpenVolume> next) {
    dropSlices(); // of the previous volume, which is closed
    dropSaving();
    open_ = std::move(next);
    makeRenderer(Scene(open_->scene), PlanDetail::coarse);
    std::shared_ptr<VolumeSeen> seen = open_->describe();
    std::unique_ptr<SliceThread> slices;
    if (open_->sliceRam.freeBytes() > 2 * SliceThread::floorBytes(seen->info, options_.threads))
        slices =
            std::make_unique<SliceThread>(*open_->store, open_->sliceRam, options_.threads, options_.news);
    board_.tell([&](SessionNews& news) {
        news.slices = std::move(slices);
        news.opening.reset();
        news.volume = std::move(seen);
        news.picture.reset();
        news.picked.reset();
        news.line = {};
        news.lineProgress.reset();
        asked_ = ++news.wishes;
        news.state = {};
        news.state.kind = ViewingState::Kind::open;
        news.state.engine = open_->engine->about().device;
    });
    moving_ = resting_ = stillBegun_ = false;
    measured_.clear();
}

/// A coarse level is open: imports the one that is meant, in the memory of stills.
void SessionThread::startFiner(const SessionWishes::ToOpen& what, const InputOptions& input) {
    finerOf_ = what;
    finerInput_ = input;
    const std::string part = sayFilePart(*open_->store->info().filePart);
    open_->finer =
        std::make_unique<FinerImport>(what.path, input, open_->stillRam, [this, number = ++finerNumber_] {
            board_.ask([&](SessionWishes& wishes, SessionNews&) { wishes.finerEnded = number; });
        });
    board_.tell([&](SessionNews& news) {
        news.notice = "shown for now: " + part + "; the finer one is being imported";
    });
}

/// The level that is meant is there. Camera, functions and all else of the scene stay.
void SessionThread::changeOver() {
    const std::unique_ptr<FinerImport> finer = std::move(open_->finer); // its import stays until it is opened
    std::string problem = finer->take();
    if (problem.empty())
        try {
            auto progress = std::make_shared<Progress>();
            std::unique_ptr<OpenVolume> next =
                OpenVolume::open(options_, finerOf_.path, finerInput_, open_->scene.imageSize, progress);
            next->takeLook(*open_, progress);
            show(std::move(next));
        } catch (const Error& e) {
            problem = e.what();
        }
    if (problem.empty())
        return;
    resting_ = false; // a still may follow
    board_.tell([&](SessionNews& news) { news.state.problem = "the coarse level stays: " + problem; });
}

/// What is no volume may be labels of the open one, which stays as it is otherwise.
/// @param isEither  it may be a volume as well
/// @param why  the reason why it is no volume; the reason why it is no labels either is added
bool SessionThread::openLabels(const SessionWishes::ToOpen& what, const std::shared_ptr<Progress>& progress,
                               bool isEither, std::string& why) {
    std::error_code ignored;
    if (!open_ || !open_->renderer || !std::filesystem::exists(what.path, ignored) ||
        isSceneFile(what.path) || looksLikeStore(what.path))
        return false;
    try {
        OpenVolume::Labelled next = open_->labelled(what.path, progress);
        const Scene before = open_->scene;
        open_->still.reset();
        dropSaving();
        try {
            makeRenderer(next.scene);
        } catch (const InputError&) {
            makeRenderer(before);
            throw;
        }
        open_->labels = std::move(next.labels);
        open_->eitherFile = isEither ? what.path : std::filesystem::path();
        open_->fitted.reset(); // the camera stays
    } catch (const Cancelled&) {
        board_.tell([](SessionNews& news) { news.opening.reset(); });
        throw;
    } catch (const InputError& e) {
        why += "; as labels of the open volume: " + std::string(e.what());
        return false;
    }
    std::shared_ptr<VolumeSeen> seen = open_->describe();
    board_.tell([&](SessionNews& news) {
        news.opening.reset();
        news.volume = std::move(seen);
        news.picked.reset();
        asked_ = ++news.wishes;
        news.state.kind = ViewingState::Kind::open;
        news.state.atRest = false;
    });
    moving_ = resting_ = stillBegun_ = false;
    measured_.clear();
    return true;
}

/// If a folder holds several volumes and none was chosen, they are offered. The open volume stays.
bool SessionThread::offerChoice(const SessionWishes::ToOpen& what, const std::string& why) {
    std::shared_ptr<const VolumeOffers> offers;
    std::error_code ignored;
    const InputOptions input = optionsFor(what.pick, options_.input);
    const bool chosen = what.pick != VolumePick{};
    if ((!chosen && !asksForChoice(why)) || looksLikeStore(what.path) ||
        !std::filesystem::exists(what.path, ignored))
        return false;
    try {
        offers = volumeOffers(what.path, input);
    } catch (const Error&) { // the first error is reported
    }
    if (!offers)
        return false;
    board_.tell([&](SessionNews& news) {
        news.opening.reset();
        news.offers = offers;
        news.thumbnails.assign(offers->offers.size(), nullptr);
        news.state.kind = news.volume ? ViewingState::Kind::open : ViewingState::Kind::choosing;
        news.state.what = why.substr(0, why.find('\n'));
        if (chosen) // and it cannot be opened
            news.state.problem = news.state.what;
    });
    resting_ = resting_ || !open_ || !open_->renderer;
    // Memory for previews of slices: the rest of the planes' share, which outlives this call, or a part of
    // the whole RAM.
    constexpr std::size_t kParts = 8;
    auto ram = open_ ? std::shared_ptr<MemoryBudget>(std::shared_ptr<void>(), &open_->sliceRam)
                     : std::make_shared<MemoryBudget>("RAM", "--ram", options_.ramBytes / kParts);
    thumbnails_ = std::make_unique<OfferThumbnails>(
        offers, options_.input, std::move(ram),
        [this, offers](std::size_t n, std::shared_ptr<const Thumbnail> thumbnail) {
            board_.tell([&](SessionNews& news) {
                if (news.offers == offers)
                    news.thumbnails[n] = std::move(thumbnail);
            });
            options_.news();
        });
    return true;
}

/// Makes a renderer of the open volume.
void SessionThread::makeRenderer(const Scene& scene, PlanDetail detail) {
    open_->makeRenderer(scene, detail);
    board_.tell([&](SessionNews& news) { news.savingRam = open_->savingRam; });
    damaged_ = 0; // each is reported once per renderer
    pace_.forget();
    resting_ = false;
    drawsMoving_ = false;
    quickFirst_ = true;
    hastySize_ = pace_.sizeFor(scene.imageSize);
}

/// Ends the planes' thread, before what it reads goes.
void SessionThread::dropSlices() {
    std::unique_ptr<SliceThread> last; // ends after the lock
    board_.tell([&](SessionNews& news) { last.swap(news.slices); });
}

} // namespace tessera
