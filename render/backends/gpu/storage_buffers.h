// render/backends/gpu/storage_buffers.h: the storage buffers of a program on the device: allocated, filled
// and bound as its composition says.
#pragma once

#include "core/base/budget.h"
#include "render/backends/gpu/composition.h"
#include "render/backends/gpu/gl/objects.h"

#include <map>
#include <span>
#include <string>
#include <string_view>

namespace tessera {

class StorageBuffers {
  public:
    /// Those of a composition for such a picture; all of them say their sizes. Buffers that fit already stay,
    /// with their content; the others go first, so that two are never charged.
    void fit(const Composition& composition, const glm::ivec2& imageSize, const glm::ivec3& bricks,
             MemoryBudget& gpu);
    /// Every buffer as it is when rays begin.
    void begin();
    /// One of them anew, with its new content.
    void put(std::string_view name, std::span<const std::byte> data, MemoryBudget& gpu);
    void bind() const;

    bool has(std::string_view name) const { return held_.find(name) != held_.end(); }
    const GlBuffer& operator[](std::string_view name) const;
    GlBuffer& operator[](std::string_view name);

  private:
    struct Held {
        StorageBuffer what;
        GLuint binding = 0;
        GlBuffer buffer;
    };
    std::map<std::string, Held, std::less<>> held_;
};

} // namespace tessera
