// tests/bricking/import/geometry_test.cpp: headers that lie about geometry or values are refused with the
// field that lies, in every format; and what the gantry's tilt is called.
#include "bricking/import/source/plausible.h"
#include "core/base/error.h"
#include "core/base/volume.h"
#include "tests/support/dicom_writer.h"
#include "tests/support/import_test_tools.h"

#include <cmath>
#include <gmock/gmock.h>

namespace tessera::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

const double kDegree = std::acos(-1.0) / 180;

/// Four slices of 4 x 3 whose images `change` alters, all or (if given) one of them.
std::string refusedDicom(const std::function<void(DicomImage&, int)>& change) {
    const ScratchFolder folder;
    for (int n = 0; n < 4; ++n) {
        DicomImage image;
        image.position = glm::dvec3(0, 0, 2 * n);
        image.pixels.assign(12, static_cast<std::uint16_t>(1024 + n));
        change(image, n);
        writeDicom(folder / ("s" + std::to_string(n) + ".dcm"), image);
    }
    const std::string message = refusalOfOpening(folder.path(), {.resampleZ = true});
    for (const std::string& planted : kPlanted)
        EXPECT_THAT(message, Not(HasSubstr(planted)));
    return message;
}

TEST(ImportGeometry, SkewedStacksAreRefusedAndTiltedOnesAreNot) {
    const auto leaning = [](double degrees) {
        return [degrees](DicomImage& image, int n) {
            const double c = std::cos(degrees * kDegree), s = std::sin(degrees * kDegree);
            image.columnDirection = {0, c, -s};
            image.position = glm::dvec3(0, 0, 2 * n);
        };
    };
    for (const double degrees : {60.0, -60.0, 80.0})
        EXPECT_THAT(refusedDicom(leaning(degrees)), AllOf(HasSubstr("(0020,0037)"), HasSubstr("skew of")))
            << degrees;
    EXPECT_THAT(refusedDicom(leaning(60)), HasSubstr("60 degrees"));
    const ScratchFolder folder;
    for (int n = 0; n < 4; ++n) {
        DicomImage image;
        image.pixels.assign(12, 1024);
        leaning(30)(image, n);
        writeDicom(folder / std::to_string(n), image);
    }
    EXPECT_NEAR(gantryTiltDegrees(openSource(folder.path(), {})->info()), 30, 1e-4);
}

TEST(ImportGeometry, RowsThatAreNotAcrossColumnsAreRefused) {
    const auto column = [](const glm::dvec3& direction) {
        return refusedDicom([&](DicomImage& image, int) { image.columnDirection = direction; });
    };
    const double r = std::sqrt(0.5);
    EXPECT_THAT(column({r, r, 0}), AllOf(HasSubstr("(0020,0037)"), HasSubstr("45 degrees")));
    EXPECT_THAT(column({std::sin(2 * kDegree), std::cos(2 * kDegree), 0}), HasSubstr("(0020,0037)"));
    EXPECT_THAT(column({1, 0, 0}), HasSubstr("(0020,0037)"));
    EXPECT_THAT(column({0, 0, 0}), AllOf(HasSubstr("(0020,0037)"), HasSubstr("length 0")));
}

TEST(ImportGeometry, NumbersThatAreNoneAreRefusedWithTheirTag) {
    using Field = std::optional<std::string> DicomImage::*;
    const std::pair<Field, const char*> fields[] = {{&DicomImage::slope, "RescaleSlope (0028,1053)"},
                                                    {&DicomImage::intercept, "RescaleIntercept (0028,1052)"},
                                                    {&DicomImage::spacingText, "PixelSpacing (0028,0030)"},
                                                    {&DicomImage::positionText, "(0020,0032)"},
                                                    {&DicomImage::orientationText, "(0020,0037)"}};
    for (const auto& [field, name] : fields)
        for (const char* text : {"q", "1e999", "nan", "0x10", "1,5", "1.5 mm", "1\\2\\3\\4", "inf\\1"}) {
            const std::string message = refusedDicom([&, f = field](DicomImage& image, int n) {
                if (n == 2)
                    image.*f = text;
            });
            EXPECT_THAT(message, AllOf(HasSubstr(name), HasSubstr("s2.dcm"))) << text;
        }
    // An empty value is an absent one.
    const ScratchFolder folder;
    for (int n = 0; n < 3; ++n) {
        DicomImage image;
        image.position = glm::dvec3(0, 0, n);
        image.pixels.assign(12, 7);
        image.slope = "";
        image.intercept = " ";
        writeDicom(folder / std::to_string(n), image);
    }
    EXPECT_EQ(readAll<std::int16_t>(*openSource(folder.path(), {}))[0], 7);
}

