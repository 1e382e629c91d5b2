// tests/bricking/import/dicom_bounds_test.cpp: the bounds by which DICOM headers are judged: just within
// each, a series is one volume; just beyond, it is refused by a message that tells both values.
#include "tests/support/dicom_writer.h"
#include "tests/support/import_test_tools.h"

#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <gmock/gmock.h>

namespace tessera::test {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

constexpr int kFiveSlices = 5;

/// A series of five slices of 4 x 3 pixels, 2 mm apart, of HU.
class DicomBounds : public ::testing::Test {
  protected:
    using Change = std::function<void(DicomImage&, int)>;

    static DicomImage imageAt(int n) {
        DicomImage image;
        image.position = glm::dvec3(-1, 2, 2 * n);
        image.pixels.assign(12, static_cast<std::uint16_t>(1024 + 100 * n));
        image.instance = n + 1;
        return image;
    }
    static std::string nameOf(int n) { return "IM" + std::to_string(41 + n) + ".dcm"; }
    void write(const Change& change, int slices = kFiveSlices) {
        for (const auto& entry : fs::directory_iterator(folder.path()))
            fs::remove_all(entry.path());
        for (int n = 0; n < slices; ++n) {
            DicomImage image = imageAt(n);
            change(image, n);
            writeDicom(folder / nameOf(n), image);
        }
    }
    /// "" where the series is opened, else why not.
    std::string outcome(const SourceOptions& options = {}) {
        try {
            openSource(folder.path(), options);
            return "";
        } catch (const InputError& error) {
            return error.what();
        }
    }
    std::string outcomeOf(const Change& change, int slices = kFiveSlices) {
        write(change, slices);
        return outcome();
    }
    /// Of the third slice alone.
    std::string outcomeOfOne(const std::function<void(DicomImage&)>& change) {
        return outcomeOf([&](DicomImage& image, int n) {
            if (n == 2)
                change(image);
        });
    }
    ScratchFolder folder;
};

// A thousandth of a unit vector is 0.5 mm at the edge of a field of 500 mm.
TEST_F(DicomBounds, DirectionsDifferByAThousandthAtMost) {
    const auto turned = [&](const glm::dvec3& axis, double angle) {
        return outcomeOf(
            [&](DicomImage& image, int n) { // of numbers that are not round: rounding explains none
                const auto turn = [&](const glm::dvec3& v) {
                    return n == 2 ? v * std::cos(angle) + glm::cross(axis, v) * std::sin(angle) : v;
                };
                image.rowDirection = turn({std::cos(0.3), std::sin(0.3), 0});
                image.columnDirection = turn({-std::sin(0.3), std::cos(0.3), 0});
            });
    };
    for (const double sign : {1.0, -1.0})
        for (const glm::dvec3& axis : {glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0), glm::dvec3(0, 0, 1)}) {
            EXPECT_EQ(turned(axis, 0.0009123 * sign), "");
            EXPECT_THAT(turned(axis, 0.0014123 * sign),
                        HasSubstr("expected slices of one orientation, found another in IM4"));
        }
}

TEST_F(DicomBounds, PixelSpacingsDifferByAThousandthAtMost) {
    const auto spacing = [&](double x, double y) {
        return outcomeOf([&](DicomImage& image, int n) {
            image.spacingX = n == 2 ? x : 0.512345, image.spacingY = n == 2 ? y : 0.712345;
        });
    };
    for (const double sign : {1.0, -1.0}) {
        EXPECT_EQ(spacing(0.512345 + sign * 0.000461, 0.712345), "");
        EXPECT_EQ(spacing(0.512345, 0.712345 + sign * 0.000461), "");
        for (const auto& [x, y] : {std::pair(0.000713, 0.0), {0.0, 0.000713}})
            EXPECT_THAT(spacing(0.512345 + sign * x, 0.712345 + sign * y),
                        EndsWith("expected slices of one pixel spacing, found another in IM43.dcm"));
    }
}

