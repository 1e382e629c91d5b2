// render/backends/gpu/composition.h: the head of a program's text, by its features: FEATURE_<NAME> 0 or 1,
// BINDING_<NAME> of its storage buffers, and the driver it is for. Bindings are given out here, never
// numbered by hand. The storage buffers of a program on the device: allocated, filled and bound as its
// composition says.
#pragma once

#include "core/base/budget.h"
#include "render/backends/gpu/features.h"
#include "render/backends/gpu/gl/objects.h"
#include "render/backends/gpu/gl/program.h"

#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace tessera {

/// Storage buffers that a compute shader may have on every device (GL 4.5).
constexpr std::size_t kStorageBuffersEverywhere = 8;

/// The reason why features do not go together, as a sentence; empty if they do.
std::string featureConflict(std::uint32_t features, const std::vector<FeatureModule>& modules);

class Composition {
  public:
    Composition() = default;
    /// Throws Error where the features do not go together.
    /// @param own  the program's buffers, whatever the features
    /// @param volumes  of kFeatureFused
    Composition(std::vector<StorageBuffer> own, std::uint32_t features,
                const std::vector<FeatureModule>& modules = featureModules(), int volumes = 1);
    /// Turns of loops that one more sample may take (shaders/common_turns.glsl).
    int turns() const { return turns_; }

    /// The program's and then its features', in the order of their bindings, from 0.
    const std::vector<StorageBuffer>& buffers() const { return buffers_; }
    GLuint binding(std::string_view buffer) const;
    /// Of all buffers that say their sizes.
    std::size_t bytes(const glm::ivec2& imageSize, const glm::ivec3& bricks) const;
    /// For the device of the current context.
    std::string defines() const;
    /// Compiled for it. Throws Error where it has fewer storage buffers.
    GlProgram program(const std::string& shader, const EmbeddedFiles& files = render::embeddedFiles()) const;

  private:
    std::vector<StorageBuffer> buffers_;
    std::string features_; // their defines
    int turns_ = 0;
};

/// For tests: while it lives, programs are composed as for llvmpipe, or as for a GPU, whatever
/// device is there.
class ComposeAsFor {
  public:
    explicit ComposeAsFor(bool llvmpipe);
    ~ComposeAsFor();
    ComposeAsFor(const ComposeAsFor&) = delete;
    ComposeAsFor& operator=(const ComposeAsFor&) = delete;

  private:
    std::optional<bool> before_;
};

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
