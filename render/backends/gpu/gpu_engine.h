// render/backends/gpu/gpu_engine.h: the GPU ray caster as an engine: bricks in an atlas, level maps in
// textures, and ray casters (`March`) over them.
#pragma once

#include "render/backends/gpu/atlas_plane.h"
#include "render/backends/gpu/field_binding.h"
#include "render/backends/gpu/gl/context.h"
#include "render/engine.h"
#include "render/engine_traits.h"

#include <cstdint>
#include <memory>
#include <optional>

namespace tessera {

/// The features that a scene needs over bricks that are all there, in bits of features.h.
std::uint32_t marchFeatures(const FramePlan& scene, bool counting);

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
    void open(std::span<const FramePlan* const> plans, std::size_t pages) override;
    void close() override;
    BrickResidency* bricks() override { return atlas_ ? &atlas_->bricks : nullptr; }
    LightPlane* light() override { return light_ ? &light_->plane() : nullptr; }
    std::optional<LightReport> lightReport() const override {
        return light_ ? std::optional(light_->report()) : std::nullopt;
    }
    std::unique_ptr<RayCaster> caster(const CasterOptions& options, MemoryBudget& gpu) override;
    std::unique_ptr<VisibilityCounter> counter(MemoryBudget& gpu) override;
    std::string fault() override;

    /// The bricks and their levels, as ray casters read them.
    const FieldSource& field() const { return field_; }
    /// Light as things are; before rays are drawn.
    void settleLight(Work& work);
    /// Takes the plan's levels and function as they are, where they are others.
    void settlePlan();

  private:
    void takeLevels();

    const GlContext* context_ = nullptr;
    MemoryBudget &gpu_, &ram_;
    const FramePlan* scene_ = nullptr;
    std::optional<LightAtlas> light_;
    std::optional<Atlas> atlas_;
    PlanRevisions taken_;                   // of the plan
    Camera litBy_;                          // the camera that lights were placed by
    std::optional<LevelTextures> textures_; // of mixed levels
    FieldSource field_;
};

EngineTraits gpuTraits();

} // namespace tessera
