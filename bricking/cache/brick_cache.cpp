// bricking/cache/brick_cache.cpp: see brick_cache.h. One mutex guards all state. Nothing that could release a
// pointer or wake a waiter runs while it is held.
#include "bricking/cache/brick_cache.h"

#include "core/base/error.h"
#include "core/base/threads.h"

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <exception>
#include <list>
#include <mutex>
#include <optional>
#include <unordered_map>
#include <utility>

namespace tessera {
namespace {

constexpr std::size_t kPinnedFloor = 8; // the chunks around one corner
constexpr std::size_t kToldAhead = 256; // of the chunks that are wanted: the list is soon another
std::size_t loaderCount(int threads) {
    return static_cast<std::size_t>(threads > 0 ? threads : defaultThreads());
}

enum class Stage { queued, decoding, resident };

struct Entry {
    Stage stage = Stage::queued;
    // Queued and decoding: the promise of the result. Empty once resident, or the entry would pin itself.
    std::optional<std::promise<ChunkPointer>> promise;
    ChunkFuture future;
    // Resident.
    std::unique_ptr<const Chunk> chunk;
    int pins = 0;
    std::list<ChunkKey>::iterator idleAt; // valid while resident with pins == 0
};

/// State of a chunk to prefetch.
struct Wish {
    ChunkPointer chunk; // there
    std::exception_ptr failure;
    bool loading = false;
    bool settled() const { return chunk || failure; }
};

} // namespace

struct BrickCache::State : std::enable_shared_from_this<State> {
    State(const ChunkSource& read, MemoryBudget& ram, std::size_t budgetBytes, std::size_t chunk)
        : source(read), chunkBytes(chunk), capacity(budgetBytes / chunk),
          charge(ram.charge(budgetBytes, "the cache of chunks")) {}

    ChunkPointer pin(const ChunkKey& key, Entry& entry);
    void unpin(const ChunkKey& key);
    ChunkFuture ask(const ChunkKey& key, ChunkPointer& resident);
    bool roomForOne() const { return held < capacity || !idle.empty(); }
    /// Chunks held, or about to be held, by prefetching.
    bool mayLoadAhead() const { return ahead < std::max<std::size_t>(1, (capacity - loaders) / 2); }
    bool hasJob() const { return roomForOne() && (!queue.empty() || (!wishes.empty() && mayLoadAhead())); }
    std::optional<ChunkKey> nextJob();
    void loaderLoop();
    void load(const ChunkKey& key);
    std::unique_ptr<Chunk> decode(const ChunkKey& key) const;

    const ChunkSource& source;
    const std::size_t chunkBytes, capacity; // capacity in chunks
    std::size_t loaders = 0;
    const Charge charge;

    mutable std::mutex mutex;
    std::condition_variable wake; // a queued job and room for it, or stop
    bool stop = false;
    std::unordered_map<ChunkKey, Entry, ChunkKeyHash> entries;
    std::deque<ChunkKey> queue;
    std::deque<ChunkKey> wishes; // wanted, not started; most urgent first
    std::unordered_map<ChunkKey, Wish, ChunkKeyHash> wanted;
    std::size_t ahead = 0;           // of wanted: loading or resident
    std::condition_variable settled; // one more request
    std::list<ChunkKey> idle;        // resident and unpinned, least recently used first
    std::size_t held = 0;            // chunks decoding or resident; held <= capacity
    Counters counters;
};

/// Under the mutex: a pointer whose destruction unpins.
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
        if (!hasJob())
            return; // readers unpin constantly; waking a loader needlessly costs more
    }
    wake.notify_one();
}

