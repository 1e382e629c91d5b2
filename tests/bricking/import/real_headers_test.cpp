// tests/bricking/import/real_headers_test.cpp: real-world headers: removed names, and identifiers that are
// missing, empty or different in every slice. Also numbers rounded per slice, texts in other representations
// and paddings, and slices that differ in slope, kernel or voltage. Odd and harmless content is taken,
// reported and kept. Content that would make values or places wrong is refused.
#include "bricking/import/catalogue.h"
#include "bricking/import/importer.h"
#include "bricking/store/store_reader.h"
#include "tests/support/dicom_writer.h"
#include "tests/support/import_test_tools.h"

#include <cmath>
#include <functional>
#include <gmock/gmock.h>

namespace tessera::test {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

constexpr int kStack = 12;

/// A series of twelve slices of 4 x 3 pixels, 2 mm apart; slice n holds 100 n HU.
class RealHeaders : public ::testing::Test {
  protected:
    using Change = std::function<void(DicomImage&, int)>;

    static DicomImage imageAt(int n) {
        DicomImage image;
        image.position = glm::dvec3(-100, -120, 2 * n - 7);
        image.pixels.assign(12, static_cast<std::uint16_t>(1024 + 100 * n));
        image.instance = n + 1;
        return image;
    }
    static std::string nameOf(int n) {
        char name[32];
        std::snprintf(name, sizeof name, "IM%04d.dcm", n);
        return name;
    }
    /// Writes the series anew with a change to each slice.
    void write(
        const Change& change = [](DicomImage&, int) {}, int slices = kStack) {
        for (int n = 0; n < slices; ++n) {
            DicomImage image = imageAt(n);
            change(image, n);
            writeDicom(folder / nameOf(n), image);
        }
    }
    /// Opens what is there, which has to be the whole series with every value in its place.
    std::vector<std::string> openedWhole(const VolumeInfo* as = nullptr) {
        const auto source = openSource(folder.path(), {});
        const VolumeInfo& info = source->info();
        EXPECT_EQ(info.extentVoxels, glm::ivec3(4, 3, kStack));
        EXPECT_EQ(info.unit, "HU");
        EXPECT_EQ(info.acquisition.modality, "CT");
        if (as) {
            EXPECT_EQ(info.patientFromVoxel, as->patientFromVoxel);
        }
        const auto values = readAll<std::int16_t>(*source);
        for (int n = 0; n < kStack; ++n)
            EXPECT_EQ(values[static_cast<std::size_t>(12 * n)], 100 * n) << "slice " << n;
        for (const std::string& note : source->notes())
            for (const std::string& planted : kPlanted)
                EXPECT_THAT(note, Not(HasSubstr(planted)));
        EXPECT_THAT(info.remarks, Each(Not(HasSubstr(".dcm")))) << "a name of a file";
        return source->notes();
    }
    std::string refused(const SourceOptions& options = {}) {
        const std::string message = refusalOfOpening(folder.path(), options);
        for (const std::string& planted : kPlanted)
            EXPECT_THAT(message, Not(HasSubstr(planted)));
        return message;
    }
    static std::string readText(const fs::path& path) {
        std::ifstream file(path, std::ios::binary);
        return {std::istreambuf_iterator<char>(file), {}};
    }
    ScratchFolder folder;
};

TEST_F(RealHeaders, ARegularSeriesHasNothingToSay) {
    write();
    EXPECT_THAT(openedWhole(), IsEmpty());
}

TEST_F(RealHeaders, OneSliceOfAnotherSlopeOrInterceptHasItsOwnValuesAndIsSaid) {
    write([](DicomImage& image, int n) {
        if (n == 5) { // 500 HU = 2 * 750 - 1000
            image.slope = "2", image.intercept = "-1000";
            image.pixels.assign(12, 750);
        }
    });
    EXPECT_THAT(
        openedWhole(),
        ElementsAre("RescaleSlope (0028,1053) is 1 in 11 slices, 2 in 1 slice: each slice is read by "
                    "its own",
                    "RescaleIntercept (0028,1052) is -1024 in 11 slices, -1000 in 1 slice: each slice "
                    "is read by its own"));
    write([](DicomImage& image, int n) { // as MR and PET have it
        image.modality = "MR";
        image.slope = std::to_string(n + 1);
    });
    EXPECT_THAT(openSource(folder.path(), {})->notes(),
                Contains("RescaleSlope (0028,1053) has 12 values, 1 to 12: each slice is read by its own"));
}

TEST_F(RealHeaders, OneSliceOfAnotherKernelVoltageOrThicknessIsSaidAndTheCommonOneKept) {
    write([](DicomImage& image, int n) {
        if (n == 0) // the first file's values are not the series'
            image.kernel = "B70f", image.voltage = "80", image.thickness = "1";
    });
    EXPECT_THAT(openedWhole(), ElementsAre(HasSubstr("the kernel is B30f in 11 slices, B70f in 1 slice"),
                                           HasSubstr("voltage (kV) is 120 in 11 slices, 80 in 1 slice"),
                                           HasSubstr("thickness (mm) is 1.5 in 11 slices, 1 in 1 slice")));
    EXPECT_EQ(openSource(folder.path(), {})->info().acquisition, (Acquisition{"CT", "B30f", 120, 1.5}));
    EXPECT_THAT(tableOf(lookThrough(folder.path())), HasSubstr("kernel B30f, 1.5 mm thick, 120 kV"));
    write([](DicomImage& image, int n) { image.kernel = n == 3 ? "" : "B30f"; });
    EXPECT_THAT(openedWhole(), ElementsAre(HasSubstr("B30f in 11 slices, not told in 1 slice")));
}

TEST_F(RealHeaders, EverySecondSliceMissingIsSaid) {
    const auto notes = [&](double gap, const char* thickness, int step) {
        write([&](DicomImage& image, int n) {
            image.position = glm::dvec3(-100, -120, gap * n);
            image.thickness = thickness;
            image.instance = 1 + step * n;
        });
        return openedWhole();
    };
    EXPECT_THAT(notes(10, "5", 2),
                ElementsAre("slices are 5 mm thick and lie 10 mm apart: the space between them is not in the "
                            "scan; InstanceNumber (0020,0013) goes up by 2: were slices left out?"));
    EXPECT_THAT(notes(10, "5", -2), ElementsAre(HasSubstr("goes up by 2")));
    EXPECT_THAT(notes(10, "5", 1), ElementsAre(Not(HasSubstr("InstanceNumber"))));
    EXPECT_THAT(notes(10, "", 3), ElementsAre(HasSubstr("goes up by 3")));
    EXPECT_THAT(notes(5, "5", 2), IsEmpty()) << "another's numbers in between, and no gap";
    EXPECT_THAT(notes(5, "10", 1), IsEmpty()) << "slices that overlap";
    EXPECT_THAT(notes(5, "4", 1), IsEmpty()) << "the usual small gap";
}

TEST_F(RealHeaders, AnEmptyFolderInPlaceOfASliceStopsTheImport) {
    write();
    fs::remove(folder / nameOf(11)); // the last one, whose loss leaves no gap
    fs::create_directory(folder / nameOf(11));
    EXPECT_THAT(refused(),
                AllOf(HasSubstr(nameOf(11)), HasSubstr("an empty folder"), HasSubstr("--allow-missing")));
    EXPECT_EQ(openSource(folder.path(), {.allowMissing = true})->info().extentVoxels.z, kStack - 1);
    fs::rename(folder / nameOf(11), folder / "backup");
    EXPECT_EQ(openSource(folder.path(), {})->info().extentVoxels.z, kStack - 1) << "an empty folder beside";
    // A folder for each slice.
    const ScratchFolder each;
    for (int n = 0; n < kStack; ++n) {
        fs::create_directories(each / std::to_string(n));
        if (n < 11)
            writeDicom(each / std::to_string(n) / "IM1", imageAt(n));
    }
    EXPECT_THAT(refusalOfOpening(each.path()), HasSubstr("an empty folder"));
    // Folders of whole series say nothing about an empty one.
    const ScratchFolder several;
    for (const char* name : {"1", "2", "3", "4"})
        fs::create_directories(several / name);
    for (int n = 0; n < kStack; ++n)
        writeDicom(several / "1" / nameOf(n), imageAt(n));
    EXPECT_EQ(openSource(several.path(), {})->info().extentVoxels.z, kStack);
}

TEST_F(RealHeaders, ColoursInOneSampleAreNotTakenForGreys) {
    for (const char* colour : {"RGB", "PALETTE COLOR", "YBR_FULL"}) {
        write([&](DicomImage& image, int n) {
            if (n == 4)
                image.photometric = colour;
        });
        EXPECT_THAT(refused(),
                    AllOf(HasSubstr(nameOf(4)), HasSubstr("PhotometricInterpretation (0028,0004)")))
            << colour;
        write([&](DicomImage& image, int) { image.photometric = colour; });
        EXPECT_THAT(refused(), HasSubstr("PhotometricInterpretation (0028,0004)")) << colour;
    }
    write([&](DicomImage& image, int) { image.photometric = "MONOCHROME1"; }); // turns the display, not HU
    EXPECT_THAT(openedWhole(), IsEmpty());
}

TEST_F(RealHeaders, IdentifiersThatAreMissingOrEmptyStopNothing) {
    write();
    const VolumeInfo whole = openSource(folder.path(), {})->info();
    const auto opens = [&](const char* what, const Change& change) {
        SCOPED_TRACE(what);
        write(change);
        return openedWhole(&whole);
    };
    EXPECT_THAT(opens("no names at all",
                      [](DicomImage& i, int) {
                          i.without = {0x00080016, 0x00080018, 0x00080020, 0x00100010, 0x00100020,
                                       0x00100030, 0x0020000d, 0x00081010, 0x00080050};
                      }),
                IsEmpty());
    EXPECT_THAT(
        opens("empty names", [](DicomImage& i, int) { i.patient = "", i.patientName = "", i.station = ""; }),
        IsEmpty());
    EXPECT_THAT(opens("a name in some", [](DicomImage& i, int n) { i.patient = n % 3 ? "A" : ""; }),
                ElementsAre("PatientID (0010,0020) is missing in 4 of 12 slices"));
    EXPECT_THAT(opens("a name in each", [](DicomImage& i, int n) { i.patient = "A" + std::to_string(n); }),
                ElementsAre(HasSubstr("every slice has a PatientID of its own")));
    EXPECT_THAT(opens("a station in each", [](DicomImage& i, int n) { i.station = std::to_string(n); }),
                IsEmpty());
    EXPECT_THAT(opens("no modality in some",
                      [](DicomImage& i, int n) {
                          if (n < 2)
                              i.without = {0x00080060};
                      }),
                ElementsAre(HasSubstr("Modality (0008,0060) is missing in 2 of 12 slices")));
    EXPECT_THAT(opens("no series", [](DicomImage& i, int) { i.without = {0x0020000e}; }),
                ElementsAre(HasSubstr("no SeriesInstanceUID")));
    EXPECT_THAT(opens("an empty series", [](DicomImage& i, int) { i.seriesUid = ""; }),
                ElementsAre(HasSubstr("no SeriesInstanceUID")));
    EXPECT_THAT(
        opens("a series each", [](DicomImage& i, int n) { i.seriesUid = "1.2." + std::to_string(n); }),
        ElementsAre(HasSubstr("every slice has a SeriesInstanceUID of its own")));
    EXPECT_THAT(opens("one number for all", [](DicomImage& i, int) { i.instance = 1; }), IsEmpty());
    EXPECT_THAT(opens("numbers twice", [](DicomImage& i, int n) { i.instance = n / 2; }), IsEmpty());
    EXPECT_THAT(opens("no numbers", [](DicomImage& i, int) { i.without = {0x00200013}; }), IsEmpty());
}

TEST_F(RealHeaders, TwoPatientsOrModalitiesAreNoOneVolume) {
    write([](DicomImage& image, int n) { image.patient = n < 6 ? "A" : "B"; });
    EXPECT_THAT(refused(), HasSubstr("PatientID (0010,0020)"));
    write([](DicomImage& image, int n) { image.modality = n < 6 ? "CT" : "MR"; });
    EXPECT_THAT(refused(), HasSubstr("Modality (0008,0060)"));
}

TEST_F(RealHeaders, TwoScansWithoutASeriesUidAreTwoSeries) {
    write([](DicomImage& image, int) { image.seriesUid = ""; });
    for (int n = 0; n < 5; ++n) {
        DicomImage other = imageAt(n);
        other.seriesUid = "";
        other.rowDirection = {0, 1, 0}, other.columnDirection = {0, 0, -1};
        other.position = glm::dvec3(3 * n, 0, 0);
        writeDicom(folder / ("sagittal" + std::to_string(n)), other);
    }
    EXPECT_THAT(refused(), HasSubstr("found 2 volumes"));
    EXPECT_EQ(openSource(folder.path(), {.series = 1})->info().extentVoxels.z, kStack);
}

TEST_F(RealHeaders, LoneSlicesThatMakeNoEvenStackStayAChoice) {
    write([](DicomImage& image, int n) {
        image.seriesUid = "1.2." + std::to_string(n);
        image.position = glm::dvec3(-100, -120, n * n);
    });
    EXPECT_THAT(refused(), HasSubstr("--series N"));
    EXPECT_EQ(openSource(folder.path(), {.series = 3})->info().extentVoxels.z, 1);
}

TEST_F(RealHeaders, TwoFramesOfReferenceWithSlicesEnoughAreAChoice) {
    const auto withFrames = [&](int first) {
        write([&](DicomImage& image, int n) { image.frameOfReference = n < first ? "1.2.1" : "1.2.2"; });
    };
    withFrames(7);
    EXPECT_THAT(refused(), AllOf(HasSubstr("--series N"), HasSubstr("frame of reference 1 of 2"),
                                 HasSubstr("frame of reference 2 of 2")));
    const auto first = openSource(folder.path(), {.series = 1}),
               second = openSource(folder.path(), {.series = 2});
    EXPECT_EQ(first->info().extentVoxels.z, 7);
    EXPECT_EQ(second->info().extentVoxels.z, 5);
    EXPECT_EQ(readAll<std::int16_t>(*second)[0], 700);
    withFrames(10); // two slices could be damaged headers
    EXPECT_THAT(refused(), HasSubstr("FrameOfReferenceUID (0020,0052)"));
}

// A header that is rounded says the same place less finely: the finest of the stack is taken.
TEST_F(RealHeaders, OrientationsAndSpacingsRoundedPerSliceAreOne) {
    const double angle = 0.3;
    const glm::dvec3 row(std::cos(angle), std::sin(angle), 0), column(-std::sin(angle), std::cos(angle), 0);
    const auto text = [&](int decimals) {
        char words[160];
        std::snprintf(words, sizeof words, "%.*f\\%.*f\\%.*f\\%.*f\\%.*f\\%.*f", decimals, row.x, decimals,
                      row.y, decimals, row.z, decimals, column.x, decimals, column.y, decimals, column.z);
        return std::string(words);
    };
    write([&](DicomImage& image, int n) {
        image.orientationText = text(n % 3 == 0 ? 2 : n % 3 == 1 ? 6 : 3);
    });
    EXPECT_THAT(openedWhole(), ElementsAre(HasSubstr("ImageOrientationPatient (0020,0037) is rounded")));
    const glm::dmat4 affine = openSource(folder.path(), {})->info().patientFromVoxel;
    EXPECT_LT(glm::length(glm::dvec3(affine[0]) - 0.5 * row), 1e-6) << "six decimals";
    write([&](DicomImage& image, int n) { image.spacingText = n % 2 ? "0.7\\0.49" : "0.7\\0.488281"; });
    EXPECT_THAT(openedWhole(), ElementsAre(HasSubstr("PixelSpacing (0028,0030) is rounded")));
    EXPECT_DOUBLE_EQ(openSource(folder.path(), {})->info().spacingMm().x, 0.488281);
    // A difference that no rounding explains is another place.
    write([&](DicomImage& image, int n) {
        image.orientationText = n == 4 ? "0.98\\0.2\\0\\-0.2\\0.98\\0" : text(6);
    });
    EXPECT_THAT(refused(), HasSubstr("one orientation"));
    write([&](DicomImage& image, int n) { image.spacingText = n == 4 ? "0.7\\0.5" : "0.7\\0.488281"; });
    EXPECT_THAT(refused(), HasSubstr("one pixel spacing"));
}

TEST_F(RealHeaders, PositionsRoundedPerSliceAreEvenAndStraight) {
    const auto place = [](int n, int decimals) { // a stack that leans a little, 1.25 mm apart
        char words[96];
        std::snprintf(words, sizeof words, "%.*f\\%.*f\\%.*f", decimals, -100.123 + 0.021 * n, decimals,
                      -120.456, decimals, 1.25 * n + 0.007);
        return std::string(words);
    };
    write([&](DicomImage& image, int n) { image.positionText = place(n, n % 2 ? 1 : 3); });
    EXPECT_THAT(openedWhole(), IsEmpty());
    EXPECT_NEAR(openSource(folder.path(), {})->info().spacingMm().z, 1.25, 0.01);
    // A slice that lies elsewhere by more than its last decimal can say.
    write([&](DicomImage& image, int n) { image.positionText = n == 5 ? "-100\\-120.5\\6.4" : place(n, 3); });
    EXPECT_THAT(refused(), HasSubstr("gaps that are not"));
    write(
        [&](DicomImage& image, int n) { image.positionText = n == 5 ? "-100.4\\-120.5\\6.3" : place(n, 3); });
    EXPECT_THAT(refused(), HasSubstr("sideways"));
}

TEST_F(RealHeaders, ScoutsAreToldWhereverTheWordStands) {
    for (const char* type : {"LOCALIZER\\ORIGINAL\\PRIMARY", "ORIGINAL\\PRIMARY\\LOCALIZER\\CT_SOM5 TOP",
                             "ORIGINAL \\PRIMARY \\LOCALIZER ", "original\\primary\\localizer"}) {
        write();
        DicomImage scout = imageAt(0);
        scout.imageType = type;
        scout.columnDirection = {0, 0, -1};
        writeDicom(folder / "scout", scout);
        openedWhole();
        EXPECT_THAT(tableOf(lookThrough(folder.path())), HasSubstr("scout (localizer)")) << type;
    }
}

// Some archives write text elements as UN, some files have other representations than the dictionary's.
TEST_F(RealHeaders, NumbersInOtherRepresentationsAreTheSameNumbers) {
    write();
    const VolumeInfo whole = openSource(folder.path(), {})->info();
    for (const unsigned tag : {0x00200032u, 0x00200037u, 0x00280030u, 0x00281052u, 0x00281053u, 0x00180050u,
                               0x00180060u, 0x00080060u, 0x0020000eu, 0x00080008u, 0x00280004u})
        for (const char* vr : {"UN", "LO", "ST", "UT"}) {
            SCOPED_TRACE(testing::Message() << std::hex << tag << " as " << vr);
            write([&](DicomImage& image, int) { image.vrs[tag] = vr; });
            openedWhole(&whole);
        }
}

TEST_F(RealHeaders, FillingsAndCharsetsChangeNothing) {
    write();
    const VolumeInfo whole = openSource(folder.path(), {})->info();
    for (const char filling : {' ', '\0'}) {
        write([&](DicomImage& image, int n) {
            image.filling = filling;
            image.slope = n % 2 ? " 1.0 " : "+1.00000E+00";
            image.intercept = "-1024.000000 ";
        });
        openedWhole(&whole);
    }
    for (const char* charset : {"ISO_IR 100", "ISO_IR 192", "\\ISO 2022 IR 87", "GB18030", "NONSENSE"}) {
        write([&](DicomImage& image, int) {
            image.charset = charset;
            image.patientName = "\xc4nne^\x1b$B;3ED\x1b(B";
        });
        openedWhole(&whole);
    }
}

TEST_F(RealHeaders, PaddingOfSeveralKindsIsPadding) {
    for (const char* vr : {"US", "SS"})
        for (const bool isSigned : {true, false})
            for (const int padding : {-2000, 63536}) { // the same 16 bits
                if (!isSigned && padding > 0)
                    continue;
                SCOPED_TRACE(testing::Message() << vr << isSigned << padding);
                write([&](DicomImage& image, int) {
                    image.pixelRepresentation = isSigned;
                    image.padding = isSigned ? padding : 0;
                    image.vrs[0x00280120] = vr;
                    image.pixels[11] = isSigned ? static_cast<std::uint16_t>(63536) : 0;
                });
                const auto source = openSource(folder.path(), {});
                EXPECT_EQ(readAll<std::int16_t>(*source)[11], -1024);
            }
}

/// A PET of QIBA's kind: 370 MBq of F-18 given 40 minutes before the scan to 70 kg.
void makePet(DicomImage& image) {
    image.modality = "PT";
    image.storageClass = "1.2.840.10008.5.1.4.1.1.128";
    image.intercept = "0";
    image.acquisitionTime = "101500";
    DicomBytes tracer;
    tracer.element(0x18, 0x1072, "TM", "093000");
    tracer.element(0x18, 0x1074, "DS", "370000000");
    tracer.element(0x18, 0x1075, "DS", "6586.2");
    image.more = {{0x00080031, {"TM", "101000"}},
                  {0x00101030, {"DS", "70"}},
                  {0x00280051, {"CS", "DECY\\ATTN\\SCAT"}},
                  {0x00540016, {"SQ", DicomBytes::item(tracer.bytes())}},
                  {0x00541001, {"CS", "BQML"}},
                  {0x00541102, {"CS", "START"}}};
}

TEST_F(RealHeaders, SuvIsTakenFromAHeaderThatHasAllOfItAndNeverGuessed) {
    const double perValue = 70000 / (370e6 * std::exp2(-2400 / 6586.2));
    const auto written = [&](const Change& change) {
        write([&](DicomImage& image, int n) {
            makePet(image);
            change(image, n);
        });
        return openSource(folder.path(), {});
    };
    const auto pet = written([](DicomImage&, int) {});
    EXPECT_NEAR(pet->info().suvPerValue / perValue, 1, 1e-12);
    EXPECT_THAT(pet->info().remarks, IsEmpty());
    EXPECT_NEAR(written([](DicomImage& i, int) { i.more[0x00541102].second = "ADMIN"; })->info().suvPerValue,
                70000 / 370e6, 1e-12);
    const auto lacks = [&](const char* what, const Change& change) {
        const auto source = written(change);
        EXPECT_EQ(source->info().suvPerValue, 0) << what;
        EXPECT_THAT(source->info().remarks, Contains(AllOf(HasSubstr("SUV is not known"), HasSubstr(what))));
    };
    lacks("Units", [](DicomImage& i, int) { i.more[0x00541001].second = "CNTS"; });
    lacks("PatientWeight", [](DicomImage& i, int) { i.more.erase(0x00101030); });
    lacks("PatientWeight", [](DicomImage& i, int) { i.more[0x00101030].second = "0"; });
    lacks("RadiopharmaceuticalInformationSequence", [](DicomImage& i, int) { i.more.erase(0x00540016); });
    lacks("DecayCorrection", [](DicomImage& i, int) { i.more[0x00541102].second = "NONE"; });
    lacks("CorrectedImage", [](DicomImage& i, int) { i.more[0x00280051].second = "DECY"; });
    lacks("injection", [](DicomImage& i, int) { i.more[0x00080031].second = "090000"; });
    lacks("AcquisitionTime", [](DicomImage& i, int) { i.more[0x00080031].second = "120000"; });
    lacks("for all slices", [](DicomImage& i, int n) { i.more[0x00101030].second = n ? "70" : "80"; });

    MemoryBudget ram("RAM", "--ram", std::size_t{1} << 28);
    const auto source = written([](DicomImage&, int) {});
    importToStore(*source, folder / "suv.zarr", ram, {.durable = false, .unit = "SUVbw"});
    const StoreReader store(folder / "suv.zarr", ram);
    EXPECT_EQ(store.info().unit, "SUVbw");
    EXPECT_NEAR(store.info().rescaleSlope / perValue, 1, 1e-12);
    EXPECT_THAT(readText(folder / "suv.zarr/zarr.json"),
                AllOf(Not(HasSubstr("370000000")), Not(HasSubstr("101000"))));
    write();
    const auto ct = openSource(folder.path(), {.series = 1});
    EXPECT_THROW(importToStore(*ct, folder / "no.zarr", ram, {.durable = false, .unit = "SUVbw"}),
                 InputError);
}

TEST_F(RealHeaders, WhatIsRemarkedStandsInTheStoreAndItsHashIsThatOfTheVoxels) {
    write();
    MemoryBudget ram("RAM", "--ram", std::size_t{1} << 28);
    const auto imported = [&](const char* name) {
        const auto source = openSource(folder.path(), {});
        importToStore(*source, folder / name, ram, {.durable = false});
        return StoreReader(folder / name, ram);
    };
    const std::string hash = imported("plain.zarr").contentHash();
    write([](DicomImage& image, int n) { image.kernel = n ? "B30f" : "B70f"; });
    const StoreReader odd = imported("odd.zarr");
    EXPECT_THAT(odd.info().remarks, ElementsAre(HasSubstr("the kernel is B30f in 11 slices")));
    EXPECT_EQ(odd.contentHash(), hash);
}

} // namespace
} // namespace tessera::test
