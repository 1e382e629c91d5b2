// core/base/progress.h: the progress of a long job: one line on stderr that redraws itself, with the stage,
// its share and the time left. This is on a terminal only. Elsewhere a plain line comes each ten seconds if
// more is asked for, so logs stay readable.
#pragma once

#include <chrono>
#include <functional>
#include <mutex>
#include <string>

namespace tessera {

enum class Verbosity { quiet, normal, verbose };

/// Gets the share of a stage that is done, in [0,1], from any thread; may be empty.
using ShareDone = std::function<void(double)>;

/// All calls from any thread; none is slow, so that loops may call for every turn.
class Progress {
  public:
    /// Says nothing at all.
    Progress() : Progress(Verbosity::quiet) {}
    /// @param asked  somebody reads now(), whatever is written
    explicit Progress(Verbosity verbosity, bool asked = false);
    /// Takes the line away.
    ~Progress();
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    struct Stage {
        std::string what; // empty: none has begun
        double share = 0; // that is done; 0: not known
    };
    Stage now() const;

    /// Whether somebody sees the line: worth some effort of its own.
    bool watched() const { return terminal_; }
    /// Another stage begins.
    /// @param what  present participle and object: "importing abdomen"
    void stage(const std::string& what);
    /// @param share  of the stage that is done
    void update(double share);
    /// update(), to hand on.
    ShareDone shares() {
        return [this](double share) { update(share); };
    }
    /// The last stage is done: the line goes, until another begins.
    void end();
    /// A line that stays, above the one that redraws itself; unless quiet.
    void say(const std::string& line);

  private:
    using Clock = std::chrono::steady_clock;
    void draw(Clock::time_point now);
    void clear();

    mutable std::mutex mutex_;
    bool quiet_, terminal_, lines_, asked_; // lines_: plain ones, now and then
    bool drawn_ = false;                    // a line stands on the terminal
    std::string what_;
    double share_ = 0; // 0: not known
    Clock::time_point began_, shown_;
};

} // namespace tessera
