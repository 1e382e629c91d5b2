// bricking/cache/brick_cache.h: decoded chunks in RAM, least recently used, inside a byte budget, filled by
// loader threads. A brick of level l is a sub-box of one chunk of level l, so chunks are the unit.
//
//   absent --request--> queued --room, thread--> decoding --> resident --unpinned, least recent--> absent
//                                                    \-- failed: the future holds the exception --> absent
//
// A request for a chunk that is queued or decoding joins it. A chunk is pinned while its pointer, or a future
// that has it, is held; only unpinned chunks are evicted. A queued chunk waits until there is room: it takes
// the bytes of one chunk before it is decoded. bricking/README.md has the state machine.
#pragma once

#include "bricking/cache/chunk_source.h"
#include "core/base/brick.h"
#include "core/base/budget.h"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <future>
#include <memory>
#include <span>
#include <thread>
#include <vector>

namespace tessera {

/// One decoded chunk: [z][y][x], kChunkExtent^3 stored values. Its bytes are part of the cache's charge.
struct Chunk {
    std::unique_ptr<std::byte[]> bytes;
    std::size_t size = 0;
};
using ChunkPointer = std::shared_ptr<const Chunk>;
using ChunkFuture = std::shared_future<ChunkPointer>;

class BrickCache {
  public:
    /// @param budgetBytes  most bytes of chunks, pinned, resident and in flight. They are charged to ram as a
    ///     whole, so no chunk is ever refused later. At least floorBytes(), else InputError naming the floor
    /// @param threads  that decode; 0: all processors
    /// source must outlive the cache; ram must outlive every pointer as well.
    BrickCache(const ChunkSource& source, MemoryBudget& ram, std::size_t budgetBytes, int threads);
    /// Drops queued work (its futures throw Error) and waits for chunks being decoded. Pointers stay valid.
    ~BrickCache();
    BrickCache(const BrickCache&) = delete;
    BrickCache& operator=(const BrickCache&) = delete;

    /// Requests a batch; one future per key, in order. Never blocks on decoding. A key must be inside its
    /// level. Dropping the future leaves the work queued, as a prefetch.
    std::vector<ChunkFuture> request(std::span<const ChunkKey> keys);
    /// Returns one chunk; waits unless it is resident. Thread-safe. Throws what decoding threw.
    ChunkPointer get(const ChunkKey& key);

    /// Tells the source what get() will soon read (ChunkSource::willRead()). Loads nothing.
    void tell(std::span<const ChunkKey> keys) const;

    /// Sets the chunks to prefetch, most urgent first, each once. The list replaces the last one, and chunks
    /// that are neither on it nor being decoded are dropped. Loaders turn to it when no request is queued.
    /// Loaded chunks stay until they are taken or no longer wanted; at most half of pinnableChunks() are
    /// loaded ahead.
    void want(std::span<const ChunkKey> keys);
    /// A chunk if it is resident, else null; it is then no longer wanted. Throws what decoding threw.
    ChunkPointer take(const ChunkKey& key);
    /// Waits until a wanted chunk is resident or has failed, none is wanted, or the deadline.
    void waitForWanted(std::chrono::steady_clock::time_point deadline) const;

    /// Number of chunks that all callers together may hold without deadlock: pointers, futures not yet
    /// dropped, and loaded chunks of the wanted list. It is budget / chunk bytes - threads, so that every
    /// loader has room.
    std::size_t pinnableChunks() const;
    /// Eight pinned chunks, the neighbourhood of one sample, and one per loader.
    static std::size_t floorBytes(const VolumeInfo& info, int threads);

    struct Counters {
        std::uint64_t hits = 0, joins = 0, misses = 0, evictions = 0, bytesDecoded = 0;
        std::uint64_t forgotten = 0;              // wanted, and dropped before they were decoded
        std::size_t heldBytes = 0, peakBytes = 0; // of chunks, now and at most so far
    };
    Counters counters() const;

  private:
    struct State;
    std::shared_ptr<State> state_; // shared with the pointers given out
    std::vector<std::jthread> loaders_;
};

} // namespace tessera
