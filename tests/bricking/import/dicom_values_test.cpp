// tests/bricking/import/dicom_values_test.cpp: values and positions from DICOM headers, with numbers that
// expose faults. These are both ends of ranges, both signs, stored bits that do not begin at 0, and the worst
// slice of several.
#include "bricking/import/dicom/dicom_structure.h"
#include "tests/support/dicom_writer.h"
#include "tests/support/import_test_tools.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <gmock/gmock.h>
#include <map>

namespace tessera::test {
namespace {

using ::testing::HasSubstr;

class DicomValues : public ::testing::Test {
  protected:
    /// Slice n, at z = n, of zeros without a rescale.
    static DicomImage imageAt(double z) {
        DicomImage image;
        image.position = glm::dvec3(-1, 2, z);
        image.pixels.assign(12, 0);
        image.slope = "1", image.intercept = "0";
        return image;
    }
    /// Without HU.
    static DicomImage mrAt(double z) {
        DicomImage image = imageAt(z);
        image.modality = "MR";
        image.storageClass = "1.2.840.10008.5.1.4.1.1.4";
        return image;
    }
    void write(const DicomImage& image) { writeDicom(folder / std::to_string(written_++), image); }
    std::unique_ptr<SlabSource> open(const SourceOptions& options = {}) {
        return openSource(folder.path(), options);
    }
    ScratchFolder folder;

