// tests/bricking/import/files/stack_ome_test.cpp: OME-TIFF: planes in one file or many, in every order of
// axes, channels and points of time, sets of files in folders, and descriptions that lie.
#include "bricking/import/catalogue.h"
#include "bricking/import/files/stack/ome_planes.h"
#include "bricking/import/source/time_units.h"
#include "tests/support/stack_writers.h"

#include <cmath>
#include <cstdlib>
#include <ctime>
#include <gmock/gmock.h>
#include <numeric>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace tessera::test {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;

using ::testing::HasSubstr;

namespace fs = std::filesystem;

constexpr int kOmeWidth = 5, kOmeHeight = 6;

struct Sizes {
    int z = 1, c = 1, t = 1;
    int all() const { return z * c * t; }
};

std::string omeOf(const Sizes& n, const std::string& order, const std::string& inside,
                  const std::string& uuid = "urn:uuid:0") {
    return "<?xml version=\"1.0\"?><!-- <Pixels SizeZ=\"9\"> --><OME UUID=\"" + uuid +
           "\"><Image ID=\"Image:0\"><Pixels DimensionOrder=\"" + order +
           "\" SizeX=\"5\" SizeY=\"6\" SizeZ=\"" + std::to_string(n.z) + "\" SizeC=\"" + std::to_string(n.c) +
           "\" SizeT=\"" + std::to_string(n.t) +
           "\" PhysicalSizeX=\"0.5\" PhysicalSizeXUnit=\"&#181;m\" PhysicalSizeY=\"0.25\" "
           "PhysicalSizeZ=\"2\">" +
           inside + "</Pixels></Image></OME>";
}

/// A page that has the pixels of slice `number`; several numbers: pages.
std::string tiffOf(const std::vector<int>& numbers, const std::string& description) {
    OwnTiff tiff{.pages = static_cast<int>(numbers.size())};
    for (const int number : numbers)
        tiff.pixels += voxelBytes(sliceValues<std::uint16_t>(kOmeWidth, kOmeHeight, number));
    tiff.description = description;
    return tiff.bytes();
}

std::vector<std::uint16_t> valuesOf(const std::vector<int>& numbers) {
    std::vector<std::uint16_t> values;
    for (const int number : numbers)
        for (const std::uint16_t value : sliceValues<std::uint16_t>(kOmeWidth, kOmeHeight, number))
            values.push_back(value);
    return values;
}

std::string uuidOf(int file) {
    return "urn:uuid:" + std::to_string(file);
}
std::string nameOf(int file) {
    return "p" + std::to_string(file) + ".ome.tif";
}
std::string blockOf(int page, int z, int c, int t, int file, const std::string& more = " PlaneCount=\"1\"") {
    return "<TiffData IFD=\"" + std::to_string(page) + "\" FirstZ=\"" + std::to_string(z) + "\" FirstC=\"" +
           std::to_string(c) + "\" FirstT=\"" + std::to_string(t) + "\"" + more + "><UUID FileName=\"" +
           nameOf(file) + "\">" + uuidOf(file) + "</UUID></TiffData>";
}

// By the definition of DimensionOrder: the first axis goes up first.
// Every look at a folder reads the attributes of its files.
TEST(ImportOme, LongAttributesTakeTimeByTheirLength) {
    const ScratchFolder folder;
    for (const char one : {'x', '&'}) {
        writeFile(folder / "a.tif",
                  tiffOf({0, 1}, omeOf({2, 1, 1}, "XYZCT", "", std::string(std::size_t{1} << 20, one))));
        const std::clock_t begin = std::clock();
        EXPECT_EQ(readAll<std::uint16_t>(*openSource(folder / "a.tif", {})), valuesOf({0, 1}));
        EXPECT_LT(std::clock() - begin, 10 * CLOCKS_PER_SEC) << one; // milliseconds
    }
}

