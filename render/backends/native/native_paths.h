// render/backends/native/native_paths.h: paths of light of many rays side by side: scatterings are the scalar
// text's (render/transport/path.h); where rays see something, what is at places and ways between them go by
// packets. Bit-equal to paths one by one.
#pragma once

#include "core/base/work.h"
#include "render/backends/mirror/mirror.h"
#include "render/backends/native/native_field.h"
#include "render/backends/native/packet.h"
#include "render/transport/path_scene.h"

#include <cstddef>
#include <glm/vec2.hpp>
#include <glm/vec4.hpp>
#include <span>
#include <vector>

namespace tessera {

/// For one thread.
class NativePaths {
  public:
    /// All outlive it; all bricks are there.
    /// @param packets  of the same volume; without finer blocks of empty space
    NativePaths(const PathScene& scene, const MirrorInput& input, NativeField& field,
                const native::PacketScene& packets, const native::PacketTarget& target);

    /// Takes a ray that sees something.
    /// @param parts  of the ray, in order
    /// @param colour  its opacity, and what it becomes when run() returns
    /// @param beginning  takes where its path begins, by then; null: nobody asks. Of all rays or of none
    void add(std::span<const SegmentedRay<float>> parts, const PathStart& start, glm::vec4& colour,
             PathBeginning* beginning, Work& work);
    /// Follows all paths that were added, to their ends.
    void run(Work& work);

  private:
    struct Going {
        std::size_t first, count; // of its ray's parts
        TracedPath path;
        Way way;
        glm::vec4* colour = nullptr;
        PathBeginning* beginning = nullptr;
    };
    using List = std::vector<Going*>;
    /// Puts paths where their rays see something; returns those that do.
    List seek(Work& work);
    /// Values at the places of all paths of a list, and gradients.
    void sample(const List& of, bool gradients);
    /// Results of the ways of all paths of a list, by their order: mm to a collision, or shares of light.
    const std::vector<float>& follow(bool free, const List& of, Work& work);
    /// The same of ways that no cut interrupts.
    void followWhole(bool free, const List& of, const std::vector<Way>& ways, Work& work);

    const PathScene& scene_;
    const MirrorInput& input_;
    NativeField& field_;
    const native::PacketScene& packets_;
    const native::PacketTarget& target_;
    native::PacketExtinction extinction_;
    native::PacketWaysMarch free_ = nullptr, left_ = nullptr; // null: paths go one by one
    native::PacketPlaceTools places_;
    std::vector<Going> paths_;
    std::vector<SegmentedRay<float>> rays_; // parts of all paths' rays
    // Of a list, as packets have it.
    std::vector<float> from_[3], perMm_[3], mm_, result_, gradient_[3];
    std::vector<std::uint32_t> first_, second_, draws_;
    std::vector<Way> ways_;
    std::vector<std::vector<RayPart>> parts_; // of ways that cuts interrupt
    std::vector<float> whole_;                // results of these
};

} // namespace tessera
