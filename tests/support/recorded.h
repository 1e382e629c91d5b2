// tests/support/recorded.h: results of the program as text that does not depend on machine, folder and time,
// and the comparison of two of them.
#pragma once

#include "core/image/image_file.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

namespace tessera::test {

/// Without what a run, a machine or a version changes: seconds, the device, peaks of memory, keys of the
/// cache, libraries and fonts of annotations. What a manifest has for drawing again (data, options, path) has
/// tests of its own (redraw_test.cpp).
inline void forgetTheRun(nlohmann::json& value) {
    static const std::vector<std::string> kOfTheRun = {
        "seconds", "device",  "peakBytes", "program", "openGl", "notice",  "dispatches",
        "entry",   "lastUse", "cairo",     "pango",   "fonts",  "lineHash"};
    if (value.is_object() && value.contains("tesseraManifest"))
        for (const char* key : {"commit", "data", "options", "path"})
            value.erase(key);
    if (value.is_object())
        for (const std::string& key : kOfTheRun)
            value.erase(key);
    if (value.is_structured())
        for (nlohmann::json& part : value)
            forgetTheRun(part);
}

inline void numbersOf(const nlohmann::json& value, std::vector<double>& numbers) {
    if (value.is_number())
        numbers.push_back(value.get<double>());
    for (const nlohmann::json& part : value.is_structured() ? value : nlohmann::json::array())
        numbersOf(part, numbers);
}

/// Long lists become their length, first and last items, and the moments of their numbers, by value and by
/// order.
inline void shorten(nlohmann::json& value) {
    constexpr std::size_t kLong = 40;
    if (value.is_array() && value.size() > kLong && !value[0].is_string()) {
        std::vector<double> numbers;
        numbersOf(value, numbers);
        double sum = 0, squares = 0, ordered = 0;
        for (std::size_t i = 0; i < numbers.size(); ++i) {
            sum += numbers[i];
            squares += numbers[i] * numbers[i];
            ordered += numbers[i] * static_cast<double>(i);
        }
        value = {{"items", value.size()}, {"numbers", numbers.size()}, {"sum", sum},
                 {"squares", squares},    {"ordered", ordered},        {"first", value.front()},
                 {"last", value.back()}};
    }
    if (value.is_structured())
        for (nlohmann::json& part : value)
            shorten(part);
}

/// Text without times, devices and the folder of the run.
inline std::string textWithoutTheRun(std::string text, const std::filesystem::path& folder) {
    for (std::size_t at; (at = text.find(folder.string())) != std::string::npos;)
        text.replace(at, folder.string().size(), "FOLDER");
    text = std::regex_replace(text, std::regex("CPU, (avx512|avx2|baseline)"), "CPU");
    text = std::regex_replace(text, std::regex("[0-9]+(\\.[0-9]+)? (ms|s|min)\\b"), "T s");
    text = std::regex_replace(text, std::regex("[0-9]+ (segments|samples)\\b"), "N $1"); // by packets' widths
    text =
        std::regex_replace(text, std::regex("voxels in [0-9]+ of them"), "voxels in N of them"); // likewise
    text =
        std::regex_replace(text, std::regex("[0-9.]+ [KMG]iB of memory available"), "M of memory available");
    text = std::regex_replace(text, std::regex("most charged: RAM [0-9.]+ [KMG]iB"),
                              "most charged: RAM M"); // by threads
    text = std::regex_replace(text, std::regex("/[0-9a-f]{16}\\.zarr"),
                              "/KEY.zarr"); // of the cache: a file's path and time
    text = std::regex_replace(text, std::regex("(^|\n)[0-9a-f]{16} "), "$1KEY ");
    text = std::regex_replace(text, std::regex("[0-9]{4}-[0-9]{2}-[0-9]{2} [0-9]{2}:[0-9]{2}"), "DATE");
    text = std::regex_replace(text, std::regex("[0-9]+ dispatches"),
                              "N dispatches"); // by the time that they take
    return text;
}

inline std::vector<std::string> linesOf(const std::string& text, const std::filesystem::path& folder) {
    std::vector<std::string> lines;
    std::istringstream in(textWithoutTheRun(text, folder));
    for (std::string line; std::getline(in, line);)
        lines.push_back(line.substr(0, line.find_last_not_of(' ') + 1));
    return lines;
}

/// JSON, or lines, of what the program printed or wrote.
inline nlohmann::json contentOf(const std::string& text, const std::filesystem::path& folder) {
    nlohmann::json value = nlohmann::json::parse(textWithoutTheRun(text, folder), nullptr, false);
    if (value.is_discarded() || !value.is_structured())
        return linesOf(text, folder);
    forgetTheRun(value);
    shorten(value);
    return value;
}

/// A hash of bytes (FNV-1a of 64 bits), as text.
inline std::string digestOf(const std::string& bytes) {
    std::uint64_t hash = 0xcbf29ce484222325;
    for (const char byte : bytes)
        hash = (hash ^ static_cast<unsigned char>(byte)) * 0x100000001b3;
    char text[17];
    std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash));
    return text;
}

