// viewer/session/session_opening.cpp: the part of session_thread.h that opens another volume, and has another
// renderer made for a scene of which more has changed than one can be told.
#include "viewer/session/session_thread.h"

#include <exception>
#include <utility>

namespace tessera {

void SessionThread::openVolume(const SessionWishes::ToOpen& what) {
    const Cancellation asks(&openingCalledOff_);
    auto progress = std::make_shared<Progress>(Verbosity::quiet, true);
    board_.tell([&](SessionNews& news) { news.opening = progress; });
    try {
        std::unique_ptr<OpenVolume> next = OpenVolume::open(options_, what.path, what.pictureSize, progress);
        dropSlices(); // of the one before, which goes
        open_ = std::move(next);
        makeRenderer(Scene(open_->scene));
        std::shared_ptr<VolumeSeen> seen = open_->describe();
        std::unique_ptr<SliceThread> slices;
        if (open_->sliceRam.freeBytes() > 2 * SliceThread::floorBytes(seen->info, options_.threads))
            slices = std::make_unique<SliceThread>(*open_->store, open_->sliceRam, options_.threads,
                                                   options_.news);
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
    } catch (const Cancelled&) {
        board_.tell([](SessionNews& news) { news.opening.reset(); });
        throw;
    } catch (const std::exception& e) {
        const bool stays = open_ && open_->renderer && // what was open
                           board_.look([](const SessionNews& news) { return news.volume != nullptr; });
        if (!stays) { // not under the lock, which what ends with it takes
            dropSlices();
            open_.reset();
        }
        board_.tell([&](SessionNews& news) {
            news.opening.reset();
            if (stays) {
                news.state.kind = ViewingState::Kind::open;
                news.state.problem = e.what();
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

/// Of the open volume.
void SessionThread::makeRenderer(const Scene& scene) {
    open_->makeRenderer(scene);
    damaged_ = 0; // each is told once a renderer
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
