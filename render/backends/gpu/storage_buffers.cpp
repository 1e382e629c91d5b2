// render/backends/gpu/storage_buffers.cpp: see storage_buffers.h.
#include "render/backends/gpu/storage_buffers.h"

#include "core/base/error.h"

namespace tessera {

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
