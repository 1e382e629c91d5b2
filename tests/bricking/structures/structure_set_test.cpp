// tests/bricking/structures/structure_set_test.cpp: contours of DICOM structure sets: what is read, and what
// is refused. DCMTK writes the files.
#include "bricking/import/structures/structure_lines.h"
#include "core/base/error.h"

#include <dcmtk/config/osconfig.h>
#include <dcmtk/dcmdata/dctk.h>
#include <filesystem>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <iterator>
#include <random>
#include <unistd.h>

namespace tessera {
namespace {

using testing::AllOf;
using testing::HasSubstr;

struct WrittenContour {
    std::string kind = "CLOSED_PLANAR", count = "4", data = R"(0\0\5\10.5\0\5\10.5\-20\5\0\-20\5)";
};
struct WrittenStructure {
    std::string number, name, colour;
    std::vector<WrittenContour> contours;
    std::string referenced = {}; // "": its own number
    std::string frame = {};      // of reference
};

class StructureSets : public testing::Test {
  protected:
    void SetUp() override {
        const auto* const test = testing::UnitTest::GetInstance()->current_test_info();
        folder_ = std::filesystem::temp_directory_path() /
                  ("tessera-structures-" + std::string(test->name()) + "-" + std::to_string(::getpid()));
        std::filesystem::create_directories(folder_);
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    std::filesystem::path write(const std::vector<WrittenStructure>& structures,
                                E_TransferSyntax syntax = EXS_LittleEndianExplicit,
                                const std::vector<std::string>& frames = {}, // of the whole set
                                const std::string& ownFrame = {}) const {
        DcmFileFormat format;
        DcmItem& set = *format.getDataset();
        const auto put = [](DcmItem& item, const DcmTagKey& tag, const std::string& text) {
            if (!text.empty()) {
                EXPECT_TRUE(item.putAndInsertString(tag, text.c_str()).good()) << text;
            }
        };
        const auto add = [](DcmItem& item, const DcmTagKey& sequence) -> DcmItem& {
            DcmItem* made = nullptr;
            EXPECT_TRUE(item.findOrCreateSequenceItem(sequence, made, -2).good()); // a new one
            return *made;
        };
        put(set, DCM_SOPClassUID, UID_RTStructureSetStorage);
        put(set, DCM_SOPInstanceUID, "1.2.5");
        put(set, DCM_StructureSetLabel, "S");
        put(set, DCM_FrameOfReferenceUID, ownFrame);
        for (const std::string& frame : frames)
            put(add(set, DCM_ReferencedFrameOfReferenceSequence), DCM_FrameOfReferenceUID, frame);
        for (const WrittenStructure& s : structures) {
            DcmItem& roi = add(set, DCM_StructureSetROISequence);
            put(roi, DCM_ROINumber, s.number);
            put(roi, DCM_ROIName, s.name);
            put(roi, DCM_ReferencedFrameOfReferenceUID, s.frame);
            if (s.contours.empty())
                continue;
            DcmItem& item = add(set, DCM_ROIContourSequence);
            put(item, DCM_ReferencedROINumber, s.referenced.empty() ? s.number : s.referenced);
            put(item, DCM_ROIDisplayColor, s.colour);
            for (const WrittenContour& c : s.contours) {
                DcmItem& contour = add(item, DCM_ContourSequence);
                put(contour, DCM_ContourGeometricType, c.kind);
                put(contour, DCM_NumberOfContourPoints, c.count);
                put(contour, DCM_ContourData, c.data);
            }
        }
        const std::filesystem::path path = folder_ / "rs.dcm";
        EXPECT_TRUE(format.saveFile(path.c_str(), syntax).good());
        return path;
    }
    std::string refusalOf(const std::filesystem::path& path) {
        try {
            readStructureSet(path, ram_);
        } catch (const InputError& e) {
            EXPECT_THAT(e.what(), HasSubstr(path.filename().string()));
            return e.what();
        }
        return "";
    }
    std::string refusalOf(const WrittenContour& contour) {
        return refusalOf(write({{"1", "A", "1\\2\\3", {contour}}}));
    }

    std::filesystem::path folder_;
    MemoryBudget ram_{"RAM", "--ram", std::size_t{64} << 20};
};

const std::vector<WrittenStructure> kTwoStructures = {
    {"7", "liver", "255\\128\\0", {{}, {"POINT", "1", R"(1\2\3)"}}},
    {"3", "needle", "0\\0\\255", {{"OPEN_NONPLANAR", "3", R"(+1e2\-2.25\3 \4\5\6\7\8\9)"}}},
    {"4", "empty", "", {}}};

TEST_F(StructureSets, PointsAndColoursComeBack) {
    for (const E_TransferSyntax syntax :
         {EXS_LittleEndianExplicit, EXS_LittleEndianImplicit, EXS_BigEndianExplicit}) {
        const StructureSet set = readStructureSet(write(kTwoStructures, syntax), ram_);
        ASSERT_EQ(set.structures.size(), 2u);
        const Structure &needle = set.structures[0], &liver = set.structures[1];
        EXPECT_EQ(needle.label.value, 3u);
        EXPECT_EQ(needle.label.name, "needle");
        EXPECT_EQ(needle.label.colour, glm::vec3(0, 0, 1));
        ASSERT_EQ(needle.contours.size(), 1u);
        EXPECT_EQ(needle.contours[0].form, ContourForm::line);
        EXPECT_THAT(
            needle.contours[0].points,
            testing::ElementsAre(glm::dvec3(100, -2.25, 3), glm::dvec3(4, 5, 6), glm::dvec3(7, 8, 9)));
        EXPECT_EQ(liver.label.name, "liver");
        ASSERT_TRUE(liver.label.colour);
        EXPECT_NEAR(liver.label.colour->y, 0.2158605, 1e-6); // 128 of 255, sRGB
        ASSERT_EQ(liver.contours.size(), 2u);
        EXPECT_EQ(liver.contours[0].form, ContourForm::ring);
        EXPECT_THAT(liver.contours[0].points,
                    testing::ElementsAre(glm::dvec3(0, 0, 5), glm::dvec3(10.5, 0, 5),
                                         glm::dvec3(10.5, -20, 5), glm::dvec3(0, -20, 5)));
        EXPECT_EQ(liver.contours[1].form, ContourForm::points);
        EXPECT_THAT(set.notes, testing::Contains(HasSubstr("4 \"empty\" has no contours")));
    }
    EXPECT_EQ(ram_.usedBytes(), 0u);
}

TEST_F(StructureSets, RingsAreClosedAndLinesAreNot) {
    const StructureSet set = readStructureSet(write(kTwoStructures), ram_);
    const StructureLines needle = linesOf(set.structures[0], ram_), liver = linesOf(set.structures[1], ram_);
    EXPECT_THAT(needle.ends, testing::ElementsAre(3u));
    EXPECT_EQ(needle.points, set.structures[0].contours[0].points);
    EXPECT_THAT(liver.ends, testing::ElementsAre(5u, 6u)); // a ring of four points, a point
    ASSERT_EQ(liver.points.size(), 6u);
    EXPECT_EQ(liver.points[4], liver.points[0]);
    EXPECT_EQ(liver.points[5], glm::dvec3(1, 2, 3));
}

TEST_F(StructureSets, FramesOfReference) {
    const auto frameOf = [&](const std::string& own, const std::vector<std::string>& ofSet,
                             const std::string& ofObject) {
        const std::filesystem::path file =
            write({{"1", "A", "", {{}}, "", own}}, EXS_LittleEndianExplicit, ofSet, ofObject);
        return readStructureSet(file, ram_).structures.at(0).frameOfReference;
    };
    EXPECT_EQ(frameOf("1.2.1", {"1.2.2", "1.2.3"}, "1.2.4"), "1.2.1");
    EXPECT_EQ(frameOf("", {"1.2.2"}, "1.2.4"), "1.2.2");
    EXPECT_EQ(frameOf("", {"1.2.2", "1.2.2"}, ""), "1.2.2");
    EXPECT_EQ(frameOf("", {"1.2.2", "1.2.3"}, "1.2.4"), "") << "any of them";
    EXPECT_EQ(frameOf("", {}, "1.2.4"), "1.2.4");
    EXPECT_EQ(frameOf("", {}, ""), "");
    EXPECT_EQ(frameOf("NO UID", {}, ""), "");
    EXPECT_EQ(frameOf(std::string(70, '1'), {"1.2.2"}, ""), "1.2.2");
}

TEST_F(StructureSets, ContoursThatAreNone) {
    EXPECT_EQ(refusalOf(WrittenContour{}), "");
    EXPECT_THAT(refusalOf(WrittenContour{"CLOSED_PLANAR", "5"}),
                AllOf(HasSubstr("15 numbers, for 5 points"), HasSubstr("found 12"), HasSubstr("1 \"A\"")));
    EXPECT_THAT(refusalOf(WrittenContour{"CLOSED_PLANAR", "3"}), HasSubstr("9 numbers"));
    EXPECT_THAT(refusalOf(WrittenContour{"CLOSED_PLANAR", "2000000000"}), HasSubstr("6000000000 numbers"));
    EXPECT_THAT(refusalOf(WrittenContour{"CLOSED_PLANAR", "99999999999"}), HasSubstr("a whole number"));
    EXPECT_THAT(refusalOf(WrittenContour{"CLOSED_PLANAR", "0"}), HasSubstr("at least 1"));
    EXPECT_THAT(refusalOf(WrittenContour{"CLOSED_PLANAR", "1", R"(1\nan\2)"}), HasSubstr("finite numbers"));
    EXPECT_THAT(refusalOf(WrittenContour{"CLOSED_PLANAR", "1", R"(1\inf\2)"}), HasSubstr("finite numbers"));
    EXPECT_THAT(refusalOf(WrittenContour{"CLOSED_PLANAR", "1", R"(1\\2)"}), HasSubstr("finite numbers"));
    EXPECT_THAT(refusalOf(WrittenContour{"CLOSED_PLANAR", "1", R"(1\1e7\2)"}),
                HasSubstr("within 1000000 mm"));
    EXPECT_THAT(refusalOf(WrittenContour{"SPIRAL"}), HasSubstr("\"SPIRAL\""));
    EXPECT_LT(ram_.peakBytes(), std::size_t{1} << 20);
}

TEST_F(StructureSets, StructuresThatAreNone) {
    EXPECT_THAT(refusalOf(write({{"1", "A", "1\\2\\3", {{}}, "2"}})),
                AllOf(HasSubstr("of a structure in StructureSetROISequence"), HasSubstr("found 2")));
    EXPECT_THAT(refusalOf(write({{"1", "A", "", {{}}}, {"1", "B", "", {}}})),
                HasSubstr("several of number 1"));
    EXPECT_THAT(refusalOf(write({{"1", "A", "1\\2\\300", {{}}}})), HasSubstr("from 0 to 255"));
    EXPECT_THAT(refusalOf(write({{"1", "A", "", {}}})), HasSubstr("structures with contours"));
    std::ofstream(folder_ / "no.dcm") << "no DICOM";
    EXPECT_THAT(refusalOf(folder_ / "no.dcm"), HasSubstr("a DICOM RT Structure Set"));
    MemoryBudget small("RAM", "--ram", 4096);
    EXPECT_THROW(readStructureSet(write(kTwoStructures), small), InputError);
}

// Numbers up to their last, and every kind of contour.
TEST_F(StructureSets, BoundsAndKinds) {
    EXPECT_EQ(refusalOf(WrittenContour{"CLOSED_PLANAR", "1", R"(1e6\-1e6\2)"}), "");
    EXPECT_THAT(refusalOf(WrittenContour{"CLOSED_PLANAR", "1", R"(1\-1.1e6\2)"}),
                HasSubstr("within 1000000 mm, found -1100000"));
    EXPECT_THAT(refusalOf(WrittenContour{"CLOSED_PLANAR", "", R"(1\2\3)"}),
                HasSubstr("of at least 1, found none"));
    EXPECT_THAT(refusalOf(WrittenContour{"CLOSED_PLANAR", "-1", R"(1\2\3)"}),
                HasSubstr("a whole number from 0 to 2147483647, found \"-1\""));
    EXPECT_THAT(refusalOf(WrittenContour{"", "1", R"(1\2\3)"}), HasSubstr("CLOSEDPLANAR_XOR of contour 1"));
    for (const auto& [colour, isTaken] :
         {std::pair("0\\255\\0", true), {"0\\256\\0", false}, {"0\\0\\-1", false}, {"1\\2", false}})
        EXPECT_EQ(refusalOf(write({{"1", "A", colour, {{}}}})).empty(), isTaken) << colour;
    const std::string square = R"(0\0\5\9\0\5\9\9\5\0\0\5)"; // its end is its beginning
    const StructureSet set = readStructureSet(write({{"+7",
                                                      "",
                                                      "",
                                                      {{"POINT", "4", square},
                                                       {"OPEN_PLANAR", "4", square},
                                                       {"OPEN_NONPLANAR", "4", square},
                                                       {"CLOSED_PLANAR", "4", square},
                                                       {"CLOSEDPLANAR_XOR", "+4", square},
                                                       {"CLOSED_PLANAR", "1", R"(1\2\3)"}},
                                                      "7"}}),
                                              ram_);
    ASSERT_EQ(set.structures.size(), 1u);
    EXPECT_EQ(set.structures[0].label.name, "structure 7");
    EXPECT_EQ(set.structures[0].label.colour, std::nullopt);
    std::vector<std::pair<ContourForm, std::size_t>> found;
    for (const StructureContour& contour : set.structures[0].contours)
        found.emplace_back(contour.form, contour.points.size());
    EXPECT_EQ(found, (std::vector<std::pair<ContourForm, std::size_t>>{{ContourForm::points, 4},
                                                                       {ContourForm::line, 4},
                                                                       {ContourForm::line, 4},
                                                                       {ContourForm::ring, 3},
                                                                       {ContourForm::ring, 3},
                                                                       {ContourForm::ring, 1}}));
    EXPECT_THAT(refusalOf(write({{"1", "A", "", {{}}}, {"2", "B", "", {{}}, "1"}})),
                HasSubstr("one item of contours for a structure, found several for structure 1 \"A\""));
    EXPECT_THAT(refusalOf(write({{"1", "A", "", {{}}}, {"2", "B", "", {{}, {"CLOSED_PLANAR", "2"}}}})),
                HasSubstr("of contour 3 of structure 2 \"B\""));
}

// Whatever happens to bytes, a file is read or refused by its name.
TEST_F(StructureSets, Damage) {
    const std::filesystem::path path = write(kTwoStructures);
    std::ifstream in(path, std::ios::binary);
    const std::string whole{std::istreambuf_iterator<char>(in), {}};
    const auto put = [&](const std::string& bytes) {
        std::ofstream(folder_ / "damaged.dcm", std::ios::binary) << bytes;
        return refusalOf(folder_ / "damaged.dcm");
    };
    for (std::size_t size = 0; size < whole.size(); ++size) {
        const std::string why = put(whole.substr(0, size));
        EXPECT_NE(why, "") << size << " of " << whole.size();
    }
    std::mt19937 random(1);
    int refused = 0;
    for (int n = 0; n < 3000; ++n) {
        std::string damaged = whole;
        for (int k = 0; k <= n % 3; ++k)
            damaged[132 + random() % (damaged.size() - 132)] = static_cast<char>(random());
        refused += !put(damaged).empty();
    }
    EXPECT_GT(refused, 500);
    EXPECT_EQ(ram_.usedBytes(), 0u);
}

} // namespace
} // namespace tessera
