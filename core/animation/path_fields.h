// core/animation/path_fields.h: the keys of paths as a table, for reader, writer and published schema.
// Include from .cpp files only.
#pragma once

#include "core/animation/path.h"
#include "core/scene/scene_fields.h"

namespace tessera {

const Fields<Path>& pathFields();
/// docs/path.schema.json, which refers to docs/scene.schema.json.
Schema pathSchema();

} // namespace tessera
