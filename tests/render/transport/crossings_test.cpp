// Isosurfaces on ways of light: pieces that are passed over hold no crossing.
#include "render/transport/surface_crossings.h"

#include <gtest/gtest.h>
#include <random>

namespace tessera {
namespace {

TEST(CrossingsOfWays, AreOnlyWhereValuesMayCross) {
    std::mt19937 random(4);
    std::uniform_real_distribution<float> value(0, 1);
    int crossed = 0, beyondAll = 0, passedOver = 0;
    for (int n = 0; n < 200000; ++n) {
        const float v[4] = {value(random), value(random), value(random), value(random)};
        const std::vector<float> isovalues = {2.5f * value(random) - 0.75f};
        int crossings = 0;
        forEachCrossing<float>(v[0], v[1], v[2], v[3], isovalues, [&](float, std::size_t) { ++crossings; });
        const bool may = mayCross(isovalues, v[0], v[1], v[2], v[3]);
        if (crossings > 0) {
            ASSERT_TRUE(may) << isovalues[0] << ": " << v[0] << " " << v[1] << " " << v[2] << " " << v[3];
            ++crossed;
            beyondAll +=
                isovalues[0] < *std::min_element(v, v + 4) || isovalues[0] > *std::max_element(v, v + 4);
        }
        passedOver += !may;
    }
    EXPECT_GT(crossed, 10000);
    EXPECT_GT(beyondAll, 100); // turns between the values
    EXPECT_GT(passedOver, 50000);
}

} // namespace
} // namespace tessera