TEST(ImportOme, PlanesFollowTheOrderOfAxes) {
    const ScratchFolder folder;
    const Sizes n{2, 3, 4};
    for (const char* order : {"XYZCT", "XYZTC", "XYCZT", "XYCTZ", "XYTZC", "XYTCZ"}) {
        std::vector<int> pages(static_cast<std::size_t>(n.all()));
        writeFile(folder / "a.tif", tiffOf(pages, omeOf(n, order, "<TiffData/>")));
        const InputFile file(folder / "a.tif");
        const PictureHead head = walkPicture(file);
        const OmeText text = readOmeText(head.description);
        ASSERT_EQ(omeVolumesOf(text, "a.tif"), 12);
        const auto sizeOf = [&](char axis) { return axis == 'Z' ? n.z : axis == 'C' ? n.c : n.t; };
        for (int t = 0; t < n.t; ++t)
            for (int c = 0; c < n.c; ++c) {
                const OmePlanes planes = omePlanesOf(text, t * n.c + c, folder / "a.tif", head);
                ASSERT_EQ(planes.slices.size(), 2u);
                for (int z = 0; z < n.z; ++z) {
                    int page = 0, step = 1;
                    for (const char axis : std::string(order).substr(2)) {
                        page += step * (axis == 'Z' ? z : axis == 'C' ? c : t);
                        step *= sizeOf(axis);
                    }
                    EXPECT_EQ(planes.slices[static_cast<std::size_t>(z)].page, page) << order;
                }
            }
    }
}

TEST(ImportOme, ChannelsAndTimesAreListed) {
    const ScratchFolder folder;
    const auto listed = [&](const Sizes& n, const std::string& inside) {
        writeFile(folder / "a.tif",
                  tiffOf(std::vector<int>(static_cast<std::size_t>(n.all())), omeOf(n, "XYZCT", inside)));
        EXPECT_THAT(refusalOfOpening(folder / "a.tif"), HasSubstr(n.c > 1 ? "--series N" : "--phase N"));
        std::vector<std::string> names;
        for (const CatalogueRow& row : lookThrough(folder / "a.tif").rows)
            names.push_back(row.what);
        return names;
    };
    EXPECT_THAT(listed({2, 2, 1}, "<Channel Name=\"DAPI &amp; &lt;b\"/><Channel/><TiffData/>"),
                ElementsAre("channel 1 (\"DAPI & <b\")", "channel 2"));
    const std::string times = ", 2 phases for --phase (1: time 1, 2: time 2)";
    EXPECT_THAT(listed({2, 1, 2}, "<TiffData/>"), ElementsAre("a.tif" + times));
    EXPECT_THAT(listed({1, 2, 2}, "<TiffData/>"), ElementsAre("channel 1" + times, "channel 2" + times));
    EXPECT_EQ(listed({1, 30, 1}, "<TiffData/>").size(), 30u);
}

