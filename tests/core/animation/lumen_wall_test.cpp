// tests/core/animation/lumen_wall_test.cpp: the wall of a lumen among a scene's isosurfaces.
#include "core/animation/flight.h"

#include <gtest/gtest.h>

namespace tessera {
namespace {

TEST(LumenWall, JoinsAsManyIsosurfacesAsASceneMayHave) {
    Lumen lumen;
    lumen.threshold = -500;
    for (std::size_t others = 0; others <= Scene::kMaxSurfaces; ++others) {
        Scene scene;
        for (std::size_t i = 0; i < others; ++i)
            scene.surfaces.push_back({100.0 + static_cast<double>(i), glm::dvec3(1), 0.5});
        const std::vector<Isosurface> before = scene.surfaces;
        const bool fits = others < Scene::kMaxSurfaces;
        EXPECT_EQ(showLumenWall(lumen, scene), fits) << others;
        EXPECT_EQ(scene.surfaces.size(), before.size() + (fits ? 1 : 0));
        EXPECT_TRUE(std::equal(before.begin(), before.end(), scene.surfaces.begin()));
        EXPECT_EQ(scene.mode, fits ? Mode::isosurface : Mode::composite);
        if (fits) {
            EXPECT_EQ(scene.surfaces.back().value, -500);
            EXPECT_EQ(scene.surfaces.back().opacity, 1);
        }
    }
}

// Also where no other would fit.
TEST(LumenWall, IsAddedOnce) {
    Lumen lumen;
    lumen.threshold = -500;
    lumen.surface = -620;
    Scene scene;
    for (std::size_t i = 0; i + 1 < Scene::kMaxSurfaces; ++i)
        scene.surfaces.push_back({static_cast<double>(i)});
    ASSERT_TRUE(showLumenWall(lumen, scene));
    EXPECT_EQ(scene.surfaces.back().value, -620);
    const std::vector<Isosurface> before = scene.surfaces;
    scene.mode = Mode::composite;
    EXPECT_TRUE(showLumenWall(lumen, scene));
    EXPECT_EQ(scene.surfaces, before);
    EXPECT_EQ(scene.mode, Mode::isosurface);
}

TEST(LumenWall, IsShownByFilmsOfALumenWithoutAFunction) {
    Path path;
    EXPECT_FALSE(showsWallByDefault(path));
    path.lines.emplace_back();
    EXPECT_FALSE(showsWallByDefault(path));
    path.lumen.emplace();
    EXPECT_TRUE(showsWallByDefault(path));
    path.keyframes.resize(2);
    EXPECT_TRUE(showsWallByDefault(path));
    path.keyframes[1].transferFunction = std::string("bone");
    EXPECT_FALSE(showsWallByDefault(path));
    path.keyframes.clear();
    path.lines.clear();
    EXPECT_FALSE(showsWallByDefault(path));
}

} // namespace
} // namespace tessera
