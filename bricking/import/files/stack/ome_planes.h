// bricking/import/files/stack/ome_planes.h: the pages that are the slices of one volume of an OME-TIFF, in
// one file or several. Private to stacks.
#pragma once

#include "bricking/import/files/file_volume.h"
#include "bricking/import/files/stack/ome_text.h"
#include "bricking/import/files/stack/picture_walk.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace tessera {

/// A slice is a page of a file.
struct SlicePage {
    std::size_t file = 0;
    int page = 0;
};

struct OmePlanes {
    OmeTiffImage image;
    std::vector<std::filesystem::path> files;
    std::vector<SlicePage> slices; // by z
    PictureHead head;              // of all files
};

/// Volumes of all images: each is a channel at a point of time; channels go up first. Throws InputError
/// naming `where` for more than 2^20 planes.
std::int64_t omeVolumesOf(const OmeText& text, const std::string& where);
/// Images and channels, at their points of time; empty: one at one point. Throws InputError naming `where`
/// for more than 10000 images and channels, and as omeVolumesOf().
std::vector<FileVolume> omeVolumes(const OmeText& text, const std::string& where);

/// Other files that hold planes, in the folder of the file that names them.
std::vector<std::filesystem::path> otherOmeFiles(const OmeText& text, const std::filesystem::path& file);

/// Walks over all files of the volume. Throws InputError naming the file for a description that is cut or
/// contradicts itself, for planes that no page holds, for a file that is missing or belongs to another set,
/// and for pages of another size or type.
/// @param volume  from 0 on, below omeVolumesOf()
/// @param head  of the file
OmePlanes omePlanesOf(const OmeText& text, std::int64_t volume, const std::filesystem::path& file,
                      const PictureHead& head);

} // namespace tessera