// By channel and time, by the number alone that counts channels first, and in every order of axes.
TEST(ImportOme, EveryChannelHasItsVoxelsAtEveryTime) {
    const ScratchFolder folder;
    const Sizes n{2, 3, 4};
    for (const std::string order : {"XYZCT", "XYZTC", "XYCZT", "XYCTZ", "XYTZC", "XYTCZ"}) {
        std::vector<int> pages(static_cast<std::size_t>(n.all()));
        std::iota(pages.begin(), pages.end(), 0);
        std::string text = omeOf(n, order, "<TiffData/>");
        text.replace(text.find("SizeX"), 0, "TimeIncrement=\"250\" TimeIncrementUnit=\"ms\" ");
        writeFile(folder / "a.tif", tiffOf(pages, text));
        const Catalogue catalogue = lookThrough(folder / "a.tif");
        ASSERT_EQ(catalogue.rows.size(), 3u);
        EXPECT_THAT(catalogue.rows[1].phases, ElementsAre("0 s", "0.25 s", "0.5 s", "0.75 s"));
        const auto sizeOf = [&](char axis) { return axis == 'Z' ? n.z : axis == 'C' ? n.c : n.t; };
        for (int t = 0; t < n.t; ++t)
            for (int c = 0; c < n.c; ++c) {
                std::vector<int> slices;
                for (int z = 0; z < n.z; ++z) {
                    int page = 0, step = 1;
                    for (const char axis : order.substr(2)) {
                        page += step * (axis == 'Z' ? z : axis == 'C' ? c : t);
                        step *= sizeOf(axis);
                    }
                    slices.push_back(page);
                }
                SourceOptions both, alone;
                both.series = c + 1, both.phase = t + 1;
                alone.series = t * n.c + c + 1;
                EXPECT_EQ(readAll<std::uint16_t>(*openSource(folder / "a.tif", both)), valuesOf(slices))
                    << order;
                EXPECT_EQ(readAll<std::uint16_t>(*openSource(folder / "a.tif", alone)), valuesOf(slices))
                    << order;
            }
        SourceOptions wrong;
        wrong.series = 4, wrong.phase = 1;
        EXPECT_THAT(refusalOfOpening(folder / "a.tif", wrong),
                    AllOf(HasSubstr("a.tif"), HasSubstr("1 and 3")));
        wrong.series = 3, wrong.phase = 5;
        EXPECT_THAT(refusalOfOpening(folder / "a.tif", wrong),
                    AllOf(HasSubstr("a.tif"), HasSubstr("1 and 4")));
    }
}

// The number of a channel is that of its first time in the list of all, so it stays what it was.
TEST(ImportOme, ImagesBehindTimesKeepTheirNumbers) {
    const ScratchFolder folder;
    const auto image = [](int times, const std::string& blocks) {
        return "<Image><Pixels DimensionOrder=\"XYZCT\" SizeX=\"5\" SizeY=\"6\" SizeZ=\"1\" SizeC=\"1\" "
               "SizeT=\"" +
               std::to_string(times) + "\" PhysicalSizeX=\"1\" PhysicalSizeY=\"1\" PhysicalSizeZ=\"1\">" +
               blocks + "</Pixels></Image>";
    };
    writeFile(folder / "a.tif",
              tiffOf({0, 1, 2, 3}, "<OME>" + image(3, "<TiffData IFD=\"0\" PlaneCount=\"3\"/>") +
                                       image(1, "<TiffData IFD=\"3\" PlaneCount=\"1\"/>") + "</OME>"));
    const Catalogue catalogue = lookThrough(folder / "a.tif");
    ASSERT_EQ(catalogue.rows.size(), 2u);
    EXPECT_EQ(catalogue.rows[0].series, 1);
    EXPECT_EQ(catalogue.rows[1].series, 4);
    for (int number = 1; number <= 4; ++number) {
        SourceOptions options;
        options.series = number;
        EXPECT_EQ(readAll<std::uint16_t>(*openSource(folder / "a.tif", options)), valuesOf({number - 1}));
    }
    SourceOptions wrong;
    wrong.series = 2, wrong.phase = 1;
    EXPECT_THAT(refusalOfOpening(folder / "a.tif", wrong),
                AllOf(HasSubstr("a.tif"), HasSubstr("of the table")));
}

