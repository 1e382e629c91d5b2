// tests/viewer/redraw/differences_test.cpp: what two pictures differ in: any key of their manifests, and any
// bit of their pixels; and which of the named paths is which of a picture's data.
#include "viewer/cli/redraw/differences.h"

#include "core/base/error.h"
#include "core/base/program_folders.h"
#include "core/image/image_file.h"
#include "viewer/cli/redraw/find_data.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <random>
#include <set>
#include <string>
#include <vector>

namespace tessera {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

json wholeManifest() {
    return json::parse(R"({
        "program": "tessera 1", "commit": "abc", "engine": "native", "device": "CPU", "openGl": "none",
        "scene": {"mode": "composite", "image": {"size": [40, 30]}, "window": [40, 400],
                  "volumes": [{"opacity": 1, "path": "a"}, {"opacity": 0.5, "labels": {"path": "b"}}]},
        "budgets": {"ram": {"limitBytes": 1048576}, "gpuMemory": {"limitBytes": 2097152}},
        "options": {"processors": 4, "allowDamaged": false, "verify": "quick"},
        "tiles": {"side": 64}, "layers": ["depth"], "ranks": 2})");
}

// Each key alone: it is told, with both values, in the list that it belongs to, and nothing else is.
TEST(ManifestDifference, IsTheKeyThatDiffers) {
    struct Case {
        const char *pointer, *value, *key, *before, *now;
        int list; // program, device, settings
    };
    const Case cases[] = {
        {"/program", "\"tessera 2\"", "program", "tessera 1", "tessera 2", 0},
        {"/commit", "\"def\"", "commit", "abc", "def", 0},
        {"/engine", "\"gpu\"", "engine", "native", "gpu", 1},
        {"/device", "\"GPU\"", "device", "CPU", "GPU", 1},
        {"/openGl", "\"4.5\"", "openGl", "none", "4.5", 1},
        {"/options/processors", "8", "processors", "4", "8", 1},
        {"/scene/mode", "\"maximum\"", "mode", "composite", "maximum", 2},
        {"/scene/image/size", "[40,31]", "image.size", "[40,30]", "[40,31]", 2},
        {"/scene/window", "null", "window", "[40,400]", "nothing", 2},
        {"/scene/new", "7", "new", "nothing", "7", 2},
        {"/scene/volumes/1/opacity", "0.25", "volumes[1].opacity", "0.5", "0.25", 2},
        {"/budgets/ram/limitBytes", "3145728", "--ram", "1 MiB", "3 MiB", 2},
        {"/budgets/gpuMemory/limitBytes", "1048576", "--gpu-memory", "2 MiB", "1 MiB", 2},
        {"/options/allowDamaged", "true", "--allow-damaged", "false", "true", 2},
        {"/tiles/side", "128", "--tiles", "64", "128", 2},
        {"/layers", "[]", "--layers", "[\"depth\"]", "[]", 2},
    };
    const json before = wholeManifest();
    const ManifestDifferences none = compareManifests(before, before);
    EXPECT_EQ(none.program.size() + none.device.size() + none.settings.size(), 0U);
    for (const Case& one : cases) {
        json now = before;
        now[json::json_pointer(one.pointer)] = json::parse(one.value);
        const ManifestDifferences found = compareManifests(before, now);
        const std::vector<Difference>* const lists[] = {&found.program, &found.device, &found.settings};
        for (int list = 0; list < 3; ++list)
            ASSERT_EQ(lists[list]->size(), list == one.list ? 1U : 0U) << one.pointer;
        const Difference& difference = lists[one.list]->front();
        EXPECT_EQ(difference.key, one.key);
        EXPECT_EQ(difference.before, one.before) << one.pointer;
        EXPECT_EQ(difference.now, one.now) << one.pointer;
    }
    for (const char* key : {"legend", "ranks"}) {
        json now = before;
        now.contains(key) ? (void)now.erase(key) : (void)(now[key] = json::array());
        EXPECT_EQ(compareManifests(before, now).settings.size(), 1U) << key;
    }
    for (const char* place : {"/scene/volumes/0/path", "/scene/volumes/1/labels/path"}) {
        json now = before;
        now[json::json_pointer(place)] = "elsewhere";
        EXPECT_THAT(compareManifests(before, now).settings, IsEmpty()) << "data count by their content";
    }
    // What an older manifest does not tell counts as equal.
    for (const char* key : {"commit", "budgets", "options"}) {
        json older = before;
        older.erase(key);
        const ManifestDifferences found = compareManifests(older, before);
        EXPECT_EQ(found.program.size() + found.device.size(), 0U) << key;
    }
    json longer = before;
    longer["scene"]["mode"] = std::string(500, 'x');
    const Difference cut = compareManifests(before, longer).settings.at(0);
    EXPECT_EQ(cut.now, std::string(117, 'x') + "...");
}

