// viewer/cli/modules/pictures_on_demand.cpp: core/image/image_file.h for programs: the first picture that is
// read or written loads what does that.
#include "core/image/image.h"
#include "viewer/cli/modules/picture_module.h"

namespace tessera {
namespace {

const PictureModule& pictureModule() {
    static const auto* const table = static_cast<const PictureModule*>(loadModule("tessera_pictures"));
    return *table;
}

} // namespace

void checkImagePath(const std::filesystem::path& path) {
    pictureFormat(path); // long before there is a picture
}
void writeImage(const std::filesystem::path& path, const Image& image, const std::string& manifest,
                std::span<const LayerChannel> layers, double dpi) {
    pictureModule().write(path, image, manifest, layers, dpi);
}
void writeImageRows(const std::filesystem::path& path, const ImageRows& picture, const std::string& manifest,
                    double dpi, const LayerRows* over) {
    pictureModule().writeRows(path, picture, manifest, dpi, over);
}
Image readImage(const std::filesystem::path& path) {
    return pictureModule().read(path);
}
std::string readManifest(const std::filesystem::path& path) {
    return pictureModule().manifest(path);
}
glm::ivec2 pictureSize(const std::filesystem::path& path) {
    return pictureModule().size(path);
}
void checkPictureIsWhole(const std::filesystem::path& path) {
    pictureModule().checkIsWhole(path);
}

} // namespace tessera
