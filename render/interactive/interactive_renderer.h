// render/interactive/interactive_renderer.h: pictures that follow one another. Camera and function move,
// bricks are loaded as they are needed, and the picture improves at rest. advance() does everything, and does
// what fits before a deadline. Only choosing levels and decoding have threads of their own.
//
// A brick is drawn as what the atlas has of it, its mean at worst, so every picture is whole. Between
// pictures a brick moves towards its chosen level (render/README.md, "The state machine of a brick").
#pragma once

#include "bricking/levels/level_chooser.h"
#include "core/base/work.h"
#include "core/image/image.h"
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
    int threads = 0;                                 // that decode and choose; 0: all processors
    std::size_t uploadBytes = std::size_t{16} << 20; // of bricks that move between two pictures, at most
    double dispatchMs = 20;                          // that a dispatch aims at
    /// Share of the atlas that is kept free, so that bricks can move without making room first. With 0, a
    /// first view or a new transfer function gets the levels of renderScene() with as many pages. After a
    /// camera move alone, visibility from earlier pictures also counts where memory is short.
    double spareShare = 1.0 / 16;
    /// That a first picture waits for coarse levels, and one of all pixels after one of few, lest it be one
    /// of the bricks' means.
    std::chrono::milliseconds firstPatience{2000};
    bool counting = false; // work counters
    /// Light of voxels is coarse at first, and made finer while nothing else is to be done; else every
    /// picture waits for all of it. What it comes to is the same.
    bool coarseLightFirst = true;
};

class InteractiveRenderer {
  public:
    using Clock = std::chrono::steady_clock;

    /// Store, engine and budgets must outlive this; the engine holds its bricks itself (Engine::bricks()).
    /// Quality's maxError is left out of account: what fits at once is drawn.
    /// Throws InputError for budgets below the scene's floor.
    InteractiveRenderer(const Scene& scene, const StoreReader& store, Engine& engine, MemoryBudget& ram,
                        MemoryBudget& gpu, const InteractiveOptions& options = {});
    ~InteractiveRenderer();

    /// From the next picture on. The one in the works goes on to its end, so that pictures also come while
    /// the camera moves; cancel() drops it.
    void setCamera(const Camera& camera);
    void setFunction(const TransferFunction& function);
    /// The camera of such a view of what is shown, as a plan has it, for setCamera(); none where what is free
    /// of the RAM is too little to find it. Drops the picture in the works where a function waits
    /// for its end.
    std::optional<Camera> fitted(const FittedView& view);
    /// Of modes that show single values.
    void setWindow(const WindowChoice& window);
    /// Lights, and what answers to them. False where that takes another renderer, and nothing is changed:
    /// other planes of light, more memory, or shading that comes, goes or takes other gradients.
    bool setLight(const Lighting& lighting, const Shading& shading);
    /// What is cut away. Drops the picture in the works. Not where the engine compiles what it draws
    /// (checked). Throws InputError for cuts that are none.
    void setCuts(const Cuts& cuts);
    void cancel();
    /// How pictures are drawn while something moves: fewer pixels, longer segments; and levels are chosen
    /// anew only a fifth of the time, because choosing takes processors from drawing.
    struct Haste {
        glm::ivec2 imageSize{0}; // at most the scene's along each axis, at least 1
        double stepVoxels = 0.5; // as Quality's
        bool operator==(const Haste&) const = default;
    };
    /// From the next picture on; none: as the scene says.
    void setHaste(const std::optional<Haste>& haste);
    /// Where the camera will be next, in order: their bricks are loaded into the cache when there is nothing
    /// else to load.
    void setPath(std::vector<Camera> next);

    struct Progress {
        bool newPicture = false;    // one came to its end in this call
        bool converged = false;     // it is the last until something is changed
        std::size_t movesLeft = 0;  // of bricks that are not at their levels yet
        bool lightIsCoarse = false; // light of voxels is not yet what it will be
        bool choosing = false;
    };
    /// Chooses, requests, uploads and marches what fits before the deadline, one dispatch at least; one that
    /// has begun ends.
    /// Throws what decoding or choosing threw; a chunk that cannot be read is told of once, its bricks stay
    /// as coarse as they are, and calls may go on.
    Progress advance(Clock::time_point deadline);
    /// The last whole picture: linear, premultiplied, on nothing. Empty before the first.
    const Image& picture() const { return picture_; }

    /// From the last picture's begin to its end, milliseconds.
    double pictureMs() const { return std::chrono::duration<double, std::milli>(pictureTook_).count(); }
    /// As it was set; a camera by side spelled out.
    const Camera& camera() const { return p_.view.camera; }
    const Layer& volume() const { return p_.layer(); }
    const DrawnPart& part() const { return p_.view.part; }

    /// For reports and tests.
    const Selection& resident() const { return p_.layer().selection; }
    const std::optional<Selection>& wanted() const { return wanted_; }
    const PredictedError& predictedError() const { return predicted_; } // of what is wanted
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
        bool predicted = false;           // false: no memory for it; one level for all
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

    Scene scene_;
    Engine& engine_;
    MemoryBudget &ram_, &gpu_;
    InteractiveOptions options_;
    const bool mapsAlways_; // levels, also where all bricks have one
    Planner p_;             // its selection is what is resident
    Charge charge_;
    std::size_t pages_ = 0, chosenPages_ = 0;
    std::unique_ptr<LevelChooser> chooser_;
    Charge raysReserve_; // for bricks that another function may show
    std::unique_ptr<RayCaster> caster_;
    std::unique_ptr<VisibilityCounter> counter_;

    std::optional<Selection> wanted_;
    PredictedError predicted_;
    std::vector<float> gain_, visible_;                 // per brick; visible_: empty before it was counted
    std::vector<float> likely_;                         // the same, as levels were chosen by
    std::vector<Move> moves_;                           // most urgent first
    std::unordered_set<ChunkKey, ChunkKeyHash> failed_; // chunks that cannot be read
    std::vector<Camera> path_;
    std::vector<ChunkKey> ahead_; // chunks of the path's next camera
    std::size_t lookedAhead_ = 0; // cameras of the path whose chunks are known
    std::future<Choice> choosing_;
    bool predicts_ = false;    // the chooser knows the function's errors
    std::size_t mostRays_ = 0; // bytes that more bricks can take of it
    bool forPath_ = false;     // what is being chosen
    int countsLeft_ = 1;       // times that levels are chosen again by what was seen
    bool direct_ = false;      // bricks skip the coarse level: the atlas was packed anew
    std::optional<TransferFunction> nextFunction_;
    std::optional<Haste> haste_;
    Clock::time_point choosingBegan_, chosenAt_; // levels, the last time

    bool drawing_ = false, counting_ = false; // a picture; what is seen
    bool refined_ = false;                    // the distance map, for the bricks as they are
    // What is new: since levels were last chosen; since the last picture began; and not yet mapped, or not
    // yet where rays read it.
    Changes forChoice_{kCameraChanged}, forPicture_{kCameraChanged | kLevelsChanged},
        forDevice_{kLevelsChanged};
    Clock::time_point lastPicture_ = Clock::now(), pictureBegan_;
    Clock::duration pictureTook_{};
    Image picture_;
    Work work_;
    std::size_t repacks_ = 0;
};

} // namespace tessera
