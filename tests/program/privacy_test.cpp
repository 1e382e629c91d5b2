// tests/program/privacy_test.cpp: identifiers planted in DICOM files come out nowhere: not in the store, the
// pictures and their manifests, the cache, the answers or the messages, damaged files included. The rule for
// paths: a message may name its file, and --json the requested output, because the user typed or owns those
// names. Files that are kept (store, picture, cache, and their names) hold no path of the input, since
// folders carry patients' names.
#include "tests/support/dicom_writer.h"
#include "tests/support/program_fixture.h"

#include "core/image/image_file.h"

#include <nlohmann/json.hpp>

namespace tessera::test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr int kSlices = 6;
const std::string kFolder = "PLANTED-FOLDER", kFile = "PLANTED-FILE";

class Privacy : public Program {
  protected:
    static DicomImage slice(int z) {
        DicomImage image;
        image.columns = 20;
        image.rows = 16;
        image.position = glm::dvec3(0, 0, 2.0 * z);
        for (int i = 0; i < image.columns * image.rows; ++i)
            image.pixels.push_back(static_cast<std::uint16_t>(1024 + (i % 20 > 5 ? 300 : 0) + 10 * z));
        return image;
    }
    void makeSeries(const std::string& folder, int slices = kSlices) {
        fs::create_directories(folder_ / folder);
        for (int z = 0; z < slices; ++z)
            writeDicom(folder_ / folder / (kFile + std::to_string(z) + ".dcm"), slice(z));
    }
    /// Runs and searches all messages; they may name files only if namesToo.
    Outcome quietAbout(const std::string& arguments, bool namesToo = false) {
        const Outcome outcome = run(arguments);
        look(outcome.out + outcome.problems, "said by: " + arguments, namesToo);
        return outcome;
    }
    void look(const std::string& bytes, const std::string& where, bool namesToo) {
        for (const std::string& planted : kPlanted)
            EXPECT_EQ(bytes.find(planted), std::string::npos) << planted << " in " << where;
        if (namesToo) {
            for (const std::string& name : {kFolder, kFile})
                EXPECT_EQ(bytes.find(name), std::string::npos) << name << " in " << where;
        }
        ++looks_;
    }
    /// Every byte of every file below a folder, and the names.
    void lookThrough(const fs::path& path) {
        std::size_t files = 0;
        for (const auto& entry : fs::recursive_directory_iterator(path)) {
            look(entry.path().string(), "a name", true);
            if (entry.is_regular_file()) {
                look(readAll(entry.path()), entry.path().string(), true);
                ++files;
            }
        }
        EXPECT_GT(files, 0u) << path;
    }
    int looks_ = 0;
};

TEST_F(Privacy, TheSearchFindsWhatIsThere) {
    makeSeries(kFolder);
    const std::string bytes = readAll(folder_ / kFolder / (kFile + "0.dcm"));
    for (const std::string& planted : kPlanted)
        EXPECT_THAT(bytes, HasSubstr(planted));
}

TEST_F(Privacy, NothingIdentifyingLeavesTheInput) {
    makeSeries(kFolder);
    ASSERT_EQ(quietAbout("import " + kFolder + " a.zarr -v", true).exitCode, 0);
    lookThrough(folder_ / "a.zarr");
    for (const char* input : {"a.zarr", kFolder.c_str()})
        for (const char* form : {"", " --json", " -v"}) {
            const Outcome info = quietAbout("info " + std::string(input) + form);
            EXPECT_EQ(info.exitCode, 0) << info.problems;
            EXPECT_THAT(info.out, HasSubstr("B30f")) << "the whitelist";
        }
    for (const char* picture : {"a.png", "a.exr", "a.tif"}) {
        // From the files, through the cache, with everything said that can be said.
        const Outcome render = quietAbout("render " + kFolder +
                                              " --engine mirror --preset bone --size 24x24 -v"
                                              " --explain --json -o " +
                                              picture,
                                          true);
        ASSERT_EQ(render.exitCode, 0) << render.problems;
        look(readAll(folder_ / picture), picture, true);
        look(readManifest(folder_ / picture), "the manifest", true);
        EXPECT_THAT(readManifest(folder_ / picture), HasSubstr("not for diagnosis"));
        EXPECT_THAT(readManifest(folder_ / picture), Not(HasSubstr(folder_.path().filename().string())));
    }
    const Outcome march = quietAbout("render " + kFolder +
                                         " --gl-device software --size 24x24 -v --explain --json"
                                         " -o march.png",
                                     true);
    EXPECT_EQ(march.exitCode, 0) << march.problems;
    look(readAll(folder_ / "march.png"), "march.png", true);
    lookThrough(folder_ / "cache");
    // A scene's own path stays out of the picture as well.
    write("scene.json",
          R"({"tesseraScene":1,"volumes":[{"path":")" + kFolder + R"(","transferFunction":"bone"}],
                            "image":{"size":[16,16]}})");
    EXPECT_EQ(quietAbout("render scene.json --engine mirror --json -o scene.png", true).exitCode, 0);
    look(readAll(folder_ / "scene.png"), "scene.png", true);
}

TEST_F(Privacy, NorDoesItFromDamagedFiles) {
    const std::string whole = dicomBytes(slice(2));
    int refused = 0;
    const auto tryWith = [&](const std::string& what, const auto& damage) {
        SCOPED_TRACE(what);
        fs::remove_all(folder_ / "d");
        makeSeries("d");
        damage();
        for (const char* command : {"import d b.zarr --force -v", "info d --json"})
            refused += quietAbout(command).exitCode == 2;
        if (exists("b.zarr"))
            lookThrough(folder_ / "b.zarr");
        fs::remove_all(folder_ / "b.zarr");
    };
    const auto file = [&](int z) { return "d/" + kFile + std::to_string(z) + ".dcm"; };
    for (const std::size_t bytes :
         {std::size_t{100}, std::size_t{200}, std::size_t{400}, std::size_t{600}, whole.size() - 7})
        tryWith("cut to " + std::to_string(bytes), [&] {
            for (int z = 0; z < kSlices; ++z)
                write(file(z), whole.substr(0, bytes));
        });
    // A byte of each planted value and of its tag, in every file.
    for (const std::string& planted : kPlanted)
        for (const std::ptrdiff_t shift : {-7, -2})
            tryWith("a changed byte near " + planted, [&] {
                for (int z = 0; z < kSlices; ++z) {
                    std::string bytes = dicomBytes(slice(z));
                    const auto at = static_cast<std::ptrdiff_t>(bytes.rfind(planted)) + shift;
                    bytes[static_cast<std::size_t>(at)] =
                        static_cast<char>(bytes[static_cast<std::size_t>(at)] ^ 0x41);
                    write(file(z), bytes);
                }
            });
    const auto change = [&](const std::string& what, int z, const auto& edit) {
        tryWith(what, [&] {
            DicomImage image = slice(z);
            edit(image);
            writeDicom(folder_ / file(z), image);
        });
    };
    change("a gap", 5, [](DicomImage& i) { i.position->z += 3; });
    change("a duplicate", 5, [](DicomImage& i) { i.position->z -= 2; });
    change("no position", 3, [](DicomImage& i) { i.position.reset(); });
    change("another size", 3, [](DicomImage& i) { i.columns = 19; });
    change("no pixels", 3, [](DicomImage& i) { i.withPixels = false; });
    change("a slope of words", 3, [](DicomImage& i) { i.slope = "steep"; });
    change("another series", 3, [](DicomImage& i) { i.series = "2"; });
    EXPECT_GE(refused, 20);
    EXPECT_GE(looks_, 100);
}

} // namespace
} // namespace tessera::test
