// tests/bench/lod/edge_functions.h: a slightly rotated gradient, rebuilt from blocks of random levels
// under each edge function: figure 2.24 of the course notes on advanced volume ray casting, with numbers.
#pragma once

#include "core/scene/scene.h" // EdgeFunction
#include "tests/bench/report/report.h"

#include <vector>

namespace tessera::bench {

constexpr int kGradientPixels = 256; // an axis; 8 x 8 blocks of 32 x 32

/// A grey picture, [y][x], 0 to 1 as a display's code values (sRGB).
using GreyPicture = std::vector<double>;

GreyPicture rotatedGradient();
/// A level from 0 (32 x 32 samples) to 5 (one) for each of the 8 x 8 blocks, [y][x].
std::vector<int> randomBlockLevels(unsigned seed);
/// The picture as the product's own field gives it. Every slice of a volume one brick deep is the picture,
/// and levels are constant in depth. It is read at the pixels' centres in its middle plane.
GreyPicture rebuilt(const GreyPicture& original, const std::vector<int>& blockLevels, EdgeFunction function);

/// CIE L*u*v* distance of every pixel, [y][x].
std::vector<double> greyDifferences(const GreyPicture& a, const GreyPicture& b);

struct EdgeFunctionRow {
    EdgeFunction function = EdgeFunction::nearest;
    unsigned seed = 0;
    double mean = 0, p99 = 0, largest = 0; // L*u*v*
    /// Of |second differences| along rows and columns, in code values of 255: the largest, and the root mean
    /// square. A smooth picture has small ones; a linear gradient none.
    double largestBend = 0, rmsBend = 0;
};
/// One row per seed 1..seeds and function, functions in the order of EdgeFunction.
std::vector<EdgeFunctionRow> compareEdgeFunctions(unsigned seeds);

Report edgeFunctionReport(unsigned seeds);

} // namespace tessera::bench
