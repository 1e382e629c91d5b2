// bricking/validate/mend_levels.cpp: StoredLevels makes shards again: see stored_levels.h. A shard is written
// as an import writes it, chunk after chunk in the order of its index, and compared with what zarr.json says
// of it.
#include "bricking/store/codec.h"
#include "bricking/validate/stored_levels.h"
#include "bricking/validate/written_place.h"
#include "core/base/error.h"
#include "core/base/output_file.h"
#include "core/base/threads.h"

#include <algorithm>
#include <cstring>
#include <utility>

namespace tessera {
namespace fs = std::filesystem;

void StoredLevels::repair(const ShareDone& progress) {
    for (int l = 0; l < kLevelCount; ++l) {
        const std::size_t shards = levels_[static_cast<std::size_t>(l)].shards.size();
        for (std::size_t n = 0; n < shards; ++n) {
            const std::string part = shardPath(l, gridPosition(n, files_->layout(l).shards));
            if (l == 0 && faults_.has(part))
                faults_.leave(part, "level 0 is made by an import alone");
            else if (l > 0 && hasFault(l, n))
                mendShard(l, n);
        }
        if (progress)
            progress(static_cast<double>(l + 1) / kLevelCount);
    }
}

void StoredLevels::mendShard(int l, std::size_t n) {
    Level& level = levels_[static_cast<std::size_t>(l)];
    const ShardLayout layout = files_->layout(l);
    const glm::ivec3 at = gridPosition(n, layout.shards);
    const std::string part = shardPath(l, at);
    const fs::path store = files_->path();
    try {
        if (std::string why = whyNotWritten(store, part); !why.empty())
            return faults_.leave(part, why);
        if (files_->record(l, at).chunks == 0) {
            fs::remove(store / part);
            level.shards[n] = 0;
            if (hasFault(l, n))
                return faults_.leave(part, "zarr.json contradicts level " + std::to_string(l - 1));
            return faults_.mend(part);
        }
        if (!reduce_)
            return faults_.leave(part, "level 0, by which names are counted, is damaged");
        std::string why = makeShard(l, at, false);
        if (!why.empty())
            why = makeShard(l, at, true);
        if (!why.empty())
            return faults_.leave(part, why);
    } catch (const Error& problem) {
        return faults_.leave(part, problem.what());
    } catch (const fs::filesystem_error& problem) {
        return faults_.leave(part, problem.code().message());
    }
    level.shards[n] = 0;
    const glm::ivec3 first = at * layout.chunks, end = glm::min(first + layout.chunks, level.grid);
    for (int k = first.z; k < end.z; ++k)
        for (int j = first.y; j < end.y; ++j)
            for (int i = first.x; i < end.x; ++i)
                stateOf({l, i, j, k}) = 0;
    const StoreMetadata& metadata = metadata_;
    files_.reset(); // it may have the old file open
    files_.emplace(store, metadata, ram_, 1);
    faults_.mend(part);
}

/// One chunk of a shard that is made again: as it is where it is whole, else from the level before.
void StoredLevels::makeChunk(Slot& slot, bool deriveAll) {
    slot.problem.clear();
    slot.result = {};
    const BufferPool::Lease lease(*pool_);
    const Room room = roomOf(lease);
    const std::uint8_t state = stateOf(slot.key);
    if (state != 0 || deriveAll) {
        if (assemble(slot.key, room, false)) {
            reduce(slot.key, room);
            slot.result = encodeUnlessFill(room.made, fillChunk_, valueBytes_, slot.encoded, metadata_.codec);
            return;
        }
        if (state != 0) {
            slot.problem = "chunks of level " + std::to_string(slot.key.level - 1) + " under " +
                           describe(slot.key) + " are damaged too";
            return;
        }
    }
    const std::span<std::byte> encoded = files_->read(slot.key, room.encoded);
    std::copy(encoded.begin(), encoded.end(), slot.encoded.begin());
    slot.result.bytes = encoded.size();
    if (!encoded.empty())
        std::memcpy(&slot.result.crc, encoded.data() + encoded.size() - kCrcBytes, kCrcBytes);
}

/// @return "", or why the shard stays as it is
std::string StoredLevels::makeShard(int l, const glm::ivec3& at, bool deriveAll) {
    const Level& level = levels_[static_cast<std::size_t>(l)];
    const ShardLayout& layout = files_->layout(l);
    const ShardRecord& expected = files_->record(l, at);
    const fs::path path = files_->path() / shardPath(l, at);
    const Charge charge =
        ram_.charge(threads_ * encodedBound(chunkBytes_) + layout.entries() * (sizeof(ShardEntry) + 4),
                    "making a shard again");
    std::vector<Slot> slots(threads_);
    for (Slot& slot : slots)
        slot.encoded.resize(encodedBound(chunkBytes_));
    std::vector<ShardEntry> entries(layout.entries());
    std::vector<std::uint32_t> crcs(layout.entries());
    fs::create_directories(path.parent_path());
    OutputFile file(path);
    std::uint64_t bytes = 0;
    std::string why;
    std::size_t used = 0;
    const auto flush = [&] {
        parallelFor(used, static_cast<int>(threads_), [&](std::size_t i) { makeChunk(slots[i], deriveAll); });
        for (const Slot& slot : std::span(slots).first(used)) {
            if (!slot.problem.empty() && why.empty())
                why = slot.problem;
            if (slot.result.bytes == 0)
                continue;
            const std::size_t entry = layout.entryOf(slot.key);
            file.writeAt(bytes, std::span(std::as_const(slot.encoded)).first(slot.result.bytes));
            entries[entry] = {bytes, slot.result.bytes};
            crcs[entry] = slot.result.crc;
            bytes += slot.result.bytes;
        }
        used = 0;
    };
    const glm::ivec3 first = at * layout.chunks, end = glm::min(first + layout.chunks, level.grid);
    for (int k = first.z; k < end.z && why.empty(); ++k)
        for (int j = first.y; j < end.y; ++j)
            for (int i = first.x; i < end.x; ++i) {
                slots[used++].key = {l, i, j, k};
                if (used == slots.size())
                    flush();
            }
    flush();
    if (!why.empty())
        return why;
    const std::vector<std::byte> index = encodeIndex(entries);
    const ShardRecord made = shardRecord(entries, crcs, index);
    if (made.chunks != expected.chunks || made.indexCrc != expected.indexCrc ||
        made.payloadCrc != expected.payloadCrc)
        return "what level " + std::to_string(l - 1) + " gives is not what zarr.json describes";
    file.writeAt(bytes, index);
    file.finish();
    return {};
}

} // namespace tessera
