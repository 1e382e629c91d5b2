// tests/bricking/export/round_trip_test.cpp: what is exported is read again by the importers: the same values
// and places, for every type, format, box and level.
#include "bricking/export/exported_place.h"
#include "bricking/export/exported_values.h"
#include "bricking/export/label_value_source.h"
#include "bricking/export/tiff_pages.h"
#include "bricking/import/open_source.h"
#include "core/base/interrupt.h"
#include "tests/support/export_tools.h"

#include <fstream>
#include <gmock/gmock.h>

namespace tessera::test {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

std::vector<double> physicalValuesOf(SlabSource& source) {
    const VolumeInfo info = source.info();
    std::vector<std::byte> bytes(static_cast<std::size_t>(info.extentVoxels.z) * sliceBytesOf(info));
    source.readSlices(info.extentVoxels.z, bytes);
    std::vector<double> values(info.voxelCount());
    for (std::size_t i = 0; i < values.size(); ++i)
        values[i] = info.rescaleSlope * storedValue(info.type, bytes.data() + i * bytesPerValue(info.type)) +
                    info.rescaleIntercept;
    return values;
}

struct Form {
    std::string format, file;
    bool compress = false;
    double relative = 1e-9;  // of places
    bool keepsFloat = false; // slope and intercept, as float32
    bool hasPlace = true;
};
const std::vector<Form> kForms = {
    {"nrrd", "v.nrrd"},
    {"nrrd", "c.nrrd", true},
    {"nifti", "v.nii", false, 3e-7, true},
    {"nifti", "c.nii.gz", true, 3e-7, true},
    {"nifti2", "w.nii"},
    {"nifti2", "w.nii.gz"},
    {"tiff", "v.tif", false, 1e-9, false, false},
    {"tiff", "c.tiff", true, 1e-9, false, false},
};

void expectReadsBack(const Form& form, const StoreReader& store, const LevelBox& box, const fs::path& file) {
    const VolumeInfo& whole = store.info();
    const std::string what = form.format + " " + name(whole.type) + " level " + std::to_string(box.level) +
                             " slope " + std::to_string(whole.rescaleSlope);
    const ExportReport report = exportBox(form.format, store, box, file, form.compress);
    EXPECT_EQ(report.bytes, fs::file_size(file)) << what;
    const auto read = openSource(file, {});
    ASSERT_EQ(read->info().extentVoxels, box.extent()) << what;
    const std::vector<double> found = physicalValuesOf(*read), expected = expectedValues(store, box);
    ASSERT_EQ(found.size(), expected.size());
    const bool isKept = read->info().rescaleSlope == whole.rescaleSlope &&
                        read->info().rescaleIntercept == whole.rescaleIntercept,
               isFloat = read->info().type == ValueType::f32 && !isKept;
    std::size_t wrong = 0;
    for (std::size_t i = 0; i < found.size(); ++i) {
        const double far = std::abs(found[i] - expected[i]);
        wrong += form.keepsFloat ? far > 1e-7 * (std::abs(expected[i]) + std::abs(whole.rescaleIntercept) + 1)
                 : isFloat       ? found[i] != static_cast<float>(expected[i])
                                 : far > 0;
    }
    EXPECT_EQ(wrong, 0u) << what << " of " << found.size();
    if (form.hasPlace) {
        EXPECT_TRUE(read->info().orientationKnown);
        EXPECT_EQ(read->info().originalOrder, AxisOrder{}) << what << ": nothing is turned";
        expectPlace(whole, box, fourCentres(read->info()), form.relative, what);
    } else {
        const glm::dvec3 step = std::ldexp(1.0, box.level) * whole.spacingMm(), mm = read->info().spacingMm();
        for (int axis = 0; axis < 3; ++axis)
            EXPECT_NEAR(mm[axis], step[axis], 1e-9 * step[axis]) << what;
    }
    fs::remove(file);
}

TEST(Export, EveryTypeFormatBoxAndLevelReadsBack) {
    forEachStoreToExport([](const StoreReader& store, const ScratchFolder& scratch, ValueType) {
        for (const Form& form : kForms)
            for (const LevelBox& box : boxesFor(store.info()))
                expectReadsBack(form, store, box, scratch / form.file);
    });
}

// Stored values stay whole numbers where the format takes slope and intercept, or where physical ones are.
TEST(Export, WholeNumbersStayWhole) {
    const ScratchFolder scratch;
    const auto typeOf = [&](ValueType stored, double slope, double intercept, const std::string& file,
                            const HashSource::Formula& formula = {}) {
        HashSource source(asymmetricInfo(stored, slope, intercept), formula);
        import(scratch / "v.zarr", source, fs::exists(scratch / "v.zarr"), 2, kPlenty, true);
        MemoryBudget ram("RAM", "--ram", kPlenty);
        const StoreReader store(scratch / "v.zarr", ram);
        return exportBox("", store, wholeLevel(store.info(), 0), scratch / file).values;
    };
    const auto small = [](int x, int, int) { return static_cast<double>(100 * x); };
    EXPECT_THAT(typeOf(ValueType::u16, 1, -1024, "a.nrrd", small), HasSubstr("HU as int16"));
    EXPECT_THAT(typeOf(ValueType::u16, 1, -1024, "b.nrrd"), HasSubstr("HU as int32"));
    EXPECT_THAT(typeOf(ValueType::u16, 1, 0, "c.nrrd"), HasSubstr("HU as uint16"));
    EXPECT_THAT(typeOf(ValueType::u16, 0.5, 0, "d.nrrd"), HasSubstr("float32"));
    EXPECT_THAT(typeOf(ValueType::u16, 1, -1024, "e.nii"), HasSubstr("uint16 as stored, with slope 1"));
    EXPECT_THAT(typeOf(ValueType::u16, 1, -1024, "f.tif"), HasSubstr("uint16 as stored"));
    EXPECT_THAT(typeOf(ValueType::i16, 1, -1024, "g.tif", small), HasSubstr("HU as int16"));
    EXPECT_EQ(openSource(scratch / "a.nrrd", {})->info().type, ValueType::i16);
    EXPECT_EQ(openSource(scratch / "a.nrrd", {})->info().unit, "HU");
    EXPECT_EQ(openSource(scratch / "f.tif", {})->info().unit, "HU");
}

// A side that the source does not state is no fact in the file either.
TEST(Export, AnUnknownOrientationStaysUnknown) {
    for (const bool known : {true, false}) {
        const ScratchFolder scratch;
        VolumeInfo info = plainInfo({8, 7, 6}, ValueType::i16);
        info.orientationKnown = known;
        HashSource source(info);
        import(scratch / "v.zarr", source);
        MemoryBudget ram("RAM", "--ram", kPlenty);
        const StoreReader store(scratch / "v.zarr", ram);
        exportBox("", store, wholeLevel(store.info(), 0), scratch / "v.nii");
        std::ifstream file(scratch / "v.nii", std::ios::binary);
        std::int16_t codes[2] = {-1, -1}; // qform_code, sform_code
        file.seekg(252).read(reinterpret_cast<char*>(codes), sizeof codes);
        EXPECT_EQ(codes[0], known ? 1 : 0);
        EXPECT_EQ(codes[1], known ? 1 : 0);
        EXPECT_EQ(openSource(scratch / "v.nii", {})->info().orientationKnown, known);
    }
}

// The case of a name changes nothing: a reader takes .GZ for packed.
TEST(Export, NamesInCapitalsArePackedToo) {
    const ScratchFolder scratch;
    HashSource source(asymmetricInfo(ValueType::i16));
    import(scratch / "v.zarr", source);
    MemoryBudget ram("RAM", "--ram", kPlenty);
    const StoreReader store(scratch / "v.zarr", ram);
    exportBox("", store, wholeLevel(store.info(), 0), scratch / "V.NII.GZ");
    std::ifstream file(scratch / "V.NII.GZ", std::ios::binary);
    EXPECT_EQ(file.get(), 0x1F);
    EXPECT_EQ(file.get(), 0x8B);
}

TEST(Export, AStoreOfABoxIsTheBox) {
    const ScratchFolder scratch;
    for (const Rescale& rescale : {Rescale{1, 0}, Rescale{0.37, -5.5}}) {
        HashSource source(asymmetricInfo(ValueType::i16, rescale.slope, rescale.intercept));
        import(scratch / "v.zarr", source, true);
        MemoryBudget ram("RAM", "--ram", kPlenty);
        const StoreReader store(scratch / "v.zarr", ram);
        for (const LevelBox& box : someBoxes(store.info())) {
            exportBox("ome-zarr", store, box, scratch / "w.zarr");
            const StoreReader read(scratch / "w.zarr", ram);
            EXPECT_EQ(expectedValues(read, wholeLevel(read.info(), 0)), expectedValues(store, box));
            expectPlace(store.info(), box, fourCentres(read.info()), 1e-12, "ome-zarr");
            EXPECT_EQ(read.info().unit, "HU");
            fs::remove_all(scratch / "w.zarr");
        }
    }
}

// Tilted slices: NRRD and sform hold them, VTK's image data do not.
TEST(Export, TiltedSlicesAreHeldOrRefused) {
    const ScratchFolder scratch;
    VolumeInfo info = asymmetricInfo(ValueType::i16);
    info.patientFromVoxel[2] += 0.2 * info.patientFromVoxel[1];
    HashSource source(info);
    import(scratch / "v.zarr", source);
    MemoryBudget ram("RAM", "--ram", kPlenty);
    const StoreReader store(scratch / "v.zarr", ram);
    const LevelBox box = wholeLevel(info, 1);
    for (const char* file : {"v.nrrd", "v.nii"}) {
        exportBox("", store, box, scratch / file);
        expectPlace(info, box, fourCentres(openSource(scratch / file, {})->info()), 3e-7, file);
    }
    EXPECT_THAT([&] { exportBox("", store, box, scratch / "v.vti"); },
                ThrowsMessage<InputError>(HasSubstr("right angles")));
    EXPECT_FALSE(fs::exists(scratch / "v.vti"));
}

TEST(Export, AnyBudgetGivesTheSameBytesOrIsRefused) {
    const ScratchFolder scratch;
    HashSource source(asymmetricInfo(ValueType::u16, 0.5, 3));
    import(scratch / "v.zarr", source);
    MemoryBudget ram("RAM", "--ram", kPlenty);
    const StoreReader store(scratch / "v.zarr", ram);
    const LevelBox box = levelBoxOf(store.info(), 0, {3, 30, 7}, {36, 65, 41}, "--crop-voxels");
    const std::size_t buffers = 2 * store.chunkBytes(), slice = 33 * 35 * 2;
    exportBox("nrrd", store, box, scratch / "all.nrrd");
    for (const std::size_t slices : {1, 2, 5, 31, 32}) {
        exportBox("nrrd", store, box, scratch / "some.nrrd", false, buffers + slices * slice);
        EXPECT_EQ(fileText(scratch / "some.nrrd"), fileText(scratch / "all.nrrd")) << slices;
    }
    EXPECT_THAT([&] { exportBox("nrrd", store, box, scratch / "no.nrrd", false, buffers + slice - 1); },
                ThrowsMessage<InputError>(HasSubstr("--ram")));
    EXPECT_FALSE(fs::exists(scratch / "no.nrrd"));
    EXPECT_EQ(entriesIn(scratch.path()), 3u);
}

TEST(Export, AFileIsReplacedByForceAloneAlsoOneThatAppears) {
    const ScratchFolder scratch;
    HashSource source(asymmetricInfo(ValueType::u16));
    import(scratch / "v.zarr", source);
    MemoryBudget ram("RAM", "--ram", kPlenty);
    const StoreReader store(scratch / "v.zarr", ram);
    for (const ExportFormat& format : exportFormats()) {
        if (format.writesFolder || format.endings.empty())
            continue;
        const fs::path out = scratch / ("a" + format.endings.front());
        Progress silent;
        BoxSource box(store, wholeLevel(store.info(), 0), ram, 1);
        setFileText(out, "theirs");
        EXPECT_THAT(
            [&] {
                format.write(box, {out, false, false, ram, silent});
            },
            ThrowsMessage<InputError>(HasSubstr("--force")))
            << format.name;
        EXPECT_EQ(fileText(out), "theirs");
    }
}

TEST(Export, WorkIsCalledOffBetweenPortionsOfASlice) {
    const ScratchFolder scratch;
    HashSource source(plainInfo({512, 300, 32}, ValueType::u8));
    import(scratch / "v.zarr", source);
    MemoryBudget ram("RAM", "--ram", kPlenty);
    const StoreReader store(scratch / "v.zarr", ram);
    Progress silent;
    for (const FileType type : {FileType::u8, FileType::f32}) { // as stored, and converted
        BoxSource box(store, wholeLevel(store.info(), 0), ram, 1);
        ExportedValues values = storedValues(store.info());
        values.type = type;
        Cancellation::Flag stop{false};
        const Cancellation asked(&stop);
        std::size_t taken = 0;
        EXPECT_THROW(streamNumbers(box, values, ram, silent,
                                   [&](std::span<const std::byte> numbers) {
                                       taken += numbers.size() / bytesPerFileValue(type);
                                       stop = true;
                                   }),
                     Cancelled);
        EXPECT_LT(taken, 512u * 300u);
        EXPECT_GT(taken, 0u);
    }
}

TEST(Export, BoxesAndLevelsThatAreNotThereAreRefused) {
    const VolumeInfo info = asymmetricInfo(ValueType::u8);
    EXPECT_THAT([&] { wholeLevel(info, 6); },
                ThrowsMessage<InputError>(HasSubstr("--level: expected a level from 0")));
    EXPECT_THROW(wholeLevel(info, -1), InputError);
    const auto box = [&](const glm::dvec3& low, const glm::dvec3& high) {
        return levelBoxOf(info, 0, low, high, "--crop-voxels");
    };
    // At the upper faces, too, boxes hold voxels that are there.
    for (const double thin : {1e-3, 1e-9}) {
        const glm::dvec3 extent(info.extentVoxels);
        const LevelBox last = box(extent - thin, extent + 5.0), first = box(glm::dvec3(-5), glm::dvec3(thin));
        EXPECT_EQ(last.low, info.extentVoxels - 1) << thin;
        EXPECT_EQ(last.high, info.extentVoxels) << thin;
        EXPECT_EQ(first.low, glm::ivec3(0)) << thin;
        EXPECT_EQ(first.high, glm::ivec3(1)) << thin;
    }
    EXPECT_THAT([&] { box({5, 5, 5}, {5, 9, 9}); }, ThrowsMessage<InputError>(HasSubstr("--crop-voxels")));
    EXPECT_THROW(box({5, 9, 5}, {9, 5, 9}), InputError);
    EXPECT_THAT([&] { box({40, 0, 0}, {50, 9, 9}); }, ThrowsMessage<InputError>(HasSubstr("0,37,0,70,0,45")));
    EXPECT_THROW(box({NAN, 0, 0}, {50, 9, 9}), InputError);
    EXPECT_EQ(box({-5, -5, -5}, {500, 1, 1}).extent(), glm::ivec3(37, 1, 1));
    EXPECT_EQ(levelBoxOf(info, 2, {5, 9, 13}, {37, 70, 39}, "").low, glm::ivec3(1, 2, 3));
    EXPECT_EQ(levelBoxOf(info, 2, {5, 9, 13}, {37, 70, 39}, "").high, glm::ivec3(10, 18, 10));
}

TEST(Export, TheAffineComesBackBitByBit) {
    int exact = 0;
    for (int i = 0; i < 200; ++i) {
        VolumeInfo info = asymmetricInfo(ValueType::u8);
        info.patientFromVoxel[3] += glm::dvec4(i * 0.1, -i / 7.0, i * 1e-3, 0);
        const ExportedPlace place = placeOf(info);
        const glm::dmat4 again =
            patientFromVoxelOf(place.firstCentre, place.step[0], place.step[1], place.step[2]);
        exact += again == info.patientFromVoxel;
        for (int axis = 0; axis < 3; ++axis)
            EXPECT_NEAR(again[3][axis], info.patientFromVoxel[3][axis], 1e-14) << i;
    }
    // The centre of a corner that is nearer to 0 than half a voxel has fewer bits behind the point than it.
    EXPECT_GE(exact, 180);
}

// What files above 4 GiB are.
TEST(Export, BigTiffReadsBack) {
    const ScratchFolder scratch;
    std::vector<std::uint16_t> pixels(300 * 500 * 3);
    for (std::size_t i = 0; i < pixels.size(); ++i)
        pixels[i] = static_cast<std::uint16_t>(mixed(i) % 500 * (i % 7));
    for (const bool packed : {false, true}) {
        TiffLayout layout{{300, 500},
                          3,
                          FileType::u16,
                          {0.7, 0.9},
                          "ImageJ=1.53t\nimages=3\nslices=3\nunit=mm\nspacing=2.5\n",
                          packed,
                          true};
        TiffPages pages(scratch / "b.tif", layout);
        const auto bytes = std::as_bytes(std::span(pixels));
        for (std::size_t at = 0; at < bytes.size(); at += 99991) // portions that end anywhere
            pages.append(bytes.subspan(at, std::min<std::size_t>(99991, bytes.size() - at)));
        pages.finish();
        EXPECT_EQ(fileText(scratch / "b.tif").substr(0, 4), std::string("II\x2b\0", 4));
        const auto read = openSource(scratch / "b.tif", {});
        EXPECT_EQ(physicalValuesOf(*read), std::vector<double>(pixels.begin(), pixels.end())) << packed;
        const glm::dvec3 mm = read->info().spacingMm();
        EXPECT_NEAR(mm.x, 0.7, 1e-9);
        EXPECT_NEAR(mm.y, 0.9, 1e-9);
        EXPECT_EQ(mm.z, 2.5);
    }
}

TEST(Export, LabelsHaveTheirOwnValues) {
    const ScratchFolder scratch;
    for (const std::uint32_t value : {200u, 4000u}) {
        HashSource source(asymmetricInfo(ValueType::u8), [](int x, int y, int z) { return (x + y + z) % 3; });
        import(scratch / "sets.zarr", source, true);
        MemoryBudget ram("RAM", "--ram", kPlenty);
        const StoreReader sets(scratch / "sets.zarr", ram);
        LabelTable table;
        table.labels = {{7, "liver"}, {value, "spleen"}};
        table.sets = {{}, {0}, {1}};
        const LabelValueSource numbers(sets, table, "labels");
        EXPECT_EQ(numbers.info().type, value > 255 ? ValueType::u16 : ValueType::u8);
        const LevelBox box = levelBoxOf(numbers.info(), 0, {3, 30, 7}, {36, 65, 41}, "--crop-voxels");
        BoxSource source2(numbers, box, ram);
        const std::vector<double> found = physicalValuesOf(source2);
        for (std::size_t i = 0; i < found.size(); ++i) {
            const glm::ivec3 at = box.low + gridPosition(i, box.extent());
            const int set = (at.x + at.y + at.z) % 3;
            ASSERT_EQ(found[i], set == 0 ? 0 : set == 1 ? 7 : value) << i;
        }
        table.sets.push_back({0, 1});
        EXPECT_THAT([&] { LabelValueSource(sets, table, "labels"); },
                    ThrowsMessage<InputError>(HasSubstr("overlap")));
        table.sets.pop_back();
        table.labels[1].value = 70000;
        EXPECT_THAT([&] { LabelValueSource(sets, table, "labels"); },
                    ThrowsMessage<InputError>(HasSubstr("65535")));
    }
}

TEST(Export, LongDimensionsBecomeNifti2) {
    const ScratchFolder scratch;
    VolumeInfo info = plainInfo({33000, 2, 3}, ValueType::u8);
    HashSource source(info);
    import(scratch / "v.zarr", source);
    MemoryBudget ram("RAM", "--ram", kPlenty);
    const StoreReader store(scratch / "v.zarr", ram);
    exportBox("", store, wholeLevel(info, 0), scratch / "v.nii");
    const auto read = openSource(scratch / "v.nii", {});
    EXPECT_THAT(read->describe(), HasSubstr("NIfTI-2"));
    EXPECT_EQ(physicalValuesOf(*read), expectedValues(store, wholeLevel(info, 0)));
}

} // namespace
} // namespace tessera::test
