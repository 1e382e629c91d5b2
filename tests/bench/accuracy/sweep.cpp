// tests/bench/accuracy/sweep.cpp: see sweep.h.
#include "tests/bench/accuracy/sweep.h"

#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/progress.h"
#include "core/base/threads.h"
#include "render/backends/engine_maker.h"
#include "render/backends/reference/reference.h"
#include "render/picture/render_scene.h"
#include "tests/bench/accuracy/device_scene.h"
#include "tests/bench/report/page.h" // loadAverage
#include "tests/bench/report/work_precision.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <numeric>
#include <random>

namespace tessera::accuracy {
namespace {

using Clock = std::chrono::steady_clock;
constexpr const char* kOutOfTime = "left out: the time for pictures was over";
constexpr int kWarmUps = 2;
constexpr double kLongFrameMs = 1000; // warm after one
constexpr double kMovedShare = 0.02;

/// The fixed work whose time tells whether the machine is as it was: least of some repeats, on all
/// processors.
double calibrationMs() {
    double least = std::numeric_limits<double>::infinity();
    for (int repeat = 0; repeat < 8; ++repeat) {
        const auto start = Clock::now();
        const auto threads = static_cast<std::size_t>(defaultThreads());
        std::vector<double> sums(threads);
        parallelFor(threads, 0, [&](std::size_t thread) {
            double x = 0.5;
            for (int i = 0; i < 400000; ++i)
                x = 3.7 * x * (1 - x);
            sums[thread] = x;
        });
        // Always true: the logistic map stays below 1; without a reader the loop would be removed.
        if (std::accumulate(sums.begin(), sums.end(), 0.0) < static_cast<double>(threads) + 1)
            least = std::min(least, 1e3 * secondsSince(start));
    }
    return least;
}

/// The scene's picture at most so large, its shape kept.
glm::ivec2 fittedSize(const glm::ivec2& size, int most) {
    const int longest = std::max(size.x, size.y);
    if (longest <= most)
        return size;
    return glm::max(glm::ivec2(1), size * most / longest);
}
/// 0 <= whole - ended <= bound in every component, but for rounding of float.
bool withinBound(const Image& ended, const Image& whole, double bound) {
    constexpr double kRounding = 1e-5; // of sums of some thousand segments in float
    for (std::size_t i = 0; i < whole.pixels.size(); ++i)
        for (int c = 0; c < 4; ++c) {
            const double left = double{whole.pixels[i][c]} - double{ended.pixels[i][c]};
            if (!(left >= -kRounding && left <= bound + kRounding))
                return false;
        }
    return true;
}

/// A sweep in progress: the data on the device, and the GPU ray casters over it.
class Runner {
  public:
    Runner(const NamedScene& scene, const SweepOptions& options, const CommonOptions& common)
        : options_(options), common_(common), engines_(options.engine, {options.device}),
          ram_("RAM", "--ram", options.ramBytes),
          gpuBytes_(scene.gpuBytes > 0 ? scene.gpuBytes : options.gpuBytes),
          store_(scene.scene.volumes.at(0).path, ram_) {
        out_.scene = scene;
        out_.scene.scene.imageSize = fittedSize(scene.scene.imageSize, options.effort.pictureExtent());
        out_.imageSize = out_.scene.scene.imageSize;
        const int longest = std::max(out_.imageSize.x, out_.imageSize.y);
        out_.pixelStride = (longest + options.effort.comparedExtent() - 1) / options.effort.comparedExtent();
        out_.device = engines_.about();
        out_.volume = formatExtent(store_.info().extentVoxels) + ", " + tessera::name(store_.info().type);
    }

