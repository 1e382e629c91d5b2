// render/picture/several_volumes.cpp: see several_volumes.h.
#include "render/picture/several_volumes.h"

#include "core/base/error.h"
#include "core/scene/mode.h"
#include "render/picture/render_scene.h"
#include "render/plan/fusion.h"

#include <algorithm>
#include <glm/common.hpp>

namespace tessera {
namespace {

/// A slice without a place lies in the middle of the first volume.
void placeSlice(SlicePlane& slice, const VolumeInfo& info) {
    if (slice.orientation == Orientation::oblique || slice.positionMm)
        return;
    const glm::dvec3 middle(info.patientFromVoxel * glm::dvec4(0.5 * glm::dvec3(info.extentVoxels), 1));
    slice.positionMm = middle[slice.orientation == Orientation::axial     ? 2
                              : slice.orientation == Orientation::coronal ? 1
                                                                          : 0];
}

} // namespace

void layOver(Image& below, const Image& above, double opacity, Fusion rule) {
    TESSERA_CHECK(below.size == above.size);
    const auto share = static_cast<float>(opacity);
    for (std::size_t i = 0; i < below.pixels.size(); ++i) {
        glm::vec4& pixel = below.pixels[i];
        const glm::vec4 upper = share * above.pixels[i];
        switch (rule) {
        case Fusion::maximum:
            pixel = glm::max(pixel, upper);
            break;
        case Fusion::over:
            pixel = upper + (1 - upper.a) * pixel;
            break;
        case Fusion::mix: { // colours by their shares
            const float both = pixel.a + upper.a, alpha = upper.a + (1 - upper.a) * pixel.a;
            if (both > 0)
                pixel = glm::vec4(alpha / both * (glm::vec3(pixel) + glm::vec3(upper)), alpha);
            break;
        }
        }
    }
}

RenderResult drawVolumesAlone(const Scene& given, Stores stores, MemoryBudget& ram, MemoryBudget& gpu,
                              const RenderOptions& options) {
    Scene scene = given;
    placeSlice(scene.slice, stores.front()->info());
    scene.camera = plannedCamera(asDrawn(scene), stores, ram, options.threads, kPictureBytesPerPixel);
    RenderResult result;
    Image picture;
    Charge charge;
    for (std::size_t n = 0; n < stores.size(); ++n) {
        RenderOptions alone = options;
        if (n > 0) { // a first picture and an error are told of one volume
            alone.onFirstPicture = {};
            alone.verify = Verify::none;
        }
        RenderResult mine = renderScene(sceneInFusion(scene, n), *stores[n], ram, gpu, alone);
        const double opacity = scene.volumes[n].opacity;
        if (n == 0) {
            result = std::move(mine);
            picture = Image(result.image.size);
            charge = ram.charge(picture.pixels.size() * sizeof(glm::vec4), "the picture of all volumes");
            for (std::size_t i = 0; i < picture.pixels.size(); ++i)
                picture.pixels[i] = static_cast<float>(opacity) * result.image.pixels[i];
            result.image = {};
            continue;
        }
        layOver(picture, mine.image, opacity, scene.fusion);
        result.work += mine.work;
        result.secondsPreparing += mine.secondsPreparing;
        result.secondsLoading += mine.secondsLoading;
        result.secondsDrawing += mine.secondsDrawing;
    }
    result.image = std::move(picture);
    return result;
}

} // namespace tessera
