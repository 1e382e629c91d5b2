// tests/bench/accuracy/device_scene.cpp: see device_scene.h.
#include "tests/bench/accuracy/device_scene.h"

#include "core/base/error.h"
#include "render/backends/engine_maker.h"
#include "render/backends/gpu/features.h"
#include "render/picture/picture.h"
#include "render/plan/planner.h"

#include <algorithm>
#include <cctype>
#include <chrono>

namespace tessera::accuracy {
namespace {

using Clock = std::chrono::steady_clock;
double msSince(Clock::time_point start) {
    return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

} // namespace

DeviceScene::DeviceScene(const Scene& scene, const Detail& detail, const StoreReader& store,
                         const EngineMaker& engines, MemoryBudget& ram, std::size_t gpuBytes)
    : ram_(ram.name(), ram.option(), ram.freeBytes()), gpu_("GPU memory", "--gpu-memory", gpuBytes),
      engine_(engines.make(ram_, gpu_)), limits_(engine_->limits()) {
    Scene asked = scene;
    asked.quality.maxError = detail.maxError;
    asked.quality.edgeFunction = detail.edgeFunction;
    Planner& p = prepared_;
    const bool finest = detail.finest && detail.memoryShare == 1 && !detail.maxError;
    p = planScene(asked, store, limits_, {ram_, gpu_, 0},
                  finest ? LevelChoice::oneForAll : LevelChoice::perBrick);
    if (finest && p.layer().selection.finest() != 0) // not all fit
        p.chooseAgain(asked, limits_, {ram_, gpu_, 0}, LevelChoice::perBrick);
    p.planMemory(limits_, {ram_, gpu_, 0});
    fixedBytes_ = p.memory.gpuBytes();
    p.chosen.atlasPages = std::max(p.chosen.atlasPages, std::size_t{1});
    if (p.chosen.atlasPages < pagesFor(p.layer().selection.counts) || loadBricks(*engine_, p, gpu_, uploads_))
        throw InputError(gpu_.option() + ": " + formatBytes(gpuBytes) +
                         " cannot hold at once all bricks that these levels take");
    bytesDecoded_ = p.layer().cache->counters().bytesDecoded;
    peakRam_ = ram_.peakBytes();
    p.layer().cache.reset(); // every brick is on the device now
    kept_ = ram.charge(ram_.usedBytes(), "what stays in RAM of a scene on the device");
}

std::size_t DeviceScene::gpuBytesForShare(int share) const {
    const std::size_t pages = pagesFor(prepared_.layer().selection.counts) / static_cast<std::size_t>(share);
    TextureLimits plain = limits_;
    plain.pageEdge = kBrickExtent; // with less memory bricks have no ghost layers
    return fixedBytes_ + atlasBytes(std::max(pages, std::size_t{1}), prepared_.info().type, plain);
}

DeviceMarch::DeviceMarch(DeviceScene& on, const Scene& scene, const Setting& setting, bool counting)
    : on_(on), scene_(withSetting(scene, setting)), setting_(setting),
      gpu_(on.gpu_.name(), on.gpu_.option(), on.gpu_.freeBytes()) {
    Planner& p = on.prepared_;
    p.view.quality = scene_.quality;
    p.setFunction(TransferFunction(p.layer().function), scene_);
    // As the renderer does where the integrator is left open.
    p.settleIntegrator({on.ram_, gpu_, 0}, p.layer().table.entries.size());
    p.setStep(p.view.quality.stepVoxels);
    p.view.quality.stepVoxels = setting.stepVoxels;
    p.aim();
    integrator_ = p.layer().optics.integrator;
    caster_ = on.engine_->caster({counting, false, false}, gpu_);
    caster_->refine(); // once; a viewer does so once for a function
}

Frame DeviceMarch::draw(double stepVoxels) {
    TESSERA_CHECK(integrator_ != Integrator::preintegrated2d || stepVoxels == setting_.stepVoxels);
    Planner& p = on_.prepared_;
    scene_.quality.stepVoxels = stepVoxels;
    p.view.quality = scene_.quality;
    p.aim();
    Frame frame;
    const auto start = Clock::now();
    caster_->begin(raysOf(p));
    drawToTheEnd(*caster_, *on_.engine_, p, Slicing{}, frame.work);
    frame.image = caster_->image();
    frame.wallMs = msSince(start);
    frame.gpuMs = frame.work.marchMs;
    return frame;
}

std::string DeviceMarch::features() const {
    std::string text;
    for (const FeatureName& f : featureNames()) {
        if (!(caster_->features() & f.bit) || f.bit == kFeatureCounting)
            continue;
        std::string word = std::string(f.define).substr(std::string("FEATURE_").size());
        std::transform(word.begin(), word.end(), word.begin(),
                       [](unsigned char c) { return c == '_' ? '-' : static_cast<char>(std::tolower(c)); });
        text += (text.empty() ? "" : "+") + word;
    }
    return text;
}

} // namespace tessera::accuracy
