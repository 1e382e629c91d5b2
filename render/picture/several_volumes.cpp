// render/picture/several_volumes.cpp: see several_volumes.h.
#include "render/picture/several_volumes.h"

#include "core/base/error.h"
#include "core/base/progress.h" // secondsSince
#include "core/scene/mode.h"
#include "render/contract/ray_state.h" // rayCount
#include "render/picture/render_scene.h"
#include "render/plan/fusion.h"

#include <algorithm>
#include <chrono>
#include <glm/common.hpp>
#include <utility>
#include <variant>
#include <vector>

namespace tessera {

void placeSlice(SlicePlane& slice, const VolumeInfo& info) {
    if (slice.orientation == Orientation::oblique || slice.positionMm)
        return;
    const glm::dvec3 middle(info.patientFromVoxel * glm::dvec4(0.5 * glm::dvec3(info.extentVoxels), 1));
    slice.positionMm = middle[slice.orientation == Orientation::axial     ? 2
                              : slice.orientation == Orientation::coronal ? 1
                                                                          : 0];
}

bool takesOpacities(const Scene& scene, std::size_t number) {
    return number > 0 && reductionOf(scene) != Reduction::sum &&
           sceneOfVolume(scene, number).valueColour == ValueColour::transferFunction;
}

TransferFunction opacitiesAsGreys(const TransferFunction& function) {
    std::vector<ColourPoint> greys;
    for (const OpacityPoint& point : function.opacityPoints())
        greys.push_back({point.value, glm::dvec3(point.opacity)});
    return TransferFunction::fromOpacity(function.opacityPoints(), greys, function.referenceLengthMm());
}

std::vector<float> opacitiesOf(const Image& greys) {
    std::vector<float> opacities;
    for (const glm::vec4& pixel : greys.pixels)
        opacities.push_back(pixel.a > 0 ? pixel.r / pixel.a : 0);
    return opacities;
}

void weigh(Image& picture, double opacity, const std::vector<float>& opacities) {
    const auto share = static_cast<float>(opacity);
    for (glm::vec4& pixel : picture.pixels)
        pixel *= share;
    for (std::size_t i = 0; i < opacities.size(); ++i)
        picture.pixels[i] *= opacities[i];
}

void layOver(Image& below, const Image& above, Fusion rule) {
    TESSERA_CHECK(below.size == above.size);
    for (std::size_t i = 0; i < below.pixels.size(); ++i) {
        glm::vec4& pixel = below.pixels[i];
        const glm::vec4& upper = above.pixels[i];
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

namespace {

void addWork(const RenderResult& of, RenderResult& to) {
    to.work += of.work;
    to.secondsPreparing += of.secondsPreparing;
    to.secondsLoading += of.secondsLoading;
    to.secondsDrawing += of.secondsDrawing;
}

/// The picture of a volume alone, times its opacity. Where its values have the function's colours, and it
/// lies over others, they have the function's opacity too; labels over them do not.
Image shownAlone(const Scene& scene, std::size_t number, const StoreReader& store, MemoryBudget& ram,
                 MemoryBudget& gpu, const RenderOptions& options, RenderResult& result) {
    const Scene alone = sceneInFusion(scene, number);
    RenderOptions mine = options;
    std::vector<float> shares;
    Charge charge;
    RenderResult more;
    if (takesOpacities(scene, number)) {
        Scene opacities = alone;
        opacities.volumes[0].labels = {};
        opacities.volumes[0].transferFunction =
            opacitiesAsGreys(std::get<TransferFunction>(alone.volumes[0].transferFunction));
        charge = ram.charge(rayCount(scene.imageSize) * sizeof(float), "the opacities of a volume");
        more = renderScene(opacities, store, ram, gpu, options);
        shares = opacitiesOf(more.image);
        more.image = {};
        if (alone.mode == Mode::slice && !alone.volumes[0].labels.path.empty())
            mine.shares = &shares;
    }
    result = renderScene(alone, store, ram, gpu, mine);
    addWork(more, result);
    Image picture = std::move(result.image);
    weigh(picture, scene.volumes[number].opacity, mine.shares ? std::vector<float>() : shares);
    return picture;
}

} // namespace

RenderResult drawVolumesAlone(const Scene& given, Stores stores, MemoryBudget& ram, MemoryBudget& gpu,
                              const RenderOptions& options) {
    const auto start = std::chrono::steady_clock::now();
    Scene scene = given;
    placeSlice(scene.slice, stores.front()->info());
    scene = resolved(scene, stores, ram, options.threads, kPictureBytesPerPixel);
    const double resolving = secondsSince(start);
    RenderResult result;
    Image picture = shownAlone(scene, 0, *stores[0], ram, gpu, options, result);
    result.secondsPreparing += resolving;
    result.pixelErrors.reset(); // they would be of one volume
    const Charge charge = ram.charge(picture.pixels.size() * sizeof(glm::vec4), "the picture of all volumes");
    RenderOptions others = options; // a first picture and errors are told of one volume
    others.onFirstPicture = {};
    others.verify = Verify::none;
    others.layers = {};
    for (std::size_t n = 1; n < stores.size(); ++n) {
        RenderResult mine;
        layOver(picture, shownAlone(scene, n, *stores[n], ram, gpu, others, mine), scene.fusion);
        addWork(mine, result);
        if (!mine.labels)
            continue;
        if (!result.labels)
            result.labels = RenderResult::Labels{};
        result.labels->all += mine.labels->all;
        result.labels->shown += mine.labels->shown;
        result.labels->level = std::max(result.labels->level, mine.labels->level);
        result.labels->onSlice.resize(n);
        result.labels->onSlice.insert(result.labels->onSlice.end(), mine.labels->onSlice.begin(),
                                      mine.labels->onSlice.end());
    }
    result.image = std::move(picture);
    return result;
}

} // namespace tessera
