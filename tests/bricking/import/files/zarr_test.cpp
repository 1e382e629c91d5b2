// tests/bricking/import/files/zarr_test.cpp: volumes in OME-Zarr and in arrays of Zarr, as other programs
// write them: types, orders, compressions, places, channels, what has no number, and what is refused.
#include "bricking/import/catalogue.h"
#include "tests/support/bricking_test_volumes.h"
#include "tests/support/import_test_tools.h"
#include "tests/support/refusals.h"
#include "tests/support/zarr_label_image.h"

#include <algorithm>
#include <cmath>
#include <gmock/gmock.h>
#include <limits>
#include <numeric>

namespace tessera::test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

SourceOptions oneMm() {
    SourceOptions options;
    options.spacingMm = glm::dvec3(1);
    return options;
}

Json axesOf(const std::string& names) {
    Json axes = Json::array();
    for (const char name : names)
        axes.push_back(name == 'c' ? Json{{"name", "c"}, {"type", "channel"}}
                       : name == 't'
                           ? Json{{"name", "t"}, {"type", "time"}}
                           : Json{{"name", std::string(1, name)}, {"type", "space"}, {"unit", "millimeter"}});
    return axes;
}

/// A group of OME-Zarr with one array.
void writeImage(const fs::path& group, const WrittenZarr& zarr, const std::vector<std::uint32_t>& values,
                const std::string& axes, const Json& more = Json::object()) {
    std::vector<double> scale(axes.size(), 1), shift(axes.size(), 0);
    const std::size_t first = axes.size() - 3;
    scale[first] = 2, scale[first + 1] = 0.5, scale[first + 2] = 0.25;
    shift[first] = -100, shift[first + 1] = 20, shift[first + 2] = 30;
    Json scales = {
        {"axes", axesOf(axes)},
        {"datasets", Json::array({{{"path", "full"},
                                   {"coordinateTransformations",
                                    Json::array({{{"type", "scale"}, {"scale", scale}},
                                                 {{"type", "translation"}, {"translation", shift}}})}}})}};
    Json ome = more;
    (zarr.version == 2 ? scales : ome)["version"] = zarr.version == 2 ? "0.4" : "0.5";
    ome["multiscales"] = Json::array({scales});
    writeZarrGroup(group, zarr.version, ome);
    writeZarrArray(group / "full", zarr, values);
}

template <class T> std::vector<T> as(const std::vector<std::uint32_t>& values) {
    std::vector<T> out;
    for (const std::uint32_t value : values)
        out.push_back(static_cast<T>(value));
    return out;
}

TEST(ImportZarr, EveryTypeCompressionAndOrderReadsBackEqual) {
    const ScratchFolder folder;
    const auto values = zarrLabelValues(7 * 11 * 13);
    int number = 0;
    for (const char* type : {"uint8", "int16", "uint16", "int32", "float32", "float64"})
        for (const int version : {2, 3})
            for (const char* compressor : {"none", "blosc", "zstd", "gzip", "zlib", "lz4"}) {
                if (version == 3 && (compressor == std::string("zlib") || compressor == std::string("lz4")))
                    continue;
                WrittenZarr zarr;
                zarr.version = version;
                zarr.type = type;
                zarr.compressor = compressor;
                zarr.shape = kShape;
                zarr.chunk = number % 2 ? std::vector<std::size_t>{3, 4, 5} : kShape;
                zarr.bigEndian = number % 3 == 1;
                if (number % 4 == 1)
                    zarr.order = {2, 1, 0};
                const fs::path path = folder / std::to_string(number++);
                writeZarrArray(path, zarr, values);
                const auto source = openSource(path, oneMm());
                const std::string said = path.string() + " " + type + " " + compressor;
                EXPECT_EQ(source->info().extentVoxels, glm::ivec3(13, 11, 7)) << said;
                if (type == std::string("uint8"))
                    EXPECT_EQ(readAll<std::uint8_t>(*source), as<std::uint8_t>(values)) << said;
                else if (type == std::string("int16"))
                    EXPECT_EQ(readAll<std::int16_t>(*source), as<std::int16_t>(values)) << said;
                else if (type == std::string("uint16"))
                    EXPECT_EQ(readAll<std::uint16_t>(*source), as<std::uint16_t>(values)) << said;
                else
                    EXPECT_EQ(readAll<float>(*source), as<float>(values)) << said;
            }
}

