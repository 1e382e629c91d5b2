// core/base/interrupt.h: Ctrl-C and cancellation. Long work polls here, an exception unwinds, and destructors
// remove unfinished files. If no code polls for too long, a watchdog removes the files and ends the program,
// within a second.
#pragma once

#include <atomic>
#include <exception>
#include <filesystem>

namespace tessera {

/// Thrown when the program is asked to end. Not an Error: nothing failed.
class Interrupted : public std::exception {
  public:
    explicit Interrupted(int signal) : signal_(signal) {}
    const char* what() const noexcept override { return "interrupted"; }
    /// Exit code by the shell's convention: 129 for SIGHUP, 130 for SIGINT, 143 for SIGTERM.
    int exitCode() const { return 128 + signal_; }

  private:
    int signal_;
};

/// Thrown when the result of a piece of work is no longer wanted. Not an Error: nothing failed.
class Cancelled : public std::exception {
  public:
    const char* what() const noexcept override { return "called off"; }
};

/// While it lives, checkInterrupted() throws Cancelled on this thread, and on those that parallelFor() starts
/// for it, once the flag is set. Of nested ones only the inner flag counts. Threads that others start do not
/// check it.
class Cancellation {
  public:
    using Flag = std::atomic<bool>;
    /// @param flag  null: none is checked
    explicit Cancellation(const Flag* flag);
    ~Cancellation();
    Cancellation(const Cancellation&) = delete;
    Cancellation& operator=(const Cancellation&) = delete;
    /// The flag of this thread, to pass to others.
    static const Flag* current();

  private:
    const Flag* before_;
};

/// From now on SIGINT, SIGTERM and, unless it is ignored, SIGHUP are remembered for checkInterrupted(). The
/// second one ends the program at once without unwinding, as does the first after 0.8 seconds; the files of
/// TemporaryPath are removed then. Exceeding the process's limit of file size becomes a failed write.
void catchInterrupts();
/// Throws Interrupted after a signal, Cancelled if this thread's work is cancelled; otherwise nearly free.
/// From any thread.
void checkInterrupted();

/// A file or folder that must not outlive the program unless it is finished. Its creator removes it; this
/// covers programs that end without unwinding.
class TemporaryPath {
  public:
    explicit TemporaryPath(const std::filesystem::path& path);
    ~TemporaryPath() { forget(); }
    TemporaryPath(const TemporaryPath&) = delete;
    TemporaryPath& operator=(const TemporaryPath&) = delete;
    /// It has its final name, or was removed.
    void forget();

  private:
    int number_; // of this path; negative: forgotten
};

} // namespace tessera
