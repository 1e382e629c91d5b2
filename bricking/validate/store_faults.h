// bricking/validate/store_faults.h: StoreFaults, what is wrong with a store, in lines for people, and what
// became of it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <vector>

namespace tessera {

/// All functions but lines() may be called from any thread.
class StoreFaults {
  public:
    static constexpr std::size_t kMostLines = 10000; // further faults are counted

    /// @param part  what is made again as a whole: a path
    /// @param text  "FILE: expected ..., found ..."
    void add(const std::string& part, const std::string& text);
    /// A part was made again, all its faults are gone.
    void mend(const std::string& part);
    /// A part stays as it is.
    /// @param why  "level 0 is made by an import alone"
    void leave(const std::string& part, const std::string& why);

    bool has(const std::string& part) const;
    std::uint64_t count() const;
    std::uint64_t mended() const;
    /// Lines of parts that do not begin with "STORE/stats" or the like may come from many threads: puts those
    /// from `first` on in order.
    void sortFrom(std::size_t first);
    std::size_t listed() const;
    /// A line a fault, with what became of it.
    std::vector<std::string> lines() const;

  private:
    struct Line {
        std::string text, part;
    };
    struct Part {
        std::uint64_t faults = 0;
        bool isMended = false;
        std::string why; // it stays
    };
    mutable std::mutex mutex_;
    std::vector<Line> lines_;
    std::map<std::string, Part> parts_;
};

} // namespace tessera
