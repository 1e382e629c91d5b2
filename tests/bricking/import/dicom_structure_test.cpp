// tests/bricking/import/dicom_structure_test.cpp: the structure of a DICOM header at its bounds: nesting,
// filling, the order of elements; and words for classes of objects.
#include "bricking/import/dicom/dicom_remarks.h"
#include "bricking/import/dicom/dicom_structure.h"
#include "tests/support/dicom_series.h"
#include "tests/support/import_test_tools.h"

#include <gmock/gmock.h>

namespace tessera::test {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

/// What a header's structure is found to lack.
class HeaderStructure : public DicomSeries {
  protected:
    std::string irregularity(const std::string& bytes) {
        writeFile(folder / "one", bytes);
        return structureOf(folder / "one").irregularity;
    }
    static std::string with(unsigned tag, const char* vr, const std::string& value) {
        DicomImage image = imageAt(0);
        image.more[tag] = {vr, value};
        return dicomBytes(image);
    }
    /// `depth` sequences in one another.
    static std::string nested(int depth) {
        std::string inner;
        for (int n = 1; n < depth; ++n) {
            DicomBytes b;
            b.element(0x11, 0x1010, "SQ", DicomBytes::item(inner));
            inner = b.bytes();
        }
        return DicomBytes::item(inner);
    }
};

TEST_F(HeaderStructure, SequencesAreNestedSixteenDeepAtMost) {
    EXPECT_EQ(irregularity(with(0x00111010, "SQ", nested(1))), "");
    EXPECT_EQ(irregularity(with(0x00111010, "SQ", nested(16))), "");
    EXPECT_THAT(irregularity(with(0x00111010, "SQ", nested(17))), HasSubstr("16 sequences"));
}

TEST_F(HeaderStructure, UidsOfAKibibyteAreLookedAt) {
    EXPECT_EQ(irregularity(with(0x00111010, "UI", std::string(1024, '1'))), "");
    EXPECT_EQ(irregularity(with(0x00111010, "UI", "1.2\\3.4 ")), "");
    EXPECT_THAT(irregularity(with(0x00111010, "UI", std::string(1023, '1') + "x")),
                HasSubstr("no UID at (0011,1010)"));
    EXPECT_EQ(irregularity(with(0x00111010, "UI", std::string(1025, '1') + "x")), "");
}

// Tapes fill files with zeros up to a block of 512 bytes, less than 64 of them.
TEST_F(HeaderStructure, ZerosBehindThePixelsFillABlock) {
    std::string bytes = dicomBytes(imageAt(0));
    const std::size_t size = bytes.size();
    ASSERT_NE(size % 512, 0u);
    const std::size_t full = (size + 511) / 512 * 512;
    bytes.resize(full);
    EXPECT_EQ(irregularity(bytes), "");
    bytes.resize(full - 2);
    EXPECT_NE(irregularity(bytes), "");
    bytes.resize(full + 63 * 512);
    EXPECT_EQ(irregularity(bytes), "");
    bytes.resize(full + 64 * 512);
    EXPECT_NE(irregularity(bytes), "");
    for (const std::size_t at : {size, full - 1}) {
        bytes.resize(full);
        bytes[at] = 1;
        EXPECT_NE(irregularity(bytes), "") << at;
        bytes[at] = 0;
    }
}

TEST_F(HeaderStructure, ElementsAscendInsideAndOutside) {
    DicomBytes inner;
    inner.element(0x11, 0x1012, "US", "ab");
    inner.element(0x11, 0x1011, "US", "ab");
    EXPECT_THAT(irregularity(with(0x00111010, "SQ", DicomBytes::item(inner.bytes()))),
                HasSubstr("out of order at (0011,1011)"));
    DicomBytes twice;
    twice.element(0x11, 0x1011, "US", "ab");
    twice.element(0x11, 0x1011, "US", "cd");
    EXPECT_THAT(irregularity(with(0x00111010, "SQ", DicomBytes::item(twice.bytes()))),
                HasSubstr("out of order"));
    // The same in two items is in order.
    DicomBytes once;
    once.element(0x11, 0x1011, "US", "ab");
    EXPECT_EQ(
        irregularity(with(0x00111010, "SQ", DicomBytes::item(once.bytes()) + DicomBytes::item(once.bytes()))),
        "");
    EXPECT_THAT(irregularity(with(0x00111010, "SQ", once.bytes())),
                HasSubstr("something other than an item in (0011,1010)"));
    const std::string item = DicomBytes::item(once.bytes());
    EXPECT_THAT(irregularity(with(0x00111010, "SQ", item.substr(0, item.size() - 2))), Not(IsEmpty()));
}

/// Classes of DICOM PS3.4, table B.5-1.
TEST(DicomWords, ClassesBeginWithWholeParts) {
    const std::string root = "1.2.840.10008.5.1.4.1.1.";
    for (const auto& [number, words] :
         std::vector<std::pair<std::string, std::string>>{{"88.67", "dose report"},
                                                          {"88.670", "structured report"},
                                                          {"88.6", "structured report"},
                                                          {"88", "structured report"},
                                                          {"880", ""},
                                                          {"481.5", "radiotherapy object"},
                                                          {"66.4", "segmentation"},
                                                          {"66.4.1", "segmentation"},
                                                          {"2", ""},
                                                          {"2.3", ""},
                                                          {"1.1.1", "digital radiograph"},
                                                          {"7.2", "secondary capture"}})
        EXPECT_EQ(objectWords(root + number), words) << number;
    EXPECT_EQ(objectWords("1.2.840.10008.1.3.10"), "DICOMDIR");
    EXPECT_TRUE(isSliceClass(root + "2.1"));
    EXPECT_FALSE(isSliceClass(root + "2.10"));
    EXPECT_FALSE(isSliceClass(root + "2.3"));
    EXPECT_EQ(derivationOf("DERIVED\\SECONDARY\\MPR"), "MPR");
    EXPECT_EQ(derivationOf("derived\\ minip \\x"), "MINIP");
    EXPECT_EQ(derivationOf("DERIVED\\MPRAGE"), "");
}

} // namespace
} // namespace tessera::test
