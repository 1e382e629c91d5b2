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
    /// @param colour  its opacity, and what it becomes when run() returns
    void add(const SegmentedRay<float>& ray, const PathStart& start, glm::vec4& colour, Work& work);
    /// Follows all paths that were added, to their ends.
    void run(Work& work);

  private:
    struct Going {
        SegmentedRay<float> ray;
        TracedPath path;
        Way way;
        glm::vec4* colour = nullptr;
    };
    using List = std::vector<Going*>;
    /// Puts paths where their rays see something; returns those that do.
    List seek(Work& work);
    /// Values at the places of all paths of a list, and gradients.
    void sample(const List& of, bool gradients);
    /// Results of the ways of all paths of a list, by their order.
    void follow(bool free, const List& of, Work& work);

    const PathScene& scene_;
    const MirrorInput& input_;
    NativeField& field_;
    const native::PacketScene& packets_;
    const native::PacketTarget& target_;
    native::PacketExtinction extinction_;
    native::PacketWaysMarch free_ = nullptr, left_ = nullptr; // null: paths go one by one
    native::PacketPlaceTools places_;
    std::vector<Going> paths_;
    // Of a list, as packets have it.
    std::vector<float> from_[3], perMm_[3], mm_, result_, gradient_[3];
    std::vector<std::uint32_t> first_, second_, draws_;
};

} // namespace tessera
