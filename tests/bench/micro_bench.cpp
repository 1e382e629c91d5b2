// tests/bench/micro_bench.cpp: the parts of a frame one by one (Google Benchmark): import, codec, cache,
// sampler, GPU ray caster. Names are stable: part/what/type/size. Rates say how fast, counters say how much
// work it was; on a noisy machine the counters are what to compare.
//
//   micro_bench --benchmark_filter=decode --benchmark_out=micro.csv --benchmark_out_format=csv
#include "tests/bench/bench_tools.h"

#include "bricking/import/importer.h"
#include "bricking/store/codec.h"
#include "core/base/error.h"
#include "core/base/threads.h"
#include "render/backends/gpu/features.h"
#include "render/backends/gpu/gl/context.h"
#include "render/backends/gpu/probe.h"
#include "render/contract/lattice.h"
#include "render/contract/sampler.h"
#include "render/plan/planner.h"

#include <benchmark/benchmark.h>

#include <cmath>
#include <cstring>
#include <optional>

namespace tessera::bench {
namespace {

constexpr int kEdge = 128; // voxels an axis: 64 chunks, large enough that fixed costs do not tell

/// A hash in [0,1): positions and orders that repeat from run to run.
double unitHash(std::uint64_t n) {
    n = (n ^ (n >> 30)) * 0xbf58476d1ce4e5b9u;
    n = (n ^ (n >> 27)) * 0x94d049bb133111ebu;
    return static_cast<double>((n ^ (n >> 31)) >> 11) * 0x1p-53;
}

/// The shared inputs of all benchmarks, made on first use.
class Workbench {
  public:
    const MemoryVolume& volume(ValueType type) {
        auto& slot = volumes_[type];
        if (slot.voxels.empty())
            slot = phantomInMemory("torso", glm::ivec3(kEdge), type);
        return slot;
    }
    const StoreReader& store(ValueType type) {
        auto& slot = stores_[type];
        if (!slot) {
            const std::filesystem::path path = folder_.path() / (std::string(name(type)) + ".zarr");
            MemorySource source(volume(type).info, volume(type).voxels);
            ImportOptions options;
            options.durable = false;
            importToStore(source, path, budgets.ram, options);
            slot = std::make_unique<StoreReader>(path, budgets.ram);
        }
        return *slot;
    }
    /// Throws Error where the machine has no GL 4.5.
    const GlContext& context() {
        if (!context_)
            context_.emplace(GlDeviceChoice{device});
        return *context_;
    }
    std::filesystem::path scratch(const std::string& file) const { return folder_.path() / file; }

    std::string device = "auto";
    Budgets budgets;

  private:
    ScratchFolder folder_;
    std::map<ValueType, MemoryVolume> volumes_;
    std::map<ValueType, std::unique_ptr<StoreReader>> stores_;
    std::optional<GlContext> context_;
};

std::vector<ChunkKey> chunksOf(const VolumeInfo& info) {
    std::vector<ChunkKey> keys;
    const glm::ivec3 grid = chunkGrid(info.extentVoxels, 0);
    for (int k = 0; k < grid.z; ++k)
        for (int j = 0; j < grid.y; ++j)
            for (int i = 0; i < grid.x; ++i)
                keys.push_back({0, i, j, k});
    return keys;
}

void importVolume(benchmark::State& state, Workbench& bench, ValueType type) {
    const MemoryVolume& volume = bench.volume(type);
    ImportReport report;
    for (auto _ : state) {
        MemorySource source(volume.info, volume.voxels);
        ImportOptions options;
        options.force = true;
        options.durable = false;
        report = importToStore(source, bench.scratch("import.zarr"), bench.budgets.ram, options);
    }
    state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(report.bytesIn));
    state.counters["voxels"] = static_cast<double>(report.voxels);
    state.counters["bytes_in"] = static_cast<double>(report.bytesIn);
    state.counters["bytes_out"] = static_cast<double>(report.bytesOut);
    state.counters["chunks"] = static_cast<double>(report.chunksWritten);
    state.counters["chunks_fill"] = static_cast<double>(report.chunksFill);
}

/// The chunks of the torso, encoded; one thread.
void codec(benchmark::State& state, Workbench& bench, ValueType type, bool decode) {
    const StoreReader& store = bench.store(type);
    std::vector<std::byte> raw(store.chunkBytes()), encoded(encodedBound(raw.size()));
    std::vector<std::vector<std::byte>> chunks, packed;
    double packedBytes = 0;
    for (const ChunkKey& key : chunksOf(store.info())) {
        store.readChunk(key, raw);
        chunks.push_back(raw);
        const std::size_t bytes = encodeChunk(raw, bytesPerValue(type), encoded).bytes;
        packed.emplace_back(encoded.begin(), encoded.begin() + static_cast<std::ptrdiff_t>(bytes));
        packedBytes += static_cast<double>(bytes);
    }
    for (auto _ : state)
        for (std::size_t i = 0; i < chunks.size(); ++i) {
            if (decode)
                decodeChunk(packed[i], raw, "benchmark");
            else
                benchmark::DoNotOptimize(encodeChunk(chunks[i], bytesPerValue(type), encoded));
            benchmark::ClobberMemory();
        }
    const double rawBytes = static_cast<double>(raw.size() * chunks.size());
    state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(rawBytes));
    state.counters["chunks"] = static_cast<double>(chunks.size());
    state.counters["bytes_decoded"] = rawBytes;
    state.counters["bytes_encoded"] = packedBytes;
}