// Cut at any page, or a description of more times than there are pages.
TEST(ImportOme, TimesThatAreNotThereAreRefused) {
    const ScratchFolder folder;
    const Sizes n{2, 2, 3};
    SourceOptions last;
    last.series = 2, last.phase = 3;
    const auto block = [](int page, int t) {
        return "<TiffData IFD=\"" + std::to_string(page) + "\" FirstT=\"" + std::to_string(t) +
               "\" PlaneCount=\"4\"/>";
    };
    const std::string blocks = block(0, 0) + block(4, 1) + block(8, 2);
    for (int pages = 1; pages < n.all(); ++pages) {
        std::vector<int> all(static_cast<std::size_t>(pages));
        writeFile(folder / "a.tif", tiffOf(all, omeOf(n, "XYZCT", blocks)));
        EXPECT_THAT(refusalOfOpening(folder / "a.tif", last), HasSubstr("a.tif")) << pages;
    }
    for (const Sizes& lie : {Sizes{2, 2, 1 << 30}, Sizes{1, 1, 2147483647}, Sizes{1, 1 << 30, 1 << 30}}) {
        writeFile(folder / "a.tif", tiffOf({0, 1}, omeOf(lie, "XYZCT", "<TiffData/>")));
        EXPECT_THAT(refusalOfOpening(folder / "a.tif", last), HasSubstr("2^20 planes at most"));
        EXPECT_THAT(refusalOfOpening(folder / "a.tif"), HasSubstr("2^20 planes at most"));
    }
    const std::string whole =
        tiffOf(std::vector<int>(static_cast<std::size_t>(n.all())), omeOf(n, "XYZCT", blocks));
    for (std::size_t bytes = 0; bytes < whole.size(); bytes += 97) {
        writeFile(folder / "a.tif", whole.substr(0, bytes));
        EXPECT_THAT(refusalOfOpening(folder / "a.tif", last), HasSubstr("a.tif")) << bytes;
    }
}

/// A set: every plane in a file of its own or with others, at random.
struct OmeSet {
    Sizes n;
    std::string blocks;
    std::vector<std::vector<int>> numbers; // of the pages of each file
    OmeSet(const Sizes& sizes, int files, unsigned seed)
        : n(sizes), numbers(static_cast<std::size_t>(files)) {
        std::mt19937 random(seed);
        for (int t = 0; t < n.t; ++t)
            for (int c = 0; c < n.c; ++c)
                for (int z = 0; z < n.z; ++z) {
                    const int number = (t * n.c + c) * n.z + z,
                              file = number < files ? number : static_cast<int>(random()) & (files - 1);
                    auto& pages = numbers[static_cast<std::size_t>(file)];
                    blocks += blockOf(static_cast<int>(pages.size()), z, c, t, file);
                    pages.push_back(number);
                }
    }
    void write(const fs::path& folder) const {
        for (std::size_t file = 0; file < numbers.size(); ++file) {
            const int number = static_cast<int>(file);
            writeFile(folder / nameOf(number),
                      tiffOf(numbers[file], omeOf(n, "XYZCT", blocks, uuidOf(number))));
        }
    }
};

TEST(ImportOme, SetsOfFilesAreOneVolume) {
    const ScratchFolder folder;
    for (const int files : {1, 2, 4, 8}) {
        const OmeSet set({8, 1, 1}, files, static_cast<unsigned>(files));
        set.write(folder.path());
        std::vector<int> order(8);
        for (int z = 0; z < 8; ++z)
            order[static_cast<std::size_t>(z)] = z;
        for (int file = 0; file < files; ++file) {
            const auto source = openSource(folder / nameOf(file), {});
            EXPECT_EQ(source->info().spacingMm(), glm::dvec3(0.5e-3, 0.25e-3, 2e-3));
            EXPECT_EQ(readAll<std::uint16_t>(*source), valuesOf(order)) << files;
        }
        EXPECT_EQ(lookThrough(folder.path()).rows.size(), 1u) << files;
        EXPECT_EQ(readAll<std::uint16_t>(*openSource(folder.path(), {})), valuesOf(order)) << files;
        EXPECT_EQ(namedFilesOf(folder / nameOf(0)).size(), static_cast<std::size_t>(files - 1));
    }
}

