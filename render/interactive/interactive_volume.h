// render/interactive/interactive_volume.h: InteractiveVolume: a volume of interactive pictures. It chooses
// the levels of its bricks for each view and function, on another thread, and moves the bricks there in its
// share of the memory. Pictures are InteractiveRenderer's.
//
// A brick is drawn at the level that the atlas has, at worst as its mean. Between pictures it moves towards
// its chosen level (render/README.md, "The state machine of a brick").
#pragma once

#include "bricking/levels/level_chooser.h"
#include "core/base/work.h"
#include "render/engine.h"
#include "render/plan/planner.h"
#include "render/residency/transition.h"

#include <chrono>
#include <future>
#include <memory>
#include <optional>
#include <unordered_set>
#include <vector>

namespace tessera {

constexpr int kMean = kLevelCount - 1; // the level at which a brick is one value

struct InteractiveOptions {
    int threads = 0; // that decode and choose; 0: all processors
    std::size_t uploadBytes = std::size_t{16}
                              << 20; // largest amount of a volume's bricks moved between two pictures
    double dispatchMs = 20;          // target time of a dispatch
    /// Share of the atlas that stays free, so that bricks can move without evictions first. With 0, a first
    /// view or a new transfer function gets the levels of renderScene() with as many pages. After a camera
    /// move alone, visibility from earlier pictures also counts if memory is scarce.
    double spareShare = 1.0 / 16;
    /// Time that a first picture waits for coarse levels, as does one of all pixels after one of few, so that
    /// it does not show bricks as means.
    std::chrono::milliseconds firstPatience{2000};
    bool counting = false; // work counters
    /// Light per voxel is coarse at first, and refined in idle time; else every picture waits for all of it.
    /// The final light is the same.
    bool coarseLightFirst = true;
    /// Only what few bytes tell is read (PlanDetail::coarse), where the scene allows it: pictures have one
    /// coarse level, until another renderer takes this one's place. Of one volume.
    bool coarse = false;
    /// The first volume is drawn alone, all its labels with its own function.
    bool firstAlone = false;
};

class InteractiveVolume {
  public:
    using Clock = RayCaster::Clock;

    /// Plans the memory and charges it; nothing is resident. Everything outlives this.
    /// @param scene       of this volume alone, as asDrawn() has it
    /// @param plan        its plan, without levels
    /// @param opacities   pictures show the function's opacities as greys, in place of its colours
    /// @param mapsAlways  levels, also if all bricks have the same
    /// Throws InputError naming the least gpu.
    InteractiveVolume(const Scene& scene, Planner& plan, MemoryBudget& ram, MemoryBudget& gpu,
                      const TextureLimits& engineLimits, const InteractiveOptions& options, bool opacities,
                      bool mapsAlways);
    ~InteractiveVolume();
    InteractiveVolume(const InteractiveVolume&) = delete;
    InteractiveVolume& operator=(const InteractiveVolume&) = delete;
    /// Opens the plan on an engine.
    /// @param alone  the scene has no other volume: light is coarse at first, if options say so
    void open(Engine& engine, bool alone);

    const Planner& plan() const { return p_; }
    Planner& plan() { return p_; }
    Engine& engine() const { return *engine_; }
    LightPlane* light() const { return engine_->light(); }
    bool lightIsWhole() const { return !light() || light()->isWhole(); }

    // Changes. Those of function and window wait for applyFunction().

    void setCamera(const Camera& camera);
    void setFunction(const TransferFunction& function);
    void setOpacity(double opacity);
    void setWindow(const WindowChoice& window);
    /// Lights and shading of a scene, which the plan takes (checked).
    void setLight(const Scene& scene);
    void forgetPath();
    bool waitsForFunction() const { return nextFunction_.has_value(); }

    // The steps of an idle moment. Threads that decode and choose throw through them.