// What is rounded to units of its last decimal differs by half of one: by 0.005 at most for directions, by a
// hundredth of a spacing for spacings.
TEST_F(DicomBounds, RoundingExplainsDifferencesOfHalfItsUnit) {
    const auto turned = [&](double angle) {
        return outcomeOf([&](DicomImage& image, int n) {
            if (n != 2)
                image.rowDirection = {std::cos(angle), std::sin(angle), 0},
                image.columnDirection = {-std::sin(angle), std::cos(angle), 0};
        });
    };
    EXPECT_EQ(turned(0.0047123), "") << "1\\0\\0\\0\\1\\0 beside seven decimals";
    EXPECT_THAT(turned(0.0071234), HasSubstr("one orientation"));
    const auto spacing = [&](const char* fine, const char* rounded) {
        return outcomeOf([&](DicomImage& image, int n) { image.spacingText = n == 2 ? rounded : fine; });
    };
    EXPECT_EQ(spacing("0.7\\0.201901", "0.7\\0.2"), "");
    EXPECT_THAT(spacing("0.7\\0.203001", "0.7\\0.2"), HasSubstr("one pixel spacing"));
    EXPECT_EQ(spacing("2\\2.004701", "2\\2"), "");
    EXPECT_THAT(spacing("2\\2.007001", "2\\2"), HasSubstr("one pixel spacing"));
}

TEST_F(DicomBounds, SlicesLieSidewaysByATwentiethOfAPixelAtMost) {
    const auto shifted = [&](double x, double y) {
        return outcomeOfOne([&](DicomImage& image) { *image.position += glm::dvec3(x, y, 0); });
    };
    for (const double sign : {1.0, -1.0}) { // pixels of 0.5 x 0.7 mm
        EXPECT_EQ(shifted(sign * 0.02, 0), "");
        EXPECT_EQ(shifted(0, sign * 0.02), "");
        EXPECT_THAT(shifted(sign * 0.03, 0), EndsWith("slice 3 shifted sideways by 0.03 mm"));
        EXPECT_THAT(shifted(0, sign * 0.03), EndsWith("slice 3 shifted sideways by 0.03 mm"));
    }
    // A stack that leans by a quarter of its last decimal per slice: of small pixels that is no rounding.
    const auto leaning = [&](double pixelMm) {
        return outcomeOf([&](DicomImage& image, int n) {
            image.spacingX = pixelMm;
            image.position->x = n < 2 ? -1 : -0.9;
        });
    };
    EXPECT_EQ(leaning(0.5), "");
    EXPECT_THAT(leaning(0.2), HasSubstr("sideways"));
}

// The largest deviation from even gaps is a hundredth of the median.
TEST_F(DicomBounds, GapsDifferByAHundredthAtMost) {
    const auto shifted = [&](double z) {
        return outcomeOfOne([&](DicomImage& image) { image.position->z += z; });
    };
    EXPECT_EQ(shifted(0.01912), "");
    EXPECT_EQ(shifted(-0.01912), "");
    for (const double z : {0.02812, -0.02812})
        EXPECT_THAT(shifted(z),
                    HasSubstr("expected evenly spaced slices (within 1 % of the median gap, 2 mm), "
                              "found 2 of 4 gaps that are not: "));
}

/// What follows "that are not: " of stacks with these gaps.
TEST_F(DicomBounds, RunsOfGapsAreListed) {
    const auto listed = [&](const std::vector<double>& gaps) {
        const std::string text = outcomeOf(
            [&](DicomImage& image, int n) {
                image.position->z = 0;
                for (int i = 0; i < n; ++i)
                    image.position->z += gaps[static_cast<std::size_t>(i)];
            },
            static_cast<int>(gaps.size()) + 1);
        const std::string before = "gaps that are not: ", after = "; --resample-z";
        const std::size_t begin = text.find(before), end = text.find(after);
        return begin == std::string::npos || end == std::string::npos
                   ? text
                   : text.substr(begin + before.size(), end - begin - before.size());
    };
    EXPECT_EQ(listed({2, 2, 2, 6, 6, 2}),
              "1-4: 2 mm, 4-6: 6 mm (missing slices: about 2 in each gap), 6-7: 2 mm");
    EXPECT_EQ(listed({2, 2, 3, 2}), "1-3: 2 mm, 3-4: 3 mm, 4-5: 2 mm");
    EXPECT_EQ(listed({2, 2, 3.2, 2}), "1-3: 2 mm, 3-4: 3.2 mm (missing slices: about 1), 4-5: 2 mm");
    EXPECT_EQ(listed({2, 2.03, 2.04, 2, 2, 2}), "1-2: 2 mm, 2-4: 2.03 mm, 4-7: 2 mm");
    std::vector<double> many;
    for (int i = 0; i < 7; ++i)
        many.insert(many.end(), {2, 2.5});
    EXPECT_THAT(listed(many), EndsWith("12-13: 2.5 mm, ...")) << "twelve runs";
    many.resize(12);
    EXPECT_THAT(listed(many), EndsWith("12-13: 2.5 mm"));
}

