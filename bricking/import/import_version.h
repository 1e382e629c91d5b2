// bricking/import/import_version.h: the version of import results, a part of their key in the import cache.
#pragma once

namespace tessera {

/// Raise it with every change of the result for the same files: voxels, values, geometry, or the store's
/// metadata. Cached imports of another version are made again.
constexpr int kImportVersion = 4;

} // namespace tessera
