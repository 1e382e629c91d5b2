// render/backends/native/native_engine.h: the native engine: rays on the processor, several side by side
// (packet.h). It takes the contract's samples, bit-equal to the float mirror, from bricks in host memory. It
// takes RAM where other engines take GPU memory, and charges it as GPU memory: --gpu-memory bounds it.
#pragma once

#include "render/backends/native/host_plane.h"
#include "render/engine.h"
#include "render/engine_traits.h"
#include "render/labels/label_plane.h"
#include "render/light/light_plane.h"

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

namespace tessera {

class NativeEngine : public Engine {
  public:
    /// @param threads  0: all processors. All must outlive this.
    NativeEngine(int threads, MemoryBudget& gpu, MemoryBudget& ram)
        : threads_(threads), gpu_(gpu), ram_(ram) {}
    NativeEngine(const NativeEngine&) = delete;
    NativeEngine& operator=(const NativeEngine&) = delete;

    About about() const override;
    TextureLimits limits() const override;
    void open(const FramePlan& plan, std::size_t pages) override;
    void close() override;
    BrickResidency* bricks() override { return bricks_ ? &*bricks_ : nullptr; }
    NativeEngine* further(std::size_t number) override { return further_.at(number).get(); }
    LightPlane* light() override { return lightPlane_ ? &*lightPlane_ : nullptr; }
    std::optional<LightReport> lightReport() const override;
    std::unique_ptr<RayCaster> caster(const CasterOptions& options, MemoryBudget& gpu) override;
    std::unique_ptr<VisibilityCounter> counter(MemoryBudget& gpu) override;

    /// The bricks, ready for rays.
    const HostPlane& settled();
    const HostPlane& plane() const { return *plane_; }
    /// Makes the shadow maps of all volumes of the plan, of which each shades the others; before
    /// settledLight() of any. Bricks must be settled.
    void castShadows();
    /// The light of bricks' samples, ready for rays: a plane a channel of the scene's light; none where it
    /// has none. Bricks must be settled.
    const std::vector<std::unique_ptr<HostPlane>>& settledLight(Work& work);
    const std::vector<std::unique_ptr<HostPlane>>& lightChannels() const { return lightPlanes_; }
    /// The labels' factors, ready for rays where bricks are: a plane a channel; none without labels.
    const std::vector<std::unique_ptr<HostPlane>>& labelChannels() const { return labelPlanes_; }
    /// Takes the plan's levels and function as they are, where they are others.
    void settlePlan();
    int threads() const { return threads_; }

  private:
    void lookAgain();
    template <typename Action> void withRays(const Action& action);

    int threads_;
    MemoryBudget &gpu_, &ram_;
    const FramePlan* scene_ = nullptr;
    std::unique_ptr<HostPlane> plane_;
    std::vector<std::unique_ptr<HostPlane>> lightPlanes_, labelPlanes_;
    std::optional<LabelPlane> labelPlane_;
    std::optional<SceneLight> sceneLight_;
    std::optional<LightPlane> lightPlane_;
    PlanRevisions taken_; // of the plan
    Camera litBy_;        // the camera that lights were placed by
    std::optional<BrickResidency> bricks_;
    std::vector<std::unique_ptr<NativeEngine>> further_; // of the plan's further volumes
};

EngineTraits nativeTraits();

} // namespace tessera
