// tests/bench/six_tables.h: the results of a suite of pictures, as Markdown to read and as CSV, a line a
// setting.
#pragma once

#include "tests/bench/contest.h"

#include <cstdio>
#include <filesystem>
#include <glm/vec2.hpp>
#include <string>
#include <vector>

namespace tessera::bench {

/// One picture, all renderers.
struct PictureResult {
    std::string name, store;
    bool lit = false;
    glm::ivec2 size{0};
    std::vector<Contender> contenders;
    bool cpuMapperSeesTheLight = true; // a lit picture in perspective: it does not (vtk_renderer.h)
    ErrorTarget target;
    std::size_t comparedPixels = 0;
    double roundingLuvP99 = 0; // of the reference itself, once 8 bits hold it
    double loadBefore = 0, loadAfter = 0;
};

/// The index of a contender, or that of none (their number).
std::size_t indexOf(const std::vector<Contender>& contenders, const std::string& name);

constexpr const char* kVtkCpu = "vtk cpu";
constexpr const char* kVtkGpu = "vtk gpu";

void printSixTables(const std::vector<PictureResult>& results);

/// A line for every setting that was drawn. Throws InputError for a file that cannot be written.
void writeSixCsv(const std::filesystem::path& path, const std::vector<PictureResult>& results);

} // namespace tessera::bench
