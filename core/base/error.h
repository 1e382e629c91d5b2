// core/base/error.h: the three error tiers. A bug stops the program with both values printed (TESSERA_CHECK).
// A bad file, a bad option or too small a budget throws InputError (exit 2). Anything else throws Error (exit
// 1). Ordinary outcomes are values, never exceptions.
#pragma once

#include <stdexcept>
#include <string>

namespace tessera {

/// Something outside the program failed: a driver, a disk. The message names the thing. Exit code 1.
class Error : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

/// Bad use or bad input. One line that names the file or option, what was expected and what was found.
/// Exit code 2.
class InputError : public Error {
  public:
    using Error::Error;
};

/// InputError about a file, in one form: "PATH: expected EXPECTED, found FOUND"; path made printable().
class BadFile : public InputError {
  public:
    BadFile(const std::string& path, std::string expected, std::string found);
    const std::string& expected() const { return expected_; }
    const std::string& found() const { return found_; }

  private:
    std::string expected_, found_;
};
BadFile badFile(const std::string& path, const std::string& expected, const std::string& found);
/// "expected EXPECTED, found FOUND" of a BadFile; what() of another error.
std::string withoutPath(const Error& error);

[[noreturn]] void checkFailed(const char* expression, const char* file, int line, const std::string& detail);

} // namespace tessera

/// A condition that only a bug can break; always on, kept out of inner loops.
#define TESSERA_CHECK(condition)                                                                             \
    do {                                                                                                     \
        if (!(condition))                                                                                    \
            ::tessera::checkFailed(#condition, __FILE__, __LINE__, "");                                      \
    } while (false)
