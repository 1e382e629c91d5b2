// viewer/session/volume_labels.cpp: see volume_labels.h.
#include "viewer/session/volume_labels.h"

#include "bricking/labels/label_names.h"
#include "bricking/labels/label_volume.h"
#include "core/base/brick.h"
#include "render/labels/label_looks.h" // namedLabels

#include <cstring>
#include <glm/common.hpp>

namespace tessera {

LabelVoxels::LabelVoxels(const StoreReader& voxels, int level)
    : voxels_(voxels), level_(level), chunk_(voxels.chunkBytes()) {}

std::size_t LabelVoxels::setAt(const glm::ivec3& voxel) {
    const glm::ivec3 chunk = voxel / kChunkExtent;
    if (chunk != chunkAt_) {
        chunkAt_ = glm::ivec3(-1); // until it is read
        voxels_.readChunk({level_, chunk.x, chunk.y, chunk.z}, chunk_);
        chunkAt_ = chunk;
    }
    const std::size_t at = linearIndex(voxel - chunk * kChunkExtent, glm::ivec3(kChunkExtent));
    if (voxels_.info().type == ValueType::u8)
        return std::to_integer<std::size_t>(chunk_[at]);
    std::uint16_t set = 0;
    std::memcpy(&set, chunk_.data() + at * sizeof set, sizeof set);
    return set;
}

VolumeLabels::VolumeLabels(const Labels& labels, MemoryBudget& ram) {
    const LabelVolume volume(labels.store, ram);
    table_ = namedLabels(volume.table(), labels);
    charge_ = ram.charge(bytesOf(table_), "the list of labels");
    std::vector<bool> hasVoxels(table_.sets.size());
    for (const LabelCells::Share& share : volume.cells().shares)
        hasVoxels[share.set] = true;
    hasVoxels_.resize(table_.labels.size());
    for (std::size_t set = 0; set < hasVoxels.size(); ++set)
        for (const std::uint16_t number : table_.sets[set])
            hasVoxels_[number] = hasVoxels_[number] || hasVoxels[set];
}

LabelList VolumeLabels::list() const {
    LabelList list;
    for (std::size_t n = 0; n < table_.labels.size(); ++n) {
        const Label& label = table_.labels[n];
        list.push_back({label.value, label.name, label.group, label.colour.value_or(labelColour(label.value)),
                        hasVoxels_[n]});
    }
    return list;
}

std::vector<std::uint32_t> VolumeLabels::at(const StoreReader& voxels, const glm::dvec3& voxel) const {
    const glm::ivec3 last = voxels.info().extentVoxels - 1;
    const std::size_t set =
        LabelVoxels(voxels, 0).setAt(glm::clamp(glm::ivec3(glm::floor(voxel)), glm::ivec3(0), last));
    std::vector<std::uint32_t> values;
    if (set < table_.sets.size())
        for (const std::uint16_t number : table_.sets[set])
            values.push_back(table_.labels[number].value);
    return values;
}

} // namespace tessera
