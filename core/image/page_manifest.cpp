// core/image/page_manifest.cpp: the manifest of a PDF or SVG that viewer/annotations/ wrote, for
// picture_codecs.h.
#include "core/image/picture_codecs.h"

namespace tessera {

std::string pdfManifest(const std::string&) {
    return {};
}

std::string svgManifest(const std::string&) {
    return {};
}

} // namespace tessera
