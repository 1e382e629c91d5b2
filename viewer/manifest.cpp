// viewer/manifest.cpp: see manifest.h.
#include "viewer/manifest.h"

#include <nlohmann/json.hpp>

namespace tessera {
namespace {
nlohmann::json budgetJson(const Ledger& ledger) {
    return {{"limitBytes", ledger.limitBytes()}, {"peakBytes", ledger.peakBytes()}};
}
} // namespace

nlohmann::json makeManifest(const Scene& scene, const StoreReader& store, const RenderResult& result,
                            Engine engine, const Ledger& ram, const Ledger& gpu) {
    const std::string hash = store.contentHash();
    Scene shown = scene;
    shown.camera = result.camera;
    for (SceneVolume& volume : shown.volumes)
        volume.path = "content-" + hash + ".zarr";
    const VolumeInfo& info = store.info();
    const Work& work = result.work;
    nlohmann::json manifest = {
        {"tesseraManifest", 1},
        {"notice", "not for diagnosis"},
        {"program", "tessera " TESSERA_VERSION},
        {"scene", nlohmann::json::parse(sceneJson(shown))},
        {"store",
         {{"contentHash", hash},
          {"extentVoxels", {info.extentVoxels.x, info.extentVoxels.y, info.extentVoxels.z}},
          {"type", name(info.type)},
          {"unit", info.unit},
          {"lowest", result.lowest},
          {"highest", result.highest}}},
        {"engine", name(engine)},
        {"device", result.device},
        {"openGl", result.glVersion},
        {"budgets", {{"ram", budgetJson(ram)}, {"gpuMemory", budgetJson(gpu)}}},
        {"resident",
         {{"level", result.level},
          {"bricksOfLevel", result.bricksOfLevel}, // 0 finest; the last: empty
          {"pages", result.selectionPages},
          {"pagesAtOnce", result.atlasPages},
          {"passes", result.passes},
          {"bricks", result.residentBricks},
          {"emptyBricks", result.emptyBricks},
          {"cells", result.cells},
          {"occupiedCells", result.occupiedCells}}},
        {"transferTableRelativeError", result.tableRelativeError},
        {"work",
         {{"iterations", work.iterations},
          {"segments", work.segments},
          {"samples", work.samples},
          {"fetches", work.fetches},
          {"dispatches", work.dispatches},
          {"bricksUploaded", work.bricksUploaded},
          {"blended", work.blended},
          {"bytesUploaded", work.bytesUploaded}}}};
    if (result.predictedError)
        manifest["predictedLevelError"] = {{"unit", "CIE 1976 L*u*v*"},
                                           {"mean", result.predictedError->mean},
                                           {"percentile99", result.predictedError->p99}};
    return manifest;
}

} // namespace tessera
