// tests/bricking/import/resume_files_test.cpp: imports of files in parts, each part by another process: what
// voxels tell, such as numbers that are none and labels, does not depend on who read which of them.
#include "bricking/import/importer.h"
#include "bricking/import/open_source.h"
#include "bricking/store/work_folder.h"
#include "core/base/error.h"
#include "tests/support/bricking_store_tools.h"
#include "tests/support/dicom_writer.h"
#include "tests/support/import_test_tools.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <functional>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace tessera {
namespace {

using namespace test;
using testing::Contains;
using testing::HasSubstr;

std::map<std::string, std::string> textsIn(const fs::path& folder) {
    std::map<std::string, std::string> texts;
    for (const auto& entry : fs::recursive_directory_iterator(folder))
        if (entry.is_regular_file())
            texts[entry.path().lexically_relative(folder)] = fileText(entry.path());
    return texts;
}

/// Breaks off before a slice, as a process that is killed.
class BrokenOff final : public SlabSource {
  public:
    BrokenOff(std::unique_ptr<SlabSource> source, int end) : source_(std::move(source)), end_(end) {}
    const VolumeInfo& info() const override { return source_->info(); }
    std::string describe() const override { return source_->describe(); }
    std::vector<std::string> notes() const override { return source_->notes(); }
    VoxelTally takeTally() override { return source_->takeTally(); }
    bool seek(int z) override {
        const bool can = source_->seek(z);
        next_ = can ? z : next_;
        return can;
    }
    void readSlices(int count, std::span<std::byte> out) override {
        if ((next_ += count) > end_)
            throw Error("test: broken off");
        source_->readSlices(count, out);
    }

  private:
    std::unique_ptr<SlabSource> source_;
    int end_, next_ = 0;
};

class ResumeFiles : public ::testing::Test {
  protected:
    static constexpr const char* kKey = "0123456789abcdef0123456789abcdef";
    /// @param reopen  given: the import is shared
    ImportReport import(std::unique_ptr<SlabSource> source, const std::string& store, int partSlices,
                        const std::function<std::unique_ptr<SlabSource>()>& reopen = {}) {
        MemoryBudget ram("RAM", "--ram", kPlenty);
        ImportOptions options;
        options.durable = false;
        options.threads = 1;
        options.key = kKey;
        options.shared = reopen != nullptr;
        options.reopen = reopen;
        options.partSlices = partSlices;
        return importToStore(*source, scratch_ / store, ram, options);
    }
    /// In one part, in parts of one process, and with a process for every part: the same.
    /// @return what was said
    std::vector<std::string> expectTheSame(const fs::path& path, const SourceOptions& options = {}) {
        SCOPED_TRACE(path.filename().string());
        constexpr int kSlices = 32;
        const ImportReport whole = import(openSource(path, options), "whole.zarr", kPartSlices);
        EXPECT_EQ(whole.parts, 1);
        const ImportReport parts = import(openSource(path, options), "parts.zarr", kSlices);
        EXPECT_GT(parts.parts, 2);
        for (int part = 0; part + 1 < parts.parts; ++part)
            EXPECT_THROW(import(std::make_unique<BrokenOff>(openSource(path, options), (part + 1) * kSlices),
                                "resumed.zarr", kSlices),
                         Error);
        const ImportReport resumed = import(openSource(path, options), "resumed.zarr", kSlices);
        EXPECT_EQ(resumed.partsFound, parts.parts - 1);
        // A process that makes the first part last, after another one gave it up.
        ImportReport backwards;
        {
            auto other =
                std::make_unique<WorkFolder>(scratch_ / "backwards.zarr", WorkFolder::Use{kKey, true});
            std::unique_ptr<Claim> claim = other->claims().claim(WorkFolder::nameOfPart(0));
            const fs::path last = other->part(parts.parts - 1);
            std::jthread gaveUp([&] {
                while (!fs::exists(last))
                    std::this_thread::sleep_for(std::chrono::milliseconds(1));
                claim.reset();
                other.reset();
            });
            backwards = import(openSource(path, options), "backwards.zarr", kSlices,
                               [&] { return openSource(path, options); });
        }
        EXPECT_EQ(backwards.notes, whole.notes);
        const auto expected = textsIn(scratch_ / "whole.zarr");
        EXPECT_TRUE(textsIn(scratch_ / "parts.zarr") == expected);
        EXPECT_TRUE(textsIn(scratch_ / "resumed.zarr") == expected);
        EXPECT_TRUE(textsIn(scratch_ / "backwards.zarr") == expected);
        EXPECT_EQ(parts.notes, whole.notes);
        EXPECT_EQ(resumed.notes, whole.notes);
        EXPECT_EQ(resumed.chunksWritten, whole.chunksWritten);
        for (const char* store : {"whole.zarr", "parts.zarr", "resumed.zarr", "backwards.zarr"})
            fs::remove_all(scratch_ / store);
        info_ = resumed.info;
        return resumed.notes;
    }
    /// As .nii, which is read at any place, and as .nii.gz, which is read on.
    std::vector<std::string> expectTheSameNifti(NiftiImage image) {
        constexpr std::array<double, 12> kForward = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0},
                                         kDown = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, 0},
                                         kSagittal = {0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0};
        std::vector<std::string> notes;
        for (const auto& axes : {kForward, kDown, kSagittal})
            for (const bool isPacked : {false, true}) {
                image.srow = axes;
                const fs::path path = scratch_ / (isPacked ? "a.nii.gz" : "a.nii");
                writeFile(path, isPacked ? gzip(niftiBytes(image)) : niftiBytes(image));
                notes = expectTheSame(path);
            }
        return notes;
    }
    static constexpr int kAcross = 70; // along every axis: three parts however they lie
    template <class T, class Value> static NiftiImage imageOf(std::int16_t datatype, const Value& value) {
        NiftiImage image;
        image.extent = {kAcross, kAcross, kAcross};
        image.datatype = datatype;
        std::vector<T> voxels;
        for (int z = 0; z < kAcross; ++z)
            for (int y = 0; y < kAcross; ++y)
                for (int x = 0; x < kAcross; ++x)
                    voxels.push_back(value(x, y, z));
        image.voxels = voxelBytes<T>(voxels);
        return image;
    }

    const ScratchFolder scratch_;
    VolumeInfo info_;
};

