// core/scene/colour_legend.h: the colour legend of a picture: a bar of colours by value for every visible
// volume. viewer/annotations/ draws them into pictures; windows draw their own.
#pragma once

#include "core/image/image.h"
#include "core/scene/preset.h" // ValueSummary
#include "core/scene/scene.h"

#include <cstddef>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <vector>

namespace tessera {

/// What a legend takes of a volume of a scene.
struct LegendVolume {
    ValueSummary values;
    std::string unit; // as shown
};

struct LegendBar {
    std::string name, unit;          // of the volume, and of its values; "": none
    double low = 0, high = 1;        // the values at its ends, low < high
    std::vector<glm::dvec3> colours; // linear light, evenly from low to high
    std::size_t volume = 0;          // of the scene's

    std::string title() const { return name + (name.empty() || unit.empty() ? "" : ", ") + unit; }
    /// The value at a part of its length, [0,1].
    std::string textAt(double part) const;
};

/// Bars of the volumes that the picture shows, in the scene's order: colours by the function or, of single
/// values, greys of the window. None of isosurfaces alone. A function's bar is as wide as its points, within
/// the volume's values.
/// @param volumes  of the scene's, from the first on; others have no bar. Their functions are resolved
std::vector<LegendBar> colourLegend(const Scene& scene, std::span<const LegendVolume> volumes);

/// True for a slice that other volumes lie over: its colours need a legend.
bool needsLegend(const Scene& scene);

} // namespace tessera
