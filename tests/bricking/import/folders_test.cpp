// tests/bricking/import/folders_test.cpp: folders as they come: files that cannot be read among slices,
// scouts and reports beside them, duplicates, phases, files without a preamble, and what other programs
// wrote. Nothing may be left out without a word.
#include "bricking/import/catalogue.h"
#include "bricking/import/files/file_format.h"
#include "tests/support/dicom_series.h"
#include "tests/support/import_test_tools.h"

#include <fcntl.h>
#include <functional>
#include <gmock/gmock.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

namespace tessera::test {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

class Folder : public DicomSeries {
  protected:
    std::string refused(const SourceOptions& options = {}) {
        const std::string message = refusalOfOpening(folder.path(), options);
        for (const std::string& planted : kPlanted)
            EXPECT_THAT(message, Not(HasSubstr(planted)));
        return message;
    }
    int slices(const SourceOptions& options = {}) {
        return openSource(folder.path(), options)->info().extentVoxels.z;
    }
    std::string passed() {
        const Catalogue catalogue = lookThrough(folder.path());
        return passedOverText(catalogue, chooseRow(catalogue, {}));
    }
    std::string table() { return tableOf(lookThrough(folder.path())); }
};

TEST_F(Folder, ASliceThatCannotBeReadStopsTheImportWhereverItIs) {
    for (const int lost : {41, 43, 45}) { // the first, one inside, the last
        SCOPED_TRACE(lost);
        writeSeries();
        const fs::path file = folder / nameOf(lost);
        const auto expectStop = [&](const char* why) {
            EXPECT_THAT(refused(),
                        AllOf(HasSubstr(nameOf(lost)), HasSubstr(why), HasSubstr("--allow-missing")));
            if (lost == 43) {
                EXPECT_THAT(refused({.allowMissing = true}), HasSubstr("missing slices"));
            }
            EXPECT_EQ(slices({.resampleZ = true, .allowMissing = true}), lost == 43 ? kSlices : kSlices - 1);
        };
        writeFile(file, "");
        expectStop("empty");
        writeFile(file, std::string(900, '\0'));
        expectStop("zeros");
        writeFile(file, std::string(900, 'x'));
        expectStop("not DICOM");
        writeFile(file, dicomBytes(imageAt(lost - 41)).substr(0, 500));
        expectStop("truncated");
        fs::remove(file);
        fs::create_symlink("nowhere", file);
        expectStop("not readable");
        fs::remove(file);
    }
}

TEST_F(Folder, WithoutPermissionIsNotReadable) {
    // In a child process of the user nobody, because root may read everything.
    writeSeries();
    fs::permissions(folder.path(), fs::perms::all);
    fs::permissions(folder / nameOf(45), fs::perms::none);
    fs::create_directory(folder / "more");
    const auto refusedAsNobody = [&] {
        int ends[2];
        if (::pipe(ends) != 0)
            return std::string("no pipe");
        const pid_t child = ::fork();
        if (child == 0) {
            if (::geteuid() == 0 && (::setgid(65534) != 0 || ::setuid(65534) != 0))
                ::_exit(1);
            std::string message = "nothing was thrown";
            try {
                openSource(folder.path(), {});
            } catch (const std::exception& error) {
                message = error.what();
            }
            ::_exit(::write(ends[1], message.data(), message.size()) < 0);
        }
        ::close(ends[1]);
        std::string message(4096, '\0');
        const auto got = ::read(ends[0], message.data(), message.size());
        message.resize(static_cast<std::size_t>(std::max<ssize_t>(got, 0)));
        ::close(ends[0]);
        int status = 0;
        ::waitpid(child, &status, 0);
        return message;
    };
    EXPECT_THAT(refusedAsNobody(), AllOf(HasSubstr("IM0045.dcm"), HasSubstr("Permission denied")));
    fs::permissions(folder / nameOf(45), fs::perms::owner_all | fs::perms::others_read);
    EXPECT_EQ(refusedAsNobody(), "nothing was thrown");
    fs::permissions(folder / "more", fs::perms::none);
    EXPECT_THAT(refusedAsNobody(),
                AllOf(HasSubstr("more"), HasSubstr("folder"), HasSubstr("--allow-missing")));
    fs::permissions(folder / "more", fs::perms::all);
}

TEST_F(Folder, WhatIsNoSliceByItsNameNeverStops) {
    writeSeries();
    for (const char* name : {"._IM0042.dcm", ".DS_Store", "Thumbs.db", "desktop.ini", "DICOMDIR", "README",
                             "LICENSE.md", "IM0046.txt", "report.pdf", "IM0046.jpg", "sums.md5"})
        writeFile(folder / name, "");
    writeFile(folder / "Citations", "some words");
    writeFile(folder / "other.bin", "some words");
    EXPECT_EQ(slices(), kSlices);
    EXPECT_THAT(passed(),
                AllOf(HasSubstr("11 files of other kinds"), HasSubstr("2 not DICOM (Citations, other.bin)")));
}

TEST_F(Folder, ADamagedSliceStopsItsOwnSeriesOnly) {
    for (int n = 0; n < kSlices; ++n) {
        writeDicom(folder / nameOf(41 + n), imageAt(n));
        DicomImage other = imageAt(n, "2");
        other.modality = "MR";
        writeDicom(folder / ("MR" + std::to_string(n)), other);
    }
    const std::string whole = dicomBytes(imageAt(4, "2"));
    writeFile(folder / "MR4", whole.substr(0, whole.size() - 7)); // names its series
    writeFile(folder / "MR5", "");                                // beside MR4 by name
    EXPECT_EQ(slices(), kSlices);
    EXPECT_THAT(refused({.series = 2}), AllOf(HasSubstr("MR4"), HasSubstr("truncated"), HasSubstr("MR5")));
    EXPECT_EQ(slices({.series = 2, .allowMissing = true}), kSlices - 1);
    EXPECT_THAT(passed(), AllOf(HasSubstr("1 empty (MR5)"), HasSubstr("1 damaged or not decodable (MR4)"),
                                HasSubstr("series 2 (MR, 4 slices)")));
    // A file that names no patient could be anybody's.
    writeFile(folder / "lost", "");
    EXPECT_THAT(refused(), HasSubstr("lost"));
    fs::create_directory(folder / "elsewhere");
    fs::rename(folder / "lost", folder / "elsewhere/lost");
    EXPECT_EQ(slices(), kSlices);
}

TEST_F(Folder, ASliceUnderADamagedSeriesUidIsMissed) {
    writeSeries();
    for (const int lost : {0, 4}) {
        std::string bytes = dicomBytes(imageAt(lost));
        bytes[bytes.find(kPlanted[6] + ".7.1") + 4] ^= 1; // in SeriesInstanceUID
        writeFile(folder / nameOf(41 + lost), bytes);
        EXPECT_THAT(refused(),
                    AllOf(HasSubstr(nameOf(41 + lost)), HasSubstr("SeriesInstanceUID (0020,000e)")));
        EXPECT_EQ(slices({.allowMissing = true}), kSlices - 1);
        writeSeries();
    }
    // Without any UID and position.
    std::string bytes = dicomBytes(imageAt(0));
    for (const char* tag : {"\x20\0\x0e\0UI", "\x20\0\x32\0"
                                              "DS"})
        bytes[bytes.find(std::string(tag, 6))] = '\x21'; // another group
    writeFile(folder / nameOf(41), bytes);
    EXPECT_THAT(refused(), AllOf(HasSubstr(nameOf(41)), HasSubstr("neither")));
    writeSeries();
    // A lone slice elsewhere, as for the timing of contrast, is none of it.
    DicomImage timing = imageAt(2, "2");
    timing.position->z += 0.7;
    writeDicom(folder / nameOf(46), timing);
    EXPECT_EQ(slices(), kSlices);
}

TEST_F(Folder, ScoutsReportsAndCapturesNeverCompete) {
    writeSeries();
    DicomImage scout = imageAt(0, "2");
    scout.imageType = "ORIGINAL\\PRIMARY\\LOCALIZER";
    scout.columnDirection = {0, 0, -1};
    writeDicom(folder / "scout", scout);
    DicomImage report = imageAt(0, "3");
    report.withPixels = false;
    report.modality = "SR";
    report.storageClass = "1.2.840.10008.5.1.4.1.1.88.67";
    writeDicom(folder / "dose", report);
    report.series = "4";
    report.modality = "DOC";
    report.storageClass = "1.2.840.10008.5.1.4.1.1.104.1";
    writeDicom(folder / "document", report);
    DicomImage capture = imageAt(0, "5");
    capture.storageClass = "1.2.840.10008.5.1.4.1.1.7";
    capture.samplesPerPixel = 3;
    capture.pixels.assign(36, 0);
    writeDicom(folder / "capture", capture);
    writeDicom(folder / "one", imageAt(7, "6")); // one slice of a bolus tracking
    for (const int n : {3, 4})                   // two, as some planning scans have
        writeDicom(folder / ("two" + std::to_string(n)), imageAt(n, "7"));
    EXPECT_EQ(slices(), kSlices);
    const std::string shown = table();
    EXPECT_THAT(
        shown,
        HasSubstr("CT        5       4 x 3  0.500 x 0.700 x 2.000  kernel B30f, 1.5 mm thick, 120 kV"));
    EXPECT_THAT(shown, HasSubstr("scout (localizer)"));
    EXPECT_THAT(shown, AllOf(HasSubstr("SR"), HasSubstr("1 file"), HasSubstr("dose report"),
                             HasSubstr("PDF document"), HasSubstr("secondary capture")));
    for (const std::string& planted : kPlanted)
        EXPECT_THAT(shown, Not(HasSubstr(planted)));
    EXPECT_THAT(passed(), AllOf(HasSubstr("(CT, 1 slice: scout)"), HasSubstr("1 dose report"),
                                HasSubstr("1 PDF document"), HasSubstr("1 secondary capture")));
}

TEST_F(Folder, AScoutAloneExplainsItself) {
    DicomImage scout = imageAt(0);
    scout.imageType = "ORIGINAL\\PRIMARY\\LOCALIZER";
    writeDicom(folder / "scout", scout);
    EXPECT_THAT(refused(), AllOf(HasSubstr("a scout (localizer)"), HasSubstr("--series 1")));
    EXPECT_THAT(refusalOfOpening(folder / "scout"), HasSubstr("a scout (localizer)"));
    EXPECT_EQ(slices({.series = 1}), 1);
}

TEST_F(Folder, OfSeveralVolumesTheOnlyCtOrAChoice) {
    writeSeries();
    for (int n = 0; n < 9; ++n) {
        DicomImage other = imageAt(n, "2");
        other.modality = "MR";
        writeDicom(folder / ("b" + std::to_string(n)), other);
    }
    EXPECT_EQ(slices(), kSlices) << "the only CT";
    for (int n = 0; n < 7; ++n)
        writeDicom(folder / ("c" + std::to_string(n)), imageAt(n, "3"));
    EXPECT_THAT(refused(), AllOf(HasSubstr("--series N or --largest"),
                                 HasSubstr("found 3 volumes: series 1, 2, 3\n  series")));
    EXPECT_EQ(slices({.largest = true}), 7) << "a CT before anything larger";
    EXPECT_EQ(slices({.series = 2}), 9);
    // A CT that needs --resample-z is a volume too, and never gives way without a word.
    fs::remove(folder / "c3");
    EXPECT_THAT(refused(), HasSubstr("--resample-z interpolates"));
}

TEST_F(Folder, ByteIdenticalDuplicatesAreDroppedWithACount) {
    writeSeries();
    fs::copy_file(folder / nameOf(42), folder / "copy of it.dcm");
    writeDicom(folder / "sent again.dcm", imageAt(3)); // another instance, all else the same
    const auto source = openSource(folder.path(), {});
    EXPECT_EQ(source->info().extentVoxels.z, kSlices);
    EXPECT_THAT(source->describe(), HasSubstr("2 byte-identical duplicates dropped"));
    EXPECT_THAT(table(), HasSubstr("2 duplicates dropped"));
    DicomImage another = imageAt(3);
    for (std::size_t pixel = 0; pixel < another.pixels.size(); ++pixel)
        for (const unsigned bit : {1u, 0x100u}) { // of either byte
            another = imageAt(3);
            another.pixels[pixel] ^= static_cast<std::uint16_t>(bit);
            writeDicom(folder / "another.dcm", another);
            EXPECT_THAT(refused(), AllOf(HasSubstr("1 of 6 slices at the position of another"),
                                         HasSubstr("IM0044.dcm and another.dcm")))
                << pixel << ", " << bit;
        }
    another = imageAt(3);
    another.intercept = "-1000"; // the same pixels, other values
    writeDicom(folder / "another.dcm", another);
    EXPECT_THAT(refused(), HasSubstr("at the position of another"));
}

TEST_F(Folder, PhasesBecomeAChoice) {
    const auto expectPhases = [this](const char* label, const auto& change) {
        SCOPED_TRACE(label);
        const ScratchFolder phased;
        for (int n = 0; n < kSlices; ++n)
            for (int phase = 0; phase < 3; ++phase) {
                DicomImage image = imageAt(n);
                image.pixels.assign(12, static_cast<std::uint16_t>(1024 + 100 * phase + n));
                change(image, n, phase);
                writeDicom(phased / (std::to_string(phase * 7 % 3) + "-" + std::to_string(n)), image);
            }
        const std::string message = refusalOfOpening(phased.path());
        EXPECT_THAT(message, AllOf(HasSubstr("--phase N"), HasSubstr("3 phases"), HasSubstr(label)));
        for (const std::string& planted : kPlanted)
            EXPECT_THAT(message, Not(HasSubstr(planted)));
        EXPECT_THAT(message, Not(HasSubstr("101501"))) << "no time of day";
        EXPECT_THAT(refusalOfOpening(phased.path(), {.phase = 4}), HasSubstr("between 1 and 3"));
        for (int phase = 0; phase < 3; ++phase) {
            const auto source = openSource(phased.path(), {.phase = phase + 1});
            const auto values = readAll<std::int16_t>(*source);
            ASSERT_EQ(values.size(), 12u * kSlices);
            for (int n = 0; n < kSlices; ++n)
                EXPECT_EQ(values[static_cast<std::size_t>(12 * n)], 100 * phase + n);
        }
        EXPECT_THAT(tableOf(lookThrough(phased.path())), AllOf(HasSubstr("--phase"), HasSubstr(label)));
    };
    expectPhases("2: phase 40 %", [](DicomImage& i, int, int p) { i.cardiacPercent = 40 * p; });
    expectPhases("3: time 7", [](DicomImage& i, int, int p) { i.temporalPosition = 5 + p; });
    expectPhases("1: acquisition 2", [](DicomImage& i, int, int p) { i.acquisition = 2 + p; });
    // Every slice at its own time: at each place the first, second and third.
    const auto time = [](int n, int p) { return "10150" + std::to_string(p) + "." + std::to_string(10 + n); };
    expectPhases("3: time 3", [&](DicomImage& i, int n, int p) { i.acquisitionTime = time(n, p); });
    // Numbers that go on from place to place are no phases.
    expectPhases("3: time 3", [&](DicomImage& i, int n, int p) {
        i.acquisition = 3 * n + p;
        i.acquisitionTime = time(n, p);
    });
    // At every second place the files stand in the other order.
    expectPhases("3: time 3", [&](DicomImage& i, int n, int p) {
        i.acquisitionTime = time(n, n % 2 ? 2 - p : p);
        i.pixels.assign(12, static_cast<std::uint16_t>(1024 + 100 * (n % 2 ? 2 - p : p) + n));
    });
    expectPhases("3: time 3", [&](DicomImage& i, int n, int p) { i.contentTime = time(n, p); });
    writeSeries();
    EXPECT_THAT(refused({.phase = 1}), HasSubstr("one image at each position"));
    // A phase that lacks a slice at an end would come out shorter without a word.
    for (int n = 0; n < kSlices; ++n)
        for (int phase = 1; phase <= 2; ++phase) {
            DicomImage image = imageAt(n);
            image.temporalPosition = phase;
            if (n > 0 || phase == 2)
                writeDicom(folder / (phase == 1 ? nameOf(41 + n) : "late" + std::to_string(n)), image);
        }
    fs::remove(folder / nameOf(41));
    EXPECT_THAT(refused(), HasSubstr("1: time 1 with 4 of 5 slices, 2: time 2"));
    EXPECT_THAT(refused({.phase = 1}),
                AllOf(HasSubstr("5 slices in every phase"), HasSubstr("--allow-missing")));
    EXPECT_EQ(slices({.phase = 1, .allowMissing = true}), kSlices - 1);
    EXPECT_EQ(slices({.phase = 2}), kSlices);
}

TEST_F(Folder, FilesWithoutAPreambleOpen) {
    for (const bool implicit : {false, true}) {
        for (int n = 0; n < kSlices; ++n) {
            DicomImage image = imageAt(n);
            image.preamble = false;
            image.implicitVr = implicit;
            writeDicom(folder / nameOf(n), image);
        }
        const auto source = openSource(folder.path(), {});
        EXPECT_EQ(source->info().extentVoxels.z, kSlices);
        EXPECT_EQ(source->info().unit, "HU");
        EXPECT_EQ(readAll<std::int16_t>(*source)[12], 100);
        EXPECT_EQ(openSource(folder / nameOf(2), {})->info().extentVoxels.z, 1);
    }
    // A file that only begins alike is no DICOM.
    writeFile(folder / "a", std::string("\x08\0\x05\0ZZ\x0a\0ISO_IR 100", 18) + std::string(200, 'x'));
    writeFile(folder / "b", std::string("\x08\0\x05\0\xff\xff\xff\x7f", 8) + std::string(200, 'x'));
    EXPECT_THAT(refusalOfOpening(folder / "a"), HasSubstr("not DICOM"));
    EXPECT_THAT(refusalOfOpening(folder / "b"), HasSubstr("not DICOM"));
    // Four elements that fit tell, though the file ends with them. Cut short, the fourth does not fit.
    const std::string four("\x08\0\x05\0CS\x0a\0ISO_IR 100\x08\0\x08\0CS\x08\0ORIGINAL\x08\0\x60\0CS\x02\0CT"
                           "\x08\0\x70\0LO\x08\0SOMEBODY",
                           60);
    writeFile(folder / "c", four);
    writeFile(folder / "d", four.substr(0, 59));
    EXPECT_THAT(refusalOfOpening(folder / "c"), Not(HasSubstr("not DICOM")));
    EXPECT_THAT(refusalOfOpening(folder / "d"), HasSubstr("not DICOM"));
}

TEST_F(Folder, SlicesThatDifferInTheirNumberFormatAreReadEachByItsOwn) {
    for (int n = 0; n < 4; ++n) {
        DicomImage image = imageAt(n);
        image.pixelRepresentation = n % 2;
        image.bitsStored = n < 2 ? 12 : 16;
        image.slope = n == 3 ? "2" : "1";
        image.intercept = n == 1 ? "0" : "-1000";
        image.pixels.assign(12, n == 1 ? 0x0fff : 0x0800); // -1 in 12 bits with a sign
        writeDicom(folder / nameOf(n), image);
    }
    const auto values = readAll<std::int16_t>(*openSource(folder.path(), {}));
    EXPECT_EQ(values[0], 2048 - 1000);
    EXPECT_EQ(values[12], -1);
    EXPECT_EQ(values[24], 2048 - 1000);
    EXPECT_EQ(values[36], 2 * 2048 - 1000);
}

// One flipped bit of BitsStored shifted a slice's values by four bits, one of PixelRepresentation wrapped
// them.
TEST_F(Folder, AFewSlicesOfAnotherNumberFormatAreRefused) {
    const auto write = [&](int odd, const auto& change) {
        for (int n = 0; n < kSlices; ++n) {
            DicomImage image = imageAt(n);
            image.bitsStored = 12;
            image.pixelRepresentation = 0;
            if (n < odd)
                change(image);
            writeDicom(folder / nameOf(41 + n), image);
        }
    };
    for (const auto& change : std::vector<std::function<void(DicomImage&)>>{
             [](DicomImage& i) { i.bitsStored = 8; }, [](DicomImage& i) { i.pixelRepresentation = 1; },
             [](DicomImage& i) { i.highBit = 13; }}) {
        write(1, change);
        EXPECT_THAT(refused(), HasSubstr(nameOf(41)));
    }
    write(2, [](DicomImage& i) { i.pixelRepresentation = 1; }); // too many for damage
    EXPECT_THAT(openSource(folder.path(), {})->notes(), ElementsAre(HasSubstr("several number formats")));
    write(kSlices, [](DicomImage& i) { i.bitsStored = 8; }); // pixels up to 1424
    const auto source = openSource(folder.path(), {});
    readAll<std::int16_t>(*source);
    EXPECT_THAT(source->notes(), ElementsAre(HasSubstr("12 pixels have bits beside the 8")));
    write(1, [](DicomImage& i) { i.modalityTable = true; });
    EXPECT_THAT(refused(), HasSubstr("ModalityLUTSequence (0028,3000)"));
}

// 0.625 mm between slices, positions with two decimals: gaps of 0.62 and 0.63 mm were refused as uneven.
TEST_F(Folder, RoundedPositionsOfAnEvenStackAreEven) {
    const auto write = [&](double gap, double unit, int count, double shift) {
        for (int n = 0; n < count; ++n) {
            DicomImage image = imageAt(n);
            // The other coordinates are no finer: the decimals of all three tell how positions are rounded.
            image.position = glm::dvec3(unit < 0.1 ? -1.25 : -1.5, 2.5,
                                        std::round((gap * n + (n == 7 ? shift : 0)) / unit) * unit);
            writeDicom(folder / nameOf(41 + n), image);
        }
    };
    write(0.625, 0.01, 21, 0);
    const VolumeInfo info = openSource(folder.path(), {})->info();
    EXPECT_EQ(info.extentVoxels.z, 21);
    EXPECT_NEAR(info.spacingMm().z, 0.625, 1e-3);
    write(0.625, 0.01, 21, 0.03); // that is no rounding
    EXPECT_THAT(refused(), HasSubstr("gaps that are not"));
    write(0.625, 0.1, 21, 0); // rounded by a sixth of a gap: slices could be misplaced visibly
    EXPECT_THAT(refused(), HasSubstr("gaps that are not"));
}

TEST_F(Folder, AScreenSavedUnderTheScansSeriesIsPassedOver) {
    writeSeries();
    DicomImage screen = imageAt(9);
    screen.position.reset();
    screen.storageClass = "1.2.840.10008.5.1.4.1.1.7";
    writeDicom(folder / nameOf(46), screen);
    EXPECT_EQ(slices(), kSlices);
    EXPECT_THAT(passed(), HasSubstr("1 secondary capture"));
    screen.storageClass = "1.2.840.10008.5.1.4.1.1.2"; // a CT slice has to have a position
    writeDicom(folder / nameOf(46), screen);
    EXPECT_THAT(refused(), HasSubstr(nameOf(46)));
}

TEST_F(Folder, SlicesWithoutNumbersInTheirNamesHaveNeighboursToo) {
    const auto write = [&](const std::string& lost) {
        for (int n = 0; n < kSlices; ++n)
            writeDicom(folder /
                           ("2.25.30815264" + std::to_string(7000000 + 123457 * n) + std::to_string(11 * n)),
                       imageAt(n));
        writeFile(folder / lost, "<html>503</html>");
    };
    write("2.25.3081526479999999");
    EXPECT_THAT(refused(), HasSubstr("2.25.3081526479999999"));
    // A folder for each slice, all of one name.
    const ScratchFolder each;
    for (int n = 0; n < kSlices; ++n) {
        fs::create_directories(each / std::to_string(n));
        writeDicom(each / std::to_string(n) / "IM1", imageAt(n));
    }
    fs::create_directories(each / "9");
    writeFile(each / "9/IM1", "");
    EXPECT_THAT(refusalOfOpening(each.path()), HasSubstr("empty"));
}

TEST_F(Folder, ASliceIsASliceWhateverItsName) {
    writeSeries();
    for (const char* name : {"slice.txt", "a.png", "b.json", "README"}) {
        fs::copy_file(folder / nameOf(45), folder / name);
        fs::rename(folder / nameOf(45), folder / "moved");
        EXPECT_EQ(slices(), kSlices) << name; // "moved" is the same slice, a copy
        fs::rename(folder / "moved", folder / nameOf(45));
        fs::remove(folder / name);
    }
    fs::copy_file(folder / nameOf(45), folder / "._IM0046.dcm");
    EXPECT_THAT(passed(), HasSubstr("._IM0046.dcm"));
    fs::remove(folder / "._IM0046.dcm");
    ASSERT_EQ(::mkfifo((folder / nameOf(46)).c_str(), 0600), 0);
    EXPECT_THAT(refused(), AllOf(HasSubstr(nameOf(46)), HasSubstr("pipe")));
}

// As LIDC-IDRI and others whose names were taken out: no frame, and no reason to refuse. Two frames with
// slices enough to be places are refused, one that lacks in some is not.
TEST_F(Folder, AFrameOfReferenceOfEverySlicesOwnIsNone) {
    const auto withFrames = [&](std::initializer_list<const char*> frames) {
        writeSeries();
        int n = 0;
        for (const char* const frame : frames) {
            DicomImage image = imageAt(n);
            image.frameOfReference = frame;
            writeDicom(folder / nameOf(41 + n++), image);
        }
    };
    withFrames({"1.2.1", "1.2.1", "1.2.1", "1.2.1"});
    const auto alike = openSource(folder.path(), {});
    EXPECT_THAT(alike->notes(), Each(Not(HasSubstr("frame of reference"))));
    EXPECT_EQ(alike->info().frameOfReference, "1.2.1");
    withFrames({"1.2.1", "1.2.2", "1.2.3", "1.2.4"});
    const auto own = openSource(folder.path(), {});
    EXPECT_THAT(own->notes(), Contains(HasSubstr("every slice has a FrameOfReferenceUID of its own")));
    EXPECT_EQ(own->info().patientFromVoxel, alike->info().patientFromVoxel);
    EXPECT_EQ(own->info().frameOfReference, "");
    withFrames({"1.2.1", "", "1.2.1", "1.2.1"});
    EXPECT_EQ(openSource(folder.path(), {})->info().extentVoxels, alike->info().extentVoxels);
    EXPECT_EQ(openSource(folder.path(), {})->info().frameOfReference, "1.2.1");
    withFrames({"", "", "", ""});
    EXPECT_EQ(openSource(folder.path(), {})->info().frameOfReference, "");
    withFrames({"PLANTED NAME", "PLANTED NAME", "PLANTED NAME", "PLANTED NAME"});
    EXPECT_EQ(openSource(folder.path(), {})->info().frameOfReference, "") << "no UID";
    withFrames({"1.2.1", "1.2.1", "1.2.2", "1.2.2"});
    EXPECT_THAT(refused(), HasSubstr("FrameOfReferenceUID (0020,0052)"));
    withFrames({"1.2.1", "1.2.1", "1.2.1", "1.2.2"});
    EXPECT_THAT(refused(), HasSubstr("FrameOfReferenceUID (0020,0052)"));
}

TEST_F(Folder, ASliceThatDisagreesAboutItsValuesIsRefused) {
    const auto refusedWith = [&](const auto& change) {
        writeSeries();
        DicomImage image = imageAt(2);
        change(image);
        writeDicom(folder / nameOf(43), image);
        return refused();
    };
    EXPECT_THAT(refusedWith([](DicomImage& i) { i.intercept.reset(); }),
                AllOf(HasSubstr("RescaleIntercept (0028,1052) in every slice"), HasSubstr("IM0043")));
    EXPECT_THAT(refusedWith([](DicomImage& i) { i.slope.reset(); }),
                HasSubstr("RescaleSlope (0028,1053) in every"));
    // Two patients are not one volume; no patient is named.
    EXPECT_THAT(refusedWith([](DicomImage& i) { i.patientSuffix = "X"; }),
                HasSubstr("PatientID (0010,0020)"));
    EXPECT_THAT(refusedWith([](DicomImage& i) { i.modality = "CU"; }), HasSubstr("Modality (0008,0060)"));
    // Fewer rows or frames than there are pixels: a part would be lost.
    EXPECT_THAT(refusedWith([](DicomImage& i) { i.rows = 2; }),
                AllOf(HasSubstr("IM0043"), HasSubstr("(0028,0010)")));
    EXPECT_THAT(refusedWith([](DicomImage& i) { i.pixels.resize(24); }), HasSubstr("(0028,0008)"));
    // A damaged VR of PixelData makes its length another number, and shifts every pixel.
    std::string bytes = dicomBytes(imageAt(2));
    bytes[bytes.rfind("OW")] ^= 0x40;
    writeSeries();
    writeFile(folder / nameOf(43), bytes);
    EXPECT_THAT(refused(), AllOf(HasSubstr("IM0043"), HasSubstr("(7fe0,0010)")));
    writeSeries();
    DicomImage image = imageAt(2);
    image.intercept = "-1025"; // right for all that can be known, and said
    writeDicom(folder / nameOf(43), image);
    EXPECT_THAT(
        openSource(folder.path(), {})->notes(),
        ElementsAre("RescaleIntercept (0028,1052) is -1024 in 4 slices, -1025 in 1 slice: each slice is "
                    "read by its own"));
    EXPECT_THAT(refusedWith([](DicomImage& i) { i.samplesPerPixel = 3, i.pixels.resize(36); }),
                AllOf(HasSubstr("IM0043"), HasSubstr("SamplesPerPixel")));
}

/// "0028,1053": the element of an explicit little-endian file that a byte belongs to.
std::string elementAt(const std::string& bytes, std::size_t at) {
    const auto u16 = [&](std::size_t p) {
        return static_cast<unsigned>(static_cast<unsigned char>(bytes[p])) |
               static_cast<unsigned>(static_cast<unsigned char>(bytes[p + 1])) << 8;
    };
    for (std::size_t p = 132; p + 12 <= bytes.size();) {
        const bool isLong = std::string("OB OW SQ").find(bytes.substr(p + 4, 2)) != std::string::npos;
        const std::size_t end = p + (isLong ? 12 + u16(p + 8) : 8 + u16(p + 6));
        if (at < end) {
            char tag[16];
            std::snprintf(tag, sizeof tag, "%04x,%04x", u16(p), u16(p + 2));
            return tag;
        }
        p = end;
    }
    return "";
}

// Each bit of one slice's header, flipped: the import is refused, or the volume is what it was. Excepted is
// what decides the values and cannot be told from a right one: the sign, slope and intercept; and the
// transfer syntax, which the decoder has to check.
TEST_F(Folder, EveryFlippedBitOfAHeaderIsHarmlessOrRefused) {
    writeSeries();
    const auto whole = openSource(folder.path(), {});
    const auto expected = readAll<std::int16_t>(*whole);
    const std::string bytes = dicomBytes(imageAt(0));
    int refusals = 0;
    for (std::size_t at = 132; at < bytes.size() - 24; ++at)
        for (int bit = 0; bit < 8; ++bit) {
            std::string damaged = bytes;
            damaged[at] = static_cast<char>(damaged[at] ^ (1 << bit));
            writeFile(folder / nameOf(41), damaged);
            std::unique_ptr<SlabSource> source;
            try {
                source = openSource(folder.path(), {});
            } catch (const InputError&) {
                ++refusals;
                continue;
            }
            const std::string element = elementAt(bytes, at);
            SCOPED_TRACE(element + ", byte " + std::to_string(at) + ", bit " + std::to_string(bit));
            ASSERT_EQ(source->info().extentVoxels, whole->info().extentVoxels);
            ASSERT_EQ(source->info().patientFromVoxel, whole->info().patientFromVoxel);
            ASSERT_EQ(source->info().unit, "HU");
            const bool excepted = element == "0028,0103" || element == "0028,1052" ||
                                  element == "0028,1053" || element == "0002,0010";
            if (!excepted) {
                ASSERT_EQ(readAll<std::int16_t>(*source), expected);
            }
        }
    EXPECT_GT(refusals, 1000);
}

TEST_F(Folder, WhatOtherProgramsWroteIsNamed) {
    const auto expectNamed = [&](const fs::path& path, const char* what, const char* advice) {
        EXPECT_THAT(refusalOfOpening(path), AllOf(HasSubstr(what), HasSubstr(advice))) << path;
    };
    const auto zarr = [&](const char* name, const char* file, const std::string& text) {
        fs::create_directories(folder / name);
        if (*file)
            writeFile(folder / name / file, text);
        return folder / name;
    };
    expectNamed(zarr("a.zarr", ".zarray", "{}"), "a.zarr/.zarray", "zarr_format");
    expectNamed(zarr("b", ".zgroup", R"({"zarr_format":2})"), "b/.zattrs", "multiscales");
    expectNamed(zarr("c.zarr", "zarr.json", R"({"zarr_format":3,"node_type":"group"})"), "c.zarr/zarr.json",
                "multiscales");
    expectNamed(zarr("f.zarr", "", ""), ".zarr folder without metadata", "copy");
    const auto file = [&](const char* name, const std::string& text) {
        fs::create_directories(folder / "files" / name);
        writeFile(folder / "files" / name / name, text);
        return folder / "files" / name / name;
    };
    const std::string hdr = std::string("\x5c\x01\0\0", 4) + std::string(344, '\0');
    for (const auto& [name, text, what] : {std::tuple{"a.hdr", hdr, "Analyze or detached NIfTI"},
                                           {"a.img", "xxxx", "Analyze or detached NIfTI"},
                                           {"a.zip", "PK\x03\x04zzzz", "ZIP"},
                                           {"a.dcm.gz", gzip("a slice"), "DICOM file packed with gzip"},
                                           {"scan", "PK\x03\x04zzzz", "ZIP"},
                                           {"nrrd", "NRRD0004\n", "call it .nrrd"},
                                           {"meta", "ObjectType = Image", "call it .mhd"}}) {
        const fs::path path = file(name, text);
        expectNamed(path, what, "");
        expectNamed(path.parent_path(), what, "");
    }
}

/// Archives are to be unpacked, volumes to be converted; of the rest there is nothing to say but what they
/// are.
TEST_F(Folder, EveryEndingHasTheAdviceOfItsKind) {
    const auto expectAdvice = [&](std::initializer_list<const char*> endings, const char* advice) {
        for (const char* ending : endings) {
            const fs::path path = folder / (std::string("A.b") + ending);
            writeFile(path, "nothing to know it by");
            const ForeignFormat format = foreignFormatOf(path);
            EXPECT_TRUE(format.known()) << ending;
            EXPECT_THAT(format.advice, ::testing::StartsWith(advice)) << ending;
            EXPECT_EQ(format.advice.empty(), !*advice) << ending;
        }
    };
    expectAdvice({".zip", ".tar", ".tgz", ".tar.gz", ".7z", ".RAR"}, "unpack it");
    expectAdvice({".hdr", ".img", ".mgz", ".mgh", ".mnc", ".vtk"}, "convert it to .nii.gz");
    expectAdvice({".stl", ".ply", ".obj"}, "");
}

TEST_F(Folder, SeveralNiftiFilesAreAChoiceByName) {
    NiftiImage image;
    image.voxels = std::string(48, '\0');
    writeFile(folder / "a.nii", niftiBytes(image));
    EXPECT_EQ(slices(), 4);
    writeFile(folder / "b.nii.gz", gzip(niftiBytes(image)));
    EXPECT_THAT(refused(),
                AllOf(HasSubstr("the name of one file"), HasSubstr("a.nii\n"), HasSubstr("b.nii.gz")));
    EXPECT_EQ(slices({.largest = true}), 4);
    writeFile(folder / "b.nii.gz", "no");
    EXPECT_EQ(slices(), 4);
    EXPECT_THAT(passed(), HasSubstr("1 damaged or not decodable (b.nii.gz)"));
}

TEST_F(Folder, ControlCharactersInNamesAreEscaped) {
    writeSeries();
    writeFile(folder / "IM0043\x1b[2J\n.dcm", "");
    EXPECT_THAT(refused(), AllOf(HasSubstr("\\x1b"), Not(HasSubstr("\x1b")), Not(HasSubstr("\n"))));
    EXPECT_THAT(passed(), AllOf(HasSubstr("\\x1b"), Not(HasSubstr("\x1b"))));
}

} // namespace
} // namespace tessera::test
