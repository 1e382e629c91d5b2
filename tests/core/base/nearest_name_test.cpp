// tests/core/base/nearest_name_test.cpp: the name that was meant.
#include "core/base/names.h"

#include <gtest/gtest.h>

namespace tessera {
namespace {

TEST(NearestName, IsTheOneThatWasMeant) {
    EXPECT_EQ(editDistance("kitten", "sitting"), 3u);
    EXPECT_EQ(editDistance("", "abc"), 3u);
    EXPECT_EQ(editDistance("abc", ""), 3u);
    EXPECT_EQ(editDistance("overview", "view"), 4u);
    EXPECT_EQ(editDistance("View", "view"), 0u);
    EXPECT_EQ(nearestName("bne", {"auto", "bone", "lung"}), "bone");
    EXPECT_EQ(nearestName("x", {}), "");
}

} // namespace
} // namespace tessera
