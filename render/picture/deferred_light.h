// render/picture/deferred_light.h: light of isosurfaces that is added to a picture after its rays, from their
// first hits: ambient light that others take (surface_light.h), and what they mirror (reflections.h).
#pragma once

#include "core/image/picture_tile.h"
#include "render/engine.h"
#include "render/light/reflections.h"
#include "render/light/surface_light.h"
#include "render/picture/picture.h"
#include "render/renderer.h"

#include <glm/vec2.hpp>
#include <optional>
#include <span>

namespace tessera {

class DeferredLight {
  public:
    /// True if a plan's pictures have any.
    static bool isOf(const FramePlan& plan) {
        return plan.view.lighting.surfaceOcclusion.has_value() || plan.view.reflects;
    }
    /// The plan outlives it, and has some.
    /// @param exact  for the reference
    /// @param part  of the picture, where surfaces' surroundings are looked at: around(); none: all of it
    DeferredLight(const FramePlan& plan, int threads, bool exact,
                  const std::optional<PictureTile>& part = {});
    /// What a part of a picture needs to be looked at: it, with pixels around it where results are shared.
    static PictureTile around(const PictureTile& tile, const FramePlan& plan);

    /// True until it knows the first hits of the rays through the middles of all pixels.
    bool needsMiddles() const { return occlusion_ && !occlusion_->hasLooked(); }
    /// @param caster  has drawn these rays
    void lookAround(const RayCaster& caster, Progress& progress);
    /// The image to add to the colours of the rays that a caster has drawn; alpha 0. It draws others then.
    /// @param places, size  of the rays on the picture: Reflections::added()
    Image added(RayCaster& caster, Engine& engine, std::span<const glm::vec2> places, const glm::ivec2& size,
                const Slicing& slicing, Work& work) const;
    void report(RenderResult& result) const;
    /// In addition to those of other parts of the picture.
    void addReport(RenderResult& result) const;

  private:
    const FramePlan& plan_;
    std::optional<SurfaceLight> occlusion_;
    std::optional<Reflections> reflections_;
};

} // namespace tessera
