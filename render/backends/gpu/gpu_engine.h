// render/backends/gpu/gpu_engine.h: the GPU ray caster as an engine: bricks in an atlas, level maps in
// textures, and ray casters (`March`) over them.
#pragma once

#include "render/backends/gpu/atlas.h"
#include "render/backends/gpu/bindings.h"
#include "render/backends/gpu/gl/context.h"
#include "render/backends/gpu/march.h"
#include "render/engine.h"
#include "render/engine_traits.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace tessera {

/// The features that a scene needs over bricks that are all there, in bits of features.h.
std::uint32_t marchFeatures(const FramePlan& scene, bool counting);

/// What a device allows a compute shader.
struct FuseLimits {
    int textures = 0, units = 0,
        components = 0; // samplers; texture units of all shaders; numbers of uniforms
};
/// Of the current context's.
FuseLimits fuseLimits();
/// Why a device cannot draw the volumes of a scene in one pass; empty: it can, as it can any single volume.
std::string cannotFuse(const Scene& scene, const FuseLimits& limits);

class GpuEngine : public Engine {
  public:
    /// All must outlive this; the context stays current.
    GpuEngine(const GlContext& context, MemoryBudget& gpu, MemoryBudget& ram)
        : context_(&context), gpu_(gpu), ram_(ram) {}
    /// On the context that is current, whichever it is, within limits that every device has.
    GpuEngine(MemoryBudget& gpu, MemoryBudget& ram) : gpu_(gpu), ram_(ram) {}
    GpuEngine(const GpuEngine&) = delete; // the field points into it
    GpuEngine& operator=(const GpuEngine&) = delete;

    About about() const override;
    TextureLimits limits() const override;
    void open(const FramePlan& plan, std::size_t pages) override;
    void close() override;
    BrickResidency* bricks() override { return atlas_ ? &atlas_->bricks : nullptr; }
    GpuEngine* further(std::size_t number) override { return further_.at(number).get(); }
    LightPlane* light() override { return light_ ? &light_->plane() : nullptr; }
    std::optional<LightReport> lightReport() const override {
        return light_ ? std::optional(light_->report()) : std::nullopt;
    }
    std::unique_ptr<RayCaster> caster(const CasterOptions& options, MemoryBudget& gpu) override;
    std::unique_ptr<VisibilityCounter> counter(MemoryBudget& gpu) override;
    std::string fault() override;

    /// The bricks and their levels, as ray casters read them.
    const FieldSource& field() const { return field_; }
    /// The same as of mixed levels, also where they are not: beside volumes whose levels are.
    const FieldSource& mixedField();
    /// Makes the shadow maps of all volumes of the plan, of which each shades the others; before
    /// settleLight() of any.
    void castShadows();
    /// Light as things are; before rays are drawn.
    void settleLight(Work& work);
    /// Takes the plan's levels and function as they are, where they are others.
    void settlePlan();

  private:
    void takeLevels();
    void lookAgain();

    const GlContext* context_ = nullptr;
    MemoryBudget &gpu_, &ram_;
    const FramePlan* scene_ = nullptr;
    std::optional<LightAtlas> light_;
    std::optional<LabelAtlas> labels_;
    std::optional<Atlas> atlas_;
    PlanRevisions taken_;                   // of the plan
    Camera litBy_;                          // the camera that lights were placed by
    std::optional<LevelTextures> textures_; // of mixed levels
    std::optional<LevelMap> uniformMap_;    // of levels that are not, for mixedField()
    FieldSource field_;
    std::vector<std::unique_ptr<GpuEngine>> further_; // of the plan's further volumes
};

EngineTraits gpuTraits();

// The ray caster of a scene on the GPU: `March` with its distance maps, made finer on the device where that
// pays (skipping_binding.h).

class GpuCaster : public RayCaster {
  public:
    /// Scene and engine outlive it.
    GpuCaster(const FramePlan& scene, GpuEngine& engine, const CasterOptions& options, MemoryBudget& gpu);
    /// The same with exactly these features: for tests and studies that leave out features of the scene.
    GpuCaster(const FramePlan& scene, GpuEngine& engine, std::uint32_t features, MemoryBudget& gpu);

    void begin(const Rays& rays) override;
    bool draw(const Slicing& slicing, Clock::time_point deadline, Work& work) override;
    std::size_t waiting() const override { return march_.waiting(); }
    std::vector<std::uint32_t> takeWanted(std::size_t volume = 0) override {
        return march_.takeWanted(volume);
    }
    Image image() const override;
    std::vector<SurfaceHit> hits() const override { return march_.hits(); }
    void refine() override;
    std::size_t refinedCells() const override { return refinedCells_; }
    std::uint32_t features() const override { return features_; }

    const March& march() const { return march_; }

  private:
    void takeFunction();
    void putBounds();

    const FramePlan& scene_;
    GpuEngine& engine_;
    MemoryBudget& gpu_;
    std::vector<const FramePlan*> plans_; // of all volumes
    std::uint32_t features_;              // the integrator's and the lights' included
    std::vector<PlanRevisions> taken_;    // of the plans, when rays last began
    Fetch fetch_;                         // then
    std::size_t refinedCells_ = 0;
    std::uint64_t boundsVersion_ = 0; // of the bounds on the device; 0: none
    March march_;
};

} // namespace tessera
