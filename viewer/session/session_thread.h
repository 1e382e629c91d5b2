// viewer/session/session_thread.h: the thread that draws the requests of a session's board. It owns
// everything that is open; results are copied to the board.
#pragma once

#include "core/base/interrupt.h"
#include "render/interactive/interactive_renderer.h"
#include "viewer/session/frame_pace.h"
#include "viewer/session/open_volume.h"
#include "viewer/session/session_board.h"
#include "viewer/session/view_session.h"
#include "viewer/session/volume_offers.h"

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <thread>

namespace tessera {

class SessionThread {
  public:
    /// Begins. board outlives this.
    SessionThread(const ViewSessionOptions& options, SessionBoard& board);
    /// Ends it, and cancels opening and drawing.
    ~SessionThread();
    SessionThread(const SessionThread&) = delete;
    SessionThread& operator=(const SessionThread&) = delete;
    /// Path being opened, if any. From any thread.
    void callOffOpening() { openingCalledOff_ = true; }

  private:
    // session_thread.cpp: its loop, from requests to pictures
    void run();
    void turn(SessionWishes& wishes);
    void take(const SessionWishes::ToShow& wish);
    void aim(const Scene& scene);
    void answerAsBefore(std::uint64_t before);
    void answer(const SessionWishes::Question& question);
    void answer(const SessionWishes::Disc& question);
    void proceed();
    void publishPicture(const InteractiveRenderer::Progress& progress);
    void prepareDisplay(ShownPicture& picture) const;
    void nothingMoreComes();
    void tellState(const InteractiveRenderer::Progress& progress);
    void giveUp(const std::string& problem);
    // session_opening.cpp: another volume, another renderer
    void openVolume(const SessionWishes::ToOpen& what);
    void show(std::unique_ptr<OpenVolume> next);
    void startFiner(const SessionWishes::ToOpen& what, const InputOptions& input);
    void changeOver();
    bool offerChoice(const SessionWishes::ToOpen& what, const std::string& why);
    bool openLabels(const SessionWishes::ToOpen& what, const std::shared_ptr<Progress>& progress,
                    bool isEither, std::string& why);
    void makeRenderer(const Scene& scene, PlanDetail detail = PlanDetail::whole);
    void dropSlices();
    // session_beside.cpp: work on other threads while pictures rest
    void drawStill(const Scene& scene);
    void startStill();
    void showRound(const SessionWishes::Round& round);
    void finishStill();
    void startSaving(SessionWishes::Save& save);
    void dropSaving();
    /// The request to save has ended.
    void tellSaved(std::uint64_t number);
    void finishSaving();
    void startLine(const SessionWishes::Line& line);
    void finishLine();

    const ViewSessionOptions options_;
    SessionBoard& board_;

    std::unique_ptr<OpenVolume> open_;
    std::uint64_t asked_ = 0;   // the request that is being drawn
    std::uint64_t refused_ = 0; // the last request that cannot be drawn
    bool moving_ = false, resting_ = true;
    bool quickFirst_ = false;       // something changed: one picture of few pixels before one of all
    bool drawsMoving_ = false;      // the current picture has few pixels
    std::uint64_t stillNumber_ = 0; // of the last still begun
    bool stillBegun_ = false;       // of the current scene
    struct Saving {
        std::filesystem::path path;
        PictureMarks marks;
        PanelOfStills panel;
        std::uint64_t number = 0;
    };
    std::optional<Saving> saving_;           // target of the still being drawn; none: the window
    PanelOfStills waiting_;                  // that was drawn; other panels of its figure are awaited
    std::uint64_t lineNumber_ = 0;           // of the line being searched
    std::uint64_t finerNumber_ = 0;          // of the last finer import begun,
    SessionWishes::ToOpen finerOf_;          // for this
    InputOptions finerInput_;                // opened by these
    InteractiveRenderer::Progress progress_; // the last
    std::string measured_;                   // of the still of asked_
    std::size_t damaged_ = 0;                // chunks that could not be read
    FramePace pace_;
    glm::ivec2 hastySize_{1}; // of interactive pictures

    std::unique_ptr<OfferThumbnails> thumbnails_; // while the user may choose

    Cancellation::Flag openingCalledOff_{false};
    std::thread thread_; // last: it uses all of the above
};

} // namespace tessera
