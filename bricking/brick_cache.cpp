// bricking/brick_cache.cpp: see brick_cache.h. One mutex guards all state; nothing that can run a pointer's
// release or a waiter's wake-up happens while it is held.
#include "bricking/brick_cache.h"

#include "core/error.h"
#include "core/threads.h"

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <list>
#include <mutex>
#include <optional>
#include <unordered_map>
#include <utility>

namespace tessera {
namespace {

constexpr std::size_t kPinnedFloor = 8; // the chunks around one corner
std::size_t loaderCount(int threads) {
    return static_cast<std::size_t>(threads > 0 ? threads : defaultThreads());
}

enum class Stage { queued, decoding, resident };

struct Entry {
    Stage stage = Stage::queued;
    // Queued and decoding: where the result goes. Empty once resident, or the entry would pin itself.
    std::optional<std::promise<ChunkPointer>> promise;
    ChunkFuture future;
    // Resident.
    std::unique_ptr<const Chunk> chunk;
    int pins = 0;
    std::list<ChunkKey>::iterator idleAt; // valid while resident with pins == 0
};

} // namespace

struct BrickCache::State : std::enable_shared_from_this<State> {
    State(const StoreReader& storeRead, Ledger& ram, std::size_t budgetBytes, std::size_t chunk)
        : store(storeRead), chunkBytes(chunk), capacity(budgetBytes / chunk),
          charge(ram.charge(budgetBytes, "the cache of chunks")) {}

    ChunkPointer pin(const ChunkKey& key, Entry& entry);
    void unpin(const ChunkKey& key);
    ChunkFuture ask(const ChunkKey& key, ChunkPointer& resident);
    bool roomForOne() const { return held < capacity || !idle.empty(); }
    void loaderLoop();
    void load(const ChunkKey& key);
    std::unique_ptr<Chunk> decode(const ChunkKey& key) const;

    const StoreReader& store;
    const std::size_t chunkBytes, capacity; // capacity in chunks
    const Charge charge;

