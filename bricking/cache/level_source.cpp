// bricking/cache/level_source.cpp: see level_source.h.
#include "bricking/cache/level_source.h"

#include "core/base/brick.h"
#include "core/base/error.h"

#include <glm/ext/matrix_transform.hpp>
#include <glm/vec3.hpp>
#include <vector>

namespace tessera {

VolumeInfo infoOfLevel(const VolumeInfo& info, int level) {
    VolumeInfo own = info;
    own.extentVoxels = levelExtent(info.extentVoxels, level);
    own.patientFromVoxel = glm::scale(info.patientFromVoxel, glm::dvec3(1 << level));
    return own;
}

LevelSource::LevelSource(const ChunkSource& volume, int level)
    : volume_(volume), level_(level), info_(infoOfLevel(volume.info(), level)) {
    TESSERA_CHECK(level >= 0 && level < kLevelCount);
}

ChunkKey LevelSource::below(ChunkKey key) const {
    key.level += level_;
    TESSERA_CHECK(key.level < kLevelCount);
    return key;
}

void LevelSource::readChunk(const ChunkKey& key, std::span<std::byte> out) const {
    volume_.readChunk(below(key), out);
}

void LevelSource::willRead(std::span<const ChunkKey> keys) const {
    std::vector<ChunkKey> all;
    for (const ChunkKey& key : keys)
        all.push_back(below(key));
    volume_.willRead(all);
}

} // namespace tessera
