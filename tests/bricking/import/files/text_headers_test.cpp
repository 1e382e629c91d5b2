// tests/bricking/import/files/text_headers_test.cpp: the words of headers of text, one by one: numbers, names
// of types, spaces and units, names of data files, and the last value that each field may have.
#include "bricking/import/files/header_words.h"
#include "tests/support/import_test_tools.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <gmock/gmock.h>
#include <map>

namespace tessera::test {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(HeaderWords, NumbersAreWholeTexts) {
    for (const auto& [text, value] : std::vector<std::pair<std::string, std::optional<std::int64_t>>>{
             {"5", 5},
             {"+5", 5},
             {"-5", -5},
             {" \t7\r", 7},
             {"+-5", {}},
             {"", {}},
             {" ", {}},
             {"5 6", {}},
             {"5.0", {}},
             {"0x5", {}},
             {"9223372036854775807", std::numeric_limits<std::int64_t>::max()},
             {"9223372036854775808", {}}})
        EXPECT_EQ(wholeNumberOf(text), value) << text;
    for (const auto& [text, value] : std::vector<std::pair<std::string, std::optional<double>>>{
             {"+0.5", 0.5}, {" -1e3 ", -1000}, {"1e", {}}, {"1,5", {}}, {"1e999", {}}, {"inf", HUGE_VAL}})
        EXPECT_EQ(realNumberOf(text), value) << text;
    EXPECT_TRUE(std::isnan(realNumberOf("nan").value_or(0)));
    EXPECT_THAT(wordsOf("  one\ttwo \r three"), ElementsAre("one", "two", "three"));
    EXPECT_THAT(wordsOf("one"), ElementsAre("one"));
    EXPECT_THAT(wordsOf(" \t"), IsEmpty());
    EXPECT_EQ(withoutBlanks(" a b\t"), "a b");
    EXPECT_EQ(withoutBlanks(" \v\f\r"), "");
    EXPECT_EQ(lowered("AZaz@[`{"), "azaz@[`{");
    EXPECT_EQ(shownWord(std::string(60, 'x')), "\"" + std::string(60, 'x') + "\"");
    EXPECT_EQ(shownWord(std::string(61, 'x')), "\"" + std::string(60, 'x') + "...\"");
}

TEST(HeaderWords, NamesOfAPatternHaveOneNumber) {
    for (const auto& [pattern, name] : std::vector<std::pair<std::string, std::optional<std::string>>>{
             {"s%d.raw", "s42.raw"},
             {"%i", "42"},
             {"a%u", "a42"},
             {"s%2d", "s42"},
             {"s%3d", "s 42"},
             {"s%05d.dat", "s00042.dat"},
             {"s%020d", "s00000000000000000042"},
             {"s%099d", "s00000000000000000042"}, // at most 20 characters
             {"s%x", {}},
             {"s%", {}},
             {"s%03", {}},
             {"s%d%d", {}},
             {"s%%", {}},
             {"s", {}}})
        EXPECT_EQ(numberedName(pattern, 42), name) << pattern;
}

TEST(HeaderWords, HeadersHaveSixteenMebibytesAtMost) {
    const ScratchFolder folder;
    const auto lines = [&](const std::string& text) {
        writeFile(folder / "a", text);
        const InputFile file(folder / "a");
        HeaderLines header(file, "NRRD");
        std::vector<std::string> all;
        while (const std::optional<std::string> line = header.next()) {
            all.push_back(*line);
            EXPECT_LE(header.readBytes(), text.size());
        }
        EXPECT_EQ(header.readBytes(), text.size());
        return all;
    };
    EXPECT_THAT(lines("a\r\n\nb"), ElementsAre("a", "", "b"));
    EXPECT_THAT(lines("a\n"), ElementsAre("a"));
    EXPECT_THAT(lines(""), IsEmpty());
    const std::string portion(65535, 'p'), longer(65536, 'q'); // and their ends: read 64 KiB at a time
    EXPECT_THAT(lines(portion + "\n" + longer + "\nz"), ElementsAre(portion, longer, "z"));
    EXPECT_THAT(lines(std::string(std::size_t{16} << 20, 'x')), ::testing::SizeIs(1));
    writeFile(folder / "a", std::string((std::size_t{16} << 20) + 70000, 'x'));
    const InputFile file(folder / "a");
    HeaderLines header(file, "NRRD");
    EXPECT_THAT(refusal([&] { header.next(); }), HasSubstr("a header (NRRD) of 16 MiB at most"));
}

/// A volume of 3 x 2 x 1 values in a text header of each format.
class TextHeaders : public ::testing::Test {
  protected:
    VolumeInfo nrrd(const std::string& more, const std::string& type = "uchar", std::size_t bytes = 1) {
        writeFile(folder / "a.nrrd", "NRRD0005\ntype: " + type +
                                         "\ndimension: 3\nsizes: 3 2 1\nencoding: raw\nendian: little\n" +
                                         more + "\n" + std::string(6 * bytes, '\0'));
        const auto source = openSource(folder / "a.nrrd", {.spacingMm = spacingMm});
        described = source->describe();
        return source->info();
    }
    VolumeInfo meta(const std::string& more, const std::string& type = "MET_UCHAR", std::size_t bytes = 1) {
        writeFile(folder / "a.mha", "ObjectType = Image\nNDims = 3\nDimSize = 3 2 1\nElementType = " + type +
                                        "\n" + more + "ElementDataFile = LOCAL\n" +
                                        std::string(6 * bytes, '\0'));
        const auto source = openSource(folder / "a.mha", {.spacingMm = spacingMm});
        described = source->describe();
        return source->info();
    }
    ScratchFolder folder;
    std::optional<glm::dvec3> spacingMm;
    std::string described;
};

const std::string kSpacingsField = "spacings: 2 3 4\n", kSpacingField = "ElementSpacing = 2 3 4\n";

TEST_F(TextHeaders, TypesOfEveryName) {
    for (const auto& [words, name, bytes, type] :
         std::vector<std::tuple<const char*, const char*, std::size_t, ValueType>>{
             {"signed char,int8,int8_t", "int8", 1, ValueType::i16},
             {"uchar,unsigned char,uint8,uint8_t", "uint8", 1, ValueType::u8},
             {"short,short int,signed short,signed short int,int16,int16_t", "int16", 2, ValueType::i16},
             {"ushort,unsigned short,unsigned short int,uint16,uint16_t", "uint16", 2, ValueType::u16},
             {"int,signed int,int32,int32_t", "int32", 4, ValueType::f32},
             {"uint,unsigned int,uint32,uint32_t", "uint32", 4, ValueType::f32},
             {"longlong,long long,long long int,signed long long,signed long long int,int64,int64_t", "int64",
              8, ValueType::f32},
             {"ulonglong,unsigned long long,unsigned long long int,uint64,uint64_t", "uint64", 8,
              ValueType::f32},
             {"float,Float", "float32", 4, ValueType::f32},
             {"double", "float64", 8, ValueType::f32}}) {
        std::stringstream list(words);
        for (std::string word; std::getline(list, word, ',');) {
            EXPECT_EQ(nrrd(kSpacingsField, word, bytes).type, type) << word;
            EXPECT_THAT(described, HasSubstr(std::string("NRRD (raw), ") + name)) << word;
        }
    }
    for (const auto& [word, name, bytes, type] :
         std::vector<std::tuple<const char*, const char*, std::size_t, ValueType>>{
             {"MET_CHAR", "int8", 1, ValueType::i16},
             {"MET_UCHAR", "uint8", 1, ValueType::u8},
             {"MET_SHORT", "int16", 2, ValueType::i16},
             {"MET_USHORT", "uint16", 2, ValueType::u16},
             {"MET_INT", "int32", 4, ValueType::f32},
             {"MET_UINT", "uint32", 4, ValueType::f32},
             {"MET_LONG", "int32", 4, ValueType::f32},
             {"MET_ULONG", "uint32", 4, ValueType::f32},
             {"MET_LONG_LONG", "int64", 8, ValueType::f32},
             {"MET_ULONG_LONG", "uint64", 8, ValueType::f32},
             {"MET_FLOAT", "float32", 4, ValueType::f32},
             {"MET_DOUBLE", "float64", 8, ValueType::f32}}) {
        const VolumeInfo info = meta(kSpacingField, word, bytes);
        EXPECT_EQ(info.type, type) << word;
        EXPECT_THAT(described, HasSubstr(name)) << word;
        EXPECT_EQ(info.remarks.size(), bytes > 1 ? 1u : 0u) << word << ": the order of bytes is not stated";
        EXPECT_THAT(meta(kSpacingField + "ElementByteOrderMSB = False\n", word, bytes).remarks, IsEmpty())
            << word;
    }
}

// The words of teem's definition, in any mixture of axes.
TEST_F(TextHeaders, SpacesOfEveryDirection) {
    const std::array<std::array<const char*, 2>, 3> words = {
        {{"left", "right"}, {"posterior", "anterior"}, {"superior", "inferior"}}};
    for (int n = 0; n < 8; ++n) {
        const std::array<std::size_t, 3> way = {static_cast<std::size_t>(n & 1),
                                                static_cast<std::size_t>(n >> 1 & 1),
                                                static_cast<std::size_t>(n >> 2)};
        std::string name, letters;
        glm::dvec3 sign;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            name += (axis == 0 ? "" : "-") + std::string(words[axis][way[axis]]);
            letters += static_cast<char>(std::toupper(words[axis][way[axis]][0]));
            sign[static_cast<int>(axis)] = way[axis] == 0 ? 1 : -1;
        }
        for (const std::string& space : {name, letters}) {
            const VolumeInfo info = nrrd("space: " + space +
                                         "\nspace directions: (2,0,0) (0,3,0.5) (0.25,0,4)\n"
                                         "space origin: (10,20,30)\n");
            EXPECT_TRUE(info.orientationKnown) << space;
            EXPECT_THAT(info.remarks, IsEmpty()) << space;
            glm::dvec3 place =
                sign * (glm::dvec3(10, 20, 30) + 2.0 * glm::dvec3(2, 0, 0) + glm::dvec3(0, 3, 0.5));
            const int x = way[0] == 0 ? 2 : 0,
                      y = way[1] == 0 ? 1 : 0; // axes that run the other way are turned
            EXPECT_LT(glm::length(centreMm(info, x, y, 0) - place), 1e-9) << space;
        }
    }
    for (const std::string space :
         {"LP", "LPSX", "PLS", "left-posterior", "leftposteriorsuperior", "left-posterior-superior-time",
          "scanner-xyz", "LLS", "left-posterior-superiors"}) {
        const VolumeInfo info =
            nrrd("space: " + space + "\nspace directions: (2,0,0) (0,3,0) (0,0,4)\nspace origin: (1,2,3)\n");
        EXPECT_FALSE(info.orientationKnown) << space;
        EXPECT_THAT(info.remarks, ElementsAre(HasSubstr("the orientation in the patient is not known")))
            << space;
        EXPECT_EQ(firstVoxelCentreMm(info), glm::dvec3(1, 2, 3)) << space;
    }
}

