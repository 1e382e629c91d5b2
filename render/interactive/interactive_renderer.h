// render/interactive/interactive_renderer.h: interactive pictures. Camera and function change, bricks are
// loaded on demand, and the picture improves at rest. advance() does all work that fits before a deadline.
// Only choosing levels and decoding have threads of their own.
//
// A brick is drawn at the level that the atlas has, at worst as its mean, so every picture is complete.
// Between pictures a brick moves towards its chosen level (render/README.md, "The state machine of a brick").
#pragma once

#include "bricking/levels/level_chooser.h"
#include "core/base/work.h"
#include "core/image/image.h"
#include "render/engine.h"
#include "render/plan/planner.h"
#include "render/residency/transition.h"

#include <chrono>
#include <exception>
#include <future>
#include <memory>
#include <optional>
#include <unordered_set>
#include <vector>

namespace tessera {

constexpr int kMean = kLevelCount - 1; // the level at which a brick is one value

struct InteractiveOptions {
    int threads = 0;                                 // that decode and choose; 0: all processors
    std::size_t uploadBytes = std::size_t{16} << 20; // largest amount of bricks moved between two pictures
    double dispatchMs = 20;                          // target time of a dispatch
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
};

class InteractiveRenderer {
  public:
    using Clock = std::chrono::steady_clock;

    /// Store, engine and budgets must outlive this; the engine holds its bricks itself (Engine::bricks()).
    /// Quality's maxError is ignored: pictures take one pass. Throws InputError for budgets below the scene's
    /// minimum.
    InteractiveRenderer(const Scene& scene, const StoreReader& store, Engine& engine, MemoryBudget& ram,
                        MemoryBudget& gpu, const InteractiveOptions& options = {});
    ~InteractiveRenderer();

    /// From the next picture on. The current one is finished, so that there are pictures while the camera
    /// moves; cancel() drops it.
    void setCamera(const Camera& camera);
    void setFunction(const TransferFunction& function);
    /// The camera fitted to a view, as by a plan, for setCamera(); none if the free RAM is too small to find
    /// it. Drops the current picture if a function waits for its end.
    std::optional<Camera> fitted(const FittedView& view);
    /// Sets the window of modes that show single values.
    void setWindow(const WindowChoice& window);
    /// Sets lights and material response. Returns false, without a change, if another renderer is needed: for
    /// other light planes, more memory, shading switched on or off, or another gradient operator.
    bool setLight(const Lighting& lighting, const Shading& shading);
    /// Sets the cuts, and drops the current picture. Not for engines that compile cuts (checked). Throws
    /// InputError for invalid cuts.
    void setCuts(const Cuts& cuts);
    void cancel();
    /// Pictures during motion: fewer pixels, longer segments. Levels are then chosen for at most a fifth of
    /// the time, because choosing takes processors from drawing.
    struct Haste {
        glm::ivec2 imageSize{0}; // at most the scene's along each axis, at least 1
        double stepVoxels = 0.5; // as Quality's
        bool operator==(const Haste&) const = default;
    };
    /// From the next picture on; none: the scene's.
    void setHaste(const std::optional<Haste>& haste);
    /// The next cameras, in order: their bricks are loaded into the cache in idle time.
    void setPath(std::vector<Camera> next);

    struct Progress {
        bool newPicture = false;    // a picture was finished in this call
        bool converged = false;     // it is final until something changes
        std::size_t movesLeft = 0;  // bricks that are not at their levels yet
        bool lightIsCoarse = false; // light per voxel is not final yet
        bool choosing = false;
    };
    /// Chooses, requests, uploads and casts rays as fits before the deadline, at least one dispatch, which
    /// may exceed it. Throws what decoding or choosing threw. An unreadable chunk throws once; its bricks
    /// keep their level, and calls may continue.
    Progress advance(Clock::time_point deadline);
    /// The last finished picture: linear, premultiplied, without background. Empty before the first.
    const Image& picture() const { return picture_; }

    /// Time of the last picture, milliseconds.
    double pictureMs() const { return std::chrono::duration<double, std::milli>(pictureTook_).count(); }
    /// As set, with a resolved camera.
    const Camera& camera() const { return p_.view.camera; }
    const Layer& volume() const { return p_.layer(); }
    const DrawnPart& part() const { return p_.view.part; }
    /// Those that are drawn, with their shapes.
    const std::vector<SceneMesh>& meshes() const { return p_.view.meshes; }
    /// The surfaces of meshes along a ray, front to back, up to the first opaque one.
    /// @param imageSize, place  of the ray on a picture of this size; pixels
    struct MeshSurface {
        glm::dvec3 voxel{0};
        const SceneMesh* mesh = nullptr; // of the plan
    };
    std::vector<MeshSurface> meshesAlong(const glm::ivec2& imageSize, const glm::dvec2& place) const;

