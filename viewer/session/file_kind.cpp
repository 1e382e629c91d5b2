// viewer/session/file_kind.cpp: see file_kind.h.
#include "viewer/session/file_kind.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <fstream>
#include <string>
#include <string_view>
#include <system_error>

namespace tessera {

bool meansStructureSet(const std::filesystem::path& path) {
    constexpr std::size_t kPreamble = 128, kLookedAt = 1024; // the kind of object stands in front
    constexpr std::string_view kMark = "DICM", kKind = "1.2.840.10008.5.1.4.1.1.481.3";
    std::error_code none;
    if (!std::filesystem::is_regular_file(path, none))
        return false;
    std::array<char, kLookedAt> bytes{};
    std::ifstream file(path, std::ios::binary);
    file.read(bytes.data(), bytes.size());
    const std::string_view head(bytes.data(), static_cast<std::size_t>(file.gcount()));
    if (head.size() < kPreamble + kMark.size() || head.substr(kPreamble, kMark.size()) != kMark)
        return false;
    const std::size_t at = head.find(kKind);
    const std::size_t end = at == std::string_view::npos ? head.size() : at + kKind.size();
    return end < head.size() && !std::isdigit(static_cast<unsigned char>(head[end])) && head[end] != '.';
}

bool meansMesh(const std::filesystem::path& path) {
    std::string ending = path.extension().string();
    std::transform(ending.begin(), ending.end(), ending.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    constexpr std::array<std::string_view, 5> kEndings = {".ply", ".stl", ".obj", ".gltf", ".glb"};
    std::error_code none;
    return (std::find(kEndings.begin(), kEndings.end(), ending) != kEndings.end() &&
            std::filesystem::is_regular_file(path, none)) ||
           meansStructureSet(path);
}

} // namespace tessera
