// viewer/cli/manifest/manifest.cpp: see manifest.h.
#include "viewer/cli/manifest/manifest.h"

#include "bricking/store/stand_in_reader.h"
#include "core/base/error.h"
#include "core/base/fnv_hash.h"
#include "render/geometry/shape.h"
#include "render/transport/environment_map.h"
#include "viewer/cli/manifest/build_commit.h"
#include "viewer/cli/manifest/picture_data.h"

#include <bit>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <utility>

namespace tessera {
namespace {
nlohmann::json budgetJson(const MemoryBudget& budget) {
    return {{"limitBytes", budget.limitBytes()}, {"peakBytes", budget.peakBytes()}};
}
} // namespace

namespace {
nlohmann::json errorJson(const EstimatedError& e) {
    return {{"rms", e.rms}, {"largest", e.largest}, {"luvMean", e.luvMean}, {"luvPercentile99", e.luvP99}};
}

/// One number per cause; docs/guide/errors.md explains them. The samples of pixels, and their standard error.
nlohmann::json pixelsJson(const RenderResult& result, const Scene& scene) {
    const PixelReport& r = result.pixels;
    const bool decide = r.asked == PixelSampling::kAutomatic;
    nlohmann::json pixels = {{"samples", decide ? nlohmann::json("auto") : nlohmann::json(r.asked)},
                             {"samplesTaken", r.taken},
                             {"samplesTakenAtMost", r.most}};
    if (r.asked == 1)
        return pixels;
    if (r.ofEarlierRuns > 0)
        pixels["samplesOfEarlierRuns"] = r.ofEarlierRuns;
    pixels["filter"] = pixelFilterNames()[static_cast<std::size_t>(scene.quality.pixels.filter)];
    pixels["seed"] = scene.quality.pixels.seed;
    if (r.error)
        pixels["standardError"] = {
            {"rms", r.error->rms}, {"luvMean", r.error->luvMean}, {"luvPercentile99", r.error->luvP99}};
    return pixels;
}

nlohmann::json measuredJson(const MeasuredErrors& e) {
    const auto estimate = [](const Estimate& x) {
        return nlohmann::json{{"value", x.value}, {"from", x.low}, {"to", x.high}};
    };
    nlohmann::json out = nlohmann::json::object();
    if (e.rms)
        out["rms"] = estimate(*e.rms);
    if (e.luvMean)
        out["luvMean"] = estimate(*e.luvMean);
    if (e.luvP99)
        out["luvPercentile99"] = estimate(*e.luvP99);
    return out;
}

/// The error against the mean of the finest level's integral over each pixel's area. "from" and "to" are a
/// 95% confidence interval over choices of pixels.
nlohmann::json measurementJson(const PictureMeasurement& m) {
    nlohmann::json out = m.whyNot.empty() ? measuredJson(m.all) : nlohmann::json::object();
    out["mode"] = verifyNames()[static_cast<std::size_t>(m.mode)];
    if (m.light) // beside the others, which do not count it
        out["light"] = measuredJson(*m.light);
    else if (m.keptLight)
        out["notCounted"] = {"light"};
    if (m.keptRays)
        out["notCounted"] = {"levelsStepFiltering"};
    if (!m.whyNot.empty()) {
        out["notMeasured"] = m.whyNot;
        return out;
    }
    out["pixels"] = m.all.pixels;
    out["pixelsThatShow"] = m.all.shown;
    out["samplesOfPixel"] = m.samples;
    out["samplesOfPixelAtMost"] = m.mostSamples;
    out["bytesRead"] = m.bytesRead;
    if (m.all.luvP99Bound)
        out["luvPercentile99AtMost"] = *m.all.luvP99Bound;
    out["samplesOfPixels"] = measuredJson(m.sampling);
    if (!m.keptRays)
        out["levelsStepFiltering"] = measuredJson(m.rays);
    return out;
}

nlohmann::json segmentsJson(const RenderResult& r) {
    const std::string& integrator = integratorNames()[static_cast<std::size_t>(r.integrator)];
    if (r.hulls.count > 0)
        return {{"hulls", r.hulls.count}, {"samplesOfHull", r.hulls.samples}, {"integrator", integrator}};
    return {{"stepVoxels", r.stepVoxels},
            {"stepVoxelsOfMeans", r.stepOfMeans.value_or(r.stepVoxels)},
            {"integrator", integrator}};
}

nlohmann::json errorsJson(const RenderResult& result, const Scene& scene) {
    const double share = scene.quality.terminationTransmittance;
    nlohmann::json errors = {{"termination", {{"lightLeftOutAtMost", share}}},
                             {"table", {{"ofLargestExtinction", result.tableRelativeError}}}};
    if (result.predictedError)
        errors["levels"] = {{"luvMean", result.predictedError->mean},
                            {"luvPercentile99", result.predictedError->p99}};
    if (result.measured)
        errors["measured"] = measurementJson(*result.measured);
    if (result.rounds > 1)
        errors["picturesUntilWithinMaxError"] = result.rounds;
    if (!result.shortfall.empty())
        errors["maxErrorNotReached"] = result.shortfall;
    if (!result.errors)
        return errors;
    errors["pixelsDrawnAgain"] = result.errors->pixels;
    errors["termination"]["largest"] = result.errors->terminationBound;
    if (result.errors->step) {
        errors["step"] = errorJson(result.errors->step->error);
        errors["step"]["order"] = result.errors->step->order;
    }
    if (result.errors->filtering)
        errors["filtering"] = errorJson(*result.errors->filtering);
    errors["luvPercentile99"] = result.errors->luvP99();
    return errors;
}
} // namespace

namespace {
/// What a file's light is, in digits.
std::string contentOf(const EnvironmentMap& map) {
    FnvHash hash;
    const glm::ivec2 size = map.table().size();
    for (std::size_t n = 0; n < static_cast<std::size_t>(size.x * size.y); ++n)
        for (int c = 0; c < 3; ++c)
            hash.add(std::bit_cast<std::uint32_t>(map.radianceAt(n)[c]));
    return hash.digits();
}
} // namespace

Scene withoutPaths(Scene scene, Stores stores) {
    TESSERA_CHECK(scene.volumes.size() == stores.size());
    for (std::size_t n = 0; n < stores.size(); ++n) {
        scene.volumes[n].path = "content-" + stores[n]->contentHash() + ".zarr";
        scene.volumes[n].source = {};
        Labels& labels = scene.volumes[n].labels;
        if (!labels.path.empty())
            labels.path = "labels-" + std::to_string(n) + labels.path.extension().string();
        if (!labels.names.empty() && labels.names != Labels::kTotalSegmentator)
            labels.names = "names-" + std::to_string(n) + labels.names.extension().string();
    }
    for (std::size_t n = 0; n < scene.meshes.size(); ++n) // names of files may be those of patients
        if (std::filesystem::path& path = scene.meshes[n].path; !path.empty())
            path = "mesh-" + std::to_string(n) + path.extension().string();
    if (auto& sky = scene.lighting.environment; sky && !sky->file.path.empty())
        sky->file.path = "environment-" + (sky->file.map ? contentOf(*sky->file.map) : "unread") +
                         sky->file.path.extension().string();
    return scene;
}

nlohmann::json sourcesJson(std::span<const SourceChoice> sources) {
    nlohmann::json all = nlohmann::json::array();
    bool chosen = false;
    for (const SourceChoice& source : sources) {
        Scene alone;
        alone.volumes.push_back(
            {.path = "source", .transferFunction = std::string("auto"), .source = source});
        const nlohmann::json volume = nlohmann::json::parse(sceneJson(alone)).at("volumes").at(0);
        nlohmann::json& one = all.emplace_back(nlohmann::json::object());
        for (const char* key :
             {"series", "phase", "largest", "resampleZ", "allowMissing", "spacing", "fileLevel", "fileBox"})
            if (volume.contains(key))
                one[key] = volume[key];
        chosen = chosen || !one.empty();
    }
    return chosen ? all : nlohmann::json::array();
}

nlohmann::json filePartJson(const FilePart& part) {
    const auto& [level, finest, extent, box] = part;
    return {{"fileLevel", level},
            {"finestVoxels", {finest.x, finest.y, finest.z}},
            {"levelVoxels", {extent.x, extent.y, extent.z}},
            {"fileBox", {box.low.x, box.high.x, box.low.y, box.high.y, box.low.z, box.high.z}},
            {"errorsAgainst", "this level of the file"}};
}

namespace {
nlohmann::json furtherJson(const RenderResult& result, Stores stores) {
    nlohmann::json further = nlohmann::json::array();
    for (std::size_t n = 1; n < stores.size(); ++n) {
        const VolumeInfo& info = stores[n]->info();
        nlohmann::json volume = {
            {"contentHash", stores[n]->contentHash()},
            {"extentVoxels", {info.extentVoxels.x, info.extentVoxels.y, info.extentVoxels.z}},
            {"type", name(info.type)},
            {"unit", info.unit}};
        if (info.filePart)
            volume["filePart"] = filePartJson(*info.filePart);
        if (n <= result.further.size()) {
            const RenderResult::Further& drawn = result.further[n - 1];
            volume["level"] = drawn.level;
            volume["bricksOfLevel"] = drawn.bricksOfLevel;
            volume["shares"] = {
                {"ram", {{"limitBytes", drawn.ramBytes}, {"peakBytes", drawn.ramPeakBytes}}},
                {"gpuMemory", {{"limitBytes", drawn.gpuBytes}, {"peakBytes", drawn.gpuPeakBytes}}}};
        }
        further.push_back(std::move(volume));
    }
    return further;
}
} // namespace

nlohmann::json makeManifest(const Scene& scene, Stores stores, const RenderResult& result,
                            const MemoryBudget& ram, const MemoryBudget& gpu) {
    const StoreReader& store = *stores.front();
    const std::string hash = store.contentHash();
    Scene shown = withoutPaths(scene, stores);
    shown.camera = result.camera;
    const VolumeInfo& info = store.info();
    const Work& work = result.work;
    nlohmann::json manifest = {
        {"tesseraManifest", 1},
        {"notice", "not for diagnosis"},
        {"program", "tessera " TESSERA_VERSION},
        {"commit", buildCommit()},
        {"scene", nlohmann::json::parse(sceneJson(shown))},
        {"data", dataJson(dataOf(scene, stores))},
        {"store",
         {{"contentHash", hash},
          {"extentVoxels", {info.extentVoxels.x, info.extentVoxels.y, info.extentVoxels.z}},
          {"type", name(info.type)},
          {"unit", info.unit},
          {"lowest", result.lowest},
          {"highest", result.highest}}},
        {"engine", name(result.engine)},
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
          {"unseenBricks", result.unseenBricks},
          {"cells", result.cells},
          {"occupiedCells", result.occupiedCells}}},
        {"segments", segmentsJson(result)},
        {"mode", modeNames()[static_cast<std::size_t>(scene.mode)]},
        {"pixels", pixelsJson(result, scene)},
        {"errors", errorsJson(result, scene)},
        {"work",
         {{"iterations", work.iterations},
          {"segments", work.segments},
          {"samples", work.samples},
          {"fetches", work.fetches},
          {"dispatches", work.dispatches},
          {"bricksUploaded", work.bricksUploaded},
          {"blended", work.blended},
          {"bytesUploaded", work.bytesUploaded}}}};
    if (info.filePart)
        manifest["store"]["filePart"] = filePartJson(*info.filePart);
    if (const PathWork& paths = work.paths; paths.paths > 0)
        manifest["paths"] = {{"paths", paths.paths},         {"scatterings", paths.bounces},
                             {"extinctions", paths.lookUps}, {"nullCollisions", paths.nullCollisions},
                             {"boxes", paths.cells},         {"aboveBounds", paths.exceeded},
                             {"oneByOne", paths.alone}};
    if (const auto fetched = fetchedFor(stores))
        manifest["fetched"] = {{"requests", fetched->requests},
                               {"retries", fetched->retries},
                               {"bytes", fetched->bytesFetched},
                               {"bytesFromDisk", fetched->bytesFromDisk}};
    if (nlohmann::json damage = damageJson(stores); !damage.is_null())
        manifest["damagedChunks"] = std::move(damage);
    if (stores.size() > 1)
        manifest["furtherVolumes"] = furtherJson(result, stores);
    if (result.labels)
        manifest["labels"] = {{"labels", result.labels->all}, {"drawn", result.labels->shown}};
    if (result.labels && !result.labels->onSlice.empty()) {
        manifest["labels"]["onSlice"] = result.labels->countOnSlice();
        manifest["labels"]["level"] = result.labels->level;
    }
    for (const SceneMesh& mesh : scene.meshes)
        if (mesh.shape)
            manifest["meshes"].push_back({{"parts", mesh.shape->parts()}, {"bytes", mesh.shape->bytes()}});
    for (const FillValue& fill : result.leftOut)
        manifest["leftOut"].push_back({{"value", fill.value}, {"share", fill.share}});
    if (result.patientTable && result.patientTable->why.empty())
        manifest["patientTable"] = {{"hiddenLitres", result.patientTable->litres}};
    else if (result.patientTable)
        manifest["patientTable"] = {{"shownBecause", result.patientTable->why}};
    if (reductionOf(scene) != Reduction::composite) {
        if (scene.mode != Mode::absorption)
            manifest["window"] = {{"centre", result.window.centre}, {"width", result.window.width}};
        manifest["errors"]["levels"] = "not predicted";
    }
    return manifest;
}