/// Chunks straight from the store's files (in the system's cache), one thread.
void readChunks(benchmark::State& state, Workbench& bench, ValueType type) {
    const StoreReader& store = bench.store(type);
    const std::vector<ChunkKey> keys = chunksOf(store.info());
    std::vector<std::byte> raw(store.chunkBytes());
    for (auto _ : state)
        for (const ChunkKey& key : keys)
            store.readChunk(key, raw);
    state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(keys.size() * raw.size()));
    state.counters["chunks"] = static_cast<double>(keys.size());
}

/// Chunks in a fixed random order through a cache that holds a share of them. share 1: hits alone, once warm.
void cacheOrder(benchmark::State& state, Workbench& bench, ValueType type, double share) {
    const StoreReader& store = bench.store(type);
    const std::vector<ChunkKey> keys = chunksOf(store.info());
    const auto chunks = static_cast<std::size_t>(std::lround(share * static_cast<double>(keys.size()))) +
                        (share < 1 ? 0u : 8u);
    const std::size_t bytes = std::max(chunks * store.chunkBytes(), BrickCache::floorBytes(store.info(), 0));
    BrickCache cache(store, bench.budgets.ram, bytes, 0);
    for (const ChunkKey& key : keys)
        (void)cache.get(key);
    const BrickCache::Counters before = cache.counters();
    constexpr std::uint64_t kGets = 1024; // an iteration
    for (auto _ : state)
        for (std::uint64_t n = 0; n < kGets; ++n)
            benchmark::DoNotOptimize(
                cache.get(keys[static_cast<std::size_t>(unitHash(n) * static_cast<double>(keys.size()))]));
    const BrickCache::Counters after = cache.counters();
    const double gets = static_cast<double>(kGets) * static_cast<double>(state.iterations());
    state.SetItemsProcessed(static_cast<std::int64_t>(gets));
    state.counters["hit_rate"] = static_cast<double>(after.hits - before.hits) / gets;
    state.counters["evictions_per_get"] = static_cast<double>(after.evictions - before.evictions) / gets;
    state.counters["bytes_decoded_per_get"] =
        static_cast<double>(after.bytesDecoded - before.bytesDecoded) / gets;
    state.counters["cache_bytes"] = static_cast<double>(bytes);
}

enum class Order { alongRays, random };

/// alongRays: rows of samples half a voxel apart, oblique by a little; random: anywhere.
glm::vec3 samplePosition(std::uint64_t n, Order order) {
    constexpr float kInside = static_cast<float>(kEdge);
    if (order == Order::random)
        return glm::vec3(unitHash(3 * n), unitHash(3 * n + 1), unitHash(3 * n + 2)) * kInside;
    constexpr std::uint64_t kPerRay = 2 * kEdge;
    const auto along = static_cast<float>(n % kPerRay) * 0.5f;
    const auto row = static_cast<float>((n / kPerRay) % kEdge),
               layer = static_cast<float>(n / kPerRay / kEdge);
    return glm::mod(glm::vec3(along, row + 0.01f * along + 0.37f, layer + 0.02f * along + 0.21f), kInside);
}

constexpr std::uint64_t kSamplesPerProbe = 7; // probe.comp: a value, and six for the gradient

