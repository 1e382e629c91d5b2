// render/backends/gpu/composition.cpp: see composition.h.
#include "render/backends/gpu/composition.h"

#include "core/base/error.h"
#include "render/backends/gpu/gl/context.h"

#include <algorithm>

namespace tessera {
namespace {

/// Of one more volume's sample, without features: of seven values, corner by corner.
constexpr int kTurnsOfVolume = 600;

thread_local std::optional<bool> asForLlvmpipe; // GL has one thread

bool isForLlvmpipe() {
    return asForLlvmpipe.value_or(
        isSoftwareRenderer(reinterpret_cast<const char*>(glGetString(GL_RENDERER))));
}

} // namespace

std::string featureConflict(std::uint32_t features, const std::vector<FeatureModule>& modules) {
    const auto words = [](const FeatureModule& m) { return std::string(m.define) + " (" + m.meaning + ")"; };
    for (const FeatureModule& m : modules) {
        if (!(features & m.bit))
            continue;
        for (const FeatureModule& other : modules) {
            if ((m.needs & other.bit) && !(features & other.bit))
                return words(m) + " needs " + words(other);
            if (m.excludes & features & other.bit)
                return words(m) + " does not go with " + words(other);
        }
    }
    return {};
}

Composition::Composition(std::vector<StorageBuffer> own, std::uint32_t features,
                         const std::vector<FeatureModule>& modules, int volumes)
    : buffers_(std::move(own)), features_(featureDefines(features, modules)) {
    if (const std::string why = featureConflict(features, modules); !why.empty())
        throw Error("features of the march: " + why);
    for (const FeatureModule& m : modules)
        if (features & m.bit) {
            buffers_.insert(buffers_.end(), m.buffers.begin(), m.buffers.end());
            turns_ += m.turns;
        }
    if (!(features & kFeatureFused))
        return;
    turns_ = volumes * (turns_ + kTurnsOfVolume);
    features_ += "#define VOLUMES " + std::to_string(volumes) + "\n";
    features_ += "#define MOST_CUT_SLABS " + std::to_string(kMostCutSlabs) + "\n";
}

GLuint Composition::binding(std::string_view buffer) const {
    const auto found = std::find_if(buffers_.begin(), buffers_.end(),
                                    [&](const StorageBuffer& b) { return b.name == buffer; });
    TESSERA_CHECK(found != buffers_.end());
    return static_cast<GLuint>(found - buffers_.begin());
}

std::size_t Composition::bytes(const glm::ivec2& imageSize, const glm::ivec3& bricks) const {
    std::size_t sum = 0;
    for (const StorageBuffer& b : buffers_)
        sum += b.bytes ? b.bytes(imageSize, bricks) : 0;
    return sum;
}

std::string Composition::defines() const {
    std::string text = features_;
    for (const StorageBuffer& b : buffers_)
        text += "#define BINDING_" + std::string(b.name) + " " + std::to_string(binding(b.name)) + "\n";
    text += "#define SAMPLE_TURNS " + std::to_string(turns_) + "\n";
    return text + "#define DRIVER_LLVMPIPE " + (isForLlvmpipe() ? "1\n" : "0\n");
}

GlProgram Composition::program(const std::string& shader, const EmbeddedFiles& files) const {
    GLint most = 0;
    glGetIntegerv(GL_MAX_COMPUTE_SHADER_STORAGE_BLOCKS, &most);
    if (buffers_.size() > static_cast<std::size_t>(most))
        throw Error("shader " + shader + " has " + std::to_string(buffers_.size()) +
                    " storage buffers; this device allows " + std::to_string(most));
    constexpr int kMostTurns = 65535 / 16 - 400; // as shaders/common_turns.glsl has them
    if (isForLlvmpipe() && turns_ > kMostTurns - 64)
        throw InputError(
            "--engine: expected native for this scene, found gpu in software: a sample takes up to " +
            std::to_string(turns_) + " turns of loops there, and " + std::to_string(kMostTurns - 64) +
            " are allowed");
    return GlProgram(shader, defines(), files);
}

ComposeAsFor::ComposeAsFor(bool llvmpipe) : before_(std::exchange(asForLlvmpipe, llvmpipe)) {}
ComposeAsFor::~ComposeAsFor() {
    asForLlvmpipe = before_;
}

void StorageBuffers::fit(const Composition& composition, const glm::ivec2& imageSize,
                         const glm::ivec3& bricks, MemoryBudget& gpu) {
    std::map<std::string, Held, std::less<>> before = std::move(held_);
    held_.clear();
    const auto bytesOf = [&](const StorageBuffer& b) { return b.bytes(imageSize, bricks); };
    for (const StorageBuffer& b : composition.buffers()) {
        TESSERA_CHECK(b.bytes);
        Held& held = held_[b.name];
        held.what = b;
        held.binding = composition.binding(b.name);
        if (const auto old = before.find(b.name);
            old != before.end() && old->second.buffer.bytes() == bytesOf(b))
            held.buffer = std::move(old->second.buffer);
    }
    before.clear();
    for (const StorageBuffer& b : composition.buffers()) {
        GlBuffer& buffer = held_[b.name].buffer;
        if (buffer.bytes() == 0) {
            buffer = GlBuffer(bytesOf(b), {}, gpu, b.label);
            buffer.fill(b.first);
        }
    }
}

void StorageBuffers::begin() {
    for (auto& [name, held] : held_)
        held.buffer.fill(held.what.first);
}

void StorageBuffers::put(std::string_view name, std::span<const std::byte> data, MemoryBudget& gpu) {
    const auto found = held_.find(name);
    TESSERA_CHECK(found != held_.end());
    found->second.buffer = {};
    found->second.buffer = GlBuffer(data.size(), data, gpu, found->second.what.label);
}

void StorageBuffers::bind() const {
    for (const auto& [name, held] : held_) {
        TESSERA_CHECK(held.buffer.bytes() > 0);
        held.buffer.bind(held.binding);
    }
}

const GlBuffer& StorageBuffers::operator[](std::string_view name) const {
    const auto found = held_.find(name);
    TESSERA_CHECK(found != held_.end());
    return found->second.buffer;
}

GlBuffer& StorageBuffers::operator[](std::string_view name) {
    return const_cast<GlBuffer&>(std::as_const(*this)[name]);
}

} // namespace tessera