TEST_F(TextHeaders, UnitsOfLength) {
    for (const auto& [unit, mm] : std::map<std::string, double>{{"mm", 1},
                                                                {"millimeter", 1},
                                                                {"millimeters", 1},
                                                                {"cm", 10},
                                                                {"m", 1000},
                                                                {"um", 1e-3},
                                                                {"\xc2\xb5m", 1e-3},
                                                                {"micron", 1e-3},
                                                                {"microns", 1e-3}}) {
        const std::string thrice = "\"" + unit + "\" \"" + unit + "\" \"" + unit + "\"\n";
        EXPECT_EQ(nrrd(kSpacingsField + "units: " + thrice).spacingMm(), mm * glm::dvec3(2, 3, 4)) << unit;
        const VolumeInfo info = nrrd(
            "space: LPS\nspace directions: (2,0,0) (0,3,0) (0,0,4)\nspace origin: (1,2,3)\nspace units: " +
            thrice);
        EXPECT_EQ(info.spacingMm(), mm * glm::dvec3(2, 3, 4)) << unit;
        EXPECT_LT(glm::length(firstVoxelCentreMm(info) - mm * glm::dvec3(1, 2, 3)), 1e-9 * mm) << unit;
    }
    EXPECT_THAT(refusal([&] { nrrd(kSpacingsField + "units: \"mm\" \"mm\" \"cm\"\n"); }),
                HasSubstr("--spacing"));
    for (const auto& [unit, mm] :
         std::map<std::string, double>{{"?", 1}, {"mm", 1}, {"cm", 10}, {"um", 1e-3}, {"CM", 10}}) {
        const VolumeInfo info = meta(kSpacingField + "DistanceUnits = " + unit + "\nOffset = 1 2 3\n");
        EXPECT_LT(glm::length(info.spacingMm() - mm * glm::dvec3(2, 3, 4)), 1e-12) << unit;
        EXPECT_LT(glm::length(firstVoxelCentreMm(info) - mm * glm::dvec3(1, 2, 3)), 1e-12) << unit;
    }
}

