// tests/bricking/export/file_headers_test.cpp: what stands before the values in exported files, and what
// reports say: fields that our own importer passes over, read by their offsets and by the formats'
// definitions.
#include "bricking/export/exported_values.h"
#include "bricking/import/files/nifti/nifti.h"
#include "tests/support/export_tools.h"
#include "tests/support/import_test_tools.h"

#include <cstring>
#include <glm/gtc/quaternion.hpp>
#include <gmock/gmock.h>
#include <random>

namespace tessera::test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;
using ::testing::ThrowsMessage;

/// A store of 4 x 3 x 2 voxels of 0.5 x 0.75 x 2 mm, the first centred at (10, 20, -30).
class ExportedFile : public ::testing::Test {
  protected:
    static VolumeInfo plainBox(ValueType type = ValueType::i16) {
        VolumeInfo info = plainInfo({4, 3, 2}, type);
        info.patientFromVoxel = patientFromVoxelOf({10, 20, -30}, {0.5, 0, 0}, {0, 0.75, 0}, {0, 0, 2});
        info.unit = "HU";
        return info;
    }
    /// Writes it whole and returns the file.
    std::string exported(const VolumeInfo& info, const std::string& format, const std::string& file,
                         bool compress = false) {
        HashSource source(info, [](int x, int y, int z) { return 1 + x + 4 * y + 12 * z; });
        import(scratch / "v.zarr", source, true, 1);
        MemoryBudget ram("RAM", "--ram", kPlenty);
        const StoreReader store(scratch / "v.zarr", ram);
        report = exportBox(format, store, wholeLevel(store.info(), 0), scratch / file, compress);
        return fileText(scratch / file);
    }
    template <class T> static T at(const std::string& bytes, std::size_t offset) {
        T value{};
        EXPECT_LE(offset + sizeof(T), bytes.size());
        std::memcpy(&value, bytes.data() + offset, sizeof(T));
        return value;
    }
    ScratchFolder scratch;
    ExportReport report;
};

// nifti1.h and nifti2.h.
TEST_F(ExportedFile, NiftiFieldsStandAtTheirOffsets) {
    VolumeInfo info = plainBox();
    info.rescaleSlope = 2, info.rescaleIntercept = -7;
    const std::string one = exported(info, "nifti", "v.nii");
    ASSERT_EQ(one.size(), 352u + 48);
    EXPECT_EQ(at<std::int32_t>(one, 0), 348);
    EXPECT_EQ(one.substr(344, 8), std::string("n+1\0\0\0\0\0", 8));
    EXPECT_EQ(at<float>(one, 108), 352); // vox_offset
    EXPECT_EQ(at<std::int16_t>(one, 70), 4);
    EXPECT_EQ(at<std::int16_t>(one, 72), 16);
    EXPECT_EQ(at<float>(one, 112), 2);
    EXPECT_EQ(at<float>(one, 116), -7);
    EXPECT_EQ(one[123], 2); // mm
    EXPECT_EQ(at<std::int16_t>(one, 252), 1);
    EXPECT_EQ(at<std::int16_t>(one, 254), 1);
    const std::string two = exported(info, "nifti2", "w.nii");
    ASSERT_EQ(two.size(), 544u + 48);
    EXPECT_EQ(at<std::int32_t>(two, 0), 540);
    EXPECT_EQ(two.substr(4, 8), std::string("n+2\0\r\n\x1a\n", 8));
    EXPECT_EQ(at<std::int64_t>(two, 168), 544);
    EXPECT_EQ(at<std::int16_t>(two, 12), 4);
    EXPECT_EQ(at<std::int16_t>(two, 14), 16);
    EXPECT_EQ(at<double>(two, 176), 2);
    EXPECT_EQ(at<double>(two, 184), -7);
    EXPECT_EQ(at<std::int32_t>(two, 500), 2);
    EXPECT_EQ(at<std::int32_t>(two, 344), 1);
    EXPECT_EQ(at<std::int32_t>(two, 348), 1);
    const std::vector<int> dims = {3, 4, 3, 2, 1, 1, 1, 1};
    const std::vector<double> pixdim = {1, 0.5, 0.75, 2}, quaternion = {0, 0, 1}, offset = {-10, -20, -30},
                              srow = {-0.5, 0, 0, -10, 0, -0.75, 0, -20, 0, 0, 2, -30};
    for (std::size_t i = 0; i < dims.size(); ++i) {
        EXPECT_EQ(at<std::int16_t>(one, 40 + 2 * i), dims[i]) << i;
        EXPECT_EQ(at<std::int64_t>(two, 16 + 8 * i), dims[i]) << i;
    }
    for (const auto& [values, at1, at2] :
         {std::tuple{pixdim, 76u, 104u}, {quaternion, 256u, 352u}, {offset, 268u, 376u}, {srow, 280u, 400u}})
        for (std::size_t i = 0; i < values.size(); ++i) {
            EXPECT_EQ(at<float>(one, at1 + 4 * i), values[i]) << at1 << ", " << i;
            EXPECT_EQ(at<double>(two, at2 + 8 * i), values[i]) << at2 << ", " << i;
        }
    for (const auto& [type, code, bits] :
         {std::tuple{ValueType::u8, 2, 8}, {ValueType::u16, 512, 16}, {ValueType::f32, 16, 32}}) {
        const std::string file = exported(plainBox(type), "nifti", "v.nii");
        EXPECT_EQ(at<std::int16_t>(file, 70), code);
        EXPECT_EQ(at<std::int16_t>(file, 72), bits);
    }
}