TEST(ImportGeometry, ExtremesAreRefusedWithTheirTag) {
    const auto slope = [](const char* text) {
        return refusedDicom([&](DicomImage& image, int) { image.slope = text; });
    };
    EXPECT_THAT(slope("1e30"), AllOf(HasSubstr("(0028,1053)"), HasSubstr("1e+30")));
    EXPECT_THAT(slope("-1e30"), HasSubstr("(0028,1053)"));
    EXPECT_THAT(slope("1e-30"), HasSubstr("(0028,1053)"));
    EXPECT_THAT(slope("0"), AllOf(HasSubstr("(0028,1053)"), HasSubstr("slope")));
    EXPECT_THAT(slope("0.0000001"), HasSubstr("tell values apart")); // beside an intercept of -1024
    EXPECT_THAT(refusedDicom([](DicomImage& i, int) { i.intercept = "1e30"; }), HasSubstr("(0028,1052)"));
    for (const char* text : {"0\\0", "-1\\-1", "1e30\\1e30", "1e-30\\1e-30"})
        EXPECT_THAT(refusedDicom([&](DicomImage& i, int) { i.spacingText = text; }), HasSubstr("(0028,0030)"))
            << text;
    EXPECT_THAT(refusedDicom([](DicomImage& i, int n) { i.positionText = "0\\1e30\\" + std::to_string(n); }),
                AllOf(HasSubstr("(0020,0032)"), HasSubstr("1e+30")));
}

/// Values may reach what they must not exceed.
TEST(ImportGeometry, LargestValuesAreTakenAndLargerOnesRefused) {
    const auto check = [](double slope, double intercept, double largest, bool isHounsfield) {
        requirePlausibleRescale(slope, intercept, largest, isHounsfield, "slope", "intercept", "f");
    };
    for (const bool isHounsfield : {true, false})
        for (const double sign : {1.0, -1.0}) {
            const double most = isHounsfield ? 1e7 : 1e12, more = most * (1 + 1e-12);
            EXPECT_NO_THROW(check(sign * most, 0, 1, isHounsfield));
            EXPECT_NO_THROW(check(sign * most / 4, 0, 4, isHounsfield));
            EXPECT_NO_THROW(check(most / 1e6, sign * most, 1, isHounsfield));
            EXPECT_THROW(check(sign * more, 0, 1, isHounsfield), InputError);
            EXPECT_THROW(check(sign * more / 4, 0, 4, isHounsfield), InputError);
            EXPECT_THROW(check(most / 1e6, sign * more, 1, isHounsfield), InputError);
        }
}

