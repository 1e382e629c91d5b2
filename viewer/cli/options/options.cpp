// viewer/cli/options/options.cpp: see options.h.
#include "viewer/cli/options/options.h"

#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/base/printable_text.h"

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

/// "AxBxC" as `count` whole numbers in [1, largest]; nothing else.
std::vector<int> parseExtents(const std::string& text, std::size_t count, const std::string& option,
                              int largest) {
    constexpr std::size_t kMaxDigits = 6;
    std::vector<int> numbers;
    std::istringstream parts(text);
    for (std::string part; std::getline(parts, part, 'x');) {
        const bool digits = !part.empty() && part.size() <= kMaxDigits &&
                            part.find_first_not_of("0123456789") == std::string::npos;
        numbers.push_back(digits ? std::stoi(part) : 0);
    }
    const bool inRange =
        std::all_of(numbers.begin(), numbers.end(), [&](int n) { return n >= 1 && n <= largest; });
    if (numbers.size() != count || !inRange || text.back() == 'x')
        throw badFile(option,
                      std::string(count == 2 ? "WIDTHxHEIGHT" : "XxYxZ") + " with numbers from 1 to " +
                          std::to_string(largest),
                      "\"" + text + "\"");
    return numbers;
}

} // namespace

void CommonOptions::note(const std::string& line) const {
    if (!quiet)
        progress->say(line);
}
void CommonOptions::detail(const std::string& line) const {
    if (verbose)
        note(line);
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

glm::ivec2 parseImageSize(const std::string& text, const std::string& option, int largest) {
    const std::vector<int> n = parseExtents(text, 2, option, largest);
    return {n[0], n[1]};
}
glm::ivec3 parseVolumeSize(const std::string& text, const std::string& option, int largest) {
    const std::vector<int> n = parseExtents(text, 3, option, largest);
    return {n[0], n[1], n[2]};
}

std::string formatExtent(const glm::ivec3& extent) {
    return std::to_string(extent.x) + " x " + std::to_string(extent.y) + " x " + std::to_string(extent.z);
}
std::string formatNumber(double number, int digits) {
    return numberText(number, digits);
}

} // namespace tessera
