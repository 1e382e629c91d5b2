// core/image/page_format.h: pages with a picture, and words and lines over it: PDF and SVG
// (viewer/annotations/figure_file.h), by the name of their file.
#pragma once

#include <filesystem>
#include <optional>

namespace tessera {

enum class PageFormat { pdf, svg };

/// By extension; nullopt: no page.
std::optional<PageFormat> pageFormat(const std::filesystem::path& path);
/// Throws InputError naming path when its extension is neither that of a picture nor of a page.
void checkPictureOrPage(const std::filesystem::path& path);

} // namespace tessera