TEST_F(ResumeFiles, VoxelsWithoutANumber) {
    const float none = std::numeric_limits<float>::quiet_NaN();
    for (const int from : {0, 40, 65}) { // of one part alone, and of several
        expectTheSameNifti(imageOf<float>(16, [&](int x, int y, int z) {
            return std::min({x, y, z}) >= from && (x + y + z) % 5 == 0
                       ? none
                       : static_cast<float>(x * y - 3 * z) - 100;
        }));
        EXPECT_GT(info_.nonFiniteVoxels, 0u);
        EXPECT_EQ(info_.absentStored, -100 - 3 * (kAcross - 1));
    }
}

TEST_F(ResumeFiles, NumbersThatChange) {
    const auto notes = expectTheSameNifti(
        imageOf<std::int64_t>(1024, [](int x, int y, int z) { return (std::int64_t{1} << 24) + x + y + z; }));
    EXPECT_THAT(notes, Contains(HasSubstr("whole numbers beyond 2^24")));
    expectTheSameNifti(imageOf<double>(64, [](int x, int y, int z) { return x == y ? 1e300 : z; }));
    EXPECT_EQ(info_.clampedVoxels, 1u * kAcross * kAcross);
}

TEST_F(ResumeFiles, Labels) {
    const auto labels = [](int most) {
        return imageOf<std::uint16_t>(512, [most](int x, int y, int z) {
            return static_cast<std::uint16_t>(x > 4 && y > 4 ? 1 + (x / 8 + 9 * (y / 8) + z / 8) % most : 0);
        });
    };
    EXPECT_THAT(expectTheSameNifti(labels(9)), Contains(HasSubstr("10 whole values, 0 to 9")));
    EXPECT_THAT(info_.remarks, Contains(HasSubstr("looks like a label map")));
    // 300 of them, though no part has so many
    const auto many = imageOf<std::uint16_t>(512, [](int x, int y, int z) {
        return static_cast<std::uint16_t>(x / 10 + 7 * (y / 10) + 49 * (z / 10));
    });
    expectTheSameNifti(many);
    EXPECT_THAT(info_.remarks, testing::Each(testing::Not(HasSubstr("looks like a label map"))));
}

// A slice of the file shows in several of the volume, in other parts too: it is counted once.
TEST_F(ResumeFiles, InterpolatedSlices) {
    fs::create_directory(scratch_ / "series");
    double z = 0;
    for (int i = 0; i < 70; ++i, z += i % 9 == 0 ? 4 : 2) {
        DicomImage image;
        image.position = glm::dvec3(0, 0, z);
        image.slope = "3";
        for (int at = 0; at < image.columns * image.rows; ++at)
            image.pixels.push_back(static_cast<std::uint16_t>(7000 + 800 * at));
        writeDicom(scratch_ / "series" / std::to_string(i), image);
    }
    SourceOptions options;
    options.resampleZ = true;
    expectTheSame(scratch_ / "series", options);
    EXPECT_GT(info_.extentVoxels.z, 70);
    EXPECT_EQ(info_.clampedVoxels % 70, 0u);
    EXPECT_GT(info_.clampedVoxels, 0u);
}

} // namespace
} // namespace tessera