// Where a header does not say the spacing, its places count in units that are not known.
TEST_F(TextHeaders, WhatIsNotSaidIsTold) {
    spacingMm = glm::dvec3(2, 5, 7);
    const VolumeInfo bare = nrrd("");
    EXPECT_EQ(bare.spacingMm(), *spacingMm);
    EXPECT_EQ(firstVoxelCentreMm(bare), glm::dvec3(0));
    EXPECT_THAT(bare.remarks, ElementsAre(HasSubstr("the orientation in the patient is not known")));
    const VolumeInfo feet =
        nrrd("space: LPS\nspace units: \"ft\" \"ft\" \"ft\"\nspace directions: (3,0,0) (0,0.25,0) (0,0,4)\n"
             "space origin: (1,2,3)\n");
    EXPECT_EQ(feet.spacingMm(), *spacingMm);
    EXPECT_EQ(firstVoxelCentreMm(feet), glm::dvec3(0));
    EXPECT_THAT(feet.remarks, ElementsAre(HasSubstr("\"space origin\" in a unit that is not known")));
    const VolumeInfo half = nrrd("spacings: 3 nan 4\n");
    EXPECT_EQ(half.spacingMm(), glm::dvec3(3, 5, 4));
    spacingMm.reset();
    EXPECT_THAT(nrrd("space: LPS\nspace directions: (2,0,0) (0,3,0) (0,0,4)\n").remarks,
                ElementsAre(HasSubstr("no \"space origin\"")));
    EXPECT_EQ(nrrd(kSpacingsField + "sample units: HU\n").unit, "HU");
    EXPECT_EQ(nrrd(kSpacingsField + "sampleunits: \"HU\"\n").unit, "HU");
    EXPECT_EQ(nrrd(kSpacingsField + "sample units: T1\n").unit, "");
}