/// The field on the device. A probe uploads positions and compiles too: the time of 64 probes, which is all
/// that, is taken off the time of a million.
void sampleOnDevice(benchmark::State& state, Workbench& bench, ValueType type, Fetch fetch, Order order) {
    const GlContext& context = bench.context();
    Scene scene;
    scene.camera = FittedView{View::anterior, Projection::perspective, Fit::volume};
    scene.volumes = {{"", std::string("soft-tissue")}};
    const StoreReader& store = bench.store(type);
    Planner p = planScene(scene, store, {context.max3dTextureSize(), context.maxTextureBytes()},
                          {bench.budgets.ram, bench.budgets.gpu, 0}, LevelChoice::oneForAllNothingCulled);
    Atlas atlas(store.info(), p.layer().selection, pagesFor(p.layer().selection.counts),
                {context.max3dTextureSize(), context.maxTextureBytes()}, bench.budgets.gpu,
                bench.budgets.ram);
    Work upload;
    atlas.bricks.load(*p.layer().cache, upload);
    std::uint32_t features = 0;
    if (fetch == Fetch::hardware)
        features |= kFeatureHardware;
    if (texelFormat(type).normalised)
        features |= kFeatureNormalised;
    std::vector<glm::vec3> positions;
    for (std::uint64_t n = 0; n < (std::uint64_t{1} << 20); ++n)
        positions.push_back(samplePosition(n, order));
    const std::vector<glm::vec3> few(positions.begin(), positions.begin() + 64);
    const auto probe = [&](const std::vector<glm::vec3>& at) {
        const auto start = Clock::now();
        benchmark::DoNotOptimize(probeField(at, features, store.info(),
                                            {&atlas, p.layer().selection.finest()}, bench.budgets.gpu));
        return msSince(start);
    };
    double overhead = probe(few);
    for (int turn = 0; turn < 5; ++turn)
        overhead = std::min(overhead, probe(few));
    for (auto _ : state)
        state.SetIterationTime(std::max(probe(positions) - overhead, 1e-3) * 1e-3);
    const auto samples = static_cast<std::int64_t>(positions.size() * kSamplesPerProbe);
    state.SetItemsProcessed(state.iterations() * samples);
    state.counters["samples"] = static_cast<double>(samples);
    state.counters["bricks"] = static_cast<double>(upload.bricksUploaded);
    state.counters["bytes_uploaded"] = static_cast<double>(upload.bytesUploaded);
}

/// The same samples by the contract's C++ counterpart on the CPU, all threads.
template <typename Real>
void sampleOnMirror(benchmark::State& state, Workbench& bench, ValueType type, Order order) {
    const StoreReader& store = bench.store(type);
    BrickCache cache(store, bench.budgets.ram, std::size_t{64} << 20, 0);
    constexpr std::uint64_t kStrips = 64, kPerStrip = 1024;
    for (auto _ : state) {
        std::vector<Real> sums(kStrips);
        parallelFor(kStrips, 0, [&](std::size_t strip) {
            LatticeReader samples(cache, store.info(), 0, nullptr);
            for (std::uint64_t n = strip * kPerStrip; n < (strip + 1) * kPerStrip; ++n) {
                const glm::vec<3, Real> p(samplePosition(n, order));
                const glm::vec<3, Real> g = fieldGradient(samples, p, Real(1));
                sums[strip] += fieldValue(samples, p, Real(1)) + g.x + g.y + g.z;
            }
        });
        benchmark::DoNotOptimize(sums);
    }
    const auto samples = static_cast<std::int64_t>(kStrips * kPerStrip * kSamplesPerProbe);
    state.SetItemsProcessed(state.iterations() * samples);
    state.counters["samples"] = static_cast<double>(samples);
    const BrickCache::Counters c = cache.counters();
    state.counters["bytes_decoded"] = static_cast<double>(c.bytesDecoded);
}

/// A frame of the small torso, with all of its work.
void march(benchmark::State& state, Workbench& bench, ValueType type, Fetch fetch, bool shaded) {
    Scene scene;
    scene.camera = FittedView{View::anterior, Projection::perspective, Fit::volume};
    scene.volumes = {{"", std::string("bone-1")}};
    scene.shading.on = shaded;
    SceneOnDevice onDevice(scene, bench.store(type), bench.context(), bench.budgets);
    const std::uint32_t features = onDevice.features(fetch);
    const glm::ivec2 size(256);
    const Work work = onDevice.draw(size, 0.5, features | kFeatureCounting, nullptr).work;
    for (auto _ : state)
        state.SetIterationTime(onDevice.draw(size, 0.5, features, nullptr).ms * 1e-3);
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(work.samples));
    state.counters["segments"] = static_cast<double>(work.segments);
    state.counters["samples"] = static_cast<double>(work.samples);
    state.counters["fetches"] = static_cast<double>(work.fetches);
    state.counters["bricks"] = static_cast<double>(onDevice.uploadWork().bricksUploaded);
    state.counters["bytes_uploaded"] = static_cast<double>(onDevice.uploadWork().bytesUploaded);
}

