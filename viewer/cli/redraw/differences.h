// viewer/cli/redraw/differences.h: what two pictures differ in, by their manifests and by their pixels.
#pragma once

#include "core/base/budget.h"

#include <cstddef>
#include <filesystem>
#include <glm/vec2.hpp>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace tessera {

struct Difference {
    std::string key, before, now; // "nothing" where a manifest has no such key
};

struct ManifestDifferences {
    std::vector<Difference> program;  // version and commit
    std::vector<Difference> device;   // engine, device, OpenGL, processors
    std::vector<Difference> settings; // keys of the scene, options and budgets
};
/// What an older manifest does not tell counts as equal.
ManifestDifferences compareManifests(const nlohmann::json& before, const nlohmann::json& now);

struct PixelDifferences {
    std::string notCompared; // why; "": they were
    bool ofPages = false;    // PDF or SVG: pixels are bytes of the files
    glm::ivec2 size{0};
    std::size_t pixels = 0, differing = 0;
    double rms = 0; // linear premultiplied RGBA, over all pixels
};
/// Of two pictures' files. Both are charged to ram before they are read; where it has no room, or their
/// formats or sizes differ, they are not compared. Of two pages the files' bytes are, without
/// the manifests in them.
PixelDifferences comparePixels(const std::filesystem::path& before, const std::filesystem::path& now,
                               MemoryBudget& ram);

} // namespace tessera