TEST_F(TextHeaders, NrrdFieldsUpToTheirLastValue) {
    const auto outcome = [&](const std::string& text) -> std::string {
        writeFile(folder / "a.nrrd", text);
        try {
            openSource(folder / "a.nrrd", {});
            return "";
        } catch (const InputError& error) {
            return error.what();
        }
    };
    const std::string six(6, '\0');
    const auto magic = [&](const char* version) {
        return outcome(std::string("NRRD") + version +
                       "\ntype: uchar\ndimension: 3\nsizes: 3 2 1\nencoding: raw\n" + kSpacingsField + "\n" +
                       six);
    };
    for (const char* version : {"0001", "0002", "0003", "0004", "0005"})
        EXPECT_EQ(magic(version), "") << version;
    for (const char* version : {"0000", "0006", "00011", "1001"})
        EXPECT_THAT(magic(version), HasSubstr("NRRD0001 to NRRD0005")) << version;
    const auto with = [&](const std::string& shape, const std::string& more = kSpacingsField,
                          const std::string& data = std::string(6, '\0')) {
        return outcome("NRRD0004\ntype: uchar\nencoding: raw\n" + shape + more + "\n" + data);
    };
    EXPECT_EQ(with("dimension: 3\nsizes: 3 2 1\n# a comment: with a colon\nkey:=value\nother: field\n"), "");
    EXPECT_THAT(with("dimension: 3\nsizes: 3 2\n"),
                EndsWith("\"sizes\" of 3 axes, as \"dimension\" says, found 2 values"));
    EXPECT_THAT(with("dimension: 0\nsizes: 1\n"),
                HasSubstr("\"dimension\" as a whole number from 1 to 16, found \"0\""));
    EXPECT_THAT(with("dimension: 17\nsizes: 1\n"), HasSubstr("from 1 to 16"));
    EXPECT_THAT(with("dimension: 16\nsizes: 3 2 1\n"), HasSubstr("of 16 axes"));
    EXPECT_THAT(with("dimension: 3\nsizes: 3 0 1\n"),
                HasSubstr("\"sizes\" as a whole number from 1 to 2147483647"));
    EXPECT_THAT(with("dimension: 3\nsizes: 2147483648 1 1\n"), HasSubstr("2147483647"));
    EXPECT_THAT(with("dimension: 3\nsizes: 536870912 536870912 1\n"), HasSubstr("too short"))
        << "2^58 values";
    EXPECT_THAT(with("dimension: 3\nsizes: 536870912 536870913 1\n"), HasSubstr("2^58 values at most"));
    EXPECT_THAT(with("dimension: 3\nsizes: 3 2 1\nspace dimension: 4\n"),
                HasSubstr("\"space dimension\" as a whole number from 3 to 3"));
    EXPECT_EQ(with("dimension: 3\nsizes: 3 2 1\nspace dimension: 3\n"), "");
    EXPECT_THAT(with("dimension: 3\nsizes: 3 2 1\nsizes: 3 2 1\n"), HasSubstr("\"sizes\" again"));
    EXPECT_THAT(with("dimension: 3\nsizes: 3 2 1\nline skip: -1\n"),
                HasSubstr("\"line skip\" as a whole number from 0 to"));
    EXPECT_THAT(with("dimension: 3\nsizes: 3 2 1\nbyte skip: -2\n"),
                HasSubstr("\"byte skip\" as a whole number from -1 to"));
    EXPECT_EQ(with("dimension: 3\nsizes: 3 2 1\nbyte skip: 4\n", kSpacingsField, "skip" + six), "");
    EXPECT_EQ(with("dimension: 3\nsizes: 3 2 1\nline skip: 2\n", kSpacingsField, "one\ntwo\n" + six), "");
    EXPECT_EQ(
        with("dimension: 3\nsizes: 3 2 1\nline skip: 1\nbyte skip: 1\n", kSpacingsField, "one\n2" + six), "");
    EXPECT_THAT(with("dimension: 3\nsizes: 3 2 1\nline skip: 2\n", kSpacingsField, "one\n" + six),
                EndsWith("2 lines before the data, as \"line skip\" says, found 1"));
    EXPECT_EQ(with("dimension: 3\nsizes: 3 2 1\n", kSpacingsField, six + "12"), "") << "less than a row more";
    EXPECT_THAT(with("dimension: 3\nsizes: 3 2 1\n", kSpacingsField, six + "123"), HasSubstr("3 bytes more"));
    EXPECT_THAT(
        with("dimension: 3\nsizes: 3 2 1\n", kSpacingsField, "12345"),
        EndsWith(
            "expected 6 values of 3 x 2 x 1, found a file of 5 bytes behind the header, too short for them"));
    for (const char* vector : {"(2,0,0)(0,3,0)(0,0,4)", "( 2 , 0 , 0 ) (0,3,0) (0,0,4)"})
        EXPECT_EQ(with("dimension: 3\nsizes: 3 2 1\n",
                       std::string("space: LPS\nspace directions: ") + vector + "\n"),
                  "")
            << vector;
    for (const char* vector :
         {"(2,0) (0,3,0) (0,0,4)", "(2,0,0,1) (0,3,0) (0,0,4)", "2,0,0 (0,3,0) (0,0,4)",
          "(2,0,0 (0,3,0) (0,0,4)", "(2,0,inf) (0,3,0) (0,0,4)", "(2,,0) (0,3,0) (0,0,4)"})
        EXPECT_NE(with("dimension: 3\nsizes: 3 2 1\n",
                       std::string("space: LPS\nspace directions: ") + vector + "\n"),
                  "")
            << vector;
    for (const char* encoding : {"gzip", "gz", "GZIP", "raw", "text", "txt", "ascii"}) {
        const std::string word(encoding);
        const std::string data = word == "raw"                                         ? six
                                 : word.size() > 3 && word[0] != 'g' && word[0] != 'G' ? "0 0 0 0 0 0"
                                 : word == "txt"                                       ? "0 0 0 0 0 0"
                                                                                       : gzip(six);
        EXPECT_EQ(outcome("NRRD0004\ntype: uchar\ndimension: 3\nsizes: 3 2 1\n" + kSpacingsField +
                          "encoding: " + word + "\n\n" + data),
                  "")
            << word;
    }
}

