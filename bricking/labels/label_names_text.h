// bricking/labels/label_names_text.h: names of labels from text. Private to the names of labels.
#pragma once

#include "bricking/labels/label_names.h"

#include <string>
#include <vector>

namespace tessera {

/// The JSON of readLabelNames(). Throws InputError naming `where` and the path.
std::vector<LabelName> labelNamesOfJson(const std::string& text, const std::string& where);

} // namespace tessera
