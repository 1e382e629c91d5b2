// render/parts/part_caster.h: PartCaster: the ray caster of a picture that several processes draw, by that of
// an engine: it draws the segments of rays that lie in this process's part of the volume, and gives the
// composite of all parts, the same in all processes.
#pragma once

#include "render/engine.h"
#include "render/parts/process_group.h"

#include <memory>
#include <optional>
#include <vector>

namespace tessera {

class PartCaster : public RayCaster {
  public:
    /// @param volume  of an engine that takes Rays::segments
    /// @param plan  of a shared volume; outlives this
    PartCaster(std::unique_ptr<RayCaster> volume, const FramePlan& plan, int threads);

    /// Throws InputError where the processes draw different rays, or plan differently.
    void begin(const Rays& rays) override;
    bool draw(const Slicing& slicing, Clock::time_point deadline, Work& work) override {
        return volume_->draw(slicing, deadline, work);
    }
    std::size_t waiting() const override { return volume_->waiting(); }
    std::vector<std::uint32_t> takeWanted(std::size_t volume) override { return volume_->takeWanted(volume); }
    Image image() const override;
    void refine() override { volume_->refine(); }
    std::size_t refinedCells() const override { return volume_->refinedCells(); }

    /// RAM of a ray, besides the engine's: its segments, and its colours here and while they are composited.
    static constexpr std::size_t bytesPerRay() { return sizeof(SegmentRange) + 4 * sizeof(glm::vec4); }

  private:
    std::unique_ptr<RayCaster> volume_;
    const FramePlan& plan_;
    int threads_;
    Rays rays_;
    std::vector<SegmentRange> segments_;
    mutable std::optional<Image> composite_; // of the rays at hand
};

} // namespace tessera
