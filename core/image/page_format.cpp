// core/image/page_format.cpp: see page_format.h.
#include "core/image/page_format.h"

#include "core/base/error.h"
#include "core/image/image.h"

#include <algorithm>
#include <cctype>
#include <string>

namespace tessera {

std::optional<PageFormat> pageFormat(const std::filesystem::path& path) {
    std::string extension = path.extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (extension == ".pdf")
        return PageFormat::pdf;
    if (extension == ".svg")
        return PageFormat::svg;
    return std::nullopt;
}

void checkPictureOrPage(const std::filesystem::path& path) {
    if (pageFormat(path))
        return;
    try {
        pictureFormat(path);
    } catch (const BadFile& bad) {
        throw badFile(path.string(), bad.expected() + ", or of a figure: .pdf or .svg", bad.found());
    }
}

} // namespace tessera
