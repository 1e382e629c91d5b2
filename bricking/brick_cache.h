// bricking/brick_cache.h: decoded chunks in RAM, least recently used, inside a byte budget, filled by loader
// threads. A brick of level l is a sub-box of one chunk of level l, so chunks are the unit.
//
//   absent --request--> queued --thread--> decoding --> resident --evicted (unpinned, least recent)--> absent
//                          \-------------- failed: the request's future holds the exception; absent again
//
// A request for a chunk that is queued or decoding joins it. A chunk is pinned while anyone holds its pointer.
#pragma once

#include "bricking/store/store_reader.h"
#include "core/brick.h"
#include "core/budget.h"

#include <cstddef>
#include <cstdint>
#include <future>
#include <memory>
#include <span>
#include <vector>

namespace tessera {

/// One decoded chunk: [z][y][x], kChunkExtent^3 stored values.
struct Chunk {
    std::unique_ptr<std::byte[]> bytes;
    std::size_t size = 0;
    Charge charge;
};
using ChunkPointer = std::shared_ptr<const Chunk>;
using ChunkFuture = std::shared_future<ChunkPointer>;

class BrickCache {
  public:
    /// @param budgetBytes  most bytes of chunks, resident and in flight, also charged to ram; at least
    ///                     floorBytes(), else InputError that names the floor
    BrickCache(const StoreReader& store, Ledger& ram, std::size_t budgetBytes, int threads);
    ~BrickCache(); // drops queued work, waits for what is being decoded
    BrickCache(const BrickCache&) = delete;
    BrickCache& operator=(const BrickCache&) = delete;

    /// Asks for a batch; one future per key, in order. Never blocks on decoding.
    std::vector<ChunkFuture> request(std::span<const ChunkKey> keys);
    /// One chunk, now: resident at once, or waits. Thread-safe. Throws what decoding threw.
    ChunkPointer get(const ChunkKey& key);
    /// Chunks that one caller may keep pinned and still expect progress.
    std::size_t pinnableChunks() const;
    static std::size_t floorBytes(const StoreReader& store, int threads);

    struct Counters {
        std::uint64_t hits = 0, joins = 0, misses = 0, evictions = 0, bytesDecoded = 0;
    };
    Counters counters() const;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace tessera
