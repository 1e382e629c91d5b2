// tests/bricking/labels/nrrd_labels_test.cpp: NRRD files that the test writes, in every coding, read back
// equal; their places in the patient; layers and segments of 3D Slicer; what is refused.
#include "tests/support/label_file_tools.h"

#include <functional>
#include <random>

namespace tessera::test {
namespace {

using testing::Contains;
using testing::HasSubstr;

constexpr std::size_t kVoxels = 3 * 4 * 5;

/// Values below 128, most of them 0.
std::vector<std::uint32_t> someLabels(std::size_t count = kVoxels, unsigned seed = 1) {
    std::mt19937 random(seed);
    std::vector<std::uint32_t> values(count);
    for (std::uint32_t& value : values)
        value = random() % 3 ? 0 : random() % 128;
    return values;
}

const std::string kPlace = "space: left-posterior-superior\n"
                           "space directions: (2,0,0) (0,3,0) (0,0,4)\n"
                           "space origin: (10,20,30)\n";

std::string headerOf(const std::string& type, const std::string& encoding, const std::string& more = kPlace,
                     const std::string& sizes = "3 4 5") {
    const auto axes = std::count(sizes.begin(), sizes.end(), ' ') + 1;
    return "NRRD0004\n# a comment\ntype: " + type + "\ndimension: " + std::to_string(axes) +
           "\nsizes: " + sizes + "\nencoding: " + encoding + "\n" + more;
}

std::vector<std::uint32_t> readOnly(const std::filesystem::path& path) {
    LabelFile file = openLabelFile(path);
    EXPECT_EQ(file.layers.size(), 1u);
    return readLayer(*file.layers.at(0));
}

struct TypeRow {
    const char* names;
    std::function<std::string(const std::vector<std::uint32_t>&, bool)> bytes;
};
const std::vector<TypeRow> kTypes = {{"int8", fileBytes<std::int8_t>},
                                     {"unsigned char", fileBytes<std::uint8_t>},
                                     {"short", fileBytes<std::int16_t>},
                                     {"uint16_t", fileBytes<std::uint16_t>},
                                     {"signed int", fileBytes<std::int32_t>},
                                     {"uint", fileBytes<std::uint32_t>},
                                     {"longlong", fileBytes<std::int64_t>},
                                     {"unsigned long long int", fileBytes<std::uint64_t>},
                                     {"float", fileBytes<float>},
                                     {"double", fileBytes<double>}};

TEST(NrrdLabels, EveryTypeAndCodingReadsBackEqual) {
    const auto folder = labelTestFolder();
    const std::vector<std::uint32_t> labels = someLabels();
    std::string text;
    for (const std::uint32_t value : labels)
        text += std::to_string(value) + (value % 7 ? " " : "\r\n");
    for (const TypeRow& type : kTypes)
        for (const bool big : {false, true}) {
            const std::string bytes = type.bytes(labels, big),
                              endian = std::string("endian: ") + (big ? "big\n" : "little\n");
            const std::vector<std::pair<std::string, std::string>> codings = {{"raw", bytes},
                                                                              {"gzip", gzipped(bytes)},
                                                                              {"gz", gzipped(bytes)},
                                                                              {"ascii", text},
                                                                              {"TXT", text}};
            for (const auto& [encoding, data] : codings) {
                SCOPED_TRACE(std::string(type.names) + " " + encoding);
                const std::string header = headerOf(type.names, encoding, endian + kPlace);
                writeBytes(folder / "a.nrrd", header + "\n" + data);
                EXPECT_EQ(readOnly(folder / "a.nrrd"), labels);
                writeBytes(folder / "data.bin", data);
                writeBytes(folder / "b.nhdr", header + "data file: data.bin\n");
                EXPECT_EQ(readOnly(folder / "b.nhdr"), labels);
            }
        }
}

TEST(NrrdLabels, ValuesOf32BitsAreKept) {
    const auto folder = labelTestFolder();
    std::vector<std::uint32_t> labels = someLabels();
    labels[7] = 4294967295u;
    labels[8] = 16777217; // no float has it
    for (const char* type : {"uint32", "int64", "uint64", "double"}) {
        const std::string data = std::string(type) == "uint32"   ? fileBytes<std::uint32_t>(labels)
                                 : std::string(type) == "double" ? fileBytes<double>(labels)
                                                                 : fileBytes<std::int64_t>(labels);
        writeBytes(folder / "a.nrrd", headerOf(type, "raw", "endian: little\n" + kPlace) + "\n" + data);
        EXPECT_EQ(readOnly(folder / "a.nrrd"), labels) << type;
    }
}

TEST(NrrdLabels, HarmlessOdditiesAreRead) {
    const auto folder = labelTestFolder();
    const std::vector<std::uint32_t> labels = someLabels();
    const std::string data = fileBytes<std::uint8_t>(labels);
    std::string carriage =
        headerOf("uchar", "raw", "content: x: y := z\nsome key:=a\\nb: c\nodd field: 3\n" + kPlace);
    for (std::size_t at = 0; (at = carriage.find('\n', at)) != std::string::npos; at += 2)
        carriage.insert(at, 1, '\r');
    writeBytes(folder / "a.nrrd", carriage + "\r\n" + data);
    EXPECT_EQ(readOnly(folder / "a.nrrd"), labels);
    // Blanks in vectors, upper case, fields in another order, without their blanks.
    writeBytes(folder / "b.nrrd",
               "NRRD0005\nEncoding: RAW\nspacedirections: ( 2, 0, 0 )(0 ,3,0) (0,0,+4.0e0)\n"
               "Space: LPS\nType: UCHAR\nspaceorigin:(10, 20, 30)\nDimension: 3\n"
               "sizes:  3\t4 5 \n\n" +
                   data);
    LabelFile file = openLabelFile(folder / "b.nrrd");
    EXPECT_EQ(readLayer(*file.layers[0]), labels);
    EXPECT_EQ(file.layers[0]->info().patientFromVoxel,
              openLabelFile(folder / "a.nrrd").layers[0]->info().patientFromVoxel);
    EXPECT_TRUE(file.notes.empty());
    // By its beginning, under another name.
    writeBytes(folder / "c.dat", carriage + "\r\n" + data);
    EXPECT_EQ(readOnly(folder / "c.dat"), labels);
}

TEST(NrrdLabels, LinesAndBytesBeforeTheDataAreSkipped) {
    const auto folder = labelTestFolder();
    const std::vector<std::uint32_t> labels = someLabels();
    const std::string data = fileBytes<std::uint8_t>(labels);
    const auto expectRead = [&](const std::string& encoding, const std::string& skips,
                                const std::string& content) {
        SCOPED_TRACE(encoding + skips);
        const std::string header = headerOf("uchar", encoding, skips + kPlace);
        writeBytes(folder / "a.nrrd", header + "\n" + content);
        EXPECT_EQ(readOnly(folder / "a.nrrd"), labels);
        writeBytes(folder / "data.bin", content);
        writeBytes(folder / "b.nhdr", header + "data file: data.bin\n");
        EXPECT_EQ(readOnly(folder / "b.nhdr"), labels);
    };
    expectRead("raw", "line skip: 2\nbyte skip: 3\n", "one\ntwo\nabc" + data);
    expectRead("raw", "byteskip: -1\n", "something of any length" + data);
    expectRead("gzip", "lineskip: 1\nbyte skip: 5\n", "one\n" + gzipped("12345" + data));
}

TEST(NrrdLabels, DataInManyFiles) {
    const auto folder = labelTestFolder();
    const std::vector<std::uint32_t> labels = someLabels();
    const std::string data = fileBytes<std::uint8_t>(labels);
    std::filesystem::create_directories(folder / "sub");
    for (const bool isGzip : {false, true})
        for (int parts : {5, 20}) { // slices, rows
            const std::size_t each = data.size() / static_cast<std::size_t>(parts);
            std::string list = parts == 5 ? "data file: LIST\n" : "data file: LIST 1\n";
            for (int i = 0; i < parts; ++i) {
                const std::string part = data.substr(static_cast<std::size_t>(i) * each, each);
                char name[32];
                std::snprintf(name, sizeof name, "sub/s%03d.bin", 2 * i + 1);
                writeBytes(folder / name, isGzip ? gzipped(part) : part);
                list += std::string(name) + "\n";
            }
            const std::string header = headerOf("uchar", isGzip ? "gzip" : "raw");
            writeBytes(folder / "list.nhdr", header + list);
            EXPECT_EQ(readOnly(folder / "list.nhdr"), labels);
            const std::string most = std::to_string(2 * parts - 1);
            writeBytes(folder / "pattern.nhdr", header + "datafile: sub/s%03d.bin 1 " + most + " 2" +
                                                    (parts == 20 ? " 1" : "") + "\n");
            EXPECT_EQ(readOnly(folder / "pattern.nhdr"), labels);
            std::filesystem::remove(folder / "sub/s005.bin");
            EXPECT_THAT(refusalOfReading(folder / "list.nhdr"), HasSubstr("s005.bin"));
        }
    writeBytes(folder / "few.nhdr", headerOf("uchar", "raw") + "data file: LIST\nsub/s001.bin\n");
    EXPECT_THAT(refusalOfReading(folder / "few.nhdr"), HasSubstr("expected 5 data files"));
}

TEST(NrrdLabels, SpacesAreTurnedToLps) {
    const auto folder = labelTestFolder();
    std::vector<std::uint32_t> labels(kVoxels);
    labels[1 + 3 * (2 + 4 * 3)] = 9; // voxel (1, 2, 3)
    const std::string data = fileBytes<std::uint8_t>(labels);
    struct Row {
        const char* space;
        std::array<long, 3> at; // of 12, 26, 42 in the file's space
    };
    for (const Row& row :
         {Row{"left-posterior-superior", {1200, 2600, 4200}}, Row{"LPS", {1200, 2600, 4200}},
          Row{"right-anterior-superior", {-1200, -2600, 4200}}, Row{"RAS", {-1200, -2600, 4200}},
          Row{"left-anterior-superior", {1200, -2600, 4200}}, Row{"las", {1200, -2600, 4200}}}) {
        writeBytes(folder / "a.nrrd",
                   headerOf("uchar", "raw",
                            std::string("space: ") + row.space +
                                "\nspace directions: (2,0,0) (0,3,0) (0,0,4)\nspace origin: (10,20,30)\n") +
                       "\n" + data);
        LabelFile file = openLabelFile(folder / "a.nrrd");
        EXPECT_EQ(placesOf(*file.layers[0]), (Places{{row.at, 9}})) << row.space;
        EXPECT_TRUE(file.layers[0]->info().orientationKnown);
    }
    // Axes in any order, oblique: voxel (1, 2, 3) is at origin + step x + 2 step y + 3 step z.
    writeBytes(folder / "b.nrrd", headerOf("uchar", "raw",
                                           "space: RAS\nspace directions: (0,0,-2) (3,1,0) (-1,4,0)\n"
                                           "space origin: (1,2,3)\nspace units: \"cm\" \"cm\" \"cm\"\n") +
                                      "\n" + data);
    LabelFile oblique = openLabelFile(folder / "b.nrrd");
    EXPECT_EQ(placesOf(*oblique.layers[0]), (Places{{{-4000, -16000, 1000}, 9}}));
}

TEST(NrrdLabels, WithoutASpaceTheOrientationIsUnknown) {
    const auto folder = labelTestFolder();
    const std::string data = fileBytes<std::uint8_t>(someLabels());
    for (const std::string& place :
         {std::string("spacings: 1 2 3\n"),
          std::string("space: 3D-right-handed\nspace directions: (1,0,0) "
                      "(0,2,0) (0,0,3)\n"),
          std::string("space dimension: 3\nspace directions: (1,0,0) (0,2,0) (0,0,3)\n"), std::string()}) {
        writeBytes(folder / "a.nrrd", headerOf("uchar", "raw", place) + "\n" + data);
        LabelFile file = openLabelFile(folder / "a.nrrd");
        EXPECT_FALSE(file.layers[0]->info().orientationKnown);
        EXPECT_THAT(file.notes, Contains(HasSubstr("orientation in the patient is not known")));
        EXPECT_EQ(file.layers[0]->info().spacingMm(), place.empty() ? glm::dvec3(1) : glm::dvec3(1, 2, 3));
    }
}

const std::string kSegments =
    "Segment0_Name:=kidney left\nSegment0_LabelValue:=1\nSegment0_Layer:=0\nSegment0_Color:=1 0.5 0\n"
    "Segment0_Tags:=Segmentation.Status:done|TerminologyEntry:Segmentation category and type - 3D Slicer "
    "General Anatomy list~SCT^123037004^Anatomical Structure~SCT^64033007^Kidney~^^~Anatomic codes - DICOM "
    "master list~^^~^^|\n"
    "Segment1_Name:=cyst\nSegment1_LabelValue:=1\nSegment1_Layer:=1\n"
    "Segment2_Name:=tumour\nSegment2_LabelValue:=7\nSegment2_Layer:=1\nSegment2_Color:=0 0 1\n"
    "Segmentation_MasterRepresentation:=Binary labelmap\n";

TEST(NrrdLabels, LayersOfSlicer) {
    const auto folder = labelTestFolder();
    std::vector<std::uint32_t> first(kVoxels), second(kVoxels), expected(kVoxels);
    for (std::size_t i = 0; i < kVoxels; ++i) {
        first[i] = i % 4 == 0;
        second[i] = i % 3 == 0 ? 1 : i % 5 == 0 ? 7 : 0;
        expected[i] = second[i] == 1 ? 8 : second[i]; // 1 is the first layer's
    }
    const std::string spaces = "space: left-posterior-superior\nspace origin: (10,20,30)\n",
                      directions = "(2,0,0) (0,3,0) (0,0,4)";
    for (const bool isGzip : {false, true})
        for (const bool isFirst : {true, false}) {
            std::vector<std::uint32_t> values;
            for (std::size_t i = 0; i < 2 * kVoxels; ++i)
                values.push_back(isFirst ? (i % 2 ? second : first)[i / 2]
                                         : (i < kVoxels ? first[i] : second[i - kVoxels]));
            const std::string data = fileBytes<std::uint16_t>(values, true);
            writeBytes(folder / "a.seg.nrrd",
                       headerOf("ushort", isGzip ? "gzip" : "raw",
                                "endian: big\nspace directions: " +
                                    (isFirst ? "none " + directions : directions + " none") + "\nkinds: " +
                                    (isFirst ? "list domain domain domain" : "domain domain domain list") +
                                    "\n" + spaces + kSegments,
                                isFirst ? "2 3 4 5" : "3 4 5 2") +
                           "\n" + (isGzip ? gzipped(data) : data));
            LabelFile file = openLabelFile(folder / "a.seg.nrrd");
            ASSERT_EQ(file.layers.size(), 2u);
            EXPECT_EQ(readLayer(*file.layers[1]), expected);
            EXPECT_EQ(readLayer(*file.layers[0]), first);
            EXPECT_THAT(file.notes, Contains(HasSubstr("share label values")));
            ASSERT_EQ(file.labels.size(), 3u);
            EXPECT_EQ(file.labels[0].value, 1u);
            EXPECT_EQ(file.labels[0].name, "kidney left");
            EXPECT_EQ(file.labels[0].group, "Anatomical Structure");
            ASSERT_TRUE(file.labels[0].colour);
            EXPECT_FLOAT_EQ(file.labels[0].colour->r, 1);
            EXPECT_NEAR(file.labels[0].colour->g, 0.21404f, 1e-5); // linear light
            EXPECT_EQ(file.labels[1], (Label{7, "tumour", "", glm::vec3(0, 0, 1)}));
            EXPECT_EQ(file.labels[2], (Label{8, "cyst"}));
        }
}

TEST(NrrdLabels, OldFilesOfSlicerHaveALayerASegment) {
    const auto folder = labelTestFolder();
    std::vector<std::uint32_t> values(3 * kVoxels);
    for (std::size_t i = 0; i < values.size(); ++i)
        values[i] = i / 3 % (i % 3 + 2) == 0; // overlapping masks
    writeBytes(folder / "a.seg.nrrd", headerOf("uchar", "raw",
                                               "space: LPS\nspace directions: none (1,0,0) (0,1,0) (0,0,1)\n"
                                               "Segment0_Name:=a\nSegment1_Name:=b\nSegment2_ID:=c\n",
                                               "3 3 4 5") +
                                          "\n" + fileBytes<std::uint8_t>(values));
    LabelFile file = openLabelFile(folder / "a.seg.nrrd");
    ASSERT_EQ(file.layers.size(), 3u);
    EXPECT_EQ(file.labels, (std::vector<Label>{{1, "a"}, {2, "b"}, {3, "label 3"}}));
    for (std::uint32_t layer = 0; layer < 3; ++layer) {
        const std::vector<std::uint32_t> voxels = readLayer(*file.layers[layer]);
        for (std::size_t i = 0; i < kVoxels; ++i)
            ASSERT_EQ(voxels[i], i % (layer + 2) == 0 ? layer + 1 : 0);
    }
}

TEST(NrrdLabels, LiesAreRefused) {
    const auto folder = labelTestFolder();
    const std::string data = fileBytes<std::uint8_t>(someLabels()), packed = gzipped(data);
    const auto expectRefusal = [&](const std::string& header, const std::string& content,
                                   const std::string& part) {
        writeBytes(folder / "a.nrrd", header + "\n" + content);
        const std::string message = refusalOfReading(folder / "a.nrrd");
        EXPECT_THAT(message, HasSubstr(part)) << header;
        EXPECT_THAT(message, HasSubstr("a.nrrd"));
    };
    const std::string good = headerOf("uchar", "raw");
    const auto without = [&](const std::string& field) {
        std::string text = good;
        const std::size_t at = text.find("\n" + field + ":") + 1;
        return text.erase(at, text.find('\n', at) + 1 - at);
    };
    for (const char* field : {"type", "dimension", "sizes", "encoding"})
        expectRefusal(without(field), data, "the NRRD field \"" + std::string(field) + "\"");
    expectRefusal(headerOf("short", "raw"), data + data, "\"endian\" little or big");
    expectRefusal(headerOf("block", "raw"), data, "\"type\" of numbers");
    expectRefusal(headerOf("uchar", "bzip2"), data, "\"encoding\" raw, gzip or text");
    expectRefusal(headerOf("uchar", "raw", kPlace, "3 4 6"), data, "too short");
    expectRefusal(headerOf("uchar", "raw", kPlace, "3 4 4"), data, "12 bytes more");
    expectRefusal(headerOf("uchar", "raw", kPlace, "3 -4 5"), data, "\"sizes\"");
    expectRefusal(headerOf("uchar", "raw", kPlace, "0 4 5"), data, "\"sizes\"");
    expectRefusal(headerOf("uchar", "raw", kPlace, "2147483647 2147483647 2147483647"), data, "2^58");
    expectRefusal(headerOf("uchar", "raw", kPlace, "1073741824 1048576 1"), data, "too short");
    expectRefusal(headerOf("uchar", "raw", "", "3 20"), data, "three axes of space");
    expectRefusal(headerOf("uchar", "raw", "", "3 1 4 5"), data, "three axes of space");
    expectRefusal(headerOf("uchar", "raw", "kinds: domain domain list domain\n", "3 2 2 5"), data,
                  "axis 3 of 4");
    expectRefusal(headerOf("uchar", "raw", "kinds: domain domain domain time\n", "3 2 2 5"), data,
                  "\"time\"");
    expectRefusal(headerOf("uchar", "gzip", kPlace, "300 400 500"), packed, "too short");
    expectRefusal(headerOf("uchar", "gzip"), packed.substr(0, packed.size() / 2), "truncated");
    expectRefusal(headerOf("uchar", "gzip"), packed.substr(0, packed.size() - 3), "truncated");
    std::string wrongSum = packed;
    wrongSum[wrongSum.size() - 6] ^= 1;
    expectRefusal(headerOf("uchar", "gzip"), wrongSum, "damage");
    expectRefusal(headerOf("uchar", "gzip", kPlace, "3 4 4"), packed, "12 more");
    expectRefusal(headerOf("uchar", "ascii"), "1 2 3 4 x " + std::string(200, '1'), "\"x\"");
    std::string sixty;
    for (int i = 0; i < 60; ++i)
        sixty += "1 ";
    expectRefusal(headerOf("uchar", "ascii"), sixty.substr(4) + std::string(9, ' '), "truncated");
    expectRefusal(headerOf("uchar", "ascii"), sixty + "1 1 1", "3 more");
    expectRefusal(headerOf("float", "ascii"), "1.5 " + sixty.substr(2), "1.5");
    expectRefusal(headerOf("float", "ascii"), "-1 " + sixty.substr(2), "-1");
    expectRefusal(headerOf("float", "ascii"), "nan " + sixty.substr(2), "nan");
    expectRefusal(headerOf("int8", "raw"), "\xff" + data.substr(1), "-1");
    expectRefusal(headerOf("uchar", "raw", "space: LPS\nspace directions: (1,0,0) (1,0,0) (0,0,1)\n"), data,
                  "\"space directions\"");
    expectRefusal(headerOf("uchar", "raw", "space: LPS\nspace directions: (1,0,0) (0,1,0)\n"), data,
                  "\"space directions\" of 3 axes");
    expectRefusal(headerOf("uchar", "raw", "space: LPS\nspace directions: (1,0,0) (0,1,0) (0,0,nan)\n"), data,
                  "finite");
    expectRefusal(headerOf("uchar", "raw", "spacings: 1 2 0\n"), data, "\"spacings\"");
    expectRefusal(headerOf("uchar", "raw", kPlace + "line skip: 7\n"), data, "7 lines before the data");
    expectRefusal(headerOf("uchar", "gzip", kPlace + "byte skip: 70\n"), packed, "truncated");
    expectRefusal(headerOf("uchar", "gzip", kPlace + "byte skip: -1\n"), packed, "-1 with raw data");
    expectRefusal(good + "type: uchar\n", data, "every NRRD field once");
    expectRefusal(good + "no colon\n", data, "no colon");
    expectRefusal("NRRD0009\n" + good.substr(9), data, "version");
    expectRefusal(good + "Segment0_LabelValue:=0\n", data, "Segment0_LabelValue");
    expectRefusal(good + "Segment0_LabelValue:=x\n", data, "Segment0_LabelValue");
    expectRefusal(good + "Segment0_Layer:=1\n", data, "Segment0_Layer");
    expectRefusal(good + "Segment0_Color:=1 0\n", data, "Segment0_Color");
    expectRefusal(good + "Segment0_Name:=a\nSegment1_Name:=b\n", data, "different label values");
    expectRefusal(good + "data file: s%s.raw 1 5 1\n", data, "one %d");
    expectRefusal(good + "data file: s%d%n.raw 1 5 1\n", data, "one %d");
    expectRefusal(good + "data file: s%d.raw 1 999999999 1\n", data, "data files, as its sizes say");
    writeBytes(folder / "gone.nhdr", good + "data file: gone.raw\n");
    EXPECT_THAT(refusalOfReading(folder / "gone.nhdr"), HasSubstr("gone.raw"));
    writeBytes(folder / "b.nrrd", good);
    EXPECT_THAT(refusalOfReading(folder / "b.nrrd"), HasSubstr("truncated"));
    writeBytes(folder / "long.nrrd", good + "# " + std::string(std::size_t{17} << 20, 'x'));
    EXPECT_THAT(refusalOfReading(folder / "long.nrrd"), HasSubstr("16 MiB at most"));
    writeBytes(folder / "c.nrrd", "");
    EXPECT_THAT(refusalOfReading(folder / "c.nrrd"), HasSubstr("an NRRD file"));
}

TEST(NrrdLabels, LabelsOfAnotherLayerAreNotMistaken) {
    const auto folder = labelTestFolder();
    std::vector<std::uint32_t> values(2 * kVoxels);
    values[6] = 5;  // first layer
    values[9] = 77; // second layer: no segment's
    const std::string header =
        headerOf("uchar", "raw",
                 "kinds: list domain domain domain\nSegment0_LabelValue:=5\nSegment0_Layer:=0\n"
                 "Segment1_LabelValue:=6\nSegment1_Layer:=1\n",
                 "2 3 4 5");
    writeBytes(folder / "a.seg.nrrd", header + "\n" + fileBytes<std::uint8_t>(values));
    EXPECT_EQ(refusalOfReading(folder / "a.seg.nrrd"), "");
    values[9] = 5;
    writeBytes(folder / "a.seg.nrrd", header + "\n" + fileBytes<std::uint8_t>(values));
    EXPECT_THAT(refusalOfReading(folder / "a.seg.nrrd"), HasSubstr("a segment of another layer has"));
}

} // namespace
} // namespace tessera::test
