// viewer/cli/redraw/redraw_report.cpp: see redraw_report.h.
#include "viewer/cli/redraw/redraw_report.h"

#include "core/base/shown_text.h"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>

namespace tessera {
namespace {

using nlohmann::json;

bool isAnother(const FoundData& found) {
    return !found.wanted.contentHash.empty() && found.contentHash != found.wanted.contentHash;
}

void printLines(const char* what, const std::vector<Difference>& differences, const std::string& same) {
    if (differences.empty())
        std::printf("%-9s the same%s\n", (std::string(what) + ":").c_str(),
                    same.empty() ? "" : (" (" + printable(same) + ")").c_str());
    for (const Difference& one : differences)
        std::printf("%-9s %s: %s, now %s\n", (std::string(what) + ":").c_str(), printable(one.key).c_str(),
                    printable(one.before).c_str(), printable(one.now).c_str());
}

} // namespace

bool RedrawReport::isDataAnother() const {
    return std::ranges::any_of(data, isAnother);
}

bool RedrawReport::isKnownToDiffer() const {
    return isDataAnother() || !differences.program.empty() || !differences.device.empty() ||
           !differences.settings.empty();
}

void printReport(const RedrawReport& report, const json& now) {
    for (const FoundData& found : report.data) {
        const std::string name = printable(nameOf(found.wanted) + ", " + found.where);
        if (found.wanted.contentHash.empty())
            std::printf("data:     not known to be the same (%s; now %s)\n", name.c_str(),
                        found.contentHash.c_str());
        else if (isAnother(found))
            std::printf("data:     %s: content %s, now %s\n", name.c_str(), found.wanted.contentHash.c_str(),
                        found.contentHash.empty() ? "unknown" : found.contentHash.c_str());
        else
            std::printf("data:     the same (%s; content %s)\n", name.c_str(), found.contentHash.c_str());
    }
    const std::string commit = now.value("commit", "");
    printLines("program", report.differences.program,
               now.value("program", "") + (commit.empty() ? "" : ", commit " + commit));
    printLines("device", report.differences.device,
               now.value("engine", "") + " engine, " + now.value("device", ""));
    printLines("settings", report.differences.settings, "");
    const PixelDifferences& pixels = report.pixels;
    const std::string size = pixels.ofPages
                                 ? std::to_string(pixels.pixels) + " bytes of the page"
                                 : std::to_string(pixels.size.x) + " x " + std::to_string(pixels.size.y);
    if (!pixels.notCompared.empty())
        std::printf("pixels:   not compared: %s\n", printable(pixels.notCompared).c_str());
    else if (pixels.differing == 0)
        std::printf("pixels:   equal (%s)\n", size.c_str());
    else if (pixels.ofPages)
        std::printf("pixels:   %zu of %zu bytes of the page differ\n", pixels.differing, pixels.pixels);
    else
        std::printf("pixels:   %zu of %zu differ, rms %s\n", pixels.differing, pixels.pixels,
                    numberText(pixels.rms).c_str());
}

json reportJson(const RedrawArguments& arguments, const RedrawReport& report) {
    const auto list = [](const std::vector<Difference>& differences) {
        json rows = json::array();
        for (const Difference& one : differences)
            rows.push_back({{"key", one.key}, {"before", one.before}, {"now", one.now}});
        return rows;
    };
    json out = {{"figure", arguments.figure},
                {"output", arguments.out},
                {"program", list(report.differences.program)},
                {"device", list(report.differences.device)},
                {"settings", list(report.differences.settings)}};
    for (const FoundData& found : report.data)
        out["data"].push_back({{"name", nameOf(found.wanted)},
                               {"before", found.wanted.contentHash},
                               {"now", found.contentHash},
                               {"where", found.where}});
    const PixelDifferences& pixels = report.pixels;
    if (pixels.ofPages && pixels.notCompared.empty())
        out["pixels"] = {{"equal", pixels.differing == 0},
                         {"differingBytes", pixels.differing},
                         {"ofBytes", pixels.pixels}};
    else
        out["pixels"] = pixels.notCompared.empty() ? json{{"equal", pixels.differing == 0},
                                                          {"differing", pixels.differing},
                                                          {"of", pixels.pixels},
                                                          {"rms", pixels.rms}}
                                                   : json{{"notCompared", pixels.notCompared}};
    return out;
}

} // namespace tessera
