// viewer/cli/render/body_crop.cpp: see body_crop.h.
#include "viewer/cli/render/body_crop.h"

#include "bricking/analysis/body/body_box.h"
#include "bricking/statistics/statistics.h"
#include "core/base/error.h"
#include "core/scene/preset.h"
#include "render/plan/frame_plan.h" // summarise

#include <string>

namespace tessera {
namespace {

bool inHu(const StoreReader& store, const std::string& unit, MemoryBudget& ram) {
    if (store.info().unit == "HU" || unit == "HU")
        return true;
    return looksLikeHu(summarise(loadStatistics(store, ram, 0), store.info(), unit));
}

std::string along(const char* axis, double low, double high) {
    return std::string(axis) + " " + formatNumber(low) + " to " + formatNumber(high);
}

} // namespace

void cropToBody(const RenderArguments& arguments, const StoreReader& store, Scene& scene, MemoryBudget& ram,
                const CommonOptions& common) {
    if (!inHu(store, scene.volumes.front().unit, ram))
        throw badFile("--crop body", "values in HU, by which a body is found",
                      "values without a unit that do not look like HU; --unit HU takes them for HU");
    const BodyBox body = findBody(store, ram);
    const Keep keep = arguments.mode.keep == "outside" ? Keep::outside : Keep::inside;
    scene.cuts.boxes.push_back({body.low, body.high, CropBox::Space::patient, keep});
    if (scene.cuts.boxes.size() > Cuts::kMostOfAKind)
        throw badFile("--crop", "at most " + std::to_string(Cuts::kMostOfAKind) + " of a kind", "more");
    if (auto* fitted = std::get_if<FittedView>(&scene.camera); fitted && arguments.fit.empty())
        fitted->fit = fitted->fit == Fit::shown ? Fit::kept : fitted->fit;
    common.note("--crop body: " + along("x", body.low.x, body.high.x) + ", " +
                along("y", body.low.y, body.high.y) + ", " + along("z", body.low.z, body.high.z) +
                " mm: a body of " + formatNumber(body.litres, 3) + " l; " +
                formatNumber(body.litresLeftOut, 3) + " l of table and the like left out");
}

} // namespace tessera