    Sweep run() {
        out_.loadBefore = bench::loadAverage();
        const std::vector<Planned> planned =
            options_.settings.empty()
                ? plannedSettings(out_.scene.scene, options_.effort.quick, options_.integrators)
                : options_.settings;
        details_.push_back({Detail{}, false, makeScene(out_.scene.scene, Detail{}, gpuBytes_)});
        findTruth();
        const auto start = Clock::now();
        common_.progress->stage(out_.scene.name + ": drawing every setting");
        for (std::size_t n = 0; n < planned.size(); ++n) {
            checkInterrupted();
            if (secondsSince(start) <= options_.effort.secondsForPictures())
                prepare(planned[n]);
            else
                fail(planned[n].setting, kOutOfTime);
            common_.progress->update(static_cast<double>(n + 1) / static_cast<double>(planned.size()));
        }
        common_.progress->stage(out_.scene.name + ": taking times");
        for (int block = 0; block < options_.effort.blocks(); ++block)
            timeBlock(block);
        out_.loadAfter = bench::loadAverage();
        if (const std::string fault = engines_.fault(); !fault.empty())
            throw Error(fault);
        return std::move(out_);
    }

  private:
    struct OnDevice {
        Detail detail;
        bool preintegration2d;              // leaves room for the tables of preintegrated2d
        std::unique_ptr<DeviceScene> scene; // null: refused
    };
    struct Drawer {
        Setting setting; // its step aside where that varies
        std::unique_ptr<DeviceMarch> march;
    };

    std::unique_ptr<DeviceScene> makeScene(const Scene& scene, const Detail& detail, std::size_t gpuBytes) {
        return std::make_unique<DeviceScene>(scene, detail, store_, engines_, ram_, gpuBytes);
    }

    /// No path of this machine gets into a report.
    void fail(const Setting& setting, std::string what) {
        const std::string path = out_.scene.scene.volumes.front().path.string();
        for (std::size_t at = what.find(path); !path.empty() && at != std::string::npos; at = what.find(path))
            what.replace(at, path.size(), "the store");
        out_.failures.push_back({out_.scene.name, settingName(setting), what});
    }

    /// Null, and a failure, where the scene cannot be drawn like that.
    DeviceScene* sceneOf(const Setting& setting) {
        // Large tables leave less room for bricks, where the bricks take all there is.
        constexpr std::size_t kAmple = std::size_t{64} << 20;
        const bool preintegration2d = setting.integrator == Integrator::preintegrated2d &&
                                      details_.front().scene->gpuFreeBytes() < kAmple;
        for (const OnDevice& known : details_)
            if (known.detail == setting.detail && known.preintegration2d == preintegration2d)
                return known.scene.get();
        OnDevice made{setting.detail, preintegration2d, nullptr};
        try {
            Scene scene = out_.scene.scene;
            if (preintegration2d)
                scene.quality.integrator = setting.integrator;
            const int share = setting.detail.memoryShare;
            made.scene = makeScene(scene, setting.detail,
                                   share == 1 ? gpuBytes_ : details_.front().scene->gpuBytesForShare(share));
        } catch (const InputError& refused) {
            fail(setting, refused.what());
        }
        details_.push_back(std::move(made));
        return details_.back().scene.get();
    }

    void findTruth() {
        const DeviceScene& base = *details_.front().scene;
        const FramePlan& p = base.prepared();
        out_.tableError = p.layer().table.relativeError;
        const std::size_t pixels =
            static_cast<std::size_t>(out_.imageSize.x) * static_cast<std::size_t>(out_.imageSize.y);
        const Charge rays = ram_.charge(pixels * sizeof(ReferenceRay), "the reference's rays");
        const std::size_t floor = BrickCache::floorBytes(p.info(), 2 * defaultThreads()) * 4;
        BrickCache cache(store_, ram_, std::max(floor, ram_.freeBytes() / 2), 0);
        const Scene& scene = out_.scene.scene;
        ReferenceInput input{
            &cache, &p.info(),      &p.layer().function,        scene.shading,  &p.layer().statistics,
            1,      scene.surfaces, common_.progress->shares(), scene.lighting, p.view.camera};
        const std::vector<ReferenceRay> compared =
            referenceRays(p.view.camera, p.info(), out_.imageSize, out_.pixelStride);
        common_.progress->stage(out_.scene.name + ": drawing the reference");
        const std::vector<glm::dvec4> values = renderReference(input, compared, 0);
        input.progress = {};
        common_.progress->stage(out_.scene.name + ": proving the reference");
        truth_ = Image(thinnedSize(out_.imageSize, out_.pixelStride));
        std::transform(values.begin(), values.end(), truth_.pixels.begin(),
                       [](const glm::dvec4& v) { return glm::vec4(v); });
        // Proven where something is seen: rays that miss all agree trivially.
        std::vector<ReferenceRay> seen;
        for (std::size_t i = 0; i < compared.size(); ++i)
            if (values[i].a > 0)
                seen.push_back(compared[i]);
        out_.proof = proveOnRays(input, sampledRays(seen, options_.effort.provenRays()), 0);
        common_.detail(out_.scene.name + ": reference drawn, " + std::to_string(seen.size()) + " of " +
                       std::to_string(compared.size()) + " pixels show something");
    }

