// viewer/cli/redraw/differences.cpp: see differences.h.
#include "viewer/cli/redraw/differences.h"

#include "core/base/error.h"
#include "core/image/image.h"
#include "core/image/page_format.h"
#include "viewer/cli/redraw/figure_record.h" // verifyOfManifest, lineHashOf
#include "viewer/cli/render/picture_files.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

namespace tessera {
namespace {

using nlohmann::json;
using Values = std::map<std::string, json>;
using json_pointer = json::json_pointer;

constexpr const char* kNothing = "nothing";

/// The values of a document by their keys, as `--set` names them; lists of numbers are one value.
void flatten(const json& value, const std::string& key, Values& values) {
    if (value.is_object()) {
        for (const auto& [name, part] : value.items())
            flatten(part, key.empty() ? name : key + "." + name, values);
    } else if (value.is_array() && !value.empty() && value.front().is_object()) {
        for (std::size_t n = 0; n < value.size(); ++n)
            flatten(value[n], key + "[" + std::to_string(n) + "]", values);
    } else {
        values[key] = value;
    }
}

/// Stands for data, which are compared by their content.
bool isPlace(const std::string& key) {
    return (key.starts_with("volumes[") &&
            (key.ends_with("].path") || key.ends_with(".labels.path") || key.ends_with(".labels.names"))) ||
           (key.starts_with("meshes[") && key.ends_with("].path")) || key == "lighting.environment.file";
}

std::string shown(const json& value) {
    constexpr std::size_t kLongest = 120;
    if (value.is_null())
        return kNothing;
    std::string text = value.is_string() ? value.get<std::string>()
                                         : value.dump(-1, ' ', true, json::error_handler_t::replace);
    if (text.size() > kLongest)
        text = text.substr(0, kLongest - 3) + "...";
    return text;
}

json at(const json& document, const char* pointer) {
    const json_pointer place(pointer);
    return document.contains(place) ? document.at(place) : json();
}

void add(const std::string& key, const json& before, const json& now, std::vector<Difference>& to) {
    if (before != now)
        to.push_back({key, shown(before), shown(now)});
}

void addBytes(const std::string& option, const json& before, const json& now, std::vector<Difference>& to) {
    const auto text = [](const json& bytes) {
        return bytes.is_number_unsigned() ? formatBytes(bytes.get<std::size_t>()) : std::string(kNothing);
    };
    if (before != now && !before.is_null() && text(before) != text(now))
        to.push_back({option, text(before), text(now)});
}

/// The line's digest; null: an older picture, or one along no line.
json lineOf(const json& manifest) {
    const std::string hash = lineHashOf(manifest);
    return hash.empty() ? json() : json(hash);
}

Values sceneValues(const json& manifest) {
    Values values;
    flatten(manifest.value("scene", json::object()), "", values);
    std::erase_if(values, [](const auto& value) { return isPlace(value.first); });
    return values;
}

std::string noRoom(const MemoryBudget& ram) {
    return ram.option() + " of " + formatBytes(ram.limitBytes()) + " has no room for both";
}

/// The bytes of a page without those of its manifest: of a PDF all before it, since it is at the end and
/// moves what follows.
std::string pageWithoutManifest(const std::filesystem::path& path, PageFormat format) {
    std::ifstream file(path, std::ios::binary);
    std::string bytes((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
    if (!file || bytes.empty())
        throw badFile(path.string(), "a readable file", "none");
    if (format == PageFormat::pdf)
        return bytes.substr(0, bytes.rfind("/Keywords"));
    const std::size_t begin = bytes.find("<metadata id=\"tessera-manifest\">");
    const std::size_t end = begin == std::string::npos ? begin : bytes.find("</metadata>", begin);
    return end == std::string::npos ? bytes : bytes.erase(begin, end - begin);
}

PixelDifferences comparePages(const std::filesystem::path& before, const std::filesystem::path& now,
                              PageFormat format, MemoryBudget& ram) {
    PixelDifferences found;
    found.ofPages = true;
    const std::size_t bytes = std::filesystem::file_size(before) + std::filesystem::file_size(now);
    const std::optional<Charge> charge = ram.tryCharge(2 * bytes); // a text that grows has twice its bytes
    if (!charge) {
        found.notCompared = noRoom(ram);
        return found;
    }
    const std::string a = pageWithoutManifest(before, format), b = pageWithoutManifest(now, format);
    const std::size_t both = std::min(a.size(), b.size());
    found.pixels = std::max(a.size(), b.size());
    found.differing = found.pixels - both;
    for (std::size_t n = 0; n < both; ++n)
        found.differing += a[n] != b[n] ? 1 : 0;
    return found;
}

std::optional<PictureFormat> formatOf(const std::filesystem::path& path) {
    try {
        return pictureFormat(path);
    } catch (const InputError&) {
        return std::nullopt;
    }
}

} // namespace

ManifestDifferences compareManifests(const json& before, const json& now) {
    ManifestDifferences found;
    add("program", at(before, "/program"), at(now, "/program"), found.program);
    if (before.contains("commit"))
        add("commit", at(before, "/commit"), at(now, "/commit"), found.program);
    for (const char* key : {"engine", "device", "openGl"})
        add(key, before.value(key, json()), now.value(key, json()), found.device);
    if (const json processors = at(before, "/options/processors"); !processors.is_null())
        add("processors", processors, at(now, "/options/processors"), found.device);

    const Values old = sceneValues(before);
    Values changed = sceneValues(now);
    for (const auto& [key, value] : old) {
        const auto same = changed.find(key);
        add(key, value, same == changed.end() ? json() : same->second, found.settings);
        if (same != changed.end())
            changed.erase(same);
    }
    for (const auto& [key, value] : changed)
        add(key, json(), value, found.settings);
    addBytes("--ram", at(before, "/budgets/ram/limitBytes"), at(now, "/budgets/ram/limitBytes"),
             found.settings);
    addBytes("--gpu-memory", at(before, "/budgets/gpuMemory/limitBytes"),
             at(now, "/budgets/gpuMemory/limitBytes"), found.settings);
    add("--verify", verifyOfManifest(before), verifyOfManifest(now), found.settings);
    add("path", lineOf(before), lineOf(now), found.settings);
    add("--allow-damaged", at(before, "/options/allowDamaged"), at(now, "/options/allowDamaged"),
        found.settings);
    add("--tiles", at(before, "/tiles/side"), at(now, "/tiles/side"), found.settings);
    add("--layers", at(before, "/layers"), at(now, "/layers"), found.settings);
    if (at(now, "/scene/annotations/legend") != true)
        add("colour legend of a window", before.contains("legend"), now.contains("legend"), found.settings);
    add("--ranks", before.contains("ranks"), now.contains("ranks"), found.settings);
    return found;
}

PixelDifferences comparePixels(const std::filesystem::path& before, const std::filesystem::path& now,
                               MemoryBudget& ram) {
    PixelDifferences found;
    const auto one = formatOf(before), other = formatOf(now);
    if (const auto page = pageFormat(before); page && page == pageFormat(now))
        return comparePages(before, now, *page, ram);
    if (!one || !other || *one != *other) {
        found.notCompared =
            "their formats differ, " + before.extension().string() + " and " + now.extension().string();
        return found;
    }
    const glm::ivec2 size = sizeOfPicture(before);
    found.size = sizeOfPicture(now);
    if (size != found.size) {
        found.notCompared = "their sizes differ, " + std::to_string(size.x) + " x " + std::to_string(size.y) +
                            " and " + std::to_string(found.size.x) + " x " + std::to_string(found.size.y);
        return found;
    }
    // As floats, and as the file has them while it is read.
    constexpr std::size_t kBytesPerPixel = 3 * sizeof(glm::vec4);
    const auto count = static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y);
    const std::optional<Charge> charge = ram.tryCharge(count * kBytesPerPixel);
    if (!charge) {
        found.notCompared = noRoom(ram);
        return found;
    }
    Image a, b;
    try {
        a = readPicture(before);
        b = readPicture(now);
    } catch (const InputError& error) { // a format that is written and not read
        found.notCompared = error.what();
        return found;
    }
    if (a.size != b.size || a.size != size)
        throw badFile(before.string(), "a picture that stays as it is", "one that was replaced");
    found.pixels = a.pixels.size();
    using Bits = std::array<std::uint32_t, 4>; // of a pixel
    double squares = 0;
    for (std::size_t n = 0; n < a.pixels.size(); ++n) {
        if (std::bit_cast<Bits>(a.pixels[n]) == std::bit_cast<Bits>(b.pixels[n]))
            continue;
        ++found.differing;
        for (int c = 0; c < 4; ++c) {
            const double difference = static_cast<double>(a.pixels[n][c]) - b.pixels[n][c];
            squares += std::isfinite(difference) ? difference * difference : 1;
        }
    }
    found.rms = std::sqrt(squares / static_cast<double>(std::max<std::size_t>(1, 4 * found.pixels)));
    return found;
}

} // namespace tessera