/// Of spacings, places and angles, and of slopes that must keep values apart.
TEST(ImportGeometry, BoundsOfAllFormats) {
    const auto outcome = [](const auto& action) -> std::string {
        try {
            action();
            return "";
        } catch (const InputError& error) {
            return error.what();
        }
    };
    const auto geometry = [&](const glm::dvec3& first, const glm::dvec3& x, const glm::dvec3& y,
                              const glm::dvec3& z) {
        VolumeInfo info;
        info.patientFromVoxel = patientFromVoxelOf(first, x, y, z);
        return outcome([&] { requirePlausibleGeometry(info, {"spacing", "orientation", "position"}, "f"); });
    };
    for (int axis = 0; axis < 3; ++axis) {
        std::array<glm::dvec3, 3> step = {glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0), glm::dvec3(0, 0, 1)};
        const auto spaced = [&](double mm) {
            auto one = step;
            one[static_cast<std::size_t>(axis)] *= mm;
            return geometry(glm::dvec3(0), one[0], one[1], one[2]);
        };
        for (const double mm : {1e-6, 1e6})
            EXPECT_EQ(spaced(mm), "") << mm;
        EXPECT_EQ(
            spaced(0.9e-6),
            "f: expected spacing with a voxel spacing from 1e-06 to 1e+06 mm, found 9e-07 mm along axis " +
                std::to_string(axis));
        EXPECT_THAT(spaced(1.1e6), HasSubstr("found 1.1e+06 mm along axis " + std::to_string(axis)));
        for (const double sign : {1.0, -1.0}) {
            glm::dvec3 first(0);
            first[axis] = sign * 1e7;
            EXPECT_EQ(geometry(first, step[0], step[1], step[2]), "");
            first[axis] = sign * 1.1e7;
            EXPECT_THAT(geometry(first, step[0], step[1], step[2]),
                        HasSubstr("found " + std::string(sign < 0 ? "-" : "") + "1.1e+07 mm"));
        }
        // An axis that leans to another.
        const auto leaning = [&](double degrees) {
            auto one = step;
            one[static_cast<std::size_t>(axis)] =
                std::cos(degrees * kDegree) * step[static_cast<std::size_t>(axis)] +
                std::sin(degrees * kDegree) * step[static_cast<std::size_t>((axis + 1) % 3)];
            return geometry(glm::dvec3(0), one[0], one[1], one[2]);
        };
        EXPECT_EQ(leaning(44.9), "");
        EXPECT_EQ(leaning(-44.9), "");
        EXPECT_THAT(leaning(45.1), HasSubstr("skewed by 45.1 degrees"));
        EXPECT_THAT(leaning(89.8), HasSubstr("skewed by 89.8 degrees"));
        EXPECT_THAT(leaning(90), HasSubstr("a singular orientation"));
    }
    const auto rescale = [&](double slope, double intercept, double largest) {
        return outcome(
            [&] { requirePlausibleRescale(slope, intercept, largest, false, "slope", "intercept", "f"); });
    };
    EXPECT_EQ(rescale(1e-20, 0, 1), "");
    EXPECT_THAT(rescale(0.9e-20, 0, 1),
                HasSubstr("that leaves values within +-1e+12 and apart, found a slope of 9e-21"));
    // 2^-24 of the intercept is what a float tells apart.
    for (const double sign : {1.0, -1.0}) {
        EXPECT_EQ(rescale(std::ldexp(1000, -24), sign * 1000, 100), "");
        EXPECT_THAT(rescale(0.99 * std::ldexp(1000, -24), sign * 1000, 100),
                    HasSubstr("to tell values apart"));
        EXPECT_EQ(rescale(0.99 * std::ldexp(1000, -24), sign * 1000, 0), "") << "floating-point data";
    }
}

TEST(ImportGeometry, NiftiFieldsThatLieAreNamed) {
    const ScratchFolder folder;
    NiftiImage image;
    image.voxels = std::string(48, '\0');
    const auto refused = [&](const auto& change) {
        std::string bytes = niftiBytes(image);
        change(bytes);
        writeFile(folder / "lie.nii", bytes);
        return refusalOfOpening(folder / "lie.nii");
    };
    const auto put32 = [](std::size_t at, float value) {
        return [at, value](std::string& b) { put(b, at, value); };
    };
    const float inf = std::numeric_limits<float>::infinity(), nan = std::nanf("");
    EXPECT_THAT(refused(put32(280, 1e30f)), AllOf(HasSubstr("sform"), HasSubstr("1e+30")));
    EXPECT_THAT(refused(put32(292, 1e30f)), AllOf(HasSubstr("sform"), HasSubstr("1e+30"))); // the origin
    EXPECT_THAT(refused(put32(292, nan)), HasSubstr("sform"));
    EXPECT_THAT(refused(put32(280, inf)), HasSubstr("sform"));
    EXPECT_THAT(refused(put32(284, 1.8f)), AllOf(HasSubstr("sform"), HasSubstr("skewed by"))); // 61 degrees
    EXPECT_THAT(refused([](std::string& b) { b.replace(280, 16, std::string(16, '\0')); }),
                HasSubstr("sform"));
    const auto withoutSform = [&](std::size_t at, float value, std::int16_t qform = 1) {
        return refused([&](std::string& b) {
            put<std::int16_t>(b, 254, 0), put<std::int16_t>(b, 252, qform), put(b, at, value);
        });
    };
    EXPECT_THAT(withoutSform(256, nan), HasSubstr("qform"));
    EXPECT_THAT(withoutSform(256, 3.f), AllOf(HasSubstr("qform"), HasSubstr("length 3")));
    EXPECT_THAT(withoutSform(268, 1e30f), HasSubstr("qform (qoffset_x"));
    EXPECT_THAT(withoutSform(80, 0.f), HasSubstr("pixdim[1]"));
    EXPECT_THAT(withoutSform(84, 1e30f), HasSubstr("pixdim"));
    EXPECT_THAT(withoutSform(84, 1e30f, 0), HasSubstr("pixdim"));
    for (const float value : {inf, 1e30f, 1e-30f})
        EXPECT_THAT(refused(put32(112, value)), HasSubstr("scl_slope")) << value;
    EXPECT_THAT(refused([&](std::string& b) { put(b, 112, 1.f), put(b, 116, nan); }), HasSubstr("scl_inter"));
    EXPECT_THAT(refused([&](std::string& b) { put(b, 112, 1.f), put(b, 116, 1e30f); }),
                HasSubstr("scl_inter"));
    // Some programs write NaN for "not scaled".
    std::string bytes = niftiBytes(image);
    put(bytes, 112, nan), put(bytes, 116, nan);
    writeFile(folder / "unscaled.nii", bytes);
    EXPECT_EQ(openSource(folder / "unscaled.nii", {})->info().rescaleSlope, 1);
}

