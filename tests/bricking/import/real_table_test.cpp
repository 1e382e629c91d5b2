// tests/bricking/import/real_table_test.cpp: the table under a patient in a real CT, as it is, noisy, thick,
// narrow and prone, against what others labelled as the patient's organs, bones and muscles.
#include "bricking/analysis/body/table_mask.h"
#include "tests/support/import_test_tools.h"

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <functional>
#include <random>
#include <vector>

namespace tessera::test {
namespace {

/// Voxels that are held, level 0 alone.
class HeldChunks final : public ChunkSource {
  public:
    HeldChunks(const VolumeInfo& info, std::vector<float> hu) : info_(info), hu_(std::move(hu)) {}
    const VolumeInfo& info() const override { return info_; }
    void readChunk(const ChunkKey& key, std::span<std::byte> out) const override {
        const glm::ivec3 first = glm::ivec3(key.i, key.j, key.k) * kChunkExtent;
        const glm::ivec3 count = glm::min(info_.extentVoxels - first, glm::ivec3(kChunkExtent));
        auto* const to = reinterpret_cast<float*>(out.data());
        for (int z = 0; z < count.z; ++z)
            for (int y = 0; y < count.y; ++y)
                std::copy_n(hu_.data() + linearIndex(first + glm::ivec3(0, y, z), info_.extentVoxels),
                            count.x, to + linearIndex({0, y, z}, glm::ivec3(kChunkExtent)));
    }

  private:
    VolumeInfo info_;
    std::vector<float> hu_;
};

struct Scan {
    VolumeInfo info;
    std::vector<float> hu;
    std::vector<std::uint8_t> patient;
};

TEST(RealTable, HidesNothingOfWhatIsLabelled) {
    if (testData().empty())
        GTEST_SKIP() << "no shared test data (TESSERA_TEST_DATA or ../shared/data)";
    const std::filesystem::path folder = testData() / "labels/totalsegmentator";
    const auto source = openSource(folder / "example_ct.nii.gz", {});
    Scan plain{source->info(), readAll<float>(*source), {}};
    ASSERT_EQ(plain.info.type, ValueType::f32);
    plain.info.unit = "HU";
    plain.patient.resize(plain.hu.size());
    for (const auto& entry : std::filesystem::directory_iterator(folder / "masks")) {
        const auto mask = openSource(entry.path(), {});
        ASSERT_EQ(mask->info().extentVoxels, plain.info.extentVoxels) << entry.path();
        const std::vector<float> voxels = readAll<float>(*mask);
        for (std::size_t i = 0; i < voxels.size(); ++i)
            plain.patient[i] = plain.patient[i] || voxels[i] > 0;
    }
    ASSERT_GT(std::count(plain.patient.begin(), plain.patient.end(), 1), 200000);

    /// Of a scan with other extents: voxel (x, y, z) is that of the plain one at from(x, y, z).
    const auto taken = [&](const glm::ivec3& extent,
                           const std::function<glm::ivec3(const glm::ivec3&)>& from) {
        Scan scan;
        scan.info = plain.info;
        scan.info.extentVoxels = extent;
        for (std::size_t i = 0; i < cellCount(extent); ++i) {
            const std::size_t at = linearIndex(from(gridPosition(i, extent)), plain.info.extentVoxels);
            scan.hu.push_back(plain.hu[at]);
            scan.patient.push_back(plain.patient[at]);
        }
        return scan;
    };
    const glm::ivec3 e = plain.info.extentVoxels;
    std::vector<std::pair<const char*, Scan>> scans = {
        {"plain", plain},
        {"prone", taken(e, [&](const glm::ivec3& p) { return glm::ivec3(p.x, e.y - 1 - p.y, p.z); })},
        {"on the side",
         taken({e.y, e.x, e.z}, [](const glm::ivec3& p) { return glm::ivec3(p.y, p.x, p.z); })},
        {"narrow", taken({e.x - 50, e.y, e.z}, [](const glm::ivec3& p) { return p + glm::ivec3(25, 0, 0); })},
        {"thick",
         taken({e.x, e.y, e.z / 4}, [](const glm::ivec3& p) { return glm::ivec3(p.x, p.y, 4 * p.z); })},
        {"short", taken({e.x, e.y, 30}, [](const glm::ivec3& p) { return p + glm::ivec3(0, 0, 60); })},
        {"noisy", plain},
        {"very noisy", plain},
    };
    scans[4].second.info.patientFromVoxel[2] *= 4.0;
    for (const auto& [at, sigma] : {std::pair<std::size_t, double>{6, 60}, {7, 200}}) {
        std::mt19937 random(3);
        std::normal_distribution<double> noise(0, sigma);
        for (float& hu : scans[at].second.hu)
            hu += static_cast<float>(noise(random));
    }
    for (auto& [name, scan] : scans) {
        SCOPED_TRACE(name);
        MemoryBudget ram("RAM", "--ram", std::size_t{256} << 20);
        const FoundTable found = findTable(HeldChunks(scan.info, scan.hu), ram, 2);
        if (std::strcmp(name, "very noisy") != 0) {
            EXPECT_TRUE(found.mask) << found.why;
        }
        if (!found.mask)
            continue;
        std::vector<float> shares(scan.hu.size());
        found.mask->read(0, glm::ivec3(0), scan.info.extentVoxels, shares);
        std::size_t lost = 0, hidden = 0;
        for (std::size_t i = 0; i < shares.size(); ++i) {
            lost += scan.patient[i] && shares[i] > 0;
            hidden += scan.hu[i] > -300 && shares[i] > 0.5f;
        }
        EXPECT_EQ(lost, 0u);
        EXPECT_GT(hidden, std::strcmp(name, "narrow") == 0 ? 100u : 1000u); // of some table
    }
}

} // namespace
} // namespace tessera::test
