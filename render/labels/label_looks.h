// render/labels/label_looks.h: the looks of a scene's labels as factors of the sets that voxels have.
#pragma once

#include "bricking/labels/label_table.h"
#include "core/scene/labels.h"
#include "render/labels/drawn_labels.h"

#include <vector>

namespace tessera {

struct LabelMedium {
    std::vector<LabelFactors> bySet; // of every set of a table
    float density = 0;               // extinction per mm where solid is 1
};

/// The labels of a volume with the names and colours that the scene's file of names gives them, or the
/// program knows. Throws InputError naming that file.
LabelTable namedLabels(const LabelTable& table, const Labels& labels);

/// Of overlapping labels those that show count alike. Labels of other optics than labels.optics, if
/// it is one, are hidden.
/// @param voxelMm  the edge of a typical voxel
/// Throws InputError naming `where` for a pattern that no
/// label matches, with the nearest names.
LabelMedium labelLooks(const LabelTable& table, const Labels& labels, double voxelMm,
                       const std::string& where);

} // namespace tessera