nlohmann::json recordOfPixels(const Scene& scene, Stores stores, const EngineMaker& engine) {
    nlohmann::json record = {{"program", "tessera " TESSERA_VERSION},
                             {"volume", stores.front()->contentHash()},
                             {"size", {scene.imageSize.x, scene.imageSize.y}},
                             {"scene", nlohmann::json::parse(sceneJson(withoutPaths(scene, stores)))},
                             {"engine", name(engine.kind())}};
    std::vector<PictureData> data = dataOf(scene, stores);
    std::erase_if(data, [](const PictureData& one) { return one.kind == PictureData::Kind::volume; });
    if (!data.empty())
        record["data"] = dataJson(data);
    if (traitsOf(engine.kind()).onContext) // the others draw the same bits everywhere
        record["device"] = engine.about();
    return record;
}

nlohmann::json damageJson(Stores stores) {
    std::uint64_t count = 0;
    nlohmann::json chunks = nlohmann::json::array();
    for (std::size_t n = 0; n < stores.size(); ++n) {
        const auto* const store = dynamic_cast<const StandInReader*>(stores[n]);
        if (!store)
            continue;
        count += store->damagedCount();
        for (const DamagedChunk& chunk : store->damaged()) {
            const ChunkKey& key = chunk.key;
            chunks.push_back({{"volume", n + 1},
                              {"level", key.level},
                              {"chunk", {key.i, key.j, key.k}},
                              {"drawnFromLevel", chunk.drawnFrom}});
        }
    }
    return count == 0 ? nlohmann::json() : nlohmann::json{{"count", count}, {"chunks", chunks}};
}

nlohmann::json scaleBarJson(const ScaleBar& bar) {
    return {{"mm", bar.mm}, {"pixels", bar.pixels}, {"at", bar.everywhere ? "everywhere" : "centre"}};
}

nlohmann::json legendJson(std::span<const LegendBar> bars) {
    nlohmann::json all = nlohmann::json::array();
    for (const LegendBar& bar : bars)
        all.push_back({{"unit", bar.unit}, {"low", bar.low}, {"high", bar.high}});
    return all;
}

std::string manifestText(const nlohmann::json& report) {
    return report.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
}

} // namespace tessera
