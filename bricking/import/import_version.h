// bricking/import/import_version.h: the version of what an import makes, a part of its key in
// the import cache.
#pragma once

namespace tessera {

/// Raised by whoever changes what an import makes of the same files: voxels, values, geometry, or what the
/// store tells of them. Imports in the cache that another version made are made again.
constexpr int kImportVersion = 4;

} // namespace tessera
