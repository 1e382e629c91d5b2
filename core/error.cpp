// core/error.cpp: see error.h.
#include "core/error.h"

#include <cstdio>
#include <cstdlib>

namespace tessera {

InputError badFile(const std::string& path, const std::string& expected, const std::string& found) {
    return InputError(path + ": expected " + expected + ", found " + found);
}

void checkFailed(const char* expression, const char* file, int line, const std::string& detail) {
    std::fprintf(stderr, "tessera: bug: %s is false at %s:%d %s\n", expression, file, line, detail.c_str());
    std::abort();
}

} // namespace tessera