    /// One for all settings that differ in their step alone, and have no tables for it.
    DeviceMarch& marchOf(DeviceScene& scene, Setting setting, bool counting) {
        if (setting.integrator != Integrator::preintegrated2d && setting.integrator != Integrator::automatic)
            setting.stepVoxels = 1;
        std::vector<Drawer>& drawers = counting ? counters_ : drawers_;
        for (Drawer& known : drawers)
            if (known.setting == setting)
                return *known.march;
        drawers.push_back(
            {setting, std::make_unique<DeviceMarch>(scene, out_.scene.scene, setting, counting)});
        return *drawers.back().march;
    }

    /// The picture, its error and its counts; then it is ready to be timed.
    void prepare(const Planned& planned) {
        const Setting& s = planned.setting;
        try {
            DeviceScene* const scene = sceneOf(s);
            if (!scene)
                return;
            Measured m;
            m.planned = planned;
            m.work = marchOf(*scene, s, true).draw(s.stepVoxels).work;
            DeviceMarch& march = marchOf(*scene, s, false);
            Frame frame;
            for (int i = 0; i < kWarmUps && !(frame.wallMs > kLongFrameMs); ++i)
                frame = march.draw(s.stepVoxels);
            m.error = measureError(thinned(frame.image, out_.pixelStride), truth_);
            m.features = march.features();
            m.integrator = march.integrator();
            m.peakRamBytes = scene->peakRamBytes();
            m.peakGpuBytes = march.gpuBytes();
            m.bytesDecoded = scene->bytesDecoded();
            m.work.bricksUploaded = scene->uploads().bricksUploaded;
            if (s.termination > 0) {
                Setting whole = s;
                whole.termination = 0;
                m.bound = s.termination * brightest(out_.scene.scene.shading, out_.scene.scene.lighting);
                m.boundOk =
                    withinBound(frame.image, marchOf(*scene, whole, false).draw(s.stepVoxels).image, m.bound);
            }
            if (m.error.nanCount > 0)
                fail(s, std::to_string(m.error.nanCount) + " values are not finite");
            if (!m.boundOk)
                fail(s, "ending rays early left out more light than " + formatNumber(m.bound));
            m.blocks.resize(static_cast<std::size_t>(options_.effort.blocks()));
            out_.measured.push_back(std::move(m));
        } catch (const InputError& refused) {
            fail(s, refused.what());
        }
    }

