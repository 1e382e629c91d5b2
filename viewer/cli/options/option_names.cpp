// viewer/cli/options/option_names.cpp: see option_names.h.
#include "viewer/cli/options/option_names.h"

#include "core/base/names.h"

#include <algorithm>
#include <cctype>
#include <sstream>
#include <utility>

namespace tessera {
namespace {

/// Synonyms from ParaView, VTK, 3D Slicer, ffmpeg and radiology. The first option that the command has is
/// used.
const std::vector<std::pair<const char*, std::vector<const char*>>>& otherWords() {
    static const std::vector<std::pair<const char*, std::vector<const char*>>> words = {
        {"--preset",
         {"colour", "color", "colours", "colors", "colormap", "colourmap", "palette", "lut", "tf", "transfer",
          "transfer-function", "opacity", "style"}},
        {"--mode", {"mip", "minip", "blend-mode", "blend", "projection-mode", "render-mode", "ray-mode"}},
        {"--window", {"level", "window-level", "wl", "ww", "contrast", "brightness"}},
        {"--slice", {"mpr", "plane", "reslice", "axial", "coronal", "sagittal", "oblique"}},
        {"--crop", {"box", "roi", "cropping", "clip-box", "crop-box", "bounds", "region"}},
        {"--cut-plane", {"clip", "clip-plane", "clipping", "clipping-plane", "cut"}},
        {"--slab", {"thickness", "thick", "slab-thickness", "slab-mode"}},
        {"--light",
         {"lights", "lighting", "illumination", "shadow", "shadows", "ao", "occlusion", "ambient-occlusion",
          "studio"}},
        {"--background", {"bg", "back", "background-color", "background-colour"}},
        {"--size", {"width", "height", "resolution", "res", "dimensions", "dims", "pixels", "geometry"}},
        {"--view", {"camera", "angle", "side", "orientation", "direction", "from", "look"}},
        {"--fit", {"zoom", "frame", "framing", "fov"}},
        {"--projection", {"ortho", "orthographic", "parallel", "perspective"}},
        {"--output", {"out", "outfile", "file", "save", "dest", "to"}},
        {"--ram", {"memory", "mem", "max-memory", "cache"}},
        {"--gpu-memory", {"vram", "gpu-mem", "video-memory", "texture-memory"}},
        {"--gl-device", {"gpu", "device", "gl", "egl", "software", "cpu"}},
        {"--isosurface", {"iso", "isovalue", "surface", "threshold", "contour", "level"}},
        {"--max-error", {"quality", "accuracy", "error", "tolerance"}},
        {"--samples",
         {"spp", "aa", "antialias", "anti-alias", "antialiasing", "anti-aliasing", "supersampling", "msaa"}},
        {"--verify", {"check", "measure", "validate", "test"}},
        {"--step", {"steps", "spacing", "distance", "sample-distance", "rate", "sampling-rate"}},
        {"--no-shading",
         {"shading", "shade", "light", "lighting", "lights", "unlit", "no-light", "no-lighting"}},
        {"--gradient", {"normals", "normal", "smooth", "derivative"}},
        {"--fetch", {"interpolation", "filter", "filtering", "nearest", "linear"}},
        {"--first", {"preview", "coarse", "progressive", "draft"}},
        {"--quiet", {"silent", "no-progress", "batch"}},
        {"--verbose", {"progress", "debug", "log", "loud"}},
        {"--force", {"overwrite", "replace", "yes", "clobber"}},
        {"--largest", {"biggest", "all"}},
        {"--resample-z", {"resample", "even", "interpolate"}},
        {"--allow-missing", {"ignore-missing", "skip-missing", "incomplete", "skip-damaged", "partial"}},
        {"--phase", {"time", "timepoint", "time-point", "temporal", "cardiac-phase", "echo"}},
        {"--scans", {"data", "datasets", "input"}},
        {"--json", {"manifest", "format", "machine-readable"}},
        {"--explain", {"stats", "statistics", "info", "describe"}},
    };
    return words;
}

std::string plain(const std::string& option) {
    std::string word = option.substr(0, option.find('='));
    word.erase(0, word.find_first_not_of('-'));
    std::transform(word.begin(), word.end(), word.begin(),
                   [](unsigned char c) { return c == '_' ? '-' : static_cast<char>(std::tolower(c)); });
    return word;
}

/// True if one of the words between hyphens begins with it.
bool hasPart(const std::string& option, const std::string& part) {
    std::istringstream words(plain(option));
    for (std::string word; std::getline(words, word, '-');)
        if (word.rfind(part, 0) == 0)
            return true;
    return plain(option).rfind(part, 0) == 0;
}

} // namespace

std::string likelyOption(const std::string& unknown, const std::vector<std::string>& known) {
    const std::string word = plain(unknown);
    const auto isKnown = [&](const char* name) {
        return std::find(known.begin(), known.end(), name) != known.end();
    };
    const std::string nearest = nearestName("--" + word, known);
    const std::size_t away = editDistance("--" + word, nearest);
    if (away <= 1)
        return nearest; // a slip of a finger
    for (const auto& [option, others] : otherWords())
        if (isKnown(option) && std::find(others.begin(), others.end(), word) != others.end())
            return option;
    constexpr std::size_t kTelling = 3; // letters; fewer match too many options
    if (word.size() >= kTelling)
        for (const std::string& option : known)
            if (hasPart(option, word))
                return option;
    constexpr std::size_t kSlips = 2; // letters swapped, or two keys beside the right ones
    return away <= std::max(kSlips, word.size() / 3) && word.size() > kSlips ? nearest : std::string();
}

} // namespace tessera
