// core/base/size_text.cpp: see size_text.h.
#include "core/base/size_text.h"

#include "core/base/error.h"

#include <algorithm>
#include <cstddef>
#include <sstream>
#include <vector>

namespace tessera {
namespace {

/// "AxBxC" as `count` whole numbers in [1, largest]; nothing else.
std::vector<int> parseExtents(const std::string& text, std::size_t count, const std::string& where,
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
        throw badFile(where,
                      std::string(count == 2 ? "WIDTHxHEIGHT" : "XxYxZ") + " with numbers from 1 to " +
                          std::to_string(largest),
                      "\"" + text + "\"");
    return numbers;
}

} // namespace

glm::ivec2 parseImageSize(const std::string& text, const std::string& where, int largest) {
    const std::vector<int> n = parseExtents(text, 2, where, largest);
    return {n[0], n[1]};
}
glm::ivec3 parseVolumeSize(const std::string& text, const std::string& where, int largest) {
    const std::vector<int> n = parseExtents(text, 3, where, largest);
    return {n[0], n[1], n[2]};
}

} // namespace tessera
