// tests/bench/papers/previews.cpp: lossy codes of whole volumes, and what they are worth as previews beside
// the coarser levels that every store has (course notes on advanced volume ray casting, 2.9.1).
#include "bricking/import/importer.h"
#include "bricking/store/dct_codec.h"
#include "core/base/program_folders.h"
#include "core/base/threads.h"
#include "tests/bench/papers/papers.h"
#include "tests/bench/papers/studied_scene.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <ctime>
#include <functional>
#include <memory>
#if TESSERA_WITH_ZFP
#include <zfp.h>
#endif

namespace tessera::bench {
namespace {

constexpr std::size_t kValues = std::size_t{kChunkExtent} * kChunkExtent * kChunkExtent;

using Cube = std::vector<float>;
/// A code of one cube: its bytes, and what they are decoded to.
struct Code {
    std::string name;
    std::function<std::vector<std::byte>(const Cube&)> encode;
    std::function<void(const std::vector<std::byte>&, Cube&)> decode;
};

#if TESSERA_WITH_ZFP
std::vector<std::byte> zfpOf(const Cube& cube, double tolerance, std::vector<std::byte>* coded, Cube* out) {
    Cube& data = out ? *out : const_cast<Cube&>(cube); // zfp reads what it does not write
    const std::unique_ptr<zfp_field, decltype(&zfp_field_free)> field(
        zfp_field_3d(data.data(), zfp_type_float, kChunkExtent, kChunkExtent, kChunkExtent), zfp_field_free);
    const std::unique_ptr<zfp_stream, decltype(&zfp_stream_close)> stream(zfp_stream_open(nullptr),
                                                                          zfp_stream_close);
    zfp_stream_set_accuracy(stream.get(), tolerance);
    std::vector<std::byte> bytes(coded ? 0 : zfp_stream_maximum_size(stream.get(), field.get()));
    std::vector<std::byte>& buffer = coded ? *coded : bytes;
    const std::unique_ptr<bitstream, decltype(&stream_close)> bits(stream_open(buffer.data(), buffer.size()),
                                                                   stream_close);
    zfp_stream_set_bit_stream(stream.get(), bits.get());
    zfp_stream_rewind(stream.get());
    if (out)
        zfp_decompress(stream.get(), field.get());
    else
        bytes.resize(zfp_compress(stream.get(), field.get()));
    return bytes;
}

Code zfpCode(double tolerance) {
    return {"zfp, tolerance " + formatCell(tolerance),
            [=](const Cube& cube) { return zfpOf(cube, tolerance, nullptr, nullptr); },
            [=](const std::vector<std::byte>& coded, Cube& cube) {
                zfpOf(cube, tolerance, const_cast<std::vector<std::byte>*>(&coded), &cube);
            }};
}
#endif
/// That of previews. It rounds values first, and keeps what it made.
Code dctCode(Codec codec) {
    const auto bytesOf = [](const Cube& cube) {
        std::vector<std::int16_t> values(cube.begin(), cube.end());
        std::vector<std::byte> raw(values.size() * sizeof(std::int16_t));
        std::memcpy(raw.data(), values.data(), raw.size());
        return raw;
    };
    return {"DCT, step " + std::to_string(dctStep(codec)),
            [=](const Cube& cube) {
                std::vector<std::byte> raw = bytesOf(cube), out(encodedBound(raw.size()));
                withDctSteps(raw, sizeof(std::int16_t), true, codec);
                out.resize(encodeByDct(raw, sizeof(std::int16_t), out, codec));
                return out;
            },
            [=](const std::vector<std::byte>& coded, Cube& cube) {
                std::vector<std::int16_t> values(cube.size());
                decodeByDct(coded, std::as_writable_bytes(std::span(values)), "a cube", codec);
                std::copy(values.begin(), values.end(), cube.begin());
            }};
}

double cpuSeconds() {
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

struct Coded {
    std::size_t bytes = 0;
    double largest = 0, squares = 0, decodeSeconds = 0;
    std::vector<std::int16_t> volume; // decoded, whole chunks of 16 bits, in the chunks' order
};

/// A 16-bit volume as chunks.
struct Chunks {
    explicit Chunks(const StoreReader& store) : grid(ceilDiv(store.info().extentVoxels, kChunkExtent)) {
        raw.resize(cellCount(grid) * kValues);
        parallelFor(cellCount(grid), 0, [&](std::size_t n) {
            const auto x = static_cast<std::size_t>(grid.x), y = static_cast<std::size_t>(grid.y);
            store.readChunk(
                {0, static_cast<int>(n % x), static_cast<int>(n / x % y), static_cast<int>(n / x / y)},
                std::as_writable_bytes(std::span(raw).subspan(n * kValues, kValues)));
        });
    }
    Cube cube(std::size_t n) const {
        const auto values = std::span(raw).subspan(n * kValues, kValues);
        return Cube(values.begin(), values.end());
    }
    glm::ivec3 grid;
    std::vector<std::int16_t> raw;
};

Coded codedBy(const Code& code, const Chunks& chunks) {
    Coded coded;
    coded.volume.resize(chunks.raw.size());
    Cube out(kValues);
    for (std::size_t n = 0; n < cellCount(chunks.grid); ++n) {
        const Cube cube = chunks.cube(n);
        const std::vector<std::byte> bytes = code.encode(cube);
        coded.bytes += bytes.size();
        const double before = cpuSeconds();
        code.decode(bytes, out);
        coded.decodeSeconds += cpuSeconds() - before;
        for (std::size_t i = 0; i < kValues; ++i) {
            const double e = std::abs(double{out[i]} - double{cube[i]});
            coded.largest = std::max(coded.largest, e);
            coded.squares += e * e;
            coded.volume[n * kValues + i] =
                static_cast<std::int16_t>(std::clamp(std::lround(out[i]), -32768L, 32767L));
        }
    }
    return coded;
}

/// A decoded volume to import.
class DecodedSource : public SlabSource {
  public:
    DecodedSource(VolumeInfo info, const Chunks& chunks, const Coded& coded)
        : info_(std::move(info)), chunks_(chunks), coded_(coded) {}
    const VolumeInfo& info() const override { return info_; }
    std::string describe() const override { return "a decoded volume"; }
    void readSlices(int count, std::span<std::byte> out) override {
        const glm::ivec3 extent = info_.extentVoxels;
        std::size_t at = 0;
        for (int z = next_; z < next_ + count; ++z)
            for (int y = 0; y < extent.y; ++y)
                for (int x = 0; x < extent.x; ++x, at += 2) {
                    const glm::ivec3 p(x, y, z), chunk = p / kChunkExtent;
                    const std::int16_t value =
                        coded_.volume[linearIndex(chunk, chunks_.grid) * kValues +
                                      linearIndex(p - chunk * kChunkExtent, glm::ivec3(kChunkExtent))];
                    std::memcpy(out.data() + at, &value, sizeof value);
                }
        next_ += count;
    }

  private:
    VolumeInfo info_;
    const Chunks& chunks_;
    const Coded& coded_;
    int next_ = 0;
};

Image pictureOf(const Workbench& bench, const std::filesystem::path& path, const std::string& preset,
                int level) {
    MemoryBudget ram("RAM", "--ram", bench.ramBytes), gpu("GPU memory", "--gpu-memory", std::size_t{1} << 30);
    const StoreReader store(path, ram);
    Scene scene = studiedScene(preset, bench.fewerPixels());
    scene.camera = cameraNamed("anterior", store.info(), scene.imageSize);
    scene.quality.stepVoxels = 0.25;
    const EngineMaker maker(EngineKind::native, {"auto"});
    const std::unique_ptr<Engine> engine = maker.make(ram, gpu);
    Planner plan = planScene(scene, store, engine->limits(), {ram, gpu, 0}, LevelChoice::oneForAll);
    Selection selection = cullBricks(plan.layer().statistics, plan.layer().table, plan.info(), level,
                                     cullingFor(scene.shading));
    for (const std::uint8_t at : selection.levels)
        ++selection.counts[at];
    plan.setSelection(std::move(selection));
    plan.chosen.atlasPages = std::max(pagesOf(plan.layer().selection), std::size_t{1});
    Work work;
    loadBricks(*engine, plan, gpu, work);
    const auto caster = engine->caster({}, gpu);
    caster->begin(raysOf(plan));
    drawToTheEnd(*caster, *engine, plan, Slicing{}, work);
    return caster->image();
}

/// Bytes of a level, as stored.
std::size_t storedBytes(const std::filesystem::path& store, int level) {
    std::size_t bytes = 0;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(store / std::to_string(level)))
        if (entry.is_regular_file())
            bytes += entry.file_size();
    return bytes;
}

} // namespace

Report previewsReport(const Workbench& bench) {
    Report report;
    report.name = "previews";
    report.title = "Lossy codes, and coarser levels, as previews (course notes, 2.9.1)";
    report.text = {"Chunks of 32^3 values are coded one by one. *DCT* has blocks of 8^3 with coefficients in "
                   "steps that grow with frequency, and "
                   "Zstandard behind it, as previews of `import --preview` have them; *zfp* is libzfp at a "
                   "fixed tolerance. Ratios are to 16 bits a "
                   "voxel; the lossless one is the store's own. "
                   "The second table asks what a first picture errs by for the bytes that it fetches: from a "
                   "coarser level of the store, "
                   "lossless, or from a lossy code of the finest level."};
    Table codes{"previews-codes",
                "Codes of whole volumes; decoding in CPU time of one core:",
                {"volume", "code", "ratio", "PSNR, dB", "largest error", "decoded, MB/s"},
                {},
                true};
    Table pictures{"previews-pictures",
                   "Pictures of " + std::to_string(bench.fewerPixels()) +
                       "^2 pixels against that of the finest level, lossless:",
                   {"scene", "from", "MiB", "rms", "L*u*v* mean", "p99"},
                   {},
                   true};
    for (const BenchVolume& volume : bench.volumes) {
        MemoryBudget ram("RAM", "--ram", bench.ramBytes);
        const StoreReader store(volume.store, ram);
        if (store.info().type != ValueType::i16)
            continue;
        const Charge charge = ram.charge(2 * cellCount(ceilDiv(store.info().extentVoxels, kChunkExtent)) *
                                             kValues * sizeof(std::int16_t),
                                         "two volumes of chunks");
        const Chunks chunks(store);
        const double values = static_cast<double>(chunks.raw.size()), rawBytes = 2 * values;
        const auto [low, high] = std::minmax_element(chunks.raw.begin(), chunks.raw.end());
        const double range = *high - *low;
        std::size_t lossless = 0;
        std::vector<std::byte> out(encodedBound(2 * kValues));
        for (std::size_t n = 0; n < cellCount(chunks.grid); ++n)
            lossless +=
                encodeChunk(std::as_bytes(std::span(chunks.raw).subspan(n * kValues, kValues)), 2, out).bytes;
        codes.rows.push_back(
            {volume.name, "lossless", rawBytes / static_cast<double>(lossless), "infinite", 0.0, "-"});
        const std::string& preset = volume.presets.front();
        const Image truth = pictureOf(bench, volume.store, preset, 0);
        const auto addPicture = [&](const std::string& from, std::size_t bytes, const Image& image) {
            const ImageDifference d = compare(image, truth);
            pictures.rows.push_back({volume.name + ", " + preset, from,
                                     static_cast<double>(bytes) / (1 << 20), d.rms, d.luvMean, d.luvP99});
        };
        for (const int level : {1, 2, 3})
            addPicture("level " + std::to_string(level), storedBytes(volume.store, level),
                       pictureOf(bench, volume.store, preset, level));
        std::vector<Code> all;
#if TESSERA_WITH_ZFP
        for (const double tolerance : {8.0, 64.0, 256.0, 1024.0})
            all.push_back(zfpCode(tolerance));
#endif
        for (const Codec codec : {Codec::dct8, Codec::dct32, Codec::dct64, Codec::dct128})
            all.push_back(dctCode(codec));
        for (const Code& code : all) {
            const Coded coded = codedBy(code, chunks);
            const double mse = coded.squares / values;
            codes.rows.push_back({volume.name, code.name, rawBytes / static_cast<double>(coded.bytes),
                                  10 * std::log10(range * range / std::max(mse, 1e-9)), coded.largest,
                                  rawBytes / 1e6 / coded.decodeSeconds});
            const ScratchFolder scratch;
            MemoryBudget importing("RAM", "--ram", bench.ramBytes);
            ImportOptions options;
            options.durable = false;
            DecodedSource source(store.info(), chunks, coded);
            importToStore(source, scratch / "decoded.zarr", importing, options);
            addPicture(code.name, coded.bytes, pictureOf(bench, scratch / "decoded.zarr", preset, 0));
        }
        bench.done(volume.name);
    }
    report.tables = {std::move(codes), std::move(pictures)};
    return report;
}

} // namespace tessera::bench