TEST(ImportGeometry, SidecarFieldsThatLieAreNamed) {
    const ScratchFolder folder;
    writeFile(folder / "a.raw", std::string(12, '\0'));
    const auto refused = [&](const std::string& spacing, const std::string& more) {
        writeFile(folder / "a.json",
                  R"({"data":"a.raw","type":"int16","extent":[3,2,1],"spacing":)" + spacing + more + "}");
        return refusalOfOpening(folder / "a.json");
    };
    EXPECT_THAT(refused("[1,1e30,1]", ""), HasSubstr("\"spacing\""));
    EXPECT_THAT(refused("[1,1,2e6]", ""), HasSubstr("\"spacing\""));
    EXPECT_THAT(refused("[1e-7,1,1]", ""), HasSubstr("\"spacing\""));
    EXPECT_THAT(refused("[1,1,1]", R"(,"origin":[0,1e30,0])"), HasSubstr("\"origin\""));
    EXPECT_THAT(refused("[1,1,1]", R"(,"direction":[1,0.866025,0, 0,0.5,0, 0,0,1])"),
                AllOf(HasSubstr("\"direction\""), HasSubstr("60 degrees")));
    EXPECT_THAT(refused("[1,1,1]", R"(,"direction":[0,0,0, 0,1,0, 0,0,1])"), HasSubstr("\"direction\""));
    EXPECT_THAT(refused("[1,1,1]", R"(,"rescaleSlope":1e30)"), HasSubstr("\"rescaleSlope\""));
    EXPECT_THAT(refused("[1,1,1]", R"(,"rescaleIntercept":1e30)"), HasSubstr("\"rescaleIntercept\""));
}

TEST(ImportGeometry, TheSignOfATiltIsThatOfTheAnteriorEdge) {
    const double c = std::cos(20 * kDegree), s = std::sin(20 * kDegree);
    const auto tilt = [](const glm::dvec3& x, const glm::dvec3& y, const glm::dvec3& z) {
        return gantryTiltDegrees(patientFromVoxelOf({1, 2, 3}, x, y, z));
    };
    // Columns run to the back: where they also run to the feet, the front edge is nearer to the head.
    EXPECT_NEAR(tilt({1, 0, 0}, {0, c, -s}, {0, 0, 4}), 20, 1e-9);
    EXPECT_NEAR(tilt({1, 0, 0}, {0, c, s}, {0, 0, 4}), -20, 1e-9);
    // The same slices counted from the head, and with rows and columns reversed.
    EXPECT_NEAR(tilt({1, 0, 0}, {0, c, -s}, {0, 0, -4}), 20, 1e-9);
    EXPECT_NEAR(tilt({-1, 0, 0}, {0, -c, s}, {0, 0, 4}), 20, 1e-9);
    EXPECT_EQ(tilt({1, 0, 0}, {0, 1, 0}, {0, 0, 4}), 0);
    EXPECT_NEAR(tilt({1, 0, 0}, {0, c, -s}, 4. * glm::dvec3(0, s, c)), 0, 1e-6); // oblique, not tilted
}

} // namespace
} // namespace tessera::test
