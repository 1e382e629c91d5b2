// core/base/error.cpp: see error.h.
#include "core/base/error.h"

#include "core/base/shown_text.h"

#include <cstdio>
#include <cstdlib>
#include <utility>

namespace tessera {

BadFile::BadFile(const std::string& path, std::string expected, std::string found)
    : InputError(printable(path) + ": expected " + expected + ", found " + found),
      expected_(std::move(expected)), found_(std::move(found)) {}

BadFile badFile(const std::string& path, const std::string& expected, const std::string& found) {
    return {path, expected, found};
}

std::string withoutPath(const Error& error) {
    const auto* file = dynamic_cast<const BadFile*>(&error);
    return file ? "expected " + file->expected() + ", found " + file->found() : error.what();
}

void checkFailed(const char* expression, const char* file, int line, const std::string& detail) {
    std::fprintf(stderr, "tessera: bug: %s is false at %s:%d %s\n", expression, file, line, detail.c_str());
    std::abort();
}

} // namespace tessera