TEST(ImportOme, EveryVolumeOfASetHasItsPlanes) {
    const ScratchFolder folder;
    const OmeSet set({3, 2, 2}, 4, 7);
    set.write(folder.path());
    const PictureHead head = walkPicture(InputFile(folder / nameOf(2)));
    const OmeText text = readOmeText(head.description);
    for (int volume = 0; volume < 4; ++volume) {
        const OmePlanes planes = omePlanesOf(text, volume, folder / nameOf(2), head);
        for (int z = 0; z < 3; ++z) {
            const SlicePage slice = planes.slices[static_cast<std::size_t>(z)];
            const std::string name = planes.files[slice.file].filename().string();
            const int file = name[1] - '0';
            EXPECT_EQ(set.numbers[static_cast<std::size_t>(file)][static_cast<std::size_t>(slice.page)],
                      volume * 3 + z);
        }
    }
}

// Another reader of such sets.
TEST(ImportOme, TifffileReadsTheSameSet) {
    const std::string python = "/usr/bin/python3 -c '";
    if (std::system((python + "import tifffile' 2>/dev/null").c_str()) != 0)
        GTEST_SKIP() << "no python3-tifffile";
    const ScratchFolder folder;
    const OmeSet set({6, 1, 1}, 4, 3);
    set.write(folder.path());
    const std::string run =
        python + "import tifffile; tifffile.imread(\"" + (folder / nameOf(0)).string() + "\").tofile(\"" +
        (folder / "read").string() + "\"); import numpy; tifffile.imwrite(\"" + (folder / "w.tif").string() +
        "\", numpy.arange(120, dtype=\"int16\").reshape(4, 5, 6), ome=True, metadata={\"axes\": \"ZYX\", "
        "\"PhysicalSizeX\": 0.5, \"PhysicalSizeY\": 0.25, \"PhysicalSizeZ\": 2.0})' 2>/dev/null";
    ASSERT_EQ(std::system(run.c_str()), 0);
    std::vector<std::uint16_t> read(6 * kOmeWidth * kOmeHeight);
    std::ifstream(folder / "read", std::ios::binary)
        .read(reinterpret_cast<char*>(read.data()), static_cast<std::streamsize>(2 * read.size()));
    EXPECT_EQ(readAll<std::uint16_t>(*openSource(folder / nameOf(0), {})), read);
    const auto written = openSource(folder / "w.tif", {});
    EXPECT_EQ(written->info().spacingMm(), glm::dvec3(0.5e-3, 0.25e-3, 2e-3));
    const std::vector<std::int16_t> values = readAll<std::int16_t>(*written);
    for (std::size_t i = 0; i < 120; ++i)
        ASSERT_EQ(values[i], static_cast<int>(i));
}

// All pages of a file without numbers; the file itself under another name; the description in another file.
TEST(ImportOme, NamesAndNumbersMayBeLeftOut) {
    const ScratchFolder folder;
    const auto block = [](int z, int file) {
        return "<TiffData FirstZ=\"" + std::to_string(z) + "\"><UUID FileName=\"" + nameOf(file) + "\">" +
               uuidOf(file) + "</UUID></TiffData>";
    };
    const Sizes n{5, 1, 1};
    writeFile(folder / nameOf(1), tiffOf({3, 4}, "<OME UUID=\"urn:uuid:1\"><BinaryOnly MetadataFile=\"" +
                                                     nameOf(0) + "\" UUID=\"urn:uuid:0\"/></OME>"));
    writeFile(folder / "renamed.tif",
              tiffOf({0, 1, 2}, omeOf(n, "XYZCT", block(0, 0) + block(3, 1), uuidOf(0))));
    EXPECT_EQ(readAll<std::uint16_t>(*openSource(folder / "renamed.tif", {})), valuesOf({0, 1, 2, 3, 4}));
    EXPECT_THAT(openSource(folder.path(), {})->describe(),
                HasSubstr("OME-TIFF of 5 slices in 2 files, uint16"));
    EXPECT_EQ(lookThrough(folder.path()).rows.size(), 1u);
    EXPECT_THAT(refusalOfOpening(folder / nameOf(1)), HasSubstr("\"p0.ome.tif\""));
    writeFile(folder / nameOf(1), tiffOf({3, 4}, omeOf(n, "XYZCT", "", "urn:uuid:7")));
    EXPECT_THAT(refusalOfOpening(folder / "renamed.tif"),
                AllOf(HasSubstr("p1.ome.tif"), HasSubstr("of another set")));
    writeFile(folder / nameOf(1), tiffOf({3, 4}, ""));
    EXPECT_EQ(openSource(folder / "renamed.tif", {})->info().extentVoxels.z, 5);
    fs::remove(folder / nameOf(1));
    EXPECT_THAT(refusalOfOpening(folder / "renamed.tif"), HasSubstr("p1.ome.tif"));
}

