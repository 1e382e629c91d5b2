// tests/bricking/import/dicom_test.cpp: DICOM series on generated files: order from positions, spacing rules,
// values, padding, tilt, multi-frame, damage, and that no planted identifier comes out.
#include "bricking/import/dicom/dicom_scan.h"
#include "tests/support/dicom_writer.h"
#include "tests/support/import_test_tools.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <gmock/gmock.h>
#include <random>

namespace tessera::test {
namespace {

using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Not;

/// A series of 4 x 3 slices at the given z, in files whose names say nothing; slice n holds 1000 * n + pixel
/// number as HU (stored with intercept -1024).
class DicomFolder : public ::testing::Test {
  protected:
    static DicomImage imageAt(int n, double z) {
        DicomImage image;
        image.position = glm::dvec3(-1, 2, z);
        for (int i = 0; i < 12; ++i)
            image.pixels.push_back(static_cast<std::uint16_t>(1000 * n + i + 1024));
        return image;
    }
    void write(const DicomImage& image) {
        const int name = ++written_ * 37 % 101;
        writeDicom(folder / ("f" + std::to_string(name) + (name % 2 ? ".dcm" : "")), image);
    }
    void writeSeries(const std::vector<double>& zs) {
        for (std::size_t n = 0; n < zs.size(); ++n)
            write(imageAt(static_cast<int>(n), zs[n]));
    }
    std::unique_ptr<SlabSource> open(const SourceOptions& options = {}) {
        return openSource(folder.path(), options);
    }
    /// The refusal, checked to name the folder and to give nothing away.
    std::string refused(const SourceOptions& options = {}) {
        const std::string message = refusalOfOpening(folder.path(), options);
        EXPECT_THAT(message, HasSubstr(folder.path().string()));
        expectNothingPlanted(message);
        return message;
    }
    static void expectNothingPlanted(const std::string& text) {
        for (const std::string& planted : kPlanted)
            EXPECT_THAT(text, Not(HasSubstr(planted)));
    }
    static std::int16_t firstOf(const std::vector<std::int16_t>& values, int z) {
        return values[static_cast<std::size_t>(12 * z)];
    }
    ScratchFolder folder;

