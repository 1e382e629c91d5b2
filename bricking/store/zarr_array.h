// bricking/store/zarr_array.h: small dense arrays beside the levels (statistics), as ordinary unsharded Zarr
// v3. An array is a grid [z][y][x] of elements, each one value or a row of values, with the same codecs as
// the levels. Every chunk is written, so a missing one is an error.
#pragma once

#include "bricking/store/store_files.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <glm/vec3.hpp>
#include <span>
#include <string>

namespace tessera {

struct ArraySpec {
    std::string dataType;       // of Zarr: "float32", "uint16"
    std::size_t valueBytes = 0; // of one value
    glm::ivec3 grid{0};         // elements
    glm::ivec3 chunk{0};        // elements of a chunk
    std::size_t row =
        0; // values of an element as a fourth dimension, never split; 0: one value, no dimension

    std::size_t elementBytes() const { return valueBytes * (row == 0 ? 1 : row); }
    /// Layers of chunks along z; layer n holds grid slices [n * chunk.z, min((n + 1) * chunk.z, grid.z)).
    int layers() const { return (grid.z + chunk.z - 1) / chunk.z; }
    std::size_t chunkBytes() const;
    /// Memory for writing or reading, besides the layer itself.
    std::size_t scratchBytes() const;
};

/// Creates the folder and its zarr.json.
void writeArrayMetadata(const std::filesystem::path& folder, const ArraySpec& spec);
/// Writes one layer of chunks from its slices, [slices][grid.y][grid.x] elements.
void writeArrayLayer(const std::filesystem::path& folder, const ArraySpec& spec, int layer,
                     std::span<const std::byte> slices);
/// Of a layer the chunks of a band of rows, [slices][rows][grid.x] elements.
/// @param firstRow  of chunks; the band has whole chunks, or ends with the grid
void writeArrayBand(const std::filesystem::path& folder, const ArraySpec& spec, int layer, int firstRow,
                    std::span<const std::byte> band);

/// Tells a store behind an address that the layers of an array will be read (RemoteFiles::willRead()).
/// @param first, end  of the layers
void tellArrayLayers(const StoreFolder& store, const std::string& relative, const ArraySpec& spec, int first,
                     int end);

/// Checks zarr.json against spec; reads one layer.
/// @param store, relative  the store's folder and the array's path in it
/// @param shown  the store's path
/// Both throw InputError naming the file when something is missing, different or damaged.
void checkArrayMetadata(const StoreFolder& store, const std::string& relative, const ArraySpec& spec,
                        const std::filesystem::path& shown);
void readArrayLayer(const StoreFolder& store, const std::string& relative, const ArraySpec& spec, int layer,
                    std::span<std::byte> slices, const std::filesystem::path& shown);

} // namespace tessera