// Data in several files, whose numbers go up or down by any step.
TEST_F(TextHeaders, PatternsCountUpAndDown) {
    const auto values = [&](const std::string& pattern, int first, int step, int width) {
        for (int z = 0; z < 3; ++z) {
            std::string digits = std::to_string(first + step * z);
            digits.insert(0, static_cast<std::size_t>(std::max(0, width - static_cast<int>(digits.size()))),
                          '0');
            writeFile(folder / ("s" + digits + ".raw"), std::string(2, static_cast<char>('a' + z)));
        }
        writeFile(folder / "a.nhdr", "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 1 3\nencoding: raw\n" +
                                         kSpacingsField + "data file: " + pattern + "\n");
        const auto source = openSource(folder / "a.nhdr", {});
        EXPECT_THAT(source->describe(), HasSubstr(" in 3 files"));
        return readAll<std::uint8_t>(*source);
    };
    const std::vector<std::uint8_t> expected = {'a', 'a', 'b', 'b', 'c', 'c'};
    EXPECT_EQ(values("s%d.raw 0 2 1", 0, 1, 0), expected);
    EXPECT_EQ(values("s%03d.raw 4 9 2", 4, 2, 3), expected) << "8 is the last one up to 9";
    EXPECT_EQ(values("s%d.raw 30 10 -10", 30, -10, 0), expected);
    EXPECT_EQ(values("s%d.raw 5 7 1 2", 5, 1, 0), expected) << "slices";
    EXPECT_EQ(values("s%d.raw 5 7 1 3", 5, 1, 0), expected) << "parts along the slowest axis";
    const auto refused = [&](const std::string& pattern) {
        return refusal([&] { values(pattern, 0, 1, 0); });
    };
    EXPECT_THAT(refused("s%d.raw 0 2 0"), HasSubstr("leads from its first number to its last, found 0"));
    EXPECT_THAT(refused("s%d.raw 0 2 -1"), HasSubstr("found -1"));
    EXPECT_THAT(refused("s%d.raw 0 3 1"), HasSubstr("3 data files, as its sizes say, found 4"));
    EXPECT_THAT(refused("s%d.raw 0 1000000000 1"), HasSubstr("from 0 to 999999999"));
    EXPECT_THAT(refused("s%d.raw -1 1 1"), HasSubstr("from 0 to 999999999"));
    EXPECT_THAT(refused("s%d.raw 0 2 1 4"), HasSubstr("from 1 to 3"));
    EXPECT_THAT(refused("s%d.raw 0 2 1 0"), HasSubstr("from 1 to 3"));
    EXPECT_THAT(refused("s%d.raw 0 2 1 2 1"), HasSubstr("PATTERN MIN MAX STEP"));
    EXPECT_THAT(refused("s%d%d.raw 0 2 1"), HasSubstr("one %d in the pattern"));
}

