// bricking/import/labels/open_labels.h: the labels of a file, or of a folder of masks, by the table of label
// formats.
#pragma once

#include "bricking/import/source/slab_source.h"
#include "bricking/labels/label_source.h"

#include <filesystem>

namespace tessera {

/// Opens a file of a label format, a folder that such a format reads itself, or a folder of masks. In a
/// folder of masks every file is a structure that has the file's name: values 1 to n in the order of names,
/// all that is not 0 is inside. Files of other kinds are left out, and noted. Headers alone are read. Throws
/// InputError naming what is no file or folder of labels, with the formats that would be.
LabelFile openLabels(const std::filesystem::path& path, const SourceOptions& options);

} // namespace tessera
