// viewer/session/session_beside.cpp: the part of session_thread.h that has stills drawn and lines looked for,
// on threads of their own. One of the two at a time: they have one share of the memory.
#include "viewer/session/session_thread.h"

#include "core/base/error.h"
#include "render/contract/ray_state.h" // rayCount
#include "viewer/cli/input/further_volumes.h"
#include "viewer/cli/input/mesh_input.h"
#include "viewer/session/shown_picture.h"

#include <algorithm>
#include <glm/vec2.hpp>
#include <glm/vec4.hpp>
#include <string>
#include <utility>
#include <vector>

namespace tessera {

void SessionThread::drawStill(const Scene& scene) {
    OpenVolume& o = *open_;
    RenderOptions render;
    render.engine = options_.engine;
    render.device = options_.device;
    render.threads = options_.threads;
    render.searching = render.checking = true;
    render.verify = Verify::quick;
    ++stillNumber_;
    Scene drawn = asStill(scene);
    adoptShapes(o.renderer->meshes(), drawn);
    Still::Round round;
    if (!saving_)
        round = [this, number = stillNumber_](std::shared_ptr<ShownPicture> picture) {
            board_.ask([&](SessionWishes& wishes, SessionNews&) { wishes.round = {picture, number}; });
        };
    o.still = std::make_unique<Still>(
        drawn, asked_, storesOf(*o.store, o.further), o.stillRam, o.stillGpu, render,
        [this, number = stillNumber_] {
            board_.ask([&](SessionWishes& wishes, SessionNews&) { wishes.stillEnded = number; });
        },
        std::move(round));
}

void SessionThread::startStill() {
    stillBegun_ = true;
    drawStill(open_->scene);
}

/// A picture of the still before its end, unless it is of another scene by now, or a later one is there.
void SessionThread::showRound(const SessionWishes::Round& round) {
    if (!open_ || !open_->still || open_->still->isCalledOff() || round.still != stillNumber_)
        return;
    prepareDisplay(*round.picture);
    round.picture->asked = asked_;
    board_.tell([&](SessionNews& news) {
        news.picture = round.picture;
        ++news.state.pictures;
    });
}

void SessionThread::startSaving(SessionWishes::Save& save) {
    if (!open_ || save.scene.volumes.front().path != open_->scene.volumes.front().path) {
        tellSaved(save.number); // for the previous volume
        return;
    }
    if (!open_->stills || open_->line) {
        board_.tell([&](SessionNews& news) {
            news.saved = save.number;
            news.state.problem = open_->line
                                     ? "cannot save a picture of that size during the search for a line"
                                     : "cannot save a picture of that size: --ram is too small for a "
                                       "still of this volume";
        });
        return;
    }
    if (open_->still && !saving_)
        stillBegun_ = false; // it is begun again afterwards
    open_->still.reset();
    dropSaving();
    saving_ = Saving{save.path, save.marks, std::move(save.panel), save.number};
    drawStill(save.scene);
    board_.tell([](SessionNews& news) { news.state.atRest = false; });
}

void SessionThread::tellSaved(std::uint64_t number) {
    board_.tell([&](SessionNews& news) { news.saved = std::max(news.saved, number); });
}

/// Gives up what is being saved: what holds its memory may go.
void SessionThread::dropSaving() {
    if (saving_)
        tellSaved(saving_->number);
    saving_.reset();
    waiting_ = {};
}

void SessionThread::finishSaving() {
    FinishedStill finished = open_->still->take();
    open_->still.reset();
    Saving to = *std::exchange(saving_, {});
    std::string problem = finished.problem;
    bool wrote = false;
    if (finished.picture)
        try {
            MemoryBudget& ram = open_->stillRam;
            const glm::ivec2 size = finished.picture->image.size;
            Charge charge = ram.charge(sizeof(glm::vec4) * rayCount(size), "the still");
            const auto write = [&](const std::vector<SavedPanel>& panels) {
                savePictures(to.path, panels, ram);
                wrote = true;
            };
            if (SavedPanel panel{finished.picture, to.marks}; !to.panel)
                write({panel});
            else if (!to.panel.put(std::move(panel), std::move(charge), write))
                waiting_ = std::move(to.panel);
        } catch (const Error& e) {
            problem = e.what();
        }
    resting_ = false;
    board_.tell([&](SessionNews& news) {
        news.saved = std::max(news.saved, to.number);
        if (!problem.empty())
            news.state.problem = problem;
        else if (wrote)
            news.notice = "wrote the picture " + to.path.string();
    });
}

void SessionThread::finishStill() {
    if (saving_) {
        finishSaving();
        return;
    }
    OpenVolume& o = *open_;
    FinishedStill finished = o.still->take();
    o.still.reset();
    if (finished.picture)
        prepareDisplay(*finished.picture);
    board_.tell([&](SessionNews& news) {
        if (finished.picture && stillBegun_) {
            finished.picture->asked = asked_;
            news.picture = finished.picture;
            ++news.state.pictures;
            news.state.measured = measured_ = finished.measured;
            news.state.drawingStill = false;
            news.state.atRest = true;
        } else if (!finished.problem.empty()) {
            news.state.problem = finished.problem;
            news.state.drawingStill = false;
            news.state.atRest = true;
        } else {
            resting_ = false; // cancelled: the request that cancelled it gets a still of its own
        }
    });
}

void SessionThread::startLine(const SessionWishes::Line& line) {
    if (!open_) {
        board_.tell([&](SessionNews& news) {
            news.line = {};
            news.line.number = line.number;
        });
        return;
    }
    OpenVolume& o = *open_;
    o.line.reset();
    if (o.still) { // the search for a line takes over its memory
        o.still.reset();
        dropSaving();
        stillBegun_ = false;
    }
    lineNumber_ = line.number;
    o.line = std::make_unique<LineFinder>(
        line.wish, *o.store, o.stillRam, options_.threads, [this, number = line.number] {
            board_.ask([&](SessionWishes& wishes, SessionNews&) { wishes.lineEnded = number; });
        });
    board_.tell([&](SessionNews& news) { news.lineProgress = o.line->progress(); });
}

void SessionThread::finishLine() {
    OpenVolume& o = *open_;
    LineState found = o.line->take();
    o.line.reset();
    found.number = lineNumber_;
    resting_ = false; // a still may follow
    board_.tell([&](SessionNews& news) {
        news.line = std::move(found);
        news.lineProgress.reset();
        if (news.lines != lineNumber_) // another line was requested meanwhile
            news.line.searching = true;
    });
}

} // namespace tessera
