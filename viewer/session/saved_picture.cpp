// viewer/session/saved_picture.cpp: see saved_picture.h.
#include "viewer/session/saved_picture.h"

#include "core/error.h"
#if TESSERA_WITH_IMAGE_FILES
#include "core/image_file.h"
#endif

namespace tessera {

#if TESSERA_WITH_IMAGE_FILES
void savePicture(const std::filesystem::path& path, const ShownPicture& picture) {
    checkImagePath(path);
    writeImage(path, picture.background ? overBackground(picture.image, *picture.background) : picture.image,
               picture.manifest.empty() ? R"({"notice":"not for diagnosis","coarse":true})"
                                        : picture.manifest);
}
#else
void savePicture(const std::filesystem::path& path, const ShownPicture&) {
    throw InputError(path.string() + ": this program was built without picture files");
}
#endif

} // namespace tessera