  private:
    int written_ = 0;
};

/// PS3.5, table 6.2-1: a length is a multiple of the size of one value.
TEST_F(DicomValues, LengthsAreOfWholeValues) {
    const auto irregularityOf = [&](const std::string& kind, std::size_t length) {
        const auto number = [](std::size_t n, int bytes) {
            std::string text;
            for (int i = 0; i < bytes; ++i)
                text += static_cast<char>(n >> (8 * i) & 255);
            return text;
        };
        const bool isLong = kind.starts_with("O") || kind == "SV" || kind == "UV" || kind == "UN" ||
                            kind == "UT" || kind == "UC" || kind == "UR";
        const std::string syntax = std::string("1.2.840.10008.1.2.1") + '\0';
        const std::string meta = number(2, 2) + number(0x10, 2) + "UI" + number(syntax.size(), 2) + syntax;
        const std::string value = kind == "UI" ? std::string("1.2") + '\0' : std::string(length, ' ');
        writeFile(folder / "one", std::string(128, '\0') + "DICM" + number(2, 2) + number(0, 2) + "UL" +
                                      number(4, 2) + number(meta.size(), 4) + meta + number(0x11, 2) +
                                      number(0x1010, 2) + kind + (isLong ? number(0, 2) : "") +
                                      number(value.size(), isLong ? 4 : 2) + value);
        return structureOf(folder / "one").irregularity;
    };
    const std::map<std::size_t, std::vector<std::string>> kinds = {
        {1,
         {"AE", "AS", "CS", "DA", "DS", "DT", "IS", "LO", "LT", "OB", "PN", "SH", "ST", "TM", "UC", "UI",
          "UN", "UR", "UT"}},
        {2, {"OW", "SS", "US"}},
        {4, {"AT", "FL", "OF", "OL", "SL", "UL"}},
        {8, {"FD", "OD", "OV", "SV", "UV"}}};
    for (const auto& [bytes, ofSize] : kinds)
        for (const std::string& kind : ofSize)
            for (std::size_t length = 2; length <= 24; length += 2)
                EXPECT_EQ(irregularityOf(kind, length).find("a length that does not suit " + kind) ==
                              std::string::npos,
                          length % bytes == 0)
                    << kind << ", " << length;
    EXPECT_EQ(irregularityOf("FD", 24), "");
    EXPECT_EQ(irregularityOf("OD", 8), "");
}

TEST_F(DicomValues, ARangeOfPaddingIsAirFromEndToEnd) {
    const std::vector<int> stored = {-2001, -2000, -1995, -1990, -1989, 40};
    for (int n = 0; n < 2; ++n) { // the range may be written from either end
        DicomImage image = imageAt(n);
        image.padding = n == 0 ? -2000 : -1990;
        image.paddingLimit = n == 0 ? -1990 : -2000;
        for (std::size_t i = 0; i < stored.size(); ++i)
            image.pixels[i] = static_cast<std::uint16_t>(stored[i]);
        write(image);
    }
    const auto values = readAll<std::int16_t>(*open());
    for (const std::size_t slice : {0u, 12u})
        EXPECT_EQ(std::vector<int>(values.begin() + static_cast<int>(slice),
                                   values.begin() + static_cast<int>(slice) + 6),
                  (std::vector<int>{-2001, -1024, -1024, -1024, -1989, 40}))
            << slice;
}

TEST_F(DicomValues, PaddingAboveAirIsKept) {
    for (int n = 0; n < 2; ++n) {
        DicomImage image = imageAt(n);
        image.padding = 0; // as some scanners write, and as water is
        write(image);
    }
    EXPECT_EQ(readAll<std::int16_t>(*open()), std::vector<std::int16_t>(24, 0));
}

TEST_F(DicomValues, WithoutHuTheFillIsThePhysicalPadding) {
    for (int n = 0; n < 2; ++n) {
        DicomImage image = mrAt(n);
        image.padding = -100;
        image.slope = "2", image.intercept = "10";
        write(image);
    }
    EXPECT_EQ(open()->info().unit, "") << "an intercept makes no HU of an MR";
    EXPECT_EQ(open()->info().fillStored, -190);
}

TEST_F(DicomValues, TheTypeHoldsTheLastValueThatTheHeadersAllow) {
    for (int n = 0; n < 2; ++n) {
        DicomImage image = mrAt(n);
        image.pixelRepresentation = 0;
        image.pixels[0] = 65535;
        write(image);
    }
    ASSERT_EQ(open()->info().type, ValueType::u16);
    EXPECT_EQ(readAll<std::uint16_t>(*open())[12], 65535);
    for (int n = 0; n < 2; ++n) { // half as many: all are values of int16
        DicomImage image = mrAt(n);
        image.pixelRepresentation = 0;
        image.bitsStored = 15;
        image.pixels[0] = 32767;
        writeDicom(folder / std::to_string(n), image);
    }
    ASSERT_EQ(open()->info().type, ValueType::i16);
    EXPECT_EQ(readAll<std::int16_t>(*open())[12], 32767);
}

TEST_F(DicomValues, StoredBitsMayBeginAboveTheLowest) {
    for (int n = 0; n < 2; ++n) {
        DicomImage image = imageAt(n);
        image.bitsStored = 12;
        image.highBit = 15;
        image.pixelRepresentation = n; // the sign is the word's highest bit too
        image.pixels.assign(12, 0xfff0);
        write(image);
    }
    const auto values = readAll<std::int16_t>(*open());
    EXPECT_EQ(values[0], 4095);
    EXPECT_EQ(values[12], -1);
}

TEST_F(DicomValues, ASingleSliceIsAsThickAsTheDistanceToTheNext) {
    for (const char* between : {"3", "-3"}) { // as some scanners write it
        DicomImage image = imageAt(0);
        image.betweenSlices = between;
        writeDicom(folder / "one", image);
        EXPECT_EQ(openSource(folder / "one", {})->info().spacingMm().z, 3) << between;
    }
}

TEST_F(DicomValues, ColumnsThatTurnAreAnotherOrientation) {
    for (int n = 0; n < 3; ++n) {
        DicomImage image = imageAt(n);
        if (n == 1)
            image.columnDirection = {0, std::cos(0.01), std::sin(0.01)};
        write(image);
    }
    EXPECT_THAT(refusalOfOpening(folder.path()), HasSubstr("slices of one orientation"));
}

TEST_F(DicomValues, ATiltedStackWithUnevenGapsIsStraight) {
    const glm::dvec3 along = glm::normalize(glm::dvec3(0, 0.3, 1));
    for (const double at : {0.0, 2.0, 4.0, 5.0, 7.0}) {
        DicomImage image = imageAt(0);
        image.position = at * along;
        write(image);
    }
    const VolumeInfo info = open({.resampleZ = true})->info();
    EXPECT_EQ(info.extentVoxels.z, 8);
    EXPECT_LT(glm::length(glm::dvec3(info.patientFromVoxel[2]) - along), 1e-6);
}

TEST_F(DicomValues, TheWorstLossOfASeriesIsTold) {
    for (int n = 0; n < 3; ++n) {
        DicomImage image = imageAt(n);
        image.lossy = "01";
        image.lossyRatio = n == 1 ? "12" : "7";
        write(image);
    }
    EXPECT_EQ(open()->info().lossyRatio, 12);
}

} // namespace
} // namespace tessera::test
