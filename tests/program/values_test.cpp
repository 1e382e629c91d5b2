// tests/program/values_test.cpp: from outside, what the program says of values that are not what they seem:
// without a unit, without a number, compressed with loss, against their own tags.
#include "tests/support/dicom_writer.h"
#include "tests/support/import_test_tools.h"
#include "tests/support/program_fixture.h"
#include "tests/support/stream_writer.h"

#include <nlohmann/json.hpp>

namespace tessera::test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

class Values : public Program {
  protected:
    /// A body of 40 in air of -1000, with some bone, as float32.
    void writeHuNifti(const std::string& name, float outside = -1000) {
        NiftiImage image;
        image.extent = {20, 20, 20};
        image.datatype = 16;
        image.bitpix = 32;
        for (int z = 0; z < 20; ++z)
            for (int y = 0; y < 20; ++y)
                for (int x = 0; x < 20; ++x) {
                    const double r = std::hypot(x - 9.5, y - 9.5, z - 9.5);
                    const float value = r > 9 ? outside : r > 8 ? -950.f : r > 3 ? 40.f : 900.f;
                    image.voxels.append(reinterpret_cast<const char*>(&value), sizeof value);
                }
        writeFile(folder_ / name, niftiBytes(image));
    }
    /// A ball of 400 HU, radius 60 mm, that lies on a plate at its back.
    void writeBallOnPlate(const std::string& name, float air) {
        NiftiImage image;
        image.extent = {48, 48, 48};
        image.datatype = 16;
        image.srow = {-4, 0, 0, 94, 0, -4, 0, 94, 0, 0, 4, -94}; // RAS, so that x and y are DICOM's
        for (int z = 0; z < 48; ++z)
            for (int y = 0; y < 48; ++y)
                for (int x = 0; x < 48; ++x) {
                    const double r = 4 * std::hypot(x - 23.5, y - 23.5, z - 23.5);
                    const float value = r < 60 || y == 39 || y == 40 ? 400 : air;
                    image.voxels.append(reinterpret_cast<const char*>(&value), sizeof value);
                }
        writeFile(folder_ / name, niftiBytes(image));
    }
};

// The table goes, the picture is filled by the patient, and the scene keeps the box that was found.
TEST_F(Values, CropToTheBody) {
    writeBallOnPlate("ct.nii", -1000);
    const std::string small = " --engine mirror --size 32x32 --verify none --json";
    const Outcome outcome = run("render ct.nii -o a.png --crop body --view left" + small);
    ASSERT_EQ(outcome.exitCode, 0) << outcome.problems;
    EXPECT_THAT(outcome.problems, HasSubstr("--crop body: x -"));
    EXPECT_THAT(outcome.problems, HasSubstr("left out"));
    const auto scene = nlohmann::json::parse(outcome.out)["scene"];
    ASSERT_EQ(scene["cuts"]["boxes"].size(), 1u);
    const auto& box = scene["cuts"]["boxes"][0];
    for (int axis = 0; axis < 3; ++axis) {
        EXPECT_NEAR(box["low"][axis].get<double>(), -60, 6) << axis;
        // Below, the box may hold the 8 mm of the plate where the ball touches it.
        EXPECT_NEAR(box["high"][axis].get<double>(), axis == 1 ? 64 : 60, axis == 1 ? 8 : 6) << axis;
    }
    // The same box by its numbers, and the same picture; without a cut another.
    std::string numbers;
    for (int axis = 0; axis < 3; ++axis)
        numbers += (axis ? "," : "") + box["low"][axis].dump() + "," + box["high"][axis].dump();
    ASSERT_EQ(run("render ct.nii -o b.png --fit kept --view left --crop=" + numbers + small).exitCode, 0);
    ASSERT_EQ(run("render ct.nii -o c.png --view left" + small).exitCode, 0);
    EXPECT_EQ(readAll(folder_ / "a.png"), readAll(folder_ / "b.png"));
    EXPECT_NE(readAll(folder_ / "a.png"), readAll(folder_ / "c.png"));
    expectRefused("render ct.nii -o a.png --crop patient", {"--crop", "body", "X0,X1", "patient"});
    writeBallOnPlate("mr.nii", 0);
    expectRefused("-q render mr.nii -o a.png --crop body", {"--crop body", "HU", "--unit HU"});
}

// Of several volumes the box holds the bodies of all that are visible and in HU.
TEST_F(Values, CropToTheBodiesOfSeveralVolumes) {
    writeBallOnPlate("ct.nii", -1000);
    writeBallOnPlate("mr.nii", 0);
    const auto highX = [&](const std::string& volumes) {
        const Outcome outcome =
            run("render " + volumes +
                " -o a.png --crop body --view left --engine mirror --size 16x16 --verify none --json");
        EXPECT_EQ(outcome.exitCode, 0) << outcome.problems;
        const auto scene = nlohmann::json::parse(outcome.out)["scene"];
        return scene["cuts"]["boxes"][0]["high"][0].get<double>();
    };
    const std::string moved = " --add ct.nii --set volumes[1].transform=[1,0,0,100,0,1,0,0,0,0,1,0]";
    EXPECT_NEAR(highX("ct.nii" + moved), 160, 6);
    EXPECT_NEAR(highX("ct.nii" + moved + " --set volumes[1].opacity=0"), 60, 6);
    EXPECT_NEAR(highX("mr.nii --preset auto" + moved), 160, 6) << "the first has no body";
}

