// core/base/names.cpp: see names.h.
#include "core/base/names.h"

#include "core/base/error.h"

#include <algorithm>
#include <cstddef>

namespace tessera {
namespace {
constexpr std::size_t kMaxLength = 64; // longer than any name we know; bounds the quadratic cost
char lower(char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}
} // namespace

std::size_t editDistance(std::string_view a, std::string_view b) {
    a = a.substr(0, kMaxLength);
    b = b.substr(0, kMaxLength);
    std::vector<std::size_t> row(b.size() + 1); // distances from the prefix of a seen so far to prefixes of b
    for (std::size_t j = 0; j < row.size(); ++j)
        row[j] = j;
    for (std::size_t i = 0; i < a.size(); ++i) {
        std::size_t diagonal = row[0];
        row[0] = i + 1;
        for (std::size_t j = 0; j < b.size(); ++j) {
            const std::size_t replaced = diagonal + (lower(a[i]) == lower(b[j]) ? 0 : 1);
            diagonal = row[j + 1];
            row[j + 1] = std::min({replaced, row[j] + 1, row[j + 1] + 1});
        }
    }
    return row.back();
}

std::string nearestName(std::string_view word, const std::vector<std::string>& known) {
    const auto nearest = std::min_element(known.begin(), known.end(), [&](const auto& a, const auto& b) {
        return editDistance(word, a) < editDistance(word, b);
    });
    return nearest == known.end() ? std::string() : *nearest;
}

std::size_t indexOfName(const std::string& text, const std::vector<std::string>& names,
                        const std::string& where) {
    const auto found = std::find(names.begin(), names.end(), text);
    if (found == names.end())
        throw badFile(where, "one of " + joinNames(names),
                      "\"" + text.substr(0, 40) + "\"; nearest: \"" + nearestName(text, names) + "\"");
    return static_cast<std::size_t>(found - names.begin());
}

std::string joinNames(const std::vector<std::string>& names) {
    std::string all;
    for (const std::string& name : names)
        all += (all.empty() ? "" : ", ") + name;
    return all;
}

} // namespace tessera
