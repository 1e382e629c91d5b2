// bricking/import/import_version.h: which way of importing made a store.
#pragma once

namespace tessera {

/// Raised by whoever changes what an import makes of the same files: voxels, values, geometry, or what the
/// store tells of them. Imports in the cache that another version made are made again.
constexpr int kImportVersion = 4;

} // namespace tessera
