// render/engines/native/native_field.cpp: see native_field.h.
#include "render/engines/native/native_field.h"

#include "core/error.h"

#include <atomic>
#include <utility>

namespace tessera {

using native::PacketBrick;

void WantedBricks::name(std::size_t brick, std::uint32_t ray) {
    TESSERA_CHECK(brick < first_.size()); // else nobody said that rays may wait
    std::atomic_ref<std::uint32_t> first(first_[brick]);
    std::uint32_t now = first.load(std::memory_order_relaxed);
    while (ray < now && !first.compare_exchange_weak(now, ray, std::memory_order_relaxed)) {
    }
}

std::vector<std::uint32_t> WantedBricks::take() {
    std::vector<std::uint32_t> taken(first_.size(), UINT32_MAX);
    std::swap(taken, first_);
    return taken;
}

float NativeField::value(const glm::vec3& p) {
    if (map_)
        return interblockValue(*this, p);
    return fieldValue(*this, p, 1.0f / static_cast<float>(1 << level_));
}

float NativeField::pitch(const glm::vec3& p) const {
    if (!map_)
        return static_cast<float>(1 << level_);
    const auto place = cornerPlace(p, glm::vec3(map_->extentVoxels), map_->bricks);
    const std::uint32_t code = map_->at(place.corner).code(place.current);
    return static_cast<float>(1 << (code == BrickCorner::kEmpty ? map_->finest : code));
}

glm::vec3 NativeField::gradient(const glm::vec3& p) {
    if (map_)
        return interblockGradient(*this, p, kind_);
    return fieldGradient(*this, p, 1.0f / static_cast<float>(1 << level_), kind_);
}

float NativeField::at(int level, const glm::ivec3& i) {
    const glm::ivec3 at = i >> (5 - level);
    const PacketBrick& brick = brickAt(at);
    const std::uint32_t state = brick.low >> 24;
    if (state == PacketBrick::kValue)
        return brick.mean;
    if (wanted_) // those that are there too, or they would make room for the others
        wanted_->name(linearIndex(at, plane_.grid()), ray_);
    if (state == PacketBrick::kAbsent) {
        missing_ = true;
        return 0;
    }
    return plane_.sampleAt(brick, level, i);
}

} // namespace tessera
