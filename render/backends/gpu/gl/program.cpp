// render/backends/gpu/gl/program.cpp: see program.h.
#include "render/backends/gpu/gl/program.h"

#include "core/base/error.h"

#include <algorithm>
#include <cctype>
#include <glm/gtc/type_ptr.hpp>
#include <regex>
#include <set>
#include <sstream>

namespace tessera {
namespace {

constexpr const char* kInclude = "#include \"";
constexpr std::string_view kOfVolume = "OF_VOLUME ";

/// The declaration of a line behind kOfVolume: "type name;" or "type name[n];", and perhaps a comment.
/// @param here  the directive that gives the next line its number
std::string ofVolumes(const std::string& line, const std::string& here) {
    static const std::regex form(R"(^(.*?)(\w+)((?:\[\w+\])?;.*)$)");
    std::smatch match;
    if (!std::regex_match(line, match, form))
        throw Error("shader: expected OF_VOLUME type name; found " + line);
    const std::string name = match[2];
    return "uniform " + match[1].str() + name + "Of[VOLUMES]" + match[3].str() + "\n#define " + name + " " +
           name + "Of[gVolume]\n" + here;
}

/// @param several  volumes
void append(const EmbeddedFiles& files, const std::string& name, bool several, ComposedShader& out) {
    if (std::find(out.files.begin(), out.files.end(), name) != out.files.end())
        return; // once each
    const auto found = files.find(name);
    if (found == files.end())
        throw Error("shader file " + name + " is missing");
    const std::size_t number = out.files.size();
    out.files.push_back(name);
    out.text += "#line 1 " + std::to_string(number) + "\n";
    std::istringstream lines{std::string(found->second)};
    std::string line;
    for (int lineNumber = 1; std::getline(lines, line); ++lineNumber) {
        const std::string next =
            "#line " + std::to_string(lineNumber + 1) + " " + std::to_string(number) + "\n";
        if (line.starts_with(kOfVolume)) {
            const std::string declared = line.substr(kOfVolume.size());
            out.text += several ? ofVolumes(declared, next) : "uniform " + declared + "\n";
            continue;
        }
        if (!line.starts_with(kInclude)) {
            out.text += line + "\n";
            continue;
        }
        const std::size_t start = std::string_view(kInclude).size();
        append(files, line.substr(start, line.find('"', start) - start), several, out);
        out.text += next;
    }
}

/// The words of a text that begin with FEATURE_.
std::set<std::string_view> featureWords(std::string_view text) {
    constexpr std::string_view kPrefix = "FEATURE_";
    const auto isPart = [](char c) { return c == '_' || std::isalnum(static_cast<unsigned char>(c)); };
    std::set<std::string_view> words;
    for (std::size_t at = text.find(kPrefix); at != std::string_view::npos; at = text.find(kPrefix, at + 1)) {
        std::size_t end = at;
        while (end < text.size() && isPart(text[end]))
            ++end;
        if (at == 0 || !isPart(text[at - 1]))
            words.insert(text.substr(at, end - at));
    }
    return words;
}

void checkFeatures(const std::string& main, const std::string& defines, const std::string& text) {
    for (const std::string_view word : featureWords(text)) {
        const std::string define = "#define " + std::string(word) + " ";
        if (text.find(define) == std::string::npos)
            throw Error("shader " + main + " asks for " + std::string(word) + ", which nobody defines:\n" +
                        defines);
        if (const std::size_t at = defines.find(define); at != std::string::npos) {
            const std::size_t from = at + define.size();
            const std::string value = defines.substr(from, defines.find('\n', from) - from);
            if (value != "0" && value != "1")
                throw Error("shader " + main + ": " + std::string(word) + " is neither 0 nor 1 but " + value);
        }
    }
}

} // namespace

ComposedShader composeShader(const EmbeddedFiles& files, const std::string& main,
                             const std::string& defines) {
    ComposedShader out;
    out.text = "#version 450 core\n" + defines;
    append(files, main, defines.find("#define VOLUMES ") != std::string::npos, out);
    checkFeatures(main, defines, out.text);
    return out;
}

std::string mapShaderLog(const std::string& log, const std::vector<std::string>& files) {
    // Mesa writes "7:100(1): …" (the column in brackets), NVIDIA "7(100) : …".
    static const std::regex place(R"(^(\d+)(?::(\d+)(?:\(\d+\))?|\((\d+)\)))");
    std::istringstream lines(log);
    std::string line, out;
    while (std::getline(lines, line)) {
        std::smatch match;
        if (std::regex_search(line, match, place) && match[1].length() < 6) {
            const std::size_t number = std::stoul(match[1].str());
            if (number < files.size())
                line = files[number] + ":" + match[2].str() + match[3].str() + match.suffix().str();
        }
        out += line + "\n";
    }
    return out;
}

GlProgram::GlProgram(const std::string& main, const std::string& defines, const EmbeddedFiles& files) {
    const ComposedShader composed = composeShader(files, main, defines);
    const GLuint shader = glCreateShader(GL_COMPUTE_SHADER);
    const char* text = composed.text.c_str();
    glShaderSource(shader, 1, &text, nullptr);
    glCompileShader(shader);
    name_ = glCreateProgram();
    glAttachShader(name_, shader);
    glLinkProgram(name_);
    GLint ok = 0;
    glGetProgramiv(name_, GL_LINK_STATUS, &ok);
    if (!ok) {
        std::string log(16384, '\0');
        GLsizei length = 0;
        glGetShaderInfoLog(shader, static_cast<GLsizei>(log.size()), &length, log.data());
        if (length == 0)
            glGetProgramInfoLog(name_, static_cast<GLsizei>(log.size()), &length, log.data());
        log.resize(static_cast<std::size_t>(length));
        glDeleteShader(shader);
        glDeleteProgram(std::exchange(name_, 0u));
        throw Error("shader " + main + " does not compile:\n" + mapShaderLog(log, composed.files) + defines);
    }
    glDetachShader(name_, shader);
    glDeleteShader(shader);
    glObjectLabel(GL_PROGRAM, name_, static_cast<GLsizei>(main.size()), main.c_str());
}

GlProgram::~GlProgram() {
    if (name_)
        glDeleteProgram(name_);
}

std::string VolumeUniforms::nameOf(const std::string& uniform) const {
    if (number_ < 0)
        return uniform;
    std::string name = uniform;
    return name.insert(std::min(name.find_first_of("[."), name.size()),
                       "Of[" + std::to_string(number_) + "]");
}

void GlProgram::use() const {
    glUseProgram(name_);
}

GLint GlProgram::location(const char* uniform) const {
    return glGetUniformLocation(name_, uniform);
}
bool GlProgram::hasUniform(const char* uniform) const {
    return location(uniform) >= 0;
}
void GlProgram::set(const char* uniform, int value) const {
    glProgramUniform1i(name_, location(uniform), value);
}
void GlProgram::set(const char* uniform, float value) const {
    glProgramUniform1f(name_, location(uniform), value);
}
void GlProgram::set(const char* uniform, const glm::ivec2& value) const {
    glProgramUniform2iv(name_, location(uniform), 1, glm::value_ptr(value));
}
void GlProgram::set(const char* uniform, const glm::ivec3& value) const {
    glProgramUniform3iv(name_, location(uniform), 1, glm::value_ptr(value));
}
void GlProgram::set(const char* uniform, const glm::vec2& value) const {
    glProgramUniform2fv(name_, location(uniform), 1, glm::value_ptr(value));
}
void GlProgram::set(const char* uniform, const glm::vec3& value) const {
    glProgramUniform3fv(name_, location(uniform), 1, glm::value_ptr(value));
}
void GlProgram::set(const char* uniform, const glm::mat3& value) const {
    glProgramUniformMatrix3fv(name_, location(uniform), 1, GL_FALSE, glm::value_ptr(value));
}

} // namespace tessera
