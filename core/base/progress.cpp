// core/base/progress.cpp: see progress.h.
#include "core/base/progress.h"

#include "core/base/shown_text.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <sys/ioctl.h> // the terminal's width
#include <unistd.h>

namespace tessera {
namespace {

constexpr std::chrono::milliseconds kRedraw{100};
constexpr std::chrono::seconds kPlainLine{10};
constexpr double kSecondsToJudge = 0.5; // no estimate of the remaining time before

/// A line that is wider than the terminal would wrap and could not be erased.
std::size_t terminalWidth() {
    winsize size{};
    return ::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 1 ? size.ws_col : 80;
}

std::string timeText(double seconds) {
    const auto whole = static_cast<long>(std::ceil(seconds));
    char text[32];
    if (whole < 100)
        std::snprintf(text, sizeof text, "%ld s", whole);
    else
        std::snprintf(text, sizeof text, "%ld min %02ld s", whole / 60, whole % 60);
    return text;
}

} // namespace

Progress::Progress(Verbosity verbosity, bool asked)
    : quiet_(verbosity == Verbosity::quiet), terminal_(!quiet_ && ::isatty(STDERR_FILENO) == 1),
      lines_(!terminal_ && verbosity == Verbosity::verbose), asked_(asked), began_(Clock::now()),
      shown_(began_) {}

Progress::~Progress() {
    clear();
}

void Progress::stage(const std::string& what) {
    const std::lock_guard lock(mutex_);
    what_ = what;
    more_.clear();
    share_ = first_ = 0;
    began_ = Clock::now();
    if (terminal_)
        draw(began_); // at once, so that the program is not silent
}

void Progress::update(double share) {
    if (!terminal_ && !lines_ && !asked_)
        return;
    const std::lock_guard lock(mutex_);
    share_ = std::clamp(share, share_, 1.0); // threads may report out of order
    if (!terminal_ && !lines_)
        return;
    const auto now = Clock::now();
    if (now - shown_ >= (terminal_ ? Clock::duration(kRedraw) : Clock::duration(kPlainLine)))
        draw(now);
}

void Progress::detail(const std::string& more) {
    const std::lock_guard lock(mutex_);
    if (more == more_)
        return;
    more_ = more;
    if (terminal_)
        draw(Clock::now());
}

void Progress::startAt(double share) {
    const std::lock_guard lock(mutex_);
    share_ = first_ = std::clamp(share, 0.0, 1.0);
}

Progress::Stage Progress::now() const {
    const std::lock_guard lock(mutex_);
    return {what_, share_};
}

void Progress::end() {
    const std::lock_guard lock(mutex_);
    clear();
}

void Progress::say(const std::string& line) {
    if (quiet_)
        return;
    const std::lock_guard lock(mutex_);
    const bool again = drawn_;
    clear();
    std::fprintf(stderr, "%s\n", printableLines(line).c_str());
    std::fflush(stderr); // for a log that is being watched
    if (again)
        draw(Clock::now());
}

void Progress::draw(Clock::time_point now) {
    shown_ = now;
    std::string line = printable(what_ + more_);
    if (share_ > 0) {
        line += ": " + std::to_string(static_cast<int>(100 * share_)) + " %";
        const double seconds = std::chrono::duration<double>(now - began_).count();
        if (seconds > kSecondsToJudge && share_ > first_)
            line += ", " + timeText(seconds * (1 - share_) / (share_ - first_)) + " left";
    } else {
        line += " ...";
    }
    if (terminal_)
        std::fprintf(stderr, "\r\033[K%s", line.substr(0, terminalWidth() - 1).c_str());
    else
        std::fprintf(stderr, "%s\n", line.c_str());
    std::fflush(stderr);
    drawn_ = terminal_;
}

void Progress::clear() {
    if (!drawn_)
        return;
    std::fputs("\r\033[K", stderr);
    std::fflush(stderr);
    drawn_ = false;
}

} // namespace tessera