TEST(ImportZarr, NumbersThatFloatCannotHoldAreToldOf) {
    const ScratchFolder folder;
    for (const char* type : {"uint32", "uint64", "float64"})
        for (const std::uint32_t value : {1u << 24, (1u << 24) + 1}) {
            std::vector<std::uint32_t> values(7 * 11 * 13, value);
            values[9] = 5;
            WrittenZarr zarr;
            zarr.type = type;
            zarr.shape = zarr.chunk = kShape;
            const fs::path path = folder / (type + std::to_string(value));
            writeZarrArray(path, zarr, values);
            const auto source = openSource(path, oneMm());
            readAll<float>(*source);
            EXPECT_EQ(source->takeTally().rounded.any(), value % 2 == 1) << type;
        }
}

TEST(ImportZarr, ItsPlaceIsThatOfTheTransformations) {
    const ScratchFolder folder;
    for (const int version : {2, 3}) {
        WrittenZarr zarr;
        zarr.version = version;
        zarr.shape = kShape;
        zarr.chunk = {3, 4, 5};
        const fs::path path = folder / ("image" + std::to_string(version));
        writeImage(path, zarr, zarrLabelValues(7 * 11 * 13), "zyx");
        const auto source = openSource(path, {});
        const VolumeInfo& info = source->info();
        EXPECT_EQ(info.spacingMm(), glm::dvec3(0.25, 0.5, 2));
        EXPECT_EQ(firstVoxelCentreMm(info), glm::dvec3(30, 20, -100));
        EXPECT_FALSE(info.orientationKnown);
        EXPECT_THAT(source->describe(), HasSubstr(version == 2 ? "OME-Zarr 0.4" : "OME-Zarr 0.5"));
        EXPECT_EQ(openSource(path / "", {})->info().extentVoxels, glm::ivec3(13, 11, 7)); // "image2/"
        EXPECT_EQ(openSource(path, oneMm())->info().spacingMm(), glm::dvec3(1));
        EXPECT_THAT(openSource(path, oneMm())->info().remarks, ElementsAre(HasSubstr("--spacing is taken")));
    }
}

/// An image whose "multiscales" were changed after they were written.
template <class Change> void changeImage(const fs::path& group, Change change) {
    const fs::path file = group / ".zattrs";
    std::ifstream in(file);
    Json document = Json::parse(in);
    change(document["multiscales"][0]);
    writeJson(file, document);
}

TEST(ImportZarr, UnitsOfLengthPlaceItAndOthersAskForItsSpacing) {
    const ScratchFolder folder;
    WrittenZarr zarr;
    zarr.version = 2;
    zarr.shape = zarr.chunk = kShape;
    const fs::path path = folder / "image";
    writeImage(path, zarr, zarrLabelValues(7 * 11 * 13), "zyx");
    const auto takeUnits = [&](const std::vector<std::string>& units) {
        changeImage(path, [&](Json& image) {
            for (std::size_t i = 0; i < 3; ++i) {
                image["axes"][i].erase("unit");
                if (!units[i].empty())
                    image["axes"][i]["unit"] = units[i];
            }
        });
    };
    const std::vector<std::pair<const char*, double>> known = {
        {"millimeter", 1}, {"mm", 1},         {"micrometer", 1e-3}, {"um", 1e-3},
        {"micron", 1e-3},  {"µm", 1e-3},      {"micrometre", 1e-3}, {"nm", 1e-6},
        {"meter", 1000},   {"angstrom", 1e-7}};
    const Json scale = {{"type", "scale"}, {"scale", {200, 50, 0.25}}};
    changeImage(
        path, [&](Json& image) { image["datasets"][0]["coordinateTransformations"] = Json::array({scale}); });
    for (const auto& [unit, mm] : known) {
        takeUnits({unit, unit, "millimeter"});
        const glm::dvec3 spacing = openSource(path, {})->info().spacingMm();
        EXPECT_DOUBLE_EQ(spacing.x, 0.25) << unit;
        EXPECT_DOUBLE_EQ(spacing.y, 50 * mm) << unit;
        EXPECT_DOUBLE_EQ(spacing.z, 200 * mm) << unit;
    }
    takeUnits({"", "", ""});
    const auto bare = openSource(path, {});
    EXPECT_EQ(bare->info().spacingMm(), glm::dvec3(0.25, 50, 200));
    EXPECT_THAT(bare->notes(), testing::Contains(HasSubstr("taken as millimetres")));
    const auto asks = [&](const char* said) {
        EXPECT_THAT(refusalOf([&] { openSource(path, {}); }),
                    AllOf(HasSubstr(".zattrs"), HasSubstr("--spacing"), HasSubstr(said)));
        const auto source = openSource(path, oneMm());
        EXPECT_EQ(source->info().spacingMm(), glm::dvec3(1)) << said;
        EXPECT_THAT(source->notes(), testing::Each(testing::Not(HasSubstr("millimetres"))));
        EXPECT_THAT(source->info().remarks, ElementsAre()) << said;
    };
    takeUnits({"millimeter", "pixel", "millimeter"});
    asks("\"pixel\" of axis \"y\"");
    takeUnits({"", "micrometer", "micrometer"});
    asks("no unit of axis \"z\"");
    takeUnits({"millimeter", "millimeter", "millimeter"});
    for (const Json& none : {Json::array(), Json::array({Json{{"type", "identity"}}}),
                             Json::array({Json{{"type", "translation"}, {"translation", {1, 2, 3}}}})}) {
        changeImage(path, [&](Json& image) { image["datasets"][0]["coordinateTransformations"] = none; });
        asks("no scale");
    }
}