const char* shortName(ValueType type) {
    switch (type) {
    case ValueType::u8:
        return "u8";
    case ValueType::i16:
        return "i16";
    case ValueType::u16:
        return "u16";
    case ValueType::f32:
        return "f32";
    }
    return "?";
}

/// Registers a benchmark whose failure (no device, say) is reported in its place and stops no other.
template <typename Body> benchmark::internal::Benchmark* add(const std::string& name, Body body) {
    return benchmark::RegisterBenchmark(name.c_str(),
                                        [body](benchmark::State& state) {
                                            try {
                                                body(state);
                                            } catch (const std::exception& error) {
                                                state.SkipWithError(error.what());
                                            }
                                        })
        ->Unit(benchmark::kMillisecond);
}

void addAll(Workbench& bench) {
    const std::string size = "/" + std::to_string(kEdge) + "^3";
    for (const ValueType type : {ValueType::i16, ValueType::u16, ValueType::f32}) {
        const std::string t = shortName(type);
        add("import/torso/" + t + size, [&bench, type](auto& s) {
            importVolume(s, bench, type);
        })->UseRealTime();
        add("encode/" + t, [&bench, type](auto& s) { codec(s, bench, type, false); })->UseRealTime();
        add("decode/" + t, [&bench, type](auto& s) { codec(s, bench, type, true); })->UseRealTime();
        add("read/" + t + size, [&bench, type](auto& s) { readChunks(s, bench, type); })->UseRealTime();
    }
    for (const ValueType type : {ValueType::i16, ValueType::f32}) {
        const std::string t = shortName(type);
        add("cache/all/" + t, [&bench, type](auto& s) { cacheOrder(s, bench, type, 1); })->UseRealTime();
        add("cache/half/" + t, [&bench, type](auto& s) { cacheOrder(s, bench, type, 0.5); })->UseRealTime();
        for (const Order order : {Order::alongRays, Order::random}) {
            const std::string o = order == Order::random ? "/random" : "";
            for (const Fetch fetch : {Fetch::hardware, Fetch::exact})
                add(std::string("sample/trilinear/") + (fetch == Fetch::exact ? "exact/" : "hardware/") + t +
                        o,
                    [&bench, type, fetch, order](auto& s) { sampleOnDevice(s, bench, type, fetch, order); })
                    ->UseManualTime();
            add("sample/trilinear/mirror-float/" + t + o, [&bench, type, order](auto& s) {
                sampleOnMirror<float>(s, bench, type, order);
            })->UseRealTime();
            add("sample/trilinear/mirror-double/" + t + o, [&bench, type, order](auto& s) {
                sampleOnMirror<double>(s, bench, type, order);
            })->UseRealTime();
        }
        for (const bool shaded : {false, true})
            for (const Fetch fetch : {Fetch::hardware, Fetch::exact})
                add(std::string("march/bone/") + (shaded ? "shaded/" : "plain/") +
                        (fetch == Fetch::exact ? "exact/" : "hardware/") + t + size,
                    [&bench, type, fetch, shaded](auto& s) { march(s, bench, type, fetch, shaded); })
                    ->UseManualTime();
    }
}

} // namespace
} // namespace tessera::bench

int main(int argc, char** argv) {
    benchmark::Initialize(&argc, argv); // takes its own options out
    try {
        tessera::bench::Workbench bench;
        bench.device = tessera::bench::parseOptions(argc, argv, {{"--device", "auto"}})["--device"];
        try {
            benchmark::AddCustomContext("gl_device", bench.context().renderer());
        } catch (const tessera::Error& error) {
            benchmark::AddCustomContext("gl_device", std::string("none: ") + error.what());
        }
        tessera::bench::addAll(bench);
        benchmark::RunSpecifiedBenchmarks();
    } catch (const std::exception& error) {
        std::fprintf(stderr, "micro_bench: %s\n", error.what());
        return 2;
    }
    return 0;
}
