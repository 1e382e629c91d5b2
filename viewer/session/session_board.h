// viewer/session/session_board.h: the exchange between viewers of a volume and the thread that draws it,
// under one lock: requests one way, results the other.
#pragma once

#include "core/base/progress.h"
#include "viewer/session/slice_thread.h"
#include "viewer/session/viewing.h"

#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <glm/vec2.hpp>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

namespace tessera {

/// Requests to the thread. The latest of a kind counts.
struct SessionWishes {
    struct ToOpen {
        std::filesystem::path path;
        glm::ivec2 pictureSize{0};
        VolumePick pick = {};
    };
    struct ToShow {
        Scene scene;
        bool moving = false;
        std::uint64_t number = 0;
    };
    struct Question {
        glm::dvec2 place{0};
        std::uint64_t number = 0;
    };
    struct Line {
        LineWish wish;
        std::uint64_t number = 0;
    };
    struct Disc {
        Measurement circle;
        std::uint64_t number = 0;
    };
    struct Save {
        Scene scene;
        std::filesystem::path path;
        PictureMarks marks;
        PanelOfStills panel;
        std::uint64_t number = 0;
    };
    bool stop = false;
    std::optional<Save> save;
    std::optional<Disc> disc;
    std::optional<ToOpen> toOpen;
    std::optional<ToShow> toShow;
    std::optional<Question> question;
    bool stateAsked = false;
    std::optional<Line> line;
    bool lineCalledOff = false;
    std::optional<std::vector<Camera>> ahead;
    /// Of a still that is being drawn, by its number.
    struct Round {
        std::shared_ptr<ShownPicture> picture;
        std::uint64_t still = 0;
    };
    std::optional<Round> round;
    /// Numbers of a still, a line and a finer import whose threads have ended; 0: none.
    std::uint64_t stillEnded = 0, lineEnded = 0, finerEnded = 0;

    bool any() const {
        return stop || save || disc || toOpen || toShow || question || stateAsked || line || lineCalledOff ||
               ahead || round || stillEnded != 0 || lineEnded != 0 || finerEnded != 0;
    }
};

/// Results for viewers, and the numbers given so far.
struct SessionNews {
    std::shared_ptr<const VolumeSeen> volume;
    std::shared_ptr<const ShownPicture> picture;
    std::optional<PickedPlace> picked;
    std::optional<DiscValues> disc;
    ViewingState state;
    bool levelsShown = false; // state has the bricks' levels
    std::string notice;
    std::shared_ptr<Progress> opening;
    std::shared_ptr<const VolumeOffers> offers;
    std::vector<std::shared_ptr<const Thumbnail>> thumbnails; // of offers, as many
    LineState line;
    std::shared_ptr<Progress> lineProgress;  // while one is searched
    std::unique_ptr<SliceThread> slices;     // of what is open
    std::shared_ptr<MemoryBudget> savingRam; // for a picture that is saved as it is shown
    std::uint64_t wishes = 0, questions = 0, lines = 0, saves = 0;
    std::uint64_t saved = 0; // the last of saves that has ended, with a file or without
};

/// Functions passed in run under the lock: they only copy.
class SessionBoard {
  public:
    /// Calls change(SessionWishes&, SessionNews&), and wakes the thread.
    template <typename Change> void ask(const Change& change) {
        {
            const std::lock_guard lock(mutex_);
            change(wishes_, news_);
        }
        wake_.notify_all();
    }
    /// Calls change(SessionNews&).
    template <typename Change> void tell(const Change& change) {
        const std::lock_guard lock(mutex_);
        change(news_);
    }
    /// Returns get(const SessionNews&).
    template <typename Get> auto look(const Get& get) const {
        const std::lock_guard lock(mutex_);
        return get(news_);
    }
    /// For the thread: all requests since the last call.
    /// @param waiting  until there are any
    /// @param taken  called with them, before further requests
    template <typename Taken> SessionWishes take(bool waiting, const Taken& taken) {
        std::unique_lock lock(mutex_);
        if (waiting)
            wake_.wait(lock, [&] { return wishes_.any(); });
        taken();
        return std::exchange(wishes_, {});
    }

  private:
    mutable std::mutex mutex_; // of all that follows
    std::condition_variable wake_;
    SessionWishes wishes_;
    SessionNews news_;
};

} // namespace tessera