  private:
    int written_ = 0;
};

TEST_F(DicomFolder, OrderComesFromPositionsWhateverTheNames) {
    writeSeries({30, 10, 20, 0, 40}); // slice n of value 1000 n
    const auto source = open();
    const auto values = readAll<std::int16_t>(*source);
    const VolumeInfo& info = source->info();
    EXPECT_EQ(info.extentVoxels, glm::ivec3(4, 3, 5));
    EXPECT_EQ(info.spacingMm(), glm::dvec3(0.5, 0.7, 10));
    EXPECT_EQ(firstVoxelCentreMm(info), glm::dvec3(-1, 2, 0));
    const std::vector<int> expected = {3, 1, 2, 0, 4};
    for (int z = 0; z < 5; ++z) {
        EXPECT_EQ(firstOf(values, z), 1000 * expected[static_cast<std::size_t>(z)]);
    }
    EXPECT_EQ(values[11], 3011);
    EXPECT_EQ(info.unit, "HU");
    EXPECT_EQ(info.fillStored, -1024);
    EXPECT_EQ(info.acquisition, (Acquisition{"CT", "B30f", 120, 1.5}));
}

TEST_F(DicomFolder, UnevenSlicesAreRefusedWithTheGapsOrResampled) {
    writeSeries({0, 2, 4, 5, 7, 9});
    const std::string message = refused();
    EXPECT_THAT(message, HasSubstr("3-4: 1 mm"));
    EXPECT_THAT(message, HasSubstr("--resample-z"));
    EXPECT_THAT(message, Not(HasSubstr("missing")));
    const auto source = open({.resampleZ = true});
    EXPECT_EQ(source->info().extentVoxels.z, 10); // every millimetre: the smallest gap
    EXPECT_DOUBLE_EQ(source->info().spacingMm().z, 1);
    const auto values = readAll<std::int16_t>(*source);
    const std::vector<int> expected = {0, 500, 1000, 1500, 2000, 3000, 3500, 4000, 4500, 5000};
    for (int z = 0; z < 10; ++z)
        EXPECT_EQ(firstOf(values, z), expected[static_cast<std::size_t>(z)]) << z;
    EXPECT_THAT(source->describe(), HasSubstr("interpolated"));
}

TEST_F(DicomFolder, MissingSlicesAreNamed) {
    writeSeries({0, 2, 4, 10, 12, 14, 16});
    const std::string message = refused();
    EXPECT_THAT(message, HasSubstr("3-4: 6 mm (missing slices: about 2)"));
    const auto values = readAll<std::int16_t>(*open({.resampleZ = true}));
    ASSERT_EQ(values.size(), 12u * 9);
    EXPECT_EQ(firstOf(values, 3), 2333); // a third of the way from 2000 to 3000
    EXPECT_EQ(firstOf(values, 4), 2667); // two thirds: rounded, not cut off
    EXPECT_EQ(firstOf(values, 8), 6000);
}

/// Between two slices lies their mean, whatever the type that holds them and on whichever side of 32768 they
/// lie.
TEST_F(DicomFolder, UnsignedSlicesOnBothSidesOf32768AreResampled) {
    const std::vector<double> zs = {0, 2, 4, 5, 7};
    const std::vector<std::uint16_t> values = {100, 40000, 65535, 32767, 32768};
    for (std::size_t n = 0; n < zs.size(); ++n) {
        DicomImage image = imageAt(0, zs[n]);
        image.modality = "MR";
        image.pixelRepresentation = 0;
        image.slope.reset(), image.intercept.reset();
        image.pixels.assign(12, values[n]);
        write(image);
    }
    const auto source = open({.resampleZ = true});
    ASSERT_EQ(source->info().type, ValueType::u16);
    ASSERT_EQ(source->info().extentVoxels.z, 8); // every millimetre
    const auto got = readAll<std::uint16_t>(*source);
    for (std::size_t z = 0; z < 8; ++z) {
        std::size_t n = 0;
        while (n + 2 < zs.size() && zs[n + 1] <= static_cast<double>(z))
            ++n;
        const double share = (static_cast<double>(z) - zs[n]) / (zs[n + 1] - zs[n]);
        EXPECT_NEAR(got[12 * z], (1 - share) * values[n] + share * values[n + 1], 0.5) << z;
    }
}

TEST_F(DicomFolder, JitterBelowOnePercentIsAcceptedAndAboveIsNot) {
    writeSeries({0, 2, 4.015, 6, 8});
    EXPECT_EQ(open()->info().extentVoxels.z, 5);
    writeSeries({100}); // and now one far away
    EXPECT_THAT(refused(), HasSubstr("missing"));
    const ScratchFolder other;
    int n = 0;
    for (const double z : {0.0, 2.0, 4.03, 6.0, 8.0})
        writeDicom(other / std::to_string(n), imageAt(n, z)), ++n;
    EXPECT_THAT(refusalOfOpening(other.path()), HasSubstr("2 of 4 gaps"));
}

TEST_F(DicomFolder, SmallDeviationsThatAddUpAreRefused) {
    for (const double sign : {1.0, -1.0}) { // slices that lie behind their places, and before them
        std::vector<double> zs = {0};
        for (int n = 0; n < 200; ++n)
            zs.push_back(zs.back() + (1 + sign * (n < 100 ? 0.004 : -0.004)) * 2);
        for (std::size_t n = 0; n < zs.size(); ++n)
            writeDicom(folder / std::to_string(n), imageAt(0, zs[n]));
        EXPECT_THAT(refused(), HasSubstr("from its place"));
        EXPECT_EQ(open({.resampleZ = true})->info().extentVoxels.z, 202); // at the smallest gap
    }
}

TEST_F(DicomFolder, AVeryCloseSliceDoesNotBlowTheVolumeUp) {
    writeSeries({0, 10, 20, 20.01, 30, 40});
    EXPECT_EQ(open({.resampleZ = true})->info().extentVoxels.z,
              21); // at least a quarter of the mean gap of 8 mm
}

TEST_F(DicomFolder, DuplicatesAreRefusedEvenWhenResampling) {
    writeSeries({0, 2, 4, 4, 6});
    EXPECT_THAT(refused(), HasSubstr("1 of 5 slices at the position of another"));
    EXPECT_THAT(refused({.resampleZ = true}), HasSubstr("duplicates"));
}

TEST_F(DicomFolder, MixedOrientationSizeSpacingAndMissingPositionAreRefused) {
    const auto refusedWith = [](auto change, const char* expected) {
        const ScratchFolder mixed;
        for (int n = 0; n < 3; ++n) {
            DicomImage image = imageAt(n, n);
            if (n == 1)
                change(image);
            writeDicom(mixed / std::to_string(n), image);
        }
        EXPECT_THAT(refusalOfOpening(mixed.path(), {.resampleZ = true}), HasSubstr(expected));
    };
    refusedWith(
        [](DicomImage& i) {
            i.rowDirection = {0, 1, 0}, i.columnDirection = {1, 0, 0};
        },
        "one orientation");
    refusedWith([](DicomImage& i) { i.columns = 3, i.rows = 4; }, "one size");
    refusedWith([](DicomImage& i) { i.spacingX = 0.6; }, "pixel spacing");
    refusedWith([](DicomImage& i) { i.position.reset(); }, "position");
    refusedWith([](DicomImage& i) { i.position->x += 0.2; }, "sideways");
    refusedWith([](DicomImage& i) { i.slope = "0"; }, "slope");
    refusedWith([](DicomImage& i) { i.rowDirection = {2, 0, 0}; }, "orientation");
}

TEST_F(DicomFolder, SeveralSeriesAreListedAndChosenByNumber) {
    writeSeries({0, 2, 4});
    for (int n = 0; n < 4; ++n) {
        DicomImage image = imageAt(n, 3 * n);
        image.series = "2";
        image.modality = "MR";
        write(image);
    }
    for (int n = 0; n < 4; ++n) { // with one CT there is no question
        DicomImage image = imageAt(n, 5 * n);
        image.series = "3";
        write(image);
    }
    writeFile(folder / "notes.txt", std::string(400, 'n'));
    DicomImage report; // a DICOM file without pixels
    report.withPixels = false;
    report.storageClass = "1.2.840.10008.5.1.4.1.1.88.22";
    write(report);
    const std::string message = refused();
    EXPECT_THAT(message, HasSubstr("--series N"));
    EXPECT_THAT(message, HasSubstr("  CT        3       4 x 3  0.500 x 0.700 x 2.000  kernel B30f"));
    EXPECT_THAT(message, HasSubstr("  MR        4       4 x 3  0.500 x 0.700 x 3.000  kernel B30f"));
    EXPECT_THAT(refused({.series = 4}), HasSubstr("between 1 and 3"));
    auto found = listVolumes(folder.path());
    ASSERT_EQ(found.size(), 3u);
    EXPECT_EQ(found[2].modality, "CT"); // fewer voxels
    std::erase_if(found, [](const SourceCandidate& volume) { return volume.modality != "MR"; });
    ASSERT_EQ(found.size(), 1u);
    const auto source = openSource(found[0].path, {.series = found[0].series});
    EXPECT_EQ(source->info().extentVoxels.z, 4);
    EXPECT_EQ(source->info().unit, ""); // HU is a unit of CT only
    EXPECT_EQ(found[0].info.patientFromVoxel, source->info().patientFromVoxel);
}

TEST_F(DicomFolder, GantryTiltStaysInTheAffineAsAShear) {
    const double tilt = 18.5 * std::acos(-1.0) / 180;
    for (int n = 0; n < 5; ++n) { // the table moves along z, the slices lean back
        DicomImage image = imageAt(n, 4.0 * n);
        image.columnDirection = {0, std::cos(tilt), -std::sin(tilt)};
        write(image);
    }
    const auto source = open();
    const glm::dmat4& affine = source->info().patientFromVoxel;
    EXPECT_LT(glm::length(glm::dvec3(affine[2]) - glm::dvec3(0, 0, 4)), 1e-9);
    EXPECT_LT(glm::length(glm::dvec3(affine[1]) - 0.7 * glm::dvec3(0, std::cos(tilt), -std::sin(tilt))),
              1e-6);
    EXPECT_THAT(source->describe(), HasSubstr("gantry tilt 18.500 degrees"));
    for (int n = 0; n < 5; ++n) // corners of every slice, as Slicer checks them
        EXPECT_LT(glm::length(centreMm(source->info(), 0, 0, n) - glm::dvec3(-1, 2, 4.0 * n)), 1e-3);
}

TEST_F(DicomFolder, SlopePerSliceUnsigned12BitsOverlayBitsAndNegativeSlope) {
    for (int n = 0; n < 3; ++n) {
        DicomImage image = imageAt(n, n);
        image.bitsStored = 12;
        image.pixelRepresentation = 0;
        image.slope = n == 2 ? "-2" : std::to_string(n + 1);
        image.intercept = n == 2 ? "100" : "-1024";
        for (auto& word : image.pixels)
            word = 0xf000 | 4000; // the upper four bits are an overlay
        write(image);
    }
    const auto values = readAll<std::int16_t>(*open());
    EXPECT_EQ(firstOf(values, 0), 4000 - 1024);
    EXPECT_EQ(firstOf(values, 1), 8000 - 1024);
    EXPECT_EQ(firstOf(values, 2), 100 - 8000);
}

TEST_F(DicomFolder, FractionalSlopeGivesFloat) {
    for (int n = 0; n < 2; ++n) {
        DicomImage image = imageAt(n, n);
        image.slope = "0.5";
        image.intercept = "-0.25";
        write(image);
    }
    const auto source = open();
    const auto values = readAll<float>(*source);
    EXPECT_EQ(values[0], 511.75f);
    EXPECT_EQ(values[12], 1011.75f);
    EXPECT_EQ(source->info().rescaleSlope, 1);
}

TEST_F(DicomFolder, ValuesBeyondInt16AreClampedAndCounted) {
    for (int n = 0; n < 2; ++n) {
        DicomImage image = imageAt(n, n);
        image.slope = "4";
        image.intercept = "0";
        image.pixels[3] = 20000;
        image.pixels[4] = static_cast<std::uint16_t>(-20000);
        write(image);
    }
    const auto source = open();
    const auto values = readAll<std::int16_t>(*source);
    EXPECT_EQ(values[3], 32767);
    EXPECT_EQ(values[4], -32768);
    EXPECT_EQ(source->info().clampedVoxels, 4u);
}

TEST_F(DicomFolder, ValuesAtTheEndsOfInt16AreNotClamped) {
    for (int n = 0; n < 2; ++n) {
        DicomImage image = imageAt(n, n);
        image.intercept = n == 0 ? "1" : "-1";
        image.pixels[3] = static_cast<std::uint16_t>(n == 0 ? 32766 : -32767);
        write(image);
    }
    const auto source = open();
    const auto values = readAll<std::int16_t>(*source);
    const std::size_t slice = values.size() / 2;
    EXPECT_EQ(values[3], 32767);
    EXPECT_EQ(values[slice + 3], -32768);
    EXPECT_EQ(source->info().clampedVoxels, 0u);
}

TEST_F(DicomFolder, DeclaredPaddingBelowAirBecomesAirAndTheRestStays) {
    for (int n = 0; n < 2; ++n) {
        DicomImage image = imageAt(n, n);
        image.intercept = "0";
        image.padding = -2000;
        image.pixels[0] = static_cast<std::uint16_t>(-2000); // padding
        image.pixels[1] = static_cast<std::uint16_t>(-1500); // outside the circle, not declared
        image.pixels[2] = static_cast<std::uint16_t>(-32768);
        write(image);
    }
    const auto values = readAll<std::int16_t>(*open());
    EXPECT_EQ(values[0], -1024);
    EXPECT_EQ(values[1], -1500);
    EXPECT_EQ(values[2], -32768);
}

TEST_F(DicomFolder, MultiFrameFilesAreRead) {
    DicomImage image = imageAt(0, 0);
    image.frames = 3;
    image.storageClass = "1.2.840.10008.5.1.4.1.1.2.1";
    image.framePositions = {{-1, 2, 8}, {-1, 2, 4}, {-1, 2, 0}}; // descending
    image.pixels.clear();
    for (int i = 0; i < 36; ++i)
        image.pixels.push_back(static_cast<std::uint16_t>(i + 1024));
    write(image);
    const auto source = open();
    const auto values = readAll<std::int16_t>(*source);
    EXPECT_EQ(source->info().spacingMm().z, 4);
    EXPECT_EQ(firstOf(values, 0), 24);
    EXPECT_EQ(firstOf(values, 2), 0);
}

TEST_F(DicomFolder, EveryTruncationNamesTheFile) {
    writeSeries({0, 2, 4});
    const std::string whole = dicomBytes(imageAt(3, 6));
    for (std::size_t n = 340; n < whole.size(); n += n + 40 < whole.size() ? 13 : 1) {
        writeFile(folder / "cut.dcm", whole.substr(0, n));
        const std::string message = refused();
        ASSERT_THAT(message, HasSubstr("cut.dcm")) << n << " of " << whole.size();
    }
    writeFile(folder / "cut.dcm", whole);
    EXPECT_EQ(open()->info().extentVoxels.z, 4);
}

TEST_F(DicomFolder, DamagedBytesNeverDoWorseThanAnError) {
    const std::string whole = dicomBytes(imageAt(1, 2));
    std::mt19937 random(4711);
    int opened = 0;
    testing::internal::CaptureStderr();
    for (int n = 0; n < 500; ++n) {
        std::string bytes = whole;
        const std::size_t at = 132 + random() % (whole.size() - 132), count = 1 + random() % 4;
        for (std::size_t i = at; i < std::min(at + count, bytes.size()); ++i)
            bytes[i] = static_cast<char>(random());
        writeFile(folder / "damaged", bytes);
        try {
            const auto source = openSource(folder / "damaged", {});
            std::vector<std::byte> slice(bytesPerValue(source->info().type) * source->info().voxelCount());
            source->readSlices(source->info().extentVoxels.z, slice);
            ++opened;
        } catch (const InputError&) {
        }
    }
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
    EXPECT_GT(opened, 150); // most bytes of a header do not matter
    EXPECT_LT(opened, 500);
}

TEST_F(DicomFolder, AFileThatShrinksAfterOpeningIsAnErrorThatNamesIt) {
    writeSeries({0, 2});
    const auto source = open();
    for (const auto& entry : std::filesystem::directory_iterator(folder.path()))
        std::filesystem::resize_file(entry.path(), std::filesystem::file_size(entry.path()) - 1);
    EXPECT_THAT(refusal([&] { readAll<std::int16_t>(*source); }), HasSubstr(folder.path().string()));
}

TEST_F(DicomFolder, ASingleFileIsASingleSlice) {
    writeDicom(folder / "one", imageAt(1, 5));
    const auto source = openSource(folder / "one", {});
    EXPECT_EQ(source->info().extentVoxels, glm::ivec3(4, 3, 1));
    EXPECT_EQ(source->info().spacingMm().z, 1.5); // the slice thickness
    EXPECT_EQ(source->describe(), "1 DICOM slice, series 1, CT");
    EXPECT_EQ(firstOf(readAll<std::int16_t>(*source), 0), 1000);
}

TEST_F(DicomFolder, NoPlantedIdentifierComesOut) {
    writeSeries({0, 2, 4});
    testing::internal::CaptureStderr();
    testing::internal::CaptureStdout();
    const auto source = open();
    readAll<std::int16_t>(*source);
    writeFile(folder / "bad.dcm", dicomBytes(imageAt(3, 6)).substr(0, 700));
    expectNothingPlanted(refused());
    const std::string printed =
        testing::internal::GetCapturedStdout() + testing::internal::GetCapturedStderr();
    EXPECT_EQ(printed, "");
    expectNothingPlanted(source->describe());
    const VolumeInfo& info = source->info();
    for (const std::string& text : {info.unit, info.acquisition.kernel, info.acquisition.modality})
        expectNothingPlanted(text);
    // A name in a field of the whitelist does not get through either.
    DicomImage image = imageAt(0, 0);
    image.modality = kPlanted[0];
    image.series = "9";
    writeDicom(folder / "named", image);
    const auto named = openSource(folder / "named", {});
    EXPECT_EQ(named->info().acquisition.modality, "");
    EXPECT_THAT(named->describe(), EndsWith(", series 1"));
}

} // namespace
} // namespace tessera::test