// Pixels that differ are counted, and their mean square is that of all values.
TEST(PixelDifference, IsCountedAndMeasured) {
    const ScratchFolder folder;
    std::mt19937 random(1);
    MemoryBudget ram("RAM", "--ram", std::size_t{1} << 24);
    for (const char* ending : {".exr", ".tif", ".png"})
        for (int n = 0; n < 6; ++n) {
            const std::filesystem::path one = folder / (std::string("a") + ending),
                                        other = folder / (std::string("b") + ending);
            const glm::ivec2 size(3 + static_cast<int>(random() % 20), 2 + static_cast<int>(random() % 20));
            Image a(size);
            for (glm::vec4& pixel : a.pixels)
                pixel = {static_cast<float>(random() % 3) / 2, static_cast<float>(random() % 3) / 2, 0, 1};
            Image b = a;
            const std::size_t changed = n == 0 ? 0 : random() % a.pixels.size();
            for (std::size_t k = 0; k < changed; ++k)
                b.pixels[k] = glm::vec4(1) - b.pixels[k] + glm::vec4(0, 0, 0, 1);
            writeImage(one, a, "{}");
            writeImage(other, b, "{}");
            const Image readA = readImage(one), readB = readImage(other);
            std::size_t differing = 0;
            double squares = 0;
            for (std::size_t k = 0; k < readA.pixels.size(); ++k) {
                differing += readA.pixels[k] != readB.pixels[k] ? 1 : 0;
                const glm::dvec4 difference(readA.pixels[k] - readB.pixels[k]);
                for (int c = 0; c < 4; ++c)
                    squares += difference[c] * difference[c];
            }
            const PixelDifferences found = comparePixels(one, other, ram);
            EXPECT_EQ(found.notCompared, "");
            EXPECT_FALSE(found.ofPages);
            EXPECT_EQ(found.size, size);
            EXPECT_EQ(found.pixels, a.pixels.size());
            EXPECT_EQ(found.differing, differing);
            EXPECT_EQ(found.differing, changed);
            EXPECT_NEAR(found.rms, std::sqrt(squares / (4.0 * static_cast<double>(found.pixels))), 1e-6);
            EXPECT_EQ(ram.usedBytes(), 0U);
            // As many floats as two pictures have, at least.
            const std::size_t need = 2 * sizeof(glm::vec4) * a.pixels.size();
            MemoryBudget little("RAM", "--ram", need - 1), ample("RAM", "--ram", 2 * need);
            EXPECT_THAT(comparePixels(one, other, little).notCompared, HasSubstr("--ram of "));
            EXPECT_EQ(comparePixels(one, other, ample).notCompared, "");
        }
    writeImage(folder / "a.png", Image({4, 3}), "{}");
    writeImage(folder / "b.png", Image({3, 4}), "{}");
    writeImage(folder / "b.exr", Image({4, 3}), "{}");
    EXPECT_EQ(comparePixels(folder / "a.png", folder / "b.png", ram).notCompared,
              "their sizes differ, 4 x 3 and 3 x 4");
    EXPECT_EQ(comparePixels(folder / "a.png", folder / "b.exr", ram).notCompared,
              "their formats differ, .png and .exr");
}