/// A future for a chunk in progress, or the resident chunk in `resident` and no future.
ChunkFuture BrickCache::State::ask(const ChunkKey& key, ChunkPointer& resident) {
    const glm::ivec3 grid = key.level >= 0 && key.level < kLevelCount
                                ? chunkGrid(source.info().extentVoxels, key.level)
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

/// Under the mutex: a chunk to decode, its entry made. Requests precede prefetching. Nullopt if the next
/// prefetch needed no decoding.
std::optional<ChunkKey> BrickCache::State::nextJob() {
    if (!queue.empty()) {
        const ChunkKey key = queue.front();
        queue.pop_front();
        return key;
    }
    const ChunkKey key = wishes.front();
    wishes.pop_front();
    Wish& wish = wanted.at(key);
    ++ahead;
    const auto [at, isNew] = entries.try_emplace(key);
    Entry& entry = at->second;
    if (entry.stage == Stage::resident) {
        ++counters.hits;
        wish.chunk = pin(key, entry);
        settled.notify_all();
        return {};
    }
    wish.loading = true; // resident, or being decoded; it cannot be queued, because the queue is empty
    if (!isNew) {
        ++counters.joins;
        return {};
    }
    ++counters.misses;
    entry.idleAt = idle.end();
    entry.promise.emplace();
    entry.future = entry.promise->get_future().share();
    return key;
}

void BrickCache::State::loaderLoop() {
    while (true) {
        ChunkKey key;
        std::unique_ptr<const Chunk> evicted; // freed before the new one is made
        {
            std::unique_lock lock(mutex);
            wake.wait(lock, [&] { return stop || hasJob(); });
            if (stop)
                return;
            const std::optional<ChunkKey> job = nextJob();
            if (!job)
                continue;
            key = *job;
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
    source.readChunk(key, {chunk->bytes.get(), chunkBytes});
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
        if (const auto wish = wanted.find(key); wish != wanted.end() && wish->second.loading) {
            wish->second.loading = false;
            wish->second.chunk = pointer;
            wish->second.failure = failure;
            settled.notify_all();
        }
    }
    if (failure) {
        wake.notify_one(); // its room is free
        promise->set_exception(failure);
    } else {
        promise->set_value(std::move(pointer));
    }
}

BrickCache::BrickCache(const ChunkSource& source, MemoryBudget& ram, std::size_t budgetBytes, int threads) {
    if (budgetBytes < floorBytes(source.info(), threads))
        throw InputError("the cache of chunks needs at least " +
                         formatBytes(floorBytes(source.info(), threads)) + ", but was given " +
                         formatBytes(budgetBytes) + "; raise " + ram.option());
    state_ = std::make_shared<State>(source, ram, budgetBytes, source.chunkBytes());
    state_->loaders = loaderCount(threads);
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
        state_->wishes.clear();
    }
    want({});
    state_->wake.notify_all();
    for (auto& promise : dropped)
        promise.set_exception(
            std::make_exception_ptr(Error("the cache was closed before the chunk was loaded")));
    loaders_.clear(); // joins
}

std::vector<ChunkFuture> BrickCache::request(std::span<const ChunkKey> keys) {
    state_->source.willRead(keys);
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

void BrickCache::tell(std::span<const ChunkKey> keys) const {
    state_->source.willRead(keys);
}

void BrickCache::want(std::span<const ChunkKey> keys) {
    state_->source.willRead(keys.first(std::min(keys.size(), kToldAhead)));
    std::unordered_map<ChunkKey, Wish, ChunkKeyHash> before; // its pointers die after the lock
    {
        const std::lock_guard lock(state_->mutex);
        State& s = *state_;
        before.swap(s.wanted);
        s.wishes.clear();
        s.ahead = 0;
        for (const ChunkKey& key : keys) {
            const auto [at, isNew] = s.wanted.try_emplace(key);
            TESSERA_CHECK(isNew);
            Wish& wish = at->second;
            if (const auto old = before.find(key); old != before.end() && !old->second.failure) {
                wish = std::move(old->second);
                before.erase(old);
            }
            if (wish.chunk || wish.loading)
                ++s.ahead;
            else
                s.wishes.push_back(key);
        }
        for (const auto& [key, wish] : before)
            if (!wish.settled() && !wish.loading)
                ++s.counters.forgotten;
    }
    state_->wake.notify_all();
    state_->settled.notify_all();
}

ChunkPointer BrickCache::take(const ChunkKey& key) {
    ChunkPointer chunk;
    std::exception_ptr failure;
    {
        const std::lock_guard lock(state_->mutex);
        State& s = *state_;
        const auto wish = s.wanted.find(key);
        if (wish != s.wanted.end() && wish->second.settled()) {
            chunk = std::move(wish->second.chunk);
            failure = wish->second.failure;
            s.wanted.erase(wish);
            --s.ahead;
        } else if (const auto entry = s.entries.find(key);
                   entry != s.entries.end() && entry->second.stage == Stage::resident) {
            ++s.counters.hits;
            chunk = s.pin(key, entry->second);
            if (wish != s.wanted.end()) { // it was still in the list
                s.wishes.erase(std::find(s.wishes.begin(), s.wishes.end(), key));
                s.wanted.erase(wish);
            }
        }
    }
    state_->wake.notify_all();
    if (failure)
        std::rethrow_exception(failure);
    return chunk;
}

void BrickCache::waitForWanted(std::chrono::steady_clock::time_point deadline) const {
    std::unique_lock lock(state_->mutex);
    state_->settled.wait_until(lock, deadline, [&] {
        return state_->wanted.empty() || std::any_of(state_->wanted.begin(), state_->wanted.end(),
                                                     [](const auto& w) { return w.second.settled(); });
    });
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
