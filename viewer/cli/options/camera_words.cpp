// viewer/cli/options/camera_words.cpp: see camera_words.h.
#include "viewer/cli/options/camera_words.h"

#include "core/base/decimal.h"
#include "core/base/error.h"
#include "core/base/names.h"
#include "viewer/session/view_geometry.h"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <variant>

namespace tessera {
namespace {

void requireSideOfSlice(const Scene& scene, const std::string& where) {
    const auto* const fitted = std::get_if<FittedView>(&scene.camera);
    if (scene.mode == Mode::slice && fitted && !fitted->named)
        throw badFile(where,
                      "--view with it: a slice is seen along its normal, in parallel, and fills the picture",
                      "none");
}

} // namespace

void parseSide(const std::string& text, FittedView& view, const std::string& where) {
    view.angles.reset();
    if (text.find_first_of("0123456789") == std::string::npos) {
        view.view = parseName<View>(text, where);
        return;
    }
    const std::size_t comma = std::min(text.find(','), text.size());
    const std::optional<double> turn = decimalNumber(text.substr(0, comma));
    const std::optional<double> rise = decimalNumber(text.substr(std::min(comma + 1, text.size())));
    if (!turn || !rise)
        throw badFile(where,
                      joinNames(viewNames()) + ", or TURN,RISE: degrees about the patient's axis and up",
                      "\"" + text.substr(0, 40) + "\"");
    view.angles = checkedAngles(*turn, *rise, where);
}

void setFit(Scene& scene, const std::string& text, const std::string& where) {
    requireSideOfSlice(scene, where);
    auto* const fitted = std::get_if<FittedView>(&scene.camera);
    if (!fitted)
        throw badFile(where, "a camera by side (--view), which is fitted", "one with a position");
    fitted->fit = parseName<Fit>(text, where);
}

void setProjection(Scene& scene, const std::string& text, const std::string& where) {
    requireSideOfSlice(scene, where);
    const auto projection = parseName<Projection>(text, where);
    if (auto* const fitted = std::get_if<FittedView>(&scene.camera))
        fitted->projection = projection;
    else
        scene.camera = projectedBy(std::get<Camera>(scene.camera), projection);
}

void setScale(Scene& scene, double mmPerPixel, bool becomesParallel, const std::string& where) {
    auto* const fitted = std::get_if<FittedView>(&scene.camera);
    if (fitted && becomesParallel)
        fitted->projection = Projection::parallel;
    const auto projection = std::visit([](const auto& camera) { return camera.projection; }, scene.camera);
    if (projection != Projection::parallel)
        throw badFile(where, "--projection parallel, in which a pixel has one size at every depth",
                      "perspective");
    if (fitted)
        fitted->mmPerPixel = mmPerPixel;
    else
        std::get<Camera>(scene.camera).parallelScale = parallelScaleOf(mmPerPixel, scene.imageSize);
}

} // namespace tessera