// Readers that prefer the qform see the same places: any turn, also half turns, and axes of the left hand.
TEST_F(ExportedFile, AQformSaysThePlaceTheSformSays) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> any(-1, 1);
    for (int n = 0; n < 12; ++n) {
        glm::dquat q(any(random), any(random), any(random), any(random));
        if (n < 8) // turns by half, or nearly, about each axis
            q = glm::dquat(n < 4 ? 0 : 0.3 * any(random), n % 3 == 0, n % 3 == 1, n % 3 == 2);
        const glm::dmat3 turn = glm::mat3_cast(glm::normalize(q));
        const double hand = n % 2 == 0 ? 1 : -1;
        VolumeInfo info = plainBox(ValueType::u8);
        info.patientFromVoxel =
            patientFromVoxelOf({10, 20, -30}, 0.5 * turn[0], 0.75 * turn[1], 2 * hand * turn[2]);
        const bool isFirst = n % 4 < 2;
        std::string file = exported(info, isFirst ? "nifti" : "nifti2", "v.nii");
        isFirst ? put<std::int16_t>(file, 254, 0) : put<std::int32_t>(file, 348, 0); // no sform
        const NiftiHeader header = parseNiftiHeader(std::as_bytes(std::span(file)), "v.nii");
        EXPECT_EQ(header.orientation, std::string("qform"));
        for (int axis = 0; axis < 4; ++axis)
            for (int i = 0; i < 3; ++i)
                EXPECT_NEAR(header.info.patientFromVoxel[axis][i], info.patientFromVoxel[axis][i],
                            isFirst ? 2e-3 : 1e-7) // floats: the fourth number follows as a root
                    << n << ": " << axis << ", " << i;
    }
}

TEST_F(ExportedFile, TiltedSlicesHaveNoQform) {
    VolumeInfo info = plainBox(ValueType::u8);
    for (const auto& [shear, isBox] : {std::pair(0.9e-4, true), {1.9e-4, false}}) {
        info.patientFromVoxel =
            patientFromVoxelOf({10, 20, -30}, {0.5, 0, 0}, {0, 0.75, 0}, {0, 2 * shear, 2});
        const std::string file = exported(info, "nifti2", "v.nii");
        EXPECT_EQ(at<std::int32_t>(file, 344), isBox) << shear;
        EXPECT_EQ(at<std::int32_t>(file, 348), 1);
        EXPECT_EQ(at<double>(file, 376), isBox ? -10 : 0);
        if (isBox) {
            EXPECT_THAT(report.notes, ElementsAre(StartsWith("NIfTI does not say")));
        } else {
            EXPECT_THAT(report.notes,
                        ElementsAre(StartsWith("the slices are tilted"), StartsWith("NIfTI does not say")));
        }
    }
}

