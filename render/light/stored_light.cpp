// render/light/stored_light.cpp: see stored_light.h.
#include "render/light/stored_light.h"

#include <algorithm>

namespace tessera {

StoredLight::StoredLight(SceneLight& light, const FramePlan& scene, MemoryBudget& ram)
    : map_(scene.layer().mixed() ? &scene.layer().levels : nullptr), selection_(&scene.layer().selection),
      level_(scene.layer().selection.finest()), channels_(light.channels()),
      extent_(levelExtent(scene.info().extentVoxels, level_)), bricks_(selection_->levels.size()) {
    const auto channels = static_cast<std::size_t>(channels_);
    VoxelLight& voxels = light.ready();
    std::vector<BrickToLight> wanted;
    std::size_t texels = bricks_.size();
    for (std::size_t b = 0; b < bricks_.size(); ++b)
        if (const int level = selection_->levels[b]; level + 1 < kLevelCount) {
            wanted.push_back({b, level, std::max(level, voxels.finestLevel())});
            texels += cellCount(glm::ivec3(kBrickExtent >> level));
        }
    charge_ = ram.charge(texels * channels * sizeof(std::uint16_t), "light of the bricks");
    BrickCache& cache = *scene.layer().cache;
    std::vector<std::uint8_t> levels = selection_->levels;
    for (std::uint8_t& level : levels)
        level = std::max(level, static_cast<std::uint8_t>(voxels.finestLevel()));
    voxels.light(wanted, levels, kAllLight, cache,
                 [&](const BrickToLight& b, int channel, const Chunk& chunk, int edge) {
                     const auto* from = reinterpret_cast<const std::uint16_t*>(chunk.bytes.get());
                     const std::size_t count = cellCount(glm::ivec3(edge));
                     std::vector<std::uint16_t>& to = bricks_[b.brick].texels;
                     to.resize(count * channels);
                     std::size_t n = count * static_cast<std::size_t>(channel);
                     for (int z = 0; z < edge; ++z)
                         for (int y = 0; y < edge; ++y)
                             for (int x = 0; x < edge; ++x)
                                 to[n++] = from[linearIndex({x, y, z}, glm::ivec3(kChunkExtent))];
                 });
    standing_.resize(bricks_.size() * channels);
    for (std::size_t b = 0; b < bricks_.size(); ++b)
        for (std::size_t part = 0; part < kLightParts && bricks_[b].texels.empty(); ++part)
            for (int n = 0; n < voxels.channelsOf(part); ++n)
                standing_[b * channels + static_cast<std::size_t>(voxels.firstChannelOf(part) + n)] =
                    voxels.standing(b, part, n, cache);
}

float StoredLight::Channel::at(int level, const glm::ivec3& i) const {
    const glm::ivec3 brick = i >> (5 - level);
    const std::size_t b = linearIndex(brick, light_.selection_->bricks);
    const std::vector<std::uint16_t>& texels = light_.bricks_[b].texels;
    if (texels.empty())
        return mean(brick);
    const int edge = kBrickExtent >> level;
    return texels[cellCount(glm::ivec3(edge)) * static_cast<std::size_t>(channel_) +
                  linearIndex(i & (edge - 1), glm::ivec3(edge))];
}

float StoredLight::Channel::mean(const glm::ivec3& brick) const {
    const std::size_t b = linearIndex(brick, light_.selection_->bricks);
    return light_
        .standing_[b * static_cast<std::size_t>(light_.channels_) + static_cast<std::size_t>(channel_)];
}

bool StoredLight::Channel::isEmpty(const glm::ivec3& brick) const {
    return light_.selection_->levels[linearIndex(brick, light_.selection_->bricks)] == Selection::kEmpty;
}

} // namespace tessera
