// render/geometry/mesh_caster.h: MeshCaster: the ray caster of a scene with meshes, by that of any engine. A
// ray's volume is drawn in intervals between the surfaces that the ray meets, and each surface is composited
// between two of them (docs/sampling.md, "Meshes"). The engine sees cuts.
#pragma once

#include "render/engine.h"
#include "render/geometry/mesh_rays.h"

#include <memory>
#include <optional>
#include <vector>

namespace tessera {

class MeshCaster : public RayCaster {
  public:
    /// @param plan  of the volume that the caster draws; outlives this
    /// @param hits  the caster tells first hits (CasterOptions)
    /// @param shadows  lights that cast shadows do on meshes: their maps are made when rays begin first
    /// @param threads  0: all processors
    MeshCaster(std::unique_ptr<RayCaster> volume, const FramePlan& plan, bool hits, bool shadows,
               int threads);

    void begin(const Rays& rays) override;
    bool draw(const Slicing& slicing, Clock::time_point deadline, Work& work) override;
    std::size_t waiting() const override { return volume_->waiting(); }
    std::vector<std::uint32_t> takeWanted(std::size_t volume) override { return volume_->takeWanted(volume); }
    Image image() const override { return picture_; }
    /// Of the volume and the meshes, whichever come first.
    std::vector<SurfaceHit> hits() const override { return hits_; }
    std::vector<glm::vec3> meshAmbient() const override { return meshAmbient_; }
    std::unique_ptr<SurfaceTracer> surfaceTracer(double voxels) const override {
        return volume_->surfaceTracer(voxels);
    }
    void refine() override { volume_->refine(); }
    std::size_t refinedCells() const override { return volume_->refinedCells(); }
    std::uint32_t features() const override { return volume_->features(); }

    /// RAM of a ray, besides the engine's.
    static std::size_t bytesPerRay() { return sizeof(RayPart) + sizeof(Front) + sizeof(glm::vec4) * 2; }

  private:
    /// The surface that ends a ray's interval.
    struct Front {
        MeshRays::Order at;
        glm::vec4 colour{0};
        bool isThere = false, isLast = true; // isLast: nothing follows the interval and its surface
    };
    RayLine<double> lineOf(std::size_t ray) const;
    /// Ends the interval that begins behind a place.
    void endNext(std::size_t ray, const MeshRays& meshes, const MeshRays::Order& after);
    template <typename Visit> void forEachRay(const Visit& visit) const;
    void placeLight();
    void keepHit(std::size_t ray, const MeshRays::Surface& surface);
    void beginRound();
    bool takeRound();

    std::unique_ptr<RayCaster> volume_;
    const FramePlan& plan_;
    bool tellsHits_, hasShadows_;
    int threads_;
    std::unique_ptr<MeshLight> light_; // of the plan and camera that it was made for
    PlanRevisions lightOf_;
    Camera lightFrom_;
    Rays rays_;
    std::vector<RayPart> ends_; // of the interval at hand; from > to: there is none
    std::vector<Front> fronts_;
    Image picture_;
    std::vector<SurfaceHit> hits_; // if they are told
    std::vector<glm::vec3> meshAmbient_;
    bool isFirst_ = true, isFinished_ = true;
};

/// An engine's caster for a plan, which it has opened, and for the plan's meshes if it has any.
/// @param threads  that trace rays to meshes; 0: all processors
/// @param shadows  fall on meshes; false: for pictures that must come soon
std::unique_ptr<RayCaster> casterWithMeshes(Engine& engine, const FramePlan& plan,
                                            const CasterOptions& options, MemoryBudget& gpu, int threads,
                                            bool shadows = true);
/// RAM of a picture's pixel, besides the engine's; 0 without meshes.
std::size_t meshBytesPerPixel(const Scene& scene);

} // namespace tessera