// A CT converter writes HU and cannot say so: every preset but "auto" was refused.
TEST_F(Values, PresetsTakeWhatLooksLikeHuAndSayIt) {
    writeHuNifti("ct.nii");
    const std::string render = " -o a.png --engine mirror --size 16x16";
    Outcome outcome = run("render ct.nii --preset bone" + render);
    EXPECT_EQ(outcome.exitCode, 0) << outcome.problems;
    EXPECT_THAT(outcome.problems, HasSubstr("look like HU"));
    outcome = run("render ct.nii --preset bone --unit HU" + render);
    EXPECT_EQ(outcome.exitCode, 0) << outcome.problems;
    EXPECT_THAT(outcome.problems, Not(HasSubstr("look like HU")));
    expectRefused("render ct.nii --unit mm -o a.png", {"--unit", "HU", "mm"});
    EXPECT_EQ(run("import ct.nii ct.zarr --unit HU").exitCode, 0);
    EXPECT_THAT(run("info ct.zarr").out, HasSubstr("HU"));
    EXPECT_EQ(run("phantom sphere --size 16x16x16 -o s.zarr").exitCode, 0);
}

TEST_F(Values, AStoresNameMayEndInASlash) { // as shells complete it
    writeHuNifti("ct.nii");
    EXPECT_EQ(run("import ct.nii ct.zarr/").exitCode, 0);
    EXPECT_TRUE(exists("ct.zarr/zarr.json"));
    EXPECT_EQ(run("import ct.nii ct.zarr/ --force").exitCode, 0);
    EXPECT_EQ(run("info ct.zarr/").exitCode, 0);
}

TEST_F(Values, AbsentVoxelsAreSaidAndRecorded) {
    writeHuNifti("masked.nii", std::nanf(""));
    const Outcome outcome = run("import masked.nii m.zarr");
    EXPECT_EQ(outcome.exitCode, 0);
    EXPECT_THAT(outcome.problems, HasSubstr("voxels without a number"));
    EXPECT_THAT(outcome.problems, HasSubstr("-950"));
    EXPECT_THAT(run("info m.zarr").out, HasSubstr("voxels without a number"));
    const auto info = nlohmann::json::parse(run("info m.zarr --json").out);
    EXPECT_GT(info["nonFiniteVoxels"], 1000);
    EXPECT_EQ(info["absentStored"], -950);
    EXPECT_EQ(info["lowest"], -950);
}

TEST_F(Values, LossAndDisagreementAreSaidAtImportInInfoAndInTheStore) {
    fs::create_directories(folder_ / "ct");
    std::vector<std::int32_t> values(16 * 16);
    for (std::size_t i = 0; i < values.size(); ++i)
        values[i] = static_cast<std::int32_t>(i * 9);
    for (int z = 0; z < 4; ++z) {
        DicomImage image;
        image.columns = image.rows = 16;
        image.bitsStored = 12;
        image.pixelRepresentation = 0;
        image.position = glm::dvec3(0, 0, z);
        image.syntax = "1.2.840.10008.1.2.4.91";
        image.lossy = "01";
        image.lossyRatio = "7.25";
        image.fragments = {
            encodeJpeg2000(values, 16, 16, {.bits = 16, .isSigned = true, .reversible = false})};
        writeDicom(folder_ / "ct" / ("IM" + std::to_string(z)), image);
    }
    const Outcome outcome = run("import ct ct.zarr");
    EXPECT_EQ(outcome.exitCode, 0) << outcome.problems;
    EXPECT_THAT(outcome.problems, HasSubstr("with loss, ratio 7.25"));
    const std::string said = "the compressed stream says signed 16 bits, the tags say unsigned 12 bits";
    const std::size_t at = outcome.problems.find(said);
    EXPECT_NE(at, std::string::npos) << outcome.problems;
    EXPECT_EQ(outcome.problems.find(said, at + 1), std::string::npos) << "said twice";
    for (const char* input : {"ct", "ct.zarr"}) {
        EXPECT_THAT(run(std::string("info ") + input).out, HasSubstr("with loss, ratio 7.25"));
        const auto info = nlohmann::json::parse(run(std::string("info --json ") + input).out);
        const auto& volume = info.contains("volumes") ? info["volumes"][0] : info;
        EXPECT_EQ(volume["lossy"], true);
        EXPECT_EQ(volume["lossyRatio"], 7.25);
    }
    EXPECT_EQ(run("-q import ct quiet.zarr").problems, "");
}

} // namespace
} // namespace tessera::test
