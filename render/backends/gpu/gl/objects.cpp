// render/backends/gpu/gl/objects.cpp: see objects.h.
#include "render/backends/gpu/gl/objects.h"

#include "core/base/error.h"

#include <string>

namespace tessera {

GlTexture3d::GlTexture3d(GLenum format, const glm::ivec3& extent, std::size_t bytesPerTexel, GLenum filter,
                         MemoryBudget& gpu, std::string_view label)
    : format_(format), extent_(extent) {
    const std::size_t bytes = bytesPerTexel * static_cast<std::size_t>(extent.x) *
                              static_cast<std::size_t>(extent.y) * static_cast<std::size_t>(extent.z);
    charge_ = gpu.charge(bytes, label);
    while (glGetError() != GL_NO_ERROR) {
    } // only errors of this call count below
    glCreateTextures(GL_TEXTURE_3D, 1, &name_);
    glTextureStorage3D(name_, 1, format, extent.x, extent.y, extent.z);
    if (const GLenum error = glGetError(); error != GL_NO_ERROR) {
        glDeleteTextures(1, &name_);
        throw Error("OpenGL: cannot allocate " + formatBytes(bytes) + " for " + std::string(label) +
                    " (GL error " + std::to_string(error) + ")");
    }
    glObjectLabel(GL_TEXTURE, name_, static_cast<GLsizei>(label.size()), label.data());
    glTextureParameteri(name_, GL_TEXTURE_MIN_FILTER, static_cast<GLint>(filter));
    glTextureParameteri(name_, GL_TEXTURE_MAG_FILTER, static_cast<GLint>(filter));
    for (const GLenum axis : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T, GL_TEXTURE_WRAP_R})
        glTextureParameteri(name_, axis, GL_CLAMP_TO_EDGE);
}

GlTexture3d::~GlTexture3d() {
    if (name_)
        glDeleteTextures(1, &name_);
}

void GlTexture3d::upload(const glm::ivec3& offset, const glm::ivec3& extent, GLenum format, GLenum type,
                         const void* texels) {
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    glTextureSubImage3D(name_, 0, offset.x, offset.y, offset.z, extent.x, extent.y, extent.z, format, type,
                        texels);
}

void GlTexture3d::bindForWriting(GLuint unit) const {
    glBindImageTexture(unit, name_, 0, GL_TRUE, 0, GL_WRITE_ONLY, format_);
}

void GlTexture3d::bind(GLuint unit) const {
    constexpr GLuint kImageUnitsEverywhere = 8;
    glBindTextureUnit(unit, name_);
    if (unit < kImageUnitsEverywhere)
        glBindImageTexture(unit, name_, 0, GL_TRUE, 0, GL_READ_ONLY, format_);
}

void GlTexture3d::bindTexture(GLuint unit) const {
    glBindTextureUnit(unit, name_);
}

GlBuffer::GlBuffer(std::size_t bytes, std::span<const std::byte> data, MemoryBudget& gpu,
                   std::string_view label) {
    TESSERA_CHECK(data.empty() || data.size() == bytes);
    charge_ = gpu.charge(bytes, label);
    while (glGetError() != GL_NO_ERROR) {
    }
    glCreateBuffers(1, &name_);
    glNamedBufferStorage(name_, static_cast<GLsizeiptr>(bytes), data.empty() ? nullptr : data.data(), 0);
    if (const GLenum error = glGetError(); error != GL_NO_ERROR) {
        glDeleteBuffers(1, &name_);
        throw Error("OpenGL: cannot allocate " + formatBytes(bytes) + " for " + std::string(label) +
                    " (GL error " + std::to_string(error) + ")");
    }
    glObjectLabel(GL_BUFFER, name_, static_cast<GLsizei>(label.size()), label.data());
    if (data.empty())
        clear();
}

GlBuffer::~GlBuffer() {
    if (name_)
        glDeleteBuffers(1, &name_);
}

void GlBuffer::bind(GLuint binding) const {
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, name_);
}

void GlBuffer::fill(std::uint32_t word) {
    glClearNamedBufferData(name_, GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT, &word);
}

void GlBuffer::fill(std::uint32_t word, std::size_t offset, std::size_t bytes) {
    glClearNamedBufferSubData(name_, GL_R32UI, static_cast<GLintptr>(offset), static_cast<GLsizeiptr>(bytes),
                              GL_RED_INTEGER, GL_UNSIGNED_INT, &word);
}

void GlBuffer::read(std::size_t offset, std::span<std::byte> out) const {
    glGetNamedBufferSubData(name_, static_cast<GLintptr>(offset), static_cast<GLsizeiptr>(out.size()),
                            out.data());
}

GlTexelBuffer::GlTexelBuffer(GLenum format, std::size_t bytesPerTexel, std::span<const std::byte> texels,
                             MemoryBudget& gpu, std::string_view label) {
    GLint most = 0;
    glGetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &most);
    if (texels.size() / bytesPerTexel > static_cast<std::size_t>(most))
        throw Error("OpenGL: " + std::string(label) + " have " +
                    std::to_string(texels.size() / bytesPerTexel) + " texels; this device allows " +
                    std::to_string(most));
    buffer_ = GlBuffer(texels.size(), texels, gpu, label);
    glCreateTextures(GL_TEXTURE_BUFFER, 1, &name_);
    glTextureBuffer(name_, format, buffer_.name());
    glObjectLabel(GL_TEXTURE, name_, static_cast<GLsizei>(label.size()), label.data());
}

GlTexelBuffer::~GlTexelBuffer() {
    if (name_)
        glDeleteTextures(1, &name_);
}

void GlTexelBuffer::bind(GLuint unit) const {
    glBindTextureUnit(unit, name_);
}

} // namespace tessera
