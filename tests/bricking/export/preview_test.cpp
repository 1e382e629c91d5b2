// tests/bricking/export/preview_test.cpp: codes of chunks by the discrete cosine transform keep every chunk,
// those that they made themselves in few bytes; previews are such stores, near to what they show.
#include "bricking/export/preview.h"
#include "bricking/import/importer.h"
#include "bricking/store/dct_chunk.h"
#include "bricking/store/dct_codec.h"
#include "bricking/store/store_reader.h"
#include "core/base/error.h"
#include "core/base/program_folders.h"
#include "tests/support/formula_source.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <random>

namespace tessera {
namespace {

using namespace tessera::test;

constexpr std::size_t kCount = std::size_t{kChunkExtent} * kChunkExtent * kChunkExtent;
constexpr Codec kDct[] = {Codec::dct8, Codec::dct16, Codec::dct32, Codec::dct64, Codec::dct128};

/// A chunk of numbers of so many bytes: smooth, with noise, or all noise; beyond a box one value.
std::vector<std::byte> chunkOf(std::size_t valueBytes, double noise, const glm::ivec3& box, unsigned seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> error(0, noise);
    std::vector<std::byte> chunk(kCount * valueBytes);
    const double low = valueBytes == 1 ? 0 : -32768, high = valueBytes == 1 ? 255 : 32767;
    const double size = valueBytes == 1 ? 90 : 900;
    for (int z = 0; z < kChunkExtent; ++z)
        for (int y = 0; y < kChunkExtent; ++y)
            for (int x = 0; x < kChunkExtent; ++x) {
                double value = valueBytes == 1 ? 0 : -1024;
                if (x < box.x && y < box.y && z < box.z)
                    value = 120 + size * std::sin(0.17 * x + 0.11 * y) * std::cos(0.13 * z) + error(random);
                const auto number = static_cast<std::int32_t>(std::clamp(std::round(value), low, high));
                std::memcpy(chunk.data() + linearIndex({x, y, z}, glm::ivec3(kChunkExtent)) * valueBytes,
                            &number, valueBytes);
            }
    return chunk;
}

std::vector<std::byte> encoded(const std::vector<std::byte>& chunk, std::size_t valueBytes, Codec codec) {
    std::vector<std::byte> out(encodedBound(chunk.size()));
    out.resize(encodeChunk(chunk, valueBytes, out, codec).bytes);
    return out;
}

TEST(DctCodec, LosesNothing) {
    unsigned seed = 0;
    for (const std::size_t valueBytes : {1u, 2u})
        for (const double noise : {0.0, 10.0, 1e6})
            for (const glm::ivec3& box :
                 {glm::ivec3(32), glm::ivec3(7, 32, 1), glm::ivec3(1), glm::ivec3(31, 5, 32)})
                for (const Codec codec : kDct) {
                    const std::vector<std::byte> chunk = chunkOf(valueBytes, noise, box, ++seed);
                    std::vector<std::byte> decoded(chunk.size());
                    decodeChunk(encoded(chunk, valueBytes, codec), decoded, "test", codec);
                    EXPECT_EQ(decoded, chunk) << valueBytes << " " << noise << " " << nameOf(codec);
                }
}

TEST(DctCodec, KeepsItsOwnValuesInFewBytes) {
    unsigned seed = 100;
    std::size_t before = SIZE_MAX;
    for (const glm::ivec3& box : {glm::ivec3(32), glm::ivec3(20, 32, 9)}) {
        before = SIZE_MAX;
        for (const Codec codec : kDct) {
            std::vector<std::byte> chunk = chunkOf(2, 15, box, ++seed);
            const std::vector<std::byte> exact = chunk;
            withDctSteps(chunk, 2, true, codec);
            const std::vector<std::byte> code = encoded(chunk, 2, codec);
            EXPECT_EQ(code[0], std::byte{1}) << nameOf(codec) << ": not by coefficients";
            // Blocks that the box cuts are kept as they are.
            EXPECT_LT(code.size() * (box == glm::ivec3(32) ? 3 : 1), encoded(exact, 2, Codec::zstd).size());
            EXPECT_LE(code.size(), before + before / 16);
            before = code.size();
            double squares = 0;
            for (std::size_t n = 0; n < kCount; ++n) {
                std::int16_t a = 0, b = 0;
                std::memcpy(&a, chunk.data() + 2 * n, 2), std::memcpy(&b, exact.data() + 2 * n, 2);
                squares += std::pow(a - b, 2);
            }
            // Of coefficients that vanish the noise is left out at most.
            EXPECT_LT(std::sqrt(squares / kCount), 15 + 0.3 * dctStep(codec));
        }
    }
}

// Whole numbers of a defined size: the same bytes wherever they are made.
TEST(DctCodec, IsTheSameEverywhere) {
    std::vector<std::byte> chunk = chunkOf(2, 0, {32, 32, 30}, 1);
    withDctSteps(chunk, 2, true, Codec::dct32);
    EXPECT_EQ(crc32c(chunk), 458756838u);
    const std::vector<std::int16_t> coefficients = dctCoefficients(chunk, DctNumber::i16, 32, {32, 32, 30});
    EXPECT_EQ(crc32c(std::as_bytes(std::span(coefficients))), 1052322335u);
}

TEST(DctCodec, RefusesWhatIsNoChunk) {
    std::vector<std::byte> chunk = chunkOf(2, 15, {32, 20, 32}, 7);
    withDctSteps(chunk, 2, true, Codec::dct16);
    const std::vector<std::byte> code = encoded(chunk, 2, Codec::dct16);
    const std::span<const std::byte> payload = std::span(code).first(code.size() - kCrcBytes);
    std::vector<std::byte> out(chunk.size());
    for (const std::size_t length : {std::size_t{0}, std::size_t{1}, std::size_t{5}, std::size_t{6},
                                     payload.size() / 2, payload.size() - 1})
        EXPECT_THROW(decodeByDct(payload.first(length), out, "test", Codec::dct16), InputError) << length;
    std::mt19937 random(3);
    out.resize(chunk.size() + 64, std::byte{0x5a});
    for (int n = 0; n < 400; ++n) { // a damaged one is refused or decoded, within its bounds
        std::vector<std::byte> damaged(payload.begin(), payload.end());
        const std::size_t at = n < 64 ? static_cast<std::size_t>(n % 8) : random() % damaged.size();
        damaged[at] ^= static_cast<std::byte>(1u << (random() % 8));
        try {
            decodeByDct(damaged, std::span(out).first(chunk.size()), "test", Codec::dct16);
        } catch (const InputError&) {
        }
        EXPECT_EQ(std::count(out.end() - 64, out.end(), std::byte{0x5a}), 64);
    }
}

TEST(Preview, IsAStoreNearToWhatItShows) {
    const ScratchFolder folder;
    MemoryBudget ram("RAM", "--ram", std::size_t{256} << 20);
    VolumeInfo info;
    info.extentVoxels = {70, 45, 50};
    info.type = ValueType::i16;
    info.patientFromVoxel[3] = glm::dvec4(3, -40, 12, 1);
    FormulaSource source(info, [](const glm::dvec3& p) {
        return 400 * std::sin(0.1 * p.x) * std::cos(0.07 * p.y + 0.2) + 5 * p.z;
    });
    importToStore(source, folder / "a.zarr", ram, {.durable = false});
    const std::uint64_t bytes = writePreview(folder / "a.zarr", Codec::dct32, ram, 2);
    const StoreReader store(folder / "a.zarr", ram), preview(folder / "a.zarr" / kPreviewFolder, ram);
    EXPECT_TRUE(preview.info().lossy);
    EXPECT_FALSE(store.info().lossy);
    EXPECT_EQ(preview.info().extentVoxels, store.info().extentVoxels);
    EXPECT_EQ(preview.info().patientFromVoxel, store.info().patientFromVoxel);
    std::vector<std::byte> a(store.chunkBytes()), b(store.chunkBytes());
    double squares = 0, most = 0;
    for (int k = 0; k < 2; ++k)
        for (int j = 0; j < 2; ++j)
            for (int i = 0; i < 3; ++i) {
                store.readChunk({0, i, j, k}, a), preview.readChunk({0, i, j, k}, b);
                for (std::size_t n = 0; n < kCount; ++n) {
                    const double e = storedValue(store.info().type, a.data() + 2 * n) -
                                     storedValue(store.info().type, b.data() + 2 * n);
                    squares += e * e, most = std::max(most, std::abs(e));
                }
            }
    EXPECT_LT(std::sqrt(squares / (12 * kCount)), 16);
    EXPECT_GT(most, 0);
    EXPECT_LT(bytes, 12 * 2 * kCount / 8);
    writePreview(folder / "a.zarr", Codec::dct8, ram, 1); // in place of the first
}

// Numbers without a sign next to 0 and above 32767; few slices at a time.
TEST(Preview, OfNumbersWithoutASignAreNearToThem) {
    const ScratchFolder folder;
    VolumeInfo info;
    info.extentVoxels = {64, 40, 41};
    info.type = ValueType::u16;
    info.fillStored = 0;
    class Ball : public SlabSource {
      public:
        explicit Ball(const VolumeInfo& info) : info_(info) {}
        const VolumeInfo& info() const override { return info_; }
        std::string describe() const override { return "a ball"; }
        void readSlices(int count, std::span<std::byte> out) override {
            std::size_t n = 0;
            for (int z = next_; z < next_ + count; ++z)
                for (int y = 0; y < info_.extentVoxels.y; ++y)
                    for (int x = 0; x < info_.extentVoxels.x; ++x, ++n) {
                        const glm::dvec3 p = glm::dvec3(x, y, z) - glm::dvec3(30, 20, 20);
                        const std::uint16_t value = glm::dot(p, p) < 150 ? 40000 : 0;
                        std::memcpy(out.data() + 2 * n, &value, 2);
                    }
            next_ += count;
        }

      private:
        VolumeInfo info_;
        int next_ = 0;
    } ball(info);
    MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
    importToStore(ball, folder / "a.zarr", ram, {.durable = false});
    writePreview(folder / "a.zarr", Codec::dct64, ram, 2);
    const StoreReader store(folder / "a.zarr", ram), preview(folder / "a.zarr" / kPreviewFolder, ram);
    std::vector<std::byte> a(store.chunkBytes()), b(store.chunkBytes());
    double most = 0;
    for (int k = 0; k < 2; ++k)
        for (int j = 0; j < 2; ++j)
            for (int i = 0; i < 2; ++i) {
                store.readChunk({0, i, j, k}, a), preview.readChunk({0, i, j, k}, b);
                for (std::size_t n = 0; n < kCount; ++n)
                    most = std::max(most, std::abs(storedValue(ValueType::u16, a.data() + 2 * n) -
                                                   storedValue(ValueType::u16, b.data() + 2 * n)));
            }
    EXPECT_GT(most, 0);
    EXPECT_LT(most, 8000) << "a step of the highest frequency, in few coefficients";
    EXPECT_FALSE(std::filesystem::exists(folder / ".a.zarr.preview"));
}

// The same bytes whatever memory there is, and how many slices are asked for at a time.
TEST(Preview, IsMadeByBandsToo) {
    const ScratchFolder folder;
    VolumeInfo info;
    info.extentVoxels = {200, 190, 40};
    info.type = ValueType::i16;
    const Formula formula = [](const glm::dvec3& p) {
        return 400 * std::sin(0.1 * p.x) * std::cos(0.07 * p.y) + p.z;
    };
    std::vector<std::string> documents;
    for (const std::size_t bytes : {std::size_t{256} << 20, std::size_t{8} << 20}) {
        MemoryBudget ample("RAM", "--ram", std::size_t{256} << 20), ram("RAM", "--ram", bytes);
        FormulaSource source(info, formula);
        importToStore(source, folder / "a.zarr", ample, {.force = true, .durable = false});
        writePreview(folder / "a.zarr", Codec::dct16, ram, 2);
        std::ifstream file(folder / "a.zarr" / kPreviewFolder / "zarr.json");
        documents.emplace_back(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
    }
    EXPECT_NE(documents[0], "");
    EXPECT_EQ(documents[0], documents[1]);
}

TEST(Preview, ShowsTheFinestLevelThatIsSmallEnough) {
    VolumeInfo info;
    info.extentVoxels = glm::ivec3(400);
    EXPECT_EQ(previewLevel(info), 0);
    info.extentVoxels = glm::ivec3(2048);
    EXPECT_EQ(previewLevel(info), 3);
    info.extentVoxels = glm::ivec3(512, 512, 749);
    EXPECT_EQ(previewLevel(info), 1);
    info.type = ValueType::f32;
    EXPECT_NE(whyNoPreview(info), "");
}

} // namespace
} // namespace tessera