TEST_F(ExportedFile, NotesSayWhatNiftiRounds) {
    VolumeInfo info = plainBox();
    info.unit = "";
    exported(info, "nifti", "v.nii");
    EXPECT_THAT(report.notes, IsEmpty());
    info.unit = "HU";
    exported(info, "nifti", "v.nii");
    EXPECT_THAT(report.notes, ElementsAre("NIfTI does not say that values are in HU"));
    const glm::dmat4 exact = info.patientFromVoxel;
    for (int column = 0; column < 4; ++column) { // 0.1 mm more is no float
        info.patientFromVoxel = exact;
        const int row = column == 3 ? 1 : column;
        info.patientFromVoxel[column][row] += 0.1;
        exported(info, "nifti", "v.nii");
        EXPECT_THAT(report.notes, ElementsAre(StartsWith("positions are rounded to float32"),
                                              StartsWith("NIfTI does not say")))
            << column;
        exported(info, "nifti2", "v.nii");
        EXPECT_THAT(report.notes, ElementsAre(StartsWith("NIfTI does not say"))) << column;
    }
    for (const auto& [slope, intercept] : {std::pair(0.1, 0.0), {2.0, 0.1}}) {
        info = plainBox();
        info.rescaleSlope = slope, info.rescaleIntercept = intercept;
        exported(info, "nifti", "v.nii");
        EXPECT_THAT(report.notes, ElementsAre("slope and intercept are rounded to float32 in NIfTI-1",
                                              StartsWith("NIfTI does not say")));
    }
    EXPECT_THAT([&] { exported(info, "nifti", "v.nii", true); },
                ThrowsMessage<InputError>(HasSubstr("a name ending in .nii.gz for --compress")));
}

TEST_F(ExportedFile, NrrdHeadersAreTheseLines) {
    VolumeInfo info = plainBox();
    const auto header = [](const std::string& file) { return file.substr(0, file.find("\n\n")); };
    const std::string expected =
        "NRRD0005\ntype: int16\ndimension: 3\nspace: left-posterior-superior\nsizes: 4 3 2\n"
        "space directions: (0.5,0,0) (0,0.75,0) (0,0,2)\nkinds: domain domain domain\nendian: little\n"
        "encoding: raw\nspace units: \"mm\" \"mm\" \"mm\"\nspace origin: (10,20,-30)\nsample units: HU";
    EXPECT_EQ(header(exported(info, "nrrd", "v.nrrd")), expected);
    EXPECT_EQ(report.values, "HU as int16");
    EXPECT_THAT(report.notes, IsEmpty());
    info.orientationKnown = false;
    info.unit = "";
    info.rescaleSlope = 0.5;
    std::string other = expected.substr(0, expected.rfind('\n'));
    other.replace(other.find("int16"), 5, "float");
    other.replace(other.find("space: left-posterior-superior"), 30, "space dimension: 3");
    other.replace(other.find("raw"), 3, "gzip");
    EXPECT_EQ(header(exported(info, "nrrd", "v.nrrd", true)), other);
    EXPECT_EQ(report.values, "values as float32, slope 0.5, intercept 0 applied and rounded to float32");
}

