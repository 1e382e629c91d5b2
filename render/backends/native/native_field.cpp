// render/backends/native/native_field.cpp: see native_field.h.
#include "render/backends/native/native_field.h"

#include "core/base/error.h"

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

namespace {

/// The eight samples of a cell whose lowest one is the n-th, `row` and `slice` apart.
template <typename Sample>
float trilinearAt(const void* samples, std::int64_t n, std::int64_t row, std::int64_t slice,
                  const glm::vec3& f) {
    const auto* const s = static_cast<const Sample*>(samples) + n;
    const auto at = [s](std::int64_t offset) { return static_cast<float>(s[offset]); };
    return leaf::trilinear(at(0), at(1), at(row), at(row + 1), at(slice), at(slice + 1), at(slice + row),
                           at(slice + row + 1), f.x, f.y, f.z);
}

} // namespace

/// As packets do (packet_field.h): the cell's own brick has all that it needs.
bool NativeField::valueInBrick(const glm::vec3& p, float& value) const {
    const float perVoxel = 1.0f / static_cast<float>(1 << level_);
    const glm::vec3 at = p * perVoxel - 0.5f, low = glm::floor(at);
    const glm::ivec3 cell(low), brick = cell >> (5 - level_);
    if (level_ + 1 >= kLevelCount || glm::any(glm::lessThan(brick, glm::ivec3(0))) ||
        glm::any(glm::greaterThanEqual(brick, plane_.grid())))
        return false;
    const PacketBrick& b = brickAt(brick);
    const glm::ivec3 inside = cell & ((kBrickExtent >> level_) - 1);
    const auto byte = [](std::uint32_t word, int axis) {
        return static_cast<int>((word >> (8 * axis)) & 255u) - 8;
    };
    for (int axis = 0; axis < 3; ++axis)
        if (inside[axis] < byte(b.low, axis) || inside[axis] >= byte(b.high, axis))
            return false;
    const std::int64_t row = plane_.rowPitch(level_), slice = plane_.slicePitch(level_);
    const std::int64_t n = std::int64_t{b.base} + inside.z * slice + inside.y * row + inside.x;
    const glm::vec3 f = at - low;
    switch (plane_.kind()) {
    case native::SampleKind::i16:
        value = trilinearAt<std::int16_t>(plane_.samples(), n, row, slice, f);
        return true;
    case native::SampleKind::u16:
        value = trilinearAt<std::uint16_t>(plane_.samples(), n, row, slice, f);
        return true;
    case native::SampleKind::f32:
        break;
    }
    value = trilinearAt<float>(plane_.samples(), n, row, slice, f);
    return true;
}

float NativeField::value(const glm::vec3& p) {
    if (map_)
        return interblockValue(*this, p);
    if (float value = 0; !wanted_ && valueInBrick(p, value))
        return value;
    return fieldValue(*this, p, 1.0f / static_cast<float>(1 << level_));
}

float NativeField::pitch(const glm::vec3& p) const {
    return static_cast<float>(1 << (map_ ? map_->levelAt(p) : level_));
}

glm::vec3 NativeField::gradient(const glm::vec3& p, Gradient by) {
    if (map_)
        return interblockGradient(*this, p, by);
    if (by != Gradient::analytic)
        return differences(
            by, [this](const glm::vec3& at) { return value(at); }, p, static_cast<float>(1 << level_));
    return fieldGradient(*this, p, 1.0f / static_cast<float>(1 << level_), by);
}

void NativeField::setLight(const std::vector<std::unique_ptr<HostPlane>>& planes) {
    light_.clear();
    for (const auto& plane : planes)
        light_.emplace_back(*plane, map_, level_, kind_);
}

leaf::ReceivedLight<float> NativeField::received(const glm::vec3& p, const leaf::LightingNumbers& lighting) {
    return leaf::receivedLight<float>(lighting, [&](int channel) {
        NativeField& field = light_[static_cast<std::size_t>(channel)];
        const float texel = field.value(p);
        missing_ = field.takeMissing() || missing_;
        return texel * (1 / leaf::kLightOne);
    });
}

void NativeField::setLabels(const std::vector<std::unique_ptr<HostPlane>>& planes,
                            const leaf::LabelNumbers& numbers) {
    numbers_ = numbers;
    labels_.clear();
    for (const auto& plane : planes)
        labels_.emplace_back(*plane, map_, level_, kind_);
}

float NativeField::labelAt(int channel, const glm::vec3& p) {
    NativeField& field = labels_[static_cast<std::size_t>(channel)];
    field.name(wanted_, ray_);
    const float texel = field.value(p);
    missing_ = field.takeMissing() || missing_;
    return texel * (1 / leaf::kLightOne);
}

leaf::LabelShares<float> NativeField::labels(const glm::vec3& p) {
    const glm::vec3 at = leaf::placeOfLabels(numbers_, p, [&] { return pitch(p); });
    return leaf::labelShares<float>(numbers_, [&](int channel) { return labelAt(channel, at); });
}

glm::vec3 NativeField::mediumGradient(const glm::vec3& p) {
    return leaf::mediumGradient<float>(p, [&](const glm::vec3& at) { return labelAt(numbers_.solid, at); });
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
