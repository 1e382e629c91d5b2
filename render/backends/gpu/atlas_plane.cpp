// render/backends/gpu/atlas_plane.cpp: see atlas_plane.h.
#include "render/backends/gpu/atlas_plane.h"

#include "core/base/error.h"
#include "render/residency/texels.h"

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

} // namespace tessera
