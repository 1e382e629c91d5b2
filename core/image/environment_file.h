// core/image/environment_file.h: pictures of all directions by longitude and latitude, OpenEXR or Radiance.
// It is a target of its own (tessera_environment_files: OpenImageIO), which programs load with the first such
// file (viewer/cli/modules/).
#pragma once

#include "core/base/budget.h"

#include <filesystem>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

namespace tessera {

struct EnvironmentPixels {
    static constexpr int kMostColumns = 4096;    // of a file
    static constexpr glm::ivec2 kKept{512, 256}; // of what is kept of it, at most
    static constexpr float kMostRadiance = 1e9f;

    glm::ivec2 size{0};
    std::vector<glm::vec3> radiance = {}; // row by row, 0 to kMostRadiance
    std::vector<std::string> notes = {};  // what was changed, in words
};

/// Reads a file in bands of rows. Larger ones are reduced to kKept by means over the sphere. Values below 0
/// count as 0.
/// @param ram  is charged for what reading takes
/// Throws InputError naming the file for one that is no such picture, not twice as wide as high, too large,
/// cut short, or holds values that are not finite or above kMostRadiance.
EnvironmentPixels readEnvironment(const std::filesystem::path& path, MemoryBudget& ram);

} // namespace tessera
