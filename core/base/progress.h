// core/base/progress.h: the progress of a long job. On a terminal one line on stderr redraws itself, with the
// stage, its share and the time left. Elsewhere, with -v, a plain line comes every ten seconds, so logs stay
// readable.
#pragma once

#include <chrono>
#include <functional>
#include <mutex>
#include <string>

namespace tessera {

enum class Verbosity { quiet, normal, verbose };

/// Gets the share of a stage that is done, in [0,1], from any thread; may be empty.
using ShareDone = std::function<void(double)>;

/// All functions may be called from any thread, and are fast enough for every iteration of a loop.
class Progress {
  public:
    /// Prints nothing.
    Progress() : Progress(Verbosity::quiet) {}
    /// @param asked  now() will be read, even if nothing is printed
    explicit Progress(Verbosity verbosity, bool asked = false);
    /// Removes the line.
    ~Progress();
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    struct Stage {
        std::string what; // empty: no stage has begun
        double share = 0; // share that is done; 0: unknown
    };
    Stage now() const;

    /// True if the line is visible, so that effort for it is worthwhile.
    bool watched() const { return terminal_; }
    /// Begins another stage.
    /// @param what  present participle and object: "importing abdomen"
    void stage(const std::string& what);
    /// @param share  of the stage that is done
    void update(double share);
    /// update(), as a function to pass on.
    ShareDone shares() {
        return [this](double share) { update(share); };
    }
    /// Says more about the stage behind its name, such as how good a picture is by now; until another begins.
    void detail(const std::string& more);
    /// A share of the stage that was done before it began: the rest of the time is judged without it.
    void startAt(double share);
    /// Ends the last stage: removes the line until another stage begins.
    void end();
    /// Prints a permanent line above the progress line; unless quiet.
    void say(const std::string& line);

  private:
    using Clock = std::chrono::steady_clock;
    void draw(Clock::time_point now);
    void clear();

    mutable std::mutex mutex_;
    bool quiet_, terminal_, lines_, asked_; // lines_: plain ones, now and then
    bool drawn_ = false;                    // a line stands on the terminal
    std::string what_, more_;
    double share_ = 0; // 0: not known
    double first_ = 0; // share when it began
    Clock::time_point began_, shown_;
};

/// Elapsed time by the clock.
inline double secondsSince(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

} // namespace tessera
