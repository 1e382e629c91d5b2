// bricking/store/buffer_pool.h: a fixed number of equal scratch buffers, charged once. A thread takes one,
// waits while all are taken, and gives it back when the lease dies. No thread holds two, so there is no
// deadlock.
#pragma once

#include "core/base/budget.h"

#include <condition_variable>
#include <cstddef>
#include <mutex>
#include <span>
#include <string_view>
#include <vector>

namespace tessera {

class BufferPool {
  public:
    /// Throws InputError naming what when ram cannot hold count buffers.
    BufferPool(MemoryBudget& ram, std::size_t count, std::size_t bytesEach, std::string_view what)
        : charge_(ram.charge(count * bytesEach, what)), bytesEach_(bytesEach), storage_(count * bytesEach) {
        for (std::size_t i = 0; i < count; ++i)
            free_.push_back(storage_.data() + i * bytesEach);
    }

    class Lease {
      public:
        explicit Lease(BufferPool& pool) : pool_(pool), data_(pool.take()) {}
        ~Lease() { pool_.put(data_); }
        Lease(const Lease&) = delete;
        Lease& operator=(const Lease&) = delete;
        std::span<std::byte> bytes() const { return {data_, pool_.bytesEach_}; }

      private:
        BufferPool& pool_;
        std::byte* data_;
    };

  private:
    std::byte* take() {
        std::unique_lock lock(mutex_);
        given_.wait(lock, [&] { return !free_.empty(); });
        std::byte* data = free_.back();
        free_.pop_back();
        return data;
    }
    void put(std::byte* data) {
        {
            const std::lock_guard lock(mutex_);
            free_.push_back(data);
        }
        given_.notify_one();
    }

    Charge charge_;
    const std::size_t bytesEach_;
    std::vector<std::byte> storage_;
    std::mutex mutex_;
    std::condition_variable given_;
    std::vector<std::byte*> free_;
};

} // namespace tessera