TEST(ImportOme, DescriptionsThatLieAreRefused) {
    const ScratchFolder folder;
    writeFile(folder / nameOf(1), tiffOf({2, 3}, ""));
    const auto expectRefusal = [&](const std::string& description, const char* what,
                                   const char* file = "a.tif") {
        writeFile(folder / "a.tif", tiffOf({0, 1}, description));
        EXPECT_THAT(refusalOfOpening(folder / "a.tif"), AllOf(HasSubstr(file), HasSubstr(what)));
    };
    const auto with = [&](const std::string& inside, int slices = 2) {
        return omeOf({slices, 1, 1}, "XYZCT", inside);
    };
    const std::string own = "<TiffData IFD=\"0\" PlaneCount=\"2\"/>";
    writeFile(folder / "a.tif", tiffOf({0, 1}, with(own)));
    EXPECT_EQ(openSource(folder / "a.tif", {})->info().extentVoxels.z, 2);
    expectRefusal(with("", 3), "page 3, as OME's description says");
    expectRefusal(with("", 1), "1 pages, as its description says");
    expectRefusal(with("", 0), "at least 1");
    expectRefusal(with(own, 3), "none for slice 3 of 3");
    expectRefusal(with("<TiffData IFD=\"1\" PlaneCount=\"2\"/>"), "page 3, as OME's description says");
    expectRefusal(with("<TiffData IFD=\"0\" PlaneCount=\"3\"/>"), "3 from plane 1 of 2 on");
    expectRefusal(with("<TiffData IFD=\"0\" PlaneCount=\"2147483648\"/>"), "from plane 1 of 2 on");
    expectRefusal(with("<TiffData IFD=\"0\" PlaneCount=\"0\"/>"), "0 from plane 1");
    expectRefusal(with("<TiffData IFD=\"x\"/>"), "IFD of TiffData");
    expectRefusal(with("<TiffData FirstZ=\"2\"/>"), "planes that the image has");
    expectRefusal(with(own + "<TiffData IFD=\"1\"/>"), "every plane once, found two pages of slice 1");
    expectRefusal(with(own + blockOf(2, 2, 0, 0, 1), 3), "page 3, as OME's", "p1.ome.tif");
    expectRefusal(with("<TiffData><UUID FileName=\"../b.tif\">u</UUID></TiffData>"), "in its folder");
    expectRefusal(with("<TiffData><UUID FileName=\"/b.tif\">u</UUID></TiffData>"), "in its folder");
    expectRefusal(omeOf({2, 1, 1}, "XYZC", ""), "DimensionOrder");
    expectRefusal(omeOf({2, 1, 1}, "ZXYCT", ""), "DimensionOrder");
    expectRefusal(omeOf({2147483647, 1, 1}, "XYZCT", ""), "2^20 planes at most");
    expectRefusal(omeOf({1048576, 1, 1}, "XYZCT", own), "none for slice 3");
    std::string wide = with(own);
    wide.replace(wide.find("SizeX=\"5\""), 9, "SizeX=\"7\"");
    expectRefusal(wide, "SizeX of OME's description as in the pages, found 7 and 5");
    const std::string whole = with(own);
    for (std::size_t n = whole.find("SizeX"); n < whole.size(); ++n) { // before, nothing is said of planes
        writeFile(folder / "a.tif", tiffOf({0, 1}, whole.substr(0, n)));
        ASSERT_THAT(refusalOfOpening(folder / "a.tif"), HasSubstr("a.tif")) << n;
    }
    OwnTiff other{.width = 6, .pages = 1, .pixels = std::string(72, 'x')};
    writeFile(folder / nameOf(1), other.bytes());
    expectRefusal(with(own + blockOf(0, 2, 0, 0, 1), 3), "of the size, type and tiles", "p1.ome.tif");
    std::mt19937 random(4711);
    const std::string set = with(own + blockOf(0, 2, 0, 0, 1), 3);
    writeFile(folder / nameOf(1), tiffOf({2, 3}, ""));
    for (int n = 0; n < 500; ++n) {
        std::string bytes = set;
        for (std::size_t i = 0; i < 1 + random() % 3; ++i)
            bytes[random() % bytes.size()] =
                static_cast<char>(n % 3 ? '0' + random() % 10 : 1 + random() % 255);
        writeFile(folder / "a.tif", tiffOf({0, 1}, bytes));
        expectHarmless(folder / "a.tif", kCubes);
    }
}