TEST_F(DicomBounds, MessagesTellBothValues) {
    EXPECT_THAT(outcomeOfOne([](DicomImage& i) { i.columns = 6, i.rows = 2; }),
                EndsWith("expected slices of one size, found 4 x 3 and 6 x 2 in IM43.dcm"));
    EXPECT_THAT(
        outcomeOfOne([](DicomImage& i) { i.spacingText = "0.25\\0"; }),
        EndsWith(
            "expected PixelSpacing (0028,0030), the pixel spacing, above 0, found 0 x 0.25 mm in IM43.dcm"));
    EXPECT_THAT(outcomeOfOne([](DicomImage& i) { i.spacingText = "-0.5\\0.25"; }),
                EndsWith("found 0.25 x -0.5 mm in IM43.dcm"));
    EXPECT_THAT(outcomeOfOne([](DicomImage& i) { i.positionText = "0\\-2e7\\4"; }),
                EndsWith("found -2e+07 mm in IM43.dcm"));
    EXPECT_THAT(outcomeOfOne([](DicomImage& i) { i.positionText = "0\\0\\1.1e7"; }),
                EndsWith("found 1.1e+07 mm in IM43.dcm"));
    for (const auto& [tag, name] : std::vector<std::pair<unsigned, std::string>>{
             {0x00200037u, "ImageOrientationPatient (0020,0037)"}, {0x00280030u, "PixelSpacing (0028,0030)"}})
        EXPECT_THAT(
            outcomeOfOne([t = tag](DicomImage& i) { i.without = {t}; }),
            EndsWith(
                "expected position, orientation and pixel spacing in every slice, found IM43.dcm without " +
                name));
    EXPECT_THAT(
        outcomeOf([](DicomImage& image, int n) { image.position->z = 2 * std::min(n, 3); }),
        EndsWith(
            "1 of 5 slices at the position of another (duplicates, or several time points in one series), "
            "the first IM44.dcm and IM45.dcm"));
}

// Positions a micrometre apart are two places.
TEST_F(DicomBounds, OnePlaceIsAThousandthOfAMillimetre) {
    const auto apart = [&](double mm) {
        return outcomeOf([&](DicomImage& image, int n) {
            image.position = glm::dvec3(0, 0, mm * n);
            image.spacingX = image.spacingY = 0.001;
        });
    };
    EXPECT_EQ(apart(0.0011), "");
    EXPECT_THAT(apart(0.0009), HasSubstr("4 of 5 slices at the position of another"));
}

TEST_F(DicomBounds, OneOfTenSlicesOfAnotherNumberFormatIsDamage) {
    const auto odd = [&](int count, int slices) {
        return outcomeOf(
            [&](DicomImage& image, int n) {
                image.bitsStored = n < count ? 12 : 13;
                image.pixelRepresentation = n < count;
            },
            slices);
    };
    EXPECT_THAT(odd(1, 3),
                EndsWith("IM41.dcm: expected pixels of unsigned 13 of 16 bits, the highest 12, as the "
                         "other slices have, found signed 12 of 16 bits, the highest 11"));
    EXPECT_NE(odd(2, 20), "");
    EXPECT_NE(odd(1, 20), "");
    EXPECT_NE(odd(1, 9), "");
    EXPECT_EQ(odd(3, 20), "");
    EXPECT_EQ(odd(2, 19), "");
    EXPECT_EQ(odd(1, 2), "") << "two slices have no others";
}

// Half of the slices are a habit no more.
TEST_F(DicomBounds, MostSlicesTellWhetherAHeaderIsIrregular) {
    const auto irregular = [&](int count) {
        return outcomeOf(
            [&](DicomImage& image, int n) {
                if (n < count)
                    image.without = {0x00280102};
            },
            4);
    };
    for (const int count : {1, 2})
        EXPECT_THAT(irregular(count),
                    EndsWith("IM41.dcm: expected a header without fault, as most slices of its series "
                             "have, found no HighBit"));
    EXPECT_EQ(irregular(3), "");
    EXPECT_THAT(openSource(folder.path(), {})->notes(),
                ElementsAre("irregular headers, in most slices alike (no HighBit): read all the same"));
}