TEST(ImportZarr, SpacingThatIsGivenIsAlongTheAxesOfTheImage) {
    const ScratchFolder folder;
    WrittenZarr zarr;
    zarr.version = 2;
    zarr.shape = zarr.chunk = kShape;
    const fs::path path = folder / "image";
    writeImage(path, zarr, zarrLabelValues(7 * 11 * 13), "xyz"); // z runs fastest
    changeImage(path, [](Json& image) {
        for (Json& axis : image["axes"])
            axis["unit"] = "pixel";
    });
    SourceOptions options;
    options.spacingMm = glm::dvec3(3, 2, 1);
    const auto source = openSource(path, options);
    EXPECT_EQ(source->info().extentVoxels, glm::ivec3(7, 11, 13));
    EXPECT_EQ(source->info().spacingMm(), glm::dvec3(1, 2, 3));
}

TEST(ImportZarr, ANumberChoosesNothingOfOneVolume) {
    const ScratchFolder folder;
    WrittenZarr zarr;
    zarr.shape = zarr.chunk = {1, 7, 11, 13};
    writeImage(folder / "image", zarr, zarrLabelValues(7 * 11 * 13), "czyx");
    SourceOptions options;
    for (const int series : {0, 1}) {
        options.series = series;
        EXPECT_EQ(openSource(folder / "image", options)->info().extentVoxels, glm::ivec3(13, 11, 7));
    }
    options.series = 2;
    EXPECT_THAT(refusalOf([&] { openSource(folder / "image", options); }),
                AllOf(HasSubstr("one volume: --series 1 or none"), HasSubstr("found 2")));
    writeFile(folder / "image/full/zarr.json", "{}"); // which is the reason to tell
    EXPECT_THAT(refusalOf([&] { openSource(folder / "image", options); }), HasSubstr("zarr_format"));
}

/// Voxels of the c-th of two channels at the t-th of three times, by the order of axes t, c, z, y, x.
std::vector<std::int16_t> volumeAt(std::size_t t, std::size_t c, const std::vector<std::uint32_t>& values) {
    constexpr std::size_t kVoxels = 4 * 5 * 6;
    const auto begin = values.begin() + static_cast<std::ptrdiff_t>((t * 2 + c) * kVoxels);
    return as<std::int16_t>({begin, begin + kVoxels});
}

TEST(ImportZarr, ChannelsAndTimesAreVolumesToChooseFrom) {
    const ScratchFolder folder;
    std::vector<std::uint32_t> values(3 * 2 * 4 * 5 * 6);
    std::iota(values.begin(), values.end(), 100u);
    int number = 0;
    for (const std::vector<std::size_t>& chunk :
         {std::vector<std::size_t>{1, 1, 4, 5, 6}, std::vector<std::size_t>{2, 2, 3, 2, 5}}) {
        WrittenZarr zarr;
        zarr.type = "int16";
        zarr.shape = {3, 2, 4, 5, 6};
        zarr.chunk = chunk;
        const fs::path path = folder / ("image" + std::to_string(number++));
        writeImage(path, zarr, values, "tczyx",
                   {{"omero", {{"channels", Json::array({{{"label", "bone\n"}}, Json::object()})}}}});
        const Catalogue catalogue = lookThrough(path);
        ASSERT_EQ(catalogue.rows.size(), 2u);
        const std::string times = ", 3 phases for --phase (1: time 1, 2: time 2, 3: time 3)";
        EXPECT_EQ(catalogue.rows[0].what, "channel 1 (bone\\x0a)" + times);
        EXPECT_EQ(catalogue.rows[1].what, "channel 2" + times);
        for (std::size_t t = 0; t < 3; ++t)
            for (std::size_t c = 0; c < 2; ++c) {
                SourceOptions alone, both;
                alone.series = static_cast<int>(t * 2 + c) + 1;
                both.series = static_cast<int>(c) + 1, both.phase = static_cast<int>(t) + 1;
                EXPECT_EQ(readAll<std::int16_t>(*openSource(path, alone)), volumeAt(t, c, values));
                EXPECT_EQ(readAll<std::int16_t>(*openSource(path, both)), volumeAt(t, c, values));
            }
        EXPECT_THAT(refusalOf([&] { openSource(path, {}); }),
                    AllOf(HasSubstr("2 volumes"), HasSubstr("--series N"), HasSubstr("channel 1 (bone")));
        SourceOptions seventh;
        seventh.series = 7;
        EXPECT_THAT(refusalOf([&] { openSource(path, seventh); }), HasSubstr("between 1 and 2"));
    }
}