TEST_F(ExportedFile, VtiHeadersAreTheseLines) {
    VolumeInfo info = plainBox(ValueType::u16);
    info.patientFromVoxel = patientFromVoxelOf({10, 20, -30}, {0, 0.5, 0}, {0, 0, 0.75}, {2, 0, 0});
    const std::string file = exported(info, "vti", "v.vti");
    EXPECT_THAT(
        file,
        StartsWith(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" version=\"2.2\" "
            "byte_order=\"LittleEndian\" "
            "header_type=\"UInt64\">\n  <ImageData WholeExtent=\"0 3 0 2 0 1\" Origin=\"10 20 -30\" "
            "Spacing=\"0.5 0.75 2\" Direction=\"0 0 1 1 0 0 0 1 0\">\n    <Piece Extent=\"0 3 0 2 0 1\">\n"
            "      <PointData Scalars=\"HU\">\n        <DataArray type=\"UInt16\" Name=\"HU\" "
            "format=\"appended\" offset=\"0\"/>\n"));
    EXPECT_THAT(report.notes, ElementsAre("axes are those of DICOM (LPS), mm"));
    info.unit = "T<1";
    EXPECT_THAT(
        exported(info, "vti", "v.vti", true),
        ::testing::AllOf(HasSubstr("compressor=\"vtkZLibDataCompressor\""), HasSubstr("Name=\"values\"")));
}

TEST_F(ExportedFile, TiffDescriptionsAreImageJs) {
    VolumeInfo info = plainBox(ValueType::u16);
    EXPECT_THAT(exported(info, "tiff", "v.tif"),
                HasSubstr("ImageJ=1.53t\nimages=2\nslices=2\nunit=mm\nvunit=HU\nspacing=2\nloop=false\n"));
    const std::string place = "TIFF has spacings alone: the place and the axes in the patient are left out";
    EXPECT_THAT(report.notes, ElementsAre(place));
    EXPECT_EQ(report.values, "HU as uint16");
    info.unit = "";
    info.rescaleSlope = 0.5, info.rescaleIntercept = -3;
    EXPECT_THAT(exported(info, "tiff", "v.tif"), HasSubstr("unit=mm\ncf=0\nc0=-3\nc1=0.5\nspacing=2\n"));
    EXPECT_EQ(report.values, "uint16 as stored, with slope 0.5, intercept -3 beside them");
    info.type = ValueType::i16;
    EXPECT_THAT(exported(info, "tiff", "v.tif"), ::testing::Not(HasSubstr("cf=0")));
    EXPECT_EQ(report.values, "values as float32, slope 0.5, intercept -3 applied and rounded to float32");
    info.patientFromVoxel[2] += 2e-4 * info.patientFromVoxel[1];
    exported(info, "tiff", "v.tif");
    EXPECT_THAT(report.notes, ElementsAre(place));
    info.patientFromVoxel[2] += 1e-3 * info.patientFromVoxel[1];
    exported(info, "tiff", "v.tif");
    EXPECT_THAT(report.notes, ElementsAre(place, StartsWith("the slices are tilted")));
}