    /// All settings, interleaved in a random order that is another one every round. The block is thrown away
    /// and taken again where the calibration moved.
    void timeBlock(int block) {
        const Effort& effort = options_.effort;
        const double most = effort.secondsPerSetting() / effort.blocks();
        for (int attempt = 0;; ++attempt) {
            std::mt19937 random(static_cast<unsigned>(1000 * block + attempt));
            const double before = calibrationMs();
            std::vector<BlockTimes> times(out_.measured.size());
            std::vector<double> spent(out_.measured.size());
            for (int round = 0; round < effort.rounds(); ++round) {
                common_.progress->update((block + static_cast<double>(round) / effort.rounds()) /
                                         effort.blocks());
                std::vector<std::size_t> order(out_.measured.size());
                std::iota(order.begin(), order.end(), std::size_t{0});
                std::shuffle(order.begin(), order.end(), random);
                for (const std::size_t i : order) {
                    if (round > 0 && spent[i] > most)
                        continue;
                    const Setting& s = out_.measured[i].planned.setting;
                    const Frame frame = marchOf(*sceneOf(s), s, false).draw(s.stepVoxels);
                    BlockTimes& t = times[i];
                    t.gpuMs = t.wallMs.empty() ? frame.gpuMs : std::min(t.gpuMs, frame.gpuMs);
                    t.wallMs.push_back(frame.wallMs);
                    spent[i] += 1e-3 * frame.wallMs;
                }
            }
            const double moved = std::abs(calibrationMs() / before - 1);
            if (moved > kMovedShare && attempt < effort.repeatedBlocks()) {
                common_.detail("block " + std::to_string(block + 1) +
                               " is taken again: the calibration moved by " + formatNumber(100 * moved, 2) +
                               " %");
                continue;
            }
            out_.blocksMoved += moved > kMovedShare;
            ++out_.blocksMeasured;
            for (std::size_t i = 0; i < times.size(); ++i)
                out_.measured[i].blocks[static_cast<std::size_t>(block)] = std::move(times[i]);
            return;
        }
    }

    const SweepOptions& options_;
    const CommonOptions& common_;
    EngineMaker engines_;
    MemoryBudget ram_;
    std::size_t gpuBytes_;
    StoreReader store_;
    Sweep out_;
    Image truth_;                   // thinned
    std::vector<OnDevice> details_; // the first: all the memory there is
    std::vector<Drawer> drawers_, counters_;
};

} // namespace

double Measured::leastMs() const {
    const std::vector<double> least = leastOfBlocks();
    return least.empty() ? 0 : *std::min_element(least.begin(), least.end());
}

std::vector<double> Measured::leastOfBlocks() const {
    std::vector<double> least;
    for (const BlockTimes& block : blocks)
        if (!block.wallMs.empty())
            least.push_back(*std::min_element(block.wallMs.begin(), block.wallMs.end()));
    return least;
}

const Measured* Sweep::find(const Setting& setting) const {
    for (const Measured& m : measured)
        if (m.planned.setting == setting)
            return &m;
    return nullptr;
}

double Sweep::floor() const {
    constexpr double kFloatPicture = 6e-8;              // pictures are compared in float
    return 10 * std::max(proof.error(), kFloatPicture); // smaller errors are not told apart
}

namespace {
/// The step and integrator that `tessera render` takes where the scene names none.
Quality asRendered(const NamedScene& scene, const SweepOptions& options, Progress* progress) {
    MemoryBudget ram("RAM", "--ram", options.ramBytes);
    MemoryBudget gpu("GPU memory", "--gpu-memory", scene.gpuBytes > 0 ? scene.gpuBytes : options.gpuBytes);
    const StoreReader store(scene.scene.volumes.at(0).path, ram);
    Scene drawn = scene.scene;
    drawn.imageSize = fittedSize(drawn.imageSize, options.effort.pictureExtent());
    RenderOptions render;
    render.engine = options.engine;
    render.device.text = options.device;
    render.checking = true;
    render.progress = progress;
    const RenderResult result = renderScene(drawn, store, ram, gpu, render);
    Quality quality = scene.scene.quality;
    quality.stepVoxels = result.stepVoxels;
    quality.integrator = result.integrator;
    quality.automaticStep = false;
    return quality;
}
} // namespace

Sweep runSweep(const NamedScene& scene, const SweepOptions& options, const CommonOptions& common) {
    NamedScene measured = scene;
    if (scene.scene.quality.automaticStep)
        measured.scene.quality = asRendered(scene, options, common.progress.get());
    return Runner(measured, options, common).run();
}

} // namespace tessera::accuracy
