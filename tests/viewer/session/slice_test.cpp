// tests/viewer/session/slice_test.cpp: planes beside the volume: their orientation on the screen by
// radiological convention, and their values against trilinear interpolation of the source's voxels, written
// out here. Coarse pictures come before fine ones, and the last request counts.
#include "bricking/cache/brick_cache.h"
#include "bricking/import/importer.h"
#include "bricking/store/store_reader.h"
#include "core/base/program_folders.h"
#include "tests/support/formula_source.h"
#include "viewer/session/slice_thread.h"

#include <atomic>
#include <chrono>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <glm/vector_relational.hpp>
#include <gtest/gtest.h>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace tessera::test {
namespace {

using namespace std::chrono_literals;

/// Noise, so that a wrong neighbour shows. Of a voxel.
/// One value a voxel.
double noiseAt(const glm::dvec3& p) {
    const int x = static_cast<int>(p.x), y = static_cast<int>(p.y), z = static_cast<int>(p.z);
    std::uint32_t h = static_cast<std::uint32_t>(x * 73856093) ^ static_cast<std::uint32_t>(y * 19349663) ^
                      static_cast<std::uint32_t>(z * 83492791);
    h = (h ^ h >> 13) * 1274126177u;
    return static_cast<double>((h ^ h >> 16) % 2000) - 1000;
}

VolumeInfo sheared() {
    VolumeInfo info;
    info.extentVoxels = {70, 45, 90};
    info.type = ValueType::i16;
    info.rescaleSlope = 0.5;
    info.rescaleIntercept = -100;
    info.unit = "HU";
    info.patientFromVoxel = glm::dmat4(0.8, 0, 0.1, 0, 0, 1.1, 0, 0, 0, 0.3, 2, 0, -50, 20, 300, 1);
    return info;
}

struct Volume {
    explicit Volume(const VolumeInfo& info) : store(make(info), ram) {}
    std::filesystem::path make(const VolumeInfo& info) {
        FormulaSource source(info, noiseAt);
        importToStore(source, folder / "v.zarr", ram, {});
        return folder / "v.zarr";
    }
    ScratchFolder folder;
    MemoryBudget ram{"RAM", "--ram", std::size_t{256} << 20};
    StoreReader store;
};

TEST(SlicePlanes, LieAsRadiologyHasThem) {
    const VolumeInfo info = sheared();
    const glm::dvec3 place(-20, 40, 390);
    const glm::ivec2 size(200, 150);
    const auto shift = [&](Orientation o, const glm::dvec3& mm) {
        const SliceFrame f = sliceFrame(info, o, place, size);
        return f.pictureFromPatient(place + mm) - f.pictureFromPatient(place);
    };
    // To the patient's left, to the back, up (LPS).
    const glm::dvec3 left(5, 0, 0), back(0, 5, 0), up(0, 0, 5);
    EXPECT_GT(shift(Orientation::axial, left).x, 1);
    EXPECT_GT(shift(Orientation::axial, back).y, 1);
    EXPECT_NEAR(glm::length(shift(Orientation::axial, up)), 0, 1e-9);
    EXPECT_GT(shift(Orientation::coronal, left).x, 1);
    EXPECT_LT(shift(Orientation::coronal, up).y, -1);
    EXPECT_GT(shift(Orientation::sagittal, back).x, 1);
    EXPECT_LT(shift(Orientation::sagittal, up).y, -1);
}

TEST(SlicePlanes, HoldTheWholePlaneAndTheirPlace) {
    const VolumeInfo info = sheared();
    for (const Orientation o : {Orientation::axial, Orientation::coronal, Orientation::sagittal})
        for (const double zoom : {1.0, 3.0}) {
            const glm::dvec3 place(info.patientFromVoxel * glm::dvec4(12, 30, 71, 1));
            const SliceFrame f = sliceFrame(info, o, place, {160, 240}, zoom);
            const glm::dvec2 at = f.pictureFromPatient(place);
            EXPECT_LT(glm::length(f.patientFromPicture(at) - place), 1e-9) << "the plane goes through it";
            EXPECT_TRUE(at.x > 0 && at.y > 0 && at.x < 160 && at.y < 240);
            int outside = 0;
            for (int corner = 0; corner < 8; ++corner) {
                const glm::dvec3 voxel =
                    glm::dvec3(info.extentVoxels) * glm::dvec3(corner & 1, corner >> 1 & 1, corner >> 2);
                const glm::dvec2 c =
                    f.pictureFromPatient(glm::dvec3(info.patientFromVoxel * glm::dvec4(voxel, 1)));
                outside += c.x < -1e-9 || c.y < -1e-9 || c.x > 160 + 1e-9 || c.y > 240 + 1e-9;
            }
            EXPECT_EQ(outside > 0, zoom > 1);
        }
}

/// All of a plane is as large as the picture lets it be, whatever the picture's proportion.
TEST(SlicePlanes, FillThePicture) {
    const VolumeInfo info = sheared();
    for (const Orientation o : {Orientation::axial, Orientation::coronal, Orientation::sagittal})
        for (const glm::ivec2& size : {glm::ivec2(160, 240), {240, 160}, {400, 60}, {60, 400}, {100, 100}}) {
            const glm::dvec3 middle(info.patientFromVoxel *
                                    glm::dvec4(0.5 * glm::dvec3(info.extentVoxels), 1));
            const SliceFrame f = sliceFrame(info, o, middle, size, 1);
            glm::dvec2 least(1e9), most(-1e9);
            for (int corner = 0; corner < 8; ++corner) {
                const glm::dvec3 voxel =
                    glm::dvec3(info.extentVoxels) * glm::dvec3(corner & 1, corner >> 1 & 1, corner >> 2);
                const glm::dvec2 c =
                    f.pictureFromPatient(glm::dvec3(info.patientFromVoxel * glm::dvec4(voxel, 1)));
                least = glm::min(least, c), most = glm::max(most, c);
            }
            const glm::dvec2 fills = (most - least) / glm::dvec2(size);
            EXPECT_NEAR(std::max(fills.x, fills.y), 1, 1e-9) << size.x << " x " << size.y;
        }
}

TEST(SlicePlanes, AreTrilinearInterpolationOfTheVoxels) {
    const VolumeInfo info = sheared();
    Volume volume(info);
    BrickCache cache(volume.store, volume.ram, std::size_t{16} << 20, 2);
    const glm::dmat4 voxelFromPatient = glm::inverse(info.patientFromVoxel);
    for (const Orientation o : {Orientation::axial, Orientation::coronal, Orientation::sagittal}) {
        const glm::dvec3 place(info.patientFromVoxel * glm::dvec4(33.3, 21.7, 52.1, 1));
        const SliceFrame frame = sliceFrame(info, o, place, {180, 170}, 1.3);
        ASSERT_EQ(sliceLevel(info, frame, 1000), 0);
        const std::vector<float> values = sliceValues(cache, info, frame, 0, 2);
        int inside = 0;
        for (int y = 0; y < 170; ++y)
            for (int x = 0; x < 180; ++x) {
                const glm::dvec3 voxel(voxelFromPatient *
                                       glm::dvec4(frame.patientFromPicture({x + 0.5, y + 0.5}), 1));
                const float value = values[static_cast<std::size_t>(y * 180 + x)];
                const bool in = glm::all(glm::greaterThanEqual(voxel, glm::dvec3(0))) &&
                                glm::all(glm::lessThanEqual(voxel, glm::dvec3(info.extentVoxels)));
                ASSERT_EQ(!std::isnan(value), in) << x << " " << y;
                if (in) {
                    ASSERT_NEAR(value, trilinearOf(info, noiseAt, voxel), 1e-5 * 1000) << x << " " << y;
                    ++inside;
                }
            }
        EXPECT_GT(inside, 5000);
    }
}

TEST(SlicePlanes, TakeTheLevelThatAPixelShows) {
    VolumeInfo info = sheared();
    info.extentVoxels = {2048, 2048, 2048};
    info.patientFromVoxel = glm::dmat4(1);
    const auto level = [&](int pixels, std::size_t chunks) {
        return sliceLevel(info, sliceFrame(info, Orientation::axial, {1024, 1024, 1024}, glm::ivec2(pixels)),
                          chunks);
    };
    EXPECT_EQ(level(2048, 100000), 0);
    EXPECT_EQ(level(1024, 100000), 1);
    EXPECT_EQ(level(300, 100000), 2);
    // 64 x 64 chunks of level 0 do not fit; those of level 2, with their margins, do.
    EXPECT_GE(level(2048, 1000), 2);
    EXPECT_LT(level(2048, 1000), kLevelCount);
    EXPECT_EQ(level(2048, 1), kLevelCount - 1);
}

TEST(SlicePlanes, WindowsAreLinear) {
    const GreyWindow window{50, 400};
    const auto pixels = greyPixels({-200, -150, 50, 250, 900, std::nanf("")}, window);
    EXPECT_EQ(pixels[0] & 255, 0u);
    EXPECT_EQ(pixels[1] & 255, 0u);
    EXPECT_EQ(pixels[2] & 255, 128u);
    EXPECT_EQ(pixels[3] & 255, 255u);
    EXPECT_EQ(pixels[4], 0xFFFFFFFFu);
    EXPECT_EQ(pixels[5], 0xFF000000u);
}

TEST(SliceThread, ComesToTheLastWish) {
    const VolumeInfo info = sheared();
    Volume volume(info);
    MemoryBudget ram("RAM", "--ram", std::size_t{32} << 20);
    std::atomic<int> news = 0;
    SliceThread thread(volume.store, ram, 2, [&] { ++news; });
    SliceWish wish;
    wish.window = {0, 1000};
    wish.sizes = {glm::ivec2(90, 80), glm::ivec2(0), glm::ivec2(60, 100)};
    for (int n = 0; n < 30; ++n) {
        wish.placeMm = glm::dvec3(info.patientFromVoxel * glm::dvec4(10.5 + n, 22, 30 + n, 1));
        thread.show(wish);
    }
    const auto end = std::chrono::steady_clock::now() + 30s;
    while ((!thread.shown() || !(thread.shown()->wish == wish) || !thread.shown()->fine) &&
           std::chrono::steady_clock::now() < end)
        std::this_thread::sleep_for(5ms);
    const auto shown = thread.shown();
    ASSERT_TRUE(shown && shown->wish == wish && shown->fine);
    EXPECT_GT(news, 0);
    EXPECT_TRUE(shown->planes[1].display.empty()) << "not wanted";
    EXPECT_EQ(shown->planes[0].display.size(), 90u * 80);
    EXPECT_NEAR(shown->value, trilinearOf(info, noiseAt, {39.5, 22, 59}), 1e-9);
    const SliceFrame frame = sliceFrame(info, Orientation::sagittal, wish.placeMm, wish.sizes[2]);
    BrickCache cache(volume.store, volume.ram, std::size_t{16} << 20, 2);
    EXPECT_EQ(shown->planes[2].display,
              greyPixels(sliceValues(cache, info, frame, shown->planes[2].level, 1), wish.window));
    const int before = news;
    thread.show(wish);
    std::this_thread::sleep_for(100ms);
    EXPECT_EQ(news, before) << "the same again is drawn again";
    EXPECT_LE(ram.usedBytes(), ram.limitBytes());
    EXPECT_EQ(thread.takeProblem(), "");
}

TEST(SliceThread, HasNoValueOutsideTheVolume) {
    const VolumeInfo info = sheared();
    Volume volume(info);
    MemoryBudget ram("RAM", "--ram", std::size_t{32} << 20);
    SliceThread thread(volume.store, ram, 2, [] {});
    SliceWish wish;
    wish.window = {0, 1000};
    wish.sizes = {glm::ivec2(30, 30), glm::ivec2(0), glm::ivec2(0)};
    for (const double x : {-0.5, 70.5, 35.0}) {
        wish.placeMm = glm::dvec3(info.patientFromVoxel * glm::dvec4(x, 22, 30, 1));
        thread.show(wish);
        const auto end = std::chrono::steady_clock::now() + 30s;
        while ((!thread.shown() || !(thread.shown()->wish == wish)) && std::chrono::steady_clock::now() < end)
            std::this_thread::sleep_for(2ms);
        ASSERT_TRUE(thread.shown() && thread.shown()->wish == wish);
        EXPECT_EQ(std::isnan(thread.shown()->value), x != 35) << x;
    }
}

/// Whoever goes back to what is shown while another place is drawn sees what was asked for last.
TEST(SliceThread, GoesBack) {
    const VolumeInfo info = sheared();
    Volume volume(info);
    MemoryBudget ram("RAM", "--ram", std::size_t{32} << 20);
    std::atomic<int> news = 0;
    SliceThread thread(volume.store, ram, 2, [&] { ++news; });
    SliceWish first;
    first.window = {0, 1000};
    first.sizes = {glm::ivec2(200, 160), glm::ivec2(200, 180), glm::ivec2(160, 200)};
    first.placeMm = glm::dvec3(info.patientFromVoxel * glm::dvec4(10.5, 22, 30, 1));
    SliceWish second = first;
    second.placeMm = glm::dvec3(info.patientFromVoxel * glm::dvec4(30.5, 22, 59, 1));
    const auto comesTo = [&](const SliceWish& wish) {
        const auto end = std::chrono::steady_clock::now() + 30s;
        for (;;) {
            const auto shown = thread.shown();
            if (shown && shown->wish == wish && shown->fine)
                return true;
            if (std::chrono::steady_clock::now() > end)
                return false;
            std::this_thread::sleep_for(1ms);
        }
    };
    for (int n = 0; n < 12; ++n) {
        thread.show(first);
        ASSERT_TRUE(comesTo(first));
        thread.show(second);
        std::this_thread::sleep_for(std::chrono::microseconds(300 * n)); // it waits, or it is being drawn
        thread.show(first);
        int before = -1;
        while (std::exchange(before, news) != news || before == -1) // until nothing more comes
            std::this_thread::sleep_for(60ms);
        EXPECT_TRUE(thread.shown()->wish == first) << n;
    }
}

/// The first planes of a volume are two levels coarser than the fine ones after them, at most level 5.
TEST(SliceThread, ComesCoarselyFirst) {
    const VolumeInfo info = sheared();
    Volume volume(info);
    MemoryBudget ram("RAM", "--ram", std::size_t{32} << 20);
    for (const int edge : {300, 40, 2}) {
        std::vector<std::shared_ptr<const ShownSlices>> all;
        std::atomic<SliceThread*> thread = nullptr;
        std::mutex mutex;
        SliceThread drawing(volume.store, ram, 2, [&] {
            const std::lock_guard lock(mutex);
            all.push_back(thread.load()->shown());
        });
        thread = &drawing;
        SliceWish wish;
        wish.window = {0, 1000};
        wish.placeMm = glm::dvec3(info.patientFromVoxel * glm::dvec4(35, 22, 45, 1));
        wish.sizes = {glm::ivec2(edge), glm::ivec2(edge), glm::ivec2(edge)};
        drawing.show(wish);
        const auto end = std::chrono::steady_clock::now() + 30s;
        const auto count = [&] {
            const std::lock_guard lock(mutex);
            return all.size();
        };
        while (count() < 2 && std::chrono::steady_clock::now() < end)
            std::this_thread::sleep_for(2ms);
        ASSERT_EQ(count(), 2u);
        const std::lock_guard lock(mutex);
        EXPECT_FALSE(all[0]->fine);
        EXPECT_TRUE(all[1]->fine);
        for (std::size_t n = 0; n < 3; ++n) {
            EXPECT_EQ(all[0]->planes[n].level, std::min(all[1]->planes[n].level + 2, kLevelCount - 1));
            EXPECT_EQ(all[0]->planes[n].display.size(), static_cast<std::size_t>(edge * edge));
            const SliceFrame frame =
                sliceFrame(info, static_cast<Orientation>(n), wish.placeMm, wish.sizes[n]);
            EXPECT_EQ(all[1]->planes[n].frame.mmPerPixel, frame.mmPerPixel);
            EXPECT_EQ(all[1]->planes[n].frame.pose.normal, frame.pose.normal);
        }
    }
}

} // namespace
} // namespace tessera::test
