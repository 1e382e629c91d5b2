// render/interactive/interactive_renderer.h: interactive pictures of a scene, of all its volumes. Camera and
// functions change, bricks are loaded on demand, and the picture improves at rest. advance() does all work
// that fits before a deadline. Only choosing levels and decoding have threads of their own.
//
// Every volume has its levels and its share of the budgets (interactive_volume.h), so every picture is
// complete. Modes of single values draw each volume by rays of its own, and put their pictures over one
// another (docs/sampling.md, "Several volumes").
#pragma once

#include "core/base/work.h"
#include "core/image/image.h"
#include "render/engine.h"
#include "render/interactive/interactive_volume.h"
#include "render/plan/label_optics.h"
#include "render/plan/planner.h"

#include <chrono>
#include <exception>
#include <memory>
#include <optional>
#include <vector>

namespace tessera {

/// A scene as interactive pictures have it: lit without paths of light, which take too long.
Scene withoutPaths(Scene scene);

class InteractiveRenderer {
  public:
    using Clock = std::chrono::steady_clock;

    /// Stores, engine and budgets must outlive this; the engine holds its bricks itself (Engine::bricks()).
    /// Quality's maxError is ignored: pictures take one pass.
    /// @param stores  of the scene's volumes, in order
    /// Throws InputError for budgets below the scene's minimum, and for scenes of several volumes that no
    /// picture has (sceneInFusion()).
    InteractiveRenderer(const Scene& scene, Stores stores, Engine& engine, MemoryBudget& ram,
                        MemoryBudget& gpu, const InteractiveOptions& options = {});
    /// Of a scene of one volume.
    InteractiveRenderer(const Scene& scene, const StoreReader& store, Engine& engine, MemoryBudget& ram,
                        MemoryBudget& gpu, const InteractiveOptions& options = {});
    ~InteractiveRenderer();

    /// From the next picture on. The current one is finished, so that there are pictures while the camera
    /// moves; cancel() drops it.
    void setCamera(const Camera& camera);
    /// Of a volume of the scene, if it is drawn. Labels with functions of their own keep these.
    void setFunction(const TransferFunction& function, std::size_t volume = 0);
    /// Of a volume of the scene (SceneVolume::opacity).
    void setOpacity(double opacity, std::size_t volume);
    /// The camera fitted to a view of all volumes, as by a plan, for setCamera(); none if the free RAM is too
    /// small to find it. Drops the current picture if a function waits for its end.
    std::optional<Camera> fitted(const FittedView& view);
    /// Sets the window of modes that show single values, of volumes without one of their own.
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

    /// As InteractiveOptions::coarse asked for.
    bool isCoarse() const { return p_.isCoarse; }
    /// Time of the last picture, milliseconds.
    double pictureMs() const { return std::chrono::duration<double, std::milli>(pictureTook_).count(); }
    /// As set, with a resolved camera.
    const Camera& camera() const { return p_.view.camera; }
    /// Volumes of the scene that are drawn: all, or the first alone.
    std::size_t sceneVolumes() const { return scene_.volumes.size(); }
    /// Of one of these, by its number.
    ValueSummary valuesOf(std::size_t number) const;
    /// A function of its own or by name.
    TransferFunction functionOf(const TransferChoice& choice, std::size_t number) const;
    const Layer& volume(std::size_t number = 0) const { return volumes_[number]->plan().layer(); }
    const DrawnPart& part() const { return p_.view.part; }
    /// Those that are drawn, with their shapes.
    const std::vector<SceneMesh>& meshes() const { return p_.view.meshes; }
    /// The surfaces of meshes along a ray, front to back, up to the first opaque one.
    /// @param imageSize, place  of the ray on a picture of this size; pixels
    struct MeshSurface {
        glm::dvec3 voxel{0};             // of the first volume
        const SceneMesh* mesh = nullptr; // of the plan
    };
    std::vector<MeshSurface> meshesAlong(const glm::ivec2& imageSize, const glm::dvec2& place) const;

    // For reports and tests. Volumes that are drawn: those of the scene, then others of the same voxels,
    // which labels and opacities ask for.

    std::size_t drawnVolumes() const { return volumes_.size(); }
    const InteractiveVolume& drawn(std::size_t number) const { return *volumes_[number]; }
    const Selection& resident() const { return volumes_.front()->resident(); }
    const std::optional<Selection>& wanted() const { return volumes_.front()->wanted(); }
    const PredictedError& predictedError() const { return volumes_.front()->predictedError(); }
    std::size_t atlasPages() const { return volumes_.front()->pages(); }
    const BrickResidency& bricks() const { return *engine_.bricks(); }
    const Work& work() const { return work_; }
    BrickCache::Counters cacheCounters() const { return p_.layer().cache->counters(); }
    std::size_t repacks() const { return volumes_.front()->repacks(); }

  private:
    /// Rays of a picture, through one volume or all of them.
    struct Pass {
        std::unique_ptr<RayCaster> caster;
        InteractiveVolume* volume = nullptr; // with the plan of the rays
        Image image;                         // where there are others
    };
    Stores storesOfScene() const;
    void openVolumes();
    void close();
    void bringBricks(Clock::time_point deadline);
    Slicing slicing() const;
    void beginPicture();
    bool drawPasses(Clock::time_point deadline);
    void composePicture();
    bool pictureIsDue() const;
    bool meansArePending() const;
    bool hasChanged(std::uint32_t changes) const;
    bool settled() const;
    bool lightIsWhole() const;
    void refineLight(Clock::time_point deadline);
    void layLabelsOver(const InteractiveVolume& volume, Image& picture, const std::vector<float>* shares);
    template <typename Predicate> bool anyVolume(const Predicate& predicate) const;

    Scene scene_;                          // as asDrawn() has it
    std::vector<std::size_t> opacitiesOf_; // those of the last drawn volumes: numbers of the scene's
    DrawnVolumes drawn_;                   // with the volumes that labels and opacities ask for
    Engine& engine_;
    MemoryBudget &ram_, &gpu_;
    InteractiveOptions options_;
    Planner p_; // of the first volume; holds those of the others
    std::vector<std::unique_ptr<InteractiveVolume>> volumes_;
    std::vector<Pass> passes_; // casters read the volumes' plans
    Charge composing_;
    std::vector<Camera> path_;
    std::optional<Haste> haste_;

    bool drawing_ = false;
    std::size_t pass_ = 0;               // of the picture that is drawn
    bool refined_ = false;               // the distance maps, for the current bricks
    Changes forPicture_{kCameraChanged}; // since the last picture began; volumes know their own
    Clock::time_point lastPicture_ = Clock::now(), pictureBegan_;
    Clock::duration pictureTook_{};
    Image picture_;
    Camera pictureCamera_;          // of the picture that is drawn
    std::exception_ptr labelFault_; // labels of the last picture that could not be read
    Work work_;
};

} // namespace tessera