    void applyFunction();
    /// Chooses levels for the current view or, when all bricks are at theirs, for the next camera of the
    /// path.
    /// @param hasty  during motion, choosing takes at most a fifth of the time
    void choose(const std::vector<Camera>& path, bool hasty);
    void moveBricks(Work& work);
    void countVisibility(const Slicing& slicing, Clock::time_point deadline, bool hasty);
    bool isCounting() const { return counting_; }
    /// Waits a little for a choice or a chunk.
    void waitUntil(Clock::time_point soon) const;
    bool isChoosing() const { return choosing_.valid(); }

    // Before a picture

    /// Maps the levels that have changed, and aims the rays; the picture that begins has all changes.
    /// Returns whether the map of empty space is another since the last call.
    bool beginPicture();
    /// Of what is drawn, since the last picture began.
    bool changed(std::uint32_t changes) const { return forPicture_.any(changes); }
    bool levelsAreNew() const { return forDevice_.any(kLevelsChanged) || changed(kLevelsChanged); }

    /// Some bricks drawn as means are still loading.
    bool meansArePending() const;
    /// Nothing remains to be done until something changes.
    bool settled(const std::vector<Camera>& path) const;

    const Selection& resident() const { return p_.layer().selection; }
    const std::optional<Selection>& wanted() const { return wanted_; }
    const PredictedError& predictedError() const { return predicted_; } // of the wanted selection
    const std::vector<float>& likely() const { return likely_; }
    const std::vector<Move>& moves() const { return moves_; }
    std::size_t pages() const { return pages_; }
    std::size_t repacks() const { return repacks_; }

  private:
    struct Request;
    struct Choice {
        Selection selection;
        PredictedError error;
        std::vector<float> gain, visible; // per brick
        bool predicted = false;           // false: no memory for a choice; one level for all
    };
    static Choice choiceOf(LevelChooser* chooser, const Request& request);

    void startChoosing(const Camera& camera, std::vector<float> visible);
    void finishChoosing(bool hasty);
    bool mayChoose(bool hasty) const;
    void reserveForRays();
    void mapResident();
    // interactive_bricks.cpp
    void planMoves();
    void makeRoom(const Move& blocked);
    void drop(std::size_t brick);
    void setLevel(std::size_t brick, std::uint8_t level);
    void wantChunks();
    void lookAhead(const Choice& choice);
    int coarseLevel() const;

    Scene scene_;
    MemoryBudget &ram_, &gpu_;
    const InteractiveOptions& options_;
    const bool opacities_, mapsAlways_;
    Planner& p_; // its selection is the resident one
    Engine* engine_ = nullptr;
    Charge charge_;
    std::size_t pages_ = 0, chosenPages_ = 0;
    std::unique_ptr<LevelChooser> chooser_;
    Charge raysReserve_; // for bricks visible under another function
    std::unique_ptr<VisibilityCounter> counter_;

    std::optional<Selection> wanted_;
    PredictedError predicted_;
    std::vector<float> gain_, visible_;                 // per brick; visible_: empty before the first count
    std::vector<float> likely_;                         // the same, at the last choice of levels
    std::vector<Move> moves_;                           // most urgent first
    std::unordered_set<ChunkKey, ChunkKeyHash> failed_; // unreadable chunks
    std::vector<ChunkKey> ahead_;                       // chunks of the path's next camera
    std::size_t lookedAhead_ = 0;                       // cameras of the path whose chunks are known
    std::future<Choice> choosing_;
    bool predicts_ = false;    // the chooser knows the function's errors
    std::size_t mostRays_ = 0; // bytes for more bricks
    bool forPath_ = false;     // the choice in progress
    int countsLeft_ = 1;       // remaining choices by counted visibility
    bool direct_ = false;      // bricks skip the coarse level: the atlas was repacked
    bool counting_ = false;    // visibility
    std::optional<TransferFunction> nextFunction_;
    Clock::time_point choosingBegan_, chosenAt_; // levels, the last time
    // Changes since the last choice of levels; since the last picture began; not yet mapped or uploaded.
    Changes forChoice_{kCameraChanged}, forPicture_{kLevelsChanged}, forDevice_{kLevelsChanged};
    std::size_t repacks_ = 0;
};

} // namespace tessera
