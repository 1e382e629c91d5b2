// core/progress.cpp: see progress.h.
#include "core/progress.h"

#include <algorithm>
#include <cstdio>
#include <unistd.h>

namespace tessera {

Progress::Progress(std::string what, std::uint64_t total, Verbosity verbosity)
    : what_(std::move(what)), total_(total), on_(verbosity != Verbosity::quiet),
      terminal_(isatty(STDERR_FILENO) == 1), start_(Clock::now()), shown_(start_) {}

Progress::~Progress() {
    if (printed_ && terminal_)
        std::fputs("\r\033[K", stderr);
}

void Progress::update(std::uint64_t done) {
    if (!on_ || total_ == 0)
        return;
    const auto now = Clock::now();
    const auto pause = terminal_ ? std::chrono::milliseconds(100) : std::chrono::milliseconds(10000);
    if (now - shown_ < pause)
        return;
    shown_ = now;
    const double fraction = std::min(1.0, static_cast<double>(done) / static_cast<double>(total_));
    const double seconds = std::chrono::duration<double>(now - start_).count();
    const double left = fraction > 0 ? seconds * (1 - fraction) / fraction : 0;
    std::fprintf(stderr, terminal_ ? "\r\033[K%s: %3.0f %%, %.0f s left" : "%s: %3.0f %%, %.0f s left\n",
                 what_.c_str(), 100 * fraction, left);
    std::fflush(stderr);
    printed_ = true;
}

} // namespace tessera