TEST(ImportZarr, TimesOfOneChannelArePhases) {
    const ScratchFolder folder;
    std::vector<std::uint32_t> values(3 * 4 * 5 * 6);
    std::iota(values.begin(), values.end(), 100u);
    WrittenZarr zarr;
    zarr.type = "int16";
    zarr.shape = {3, 1, 4, 5, 6};
    zarr.chunk = {2, 1, 3, 2, 5};
    writeImage(folder / "image", zarr, values, "tczyx");
    SourceOptions phase, series;
    for (const int t : {1, 2, 3}) {
        phase.phase = series.series = t;
        const auto voxels = readAll<std::int16_t>(*openSource(folder / "image", phase));
        EXPECT_EQ(voxels, readAll<std::int16_t>(*openSource(folder / "image", series)));
        EXPECT_EQ(voxels.front(), 100 + 120 * (t - 1));
    }
    ASSERT_EQ(lookThrough(folder / "image").rows.size(), 1u);
    EXPECT_EQ(lookThrough(folder / "image").rows.front().phases.size(), 3u);
    phase.phase = 4;
    EXPECT_THAT(refusalOf([&] { openSource(folder / "image", phase); }), HasSubstr("between 1 and 3"));
    phase.phase = 1, phase.series = 2; // it has one channel
    EXPECT_THAT(refusalOf([&] { openSource(folder / "image", phase); }), HasSubstr("--series 1 or none"));
    zarr.shape = {1, 3, 4, 5, 6}; // channels are no phases
    zarr.chunk = {1, 1, 4, 5, 6};
    writeImage(folder / "channels", zarr, values, "tczyx");
    phase = {};
    phase.phase = 2;
    EXPECT_THAT(refusalOf([&] { openSource(folder / "channels", phase); }), HasSubstr("3 volumes"));
}

TEST(ImportZarr, AnArrayByItselfAsksForItsSpacing) {
    const ScratchFolder folder;
    WrittenZarr zarr;
    zarr.shape = zarr.chunk = kShape;
    writeZarrArray(folder / "a", zarr, zarrLabelValues(7 * 11 * 13));
    EXPECT_THAT(refusalOf([&] { openSource(folder / "a", {}); }), HasSubstr("--spacing"));
    EXPECT_FALSE(openSource(folder / "a", oneMm())->info().orientationKnown);
    zarr.shape = zarr.chunk = {11, 13};
    writeZarrArray(folder / "flat", zarr, zarrLabelValues(11 * 13));
    EXPECT_THAT(refusalOf([&] { openSource(folder / "flat", oneMm()); }), HasSubstr("three axes"));
    writeZarrGroup(folder / "group", 3, Json::object());
    EXPECT_THAT(refusalOf([&] { openSource(folder / "group", {}); }), HasSubstr("multiscales"));
}

TEST(ImportZarr, VoxelsWithoutANumberBecomeTheLowestValue) {
    const ScratchFolder folder;
    WrittenZarr zarr;
    zarr.type = "float32";
    zarr.shape = {4, 4, 4};
    zarr.chunk = {2, 4, 4};
    std::vector<std::uint32_t> values(64);
    std::iota(values.begin(), values.end(), 7u);
    writeZarrArray(folder / "a", zarr, values);
    fs::remove(folder / "a" / "c" / "0" / "0" / "0"); // its fill is no number
    Json metadata = arrayMetadata(zarr);
    for (const char* fill : {"NaN", "-Infinity", "0x7fc00000"}) {
        metadata["fill_value"] = fill;
        writeJson(folder / "a" / "zarr.json", metadata);
        const auto source = openSource(folder / "a", oneMm());
        const auto read = readAll<float>(*source);
        EXPECT_EQ(source->info().nonFiniteVoxels, 32u);
        EXPECT_EQ(read.front(), 7 + 32);
        EXPECT_EQ(read.back(), 7 + 63);
    }
    metadata["fill_value"] = -2.5;
    writeJson(folder / "a" / "zarr.json", metadata);
    EXPECT_EQ(readAll<float>(*openSource(folder / "a", oneMm())).front(), -2.5f);
    for (const Json& fill : {Json("nan"), Json("0x7fc0"), Json(Json::array())}) {
        metadata["fill_value"] = fill;
        writeJson(folder / "a" / "zarr.json", metadata);
        EXPECT_THAT(refusalOf([&] { openSource(folder / "a", oneMm()); }), HasSubstr("fill_value"));
    }
}

