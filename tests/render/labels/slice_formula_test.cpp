// tests/render/labels/slice_formula_test.cpp: labels over slices, written out once more from
// docs/sampling.md, "Labels in slices": sixteen places a pixel, fills by looks, outlines by distances. On a
// lattice of three unlike extents.
#include "render/labels/set_reader.h"
#include "render/labels/slice_labels.h"
#include "tests/support/folders.h"
#include "tests/support/label_tools.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <gtest/gtest.h>
#include <random>
#include <set>
#include <vector>

namespace tessera::test {
namespace {

const glm::ivec3 kSliced(70, 45, 52);

/// Balls of labels that overlap, in millimetres as in voxels.
struct Balls {
    Balls() {
        HeldLayer one(scan, blobs(kSliced, {1, 2, 3, 40}, 5, 24)), more(scan, blobs(kSliced, {7}, 6, 3));
        LabelFile file = fileOf({one, more}, {{1, "one"}, {2, "two"}});
        importLabels(file, scan, store, ram, quickly());
        labels.path = labels.store = store;
        labels.outline = 1;
        labels.hide = {"3"};
        LabelRule tint, plain, wide, filled;
        tint.of = "2", tint.look = LabelLook::tint, tint.opacity = 0.6,
        tint.colour = glm::dvec3(0.2, 0.4, 0.9);
        plain.of = "40", plain.look = LabelLook::plain, plain.outline = 0.5,
        plain.colour = glm::dvec3(1, 1, 0);
        wide.of = "1", wide.outline = 2.5, wide.colour = glm::dvec3(0.9, 0.1, 0.3);
        filled.of = "7", filled.fill = 0.8, filled.outline = 0, filled.colour = glm::dvec3(0.1, 0.8, 0.5);
        labels.each = {tint, plain, wide, filled};
    }
    const ScratchFolder folder;
    const VolumeInfo scan = gridOf(kSliced, glm::dmat4(1));
    const std::filesystem::path store = folder / "l.zarr";
    MemoryBudget ram{"RAM", "--ram", std::size_t{512} << 20};
    Labels labels;
};

struct Look {
    glm::dvec3 colour;
    double fill, outline;
    bool isTint, isPlain;
};
Look lookOf(std::uint32_t value) {
    switch (value) {
    case 1:
        return {{0.9, 0.1, 0.3}, 0.5, 2.5, false, false};
    case 2:
        return {{0.2, 0.4, 0.9}, 0.6, 1, true, false};
    case 7:
        return {{0.1, 0.8, 0.5}, 0.8, 0, false, false};
    default:
        return {{1, 1, 0}, 0.5, 0.5, false, true};
    }
}

TEST(SliceFormulas, FillsAndOutlinesAreTheirs) {
    Balls balls;
    const ReadBack back = readBack(balls.store);
    SliceLabels slices(balls.labels, balls.scan, balls.ram, 2, "labels");
    LabelVolume volume(balls.store, balls.ram);
    BrickCache cache(volume.voxels(), balls.ram, std::size_t{16} << 20, 1);
    // Every set its own number; what is hidden goes below.
    std::vector<std::uint16_t> every;
    for (std::size_t n = 0; n < back.table.sets.size(); ++n)
        every.push_back(static_cast<std::uint16_t>(n));
    const auto shownOf = [&](std::uint16_t number) {
        std::set<std::uint32_t> values;
        for (const std::uint32_t value : back.setOf(number))
            if (value != 3)
                values.insert(value);
        return values;
    };
    SlicePose pose;
    pose.point = {34.2, 22.6, 25.3};
    for (const double mmPerPixel : {0.7, 4.5})
        for (const double scale : {1.0, 1.6}) {
            const glm::ivec2 size(45, 37);
            const PlanePlaces places = planePlaces(pose, mmPerPixel, balls.scan, size);
            const int level = mmPerPixel < 4 ? 0 : 1;
            EXPECT_EQ(SliceLabels::levelOf(places), level);
            // What labels show counts as one set: hidden ones are no border.
            std::vector<std::uint16_t> merged = every;
            for (std::uint16_t& number : merged)
                for (std::uint16_t other = 0; other < every.size(); ++other)
                    if (shownOf(other) == shownOf(number)) {
                        number = other;
                        break;
                    }
            SetReader reader(cache, volume.voxels().info(), level, LabelBorders::smooth, merged);
            constexpr int kAround = 20; // pixels: more than any outline reaches
            const glm::ivec2 raster = 4 * (size + 2 * kAround);
            std::vector<std::set<std::uint32_t>> at;
            for (int y = 0; y < raster.y; ++y)
                for (int x = 0; x < raster.x; ++x)
                    at.push_back(shownOf(
                        reader.at(*places.at(glm::dvec2(-kAround) + (glm::dvec2(x, y) + 0.5) / 4.0))));
            const auto setAt = [&](int x, int y) -> const std::set<std::uint32_t>& {
                return at[static_cast<std::size_t>(y * raster.x + x)];
            };
            std::mt19937 random(4);
            std::vector<glm::vec4> pixels;
            for (int n = 0; n < size.x * size.y; ++n) {
                const bool isEmpty = n % size.x >= 32 && n / size.x >= 32 && mmPerPixel < 4;
                const auto any = [&] { return static_cast<float>(random() % 1000) / 1000; };
                pixels.push_back(isEmpty ? glm::vec4(0)
                                         : glm::vec4(any(), any(), any(), 0.3f + 0.7f * any()));
            }
            const std::vector<glm::vec4> before = pixels;
            std::vector<float> shares;
            for (std::size_t n = 0; n < pixels.size(); ++n)
                shares.push_back(static_cast<float>(random() % 1000) / 1000);
            const bool hasShares = scale > 1;
            const SliceLabels::Drawn drawn =
                slices.layOver(pixels, places, scale, hasShares ? &shares : nullptr);
            EXPECT_EQ(drawn.level, level);
            std::set<std::uint32_t> met;
            std::size_t outlined = 0;
            for (int py = 0; py < size.y; ++py)
                for (int px = 0; px < size.x; ++px) {
                    const std::size_t n = static_cast<std::size_t>(py * size.x + px);
                    if (px >= 32 && py >= 32 && mmPerPixel < 4) {
                        ASSERT_EQ(pixels[n], glm::vec4(0)) << "a tile that shows nothing";
                        continue;
                    }
                    glm::dvec3 keep(0), add(0);
                    double cover = 0;
                    for (int part = 0; part < 16; ++part) {
                        const int x = 4 * (px + kAround) + part % 4, y = 4 * (py + kAround) + part / 4;
                        const std::set<std::uint32_t>& mine = setAt(x, y);
                        glm::dvec3 outline(0), ownKeep(0), ownAdd(0);
                        double share = 0, ownCover = 0;
                        for (const std::uint32_t value : mine) {
                            const Look look = lookOf(value);
                            met.insert(value);
                            ownKeep += (look.isPlain ? 1.0 : 1 - look.fill) / double(mine.size());
                            if (look.isTint)
                                ownKeep += look.fill * look.colour / double(mine.size());
                            if (!look.isTint && !look.isPlain) {
                                ownAdd += look.fill * look.colour / double(mine.size());
                                ownCover += look.fill / double(mine.size());
                            }
                            const double width = 4 * look.outline * scale;
                            if (width == 0)
                                continue;
                            double nearest = 1e9;
                            const int far = static_cast<int>(width) + 2;
                            for (int v = y - far; v <= y + far; ++v)
                                for (int u = x - far; u <= x + far; ++u)
                                    if (!setAt(u, v).contains(value))
                                        nearest = std::min(nearest, std::hypot(u - x, v - y));
                            const double band = std::clamp(width + 0.3 + 0.5 - nearest, 0.0, 1.0);
                            outline += band * look.colour, share += band;
                        }
                        if (mine.empty())
                            ownKeep = glm::dvec3(1);
                        const double over = std::min(share, 1.0);
                        outlined += over > 0;
                        keep += (1 - over) * ownKeep / 16.0;
                        add += ((1 - over) * ownAdd + (share > 0 ? over / share : 0) * outline) / 16.0;
                        cover += ((1 - over) * ownCover + over) / 16;
                    }
                    const glm::dvec4 was(before[n]);
                    const double left = hasShares ? double{shares[n]} : 1;
                    const double alpha = hasShares ? was.a * (cover + (1 - cover) * left) : was.a;
                    for (int c = 0; c < 3; ++c)
                        ASSERT_NEAR(pixels[n][c], left * keep[c] * was[c] + was.a * add[c], 2e-5)
                            << mmPerPixel << ", " << scale << ": " << px << "," << py;
                    ASSERT_NEAR(pixels[n].a, alpha, 1e-5);
                    if (n % 97 == 0 && !hasShares) {
                        const LabelsOver one = slices.overPixel({px, py}, places);
                        for (int c = 0; c < 3; ++c)
                            ASSERT_NEAR(one(before[n])[c], pixels[n][c], 1e-6);
                        ASSERT_NEAR(one.cover, cover, 1e-5);
                    }
                }
            EXPECT_TRUE(std::ranges::equal(drawn.values, met));
            EXPECT_GT(met.size(), 2u);
            EXPECT_GT(outlined, 200u);
        }
    EXPECT_EQ(slices.shownLabels(), 4u);
}

// A level whose samples are at most half as wide as a pixel, and no coarser than the fourth.
TEST(SliceFormulas, LevelsAreThoseThatPixelsMeet) {
    const VolumeInfo info = gridOf({640, 640, 640}, glm::dmat4(1));
    SlicePose pose;
    pose.point = {320, 320, 320};
    for (const auto& [mm, level] : {std::pair(0.1, 0),
                                    {1.0, 0},
                                    {3.99, 0},
                                    {4.0, 1},
                                    {7.99, 1},
                                    {8.0, 2},
                                    {16.0, 3},
                                    {31.9, 3},
                                    {32.0, 4},
                                    {500.0, 4}})
        EXPECT_EQ(SliceLabels::levelOf(planePlaces(pose, mm, info, {10, 10})), level) << mm;
}

} // namespace
} // namespace tessera::test
