// core/image/image_file.h: pictures on disk, their format by extension: PNG (8-bit sRGB), EXR (linear
// float32), TIFF (16-bit sRGB). It is a target of its own (tessera_image_files: libpng, OpenEXR, libtiff), so
// a bare machine builds without it. Programs load it with their first picture (viewer/cli/modules/).
#pragma once

#include "core/image/image.h"

#include <filesystem>
#include <glm/vec2.hpp>
#include <span>
#include <string>

namespace tessera {

/// Throws InputError naming path when its extension is not one that writeImage() knows.
void checkImagePath(const std::filesystem::path& path);

/// Writes an OutputFile (output_file.h): an earlier picture stays until the new one is complete on disk.
/// @param manifest  JSON text stored as ImageDescription
/// Alpha: EXR stores premultiplied linear values; PNG and TIFF store unassociated alpha (3 channels if
/// opaque). Throws Error naming path when it cannot be written.
/// @param layers  EXR alone has them
/// @param dpi     pixels per inch, in PNG and TIFF; 0: not told
void writeImage(const std::filesystem::path& path, const Image& image, const std::string& manifest,
                std::span<const LayerChannel> layers = {}, double dpi = 0);

/// Rows of four channels R, G, B and A of a layer, of the picture's size.
struct LayerRows {
    std::string name;
    ImageRows picture;
};
/// The same file from rows, of which kAtOnce are in memory.
/// @param over  EXR alone has it; null: none
void writeImageRows(const std::filesystem::path& path, const ImageRows& picture, const std::string& manifest,
                    double dpi = 0, const LayerRows* over = nullptr);

/// Reads back what writeImage wrote, as linear premultiplied float, without layers. Throws InputError naming
/// path.
Image readImage(const std::filesystem::path& path);
/// The size by the header alone. Throws InputError naming path.
glm::ivec2 pictureSize(const std::filesystem::path& path);
/// Throws InputError naming path for a picture that cannot be read or is cut off at its end, and for a page
/// (viewer/annotations/figure_file.h) likewise. Reads its beginning and its end.
void checkPictureIsWhole(const std::filesystem::path& path);
/// The ImageDescription of a picture, or the manifest of a PDF or SVG (viewer/annotations/figure_file.h); ""
/// if none.
std::string readManifest(const std::filesystem::path& path);

} // namespace tessera
