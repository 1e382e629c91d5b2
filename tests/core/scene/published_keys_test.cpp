// tests/core/scene/published_keys_test.cpp: the published keys of files are those of the tables.
// TESSERA_WRITE_DOCS=1 writes them anew.
#include "core/animation/path_fields.h"
#include "core/base/output_file.h"
#include "core/scene/scene_fields.h"
#include "tests/support/folders.h"

#include <cstdlib>
#include <gtest/gtest.h>

namespace tessera {
namespace {

const char* const kHow =
    "TESSERA_WRITE_DOCS=1 core_scene_test --gtest_filter='PublishedKeys.*' writes it anew";

void expectPublished(const std::string& name, const std::string& text) {
    const std::filesystem::path file = test::sourceFolder() / name;
    if (std::getenv("TESSERA_WRITE_DOCS"))
        writeOutputFile(file, text);
    EXPECT_TRUE(readTextFile(file.string()) == text)
        << name << " is not what the table of keys says; " << kHow;
}

TEST(PublishedKeys, OfScenes) {
    expectPublished("docs/scene.schema.json", schemaText(sceneSchema()));
}

TEST(PublishedKeys, OfPaths) {
    expectPublished("docs/path.schema.json", schemaText(pathSchema()));
}

TEST(PublishedKeys, OfScenesInTheGuide) {
    const std::string begin = "<!-- keys of scenes: generated -->\n", end = "<!-- end of keys -->\n";
    std::string guide = readTextFile((test::sourceFolder() / "docs/guide/keys.md").string());
    const std::size_t from = guide.find(begin), to = guide.find(end);
    ASSERT_NE(from, std::string::npos);
    ASSERT_NE(to, std::string::npos);
    guide.replace(from + begin.size(), to - from - begin.size(), keyTable(keysOf(sceneSchema())));
    expectPublished("docs/guide/keys.md", guide);
}

TEST(PublishedKeys, ATextHasALineForWhatFitsOne) {
    EXPECT_EQ(schemaText({{"a", {1, 2}}, {"b", "c"}}), "{\"a\": [1, 2], \"b\": \"c\"}\n");
    const std::string wide(120, 'x');
    EXPECT_EQ(schemaText({{"a", wide}, {"b", Schema::array()}}),
              "{\n  \"a\": \"" + wide + "\",\n  \"b\": []\n}\n");
}

} // namespace
} // namespace tessera
