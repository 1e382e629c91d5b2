// bricking/import/labels/zarr/ome_labels.h: what "image-label" of OME-Zarr says of labels. Private to the
// reader of Zarr labels.
#pragma once

#include "bricking/import/zarr/zarr_node.h"
#include "bricking/labels/label_table.h"

#include <string>
#include <vector>

namespace tessera {

struct OmeLabels {
    bool isThere = false;      // the group has "image-label"
    std::vector<Label> labels; // ascending; without 0
    std::string image;         // that the labels are of, relative to their group; "" not told
};

/// Colours from "colors" (sRGB; opacity is left out), names from "properties": the first text among "name",
/// "names" (a list is joined by ", "), "label" and "class". Throws InputError naming the file and the key for
/// colours and numbers of labels that are none, and for a label twice in a list.
OmeLabels omeLabelsOf(const ZarrNode& group);

} // namespace tessera
