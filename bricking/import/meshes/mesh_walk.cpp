// bricking/import/meshes/mesh_walk.cpp: see mesh_walk.h. STL and OBJ.
#include "bricking/import/meshes/mesh_walk.h"

#include "core/base/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>

namespace tessera {
namespace {

constexpr std::size_t kStlHead = 84, kStlTriangle = 50;             // bytes
constexpr std::size_t kMostOfStlLine = 1000, kMostOfObjLine = 1000; // bytes; VTK has 1024 for one

bool isText(const InputFile& file) {
    std::array<std::byte, 512> head;
    const std::size_t read = file.readSome(0, head);
    return std::all_of(head.begin(), head.begin() + static_cast<std::ptrdiff_t>(read), [](std::byte b) {
        const auto c = static_cast<unsigned char>(b);
        return c >= 32 || c == '\t' || c == '\n' || c == '\r';
    });
}

bool isFinite(std::string_view word) {
    const std::string text(word);
    char* end = nullptr;
    const double value = std::strtod(text.c_str(), &end);
    return *end == '\0' && std::isfinite(value);
}

} // namespace

bool FileWalk::fill() {
    if (begin_ < end_)
        return true;
    begin_ = 0;
    end_ = file_.readSome(next_, buffer_);
    next_ += end_;
    return end_ > 0;
}

void FileWalk::take(void* out, std::size_t bytes) {
    auto* to = static_cast<std::byte*>(out);
    const std::uint64_t from = at();
    while (bytes > 0) {
        if (!fill())
            throw badFile(file_.path().string(), "more bytes from " + std::to_string(from) + " on",
                          "the end of the file at " + std::to_string(file_.sizeBytes()));
        const std::size_t count = std::min(bytes, end_ - begin_);
        std::memcpy(to, buffer_.data() + begin_, count);
        begin_ += count;
        to += count;
        bytes -= count;
    }
}

std::optional<std::string_view> FileWalk::line(std::size_t most) {
    if (!fill())
        return std::nullopt;
    line_.clear();
    while (fill()) {
        const auto* const from = reinterpret_cast<const char*>(buffer_.data()) + begin_;
        const auto* const end = static_cast<const char*>(std::memchr(from, '\n', end_ - begin_));
        const std::size_t count = end ? static_cast<std::size_t>(end - from) : end_ - begin_;
        if (line_.size() + count > most)
            throw badFile(file_.path().string(), "lines of at most " + std::to_string(most) + " bytes",
                          "a longer one before byte " + std::to_string(next_));
        line_.append(from, count);
        begin_ += count + (end ? 1 : 0);
        if (end)
            break;
    }
    if (!line_.empty() && line_.back() == '\r')
        line_.pop_back();
    return line_;
}

std::vector<std::string_view> wordsOf(std::string_view line) {
    std::vector<std::string_view> words;
    constexpr std::string_view kSpaces = " \t\r";
    for (std::size_t at = line.find_first_not_of(kSpaces); at != std::string_view::npos;) {
        const std::size_t end = std::min(line.find_first_of(kSpaces, at), line.size());
        words.push_back(line.substr(at, end - at));
        at = line.find_first_not_of(kSpaces, end);
    }
    return words;
}

MeshCounts walkStl(const InputFile& file) {
    if (isText(file)) {
        FileWalk walk(file);
        MeshCounts counts{0, 0, true};
        std::uint64_t corners = 0, facets = 0;
        bool ended = false;
        while (const auto line = walk.line(kMostOfStlLine)) {
            const std::vector<std::string_view> words = wordsOf(*line);
            if (words.empty())
                continue;
            if (words[0] == "vertex" && words.size() != 4)
                throw badFile(file.path().string(), "vertex X Y Z",
                              "\"" + printable(std::string(*line)) + "\"");
            corners += words[0] == "vertex";
            facets += words[0] == "facet";
            counts.triangles += words[0] == "endfacet";
            ended = words[0] == "endsolid";
        }
        if (!ended || corners != 3 * facets || counts.triangles != facets)
            throw badFile(file.path().string(), "facets of three vertices each, and endsolid at the end",
                          std::to_string(facets) + " facets, " + std::to_string(corners) + " vertices, " +
                              std::to_string(counts.triangles) + " ends of facets" +
                              (ended ? "" : ", and no endsolid"));
        counts.points = corners;
        return counts;
    }
    if (file.sizeBytes() < kStlHead)
        throw badFile(file.path().string(), "the 84 bytes that a binary STL begins with",
                      std::to_string(file.sizeBytes()) + " bytes");
    FileWalk walk(file, kStlHead - 4);
    std::array<unsigned char, 4> bytes{};
    walk.take(bytes.data(), 4);
    std::uint64_t triangles = 0;
    for (std::size_t n = 0; n < 4; ++n)
        triangles |= static_cast<std::uint64_t>(bytes[n]) << (8 * n);
    const std::uint64_t size = kStlHead + triangles * kStlTriangle;
    if (size != file.sizeBytes())
        throw badFile(file.path().string(),
                      std::to_string(size) + " bytes of the " + std::to_string(triangles) +
                          " triangles that its header tells",
                      std::to_string(file.sizeBytes()) + " bytes");
    return {3 * triangles, triangles, true};
}

MeshCounts walkObj(const InputFile& file) {
    FileWalk walk(file);
    MeshCounts counts;
    std::uint64_t texture = 0, normals = 0;
    while (const auto line = walk.line(kMostOfObjLine)) {
        const std::vector<std::string_view> words = wordsOf(*line);
        if (words.empty() || words[0].front() == '#')
            continue;
        const auto refuse = [&](const std::string& expected) {
            return badFile(file.path().string(), expected,
                           "\"" + printable(std::string(line->substr(0, 60))) + "\"");
        };
        if (!line->empty() && line->back() == '\\')
            throw refuse("lines that end where they end");
        if (words[0] == "v" &&
            (words.size() < 4 || !isFinite(words[1]) || !isFinite(words[2]) || !isFinite(words[3])))
            throw refuse("v X Y Z"); // VTK takes 0 for what is no number
        counts.points += words[0] == "v";
        normals += words[0] == "vn";
        texture += words[0] == "vt";
        if (words[0] != "f")
            continue;
        if (words.size() < 4)
            throw refuse("a face of three corners at least");
        counts.triangles += words.size() - 3;
        for (std::size_t n = 1; n < words.size(); ++n) { // point, texture, normal: each among those before
            std::string_view word = words[n];
            const std::uint64_t most[3] = {counts.points, texture, normals};
            for (int part = 0; part < 3; ++part) {
                const std::size_t end = std::min(word.find('/'), word.size());
                const std::string number(word.substr(0, end));
                char* rest = nullptr;
                const long long value = std::strtoll(number.c_str(), &rest, 10); // 0 of nothing
                const auto far = static_cast<std::uint64_t>(value < 0 ? -(value + 1) + 1 : value);
                if (number.empty() ? part == 0 : *rest != '\0' || value == 0 || far > most[part])
                    throw refuse("a face of numbers from 1 to " + std::to_string(most[part]));
                if (end == word.size())
                    break;
                word.remove_prefix(end + 1);
            }
        }
    }
    return counts;
}

} // namespace tessera