/// A file of chunks: by its place in the grid of files.
fs::path fileOf(const fs::path& array, const WrittenZarr& zarr, const std::string& place) {
    return array / (zarr.version == 2 ? place : "c/" + place);
}

TEST(ImportZarr, ChunksThatAreNotThereAreCounted) {
    const ScratchFolder folder;
    int number = 0;
    for (const int version : {2, 3})
        for (const bool isSharded : {false, true}) {
            if (version == 2 && isSharded)
                continue;
            WrittenZarr zarr;
            zarr.version = version;
            zarr.type = "int16";
            zarr.fill = -7;
            zarr.shape = {8, 6, 6};
            zarr.chunk = {2, 3, 3}; // 16 chunks
            if (isSharded)
                zarr.shard = {4, 6, 6}; // 8 chunks in each of two
            std::vector<std::uint32_t> values(8 * 6 * 6);
            std::iota(values.begin(), values.end(), 1u);
            if (isSharded) // a chunk that its shard leaves out is fill, and not missing
                for (std::size_t z = 0; z < 2; ++z)
                    for (std::size_t y = 0; y < 3; ++y)
                        for (std::size_t x = 0; x < 3; ++x)
                            values[(z * 6 + y) * 6 + x] = static_cast<std::uint32_t>(-7);
            const fs::path path = folder / std::to_string(number++);
            writeZarrArray(path, zarr, values);
            const auto whole = openSource(path, oneMm());
            EXPECT_EQ(readAll<std::int16_t>(*whole), as<std::int16_t>(values));
            EXPECT_THAT(whole->notes(), ElementsAre()) << path;
            fs::remove(fileOf(path, zarr, "1/0/0"));
            if (!isSharded)
                fs::remove(fileOf(path, zarr, "3/1/1"));
            const auto source = openSource(path, oneMm());
            EXPECT_THAT(source->notes(), ElementsAre());
            const auto read = readAll<std::int16_t>(*source);
            EXPECT_THAT(source->notes(),
                        ElementsAre(AllOf(HasSubstr(isSharded ? "8 of 16 chunks" : "2 of 16 chunks"),
                                          HasSubstr("1/0/0 is the first"), HasSubstr("fill value, -7"))));
            EXPECT_EQ(std::ranges::count(read, -7), isSharded ? 8 * 18 + 18 : 2 * 18);
            fs::remove_all(version == 2 ? path / "0" : path / "c");
            for (const char* layer : {"1", "2", "3"})
                fs::remove_all(path / layer);
            EXPECT_THAT(refusalOf([&] { readAll<std::int16_t>(*openSource(path, oneMm())); }),
                        AllOf(HasSubstr("0/0/0: expected a chunk"), HasSubstr("none of the volume's 16")));
        }
}

TEST(ImportZarr, ASeparatorThatIsNotSaidIsFoundByTheChunks) {
    const ScratchFolder folder;
    const auto values = zarrLabelValues(7 * 11 * 13);
    int number = 0;
    for (const char* separator : {".", "/"})
        for (const char* lost : {"", "0/0/0", "1/1/1"}) { // the first, the middle
            WrittenZarr zarr;
            zarr.version = 2;
            zarr.shape = kShape;
            zarr.chunk = {3, 4, 5};
            zarr.separator = separator;
            zarr.leavesOutFill = false;
            const fs::path path = folder / std::to_string(number++);
            writeZarrArray(path, zarr, values);
            Json metadata = arrayMetadata(zarr);
            metadata.erase("dimension_separator");
            writeJson(path / ".zarray", metadata);
            std::string name = lost;
            std::ranges::replace(name, '/', *separator);
            ASSERT_TRUE(name.empty() || fs::remove(path / name));
            const auto source = openSource(path, oneMm());
            const auto read = readAll<std::uint16_t>(*source);
            std::size_t other = 0;
            for (std::size_t i = 0; i < read.size(); ++i)
                other += read[i] != values[i];
            EXPECT_LE(other, name.empty() ? 0u : 60u) << path;
            EXPECT_EQ(*separator == '/',
                      !source->notes().empty() &&
                          source->notes()[0].find("metadata do not say") != std::string::npos)
                << path;
        }
}