TEST(ImportOme, TagsAndAttributesOfXml) {
    const auto tags =
        xmlTagsOf("<?x <y> ?><!DOCTYPE z><a:b  c = 'd>e' f=\"1\"> t <![CDATA[<no>]]></a:b><g/><h");
    ASSERT_EQ(tags.size(), 3u);
    EXPECT_EQ(tags[0].name, "b");
    EXPECT_TRUE(tags[0].opens && !tags[0].closes);
    EXPECT_EQ(xmlAttribute(tags[0], "c"), "d>e");
    EXPECT_EQ(xmlAttribute(tags[0], "f"), "1");
    EXPECT_EQ(xmlAttribute(tags[0], "d"), "");
    EXPECT_EQ(tags[0].text, " t ");
    EXPECT_TRUE(!tags[1].opens && tags[1].closes);
    EXPECT_EQ(tags[2].name, "g");
    EXPECT_TRUE(tags[2].opens && tags[2].closes);
    const auto other = xmlTagsOf("<a x=\"&lt;&gt;&quot;&apos;&amp;amp;&#xB5;&#956;&no;&\"/>");
    ASSERT_EQ(other.size(), 1u);
    EXPECT_EQ(xmlAttribute(other[0], "x"), "<>\"'&amp;\xc2\xb5\xce\xbc&");
}

// Every name of a unit is so many of the next smaller one.
TEST(TimeUnits, AreSoManyOfTheNextSmaller) {
    const std::vector<std::pair<std::vector<std::string>, double>> chain = {
        {{"ns", "nanosecond"}, 1e-9},
        {{"us", "\xc2\xb5s", "\xce\xbcs", "microsecond"}, 1000},
        {{"ms", "msec", "millisecond", "milliseconds"}, 1000},
        {{"s", "sec", "second", "seconds"}, 1000},
        {{"min", "minute", "minutes"}, 60},
        {{"h", "hour", "hours"}, 60},
        {{"d", "day"}, 24}};
    double seconds = 1;
    for (const auto& [names, many] : chain) {
        seconds *= many;
        for (const std::string& name : names)
            EXPECT_NEAR(secondsOf(name) / seconds, 1, 1e-12) << name;
    }
    for (const char* none : {"", "mm", "S", "frames"})
        EXPECT_EQ(secondsOf(none), 0) << none;
    EXPECT_EQ(stepSecondsOf(2.5, "min"), 150);
    for (const double step : {0.0, -1.0, 1e13, std::nan("")})
        EXPECT_EQ(stepSecondsOf(step, "s"), 0) << step;
}

} // namespace
} // namespace tessera::test
