// tests/bricking/import/neighbours_test.cpp: which files that cannot be read could be slices of a series: by
// places, names and folders, from just near enough to just too far; and the whole table of a folder of
// several kinds.
#include "bricking/import/catalogue.h"
#include "tests/support/dicom_series.h"
#include "tests/support/import_test_tools.h"

#include <functional>
#include <gmock/gmock.h>

namespace tessera::test {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Not;

class Neighbours : public DicomSeries {
  protected:
    /// What stops the import; "" where it opens the five slices.
    std::string stopped() {
        try {
            EXPECT_EQ(openSource(folder.path(), {})->info().extentVoxels.z, kSlices);
            return "";
        } catch (const InputError& error) {
            return error.what();
        }
    }
};

// A slice under another UID is missed where it continues the stack: at most one gap beyond its ends, within a
// fiftieth of a gap of its place, and alike in all else.
TEST_F(Neighbours, AStrayIsASliceThatContinuesTheStack) {
    const auto stray = [&](
                           double n, const std::function<void(DicomImage&)>& change = [](DicomImage&) {}) {
        writeSeries();
        DicomImage image = imageAt(n, "2");
        change(image);
        writeDicom(folder / nameOf(n < 0 ? 40 : 46), image);
        const std::string said = stopped();
        fs::remove(folder / nameOf(n < 0 ? 40 : 46));
        EXPECT_TRUE(said.empty() || said.find("SeriesInstanceUID (0020,000e)") != std::string::npos) << said;
        return !said.empty();
    };
    for (const double n : {-1.0, 5.0, 5.01, 4.99, -1.01, -0.99})
        EXPECT_TRUE(stray(n)) << n;
    for (const double n : {-2.0, 6.0, 5.03, 4.97, -1.03, -0.97, 4.5})
        EXPECT_FALSE(stray(n)) << n;
    const auto turned = [](double angle) {
        return [angle](DicomImage& image) {
            image.rowDirection = {std::cos(angle), std::sin(angle), 0};
            image.columnDirection = {-std::sin(angle), std::cos(angle), 0};
        };
    };
    EXPECT_TRUE(stray(5, turned(0.0008)));
    EXPECT_FALSE(stray(5, turned(0.0014)));
    EXPECT_FALSE(stray(5, [](DicomImage& i) {
        i.columnDirection = {0, std::cos(0.0014), std::sin(0.0014)};
    }));
    for (const double sign : {1.0, -1.0}) {
        EXPECT_TRUE(stray(5, [&](DicomImage& i) { i.spacingX += sign * 0.0008; }));
        EXPECT_FALSE(stray(5, [&](DicomImage& i) { i.spacingX += sign * 0.0014; }));
        EXPECT_FALSE(stray(5, [&](DicomImage& i) { i.spacingY += sign * 0.0014; }));
    }
    EXPECT_FALSE(stray(5, [](DicomImage& i) { i.columns = 3, i.pixels.resize(9); }));
    EXPECT_FALSE(stray(5, [](DicomImage& i) { i.rows = 2, i.pixels.resize(8); }));
    for (const unsigned tag : {0x00200032u, 0x00200037u, 0x00280030u})
        EXPECT_FALSE(stray(5, [&](DicomImage& i) { i.without = {tag}; })) << std::hex << tag;
}

// Two slices may be split off by damage; three are a volume of their own.
TEST_F(Neighbours, TwoStraysAreMissedAndThreeAreAVolume) {
    writeSeries();
    for (int n = 0; n < 3; ++n) {
        DicomImage image = imageAt(5 + n, "2");
        image.modality = "MR";
        if (n == 2)
            image.position->z = -2;
        writeDicom(folder / nameOf(46 + n), image);
        const std::string said = stopped();
        EXPECT_EQ(said.empty(), n == 2) << n;
    }
    fs::remove(folder / nameOf(48));
    EXPECT_THAT(stopped(), HasSubstr(nameOf(46)));
    // Beside none of its files by name it is no stray.
    fs::rename(folder / nameOf(46), folder / "timing");
    fs::rename(folder / nameOf(47), folder / "again");
    EXPECT_EQ(stopped(), "");
}

TEST_F(Neighbours, ThreeMoreFilesAreNamed) {
    writeSeries();
    const auto with = [&](int lost) {
        for (int n = 0; n < lost; ++n)
            writeFile(folder / nameOf(46 + n), n == 0 ? "" : "no slice");
        return stopped();
    };
    const auto also = [&](int n) { return nameOf(n) + ": a file that is not DICOM"; };
    EXPECT_THAT(
        with(1),
        EndsWith("IM0046.dcm: expected a slice of series 1, as the files beside it are, found an empty "
                 "file (0 bytes); --allow-missing leaves it out"));
    EXPECT_THAT(with(2), EndsWith("(0 bytes); likewise " + also(47) + "; --allow-missing leaves them out"));
    const std::string three = "; likewise " + also(47) + ", " + also(48) + ", " + also(49);
    EXPECT_THAT(with(4), EndsWith(three + "; --allow-missing leaves them out"));
    EXPECT_THAT(with(5), EndsWith(three + " and 1 more; --allow-missing leaves them out"));
    EXPECT_THAT(with(7), EndsWith(three + " and 3 more; --allow-missing leaves them out"));
}

// Numbers of nine digits count files; longer ones are parts of UIDs.
TEST_F(Neighbours, NumbersOfNineDigitsTellNeighbours) {
    const auto stops = [&](const char* before) {
        const ScratchFolder mixed;
        const auto path = [&](int number) { return mixed / (before + std::to_string(number)); };
        for (int n = 0; n < kSlices; ++n) {
            writeDicom(path(10000001 + n), imageAt(n));
            DicomImage other = imageAt(n, "2");
            other.modality = "MR";
            writeDicom(path(20000001 + n), other);
        }
        writeFile(path(20000006), ""); // behind the slices of the MR
        try {
            openSource(mixed.path(), {});
            return false;
        } catch (const InputError&) {
            return true;
        }
    };
    EXPECT_FALSE(stops("a"));
    EXPECT_FALSE(stops("9"));
    EXPECT_TRUE(stops("98")) << "any slice of the folder is a neighbour";
}

// What is no DICOM at all is missed where it has the ending of the slices, or, without one, about their
// length.
TEST_F(Neighbours, NamesWithoutNumbersAreAlikeByTheirEndings) {
    const auto stops = [&](const std::string& ending, const std::string& lost) {
        const ScratchFolder named;
        for (int n = 0; n < kSlices; ++n)
            writeDicom(named / (std::string(1, static_cast<char>('a' + n)) + ending), imageAt(n));
        writeFile(named / lost, "no slice");
        try {
            openSource(named.path(), {});
            return false;
        } catch (const InputError&) {
            return true;
        }
    };
    EXPECT_TRUE(stops(".dicm", "a-longer-name.dicm")); // four letters are an ending
    EXPECT_FALSE(stops(".dicm", "x.dicx"));
    EXPECT_FALSE(stops(".dicom", "a-longer-name.dicom")); // five are none: 19 characters beside 7
    EXPECT_TRUE(stops(".dicom", "y.dicom"));
    EXPECT_TRUE(stops(".dicom", "y.other"));
    EXPECT_FALSE(stops(".dicom", "abc")) << "3 and 7 characters: 0 and 1 times four";
    EXPECT_TRUE(stops(".dicom", "abcd"));
    EXPECT_FALSE(stops(".dicom", "abcdefgh"));
    EXPECT_TRUE(stops(".dicom", "abcd."));
}

// An empty folder is a lost slice beside three folders of a slice each.
TEST_F(Neighbours, FoldersOfASliceEachMissAnEmptyOne) {
    const auto stops = [&](int slices, int inFirst) {
        const ScratchFolder each;
        for (int n = 0; n < slices; ++n) {
            const fs::path one = each / std::string(1, static_cast<char>('a' + n));
            fs::create_directories(one);
            writeDicom(one / "slice", imageAt(n));
        }
        for (int n = 1; n < inFirst; ++n)
            writeDicom(each / "a" / ("slice" + std::to_string(n)), imageAt(slices + n - 1));
        fs::create_directories(each / "empty");
        try {
            openSource(each.path(), {});
            return false;
        } catch (const InputError&) {
            return true;
        }
    };
    EXPECT_TRUE(stops(3, 1));
    EXPECT_TRUE(stops(5, 1));
    EXPECT_FALSE(stops(2, 1));
    EXPECT_FALSE(stops(5, 2));
}

// Files of other kinds are counted, by kind; of each kind three are named.
TEST_F(Neighbours, PassedFilesAreCountedAndThreeAreNamed) {
    writeSeries();
    const auto passed = [&] {
        const Catalogue catalogue = lookThrough(folder.path());
        return passedOverText(catalogue, chooseRow(catalogue, {}));
    };
    for (const char* name : {"alpha", "beta", "gamma"})
        writeFile(folder / name, "no slice");
    EXPECT_EQ(passed(), "3 not DICOM (alpha, beta, gamma)");
    writeFile(folder / "omega", "no slice");
    EXPECT_EQ(passed(), "4 not DICOM (alpha, beta, gamma, ...)");
    writeFile(folder / "a.txt", "");
    EXPECT_EQ(passed(), "1 file of another kind (a.txt), 4 not DICOM (alpha, beta, gamma, ...)");
}

/// The numbers, dates and folders of series have columns where there are any.
TEST_F(Neighbours, TheTableTellsAllOfEverySeries) {
    const auto table = [&] { return tableOf(lookThrough(folder.path())); };
    writeSeries();
    EXPECT_EQ(table(), "  series  date        modality  slices  size   spacing (mm)           what\n"
                       "  1       2023-05-17  CT        5       4 x 3  0.500 x 0.700 x 2.000  kernel B30f, "
                       "1.5 mm thick, 120 kV");
    fs::create_directories(folder / "mr");
    const fs::path deep = folder / "a-folder-whose-long-name-is-cut" / "to-its-last-characters-in-the-table";
    fs::create_directories(deep);
    for (int n = 0; n < 4; ++n) {
        DicomImage image = imageAt(n * n, "2"); // uneven
        image.modality = "MR";
        image.kernel = "", image.voltage = "", image.thickness = "";
        image.seriesNumber = "17", image.seriesDate = "20230518";
        image.imageType = "DERIVED\\SECONDARY\\MPR";
        writeDicom(folder / "mr" / std::to_string(n), image);
        DicomImage other = imageAt(n, "3");
        other.columns = 2, other.rows = 6; // columns to the feet: the table has the source's order
        other.rowDirection = {0, 1, 0}, other.columnDirection = {0, 0, -1};
        other.position = glm::dvec3(3.5 * n, 2, 0);
        other.modality = "PT";
        other.seriesNumber = "4";
        writeDicom(deep / std::to_string(n), other);
    }
    EXPECT_EQ(
        table(),
        "  series  number  date        folder                                    modality  slices  size   "
        "spacing (mm)            what\n"
        "  1       -       2023-05-17  -                                         CT        5       4 x 3  "
        "0.500 x 0.700 x 2.000   kernel B30f, 1.5 mm thick, 120 kV\n"
        "  2       4       2023-05-17  ...t/to-its-last-characters-in-the-table  PT        4       2 x 6  "
        "0.500 x 0.700 x 3.500   kernel B30f, 1.5 mm thick, 120 kV\n"
        "  3       17      2023-05-18  mr                                        MR        4       4 x 3  "
        "0.500 x 0.700 x uneven  MPR; uneven slices: --resample-z interpolates them");
    const Catalogue catalogue = lookThrough(folder.path());
    EXPECT_EQ(passedOverText(catalogue, chooseRow(catalogue, {})),
              "series 2 (PT, 4 slices), series 3 (MR, 4 slices)");
    EXPECT_TRUE(passesOverSomething(catalogue, chooseRow(catalogue, {})));
}

// Six other volumes are told, more are counted; of competing ones twelve numbers.
TEST_F(Neighbours, ManyVolumesAreCounted) {
    for (int series = 1; series <= 14; ++series) {
        for (int n = 0; n < 3; ++n) {
            DicomImage image = imageAt(n, std::to_string(series));
            image.position->x = 100 * series;
            image.modality = "MR";
            writeDicom(folder / ("s" + std::to_string(series) + "-" + std::to_string(n)), image);
        }
        if (series < 7)
            continue;
        const Catalogue catalogue = lookThrough(folder.path());
        const std::string text = passedOverText(catalogue, chooseRow(catalogue, {.series = 2}));
        std::string expected = "series 1 (MR, 3 slices)";
        for (int other = 3; other <= 7; ++other)
            expected += ", series " + std::to_string(other) + " (MR, 3 slices)";
        if (series > 7)
            expected += ", " + std::to_string(series - 7) + " more volumes or scouts";
        EXPECT_EQ(text, expected) << series;
    }
    const auto numbers = [&] {
        const std::string said = refusalOfOpening(folder.path());
        return said.substr(0, said.find('\n'));
    };
    EXPECT_THAT(numbers(), EndsWith("found 14 volumes: series 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, ..."));
    for (int series = 13; series <= 14; ++series)
        for (int n = 0; n < 3; ++n)
            fs::remove(folder / ("s" + std::to_string(series) + "-" + std::to_string(n)));
    EXPECT_THAT(numbers(), EndsWith("found 12 volumes: series 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12"));
}

} // namespace
} // namespace tessera::test