TEST(ImportZarr, FillValuesOfVersion2AreTakenAsProgramsWriteThem) {
    const ScratchFolder folder;
    WrittenZarr zarr;
    zarr.version = 2;
    zarr.shape = {4, 4, 4};
    zarr.chunk = {2, 4, 4};
    std::vector<std::uint32_t> values(64);
    std::iota(values.begin(), values.end(), 7u);
    for (const char* type : {"int16", "float32", "float64"}) {
        zarr.type = type;
        writeZarrArray(folder / type, zarr, values);
        fs::remove(folder / type / "0/0/0");
        Json metadata = arrayMetadata(zarr);
        const auto firstWith = [&](const Json& fill) {
            metadata["fill_value"] = fill;
            writeJson(folder / type / ".zarray", metadata);
            const auto source = openSource(folder / type, oneMm());
            return type == std::string("int16") ? readAll<std::int16_t>(*source).front()
                                                : readAll<float>(*source).front();
        };
        for (const Json& fill : {Json("-3"), Json("-3.0"), Json(-3.0), Json(Json::array({-3})),
                                 Json(Json::array({"-3"})), Json(-3)})
            EXPECT_EQ(firstWith(fill), -3) << type << fill;
        EXPECT_EQ(firstWith(nullptr), 0);
        for (const Json& fill : {Json("three"), Json(""), Json("0x3"), Json(Json::array({1, 2})),
                                 Json(Json::object()), Json("3 ")})
            EXPECT_THAT(refusalOf([&] { firstWith(fill); }), HasSubstr("fill_value")) << type << fill;
        if (type != std::string("int16"))
            continue;
        for (const Json& fill : {Json(-3.5), Json("-3.5"), Json("40000"), Json(1e30), Json("1e400")})
            EXPECT_THAT(refusalOf([&] { firstWith(fill); }), HasSubstr("fill_value")) << fill;
    }
}

TEST(ImportZarr, MetadataThatAreNotNeededRefuseNothing) {
    const ScratchFolder folder;
    for (const int version : {2, 3}) {
        WrittenZarr zarr;
        zarr.version = version;
        zarr.shape = zarr.chunk = {1, 7, 11, 13};
        const fs::path path = folder / std::to_string(version);
        writeImage(path, zarr, zarrLabelValues(7 * 11 * 13), "tzyx");
        const fs::path file = path / (version == 2 ? ".zattrs" : "zarr.json");
        std::ifstream in(file);
        Json document = Json::parse(in);
        Json& ome = version == 2 ? document : document["attributes"]["ome"];
        Json& places = ome["multiscales"][0]["datasets"][0]["coordinateTransformations"];
        for (const double step : {0.0, -1.0, 1e13}) { // between times
            places[0]["scale"][0] = step;
            writeJson(file, document);
            EXPECT_EQ(openSource(path, {})->info().spacingMm(), glm::dvec3(0.25, 0.5, 2)) << step;
            places[0]["scale"][1] = step;
            writeJson(file, document);
            EXPECT_THAT(refusalOf([&] { openSource(path, {}); }), HasSubstr("scales above 0"));
            places[0]["scale"][1] = 2;
        }
        ome["version"] = "2.1"; // of version 2 a converter's
        writeJson(file, document);
        if (version == 2)
            EXPECT_EQ(openSource(path, {})->info().spacingMm(), glm::dvec3(0.25, 0.5, 2));
        else
            EXPECT_THAT(refusalOf([&] { openSource(path, {}); }), HasSubstr("version"));
        ome["version"] = version == 2 ? "0.4" : "0.5";
        writeJson(file, document);
        if (version == 3)
            continue;
        for (const char* attributes : {"{\"spacing\": NaN}", "{\"a\": 1, \"a\": 2}", "{"}) {
            writeFile(path / "full/.zattrs", attributes);
            EXPECT_EQ(openSource(path, {})->info().extentVoxels, glm::ivec3(13, 11, 7)) << attributes;
        }
    }
}

TEST(ImportZarr, TheImagesOfBioformats2rawAreFoundBelowTheirGroup) {
    const ScratchFolder folder;
    int number = 0;
    for (const int version : {2, 3})
        for (const bool hasList : {false, true}) {
            const fs::path group = folder / std::to_string(number++);
            WrittenZarr zarr;
            zarr.version = version;
            zarr.shape = zarr.chunk = kShape;
            const auto values = zarrLabelValues(7 * 11 * 13);
            const Json layout = {{"bioformats2raw.layout", 3}};
            writeZarrGroup(group, version, layout);
            EXPECT_THAT(refusalOf([&] { openSource(group, {}); }), HasSubstr("multiscales"));
            const std::string first = hasList ? "a" : "0", second = hasList ? "b" : "1";
            const auto list = [&](const Json& names) {
                if (hasList)
                    writeZarrGroup(group / "OME", version, {{"series", names}});
            };
            writeImage(group / first, zarr, values, "zyx");
            list(Json::array({first}));
            const auto only = openSource(group, {});
            EXPECT_EQ(readAll<std::uint16_t>(*only), as<std::uint16_t>(values));
            EXPECT_THAT(only->notes(), testing::Contains(HasSubstr("the image is " + first)));
            writeImage(group / second, zarr, values, "zyx");
            list(Json::array({first, second}));
            EXPECT_THAT(
                refusalOf([&] { openSource(group, {}); }),
                AllOf(HasSubstr("2 of them: " + first + ", " + second), HasSubstr((group / first).string())));
            EXPECT_EQ(openSource(group / second, {})->info().extentVoxels, glm::ivec3(13, 11, 7));
            if (!hasList)
                continue;
            list(Json::array({"../../etc"}));
            EXPECT_THAT(refusalOf([&] { openSource(group, {}); }), HasSubstr("a path below the group"));
        }
}