// Whole numbers stay whole where a type of the format has all that are in the box, from end to end.
TEST_F(ExportedFile, TheSmallestTypeThatHoldsTheBox) {
    static constexpr std::array kTiff = {FileType::u8, FileType::i16, FileType::u16, FileType::f32};
    static constexpr std::array kNrrd = {FileType::u8, FileType::i16, FileType::u16, FileType::i32,
                                         FileType::f32};
    const auto values = [&](ValueType stored, double slope, double intercept, double least, double most,
                            const char* format) {
        VolumeInfo info = plainInfo({4, 3, 2}, stored);
        info.rescaleSlope = slope, info.rescaleIntercept = intercept;
        HashSource source(info, [&](int x, int, int) {
            return x == 1 ? least : x == 2 ? most : (least + most) / 2 - std::fmod((least + most) / 2, 1);
        });
        import(scratch / "t.zarr", source, true, 1);
        MemoryBudget ram("RAM", "--ram", kPlenty);
        const StoreReader store(scratch / "t.zarr", ram);
        BoxSource box(store, wholeLevel(info, 0), ram, 1);
        Progress silent;
        const bool isTiff = std::string(format) == "tiff";
        const ExportedValues found = physicalValues(
            box, isTiff ? std::span<const FileType>(kTiff) : std::span<const FileType>(kNrrd), ram, silent);
        return std::string(name(found.type)) + (found.isRounded ? " rounded" : "");
    };
    EXPECT_EQ(values(ValueType::u8, 2, 0, 0, 127, "nrrd"), "uint8");
    EXPECT_EQ(values(ValueType::u8, 2, 0, 0, 128, "nrrd"), "int16");
    EXPECT_EQ(values(ValueType::u8, 1, -1, 0, 255, "nrrd"), "int16");
    EXPECT_EQ(values(ValueType::u8, -1, 255, 0, 255, "nrrd"), "uint8");
    EXPECT_EQ(values(ValueType::i16, 2, 0, -16384, 16383, "nrrd"), "int16");
    EXPECT_EQ(values(ValueType::i16, 2, 0, -16385, 16383, "nrrd"), "int32");
    EXPECT_EQ(values(ValueType::i16, 1, 1, 0, 32766, "nrrd"), "int16");
    EXPECT_EQ(values(ValueType::i16, 1, 1, 0, 32767, "nrrd"), "uint16");
    EXPECT_EQ(values(ValueType::i16, 1, 1, -1, 32767, "nrrd"), "uint16");
    EXPECT_EQ(values(ValueType::i16, 1, 1, -2, 32767, "nrrd"), "int32");
    EXPECT_EQ(values(ValueType::u16, 1, 1, 0, 65534, "nrrd"), "uint16");
    EXPECT_EQ(values(ValueType::u16, 1, 1, 0, 65535, "nrrd"), "int32");
    EXPECT_EQ(values(ValueType::u16, 32769, 0, 0, 65533, "nrrd"), "int32"); // 2147450877
    EXPECT_EQ(values(ValueType::u16, 32769, 0, 0, 65535, "nrrd"), "float32 rounded");
    EXPECT_EQ(values(ValueType::i16, 1, 1, -2, 32767, "tiff"),
              "float32"); // no int32, but every number is exact
    EXPECT_EQ(values(ValueType::i16, 512, 0, -32768, 32767, "tiff"), "float32"); // up to 2^24
    EXPECT_EQ(values(ValueType::i16, 513, 0, -32768, 32767, "tiff"), "float32 rounded");
    EXPECT_EQ(values(ValueType::i16, 1e9, 0, 0, 1, "nrrd"), "int32");
    EXPECT_EQ(values(ValueType::i16, 1.5e9, 0, 0, 1, "nrrd"), "float32 rounded");
    EXPECT_EQ(values(ValueType::i16, 1, 1.5e9, 0, 1, "nrrd"), "float32 rounded");
}

TEST(ExportFormats, NamesAndEndings) {
    for (const auto& [file, name] :
         std::vector<std::pair<const char*, const char*>>{{"a.nrrd", "nrrd"},
                                                          {"a.NII", "nifti"},
                                                          {"a.nii.gz", "nifti"},
                                                          {"a.vti", "vti"},
                                                          {"a.tif", "tiff"},
                                                          {"a.b.TIFF", "tiff"},
                                                          {"folder/a.zarr/", "ome-zarr"}})
        EXPECT_EQ(exportFormatOf("", file).name, name) << file;
    EXPECT_EQ(exportFormatOf("nifti2", "a.nrrd").name, "nifti2");
    EXPECT_THAT([] { exportFormatOf("", "a.gz"); },
                ThrowsMessage<InputError>(HasSubstr("a.gz: expected a name ending in .nrrd, .nii, .nii.gz")));
    EXPECT_THAT([] { exportFormatOf("pictures", "a.nrrd"); },
                ThrowsMessage<InputError>(HasSubstr("--format")));
}

} // namespace
} // namespace tessera::test
