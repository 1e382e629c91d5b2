// render/backends/native/native_caster.h: the rays of a picture, drawn in packets by all threads.
#pragma once

#include "render/backends/native/fine_blocks.h"
#include "render/backends/native/native_engine.h"
#include "render/backends/native/native_field.h"
#include "render/backends/native/packet.h"
#include "render/contract/ray_cuts.h"
#include "render/engine.h"

#include <atomic>
#include <cstdint>
#include <vector>

namespace tessera {

class NativeVolumes;

class NativeCaster : public RayCaster {
  public:
    /// Scene and engine outlive it.
    /// @param target  of instructions; null: the processor's best
    NativeCaster(const FramePlan& scene, NativeEngine& engine, const CasterOptions& options,
                 MemoryBudget& gpu, const native::PacketTarget* target = nullptr);

    void begin(const Rays& rays) override;
    bool draw(const Slicing& slicing, Clock::time_point deadline, Work& work) override;
    std::size_t waiting() const override { return waiting_; }
    std::vector<std::uint32_t> takeWanted(std::size_t volume = 0) override {
        return wanted_.at(volume).take();
    }
    Image image() const override;
    std::span<const PathBeginning> beginnings() const override { return beginnings_; }
    std::vector<SurfaceHit> hits() const override { return hits_; }
    std::unique_ptr<SurfaceTracer> surfaceTracer(double voxels) const override;
    void refine() override;
    /// As refine(), whether it pays or not, where there is a map of cells.
    void findBlocks();
    std::size_t refinedCells() const override;

    /// Turns of packets that took samples, and lanes that took one in them, since begin().
    struct Lanes {
        std::uint64_t turns = 0, used = 0;
        int width = 0;
    };
    Lanes lanes() const { return lanes_; }
    /// The packets' view of the current scene's first volume; for measurements.
    native::PacketScene packetScene() const { return packetSceneOfVolume(0); }
    const native::PacketTarget& target() const { return target_; }

  private:
    struct Counts;
    native::PacketScene packetSceneOfVolume(std::size_t number) const;
    std::size_t volumes() const { return scene_.volumesOfRays(); }
    glm::vec2 placeOf(const glm::ivec2& at, std::size_t slot) const;
    /// One interval of every ray, the same number of each.
    bool drawRound(const Slicing& slicing, Clock::time_point deadline, Work& work);
    void startRound();
    void followPaths(const Slicing& slicing, Work& work);
    void colourKeptValues();
    bool drawPacket(const glm::ivec2& origin, NativeVolumes& volumes, const Slicing& slicing, Counts& counts);
    void nameStride(NativeField& field, const SegmentedRay<float>& ray, int i, const glm::vec4& sum);
    const Occupancy* occupancy(std::size_t volume = 0) const;
    bool mapsSurfaces() const;

    const FramePlan& scene_;
    NativeEngine& engine_;
    MemoryBudget& gpu_;
    CasterOptions options_;
    const native::PacketTarget& target_;
    native::PacketMarch march_ = nullptr;
    Charge raysCharge_;
    std::unique_ptr<FineBlocks> blocks_, surfaceBlocks_; // none: the scene's maps are read
    std::uint64_t mapTaken_ = 0;                         // PlanRevisions::emptySpace when rays last began

    Rays rays_;
    RayFrame<float> frame_;
    native::PacketFrame packetFrame_;
    glm::ivec2 size_{0}, tiles_{0};
    std::vector<glm::vec4> colour_;
    std::vector<std::int32_t> next_;    // of every ray; kEnded at its end
    std::vector<std::uint16_t> packet_; // of every tile: its next packet
    std::vector<SurfaceHit> hits_;
    std::vector<PathBeginning> beginnings_;
    std::optional<CutRays> cuts_; // of cut rays
    std::size_t round_ = 0;       // the number of the interval at hand
    Charge cutsCharge_;
    std::vector<WantedBricks> wanted_; // of all volumes
    std::size_t waiting_ = 0;
    Lanes lanes_;
};

} // namespace tessera
