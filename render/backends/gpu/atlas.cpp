// render/backends/gpu/atlas.cpp: see atlas.h.
#include "render/backends/gpu/atlas.h"

#include "core/base/error.h"
#include "render/residency/texels.h"

#include <bit>

namespace tessera {
namespace {

constexpr std::size_t kSamplesOfPage = std::size_t{kBrickExtent} * kBrickExtent * kBrickExtent;

} // namespace

GlTexels glTexels(ValueType type) {
    if (texelFormat(type).normalised)
        return {GL_R16, GL_RED, GL_UNSIGNED_SHORT};
    return {GL_R32F, GL_RED, GL_FLOAT};
}

AtlasPlane::AtlasPlane(const VolumeInfo& info, std::size_t pages, const TextureLimits& limits,
                       MemoryBudget& gpu, MemoryBudget& ram)
    : type_(info.type), ram_(ram) {
    const glm::ivec3 box = atlasPages(std::max<std::size_t>(1, pages), type_, limits);
    TESSERA_CHECK(box.x > 0);
    voxels_ = GlTexture3d(glTexels(type_).internal, box * kBrickExtent, texelBytes(type_), GL_LINEAR, gpu,
                          "the brick atlas");
    index_ = GlTexture3d(GL_RG32UI, brickGrid(info.extentVoxels), kIndexEntryBytes, GL_NEAREST, gpu,
                         "the brick index");
}

void AtlasPlane::put(const AtlasSlot& slot, const BrickSamples& samples, Work& work) {
    const std::size_t texel = texelBytes(type_), row = static_cast<std::size_t>(samples.edge);
    if (staging_.empty()) {
        stagingCharge_ = ram_.charge(kSamplesOfPage * texel, "upload staging");
        staging_.resize(kSamplesOfPage * texel);
    }
    std::byte* to = staging_.data();
    for (int z = 0; z < samples.edge; ++z)
        for (int y = 0; y < samples.edge; ++y) {
            const std::size_t at = linearIndex(samples.first + glm::ivec3(0, y, z), glm::ivec3(kChunkExtent));
            toTexels(type_, samples.chunk.bytes.get() + at * bytesPerValue(type_), row, to);
            to += row * texel;
        }
    const GlTexels format = glTexels(type_);
    voxels_.upload(slot.originTexels(), glm::ivec3(samples.edge), format.external, format.type,
                   staging_.data());
    work.bytesUploaded += row * row * row * texel;
}

void AtlasPlane::finish() {
    glFinish(); // the driver may still hold copies of the data
    staging_ = {};
    stagingCharge_ = {};
}

void AtlasPlane::publish(std::span<const BrickEntry> entries) {
    index_.upload(glm::ivec3(0), index_.extent(), GL_RG_INTEGER, GL_UNSIGNED_INT, entries.data());
    glFinish();
}

void AtlasPlane::bind(GLuint voxelUnit, GLuint indexUnit) const {
    voxels_.bind(voxelUnit);
    index_.bind(indexUnit);
}

namespace {

constexpr GLenum kInternal[] = {GL_R16, GL_RG16, GL_RGBA16, GL_RGBA16};
constexpr GLenum kExternal[] = {GL_RED, GL_RG, GL_RGBA, GL_RGBA};

} // namespace

ChannelAtlas::ChannelAtlas(const VolumeInfo& info, int channels, std::size_t pages,
                           const TextureLimits& limits, const char* what, MemoryBudget& gpu)
    : components_(channels == 3 ? 4 : channels) {
    const glm::ivec3 box = atlasPages(std::max<std::size_t>(1, pages), info.type, limits);
    TESSERA_CHECK(box.x > 0 && components_ >= 1 && components_ <= 4);
    const GLenum internal = kInternal[components_ - 1];
    const std::size_t texel = sizeof(std::uint16_t) * static_cast<std::size_t>(components_);
    texels_ = GlTexture3d(internal, box * kBrickExtent, texel, GL_NEAREST, gpu, what);
    standing_ = GlTexture3d(internal, brickGrid(info.extentVoxels), texel, GL_NEAREST, gpu, what);
    for (int n = 0; n < channels; ++n)
        channels_.push_back(std::make_unique<Channel>(*this, n));
}

std::vector<Plane*> ChannelAtlas::planes() const {
    std::vector<Plane*> planes;
    for (const std::unique_ptr<Channel>& channel : channels_)
        planes.push_back(channel.get());
    return planes;
}

void ChannelAtlas::bind(GLuint unit, GLuint standingUnit) const {
    texels_.bindTexture(unit);
    standing_.bindTexture(standingUnit);
}

void ChannelAtlas::Channel::put(const AtlasSlot& slot, const BrickSamples& samples, Work& work) {
    const auto components = static_cast<std::size_t>(atlas_.components_);
    const std::size_t count = cellCount(glm::ivec3(samples.edge));
    atlas_.staging_.resize(count * components);
    const auto* const from = reinterpret_cast<const std::uint16_t*>(samples.chunk.bytes.get());
    std::uint16_t* to = atlas_.staging_.data() + number_;
    for (int z = 0; z < samples.edge; ++z)
        for (int y = 0; y < samples.edge; ++y)
            for (int x = 0; x < samples.edge; ++x, to += components)
                *to = from[linearIndex(samples.first + glm::ivec3(x, y, z), glm::ivec3(kChunkExtent))];
    if (number_ + 1 < static_cast<int>(atlas_.channels_.size()))
        return;
    atlas_.texels_.upload(slot.originTexels(), glm::ivec3(samples.edge), kExternal[components - 1],
                          GL_UNSIGNED_SHORT, atlas_.staging_.data());
    work.bytesUploaded += count * components * sizeof(std::uint16_t);
}

void ChannelAtlas::Channel::publish(std::span<const BrickEntry> entries) {
    const auto components = static_cast<std::size_t>(atlas_.components_);
    atlas_.standingStaging_.resize(entries.size() * components);
    for (std::size_t b = 0; b < entries.size(); ++b) // bits of a brick that has samples are not read
        atlas_.standingStaging_[b * components + static_cast<std::size_t>(number_)] =
            (entries[b].x & 0x80000000u) != 0 ? static_cast<std::uint16_t>(std::bit_cast<float>(entries[b].y))
                                              : std::uint16_t{0};
    if (number_ + 1 < static_cast<int>(atlas_.channels_.size()))
        return;
    atlas_.standing_.upload(glm::ivec3(0), atlas_.standing_.extent(), kExternal[components - 1],
                            GL_UNSIGNED_SHORT, atlas_.standingStaging_.data());
    atlas_.standingStaging_ = {};
    atlas_.staging_ = {};
}

LightAtlas::LightAtlas(const FramePlan& scene, std::size_t pages, const TextureLimits& limits, int threads,
                       MemoryBudget& gpu)
    : light_(scene, threads),
      channels_(scene.info(), light_.channels(), pages, limits, "light of the bricks", gpu),
      plane_(light_, scene, channels_.planes(), true) {}

namespace {
constexpr int kMostInAtlas = 4;
} // namespace

LabelAtlas::LabelAtlas(const DrawnLabels& labels, const VolumeInfo& info, std::size_t pages,
                       const TextureLimits& limits, MemoryBudget& gpu)
    : first_(info, std::min(labels.numbers().count, kMostInAtlas), pages, limits, "labels of the bricks",
             gpu),
      second_(labels.numbers().count > kMostInAtlas
                  ? std::make_unique<ChannelAtlas>(info, labels.numbers().count - kMostInAtlas, pages, limits,
                                                   "labels of the bricks", gpu)
                  : nullptr),
      plane_(labels, planes()) {}

std::vector<Plane*> LabelAtlas::planes() const {
    std::vector<Plane*> all = first_.planes();
    if (second_)
        for (Plane* more : second_->planes())
            all.push_back(more);
    return all;
}

} // namespace tessera
