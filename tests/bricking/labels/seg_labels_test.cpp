// tests/bricking/labels/seg_labels_test.cpp: DICOM Segmentations: those of others equal to their twins in
// NRRD and to what DCMTK's own reader says; those that the test writes, with overlaps, gaps, in every coding;
// what is refused.
#include "bricking/import/labels/open_labels.h"
#include "bricking/import/open_source.h"
#include "bricking/labels/label_import.h"
#include "tests/support/label_file_tools.h"
#include "tests/support/segmentation_writer.h"
#include "tests/support/stream_writer.h"

#include <dcmtk/config/osconfig.h>
#include <dcmtk/dcmdata/dctk.h>
#include <dcmtk/dcmseg/segdoc.h>
#include <dcmtk/dcmseg/segment.h>
#include <dcmtk/dcmseg/segutils.h>
#include <random>

namespace tessera::test {
namespace {

using testing::Contains;
using testing::HasSubstr;

constexpr std::size_t kFramePixels = 3 * 5;

std::vector<std::uint16_t> someMask(unsigned seed) {
    std::mt19937 random(seed);
    std::vector<std::uint16_t> pixels(kFramePixels);
    for (std::uint16_t& pixel : pixels)
        pixel = random() % 2;
    pixels[seed % kFramePixels] = 1; // never empty
    return pixels;
}

/// The labelled voxels of all layers: sets of labels by place.
std::map<std::array<long, 3>, std::set<std::uint32_t>> setsOf(LabelFile& file) {
    std::map<std::array<long, 3>, std::set<std::uint32_t>> sets;
    for (const auto& layer : file.layers)
        for (const auto& [place, label] : placesOf(*layer))
            sets[place].insert(label);
    return sets;
}

/// The same of the frames that were written, by the formula of PS3.3, C.7.6.2.1.1.
std::map<std::array<long, 3>, std::set<std::uint32_t>>
setsOf(const SegImage& image, const glm::dvec3& row, const glm::dvec3& column, double dx, double dy) {
    std::map<std::array<long, 3>, std::set<std::uint32_t>> sets;
    for (const SegTestFrame& frame : image.frames)
        for (int y = 0; y < image.rows; ++y)
            for (int x = 0; x < image.columns; ++x)
                if (const std::uint16_t value =
                        frame.pixels[static_cast<std::size_t>(y * image.columns + x)]) {
                    const glm::dvec3 at = *frame.position + row * (dx * x) + column * (dy * y);
                    sets[{std::lround(100 * at.x), std::lround(100 * at.y), std::lround(100 * at.z)}].insert(
                        image.type == "LABELMAP" ? value : static_cast<std::uint32_t>(frame.segment));
                }
    return sets;
}

void expectRead(const std::filesystem::path& file, const SegImage& image,
                const std::optional<std::string>& dataSet = {}) {
    writeBytes(file, segFileBytes(image, dataSet));
    LabelFile labels = openLabelFile(file);
    EXPECT_EQ(setsOf(labels), setsOf(image, {1, 0, 0}, {0, 1, 0}, 1, 2));
}

/// Two segments that overlap and one that meets none, on slices with gaps, in any order.
SegImage someSegments() {
    SegImage image;
    image.segments = {{3, "third"}, {1, "first"}, {900, "last"}};
    image.between = "2.5";
    std::vector<std::uint16_t> corner(kFramePixels);
    corner[14] = 1;
    image.frames = {{1, glm::dvec3(4, 5, 7.5), someMask(1)}, {3, glm::dvec3(4, 5, 0), someMask(2)},
                    {3, glm::dvec3(4, 5, 7.5), someMask(3)}, {900, glm::dvec3(4, 5, -5), corner},
                    {1, glm::dvec3(4, 5, 0), someMask(4)},   {1, glm::dvec3(4, 5, 10), someMask(5)}};
    return image;
}

TEST(SegLabels, OverlapsGapsAndAnyOrderOfFrames) {
    const auto folder = labelTestFolder();
    expectRead(folder / "a.dcm", someSegments());
    LabelFile file = openLabelFile(folder / "a.dcm");
    EXPECT_EQ(file.layers.size(), 2u);                                   // 900 meets none
    EXPECT_EQ(file.layers[0]->info().extentVoxels, glm::ivec3(5, 3, 7)); // -5 to 10 in steps of 2.5
    EXPECT_EQ(file.frameOfReference, "1.2.3.99");
    EXPECT_EQ(file.labels,
              (std::vector<Label>{{1, "first", "Tissue"}, {3, "third", "Tissue"}, {900, "last", "Tissue"}}));
    EXPECT_TRUE(file.notes.empty());
}

TEST(SegLabels, NoIdentifierComesOut) {
    const auto folder = labelTestFolder();
    SegImage image = someSegments();
    std::string said;
    for (const std::string& type :
         {std::string("FRACTIONAL"), std::string("NONSENSE"), std::string("BINARY")}) {
        image.type = type;
        image.bits = type == "FRACTIONAL" ? 8 : 1;
        writeBytes(folder / "a.dcm", segFileBytes(image));
        said += refusalOfReading(folder / "a.dcm");
        if (type != "NONSENSE")
            for (const std::string& note : openLabelFile(folder / "a.dcm").notes)
                said += note;
    }
    EXPECT_THAT(said, HasSubstr("SegmentationType"));
    for (const std::string& planted : kPlanted)
        EXPECT_THAT(said, testing::Not(HasSubstr(planted)));
}

TEST(SegLabels, ObliqueAndBackwardsFrames) {
    const auto folder = labelTestFolder();
    const glm::dvec3 row(0, 0.8, -0.6), column(1, 0, 0), normal = glm::cross(row, column);
    SegImage image;
    image.orientation = decimals(row) + "\\" + decimals(column);
    image.spacing = "0.7\\0.4";
    for (int i = 0; i < 4; ++i) // along the normal's other way
        image.frames.push_back(
            {1, glm::dvec3(10, 20, 30) - normal * (1.25 * i), someMask(7 + static_cast<unsigned>(i))});
    writeBytes(folder / "a.dcm", segFileBytes(image));
    LabelFile file = openLabelFile(folder / "a.dcm");
    EXPECT_EQ(setsOf(file), setsOf(image, row, column, 0.4, 0.7));
}

TEST(SegLabels, TheDistanceOfSlices) {
    const auto folder = labelTestFolder();
    const auto slicesOf = [&](const std::vector<double>& heights, const std::string& between) {
        SegImage image;
        image.between = between;
        for (const double height : heights)
            image.frames.push_back({1, glm::dvec3(0, 0, height), someMask(3)});
        writeBytes(folder / "a.dcm", segFileBytes(image));
        return openLabelFile(folder / "a.dcm").layers[0]->info();
    };
    EXPECT_EQ(slicesOf({0, 5, 10}, "").extentVoxels.z, 3); // nothing says that slices lack
    EXPECT_EQ(slicesOf({0, 5, 10}, "2.5").extentVoxels.z, 5);
    EXPECT_EQ(slicesOf({0, 5, 7.5}, "").extentVoxels.z, 4);
    EXPECT_EQ(slicesOf({0, 5, 10}, "3").extentVoxels.z, 3); // it contradicts the positions
    EXPECT_DOUBLE_EQ(slicesOf({0, 5, 10}, "3").spacingMm().z, 5);
    EXPECT_DOUBLE_EQ(slicesOf({7}, "2.5").spacingMm().z, 2.5);
    EXPECT_DOUBLE_EQ(slicesOf({7}, "").spacingMm().z, 3); // the thickness
    // Rounded positions: a third of a millimetre.
    std::vector<double> thirds;
    for (int i = 0; i < 300; i += 1 + i % 7)
        thirds.push_back(std::round(i * 1e3 / 3) / 1e3);
    EXPECT_EQ(slicesOf(thirds, "0.333").extentVoxels.z, static_cast<int>(std::lround(thirds.back() * 3)) + 1);
    const auto refusal = [&](const std::vector<double>& heights, const std::string& between) {
        try {
            slicesOf(heights, between);
        } catch (const InputError& error) {
            return std::string(error.what());
        }
        return std::string();
    };
    EXPECT_THAT(refusal({0, 5, 11}, "2.5"), HasSubstr("multiples of one distance"));
    EXPECT_THAT(refusal({0, 1, 1e6}, ""),
                HasSubstr("multiples of one distance"));         // a lie of a million slices
    EXPECT_THAT(refusal({0, 1, 2}, "1e-6"), testing::IsEmpty()); // and of two million
}

TEST(SegLabels, Fractions) {
    const auto folder = labelTestFolder();
    for (const int most : {255, 100, 1}) {
        SegImage image;
        image.type = "FRACTIONAL";
        image.bits = 8;
        image.most = most;
        image.frames = {{1, glm::dvec3(0), std::vector<std::uint16_t>(kFramePixels)}};
        for (int value = 0; value < static_cast<int>(kFramePixels); ++value)
            image.frames[0].pixels[static_cast<std::size_t>(value)] =
                static_cast<std::uint16_t>(value * most / static_cast<int>(kFramePixels - 1));
        writeBytes(folder / "a.dcm", segFileBytes(image));
        LabelFile file = openLabelFile(folder / "a.dcm");
        const std::vector<std::uint32_t> voxels = readLayer(*file.layers[0]);
        for (std::size_t i = 0; i < kFramePixels; ++i)
            EXPECT_EQ(voxels[i], 2 * image.frames[0].pixels[i] >= most ? 1u : 0u) << most << " " << i;
        EXPECT_THAT(file.notes, Contains(HasSubstr("probability")));
    }
}

TEST(SegLabels, Labelmaps) {
    const auto folder = labelTestFolder();
    SegImage image;
    image.type = "LABELMAP";
    image.storageClass = "1.2.840.10008.5.1.4.1.1.66.7";
    image.between = "1";
    image.segments = {{0, "Background"}, {7, "seven"}};
    for (const int bits : {8, 16}) {
        image.bits = bits;
        const auto high = static_cast<std::uint16_t>(bits == 8 ? 200 : 60000);
        std::vector<std::uint16_t> pixels(kFramePixels);
        pixels[2] = 7, pixels[14] = high;
        image.frames = {{0, glm::dvec3(0, 0, 3), pixels}, {0, glm::dvec3(0), pixels}};
        expectRead(folder / "a.dcm", image);
        image.padding = high;
        writeBytes(folder / "b.dcm", segFileBytes(image));
        LabelFile file = openLabelFile(folder / "b.dcm");
        EXPECT_EQ(file.labels, (std::vector<Label>{{7, "seven", "Tissue"}}));
        EXPECT_EQ(placesOf(*file.layers[0]), (Places{{{200, 0, 0}, 7}, {{200, 0, 300}, 7}}));
        image.padding.reset();
    }
}

std::string deflated(const std::string& bytes) {
    z_stream stream{};
    deflateInit2(&stream, 6, Z_DEFLATED, -15, 8, Z_DEFAULT_STRATEGY);
    std::string out(compressBound(bytes.size()) + 64, '\0');
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
    stream.avail_in = static_cast<uInt>(bytes.size());
    stream.next_out = reinterpret_cast<Bytef*>(out.data());
    stream.avail_out = static_cast<uInt>(out.size());
    deflate(&stream, Z_FINISH);
    out.resize(stream.total_out);
    deflateEnd(&stream);
    return out;
}

TEST(SegLabels, EveryCoding) {
    const auto folder = labelTestFolder();
    SegImage image = someSegments();
    image.syntax = "1.2.840.10008.1.2"; // implicit VR
    expectRead(folder / "implicit.dcm", image);
    image.syntax = "1.2.840.10008.1.2.1.99";
    expectRead(folder / "deflated.dcm", image, deflated(segDataSet(image)));
    image.syntax = "1.2.840.10008.1.2.1.98";
    for (const SegTestFrame& frame : image.frames) {
        SegImage one = image;
        one.frames = {frame};
        image.fragments.push_back(segPixelBytes(one));
    }
    expectRead(folder / "frames.dcm", image);

    SegImage map;
    map.type = "LABELMAP";
    map.segments = {{0, "Background"}};
    map.rows = 16, map.columns = 24;
    for (const int bits : {8, 16}) {
        map.bits = bits;
        map.frames.clear();
        for (int z = 0; z < 3; ++z) {
            std::vector<std::uint16_t> pixels(16 * 24);
            for (std::size_t i = 0; i < pixels.size(); i += 1 + i % 3)
                pixels[i] = static_cast<std::uint16_t>(i * 4321 % (bits == 8 ? 256 : 65536));
            map.frames.push_back({0, glm::dvec3(0, 0, z), pixels});
        }
        struct Row {
            const char* syntax;
            std::function<std::string(const std::vector<std::uint16_t>&)> encode;
        };
        for (const Row& row :
             {Row{"1.2.840.10008.1.2.5", [&](const auto& p) { return encodeRle(p, bits / 8); }},
              Row{"1.2.840.10008.1.2.4.80", [&](const auto& p) { return encodeJpegLs(p, 24, 16, bits); }},
              Row{"1.2.840.10008.1.2.4.70", [](const auto& p) { return encodeJpegLossless(p, 24, 16); }},
              Row{"1.2.840.10008.1.2.4.90", [&](const auto& p) {
                      Jpeg2000Options options;
                      options.bits = bits;
                      options.isSigned = false;
                      return encodeJpeg2000(std::vector<std::int32_t>(p.begin(), p.end()), 24, 16, options);
                  }}}) {
            if (bits == 8 && std::string(row.syntax).ends_with(".70"))
                continue; // the encoder writes 16
            SCOPED_TRACE(std::string(row.syntax) + " " + std::to_string(bits));
            map.syntax = row.syntax;
            map.fragments.clear();
            for (const SegTestFrame& frame : map.frames)
                map.fragments.push_back(row.encode(frame.pixels));
            expectRead(folder / "map.dcm", map);
            map.fragments[1].resize(map.fragments[1].size() / 2);
            writeBytes(folder / "short.dcm", segFileBytes(map));
            EXPECT_NE(refusalOfReading(folder / "short.dcm"), "");
        }
    }
    map.syntax = "1.2.840.10008.1.2.4.50";
    writeBytes(folder / "lossy.dcm", segFileBytes(map));
    EXPECT_THAT(refusalOfReading(folder / "lossy.dcm"), HasSubstr("transfer syntax 1.2.840.10008.1.2.4.50"));
}

TEST(SegLabels, NamesAndColours) {
    const auto folder = labelTestFolder();
    SegImage image;
    image.characters = "ISO_IR 100";
    image.segments = {{1, "Gef\xe4\xdf", "Anatomical Structure", std::array{65535, 32896, 32896}},
                      {2, "", "", std::array{34883, 53485, 50171}}}; // L* 53.23, a* 80.11, b* 67.22
    image.frames = {{1, glm::dvec3(0), someMask(1)}};
    writeBytes(folder / "a.dcm", segFileBytes(image));
    LabelFile file = openLabelFile(folder / "a.dcm");
    ASSERT_EQ(file.labels.size(), 2u);
    EXPECT_EQ(file.labels[0].name, "Gef\xc3\xa4\xc3\x9f");
    EXPECT_EQ(file.labels[0].group, "Anatomical Structure");
    EXPECT_EQ(file.labels[1].name, "label 2");
    ASSERT_TRUE(file.labels[0].colour && file.labels[1].colour);
    for (int i = 0; i < 3; ++i)
        EXPECT_NEAR((*file.labels[0].colour)[i], 1, 0.005); // white stays white
    EXPECT_GT(file.labels[1].colour->r, 0.9f);              // nearly Rec. 709's red
    EXPECT_LT(file.labels[1].colour->g, 0.02f);
    EXPECT_LT(file.labels[1].colour->b, 0.02f);
}

// L*a*b* of linear Rec. 709, by the formulas of CIE 15 and the matrix to D50 (B. Lindbloom, "RGB/XYZ
// Matrices").
TEST(SegLabels, ColoursAreThoseOfTheirLab) {
    const auto folder = labelTestFolder();
    const glm::dmat3 xyzOf(0.4360747, 0.2225045, 0.0139322, 0.3850649, 0.7168786, 0.0971045, 0.1430804,
                           0.0606169, 0.7141733);
    const glm::dvec3 white(0.96422, 1, 0.82521);
    SegImage image;
    image.segments.clear();
    std::vector<glm::dvec3> colours;
    for (const double r : {0.001, 0.2, 0.9}) // dark ones are on the straight part of the curve
        for (const double g : {0.002, 0.3, 0.8})
            for (const double b : {0.0005, 0.25, 0.95}) {
                colours.emplace_back(r, g, b);
                glm::dvec3 f = xyzOf * colours.back() / white;
                for (int i = 0; i < 3; ++i)
                    f[i] = f[i] > 216.0 / 24389 ? std::cbrt(f[i]) : (24389.0 / 27 * f[i] + 16) / 116;
                const double l = 116 * f.y - 16, a = 500 * (f.x - f.y), bb = 200 * (f.y - f.z);
                image.segments.push_back(
                    {static_cast<int>(colours.size()), "c", "Tissue",
                     std::array{static_cast<int>(std::lround(l / 100 * 65535)),
                                static_cast<int>(std::lround((a + 128) / 255 * 65535)),
                                static_cast<int>(std::lround((bb + 128) / 255 * 65535))}});
            }
    image.frames = {{1, glm::dvec3(0), someMask(1)}};
    writeBytes(folder / "a.dcm", segFileBytes(image));
    const LabelFile file = openLabelFile(folder / "a.dcm");
    ASSERT_EQ(file.labels.size(), colours.size());
    for (std::size_t n = 0; n < colours.size(); ++n)
        for (int i = 0; i < 3; ++i)
            EXPECT_NEAR((*file.labels[n].colour)[i], colours[n][i], 3e-4) << n << ", " << i;
}

TEST(SegLabels, PlacesUpToTheirBounds) {
    const auto folder = labelTestFolder();
    const auto outcome = [&](const std::vector<glm::dvec3>& places, const std::string& spacing = "2\\1",
                             const std::string& between = "") -> std::string {
        SegImage image;
        image.between = between;
        image.spacing = spacing;
        image.segments = {{1, "a"}, {2, "b"}};
        for (std::size_t n = 0; n < places.size(); ++n) // two of one place are of two segments
            image.frames.push_back(
                {n > 0 && std::abs(places[n].z - places[n - 1].z) < 0.01 ? 2 : 1, places[n], someMask(3)});
        writeBytes(folder / "a.dcm", segFileBytes(image));
        try {
            return std::to_string(openLabelFile(folder / "a.dcm").layers[0]->info().extentVoxels.z);
        } catch (const InputError& error) {
            return error.what();
        }
    };
    // A fiftieth of a distance, of steps by more than ten of it a five-hundredth of the step.
    EXPECT_EQ(outcome({{0, 0, 0}, {0, 0, 5}, {0, 0, 10.09}}), "3");
    EXPECT_THAT(
        outcome({{0, 0, 0}, {0, 0, 5}, {0, 0, 10.15}}),
        HasSubstr("multiples of one distance (ImagePositionPatient along the normal), found distances "
                  "from 5 to 5.15 mm"));
    EXPECT_EQ(outcome({{0, 0, 0}, {0, 0, 1}, {0, 0, 31.045}}), "32");
    EXPECT_THAT(outcome({{0, 0, 0}, {0, 0, 1}, {0, 0, 31.08}}), HasSubstr("multiples of one distance"));
    EXPECT_EQ(outcome({{0, 0, 0}, {0, 0, 1}, {0, 0, 32767}}), "32768");
    EXPECT_THAT(outcome({{0, 0, 0}, {0, 0, 1}, {0, 0, 32768}}), HasSubstr("multiples of one distance"));
    // Sideways by a twentieth of the least of distance, columns and rows, and a micrometre.
    for (const auto& [mm, spacing, gap] : std::vector<std::tuple<double, std::string, double>>{
             {1, "2\\1", 5}, {1, "1\\2", 5}, {0.5, "2\\1", 0.5}})
        for (const double sign : {1.0, -1.0}) {
            EXPECT_EQ(outcome({{0, 0, 0}, {0, sign * 0.046 * mm, gap}, {0, 0, 2 * gap}}, spacing), "3")
                << spacing;
            EXPECT_THAT(outcome({{0, 0, 0}, {0, sign * 0.056 * mm, gap}, {0, 0, 2 * gap}}, spacing),
                        HasSubstr("frame 2 off by 0.0"))
                << spacing;
        }
    // Positions are rounded: a thousandth of a millimetre apart they are one.
    EXPECT_EQ(outcome({{0, 0, 0}, {0, 0, 5}, {0, 0, 5.0008}}), "2");
    SegImage image;
    image.thickness = "";
    image.frames = {{1, glm::dvec3(0), someMask(1)}};
    writeBytes(folder / "a.dcm", segFileBytes(image));
    const LabelFile one = openLabelFile(folder / "a.dcm");
    EXPECT_EQ(one.layers[0]->info().spacingMm(), glm::dvec3(1, 2, 1));
    EXPECT_THAT(one.notes, Contains("the only slice has no thickness; it is taken as 1 mm"));
}

// Each rule at its last value, and beyond it. BINARY: bits of three frames in an odd number of bytes.
TEST(SegLabels, RulesOfFramesAndPixels) {
    const auto folder = labelTestFolder();
    const auto outcome =
        [&](
            const std::function<void(SegImage&)>& change,
            const std::function<void(std::string&)>& damage = [](std::string&) {}) -> std::string {
        SegImage image;
        for (int z = 0; z < 3; ++z)
            image.frames.push_back({1, glm::dvec3(0, 0, 3 * z), someMask(static_cast<unsigned>(z) + 1)});
        change(image);
        std::string bytes = segFileBytes(image);
        damage(bytes);
        writeBytes(folder / "a.dcm", bytes);
        return refusalOfReading(folder / "a.dcm");
    };
    const auto same = [](SegImage&) {};
    EXPECT_EQ(outcome(same), "");
    const auto oriented = [&](const char* all, const char* third = "") {
        return outcome([&](SegImage& i) {
            i.orientation = all;
            if (*third)
                i.frames[2].orientation = third;
        });
    };
    EXPECT_EQ(oriented("1.009\\0\\0\\0\\0.991\\0"), "");
    EXPECT_EQ(oriented("1\\0\\0\\0.009\\1\\0"), "");
    for (const char* other :
         {"1.015\\0\\0\\0\\1\\0", "1\\0\\0\\0\\0.985\\0", "1\\0\\0\\0.015\\1\\0", "1\\0\\0\\-0.015\\1\\0"})
        EXPECT_THAT(oriented(other), HasSubstr("of two perpendicular unit vectors, found others for frame 1"))
            << other;
    const char* const plain = "1\\0\\0\\0\\1\\0";
    EXPECT_EQ(oriented(plain, "1\\0.00009\\0\\-0.00009\\1\\0"), "");
    for (const char* other : {"1\\0.00015\\0\\0\\1\\0", "1\\0\\0\\0\\1\\0.00015"})
        EXPECT_THAT(oriented(plain, other),
                    HasSubstr("frames of one orientation, found another one for frame 3"))
            << other;
    // Elements of 16 bits, by their place in the file.
    const auto with = [&](const char* element, char value) {
        return outcome(same, [&](std::string& bytes) {
            const std::size_t at =
                bytes.find(std::string("\x28\0", 2) + std::string(element, 2) + std::string("US\2\0", 4));
            ASSERT_NE(at, std::string::npos);
            bytes[at + 8] = value;
        });
    };
    EXPECT_THAT(with("\2\0", 3), HasSubstr("one value without a sign a pixel"));
    EXPECT_THAT(with("\2\0", 0), HasSubstr("one value without a sign a pixel"));
    EXPECT_EQ(with("\2\0", 1), "");
    EXPECT_THAT(with("\3\1", 1), HasSubstr("one value without a sign a pixel"));
    for (const auto& [type, bits, isTaken] :
         std::vector<std::tuple<const char*, int, bool>>{{"BINARY", 1, true},
                                                         {"BINARY", 8, true},
                                                         {"BINARY", 16, false},
                                                         {"FRACTIONAL", 1, false},
                                                         {"FRACTIONAL", 8, true},
                                                         {"FRACTIONAL", 16, false},
                                                         {"LABELMAP", 1, false},
                                                         {"LABELMAP", 8, true},
                                                         {"LABELMAP", 16, true}}) {
        const std::string said = outcome([&, t = type, b = bits](SegImage& i) { i.type = t, i.bits = b; });
        EXPECT_EQ(
            said.find(
                "BitsAllocated (0028,0100) of 1 (BINARY), 8 (FRACTIONAL), or 8 or 16 (LABELMAP), found " +
                std::to_string(bits)) == std::string::npos,
            isTaken)
            << type << bits << said;
    }
    for (const auto& [most, isTaken] : {std::pair(0, false), {1, true}, {255, true}, {256, false}})
        EXPECT_EQ(outcome([m = most](SegImage& i) { i.type = "FRACTIONAL", i.bits = 8, i.most = m; }).empty(),
                  isTaken)
            << most;
    for (const auto& [said, isTaken] : {std::pair(2, false), {3, true}, {4, false}})
        EXPECT_EQ(outcome([n = said](SegImage& i) { i.framesSaid = n; }).empty(), isTaken) << said;
    // 45 bits are six bytes; an odd number has one more.
    for (const auto& [bytes, isTaken] : {std::pair(4u, false), {6u, true}, {8u, false}})
        EXPECT_EQ(outcome([n = bytes](SegImage& i) { i.pixelBytes = std::string(n, '\1'); }).empty(), isTaken)
            << bytes;
    for (const auto& [bytes, isTaken] : {std::pair(43u, false), {45u, true}, {47u, false}})
        EXPECT_EQ(outcome([n = bytes](SegImage& i) {
                      i.type = "FRACTIONAL", i.bits = 8, i.pixelBytes = std::string(n, '\1');
                  }).empty(),
                  isTaken)
            << bytes;
    EXPECT_THAT(outcome([](SegImage& i) { i.pixelBytes = std::string(4, '\1'); }),
                HasSubstr("6 bytes of PixelData (7fe0,0010) for 3 frames of 5 x 3, found 4"));
}

TEST(SegLabels, LiesAreRefused) {
    const auto folder = labelTestFolder();
    const auto refusal = [&](const std::function<void(SegImage&)>& change,
                             std::size_t kept = std::string::npos) {
        SegImage image = someSegments();
        change(image);
        writeBytes(folder / "a.dcm", segFileBytes(image).substr(0, kept));
        const std::string message = refusalOfReading(folder / "a.dcm");
        EXPECT_THAT(message, HasSubstr("a.dcm"));
        return message;
    };
    EXPECT_THAT(refusal([](SegImage& i) { i.frames[2].position.reset(); }), HasSubstr("none for frame 3"));
    EXPECT_THAT(refusal([](SegImage& i) { i.frames[2].orientation = "1\\0\\0\\0\\0\\1"; }),
                HasSubstr("frames of one orientation"));
    EXPECT_THAT(refusal([](SegImage& i) { i.orientation = "1\\0\\0\\1\\0\\0"; }), HasSubstr("perpendicular"));
    EXPECT_THAT(
        refusal([](SegImage& i) { i.orientation = ""; }),
        HasSubstr("expected ImageOrientationPatient (0020,0037) for every frame, found none for frame 1"));
    EXPECT_THAT(refusal([](SegImage& i) { i.orientation = "1\\0\\0\\0\\1\\x"; }), HasSubstr("no number"));
    EXPECT_THAT(refusal([](SegImage& i) { i.orientation = "1\\0\\0\\0\\1"; }), HasSubstr("6 numbers"));
    EXPECT_THAT(refusal([](SegImage& i) { i.spacing = "0\\1"; }), HasSubstr("PixelSpacing"));
    EXPECT_THAT(refusal([](SegImage& i) { i.frames[2].position->x += 1; }), HasSubstr("above one another"));
    EXPECT_THAT(
        refusal([](SegImage& i) { i.frames[2].position = i.frames[0].position, i.frames[2].segment = 1; }),
        HasSubstr("one frame a segment"));
    EXPECT_THAT(refusal([](SegImage& i) { i.frames[2].segment = 2; }), HasSubstr("2 for frame 3"));
    EXPECT_THAT(refusal([](SegImage& i) { i.segments[0].number = 1; }), HasSubstr("several of number 1"));
    EXPECT_THAT(refusal([](SegImage& i) { i.segments[0].number = 0; }), HasSubstr("SegmentNumber"));
    EXPECT_THAT(refusal([](SegImage& i) { i.segments.clear(); }), HasSubstr("SegmentSequence"));
    EXPECT_THAT(refusal([](SegImage& i) { i.framesSaid = 2000000000; }), HasSubstr("NumberOfFrames"));
    EXPECT_THAT(refusal([](SegImage& i) { i.rows = 65535, i.columns = 65535; }),
                HasSubstr("bytes of PixelData"));
    EXPECT_THAT(refusal([](SegImage& i) { i.rows = 2; }), HasSubstr("bytes of PixelData"));
    EXPECT_THAT(refusal([](SegImage& i) { i.rows = 0; }), HasSubstr("Rows"));
    EXPECT_THAT(refusal([](SegImage& i) { i.bits = 16; }), HasSubstr("BitsAllocated"));
    EXPECT_THAT(refusal([](SegImage& i) { i.type = "OTHER"; }), HasSubstr("SegmentationType"));
    EXPECT_THAT(refusal([](SegImage& i) { i.type = "FRACTIONAL", i.bits = 8, i.most = 0; }),
                HasSubstr("MaximumFractionalValue"));
    EXPECT_THAT(refusal([](SegImage& i) { i.storageClass = "1.2.840.10008.5.1.4.1.1.66.5"; }),
                HasSubstr("surfaces"));
    EXPECT_THAT(refusal([](SegImage& i) { i.syntax = "1.2.840.10008.1.2.5", i.fragments.resize(6, "ab"); }),
                HasSubstr("not compressed"));
    EXPECT_THAT(refusal([](SegImage& i) {
                    i.type = "LABELMAP", i.bits = 8, i.syntax = "1.2.840.10008.1.2.5";
                    i.rows = i.columns = 65535, i.fragments.resize(6, std::string(64, '\0'));
                }),
                HasSubstr("in every frame"));
    // Cut anywhere, it is refused.
    const std::size_t whole = segFileBytes(someSegments()).size();
    for (std::size_t kept = 400; kept < whole; kept += 13)
        EXPECT_NE(refusal([](SegImage&) {}, kept), "") << kept;
}

std::filesystem::path sharedSegmentations() {
    return testData().empty() ? testData() : testData() / "labels/dicom-seg";
}

TEST(SegLabels, OfOthersEqualTheirTwins) {
    const auto folder = sharedSegmentations();
    if (folder.empty())
        GTEST_SKIP() << "no shared test data (TESSERA_TEST_DATA or ../shared/data)";
    struct Row {
        const char* dicom;
        std::vector<const char*> twins;
    };
    for (const Row& row :
         {Row{"liver.dcm", {"liver_seg.nrrd"}},
          Row{"partial_overlaps.dcm",
              {"partial_overlaps-1.nrrd", "partial_overlaps-2.nrrd", "partial_overlaps-3.nrrd"}}}) {
        std::map<std::array<long, 3>, std::set<std::uint32_t>> expected;
        for (const char* twin : row.twins) {
            LabelFile file = openLabelFile(folder / twin);
            for (const auto& [place, label] : placesOf(*file.layers.at(0)))
                expected[place].insert(label);
        }
        LabelFile file = openLabelFile(folder / row.dicom);
        const auto found = setsOf(file);
        EXPECT_GT(found.size(), 100u);
        EXPECT_TRUE(found == expected) << row.dicom << ": " << found.size() << " voxels, " << expected.size();
        EXPECT_TRUE(file.notes.empty());
    }
}

TEST(SegLabels, OfOthersLieOnTheirScan) {
    const auto folder = sharedSegmentations();
    if (folder.empty())
        GTEST_SKIP() << "no shared test data (TESSERA_TEST_DATA or ../shared/data)";
    const VolumeInfo scan = openSource(folder / "ct-3slice", {})->info();
    MemoryBudget ram("RAM", "--ram", std::size_t{1} << 30);
    const auto reportOf = [&](const char* name) {
        LabelFile file = openLabels(folder / name, {});
        LabelImportOptions options;
        options.durable = false;
        return importLabels(file, scan, labelTestFolder() / "labels.zarr", ram, options);
    };
    const LabelImportReport liver = reportOf("liver.dcm"), twin = reportOf("liver_seg.nrrd"),
                            overlaps = reportOf("partial_overlaps.dcm");
    EXPECT_GT(liver.labelled, 10000u);
    EXPECT_EQ(liver.labelled, twin.labelled);
    EXPECT_EQ(liver.labels, 1u);
    EXPECT_EQ(overlaps.labelled, 40505u);
    EXPECT_EQ(overlaps.labels, 5u);
    EXPECT_GT(overlaps.sets, 6u); // some overlap
}

/// Frames and segments as DCMTK's own reader of segmentations has them.
TEST(SegLabels, OfOthersAreWhatDcmtkSays) {
    const auto folder = sharedSegmentations();
    if (folder.empty())
        GTEST_SKIP() << "no shared test data (TESSERA_TEST_DATA or ../shared/data)";
    for (const char* name : {"liver.dcm", "partial_overlaps.dcm"}) {
        LabelFile ours = openLabelFile(folder / name);
        DcmSegmentation* loaded = nullptr;
        ASSERT_TRUE(DcmSegmentation::loadFile((folder / name).c_str(), loaded).good());
        const std::unique_ptr<DcmSegmentation> theirs(loaded);
        ASSERT_EQ(theirs->getNumberOfSegments(), ours.labels.size());
        for (std::size_t i = 0; i < ours.labels.size(); ++i) {
            OFString label, category;
            DcmSegment* const segment = theirs->getSegment(static_cast<unsigned>(i + 1));
            segment->getSegmentLabel(label);
            segment->getSegmentedPropertyCategoryCode().getCodeMeaning(category);
            EXPECT_EQ(ours.labels[i].name, label.c_str());
            EXPECT_EQ(ours.labels[i].group, category.c_str());
            EXPECT_TRUE(ours.labels[i].colour);
        }
        std::size_t inside = 0, insideOurs = 0;
        for (std::size_t i = 0; i < theirs->getNumberOfFrames(); ++i) {
            const DcmIODTypes::Frame* const bits = theirs->getFrame(i);
            const std::unique_ptr<DcmIODTypes::Frame> frame(DcmSegUtils::unpackBinaryFrame(bits, 512, 512));
            inside += static_cast<std::size_t>(std::count_if(frame->pixData, frame->pixData + 512 * 512,
                                                             [](Uint8 value) { return value != 0; }));
        }
        for (const auto& [place, labels] : setsOf(ours))
            insideOurs += labels.size();
        EXPECT_EQ(insideOurs, inside);
    }
}

TEST(SegLabels, OfOthersALabelmapWithAMissingSlice) {
    const auto folder = sharedSegmentations();
    if (folder.empty())
        GTEST_SKIP() << "no shared test data (TESSERA_TEST_DATA or ../shared/data)";
    LabelFile file = openLabelFile(folder / "sparse-labelmap-noppv.dcm");
    ASSERT_EQ(file.layers.size(), 1u);
    const VolumeInfo& info = file.layers[0]->info();
    EXPECT_EQ(info.extentVoxels, glm::ivec3(24, 38, 3));
    EXPECT_NEAR(info.spacingMm().z, 2.5, 1e-9);
    const std::vector<std::uint32_t> voxels = readLayer(*file.layers[0]);
    const auto slice = static_cast<std::ptrdiff_t>(24 * 38);
    for (int z = 0; z < 3; ++z)
        EXPECT_EQ(std::count(voxels.begin() + z * slice, voxels.begin() + (z + 1) * slice, 1u) > 0, z != 1);
    ASSERT_EQ(file.labels.size(), 1u);
    EXPECT_EQ(file.labels[0].name, "Liver");
}

} // namespace
} // namespace tessera::test
