// viewer/cli/render/reformed_marks.h: what stands in the pictures of a reformation: angles, the patient's
// directions, and where its cross-sections lie.
#pragma once

#include "core/scene/reformation.h"
#include "viewer/annotations/figure.h"

#include <vector>

namespace tessera {

struct ReformedWords {
    std::vector<double> angles;    // degrees, of each picture along the line; none: they are not said
    std::vector<double> sectionMm; // of each cross-section, along the line
    double lineMm = 0;             // its length
    bool letters = false;          // the patient's directions
};

/// Of each picture, in order. Letters of a straightened picture hold at its line's beginning, where they
/// stand; of a stretched one, everywhere.
/// @param straight  pictures along the line are straightened
std::vector<InnerPicture> innerPictures(const std::vector<Reformation>& pictures, bool straight,
                                        const ReformedWords& words);

} // namespace tessera
