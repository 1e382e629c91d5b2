// render/labels/label_plane.cpp: see label_plane.h.
#include "render/labels/label_plane.h"

#include "core/base/brick.h"
#include "core/base/error.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <memory>
#include <utility>

namespace tessera {
namespace {

constexpr std::uint32_t kValueBit = 0x80000000u; // brick_residency.h

} // namespace

LabelPlane::LabelPlane(const DrawnLabels& labels, std::vector<Plane*> channels)
    : labels_(labels), channels_(std::move(channels)) {
    TESSERA_CHECK(static_cast<int>(channels_.size()) == labels_.numbers().count);
}

void LabelPlane::put(const AtlasSlot& slot, const BrickSamples& samples, Work& work) {
    std::vector<std::uint16_t> texels(channels_.size() * kBrickTexels);
    labels_.fill(samples.brick, slot.level, texels);
    Chunk chunk; // in the layout of a chunk's samples, as planes need it
    chunk.size = kBrickTexels * sizeof(std::uint16_t);
    chunk.bytes = std::make_unique_for_overwrite<std::byte[]>(chunk.size);
    for (std::size_t c = 0; c < channels_.size(); ++c) {
        std::memcpy(chunk.bytes.get(), texels.data() + c * kBrickTexels, chunk.size);
        channels_[c]->put(slot, {chunk, glm::ivec3(0), samples.edge, samples.brick}, work);
    }
}

bool LabelPlane::takesManyAtOnce() const {
    return std::all_of(channels_.begin(), channels_.end(),
                       [](const Plane* channel) { return channel->takesManyAtOnce(); });
}

void LabelPlane::finish() {
    for (Plane* channel : channels_)
        channel->finish();
}

void LabelPlane::publish(std::span<const BrickEntry> entries) {
    std::vector<BrickEntry> mine(entries.begin(), entries.end());
    for (std::size_t c = 0; c < channels_.size(); ++c) {
        for (std::size_t b = 0; b < mine.size(); ++b)
            if ((entries[b].x & kValueBit) != 0)
                mine[b].y = std::bit_cast<std::uint32_t>(
                    static_cast<float>(labels_.standing(b, static_cast<int>(c))));
        channels_[c]->publish(mine);
    }
}

} // namespace tessera