TEST(ImportZarr, LinksThatMetadataNameAreNotFollowed) {
    const ScratchFolder folder;
    WrittenZarr zarr;
    zarr.shape = zarr.chunk = kShape;
    writeImage(folder / "image", zarr, zarrLabelValues(7 * 11 * 13), "zyx");
    fs::rename(folder / "image/full", folder / "elsewhere");
    fs::create_directory_symlink(folder / "elsewhere", folder / "image/full");
    EXPECT_THAT(refusalOf([&] { openSource(folder / "image", {}); }),
                AllOf(HasSubstr("image/full"), HasSubstr("a symbolic link")));
    fs::create_directory_symlink(folder / "elsewhere", folder / "link"); // which a user names
    EXPECT_EQ(openSource(folder / "link", oneMm())->info().extentVoxels, glm::ivec3(13, 11, 7));
}

// A link that takes the array's place once it is open is not followed either.
TEST(ImportZarr, AnOpenArrayStaysWhereItIs) {
    const ScratchFolder folder;
    const auto values = zarrLabelValues(7 * 11 * 13);
    WrittenZarr zarr;
    zarr.shape = kShape;
    zarr.chunk = {3, 4, 5};
    writeImage(folder / "image", zarr, values, "zyx");
    writeZarrArray(folder / "elsewhere", zarr, std::vector<std::uint32_t>(values.size(), 3));
    const auto source = openSource(folder / "image", {});
    fs::rename(folder / "image/full", folder / "image/aside");
    fs::create_directory_symlink(folder / "elsewhere", folder / "image/full");
    EXPECT_EQ(readAll<std::uint16_t>(*source), as<std::uint16_t>(values));
}

// Python's writers put numbers into attributes that JSON does not have.
TEST(ImportZarr, NaNAndInfinityInAttributesAreIgnored) {
    const ScratchFolder folder;
    const auto values = zarrLabelValues(7 * 11 * 13);
    const std::string more =
        "\"weights\": [NaN, -Infinity, Infinity, 1], \"text \\\"NaN\": \"Infinity \\\\\", ";
    for (const int version : {2, 3}) {
        WrittenZarr zarr;
        zarr.version = version;
        zarr.shape = zarr.chunk = kShape;
        const fs::path path = folder / std::to_string(version);
        writeImage(path, zarr, values, "zyx");
        const fs::path file = path / (version == 2 ? ".zattrs" : "zarr.json");
        std::string text = fileText(file);
        const std::string where = version == 2 ? "{" : "\"attributes\":";
        std::size_t at = text.find(where);
        ASSERT_NE(at, std::string::npos) << text;
        at = text.find('{', at) + 1;
        writeFile(file, text.substr(0, at) + more + text.substr(at));
        const auto source = openSource(path, {});
        EXPECT_EQ(readAll<std::uint16_t>(*source), as<std::uint16_t>(values));
        EXPECT_THAT(source->notes(), ::testing::Contains(HasSubstr("3 values NaN or Infinity are ignored")));
        // Where a number is needed it is none.
        text = fileText(file);
        at = text.find("0.25");
        ASSERT_NE(at, std::string::npos);
        writeFile(file, text.replace(at, 4, "NaN"));
        EXPECT_THAT(refusalOf([&] { openSource(path, {}); }), HasSubstr("scale"));
    }
    // The metadata of an array stay strict: a fill value is one of them.
    WrittenZarr zarr;
    zarr.type = "float32";
    zarr.shape = zarr.chunk = kShape;
    writeZarrArray(folder / "array", zarr, values);
    std::string text = fileText(folder / "array/zarr.json");
    const std::size_t at = text.find("\"fill_value\":");
    ASSERT_NE(at, std::string::npos) << text;
    const std::size_t end = text.find_first_of(",}\n", at);
    writeFile(folder / "array/zarr.json", text.substr(0, at) + "\"fill_value\": NaN" + text.substr(end));
    EXPECT_THAT(refusalOf([&] { openSource(folder / "array", oneMm()); }), HasSubstr("zarr.json"));
}

