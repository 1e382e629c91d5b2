// tests/bench/lod/skipping.cpp: the savings of empty-space skipping with each of the maps. Samples are
// compared with those of an oracle that knows the visible segments before a ray's end. Also the time and
// memory of the maps.
#include "render/backends/gpu/features.h"
#include "render/backends/gpu/gl/context.h"
#include "render/backends/gpu/gpu_engine.h"
#include "render/backends/gpu/march.h"
#include "render/backends/gpu/skipping_binding.h"
#include "render/residency/texels.h"
#include "tests/bench/lod/experiments.h"
#include "tests/bench/report/page.h" // loadAverage

#include <algorithm>
#include <array>
#include <chrono>
#include <cstring>
#include <limits>

namespace tessera::bench {
namespace {

/// From nothing to the finest; each is the one before with one thing more.
enum Leap : std::size_t { kNone, kPlainChebyshev, kOctants, kBlocks, kLeaps };
constexpr std::array<const char*, kLeaps> kWayNames = {"none", "plain Chebyshev", "octants",
                                                       "blocks of 2 voxels"};

struct WayRow {
    double samples = 0, iterations = 0;
    double marchMs = std::numeric_limits<double>::infinity(), findMs = marchMs; // least of the repeats
    double bytes = 0;
    bool same = true;
};

/// One scene, all of its level 0 on the device, and the four ways to cast rays through it.
class SkippingCase {
  public:
    SkippingCase(SceneBench& scene, Fetch fetch, MemoryBudget& ram, MemoryBudget& gpu)
        : p_(scene.prepared()), gpu_(gpu),
          features_((fetch == Fetch::hardware ? std::uint32_t{kFeatureHardware} : 0u) |
                    (p_.layer().optics.termination > 0 ? std::uint32_t{kFeatureTermination} : 0u) |
                    (texelFormat(p_.info().type).normalised ? std::uint32_t{kFeatureNormalised} : 0u)),
          atlas_(p_.info(), p_.layer().selection,
                 std::max(pagesFor(p_.layer().selection.counts), std::size_t{1}), TextureLimits{}, gpu, ram),
          octants_({p_.layer().statistics, p_.layer().table, p_.info(), p_.layer().selection,
                    p_.view.quality.edgeFunction},
                   MapScale::cells, ram),
          plain_(octants_.plainChebyshev(ram)) {
        Work loading;
        atlas_.bricks.load(*p_.layer().cache, loading);
        for (std::size_t way = 0; way < kLeaps; ++way)
            count(static_cast<Leap>(way));
    }

    void time(Leap way) {
        double findMs = 0;
        const Work work = draw(way, features_, nullptr, findMs);
        rows_[way].marchMs = std::min(rows_[way].marchMs, work.marchMs);
        rows_[way].findMs = std::min(rows_[way].findMs, findMs);
    }

    double oracle() const { return oracle_; }
    const WayRow& row(Leap way) const { return rows_[way]; }

  private:
    void count(Leap way) {
        Image image;
        double findMs = 0;
        // A sample that shows takes six more for its gradient: so the work says how many do.
        const Work work = draw(way, features_ | kFeatureCounting | kFeatureShading, &image, findMs);
        if (way == kNone) {
            oracle_ = static_cast<double>(work.samples - work.segments) / 6;
            picture_ = std::move(image);
        } else {
            rows_[way].same = std::memcmp(image.pixels.data(), picture_.pixels.data(),
                                          image.pixels.size() * sizeof(glm::vec4)) == 0;
        }
        rows_[way].samples = static_cast<double>(work.segments);
        rows_[way].iterations = static_cast<double>(work.iterations);
    }

    Work draw(Leap way, std::uint32_t features, Image* image, double& findMs) {
        if (way != kNone)
            features |= kFeatureSkipping;
        const Occupancy& map = way == kPlainChebyshev ? plain_ : octants_;
        March march(features, p_.view.frame, p_.info(), p_.strides(), p_.layer().optics,
                    way == kNone ? nullptr : &map, gpu_);
        const FieldSource source{&atlas_, p_.layer().selection.finest(), nullptr, nullptr};
        if (way == kBlocks) {
            const auto start = std::chrono::steady_clock::now();
            refineSkipping(march.skippingMap(), map, p_.layer().table, p_.layer().optics, features, p_.info(),
                           source, gpu_);
            findMs =
                std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
        }
        rows_[way].bytes = way == kNone ? 0 : static_cast<double>(march.skippingMap().bytes());
        Work work;
        march.run(source, Slicing{}, work);
        if (image)
            *image = march.image();
        return work;
    }

    const FramePlan& p_;
    MemoryBudget& gpu_;
    std::uint32_t features_;
    Atlas atlas_;
    Occupancy octants_, plain_;
    std::array<WayRow, kLeaps> rows_;
    double oracle_ = 0;
    Image picture_;
};

} // namespace

Report skippingReport(const Workbench& bench) {
    const int repeats = bench.quick ? 1 : 3;
    Report report;
    report.name = "skipping";
    report.title = "Empty-space skipping";
    report.text = {
        "Samples that a picture takes, against those of an oracle that knows which segments show something "
        "before their ray ends: the least that gives this picture. Each way is the one before with one thing "
        "more: a distance map over cells of 8^3 voxels (plain Chebyshev); a distance for each octant; and "
        "blocks of 2^3 voxels of the cells that show something, found on the device. What is measured is the "
        "march in OpenGL, whatever `--engine` says. All bricks are at level "
        "0, half a voxel a segment, rays end at the scene's transmittance. Times are the march's alone, "
        "least "
        "of " +
        std::to_string(repeats) +
        " interleaved repeats without counters; finding blocks is once for a transfer function, and beside. "
        "The bytes are the map's on the device; the pictures are compared bit by bit."};
    Table table{"skipping",
                "Pictures of " + std::to_string(bench.fewerPixels()) + "^2 pixels from anterior:",
                {"scene", "fetch", "way", "samples", "samples / oracle", "iterations", "march ms",
                 "finding ms", "bytes", "same picture"},
                {},
                true};
    for (const BenchVolume& volume : bench.volumes)
        for (const std::string& preset : volume.presets) {
            const GlContext context({bench.device});
            SceneBench scene(bench, volume, preset, "anterior", bench.fewerPixels());
            MemoryBudget gpu("GPU memory", "--gpu-memory", std::size_t{8} << 30);
            for (const Fetch fetch : {Fetch::hardware, Fetch::exact}) {
                SkippingCase c(scene, fetch, scene.analysisRam(), gpu);
                for (int i = 0; i < repeats; ++i)
                    for (std::size_t way = 0; way < kLeaps; ++way)
                        c.time(static_cast<Leap>(i % 2 ? kLeaps - 1 - way : way));
                for (std::size_t way = 0; way < kLeaps; ++way) {
                    const WayRow& row = c.row(static_cast<Leap>(way));
                    table.rows.push_back({scene.name(), fetch == Fetch::hardware ? "hardware" : "exact",
                                          kWayNames[way], row.samples, row.samples / c.oracle(),
                                          row.iterations, row.marchMs, row.findMs, row.bytes,
                                          row.same ? "yes" : "no"});
                }
            }
            bench.done(scene.name());
        }
    report.tables = {std::move(table)};
    report.after = {"Load average at the end: " + formatCell(loadAverage()) +
                    ". Times are worth as much as the machine was quiet; counts do not depend on it."};
    return report;
}

} // namespace tessera::bench
