// viewer/cli/options/options.cpp: see options.h.
#include "viewer/cli/options/options.h"

#include "core/base/error.h"
#include "core/base/shown_text.h"

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <unistd.h> // isatty
#include <vector>

namespace tessera {
namespace {

constexpr std::size_t kDefaultBudgetBytes = std::size_t{1} << 30;

/// MemAvailable of this machine; 0 where it is not told.
std::size_t availableBytes() {
    std::ifstream file("/proc/meminfo");
    std::string key, unit;
    std::size_t kib = 0;
    while (file >> key >> kib) {
        if (key == "MemAvailable:")
            return kib << 10;
        std::getline(file, unit);
    }
    return 0;
}

} // namespace

void CommonOptions::note(const std::string& line) const {
    if (listener)
        listener(prefix + line);
    else if (!quiet)
        (shared ? shared : progress)->say(prefix + line);
}
void CommonOptions::detail(const std::string& line) const {
    if (verbose)
        note(line);
}

void CommonOptions::problem(const std::string& message) const {
    if (listener)
        return listener(prefix + message);
    (shared ? shared : progress)->end();
    printProblem(prefix + message);
}

void printProblem(const std::string& message) {
    const char* const noColour = std::getenv("NO_COLOR"); // no-color.org: set and not empty
    const bool colour = isatty(STDERR_FILENO) && !(noColour && *noColour);
    std::fprintf(stderr, "%stessera:%s %s\n", colour ? "\033[1;31m" : "", colour ? "\033[0m" : "",
                 printableLines(message).c_str());
}

std::size_t budgetBytes(const std::string& text, const std::string& option, const CommonOptions& common) {
    if (!text.empty())
        return parseBytes(text, option);
    const std::size_t available = availableBytes();
    const std::size_t bytes = available ? std::min(kDefaultBudgetBytes, available / 2) : kDefaultBudgetBytes;
    common.detail("budget " + option + " " + formatBytes(bytes) + " by default (" + formatBytes(available) +
                  " of memory available)");
    return bytes;
}

std::string formatExtent(const glm::ivec3& extent) {
    return std::to_string(extent.x) + " x " + std::to_string(extent.y) + " x " + std::to_string(extent.z);
}
std::string formatNumber(double number, int digits) {
    return numberText(number, digits);
}

} // namespace tessera
