// render/backends/gpu/gl/objects.h: textures and buffers that own their GL names and their share of the GPU
// budget. Move-only; destroyed under a current context.
#pragma once

#include "core/base/budget.h"

#include <cstddef>
#include <cstdint>
#include <epoxy/gl.h>
#include <glm/vec3.hpp>
#include <span>
#include <string_view>
#include <utility>

namespace tessera {

/// A 3D texture with immutable storage of one level.
class GlTexture3d {
  public:
    GlTexture3d() = default;
    /// @param format  one that images have too
    /// @param bytesPerTexel  of format, for the budget
    /// @param filter  GL_NEAREST or GL_LINEAR; wrap is clamp-to-edge
    /// Throws InputError when the budget cannot hold it, Error when GL cannot.
    GlTexture3d(GLenum format, const glm::ivec3& extent, std::size_t bytesPerTexel, GLenum filter,
                MemoryBudget& gpu, std::string_view label);
    GlTexture3d(GlTexture3d&& other) noexcept { swap(other); }
    GlTexture3d& operator=(GlTexture3d&& other) noexcept {
        swap(other);
        return *this;
    }
    ~GlTexture3d();
    /// Copies tightly packed texels [z][y][x] into a box.
    void upload(const glm::ivec3& offset, const glm::ivec3& extent, GLenum format, GLenum type,
                const void* texels);
    /// As a texture and, for imageLoad() from a shader, as an image where every device has a unit of these.
    void bind(GLuint unit) const;
    /// As a texture alone: there are more units of these than of images.
    void bindTexture(GLuint unit) const;
    /// For imageStore() from a shader.
    void bindForWriting(GLuint unit) const;
    const glm::ivec3& extent() const { return extent_; }
    std::size_t bytes() const { return charge_.bytes(); }

  private:
    void swap(GlTexture3d& other) {
        std::swap(name_, other.name_);
        std::swap(format_, other.format_);
        std::swap(extent_, other.extent_);
        std::swap(charge_, other.charge_);
    }
    GLuint name_ = 0;
    GLenum format_ = 0;
    glm::ivec3 extent_{0};
    Charge charge_;
};

/// A buffer of fixed size; bound as a shader storage buffer.
class GlBuffer {
  public:
    GlBuffer() = default;
    /// Zero-filled where data is empty; else data.size() == bytes.
    GlBuffer(std::size_t bytes, std::span<const std::byte> data, MemoryBudget& gpu, std::string_view label);
    GlBuffer(GlBuffer&& other) noexcept { swap(other); }
    GlBuffer& operator=(GlBuffer&& other) noexcept {
        swap(other);
        return *this;
    }
    ~GlBuffer();
    GLuint name() const { return name_; }
    void bind(GLuint binding) const;
    void fill(std::uint32_t word);
    /// A part of it; bytes, whole words.
    void fill(std::uint32_t word, std::size_t offset, std::size_t bytes);
    void clear() { fill(0); }
    void read(std::size_t offset, std::span<std::byte> out) const;
    std::size_t bytes() const { return charge_.bytes(); }

  private:
    void swap(GlBuffer& other) {
        std::swap(name_, other.name_);
        std::swap(charge_, other.charge_);
    }
    GLuint name_ = 0;
    Charge charge_;
};

/// Texels in a row, for texelFetch() on a samplerBuffer.
class GlTexelBuffer {
  public:
    GlTexelBuffer() = default;
    /// @param bytesPerTexel  of format
    /// Throws as GlTexture3d does, and Error where the device has no room for so many texels in a row.
    GlTexelBuffer(GLenum format, std::size_t bytesPerTexel, std::span<const std::byte> texels,
                  MemoryBudget& gpu, std::string_view label);
    GlTexelBuffer(GlTexelBuffer&& other) noexcept { swap(other); }
    GlTexelBuffer& operator=(GlTexelBuffer&& other) noexcept {
        swap(other);
        return *this;
    }
    ~GlTexelBuffer();
    void bind(GLuint unit) const;
    std::size_t bytes() const { return buffer_.bytes(); }

  private:
    void swap(GlTexelBuffer& other) {
        std::swap(name_, other.name_);
        std::swap(buffer_, other.buffer_);
    }
    GLuint name_ = 0;
    GlBuffer buffer_;
};

} // namespace tessera
