// core/base/interrupt.h: Ctrl-C and cancellation. A program that catches signals ends in order. Long work
// polls here, an exception unwinds, and destructors remove unfinished files. Where nobody polls for too long,
// a watchdog does the same by force: the program is gone within a second.
#pragma once

#include <atomic>
#include <exception>
#include <filesystem>

namespace tessera {

/// Thrown where somebody wants the program to end. Not an Error: nothing failed.
class Interrupted : public std::exception {
  public:
    explicit Interrupted(int signal) : signal_(signal) {}
    const char* what() const noexcept override { return "interrupted"; }
    /// What a shell expects: 129 for SIGHUP, 130 for SIGINT, 143 for SIGTERM.
    int exitCode() const { return 128 + signal_; }

  private:
    int signal_;
};

/// Thrown where nobody wants the result of a piece of work any more. Not an Error: nothing failed.
class Cancelled : public std::exception {
  public:
    const char* what() const noexcept override { return "called off"; }
};

/// As long as it lives, checkInterrupted() throws Cancelled on this thread, and on those that parallelFor()
/// starts for it, once the flag is set. One within another: only the inner one's flag is asked. Threads that
/// others start do not ask.
class Cancellation {
  public:
    using Flag = std::atomic<bool>;
    /// @param flag  null: none is asked
    explicit Cancellation(const Flag* flag);
    ~Cancellation();
    Cancellation(const Cancellation&) = delete;
    Cancellation& operator=(const Cancellation&) = delete;
    /// This thread's, to hand on to others.
    static const Flag* current();

  private:
    const Flag* before_;
};

/// From now on SIGINT, SIGTERM and, unless it is ignored, SIGHUP are remembered for checkInterrupted(). The
/// second one ends the program at once, as does the first after 0.8 seconds, without unwinding: then what
/// TemporaryPath names is removed. A file that grows over the process's limit becomes a write that fails.
void catchInterrupts();
/// Throws Interrupted after a signal, Cancelled where this thread's work is called off; else costs next to
/// nothing. From any thread.
void checkInterrupted();

/// A file or folder that must not outlive the program unless it is finished. Whoever makes it removes it;
/// this is for the case that nobody gets to.
class TemporaryPath {
  public:
    explicit TemporaryPath(const std::filesystem::path& path);
    ~TemporaryPath() { forget(); }
    TemporaryPath(const TemporaryPath&) = delete;
    TemporaryPath& operator=(const TemporaryPath&) = delete;
    /// It has its final name, or is gone.
    void forget();

  private:
    int number_; // of this path; negative: forgotten
};

} // namespace tessera
