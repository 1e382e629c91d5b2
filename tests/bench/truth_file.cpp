// tests/bench/truth_file.cpp: see truth_file.h.
#include "tests/bench/truth_file.h"

#include "core/base/error.h"
#include "core/base/output_file.h"

#include <cinttypes>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>
#include <span>

namespace tessera::bench {
namespace {

constexpr int kReferenceVersion =
    1; // another where the reference's pictures change: old files are left alone

/// FNV-1a.
std::uint64_t digest(const std::string& text) {
    std::uint64_t hash = 0xcbf29ce484222325;
    for (const char c : text)
        hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3;
    return hash;
}

std::string fileName(const std::string& name, const std::string& key) {
    char hex[17];
    std::snprintf(hex, sizeof hex, "%016" PRIx64, digest(key));
    return "truth-" + name + "-" + hex + ".bin";
}

} // namespace

std::string truthKey(const Scene& scene, const std::string& volumeContent, const glm::ivec2& size,
                     int stride) {
    Scene plain = scene;
    plain.volumes.front().path.clear();
    plain.quality = {}; // the reference takes no steps
    plain.imageSize = size;
    return "reference " + std::to_string(kReferenceVersion) + ", volume " + volumeContent + ", every " +
           std::to_string(stride) + ". pixel, " + sceneJson(plain);
}

// A file: the key, a line's end, width and height as text, a line's end, floats.
Image truthFromFile(const std::filesystem::path& folder, const std::string& name, const std::string& key,
                    const std::function<Image()>& make) {
    const std::filesystem::path path = folder / fileName(name, key);
    if (std::ifstream file(path, std::ios::binary); file) {
        std::string found;
        std::getline(file, found);
        Image image;
        glm::ivec2 size(0);
        file >> size.x >> size.y;
        file.get();
        if (file && found == key && size.x > 0 && size.y > 0 && size.x <= Scene::kMaxImageExtent &&
            size.y <= Scene::kMaxImageExtent) {
            image = Image(size);
            const auto bytes = static_cast<std::streamsize>(image.pixels.size() * sizeof(glm::vec4));
            file.read(reinterpret_cast<char*>(image.pixels.data()), bytes);
            if (file.gcount() == bytes && file.peek() == std::ifstream::traits_type::eof())
                return image;
        }
        throw InputError(path.string() + ": expected a reference as this program writes it; remove it");
    }
    const Image image = make();
    const std::string head =
        key + "\n" + std::to_string(image.size.x) + " " + std::to_string(image.size.y) + "\n";
    OutputFile file(path);
    file.writeAt(0, std::as_bytes(std::span(head)));
    file.writeAt(head.size(), std::as_bytes(std::span(image.pixels)));
    file.finish();
    return image;
}

} // namespace tessera::bench
