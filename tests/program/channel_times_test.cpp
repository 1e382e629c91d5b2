// tests/program/channel_times_test.cpp: files of channels and times by the program: --series is the channel,
// --phase the time; films over the times of OME-TIFF, ImageJ, Imaris and DICOM; the camera of turns.
#include "tests/support/dicom_writer.h"
#include "tests/support/folders.h"
#include "tests/support/program_fixture.h"

#include "core/image/image_file.h" // readManifest

#include <cmath>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>

namespace tessera::test {
namespace {

using nlohmann::json;
using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr int kSide = 16, kSlices = 6, kChannels = 2, kTimes = 3;

/// A ball that wanders; every channel and time has values of its own.
std::int16_t numberAt(int x, int y, int z, int channel, int time) {
    const int dx = x - 6 - 2 * time, dy = y - 8, dz = 2 * z - 6;
    return static_cast<std::int16_t>((dx * dx + dy * dy + dz * dz < 30 ? 1200 : 100) + 37 * channel +
                                     11 * time);
}
std::string sliceOf(int z, int channel, int time) {
    std::string bytes;
    for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x) {
            const std::int16_t number = numberAt(x, y, z, channel, time);
            bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
        }
    return bytes;
}

template <typename T> void add(std::string& bytes, T value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}
/// Pages of whole slices; the first has the description.
std::string tiffOf(const std::vector<std::string>& pages, const std::string& description) {
    std::string file("II*\0", 4);
    add<std::uint32_t>(file, 8);
    for (std::size_t n = 0; n < pages.size(); ++n) {
        const std::string text = n == 0 ? description + '\0' : std::string();
        struct Entry {
            std::uint16_t tag, type;
            std::size_t count, value;
        };
        std::vector<Entry> entries = {
            {256, 4, 1, kSide}, {257, 4, 1, kSide}, {258, 3, 1, 16}, {259, 3, 1, 1}, {262, 3, 1, 1}};
        const std::size_t count = n == 0 ? 11 : 10, data = file.size() + 2 + 12 * count + 4;
        if (n == 0)
            entries.push_back({270, 2, text.size(), data});
        entries.push_back({273, 4, 1, data + text.size()});
        for (const Entry& entry :
             {Entry{277, 3, 1, 1}, {278, 4, 1, kSide}, {279, 4, 1, pages[n].size()}, {339, 3, 1, 2}})
            entries.push_back(entry);
        add(file, static_cast<std::uint16_t>(count));
        for (const Entry& entry : entries) {
            add(file, entry.tag), add(file, entry.type);
            add(file, static_cast<std::uint32_t>(entry.count)),
                add(file, static_cast<std::uint32_t>(entry.value));
        }
        const std::size_t end = data + text.size() + pages[n].size();
        add(file, static_cast<std::uint32_t>(n + 1 < pages.size() ? end + end % 2 : 0));
        file += text + pages[n] + std::string(end % 2, '\0');
    }
    return file;
}

std::string omeOf(int channels, int times) {
    return "<?xml version=\"1.0\"?><OME><Image ID=\"Image:0\"><Pixels DimensionOrder=\"XYZCT\" SizeX=\"16\" "
           "SizeY=\"16\" "
           "SizeZ=\"6\" SizeC=\"" +
           std::to_string(channels) + "\" SizeT=\"" + std::to_string(times) +
           "\" PhysicalSizeX=\"1\" PhysicalSizeXUnit=\"mm\" PhysicalSizeY=\"1\" PhysicalSizeYUnit=\"mm\" "
           "PhysicalSizeZ=\"2\" "
           "PhysicalSizeZUnit=\"mm\" TimeIncrement=\"0.5\"><Channel Name=\"red\"/><Channel "
           "Name=\"green\"/><TiffData/>"
           "</Pixels></Image></OME>";
}
std::string imageJOf(int channels, int times) {
    return "ImageJ=1.53t\nimages=" + std::to_string(channels * times * kSlices) +
           "\nchannels=" + std::to_string(channels) + "\nslices=6\nframes=" + std::to_string(times) +
           "\nhyperstack=true\nunit=mm\nspacing=2.0\nfinterval=0.5\nmode=grayscale\n";
}
/// In the order of the format: OME's here by slices, channels, times; ImageJ's by channels, slices, times.
std::string fileOf(bool isOme, int channel, int channels, int time, int times) {
    std::vector<std::string> pages;
    for (int t = time; t < time + times; ++t)
        for (int n = 0; n < channels * kSlices; ++n)
            pages.push_back(isOme ? sliceOf(n % kSlices, channel + n / kSlices, t)
                                  : sliceOf(n / channels, channel + n % channels, t));
    return tiffOf(pages, isOme ? omeOf(channels, times) : imageJOf(channels, times));
}

class ChannelTimes : public Program {
  protected:
    json manifestOf(const std::string& picture) const { return json::parse(readManifest(folder_ / picture)); }
    static std::string frame(int n) { return "/frame-00000" + std::to_string(n) + ".png"; }
    std::string contentOf(const std::string& file, const std::string& options) {
        const Outcome made = run("import " + file + " one.zarr --force --spacing 1,1,2 " + options);
        EXPECT_EQ(made.exitCode, 0) << made.problems;
        return json::parse(run("info one.zarr --json").out).value("contentHash", "");
    }
    /// A film over phases: a frame each, of what an import of the phase has.
    void expectFilm(const std::string& file, const std::string& options, int times,
                    const std::string& spacing) {
        const Outcome film = run("render " + file + " " + options + " --phase all " + spacing +
                                 " -o frames --engine native --size 16x12 --json");
        ASSERT_EQ(film.exitCode, 0) << film.problems;
        EXPECT_EQ(json::parse(film.out)["phases"], times);
        for (int n = 0; n < times; ++n) {
            const json manifest = manifestOf("frames" + frame(n));
            EXPECT_EQ(manifest["film"]["phase"], n + 1);
            const Outcome made = run("import " + file + " one.zarr --force " + options + " " + spacing +
                                     " --phase " + std::to_string(n + 1));
            ASSERT_EQ(made.exitCode, 0) << made.problems;
            EXPECT_EQ(manifest["store"]["contentHash"],
                      json::parse(run("info one.zarr --json").out)["contentHash"])
                << file << ' ' << n;
        }
        fs::remove_all(folder_ / "frames");
    }
};

TEST_F(ChannelTimes, EachHasItsOwnVoxels) {
    for (const bool isOme : {true, false}) {
        write("t.tif", fileOf(isOme, 0, kChannels, 0, kTimes));
        for (int channel = 0; channel < kChannels; ++channel)
            for (int time = 0; time < kTimes; ++time) {
                write("one.tif", fileOf(isOme, channel, 1, time, 1));
                const std::string expected = contentOf("one.tif", "");
                EXPECT_EQ(contentOf("t.tif", "--series " + std::to_string(channel + 1) + " --phase " +
                                                 std::to_string(time + 1)),
                          expected)
                    << isOme << ' ' << channel << ' ' << time;
                const int alone = time * kChannels + channel + 1;
                EXPECT_EQ(contentOf("t.tif", "--series " + std::to_string(alone)), expected) << alone;
            }
        const Outcome info = run("info t.tif --spacing 1,1,2");
        EXPECT_THAT(
            info.out,
            AllOf(HasSubstr(isOme ? "channel 2 (\"green\"), 3 phases for --phase (1: 0 s, 2: 0.5 s, 3: 1 s)"
                                  : "channel 2, 3 phases for --phase (1: 0 s, 2: 0.5 s, 3: 1 s)"),
                  ::testing::Not(HasSubstr("time 2"))));
        const json listed = json::parse(run("info t.tif --json --spacing 1,1,2").out)["series"];
        ASSERT_EQ(listed.size(), 2u);
        EXPECT_EQ(listed[1]["series"], 2);
        EXPECT_EQ(listed[1]["phases"].size(), 3u);
        const auto refuses = [&](const std::string& command, const std::string& what) { // with the table
            const Outcome outcome = run(command + " --spacing 1,1,2");
            EXPECT_NE(outcome.exitCode, 0) << command;
            EXPECT_THAT(outcome.problems, AllOf(HasSubstr("t.tif"), HasSubstr(what), HasSubstr("channel 2")))
                << command;
        };
        refuses("import t.tif x.zarr", "--series N");
        refuses("import t.tif x.zarr --phase 2", "--series N");
        refuses("import t.tif x.zarr --series 3 --phase 1", "--series between 1 and 2");
        refuses("render t.tif --phase all --series 3 -o f", "--series 3");
        expectRefused("import t.tif x.zarr --series 2 --phase 4 --spacing 1,1,2",
                      {"t.tif", "--phase between 1 and 3"});
        expectRefused("render t.tif --phase all -o f --spacing 1,1,2", {"t.tif", "--series N"});
        const Outcome first = run("import t.tif one.zarr --force --series 2 --spacing 1,1,2");
        EXPECT_THAT(first.problems, HasSubstr("took phase 1 of 3 (0 s)"));
        expectFilm("t.tif", "--series 2", kTimes, "--spacing 1,1,2");
        write("alone.tif", fileOf(isOme, 1, 1, 0, kTimes)); // one channel
        expectFilm("alone.tif", "", kTimes, "--spacing 1,1,2");
        const std::string whole = fileOf(isOme, 0, kChannels, 0, kTimes);
        write("cut.tif", whole.substr(0, whole.size() - 100));
        expectRefused("import cut.tif x.zarr --series 2 --phase 3", {"cut.tif"});
    }
}

TEST_F(ChannelTimes, TheTimesOfImarisAreAFilm) {
    fs::copy_file(sourceFolder() / "tests/fuzz/corpus/hdf5/times.ims", folder_ / "t.ims");
    EXPECT_THAT(run("info t.ims").out,
                HasSubstr("channel 2, 3 phases for --phase (1: time 1, 2: time 2, 3: time 3)"));
    expectFilm("t.ims", "--series 2", 3, "");
    expectRefused("render t.ims --phase all -o f", {"t.ims", "--series N"});
}

TEST_F(ChannelTimes, ThePhasesOfDicomAreAFilm) {
    fs::create_directories(folder_ / "heart");
    for (int time = 0; time < kTimes; ++time)
        for (int z = 0; z < kSlices; ++z) {
            DicomImage image;
            image.columns = image.rows = kSide;
            image.spacingX = image.spacingY = 1;
            for (int n = 0; n < kSide * kSide; ++n)
                image.pixels.push_back(
                    static_cast<std::uint16_t>(numberAt(n % kSide, n / kSide, z, 0, time)));
            image.position = glm::dvec3(0, 0, 2 * z);
            image.cardiacPercent = 40 * time;
            writeDicom(folder_ / "heart" / (std::to_string(time) + "-" + std::to_string(z)), image);
        }
    EXPECT_THAT(run("info heart").out,
                HasSubstr("3 phases for --phase (1: phase 0 %, 2: phase 40 %, 3: phase 80 %)"));
    expectFilm("heart", "", kTimes, "");
}

// The ball wanders: a camera for its first place would cut the last one off.
TEST_F(ChannelTimes, ATurnHoldsWhatAnyPhaseShows) {
    write("t.tif", fileOf(true, 0, 1, 0, kTimes));
    write("back.tif", [] { // the same times the other way round
        std::vector<std::string> pages;
        for (int t = kTimes - 1; t >= 0; --t)
            for (int z = 0; z < kSlices; ++z)
                pages.push_back(sliceOf(z, 0, t));
        return tiffOf(pages, omeOf(1, kTimes));
    }());
    const auto camera = [&](const std::string& file, const std::string& more) {
        const Outcome film = run("render " + file +
                                 " --phase all --mode maximum --engine native --size 16x16 -o turn " + more);
        EXPECT_EQ(film.exitCode, 0) << film.problems;
        const json scene = manifestOf("turn" + frame(0))["scene"];
        fs::remove_all(folder_ / "turn");
        return scene["camera"];
    };
    const json forth = camera("t.tif", "--turn 180 --frames 3"),
               back = camera("back.tif", "--turn 180 --frames 3");
    const auto close = [](const json& a, const json& b) {
        double most = 0;
        for (const char* key : {"position", "focalPoint"})
            for (std::size_t n = 0; n < 3; ++n)
                most = std::max(most, std::abs(a[key][n].get<double>() - b[key][n].get<double>()));
        return most;
    };
    EXPECT_LT(close(forth, back), 1e-6);
}

TEST_F(ChannelTimes, APhaseIsAKeyOfScenesAndAColumnOfTables) {
    write("t.tif", fileOf(true, 0, kChannels, 0, kTimes));
    std::vector<std::string> contents;
    for (int time = 1; time <= kTimes; ++time) {
        ASSERT_EQ(run("import t.tif one.zarr --force --series 2 --phase " + std::to_string(time)).exitCode,
                  0);
        contents.push_back(json::parse(run("info one.zarr --json").out)["contentHash"]);
    }
    write(
        "size.json",
        R"({"tesseraScene":1,"volumes":[{"path":"t.tif","series":1,"phase":1,"transferFunction":"auto"}],"image":{"size":[16,12]}})");
    for (const std::string names : {"volumes[0].series,volumes[0].phase", "--series,--phase"}) {
        write("table.csv", "id,volumes[0].path," + names + "\na,t.tif,2,1\nb,t.tif,2,2\nc,t.tif,2,3\n");
        const Outcome batch = run("batch table.csv --scene size.json -o {id}.png --again --engine native");
        ASSERT_EQ(batch.exitCode, 0) << batch.problems;
        for (int n = 0; n < kTimes; ++n)
            EXPECT_EQ(manifestOf(std::string(1, static_cast<char>('a' + n)) + ".png")["store"]["contentHash"],
                      contents[static_cast<std::size_t>(n)])
                << names;
    }
    write(
        "scene.json",
        R"({"tesseraScene":1,"volumes":[{"path":"t.tif","series":2,"phase":3,"transferFunction":"auto"}]})");
    ASSERT_EQ(run("render scene.json -o s.png --engine native --size 16x12").exitCode, 0);
    EXPECT_EQ(manifestOf("s.png")["store"]["contentHash"], contents[2]);
    ASSERT_EQ(
        run("render scene.json --set volumes[0].phase=1 -o s.png --engine native --size 16x12").exitCode, 0);
    EXPECT_EQ(manifestOf("s.png")["store"]["contentHash"], contents[0]);
}

// A name in two keyframes means one function for all phases.
TEST_F(ChannelTimes, NamesInKeyframesAreOneFunctionForAllPhases) {
    write("t.tif", fileOf(true, 0, 1, 0, kTimes));
    const std::string camera =
        R"("camera":{"position":[8,-90,6],"focalPoint":[8,8,6],"viewAngle":30},"transferFunction":"auto")";
    write("path.json", R"({"tesseraPath":1,"framesPerSecond":2,"keyframes":[{"time":0,)" + camera +
                           R"(},{"time":1,)" + camera + "}]}");
    const Outcome film =
        run("render t.tif --phase all --path path.json -o film --engine native --size 16x12");
    ASSERT_EQ(film.exitCode, 0) << film.problems;
    const json first = manifestOf("film" + frame(0))["scene"]["volumes"][0]["transferFunction"];
    for (int n = 1; n < 3; ++n)
        EXPECT_EQ(manifestOf("film" + frame(n))["scene"]["volumes"][0]["transferFunction"], first) << n;
    EXPECT_TRUE(first.is_object()) << first;
}

} // namespace
} // namespace tessera::test
