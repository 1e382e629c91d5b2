// viewer/session/saved_picture.cpp: see saved_picture.h.
#include "viewer/session/saved_picture.h"

#include "core/base/error.h"
#if TESSERA_WITH_IMAGE_FILES
#include "core/image/image_file.h"
#include "core/scene/measurement.h"
#include "viewer/cli/manifest/manifest.h"

#include <nlohmann/json.hpp>
#include <string>
#endif

namespace tessera {

#if TESSERA_WITH_IMAGE_FILES
void savePicture(const std::filesystem::path& path, const ShownPicture& picture, bool scaleBar) {
    checkImagePath(path);
    Image image = picture.background ? overBackground(picture.image, *picture.background) : picture.image;
    std::string manifest =
        picture.manifest.empty() ? R"({"notice":"not for diagnosis","coarse":true})" : picture.manifest;
    if (scaleBar) {
        const ScaleBar bar = scaleBarOf(picture.camera, image.size);
        drawScaleBar(image, bar);
        nlohmann::json document = nlohmann::json::parse(manifest);
        document["scaleBar"] = scaleBarJson(bar);
        manifest = document.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
    }
    writeImage(path, image, manifest);
}
#else
void savePicture(const std::filesystem::path& path, const ShownPicture&, bool) {
    throw InputError(path.string() + ": this program was built without picture files");
}
#endif

} // namespace tessera
