// tests/support/thread_group.h: processes that share a volume, as threads of one process.
#pragma once

#include "render/parts/process_group.h"

#include <algorithm>
#include <barrier>
#include <functional>
#include <gtest/gtest.h>
#include <thread>

namespace tessera::test {

/// What the threads of a group have in common.
struct Meeting {
    explicit Meeting(int count)
        : barrier(count), numbers(static_cast<std::size_t>(count)), pixels(static_cast<std::size_t>(count)),
          reports(static_cast<std::size_t>(count)) {}
    std::barrier<> barrier;
    std::vector<std::uint64_t> numbers;
    std::vector<std::span<glm::vec4>> pixels;
    std::vector<glm::vec4> whole;
    std::vector<PartReport> reports;
};

class ThreadGroup : public ProcessGroup {
  public:
    ThreadGroup(Meeting& meeting, int rank) : meeting_(meeting), rank_(rank) {}
    int rank() const override { return rank_; }
    int size() const override { return static_cast<int>(meeting_.numbers.size()); }
    std::uint64_t least(std::uint64_t mine) override {
        meeting_.numbers[index()] = mine;
        meeting_.barrier.arrive_and_wait();
        const std::uint64_t least = *std::min_element(meeting_.numbers.begin(), meeting_.numbers.end());
        meeting_.barrier.arrive_and_wait();
        return least;
    }
    void composite(std::span<glm::vec4> pixels, const glm::ivec2& size, std::span<const int> order) override {
        EXPECT_EQ(pixels.size(), static_cast<std::size_t>(size.x * size.y));
        meeting_.pixels[index()] = pixels;
        meeting_.barrier.arrive_and_wait();
        if (rank_ == 0) {
            meeting_.whole.assign(pixels.size(), glm::vec4(0));
            for (const int part : order)
                for (std::size_t i = 0; i < pixels.size(); ++i)
                    meeting_.whole[i] +=
                        (1 - meeting_.whole[i].a) * meeting_.pixels[static_cast<std::size_t>(part)][i];
        }
        meeting_.barrier.arrive_and_wait();
        std::copy(meeting_.whole.begin(), meeting_.whole.end(), pixels.begin());
        meeting_.barrier.arrive_and_wait();
    }
    std::vector<PartReport> gather(const PartReport& mine) override {
        meeting_.reports[index()] = mine;
        meeting_.barrier.arrive_and_wait();
        return rank_ == 0 ? meeting_.reports : std::vector<PartReport>();
    }
    void fail(int) override {}

    /// Calls run() for every member of a group of so many, side by side. It throws in all or none of them.
    static void meet(int count, const std::function<void(ProcessGroup&)>& run) {
        Meeting meeting(count);
        std::vector<std::jthread> threads;
        for (int rank = 0; rank < count; ++rank)
            threads.emplace_back([&, rank] {
                ThreadGroup group(meeting, rank);
                run(group);
            });
    }

  private:
    std::size_t index() const { return static_cast<std::size_t>(rank_); }
    Meeting& meeting_;
    int rank_;
};

} // namespace tessera::test