/// Bytes of a string of two hexadecimal digits each.
inline std::string bytesOf(const std::string& digits) {
    std::string bytes;
    for (std::size_t i = 0; i + 1 < digits.size(); i += 2)
        bytes += static_cast<char>(std::stoi(digits.substr(i, 2), nullptr, 16));
    return bytes;
}

/// A picture as its size and means: 8 x 6 fields, row by row from the top, red, green, blue, alpha of each.
inline nlohmann::json meansOf(const std::filesystem::path& path) {
    const Image image = readImage(path);
    constexpr int kColumns = 8, kRows = 6;
    nlohmann::json rows = nlohmann::json::array();
    for (int row = 0; row < kRows; ++row) {
        nlohmann::json means = nlohmann::json::array();
        for (int column = 0; column < kColumns; ++column) {
            const auto edge = [](int part, int of, int size) { return part * size / of; };
            glm::dvec4 sum(0);
            int count = 0;
            for (int y = edge(row, kRows, image.size.y); y < edge(row + 1, kRows, image.size.y); ++y)
                for (int x = edge(column, kColumns, image.size.x);
                     x < edge(column + 1, kColumns, image.size.x); ++x, ++count)
                    sum += glm::dvec4(image.pixels[static_cast<std::size_t>(y) * image.size.x + x]);
            for (int channel = 0; channel < 4; ++channel)
                means.push_back(std::round(1e5 * sum[channel] / std::max(count, 1)) / 1e5);
        }
        rows.push_back(means);
    }
    return {{"size", {image.size.x, image.size.y}}, {"means", rows}};
}

/// How far numbers may be apart, as a share. Packets of other widths leap together with other rays, and take
/// a few more samples of rays that end.
inline double toleranceOf(const std::string& key) {
    return key == "iterations" || key == "samples" || key == "segments" ? 0.12 : 1e-5;
}

/// Places where two results differ, and both values there; at most ten.
inline void compare(const nlohmann::json& recorded, const nlohmann::json& found, const std::string& place,
                    const std::string& key, std::vector<std::string>& differences) {
    if (differences.size() >= 10)
        return;
    const auto differ = [&] {
        differences.push_back(place + ": recorded " + recorded.dump().substr(0, 300) + ", found " +
                              found.dump().substr(0, 300));
    };
    if (recorded.is_number() && found.is_number()) {
        const auto a = recorded.get<double>(), b = found.get<double>();
        if (!(std::abs(a - b) <= toleranceOf(key) * std::max(std::abs(a), std::abs(b)) + 1.5e-5))
            differ();
    } else if (recorded.type() != found.type() || recorded.size() != found.size()) {
        differ();
    } else if (recorded.is_array()) {
        for (std::size_t i = 0; i < recorded.size(); ++i)
            compare(recorded[i], found[i], place + "[" + std::to_string(i) + "]", key, differences);
    } else if (recorded.is_object()) {
        for (const auto& [name, value] : recorded.items())
            if (found.contains(name))
                compare(value, found[name], place + "." + name, name, differences);
            else
                differences.push_back(place + "." + name + ": is missing");
    } else if (recorded != found) {
        differ();
    }
}

/// One line for each of the first two levels: what changes is seen in a comparison of versions.
inline std::string textOf(const nlohmann::json& record) {
    std::ostringstream out;
    out << "{";
    for (auto part = record.begin(); part != record.end(); ++part) {
        out << (part == record.begin() ? "\n" : ",\n") << " " << nlohmann::json(part.key()) << ": ";
        if (!part->is_structured() || part->empty()) {
            out << *part;
            continue;
        }
        out << (part->is_array() ? "[" : "{");
        for (auto item = part->begin(); item != part->end(); ++item) {
            out << (item == part->begin() ? "\n  " : ",\n  ");
            if (part->is_object())
                out << nlohmann::json(item.key()) << ": ";
            out << *item;
        }
        out << "\n " << (part->is_array() ? "]" : "}");
    }
    out << "\n}\n";
    return out.str();
}

} // namespace tessera::test
