// bricking/import/files/stack/slice_names.cpp: see slice_names.h.
#include "bricking/import/files/stack/slice_names.h"

#include "bricking/import/source/source_files.h"
#include "core/base/error.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <numeric>
#include <utility>

namespace tessera {
namespace {

struct Name {
    std::string pattern; // without the ending; numbers are '#'
    std::vector<std::uint64_t> numbers;
    std::filesystem::path file;
};

Name nameOf(const std::filesystem::path& file) {
    Name name;
    name.file = file;
    const std::string text = file.stem().string();
    for (std::size_t i = 0; i < text.size();) {
        if (text[i] < '0' || text[i] > '9') {
            name.pattern += text[i++];
            continue;
        }
        std::uint64_t number = 0;
        for (; i < text.size() && text[i] >= '0' && text[i] <= '9'; ++i) {
            constexpr std::uint64_t kMost = std::numeric_limits<std::uint64_t>::max() / 20;
            if (number > kMost)
                throw badFile(file.string(), "a number of 18 digits at most in a slice's name",
                              "a longer one");
            number = 10 * number + static_cast<std::uint64_t>(text[i] - '0');
        }
        name.numbers.push_back(number);
        name.pattern += '#';
    }
    return name;
}

/// The pattern with the numbers that all names share.
std::string shown(const Name& name, std::size_t varying) {
    std::string text;
    std::size_t next = 0;
    for (const char c : name.pattern)
        if (c == '#') {
            text += next == varying ? "#" : std::to_string(name.numbers[next]);
            ++next;
        } else {
            text += c;
        }
    return printableName(text + name.file.extension().string());
}

} // namespace

SliceNames orderedSlices(const std::filesystem::path& folder, std::vector<std::filesystem::path> files) {
    const std::string where = folder.string();
    if (files.size() < 2)
        throw badFile(where, "two slices or more",
                      files.empty() ? "none" : "one, " + printableName(files[0].filename()));
    std::vector<Name> names;
    for (const std::filesystem::path& file : files)
        names.push_back(nameOf(file));
    const std::string pattern = names.front().pattern;
    for (const Name& name : names)
        if (name.pattern != pattern)
            throw badFile(where, "slices whose names are alike but for one number",
                          printableName(names.front().file.filename()) + " beside " +
                              printableName(name.file.filename()) +
                              "; a folder of its own makes them a stack");
    std::vector<std::size_t> varying;
    for (std::size_t n = 0; n < names.front().numbers.size(); ++n)
        if (std::any_of(names.begin(), names.end(),
                        [&](const Name& name) { return name.numbers[n] != names.front().numbers[n]; }))
            varying.push_back(n);
    if (varying.size() != 1)
        throw badFile(
            where, "slices whose names differ in one number",
            (varying.empty() ? "no number that differs" : std::to_string(varying.size()) + " that differ") +
                " in " + printableName(pattern) + " (each # is a number)");
    const std::size_t at = varying.front();
    std::sort(names.begin(), names.end(),
              [at](const Name& a, const Name& b) { return a.numbers[at] < b.numbers[at]; });
    SliceNames out;
    out.pattern = shown(names.front(), at);
    std::uint64_t step = 0;
    for (std::size_t i = 1; i < names.size(); ++i) {
        const std::uint64_t gap = names[i].numbers[at] - names[i - 1].numbers[at];
        if (gap == 0)
            throw badFile(names[i].file.string(), "every number once",
                          "that of " + printableName(names[i - 1].file.filename()));
        step = std::gcd(step, gap);
    }
    constexpr std::size_t kMostShown = 8;
    std::size_t runs = 0;
    for (std::size_t i = 0; i < names.size(); ++i) {
        out.files.push_back(names[i].file);
        out.places.push_back((names[i].numbers[at] - names.front().numbers[at]) / step);
        if (i == 0)
            continue;
        const std::uint64_t before = names[i - 1].numbers[at], gap = names[i].numbers[at] - before;
        if (gap == step)
            continue;
        const std::uint64_t last = before + gap - step;
        out.missingCount += gap / step - 1;
        if (++runs <= kMostShown)
            out.missing += (runs == 1 ? "" : ", ") + std::to_string(before + step) +
                           (last == before + step ? "" : " to " + std::to_string(last));
    }
    if (runs > kMostShown)
        out.missing += " and more";
    return out;
}

} // namespace tessera
