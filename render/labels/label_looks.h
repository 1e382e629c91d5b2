// render/labels/label_looks.h: the looks of a scene's labels as factors of the sets that voxels have.
#pragma once

#include "bricking/labels/label_table.h"
#include "core/scene/labels.h"
#include "render/labels/drawn_labels.h"

#include <cstdint>
#include <glm/vec3.hpp>
#include <string>
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

/// How labels show over the values of slices.
struct SliceLooks {
    struct OneLabel {
        glm::vec3 colour{1};
        float outline = 0; // pixels
    };
    /// Labels that show, of sets that have some.
    struct Set {
        std::vector<std::uint16_t> labels; // numbers in the table
        glm::vec3 keep{1}, add{0};         // the fill: keep * colour + add
        float cover = 0;                   // of what is added, [0,1]
    };
    std::vector<OneLabel> labels;
    std::vector<Set> sets;            // by comesBefore(), none twice; the first has no label
    std::vector<std::uint16_t> ofSet; // of every set of the table: its number in `sets`
    double widest = 0;                // outline, pixels
};
/// Throws InputError as labelLooks() does.
SliceLooks sliceLooks(const LabelTable& table, const Labels& labels, const std::string& where);

} // namespace tessera
