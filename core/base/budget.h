// core/base/budget.h: MemoryBudget, the memory budget. Every allocation of bricks, tables, statistics,
// staging and images is charged to a budget before it is made. So a budget is a hard limit.
#pragma once

#include <cstddef>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

namespace tessera {

class Charge;

/// The account of one kind of memory (RAM or GPU) against its budget. Thread-safe.
/// Invariant: usedBytes() <= limitBytes() at every moment.
class MemoryBudget {
  public:
    /// @param name  "RAM" or "GPU memory"; appears in messages
    /// @param option  the program's option that raises the limit, e.g. "--ram"
    MemoryBudget(std::string name, std::string option, std::size_t limitBytes);
    MemoryBudget(const MemoryBudget&) = delete;
    MemoryBudget& operator=(const MemoryBudget&) = delete;

    /// Charges bytes; the returned Charge gives them back when it dies.
    /// Throws InputError, naming what, the need, the limit and the option, when the budget cannot hold it.
    [[nodiscard]] Charge charge(std::size_t bytes, std::string_view what);
    /// As charge(), but returns nullopt instead of throwing: for callers that can evict, or work with less.
    [[nodiscard]] std::optional<Charge> tryCharge(std::size_t bytes);

    std::size_t limitBytes() const { return limitBytes_; }
    std::size_t usedBytes() const;
    std::size_t freeBytes() const;
    /// Largest usedBytes() seen so far.
    std::size_t peakBytes() const;
    const std::string& name() const { return name_; }
    const std::string& option() const { return option_; }

  private:
    friend class Charge;
    void release(std::size_t bytes);

    const std::string name_, option_;
    const std::size_t limitBytes_;
    mutable std::mutex mutex_;
    std::size_t usedBytes_ = 0, peakBytes_ = 0;
};

/// Bytes held on a budget; move-only; gives them back on destruction. The budget must outlive it.
class Charge {
  public:
    Charge() = default;
    Charge(Charge&& other) noexcept;
    Charge& operator=(Charge&& other) noexcept;
    ~Charge();
    std::size_t bytes() const { return bytes_; }

  private:
    friend class MemoryBudget;
    Charge(MemoryBudget* budget, std::size_t bytes) : budget_(budget), bytes_(bytes) {}
    MemoryBudget* budget_ = nullptr;
    std::size_t bytes_ = 0;
};

/// Parses "512MiB", "2 GiB", "1.5G", "65536"; binary units only.
/// Throws InputError naming option for anything else, zero and negative included.
std::size_t parseBytes(std::string_view text, std::string_view option);
/// "512 MiB", "1.50 GiB", "812 B"; rounded up, so that a budget of the stated size suffices.
std::string formatBytes(std::size_t bytes);

} // namespace tessera