// Bits that are stored lie within those that are allocated; a shorter row more is padding, a whole one is
// lost.
TEST_F(DicomBounds, PixelsAsTheirHeaderDescribesThem) {
    const auto bits = [&](int allocated, int stored, int high) {
        return outcomeOf([&](DicomImage& image, int) {
            image.bitsAllocated = allocated, image.bitsStored = stored, image.highBit = high;
            image.pixelRepresentation = 0;
        });
    };
    EXPECT_EQ(bits(16, 12, 11), "");
    EXPECT_EQ(bits(16, 12, 15), "");
    EXPECT_EQ(bits(16, 16, 15), "");
    EXPECT_EQ(bits(16, 1, 0), "");
    for (const auto& [allocated, stored, high] :
         {std::tuple{16, 12, 10}, {16, 12, 16}, {16, 0, 0}, {12, 12, 11}, {32, 12, 11}})
        EXPECT_THAT(
            bits(allocated, stored, high),
            EndsWith(
                "expected rows and columns of 8 or 16 bits allocated, the stored bits within, found 3 x 4, " +
                std::to_string(allocated) + " allocated, " + std::to_string(stored) + " stored"));
    const auto words = [&](std::size_t count) {
        return outcomeOf([&](DicomImage& image, int) { image.pixels.resize(count, 1024); });
    };
    EXPECT_EQ(words(12), "");
    EXPECT_EQ(words(15), "");
    EXPECT_THAT(words(16),
                EndsWith("expected 24 bytes of pixels, as Rows (0028,0010), Columns (0028,0011) and "
                         "NumberOfFrames (0028,0008) say, found 32"));
    EXPECT_THAT(words(11), HasSubstr("22 bytes (is the file truncated?)"));
}

// Of the series, the acquisition or the study, the first that is a date.
TEST_F(DicomBounds, DatesAreEightDigits) {
    const auto date = [&](const std::string& series, const std::string& acquisition) {
        write([&](DicomImage& image, int) {
            image.seriesDate = series;
            if (!acquisition.empty())
                image.more[0x00080022] = {"DA", acquisition};
        });
        std::vector<fs::path> files;
        for (int n = 0; n < kFiveSlices; ++n)
            files.push_back(folder / nameOf(n));
        return scanDicom(files).series.at(0).date;
    };
    EXPECT_EQ(date("20240518", "20240619"), "2024-05-18");
    EXPECT_EQ(date("2024051", "20240619"), "2024-06-19");
    EXPECT_EQ(date("2024.5.18", "20240619"), "2024-06-19");
    EXPECT_EQ(date("2024051x", "2024"), "2023-05-17");
}

/// The smallest type that holds what bits, sign, slope and intercept allow.
TEST_F(DicomBounds, TypesHoldEveryValueThatHeadersAllow) {
    const auto type = [&](int bits, bool isSigned, const char* slope, const char* intercept) {
        write(
            [&](DicomImage& image, int) {
                image.modality = "MR";
                image.bitsStored = bits, image.pixelRepresentation = isSigned;
                image.slope = slope, image.intercept = intercept;
                image.pixels.assign(12, 1);
            },
            2);
        return openSource(folder.path(), {})->info().type;
    };
    EXPECT_EQ(type(16, true, "1", "0"), ValueType::i16);
    EXPECT_EQ(type(16, true, "1", "1"), ValueType::f32);  // 32768
    EXPECT_EQ(type(16, true, "1", "-1"), ValueType::f32); // -32769
    EXPECT_EQ(type(16, true, "-1", "-1"), ValueType::i16);
    EXPECT_EQ(type(16, true, "-1", "0"), ValueType::f32);
    EXPECT_EQ(type(15, true, "2", "0"), ValueType::i16);
    EXPECT_EQ(type(16, false, "1", "0"), ValueType::u16);
    EXPECT_EQ(type(16, false, "1", "1"), ValueType::f32);
    EXPECT_EQ(type(16, false, "1", "-1"), ValueType::f32);
    EXPECT_EQ(type(16, false, "-1", "65535"), ValueType::u16);
    EXPECT_EQ(type(16, false, "1", "-32768"), ValueType::i16);
    EXPECT_EQ(type(15, false, "1", "0"), ValueType::i16);
    EXPECT_EQ(type(15, false, "1", "1"), ValueType::u16);
    EXPECT_EQ(type(12, false, "0.5", "0"), ValueType::f32);
    EXPECT_EQ(type(12, false, "1", "0.5"), ValueType::f32);
}