// Values stay below 1e12, whatever the type has; of more than 24 bits a float has as many.
TEST_F(TextHeaders, SlopesByTheTypesLargestNumber) {
    const auto isTaken = [&](const char* type, std::size_t bytes, double slope, double intercept) {
        char text[128];
        std::snprintf(text, sizeof text,
                      "ElementToIntensityFunctionSlope = %.12g\nElementToIntensityFunctionOffset = %.12g\n",
                      slope, intercept);
        try {
            meta(kSpacingField + text, type, bytes);
            return true;
        } catch (const InputError&) {
            return false;
        }
    };
    for (const auto& [type, bytes, bits] :
         std::vector<std::tuple<const char*, std::size_t, int>>{{"MET_UCHAR", 1, 8},
                                                                {"MET_SHORT", 2, 16},
                                                                {"MET_INT", 4, 24},
                                                                {"MET_LONG_LONG", 8, 24},
                                                                {"MET_FLOAT", 4, 0},
                                                                {"MET_DOUBLE", 8, 0}}) {
        const double most = std::ldexp(1e12, -bits);
        EXPECT_TRUE(isTaken(type, bytes, 0.999 * most, 0)) << type;
        EXPECT_FALSE(isTaken(type, bytes, 1.001 * most, 0)) << type;
        EXPECT_EQ(isTaken(type, bytes, 1e-6, 100), bits == 0) << type;
    }
}

