// tests/bench/peer_tables.h: times and errors of renderers, as tables to read and as CSV for `tessera
// accuracy --peers`.
#pragma once

#include "core/base/work.h"
#include "core/image/image.h"
#include "core/image/image_metrics.h"

#include <functional>
#include <string>
#include <vector>

namespace tessera::bench {

/// One renderer at one sample distance.
struct Method {
    std::string family;
    double distanceVoxels = 0;
    bool tessera = false;           // then it is known before rounding too
    std::function<double()> draw;   // milliseconds
    std::function<Image()> picture; // of the last draw
    std::vector<double> ms;
    Image pixels;                  // thinned, as it came
    ImageDifference asIs, rounded; // against the reference, without the border
    double rmsWithBorder = 0;      // rounded
    Work work;                     // Tessera's only
};

struct RunOn {
    std::string scene, tesseraDevice, vtkDevice;
    double loadBefore = 0;
};

/// Tables of every method and of least times at equal error, in Markdown, to stdout.
/// @param families  in the order of the columns
void printTables(const std::vector<Method>& methods, const std::vector<std::string>& families);

/// Errors are those of 8-bit pictures, by which all can be compared; "_float" is before rounding.
/// Throws InputError for a file that cannot be written.
void writeCsv(const std::string& path, const std::vector<Method>& methods, const RunOn& on);

} // namespace tessera::bench