/// What lies outside is the padding, where the type has it.
TEST_F(DicomBounds, TheFillIsThePaddingWhereTheTypeHoldsIt) {
    const auto fill = [&](int bits, bool isSigned, int padding, const char* slope, const char* intercept) {
        write([&](DicomImage& image, int) {
            image.modality = "MR";
            image.bitsStored = bits, image.pixelRepresentation = isSigned;
            image.slope = slope, image.intercept = intercept;
            image.padding = padding;
            image.pixels.assign(12, 1);
        });
        return openSource(folder.path(), {})->info().fillStored;
    };
    EXPECT_EQ(fill(16, true, 32767, "1", "0"), 32767);
    EXPECT_EQ(fill(16, true, -32767, "1", "0"), -32767);
    EXPECT_EQ(fill(16, false, 65535, "1", "0"), 65535);
    EXPECT_EQ(fill(16, false, 0, "1", "0"), 0);
    EXPECT_EQ(fill(12, false, 4095, "1", "-4000"), 95);
    EXPECT_EQ(fill(12, false, 40000, "1", "0"), 0) << "int16 has no 40000";
    EXPECT_EQ(fill(12, true, -3, "0.5", "0.25"), -1.25);
}

TEST_F(DicomBounds, TiltsAreToldFromATwentiethOfADegree) {
    const auto described = [&](double degrees) {
        write([&](DicomImage& image, int) {
            const double angle = degrees * std::acos(-1.0) / 180;
            image.columnDirection = {0, std::cos(angle), -std::sin(angle)};
        });
        return openSource(folder.path(), {})->describe();
    };
    EXPECT_EQ(described(0.04), "5 DICOM slices, series 1, CT");
    EXPECT_EQ(described(0.08), "5 DICOM slices, series 1, CT, gantry tilt 0.080 degrees");
    EXPECT_EQ(described(-0.08), "5 DICOM slices, series 1, CT, gantry tilt -0.080 degrees");
}

TEST_F(DicomBounds, SpaceBetweenSlicesIsToldBeyondOneAndAHalfThicknesses) {
    const auto remarks = [&](double gap, const char* thickness) {
        write([&](DicomImage& image, int n) {
            image.position->z = gap * n;
            image.thickness = thickness;
        });
        return openSource(folder.path(), {})->notes();
    };
    EXPECT_THAT(remarks(7.5, "5"), IsEmpty());
    EXPECT_THAT(remarks(7.75, "5"),
                ElementsAre("slices are 5 mm thick and lie 7.75 mm apart: the space between them is "
                            "not in the scan"));
}

TEST_F(DicomBounds, ThreeValuesAreListedAndMoreAreCounted) {
    const auto remarks = [&](int values) {
        write([&](DicomImage& image, int n) {
            image.voltage = std::to_string(80 + 20 * std::min(n, values - 1));
        });
        return openSource(folder.path(), {})->notes();
    };
    const std::string meaning = ": values of contrast and bone change along the stack";
    EXPECT_THAT(remarks(2), ElementsAre("the tube voltage (kV) is 100 in 4 slices, 80 in 1 slice" + meaning));
    EXPECT_THAT(
        remarks(3),
        ElementsAre("the tube voltage (kV) is 120 in 3 slices, 80 in 1 slice, 100 in 1 slice" + meaning));
    EXPECT_THAT(remarks(4), ElementsAre("the tube voltage (kV) has 4 values, 80 to 140" + meaning));
}

TEST_F(DicomBounds, KernelsAreWordsOfSixteenCharacters) {
    const auto kernel = [&](const char* text) {
        write([&](DicomImage& image, int) { image.kernel = text; });
        return openSource(folder.path(), {})->info().acquisition.kernel;
    };
    EXPECT_EQ(kernel("ABCDEFGHIJKLMNOP"), "ABCDEFGHIJKLMNOP");
    EXPECT_EQ(kernel("ABCDEFGHIJKLMNOPQR"), "");
    EXPECT_EQ(kernel("azAZ09+-_./ bb"), "azAZ09+-_./ bb");
    for (const char* other : {"A@", "A[", "a`", "a{", "1:", "B(", "B,"}) // beside letters, digits and signs
        EXPECT_EQ(kernel(other), "") << other;
}