TEST(ImportZarr, SlicesOfTooManyChunksAreRefused) {
    const ScratchFolder folder;
    WrittenZarr zarr;
    zarr.shape = {2, 4096, 4096};
    zarr.chunk = {2, 1, 1};
    writeJson(folder / "a/zarr.json", arrayMetadata(zarr));
    EXPECT_THAT(refusalOf([&] { openSource(folder / "a", oneMm()); }),
                AllOf(HasSubstr("at most 4194304 chunks across a slice"), HasSubstr("4096 x 4096")));
    zarr.chunk = {2, 2, 2}; // as many as may be
    writeJson(folder / "a/zarr.json", arrayMetadata(zarr));
    EXPECT_EQ(openSource(folder / "a", oneMm())->info().extentVoxels, glm::ivec3(4096, 4096, 2));
}

TEST(ImportZarr, TheTableHasSizesAndSpacingsOfTheFilesAxes) {
    const ScratchFolder folder;
    WrittenZarr zarr;
    zarr.shape = zarr.chunk = kShape; // 13 columns, 11 rows, 7 slices
    for (const char* axes : {"zyx", "xyz", "yzx", "xzy"}) {
        const fs::path path = folder / axes;
        writeImage(path, zarr, zarrLabelValues(7 * 11 * 13), axes);
        const Catalogue catalogue = lookThrough(path);
        EXPECT_EQ(catalogue.rows.front().slices, 7) << axes;
        EXPECT_THAT(tableOf(catalogue), AllOf(HasSubstr("13 x 11 "), HasSubstr("0.250 x 0.500 x 2.000")));
    }
}

TEST(ImportZarr, WhatLz4SaysIsChecked) {
    const ScratchFolder folder;
    WrittenZarr zarr;
    zarr.version = 2;
    zarr.shape = zarr.chunk = kShape;
    zarr.compressor = "lz4";
    writeZarrArray(folder / "a", zarr, zarrLabelValues(7 * 11 * 13));
    const fs::path chunk = folder / "a" / "0/0/0";
    std::ifstream in(chunk, std::ios::binary);
    const std::string good{std::istreambuf_iterator<char>(in), {}};
    const auto refusal = [&](const std::string& bytes) {
        writeFile(chunk, bytes);
        return refusalOf([&] { readAll<std::uint16_t>(*openSource(folder / "a", oneMm())); });
    };
    EXPECT_THAT(refusal(good.substr(0, 3)), HasSubstr("0/0/0"));
    EXPECT_THAT(refusal(good.substr(0, 20)), HasSubstr("decoded bytes"));
    EXPECT_THAT(refusal(good.substr(0, good.size() - 9)), HasSubstr("lz4"));
    std::string lying = good;
    lying[3] = '\x7f'; // 2 GiB
    EXPECT_THAT(refusal(lying), HasSubstr("decoded bytes"));
}

TEST(ImportZarr, ArraysOfOtherProgramsReadAsTheyWereWritten) {
    const fs::path top = testData() / "zarr-foreign" / "zarrita";
    if (!fs::exists(top))
        GTEST_SKIP() << "no arrays of other programs: TESSERA_TEST_DATA";
    int arrays = 0;
    for (const char* version : {"v2", "v3"})
        for (const auto& entry : fs::directory_iterator(top / version / "data.zarr")) {
            const std::string name = entry.path().filename().string();
            if (!name.starts_with("3d.") || name.find(".i2") == std::string::npos)
                continue;
            const auto source = openSource(entry.path(), oneMm());
            std::vector<std::int16_t> expected(source->info().voxelCount()); // 0, 1, 2, ...
            std::iota(expected.begin(), expected.end(), std::int16_t{0});
            EXPECT_EQ(readAll<std::int16_t>(*source), expected) << entry.path();
            const glm::ivec3 extent = source->info().extentVoxels;
            SourceOptions box = oneMm();
            box.fileBox = FileBox{extent / 3, extent - extent / 4};
            const auto part = openSource(entry.path(), box);
            std::vector<std::int16_t> inBox;
            for (int z = box.fileBox->low.z; z < box.fileBox->high.z; ++z)
                for (int y = box.fileBox->low.y; y < box.fileBox->high.y; ++y)
                    for (int x = box.fileBox->low.x; x < box.fileBox->high.x; ++x)
                        inBox.push_back(expected[indexOf(source->info(), x, y, z)]);
            EXPECT_EQ(readAll<std::int16_t>(*part), inBox) << entry.path();
            ++arrays;
        }
    EXPECT_GE(arrays, 11);
}

} // namespace
} // namespace tessera::test
