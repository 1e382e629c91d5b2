// render/backends/gpu/gl/program.h: compute programs from shader files. The host resolves `#include "name"`
// once per file. `#line` numbers files, so that a driver's message can be mapped back to a file and a line.
//
// A line `OF_VOLUME type name;` declares a uniform of a volume. Where the defines have VOLUMES, it declares
// an array of them, nameOf, and name stands for the item of gVolume.
#pragma once

#include "core/base/embedded.h"

#include <cstdint>
#include <epoxy/gl.h>
#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace tessera {

namespace render {
const EmbeddedFiles& embeddedFiles(); // shaders/*.glsl, *.comp
}

/// One shader ready to compile, and which file each source-string number of a driver's message means.
struct ComposedShader {
    std::string text;
    std::vector<std::string> files;
};
/// Throws Error for a missing file, for a FEATURE_... that the text asks for and nobody defines, and for one
/// that defines set to anything but 0 or 1. So a misspelt one is an error, not "off".
ComposedShader composeShader(const EmbeddedFiles& files, const std::string& main, const std::string& defines);
/// Replaces the leading "n:line" or "n(line)" of each line of a driver's log by "file:line".
std::string mapShaderLog(const std::string& log, const std::vector<std::string>& files);

class GlProgram {
  public:
    GlProgram() = default;
    /// Compiles and links. Throws Error with file, line and the defines on failure.
    GlProgram(const std::string& main, const std::string& defines,
              const EmbeddedFiles& files = render::embeddedFiles());
    GlProgram(GlProgram&& other) noexcept { std::swap(name_, other.name_); }
    GlProgram& operator=(GlProgram&& other) noexcept {
        std::swap(name_, other.name_);
        return *this;
    }
    ~GlProgram();
    void use() const;
    /// False when the program does not use the uniform: proof that a feature is absent.
    bool hasUniform(const char* uniform) const;
    // Setting a uniform that the program does not use is allowed and does nothing.
    void set(const char* uniform, int value) const;
    void set(const char* uniform, float value) const;
    void set(const char* uniform, const glm::ivec2& value) const;
    void set(const char* uniform, const glm::ivec3& value) const;
    void set(const char* uniform, const glm::vec2& value) const;
    void set(const char* uniform, const glm::vec3& value) const;
    void set(const char* uniform, const glm::mat3& value) const;

  private:
    GLint location(const char* uniform) const;
    GLuint name_ = 0;
};

/// The name of an item of an array of uniforms.
inline std::string element(const char* array, std::size_t i) {
    return array + ("[" + std::to_string(i) + "]");
}

/// The uniforms of one of a program's volumes, named as the shaders name them. Others are not set by it.
class VolumeUniforms {
  public:
    /// @param number  of several; -1: the program has one
    explicit VolumeUniforms(const GlProgram& program, int number = -1) : program_(program), number_(number) {}
    template <typename T> void set(const std::string& uniform, const T& value) const {
        program_.set(nameOf(uniform).c_str(), value);
    }
    int number() const { return number_; }

  private:
    std::string nameOf(const std::string& uniform) const;

    const GlProgram& program_;
    int number_;
};

} // namespace tessera
