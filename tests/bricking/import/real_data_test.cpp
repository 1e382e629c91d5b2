// tests/bricking/import/real_data_test.cpp: real scans (skipped where the shared test data is absent), and a
// whole-volume cross-check against VTK's NIfTI reader.
#include "tests/support/import_test_tools.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <gmock/gmock.h>
#include <vtkImageData.h>
#include <vtkMatrix4x4.h>
#include <vtkNIFTIImageReader.h>
#include <vtkNew.h>

namespace tessera::test {
namespace {

using ::testing::HasSubstr;

class RealData : public ::testing::Test {
  protected:
    void SetUp() override {
        if (testData().empty())
            GTEST_SKIP() << "no shared test data (TESSERA_TEST_DATA or ../shared/data)";
    }
    static std::filesystem::path at(const std::string& name) { return testData() / name; }
};

TEST_F(RealData, Abdomen) {
    const auto source = openSource(at("ct-abdomen-dicom"), {});
    const auto values = readAll<std::int16_t>(*source);
    const VolumeInfo& info = source->info();
    EXPECT_EQ(info.extentVoxels, glm::ivec3(512, 512, 134));
    EXPECT_NEAR(info.spacingMm().x, 1.07421875, 1e-9);
    EXPECT_NEAR(info.spacingMm().z, 3.0, 1e-6);
    const auto [least, most] = std::minmax_element(values.begin(), values.end());
    EXPECT_EQ(*least, -1000);
    EXPECT_EQ(*most, 1988);
    EXPECT_EQ(info.unit, "HU");
    EXPECT_EQ(info.originalOrder, AxisOrder{});
    EXPECT_EQ(info.clampedVoxels, 0u);
}

TEST_F(RealData, TiltedHeadNeedsResampling) {
    const std::string message = refusalOfOpening(at("ct-head-tilted-dicom"));
    EXPECT_THAT(message, HasSubstr("14-15: 1.081 mm")); // the odd gap, after projection
    EXPECT_THAT(message, HasSubstr("15-28: 6.999 mm"));
    const auto source = openSource(at("ct-head-tilted-dicom"), {.resampleZ = true});
    const VolumeInfo& info = source->info();
    const glm::dvec3 x = info.patientFromVoxel[0], y = info.patientFromVoxel[1], z = info.patientFromVoxel[2];
    const double lean = std::acos(glm::dot(glm::normalize(glm::cross(x, y)), glm::normalize(z)));
    EXPECT_NEAR(lean * 180 / std::acos(-1.0), 18.5, 0.05);
    EXPECT_LT(glm::length(glm::dvec3(firstVoxelCentreMm(info)) - glm::dvec3(-125, -123.5404569, 5.8360586)),
              1e-6);
    EXPECT_LT(glm::length(centreMm(info, 0, 0, info.extentVoxels.z - 1) -
                          glm::dvec3(-125, -123.5404569, 157.7760586)),
              1e-6);
    // 28 slices over 144.1 mm: the smallest gap is below a quarter of the mean one, 1.334 mm.
    EXPECT_EQ(info.extentVoxels.z, 109);
    EXPECT_NEAR(info.spacingMm().z * std::cos(lean), 1.334, 0.001);
    const auto values = readAll<std::int16_t>(*source);
    EXPECT_EQ(*std::min_element(values.begin(), values.end()), -1024); // padding of -1500 became air
}

TEST_F(RealData, EncodingsDecodeEqualOrAreSaidToBeLossyAndNothingIsPrinted) {
    const auto folder = at("ct-slice-encodings");
    const auto expected = readAll<std::int16_t>(*openSource(folder / "CTImage.dcm", {}));
    EXPECT_EQ(expected.size(), 512u * 512);
    // The largest and the mean difference in HU that the files' own encoders left.
    struct Lossy {
        std::string end;
        int largest;
        double mean;
    };
    const std::vector<Lossy> lossy = {{"4.50.dcm", 64, 19.8}, {"4.51.dcm", 36, 4},  {"4.53.dcm", 36, 4},
                                      {"4.55.dcm", 36, 4},    {"4.81.dcm", 1, 0.7}, {"4.91.dcm", 5, 0.6}};
    int same = 0;
    testing::internal::CaptureStderr();
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
        const std::string name = entry.path().filename().string();
        const auto source = openSource(entry.path(), {});
        std::vector<std::int16_t> values;
        if (source->info().type == ValueType::f32) { // 8 bits of baseline JPEG are rescaled by a fraction
            const auto scaled = readAll<float>(*source);
            std::transform(scaled.begin(), scaled.end(), std::back_inserter(values),
                           [](float v) { return static_cast<std::int16_t>(std::lround(v)); });
        } else {
            values = readAll<std::int16_t>(*source);
        }
        int largest = 0;
        double sum = 0;
        for (std::size_t i = 0; i < values.size(); ++i) {
            largest = std::max(largest, std::abs(values[i] - expected[i]));
            sum += std::abs(values[i] - expected[i]);
        }
        const auto known =
            std::find_if(lossy.begin(), lossy.end(), [&](const Lossy& l) { return name.ends_with(l.end); });
        EXPECT_EQ(source->info().lossy, known != lossy.end()) << name;
        same += largest == 0;
        if (known != lossy.end()) {
            EXPECT_LE(largest, known->largest) << name;
            EXPECT_LE(sum / static_cast<double>(values.size()), known->mean) << name;
        } else {
            EXPECT_EQ(largest, 0) << name;
        }
    }
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
    EXPECT_EQ(same, 10);
}

TEST_F(RealData, TruncatedCompressedSlicesAreRefused) {
    const ScratchFolder folder;
    testing::internal::CaptureStderr();
    for (const auto& entry : std::filesystem::directory_iterator(at("ct-slice-encodings"))) {
        for (const double part : {0.2, 0.6, 0.99}) {
            const auto cut = folder / "cut.dcm";
            std::filesystem::copy_file(entry.path(), cut, std::filesystem::copy_options::overwrite_existing);
            const auto size = static_cast<double>(std::filesystem::file_size(cut));
            std::filesystem::resize_file(cut, static_cast<std::uintmax_t>(part * size));
            const std::string message = refusal([&] {
                const auto source = openSource(cut, {});
                std::vector<std::byte> slice(512 * 512 * bytesPerValue(source->info().type));
                source->readSlices(1, slice);
            });
            EXPECT_THAT(message, HasSubstr("cut.dcm")) << entry.path().filename() << ' ' << part;
        }
    }
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST_F(RealData, MultiFrameWithoutPositionIsRefusedClearly) {
    EXPECT_THAT(refusalOfOpening(at("dicom-multiframe/emri_small.dcm")), HasSubstr("position"));
    EXPECT_THAT(refusalOfOpening(at("dicom-multiframe/emri_small_RLE.dcm")), HasSubstr("position"));
}

TEST_F(RealData, Bonsai) {
    const auto source = openSource(at("scivis/OpenSciVis/bonsai.nii.gz"), {});
    EXPECT_EQ(source->info().extentVoxels, glm::ivec3(256));
    EXPECT_EQ(source->info().type, ValueType::u8);
    EXPECT_EQ(readAll<std::uint8_t>(*source).size(), std::size_t{1} << 24);
}

TEST_F(RealData, ScaledAndObliqueNifti) {
    const auto avm = openSource(at("nifti/CT_AVM.nii.gz"), {});
    EXPECT_EQ(avm->info().extentVoxels, glm::ivec3(256, 242, 154));
    EXPECT_NEAR(avm->info().rescaleSlope, 2.2086, 1e-4);
    const auto pitch = openSource(at("nifti/CT_pitch.nii.gz"), {});
    EXPECT_EQ(pitch->info().extentVoxels, glm::ivec3(175, 248, 58));
    const glm::dvec3 z = glm::normalize(glm::dvec3(pitch->info().patientFromVoxel[2]));
    EXPECT_NEAR(std::acos(z.z) * 180 / std::acos(-1.0), 16.5, 0.5);
}

/// Every voxel of our LPS volume, looked up at its patient position in VTK's reading of the same file. VTK
/// has its own parser, its own rule for reversing slices and its own matrix, so this checks voxels and affine
/// at once.
TEST_F(RealData, NiftiAgreesWithVtk) {
    const auto path = at("nifti/CT_pitch.nii.gz");
    vtkNew<vtkNIFTIImageReader> reader;
    reader->SetFileName(path.c_str());
    reader->Update();
    vtkImageData* image = reader->GetOutput();
    ASSERT_EQ(image->GetScalarType(), VTK_UNSIGNED_CHAR);
    vtkMatrix4x4* matrix = reader->GetSFormMatrix() ? reader->GetSFormMatrix() : reader->GetQFormMatrix();
    ASSERT_NE(matrix, nullptr);
    glm::dmat4 rasFromData;
    for (int row = 0; row < 4; ++row)
        for (int column = 0; column < 4; ++column)
            rasFromData[column][row] = matrix->GetElement(row, column);
    const glm::dmat4 dataFromRas = glm::inverse(rasFromData);
    const double* spacing = image->GetSpacing();

    const auto source = openSource(path, {});
    const VolumeInfo info = source->info();
    const auto values = readAll<std::uint8_t>(*source);
    std::size_t different = 0;
    double worst = 0; // distance of a voxel centre from VTK's nearest one, in voxels
    for (int z = 0; z < info.extentVoxels.z; ++z)
        for (int y = 0; y < info.extentVoxels.y; ++y)
            for (int x = 0; x < info.extentVoxels.x; ++x) {
                const glm::dvec3 ras = centreMm(info, x, y, z) * glm::dvec3(-1, -1, 1);
                const glm::dvec4 data = dataFromRas * glm::dvec4(ras, 1);
                glm::ivec3 voxel;
                for (int axis = 0; axis < 3; ++axis) {
                    const double index = data[axis] / spacing[axis];
                    voxel[axis] = static_cast<int>(std::lround(index));
                    worst = std::max(worst, std::abs(index - voxel[axis]));
                }
                const auto* p =
                    static_cast<const std::uint8_t*>(image->GetScalarPointer(voxel.x, voxel.y, voxel.z));
                ASSERT_NE(p, nullptr);
                different += *p != values[indexOf(info, x, y, z)];
            }
    EXPECT_EQ(different, 0u);
    EXPECT_LT(worst, 1e-3); // VTK takes the spacing from pixdim, a float
}

TEST_F(RealData, ListsTheLargestFirst) {
    const auto found = listVolumes(at("ct-abdomen-dicom"));
    ASSERT_EQ(found.size(), 1u);
    EXPECT_EQ(found[0].series, 1);
    EXPECT_EQ(found[0].modality, "CT");
}

// The same volume in both formats, written by other programs.
TEST_F(RealData, AnNrrdFileIsItsNiftiTwin) {
    const auto nrrd = openSource(at("nifti-nrrd-pair/nrrd/marc_avf/avf_float_32.nrrd"), {}),
               nifti = openSource(at("nifti-nrrd-pair/nifti/marc_avf/avf_float_32.nii.gz"), {});
    ASSERT_EQ(nrrd->info().extentVoxels, nifti->info().extentVoxels);
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 3; ++row)
            EXPECT_NEAR(nrrd->info().patientFromVoxel[column][row],
                        nifti->info().patientFromVoxel[column][row], 1e-4);
    EXPECT_EQ(readAll<float>(*nrrd), readAll<float>(*nifti));
}

TEST_F(RealData, AnNrrdVolumeInNinetyThreeFiles) {
    const auto source = openSource(at("small-volumes/headsq/quarter.nhdr"), {});
    EXPECT_EQ(source->info().spacingMm(), glm::dvec3(3.2, 3.2, 1.5));
    const std::vector<std::int16_t> values = readAll<std::int16_t>(*source);
    std::vector<std::int16_t> slice(64 * 64);
    for (int z = 0; z < 93; ++z) {
        std::ifstream file(at("small-volumes/headsq/quarter." + std::to_string(z + 1)), std::ios::binary);
        file.read(reinterpret_cast<char*>(slice.data()), static_cast<std::streamsize>(2 * slice.size()));
        ASSERT_TRUE(file);
        EXPECT_TRUE(std::equal(slice.begin(), slice.end(), values.begin() + z * 64 * 64)) << z;
    }
}

} // namespace
} // namespace tessera::test
