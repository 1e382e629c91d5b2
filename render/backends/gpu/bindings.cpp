// render/backends/gpu/bindings.cpp: see bindings.h.
#include "render/backends/gpu/bindings.h"

#include <span>
#include <vector>

namespace tessera {
namespace {

constexpr char kLabel[] = "the transfer function's tables";

} // namespace

void FunctionTables::set(const Optics& optics, std::uint32_t features, MemoryBudget& gpu) {
    for (GlTexelBuffer* before : {&both_, &extinctions_, &colours_, &sums_})
        *before = {};
    if (features & kFeatureFused) {
        both_ =
            GlTexelBuffer(GL_RGBA32F, sizeof(glm::vec4), std::as_bytes(std::span(optics.table)), gpu, kLabel);
        return;
    }
    // Apart, for most samples have no extinction, and their colours are never read.
    std::vector<float> extinctions;
    std::vector<glm::vec3> colours;
    for (const glm::vec4& entry : optics.table) {
        extinctions.push_back(entry.a);
        colours.emplace_back(entry);
    }
    extinctions_ = GlTexelBuffer(GL_R32F, sizeof(float), std::as_bytes(std::span(extinctions)), gpu, kLabel);
    colours_ = GlTexelBuffer(GL_RGB32F, sizeof(glm::vec3), std::as_bytes(std::span(colours)), gpu, kLabel);
    if (!(features & kFeaturePreintegrated))
        return;
    std::vector<glm::vec4> sums = optics.bins;
    sums.insert(sums.end(), optics.sums.begin(), optics.sums.end());
    sums.insert(sums.end(), optics.seen.colours().begin(), optics.seen.colours().end());
    sums_ = GlTexelBuffer(GL_RGBA32F, sizeof(glm::vec4), std::as_bytes(std::span(sums)), gpu, kLabel);
}

void FunctionTables::bind(const VolumeUniforms& program) const {
    const auto give = [&](const GlTexelBuffer& table, const char* uniform, GLuint of) {
        const GLuint unit = unitOf(program, of);
        table.bind(unit);
        program.set(uniform, static_cast<int>(unit));
    };
    if (both_.bytes() > 0) {
        give(both_, "uTable", kColourUnit);
        return;
    }
    give(extinctions_, "uExtinctions", kExtinctionUnit);
    give(colours_, "uColours", kColourUnit);
    if (sums_.bytes() > 0)
        give(sums_, "uSums", kSumsUnit);
}

} // namespace tessera
