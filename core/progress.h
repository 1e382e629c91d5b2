// core/progress.h: one progress line on stderr. On a terminal it redraws itself; elsewhere it prints at most
// a line each ten seconds, so that logs stay readable.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

namespace tessera {

enum class Verbosity { quiet, normal, verbose };

class Progress {
  public:
    /// @param what  present participle and object, e.g. "importing abdomen"
    Progress(std::string what, std::uint64_t total, Verbosity verbosity);
    ~Progress();
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;
    /// Reports `done` of total; cheap enough to call for every slice. One thread only.
    void update(std::uint64_t done);

  private:
    using Clock = std::chrono::steady_clock;
    std::string what_;
    std::uint64_t total_;
    bool on_, terminal_, printed_ = false;
    Clock::time_point start_, shown_;
};

} // namespace tessera