// Bytes that are not alike, and those that one page has more; the manifests in them do not count.
TEST(PixelDifference, OfPagesIsThatOfTheirBytes) {
    const ScratchFolder folder;
    MemoryBudget ram("RAM", "--ram", std::size_t{1} << 20);
    const auto differing = [&](const std::string& ending, const std::string& a, const std::string& b) {
        std::ofstream(folder / ("a" + ending), std::ios::binary) << a;
        std::ofstream(folder / ("b" + ending), std::ios::binary) << b;
        const PixelDifferences found = comparePixels(folder / ("a" + ending), folder / ("b" + ending), ram);
        EXPECT_TRUE(found.ofPages);
        EXPECT_EQ(found.notCompared, "");
        EXPECT_EQ(ram.usedBytes(), 0U);
        return std::pair(found.differing, found.pixels);
    };
    using Counts = std::pair<std::size_t, std::size_t>;
    EXPECT_EQ(differing(".svg", "abcdef", "abcdef"), Counts(0, 6));
    EXPECT_EQ(differing(".svg", "abcdef", "aXcdeY"), Counts(2, 6));
    EXPECT_EQ(differing(".svg", "abcdef", "abcdefgh"), Counts(2, 8));
    EXPECT_EQ(differing(".svg", "abcdefgh", "Xbcdef"), Counts(3, 8));
    const std::string head = "<svg><metadata id=\"tessera-manifest\">", tail = "</metadata><g/></svg>";
    EXPECT_EQ(differing(".svg", head + "{}" + tail, head + "{\"more\":1}" + tail).first, 0U);
    EXPECT_EQ(differing(".svg", head + "{}" + tail, head + "{}" + tail + "x").first, 1U);
    EXPECT_EQ(differing(".pdf", "page/Keywords(a)", "page/Keywords(another)"), Counts(0, 4));
    EXPECT_EQ(differing(".pdf", "page/Keywords(a)", "pagE/Keywords(a)"), Counts(1, 4));
    MemoryBudget little("RAM", "--ram", 10);
    EXPECT_THAT(comparePixels(folder / "a.pdf", folder / "b.pdf", little).notCompared, HasSubstr("--ram"));
}

// Files are for data of their kind, in the order in which they are named.
TEST(NamedData, AreForDataOfTheirKind) {
    using Kind = PictureData::Kind;
    MemoryBudget ram("RAM", "--ram", std::size_t{1} << 20);
    const std::vector<PictureData> wanted = {
        {Kind::volume, 0}, {Kind::labels, 0}, {Kind::labelNames, 0, "", {}, "", 0, ".CSV"},
        {Kind::mesh, 0},   {Kind::mesh, 1},   {Kind::environment, 0}};
    const ScratchFolder folder;
    const auto assigned = [&](const std::vector<std::string>& named) {
        std::vector<std::string> paths;
        for (const std::string& name : named) {
            paths.push_back((folder / name).string());
            std::ofstream(paths.back()) << (name.ends_with(".ply") ? "ply\n" : "solid\n");
        }
        std::vector<std::string> found = assignData(wanted, paths, ram);
        for (std::string& path : found)
            path = std::filesystem::path(path).filename().string();
        return found;
    };
    using Paths = std::vector<std::string>;
    EXPECT_EQ(assigned({}), Paths(6));
    EXPECT_EQ(assigned({"b.PLY", "sky.hdr", "a.stl", "scan.nii"}),
              (Paths{"scan.nii", "", "", "b.PLY", "a.stl", "sky.hdr"}));
    EXPECT_EQ(assigned({"scan.nii", "labels.nrrd", "names.csv"}),
              (Paths{"scan.nii", "labels.nrrd", "names.csv", "", "", ""}));
    EXPECT_EQ(assigned({"sky.EXR"}), (Paths{"", "", "", "", "", "sky.EXR"}));
    EXPECT_THROW((void)assigned({"a.ply", "b.ply", "c.ply"}), InputError);
    EXPECT_THROW((void)assigned({"a.hdr", "b.exr"}), InputError);
}

} // namespace
} // namespace tessera
