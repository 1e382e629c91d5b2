// tests/viewer/panels/panels_test.cpp: what panels a figure has, where they lie, and their one scale.
#include "viewer/cli/render/panels.h"

#include "core/base/error.h"
#include "core/base/program_folders.h"
#include "core/scene/scene.h"
#include "viewer/annotations/panel_sheet.h"
#include "viewer/session/view_geometry.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <glm/geometric.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <vector>

namespace tessera {
namespace {

using ::testing::HasSubstr;

TEST(PanelGrids, HoldTheirPanelsRowByRowWithAGapBetween) {
    std::mt19937 random(1);
    const auto below = [&](int most) { return static_cast<int>(random() % static_cast<unsigned>(most)); };
    for (int n = 0; n < 300; ++n) {
        const int panels = 1 + below(30), columns = below(8), gap = below(9);
        const glm::ivec2 size(1 + below(90), 1 + below(90));
        PanelGrid grid = gridOf(panels, columns, gap, size, "--panel");
        if (columns > 0) {
            EXPECT_EQ(grid.columns, std::min(columns, panels));
        } else {
            EXPECT_EQ(grid.columns,
                      panels <= 3 ? panels : static_cast<int>(std::ceil(std::sqrt(panels) - 1e-9)));
        }
        EXPECT_EQ(grid.rows(), (panels - 1) / grid.columns + 1);
        grid.above = below(20), grid.below = below(20);
        // Each is the one before, moved by itself and the gap; the last ones touch the edges.
        EXPECT_EQ(grid.at(0), glm::ivec2(0, grid.above));
        for (int panel = 1; panel < panels; ++panel) {
            if (panel % grid.columns != 0) {
                EXPECT_EQ(grid.at(panel), grid.at(panel - 1) + glm::ivec2(size.x + gap, 0));
            } else {
                EXPECT_EQ(grid.at(panel), grid.at(panel - grid.columns) + glm::ivec2(0, size.y + gap));
            }
        }
        EXPECT_EQ(grid.size().x, grid.at(grid.columns - 1).x + size.x);
        EXPECT_EQ(grid.size().y, grid.at(panels - 1).y + size.y + grid.below);
        EXPECT_GE(bytesOf(grid), sizeof(glm::vec4) * static_cast<std::size_t>(grid.size().x) *
                                     static_cast<std::size_t>(grid.size().y));
        PanelGrid twice = grid;
        twice.above += grid.size().y;
        EXPECT_EQ(bytesOf(twice), 2 * bytesOf(grid)) << "by the pixel, strips as well";
    }
}

TEST(PanelGrids, AreNoLargerThanPictures) {
    const auto refused = [](PanelGrid grid) {
        try {
            checkSize(grid, "--panel");
        } catch (const InputError& e) {
            EXPECT_THAT(e.what(), HasSubstr("--panel"));
            EXPECT_THAT(e.what(), HasSubstr(std::to_string(Scene::kMaxImageExtent)));
            return true;
        }
        return false;
    };
    constexpr int kMost = Scene::kMaxImageExtent;
    for (const int axis : {0, 1}) {
        glm::ivec2 size(10);
        size[axis] = (kMost - 6) / 2;
        PanelGrid grid{2, axis == 0 ? 2 : 1, 6, size, 0, 0};
        EXPECT_FALSE(refused(grid)) << "a figure as large as it may be";
        grid.gap = 7;
        EXPECT_TRUE(refused(grid));
        grid.gap = 6;
        grid.above = 1;
        EXPECT_EQ(refused(grid), axis == 1);
        grid.above = 0, grid.below = 1;
        EXPECT_EQ(refused(grid), axis == 1);
        grid = {400, axis == 0 ? 400 : 1, 30000, glm::ivec2(30000), 0, 0};
        EXPECT_TRUE(refused(grid)) << "without overflow";
    }
}

// The largest scale of a projection is that of all its cameras, and nothing else changes.
TEST(PanelScales, AreTheLargestOfEachProjection) {
    std::mt19937 random(2);
    const auto part = [&] { return 0.1 + static_cast<double>(random() % 1000) / 500; };
    for (int n = 0; n < 200; ++n) {
        std::vector<Camera> cameras(1 + random() % 5);
        for (Camera& camera : cameras) {
            camera.projection = random() % 2 == 0 ? Projection::parallel : Projection::perspective;
            camera.focalPoint = {part(), part(), part()};
            camera.position = camera.focalPoint + 50.0 * glm::dvec3(part(), -part(), part());
            camera.parallelScale = 40 * part();
            camera.viewAngle = 15 + 20 * part();
        }
        std::vector<Camera> shared = cameras;
        shareScale(shared);
        for (std::size_t k = 0; k < cameras.size(); ++k) {
            const Camera &before = cameras[k], &now = shared[k];
            double most = 0;
            for (const Camera& camera : cameras)
                if (camera.projection == before.projection)
                    most = std::max(most, halfHeightMm(camera));
            EXPECT_NEAR(halfHeightMm(now), most, 1e-9 * most);
            EXPECT_EQ(now.focalPoint, before.focalPoint);
            EXPECT_EQ(now.viewAngle, before.viewAngle);
            EXPECT_EQ(now.projection, before.projection);
            EXPECT_LT(glm::distance(glm::normalize(now.position - now.focalPoint),
                                    glm::normalize(before.position - before.focalPoint)),
                      1e-9);
            if (before.projection == Projection::parallel) {
                EXPECT_EQ(now.position, before.position);
            } else {
                EXPECT_EQ(now.parallelScale, before.parallelScale);
            }
        }
    }
    std::vector<Camera> none;
    shareScale(none);
    EXPECT_TRUE(none.empty());
}

TEST(PanelTexts, AreSidesAnglesFilesOrKeys) {
    const ScratchFolder folder;
    const std::string file = (folder.path() / "a.json").string();
    std::ofstream(file) << "{}";
    const std::vector<Panel> panels = panelsOf({"left,anterior", "30,-10.5", "mode=maximum;image.size=8x8",
                                                "right", file, "left," + file, "-5,1e1"});
    using Said = std::vector<std::string>;
    Said views, scenes;
    for (const Panel& panel : panels) {
        views.push_back(panel.view), scenes.push_back(panel.scene);
        EXPECT_EQ(panel.view.empty() + panel.scene.empty() + panel.sets.empty(), 2);
    }
    EXPECT_EQ(views, (Said{"left", "anterior", "30,-10.5", "", "right", "", "left", "", "-5,1e1"}));
    EXPECT_EQ(scenes, (Said{"", "", "", "", "", file, "", file, ""}));
    EXPECT_EQ(panels[3].sets, (Said{"mode=maximum", "image.size=8x8"}));
    for (const char* bad : {"", "left,", ",left", "sideways", "30,", "30,x", "30,10,5", "30,10x", "left,30"})
        EXPECT_THROW((void)panelsOf({bad}), InputError) << bad;
    EXPECT_EQ(panelsOf(Said(kMostPanels, "left")).size(), kMostPanels);
    EXPECT_THROW((void)panelsOf(Said(kMostPanels + 1, "left")), InputError);
}

// A manifest tells all that a figure is, but for its panels.
TEST(PanelManifests, TellTheFigure) {
    std::mt19937 random(3);
    const auto below = [&](int most) { return static_cast<int>(random() % static_cast<unsigned>(most)); };
    for (int n = 0; n < 100; ++n) {
        PanelLayout figure;
        figure.grid = gridOf(1 + below(9), 1 + below(4), below(9), {8 + below(90), 8 + below(90)}, "--panel");
        figure.grid.above = below(30), figure.grid.below = below(30);
        figure.words.title = n % 2 ? "A title" : "";
        figure.words.caption = n % 3 ? "A caption" : "";
        figure.words.textPoints = 5 + below(9);
        figure.words.dpi = 72 + below(200);
        figure.oneScale = n % 2 == 0;
        figure.letters = n % 3 == 0;
        const nlohmann::json said = layoutJson(figure);
        const PanelLayout again = layoutOfJson(said, figure.grid.panels, "a.png");
        EXPECT_EQ(again.grid.panels, figure.grid.panels);
        EXPECT_EQ(again.grid.columns, figure.grid.columns);
        EXPECT_EQ(again.grid.gap, figure.grid.gap);
        EXPECT_EQ(again.grid.panelSize, figure.grid.panelSize);
        EXPECT_EQ(again.grid.above, figure.grid.above);
        EXPECT_EQ(again.grid.below, figure.grid.below);
        EXPECT_EQ(again.words, figure.words);
        EXPECT_EQ(again.oneScale, figure.oneScale);
        EXPECT_EQ(again.letters, figure.letters);
        // Whatever is missing or is no number of a figure, is refused.
        for (const char* key : {"columns", "gap", "panelSize", "above", "below", "title", "caption",
                                "textPoints", "dpi", "oneScale"})
            for (const char* value : {"", "\"x\"", "-1", "[-1,4]", "{}", "99999999", "1.5"}) {
                const bool isPoints = key == std::string("textPoints") || key == std::string("dpi");
                if (isPoints && value == std::string("1.5"))
                    continue; // may be one
                if ((key == std::string("title") || key == std::string("caption")) &&
                    value == std::string("\"x\""))
                    continue;
                nlohmann::json bad = said;
                bad.erase(key);
                if (*value)
                    bad[key] = nlohmann::json::parse(value);
                EXPECT_THROW((void)layoutOfJson(bad, figure.grid.panels, "a.png"), InputError)
                    << key << " " << value;
            }
        EXPECT_THROW((void)layoutOfJson(said, static_cast<int>(kMostPanels) + 1, "a.png"), InputError);
    }
}

} // namespace
} // namespace tessera