TEST_F(TextHeaders, MetaImageFieldsUpToTheirLastValue) {
    for (const char* yes : {"True", "true", "T", "t", "1", "yes"})
        EXPECT_THAT(
            refusal([&] { meta(kSpacingField + "BinaryData = False\nCompressedData = " + yes + "\n"); }),
            HasSubstr("compressed data that are binary"))
            << yes;
    for (const char* no : {"False", "f", "0", "no", "NO"})
        EXPECT_NO_THROW(meta(kSpacingField + "CompressedData = " + no + "\n")) << no;
    for (const char* field : {"Offset", "Position", "Origin"})
        EXPECT_EQ(firstVoxelCentreMm(meta(kSpacingField + field + " = 1 2 3\n")), glm::dvec3(1, 2, 3))
            << field;
    for (const char* field : {"TransformMatrix", "Rotation", "Orientation"}) {
        const VolumeInfo info = meta(kSpacingField + field + " = 1 0 0 0 0.8 0.6 0 -0.6 0.8\n");
        EXPECT_LT(glm::length(glm::dvec3(info.patientFromVoxel[1]) - glm::dvec3(0, 2.4, 1.8)), 1e-12)
            << field;
        EXPECT_TRUE(info.orientationKnown);
    }
    EXPECT_EQ(meta("ElementSize = 2 3 4\n").spacingMm(), glm::dvec3(2, 3, 4));
    EXPECT_EQ(meta("ElementSize = 7 7 7\n" + kSpacingField).spacingMm(), glm::dvec3(2, 3, 4));
    const auto matrix = [&](const char* length) {
        return kSpacingField + "TransformMatrix = 1 0 0 0 " + length + " 0 0 0 1\n";
    };
    EXPECT_NO_THROW(meta(matrix("1.0009")));
    EXPECT_NO_THROW(meta(matrix("-0.9991")));
    for (const char* length : {"1.0015", "0.9985"})
        EXPECT_THAT(refusal([&] { meta(matrix(length)); }),
                    HasSubstr("length " + std::to_string(std::stod(length))));
    for (const auto& [word, modality] : std::map<std::string, std::string>{{"MET_MOD_CT", "CT"},
                                                                           {"MET_MOD_MR", "MR"},
                                                                           {"MET_MOD_NM", "NM"},
                                                                           {"MET_MOD_US", "US"},
                                                                           {"MET_MOD_OTHER", ""}})
        EXPECT_EQ(meta(kSpacingField + "Modality = " + word + "\n").acquisition.modality, modality);
    const VolumeInfo offset = meta(kSpacingField + "ElementToIntensityFunctionOffset = 5\n");
    EXPECT_EQ(offset.rescaleSlope, 1);
    EXPECT_EQ(offset.rescaleIntercept, 5);
    const VolumeInfo slope = meta(kSpacingField + "ElementToIntensityFunctionSlope = 3\n");
    EXPECT_EQ(slope.rescaleSlope, 3);
    EXPECT_EQ(slope.rescaleIntercept, 0);
    EXPECT_THAT(refusal([&] { meta(kSpacingField + "ElementToIntensityFunctionSlope = 1 2\n"); }),
                HasSubstr("of 1 numbers"));
    EXPECT_THAT(refusal([&] { meta("ElementSpacing = 1 2\n"); }), HasSubstr("of 3 numbers"));
    EXPECT_NO_THROW(meta(kSpacingField + "ElementNumberOfChannels = 1\nComment = a\nComment = b\n"));
    // The matrix and the letters, both of where axes begin.
    const std::string turned =
        kSpacingField + "TransformMatrix = 0 1 0 0 0 -1 1 0 0\nAnatomicalOrientation = ";
    EXPECT_THAT(meta(turned + "ASR\n").remarks, IsEmpty());
    for (const char* other : {"PSR", "AIR", "ASL", "RAS"})
        EXPECT_THAT(meta(turned + other + "\n").remarks,
                    ElementsAre(HasSubstr("AnatomicalOrientation contradicts")))
            << other;
    EXPECT_THAT(meta(turned + "???\n").remarks, IsEmpty());
    EXPECT_THAT(meta(kSpacingField + "AnatomicalOrientation = LPI\n").remarks, IsEmpty()) << "no matrix";
}

} // namespace
} // namespace tessera::test