/// 50 MBq of F-18 given at 09:23:45.5 to 80 kg; the series begins at 10:11:00.
void makeTimedPet(DicomImage& image) {
    image.modality = "PT";
    image.storageClass = "1.2.840.10008.5.1.4.1.1.128";
    image.intercept = "0";
    image.acquisitionTime = "101100";
    image.more = {{0x00080031, {"TM", "101100"}},
                  {0x00101030, {"DS", "80"}},
                  {0x00280051, {"CS", "DECY\\ATTN"}},
                  {0x00541001, {"CS", "BQML"}},
                  {0x00541102, {"CS", "START"}}};
}
struct WrittenTracer {
    std::string dose = "50000000", halfLife = "6586.2", time = "092345.5", dateTime = {};
    std::string bytes() const {
        DicomBytes b;
        b.element(0x18, 0x1072, "TM", time);
        b.element(0x18, 0x1074, "DS", dose);
        b.element(0x18, 0x1075, "DS", halfLife);
        if (!dateTime.empty())
            b.element(0x18, 0x1078, "DT", dateTime);
        return DicomBytes::item(b.bytes());
    }
};

TEST_F(DicomBounds, SuvTakesPlausibleDosesWeightsAndTimes) {
    const auto suv = [&](const std::string& tracers, const std::string& weight = "80",
                         const std::string& seriesTime = "101100") {
        write(
            [&](DicomImage& image, int) {
                makeTimedPet(image);
                image.more[0x00540016] = {"SQ", tracers};
                image.more[0x00101030].second = weight;
                image.more[0x00080031].second = seriesTime;
            },
            2);
        return openSource(folder.path(), {})->info().suvPerValue;
    };
    const auto factor = [](double kg, double becquerel, double seconds, double halfLife) {
        return 1000 * kg / becquerel * std::exp2(seconds / halfLife);
    };
    const double passed = 47 * 60 + 14.5; // from 09:23:45.5 to 10:11:00
    EXPECT_NEAR(suv(WrittenTracer().bytes()) / factor(80, 5e7, passed, 6586.2), 1, 1e-9);
    EXPECT_NEAR(suv(WrittenTracer{.time = "092345"}.bytes()) / factor(80, 5e7, passed + 0.5, 6586.2), 1,
                1e-9);
    EXPECT_NEAR(suv(WrittenTracer{.dateTime = "20230517093000.25"}.bytes()) /
                    factor(80, 5e7, 41 * 60 - 0.25, 6586.2),
                1, 1e-9)
        << "date and time before the time alone";
    EXPECT_NEAR(suv(WrittenTracer{.time = "101100"}.bytes()) / factor(80, 5e7, 0, 6586.2), 1, 1e-9)
        << "given when it begins";
    EXPECT_EQ(suv(WrittenTracer{.time = "101101"}.bytes()), 0);
    EXPECT_EQ(suv(WrittenTracer().bytes(), "80", "101101"), 0) << "a series that was made later";
    EXPECT_EQ(suv(WrittenTracer().bytes() + WrittenTracer().bytes()), 0) << "two tracers";
    for (const char* kg : {"0.01", "650"})
        EXPECT_NEAR(suv(WrittenTracer().bytes(), kg) / factor(std::stod(kg), 5e7, passed, 6586.2), 1, 1e-9);
    for (const char* kg : {"0.009", "651"})
        EXPECT_EQ(suv(WrittenTracer().bytes(), kg), 0) << kg;
    for (const char* dose : {"1e6", "1e11"})
        EXPECT_NEAR(suv(WrittenTracer{.dose = dose}.bytes()) / factor(80, std::stod(dose), passed, 6586.2), 1,
                    1e-9);
    for (const char* dose : {"0.9e6", "1.1e11"})
        EXPECT_EQ(suv(WrittenTracer{.dose = dose}.bytes()), 0) << dose;
    for (const char* life : {"60", "1e7"})
        EXPECT_NEAR(suv(WrittenTracer{.halfLife = life}.bytes()) / factor(80, 5e7, passed, std::stod(life)),
                    1, 1e-9);
    for (const char* life : {"59", "1.1e7"})
        EXPECT_EQ(suv(WrittenTracer{.halfLife = life}.bytes()), 0) << life;
    for (const char* time : {"240000", "-1", "x"})
        EXPECT_EQ(suv(WrittenTracer{.time = time}.bytes()), 0) << time;
}

} // namespace
} // namespace tessera::test
