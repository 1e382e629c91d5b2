// viewer/studies/accuracy/device_scene.cpp: see device_scene.h.
#include "viewer/studies/accuracy/device_scene.h"

#include "core/error.h"
#include "render/engines/gpu/visibility_pass.h"

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
                         const GlContext& context, Ledger& ram, std::size_t gpuBytes)
    : limits_{context.max3dTextureSize(), context.maxTextureBytes()},
      ram_(ram.name(), ram.option(), ram.freeBytes()), gpu_("GPU memory", "--gpu-memory", gpuBytes) {
    Scene asked = scene;
    asked.quality.maxError = detail.maxError;
    asked.quality.edgeFunction = detail.edgeFunction;
    PreparedScene& p = prepared_;
    const bool finest = detail.finest && detail.memoryShare == 1 && !detail.maxError;
    p = prepareScene(asked, store, limits_, ram_, gpu_, 0,
                     finest ? LevelChoice::oneForAll : LevelChoice::perBrick);
    if (finest && p.selection.finest() != 0) // not all fit
        chooseAgain(p, asked, limits_, ram_, gpu_, 0, LevelChoice::perBrick);
    fixedBytes_ = p.reserveGpu(limits_, ram_, gpu_);
    if (p.chosen.atlasPages < pagesFor(p.selection.counts))
        throw InputError(gpu_.option() + ": " + formatBytes(gpuBytes) +
                         " cannot hold at once all bricks that these levels take");
    atlas_ = std::make_unique<Atlas>(p.info(), p.selection, std::max(p.chosen.atlasPages, std::size_t{1}),
                                     limits_, gpu_, ram_);
    atlas_->bricks.load(*p.cache, uploads_);
    if (p.chosen.chooser) { // as the renderer does: what is seen decides, once
        VisibilityPass pass(marchFeatures(p, false), p.info(), gpu_);
        Work counting; // not the picture's
        p.chooseBySight(pass.count(visibilityRays(p.camera, p.info(), scene.imageSize, p.strides()),
                                   SceneField(p, *atlas_, gpu_).source, p.optics, counting),
                        ram_);
        atlas_->bricks.adopt(p.selection);
        atlas_->bricks.load(*p.cache, uploads_);
    }
    field_.emplace(p, *atlas_, gpu_);
    bytesDecoded_ = p.cache->counters().bytesDecoded;
    peakRam_ = ram_.peakBytes();
    p.cache.reset(); // every brick is on the device now
    kept_ = ram.charge(ram_.usedBytes(), "what stays in RAM of a scene on the device");
}

std::size_t DeviceScene::gpuBytesForShare(int share) const {
    const std::size_t pages = pagesFor(prepared_.selection.counts) / static_cast<std::size_t>(share);
    return fixedBytes_ + atlasBytes(std::max(pages, std::size_t{1}), prepared_.info().type, limits_);
}

DeviceMarch::DeviceMarch(DeviceScene& on, const Scene& scene, const Setting& setting, bool counting)
    : on_(on), scene_(withSetting(scene, setting)), setting_(setting),
      gpu_(on.gpu_.name(), on.gpu_.option(), on.gpu_.freeBytes()) {
    PreparedScene& p = on.prepared_;
    p.quality = scene_.quality;
    p.setFunction(TransferFunction(p.function), scene_, on.ram_);
    // As the renderer does where the integrator is left open.
    p.settleIntegrator(on.ram_, gpu_, p.table.entries.size());
    p.prepareSegments();
    p.frame = rayFrame(p.camera, p.info(), scene_.imageSize, setting.stepVoxels);
    integrator_ = p.optics.integrator;
    march_.emplace(marchFeatures(p, counting), p, gpu_);
    march_->refine(on.field_->source); // once; a viewer does so once for a function
}

Frame DeviceMarch::draw(double stepVoxels) {
    TESSERA_CHECK(integrator_ != Integrator::preintegrated2d || stepVoxels == setting_.stepVoxels);
    PreparedScene& p = on_.prepared_;
    scene_.quality.stepVoxels = stepVoxels;
    p.quality = scene_.quality;
    p.frame = rayFrame(p.camera, p.info(), scene_.imageSize, stepVoxels);
    Frame frame;
    March& march = march_->march();
    const auto start = Clock::now();
    march.restart(p.frame, p.strides(), nullptr);
    march.run(on_.field_->source, MarchSlicing{}, frame.work);
    frame.image = march.image();
    frame.wallMs = msSince(start);
    frame.gpuMs = frame.work.marchMs;
    return frame;
}

std::string DeviceMarch::features() const {
    std::string text;
    for (const FeatureName& f : featureNames()) {
        if (!(march_->features() & f.bit) || f.bit == kFeatureCounting)
            continue;
        std::string word = std::string(f.define).substr(std::string("FEATURE_").size());
        std::transform(word.begin(), word.end(), word.begin(),
                       [](unsigned char c) { return c == '_' ? '-' : static_cast<char>(std::tolower(c)); });
        text += (text.empty() ? "" : "+") + word;
    }
    return text;
}

} // namespace tessera::accuracy