    /// For reports and tests.
    const Selection& resident() const { return p_.layer().selection; }
    const std::optional<Selection>& wanted() const { return wanted_; }
    const PredictedError& predictedError() const { return predicted_; } // of the wanted selection
    std::size_t atlasPages() const { return pages_; }
    const BrickResidency& bricks() const { return *engine_.bricks(); }
    const Work& work() const { return work_; }
    BrickCache::Counters cacheCounters() const { return p_.layer().cache->counters(); }
    std::size_t repacks() const { return repacks_; }

  private:
    struct Request;
    struct Choice {
        Selection selection;
        PredictedError error;
        std::vector<float> gain, visible; // per brick
        bool predicted = false;           // false: no memory for a choice; one level for all
    };
    static Choice choose(LevelChooser* chooser, const Request& request);

    void startChoosing(const Camera& camera, std::vector<float> visible);
    void finishChoosing();
    void chooseWhatIsNew();
    void reserveForRays();
    void applyFunction();
    void plan();
    void moveBricks();
    void makeRoom(const Move& blocked);
    void drop(std::size_t brick);
    void setLevel(std::size_t brick, std::uint8_t level);
    void wantChunks();
    void lookAhead(const Choice& choice);
    int coarseLevel() const;
    void countVisibility(Clock::time_point deadline);
    Slicing slicing() const;
    void mapResident();
    void beginPicture();
    bool mayChoose() const;
    bool meansArePending() const;
    bool pictureIsDue() const;
    bool settled() const;
    bool lightIsWhole() const;
    void refineLight(Clock::time_point deadline);
    void layLabelsOver();

    Scene scene_;
    Engine& engine_;
    MemoryBudget &ram_, &gpu_;
    InteractiveOptions options_;
    const bool mapsAlways_; // levels, also if all bricks have the same
    Planner p_;             // its selection is the resident one
    Charge charge_;
    std::size_t pages_ = 0, chosenPages_ = 0;
    std::unique_ptr<LevelChooser> chooser_;
    Charge raysReserve_; // for bricks visible under another function
    std::unique_ptr<RayCaster> caster_;
    std::unique_ptr<VisibilityCounter> counter_;

    std::optional<Selection> wanted_;
    PredictedError predicted_;
    std::vector<float> gain_, visible_;                 // per brick; visible_: empty before the first count
    std::vector<float> likely_;                         // the same, at the last choice of levels
    std::vector<Move> moves_;                           // most urgent first
    std::unordered_set<ChunkKey, ChunkKeyHash> failed_; // unreadable chunks
    std::vector<Camera> path_;
    std::vector<ChunkKey> ahead_; // chunks of the path's next camera
    std::size_t lookedAhead_ = 0; // cameras of the path whose chunks are known
    std::future<Choice> choosing_;
    bool predicts_ = false;    // the chooser knows the function's errors
    std::size_t mostRays_ = 0; // bytes for more bricks
    bool forPath_ = false;     // the choice in progress
    int countsLeft_ = 1;       // remaining choices by counted visibility
    bool direct_ = false;      // bricks skip the coarse level: the atlas was repacked
    std::optional<TransferFunction> nextFunction_;
    std::optional<Haste> haste_;
    Clock::time_point choosingBegan_, chosenAt_; // levels, the last time

    bool drawing_ = false, counting_ = false; // a picture; visibility
    bool refined_ = false;                    // the distance map, for the current bricks
    // Changes since the last choice of levels; since the last picture began; not yet mapped or uploaded.
    Changes forChoice_{kCameraChanged}, forPicture_{kCameraChanged | kLevelsChanged},
        forDevice_{kLevelsChanged};
    Clock::time_point lastPicture_ = Clock::now(), pictureBegan_;
    Clock::duration pictureTook_{};
    Image picture_;
    Camera pictureCamera_;          // of the picture that is drawn
    std::exception_ptr labelFault_; // labels of the last picture that could not be read
    Work work_;
    std::size_t repacks_ = 0;
};

} // namespace tessera
