// render/labels/label_field.cpp: see label_field.h.
#include "render/labels/label_field.h"

#include "core/base/brick.h"

#include <algorithm>

namespace tessera {
namespace {

std::size_t texelBytesOf(const DrawnLabels& labels) {
    return static_cast<std::size_t>(labels.numbers().count) * kBrickTexels * sizeof(std::uint16_t);
}

} // namespace

LabelBricks::LabelBricks(const DrawnLabels& labels, MemoryBudget& ram)
    : labels_(labels),
      charge_(ram.charge(kMost * texelBytesOf(labels), "labels of bricks while they are read")) {}

LabelBricks::Texels LabelBricks::get(std::size_t brick, int level) {
    const std::pair key(brick, level);
    {
        const std::lock_guard lock(mutex_);
        if (const auto found = kept_.find(key); found != kept_.end()) {
            found->second.used = ++turn_;
            return found->second.texels;
        }
    }
    auto texels = std::make_shared<std::vector<std::uint16_t>>(
        static_cast<std::size_t>(labels_.numbers().count) * kBrickTexels);
    labels_.fill(brick, level, *texels);
    const std::lock_guard lock(mutex_);
    if (kept_.size() >= kMost)
        kept_.erase(std::min_element(kept_.begin(), kept_.end(), [](const auto& a, const auto& b) {
            return a.second.used < b.second.used;
        }));
    kept_[key] = {texels, ++turn_};
    return texels;
}

float LabelField::at(int channel, int level, const glm::ivec3& i) {
    const glm::ivec3 place = i >> (5 - level);
    const std::size_t brick = linearIndex(place, selection_.bricks);
    Recent& recent =
        recent_[static_cast<std::size_t>((place.x & 3) | (place.y & 1) << 2 | (place.z & 1) << 3)];
    if (recent.brick != brick) {
        const int own = selection_.levels[brick];
        recent = {brick, own + 1 < kLevelCount ? bricks_.get(brick, own) : nullptr};
    }
    if (!recent.texels)
        return labels().standing(brick, channel);
    return (*recent.texels)[static_cast<std::size_t>(channel) * kBrickTexels +
                            linearIndex(i & ((kBrickExtent >> level) - 1), glm::ivec3(kBrickExtent))];
}

} // namespace tessera