    mutable std::mutex mutex;
    std::condition_variable wake; // a queued job and room for it, or stop
    bool stop = false;
    std::unordered_map<ChunkKey, Entry, ChunkKeyHash> entries;
    std::deque<ChunkKey> queue;
    std::list<ChunkKey> idle; // resident and unpinned, least recently used first
    std::size_t held = 0;     // chunks decoding or resident; held <= capacity
    Counters counters;
};

/// Under the mutex: a pointer whose death unpins.
ChunkPointer BrickCache::State::pin(const ChunkKey& key, Entry& entry) {
    if (entry.pins++ == 0 && entry.idleAt != idle.end()) {
        idle.erase(entry.idleAt);
        entry.idleAt = idle.end();
    }
    return ChunkPointer(entry.chunk.get(),
                        [self = shared_from_this(), key](const Chunk*) { self->unpin(key); });
}

void BrickCache::State::unpin(const ChunkKey& key) {
    {
        const std::lock_guard lock(mutex);
        Entry& entry = entries.at(key);
        if (--entry.pins > 0)
            return;
        entry.idleAt = idle.insert(idle.end(), key);
    }
    wake.notify_one();
}

/// A future for what is on its way, or the resident chunk in `resident` and no future.
ChunkFuture BrickCache::State::ask(const ChunkKey& key, ChunkPointer& resident) {
    const glm::ivec3 grid = key.level >= 0 && key.level < kLevelCount
                                ? chunkGrid(store.info().extentVoxels, key.level)
                                : glm::ivec3(0);
    TESSERA_CHECK(key.i >= 0 && key.j >= 0 && key.k >= 0 && key.i < grid.x && key.j < grid.y &&
                  key.k < grid.z);
    ChunkFuture future;
    {
        const std::lock_guard lock(mutex);
        const auto [at, isNew] = entries.try_emplace(key);
        Entry& entry = at->second;
        if (isNew) {
            ++counters.misses;
            entry.idleAt = idle.end();
            entry.promise.emplace();
            entry.future = entry.promise->get_future().share();
            queue.push_back(key);
        } else if (entry.stage == Stage::resident) {
            ++counters.hits;
            resident = pin(key, entry);
            return future;
        } else {
            ++counters.joins;
        }
        future = entry.future;
    }
    wake.notify_one();
    return future;
}

void BrickCache::State::loaderLoop() {
    while (true) {
        ChunkKey key;
        std::unique_ptr<const Chunk> evicted; // freed before the new one is made
        {
            std::unique_lock lock(mutex);
            wake.wait(lock, [&] { return stop || (!queue.empty() && roomForOne()); });
            if (stop)
                return;
            key = queue.front();
            queue.pop_front();
            if (held == capacity) {
                const auto victim = entries.find(idle.front());
                evicted = std::move(victim->second.chunk);
                idle.pop_front();
                entries.erase(victim);
                --held;
                ++counters.evictions;
            }
            ++held;
            counters.heldBytes = held * chunkBytes;
            counters.peakBytes = std::max(counters.peakBytes, counters.heldBytes);
            entries.at(key).stage = Stage::decoding;
        }
        evicted.reset();
        load(key);
    }
}

std::unique_ptr<Chunk> BrickCache::State::decode(const ChunkKey& key) const {
    auto chunk = std::make_unique<Chunk>();
    chunk->bytes = std::make_unique_for_overwrite<std::byte[]>(chunkBytes);
    chunk->size = chunkBytes;
    store.readChunk(key, {chunk->bytes.get(), chunkBytes});
    return chunk;
}

void BrickCache::State::load(const ChunkKey& key) {
    std::unique_ptr<Chunk> chunk;
    std::exception_ptr failure;
    try {
        chunk = decode(key);
    } catch (...) {
        failure = std::current_exception();
    }
    // Declared before the lock, so that they die, and perhaps unpin, after it.
    std::optional<std::promise<ChunkPointer>> promise;
    ChunkFuture future;
    ChunkPointer pointer;
    {
        const std::lock_guard lock(mutex);
        Entry& entry = entries.at(key);
        promise = std::exchange(entry.promise, std::nullopt);
        future = std::exchange(entry.future, {});
        if (failure) {
            entries.erase(key);
            --held;
            counters.heldBytes = held * chunkBytes;
        } else {
            entry.chunk = std::move(chunk);
            entry.stage = Stage::resident;
            counters.bytesDecoded += chunkBytes;
            pointer = pin(key, entry);
        }
    }
    if (failure) {
        wake.notify_one(); // its room is free
        promise->set_exception(failure);
    } else {
        promise->set_value(std::move(pointer));
    }
}

BrickCache::BrickCache(const StoreReader& store, Ledger& ram, std::size_t budgetBytes, int threads) {
    if (budgetBytes < floorBytes(store.info(), threads))
        throw InputError("the cache of chunks needs at least " +
                         formatBytes(floorBytes(store.info(), threads)) + ", but was given " +
                         formatBytes(budgetBytes) + "; raise " + ram.option());
    state_ = std::make_shared<State>(store, ram, budgetBytes, store.chunkBytes());
    for (std::size_t i = 0; i < loaderCount(threads); ++i)
        loaders_.emplace_back([state = state_.get()] { state->loaderLoop(); });
}

BrickCache::~BrickCache() {
    if (!state_)
        return;
    std::vector<std::promise<ChunkPointer>> dropped;
    {
        const std::lock_guard lock(state_->mutex);
        state_->stop = true;
        for (const ChunkKey& key : state_->queue) {
            const auto entry = state_->entries.find(key);
            dropped.push_back(std::move(*entry->second.promise));
            state_->entries.erase(entry);
        }
        state_->queue.clear();
    }
    state_->wake.notify_all();
    for (auto& promise : dropped)
        promise.set_exception(
            std::make_exception_ptr(Error("the cache was closed before the chunk was loaded")));
    loaders_.clear(); // joins
}

std::vector<ChunkFuture> BrickCache::request(std::span<const ChunkKey> keys) {
    std::vector<ChunkFuture> futures;
    futures.reserve(keys.size());
    for (const ChunkKey& key : keys) {
        ChunkPointer resident;
        ChunkFuture future = state_->ask(key, resident);
        if (resident) {
            std::promise<ChunkPointer> ready;
            ready.set_value(std::move(resident));
            future = ready.get_future().share();
        }
        futures.push_back(std::move(future));
    }
    return futures;
}

ChunkPointer BrickCache::get(const ChunkKey& key) {
    ChunkPointer resident;
    const ChunkFuture future = state_->ask(key, resident);
    return resident ? resident : future.get();
}

std::size_t BrickCache::pinnableChunks() const {
    return state_->capacity - loaders_.size();
}

std::size_t BrickCache::floorBytes(const VolumeInfo& info, int threads) {
    return (kPinnedFloor + loaderCount(threads)) * cellCount(glm::ivec3(kChunkExtent)) *
           bytesPerValue(info.type);
}

BrickCache::Counters BrickCache::counters() const {
    const std::lock_guard lock(state_->mutex);
    return state_->counters;
}

} // namespace tessera
