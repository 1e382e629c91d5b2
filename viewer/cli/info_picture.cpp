// viewer/cli/info_picture.cpp: `tessera info PICTURE`: what a picture says of itself, how wrong it is
// first.
#include "viewer/cli/info_picture.h"

#include "core/base/error.h"
#include "core/base/shown_text.h"
#include "core/image/image_file.h"

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <tuple>

namespace tessera {
namespace {

using nlohmann::json;

std::string numberText(const json& value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.3g", value.get<double>());
    return text;
}

/// "1.2 (0.9 to 1.6)"; nothing where there is none.
std::string estimateText(const json& of, const char* key) {
    if (!of.contains(key))
        return {};
    const json& e = of.at(key);
    return numberText(e.at("value")) + " (" + numberText(e.at("from")) + " to " + numberText(e.at("to")) +
           ")";
}

std::string errorText(const json& of) {
    std::string text;
    for (const auto& [key, before, after] :
         {std::tuple("luvPercentile99", "L*u*v* ", " at the 99th percentile"),
          std::tuple("luvMean", "L*u*v* ", " in the mean"), std::tuple("rms", "rms ", "")})
        if (const std::string e = estimateText(of, key); !e.empty())
            text += (text.empty() ? "" : ", ") + (before + e) + after;
    return text.empty() ? "too few visible pixels" : text;
}

void printErrors(const json& errors) {
    if (!errors.contains("measured"))
        return printLine("error", "not measured");
    const json& m = errors.at("measured");
    if (m.contains("notMeasured"))
        return printLine("error", "not measured: " + m.at("notMeasured").get<std::string>());
    printLine("error", errorText(m));
    if (m.contains("notCounted"))
        for (const json& what : m.at("notCounted"))
            printLine("not in it",
                      what == "light" ? "what light itself errs by" : "what levels and step err by");
    printLine("measured", "on " + std::to_string(m.at("pixelsThatShow").get<int>()) + " pixels of " +
                              std::to_string(m.at("samplesOfPixel").get<int>()) + " rays");
    printLine("of samples", errorText(m.at("samplesOfPixels")));
    if (m.contains("levelsStepFiltering"))
        printLine("of rays", errorText(m.at("levelsStepFiltering")));
    if (m.contains("light"))
        printLine("beside it", "of light " + errorText(m.at("light")));
    if (errors.contains("maxErrorNotReached"))
        printLine("not reached", errors.at("maxErrorNotReached").get<std::string>());
}

/// Of a volume that is not all of its file's finest level.
void printFilePart(const json& volume, const char* key) {
    if (!volume.contains("filePart"))
        return;
    const json& part = volume.at("filePart");
    const auto list = [](const json& numbers, const char* between) {
        std::string text;
        for (const json& number : numbers)
            text += (text.empty() ? "" : between) + std::to_string(number.get<int>());
        return text;
    };
    printLine(key, std::to_string(part.at("fileLevel").get<int>()) + " (0 is the finest), " +
                       list(part.at("levelVoxels"), " x ") + " voxels of " +
                       list(part.at("finestVoxels"), " x ") + ", box " + list(part.at("fileBox"), ",") +
                       "; errors are against this level");
}

/// What a manifest says of its picture.
void printPicture(const json& manifest) {
    printLine("made by", manifest.at("program").get<std::string>() + ", engine " +
                             manifest.at("engine").get<std::string>() + ", " +
                             manifest.at("device").get<std::string>());
    if (manifest.contains("unfolded"))
        printLine("unfolded", "a wall, " + numberText(manifest.at("unfolded").at("lengthMm")) + " mm long");
    if (manifest.contains("reformation"))
        printLine("reformation", manifest.at("reformation").at("form").get<std::string>());
    printFilePart(manifest.at("store"), "file level");
    for (const json& volume : manifest.value("furtherVolumes", json::array()))
        printFilePart(volume, "of a further");
    const json& pixels = manifest.at("pixels");
    printLine("samples", numberText(pixels.at("samplesTaken")) + " per pixel in the mean, " +
                             numberText(pixels.at("samplesTakenAtMost")) + " at most");
    const json& segments = manifest.at("segments");
    printLine("segments", numberText(segments.at("stepVoxels")) + " voxels, " +
                              segments.at("integrator").get<std::string>());
    if (manifest.contains("paths") && pixels.contains("standardError")) // not measured, but told
        printLine("noise", "rms " + numberText(pixels.at("standardError").at("rms")) + ", L*u*v* " +
                               numberText(pixels.at("standardError").at("luvPercentile99")) +
                               " at the 99th percentile (standard error of the samples' mean)");
    printErrors(manifest.at("errors"));
}

} // namespace

void printLine(const char* key, const std::string& value) {
    std::printf("%-14s %s\n", (std::string(key) + ":").c_str(), printable(value).c_str());
}

bool isPictureName(const std::filesystem::path& path) {
    std::string extension = path.extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    std::error_code ignored;
    return (extension == ".png" || extension == ".exr" || extension == ".tif" || extension == ".tiff" ||
            extension == ".pdf" || extension == ".svg") &&
           std::filesystem::is_regular_file(path, ignored);
}

void infoPicture(const std::filesystem::path& path, bool asJson) {
    const std::string text = readManifest(path);
    const json manifest = json::parse(text, nullptr, false);
    if (!manifest.is_object() || !manifest.contains("program"))
        throw badFile(path.string(), "a picture that tessera made", "one without its manifest");
    if (asJson) {
        std::printf("%s\n", manifest.dump(2, ' ', true, json::error_handler_t::replace).c_str());
        return;
    }
    try {
        printLine("picture", path.string());
        if (!manifest.contains("panels"))
            return printPicture(manifest);
        const json& panels = manifest.at("panels");
        printLine("panels", std::to_string(panels.size()));
        for (std::size_t n = 0; n < panels.size(); ++n) {
            printLine("panel", std::to_string(n + 1));
            printPicture(panels.at(n));
        }
    } catch (const json::exception&) {
        throw badFile(path.string(), "the manifest of this version of tessera", "another; --json prints it");
    }
}

} // namespace tessera
