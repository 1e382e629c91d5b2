// tests/bricking/import/files/nifti_test.cpp: NIfTI: types, scaling, byte orders, and every lie refused with
// the file named, before anything of its size is allocated.
#include "bricking/import/files/nifti/nifti.h"
#include "tests/support/import_test_tools.h"

#include <array>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <gmock/gmock.h>
#include <limits>
#include <random>

namespace tessera::test {
namespace {

using ::testing::HasSubstr;

/// Identity in LPS, so that voxels come out as they are written.
constexpr std::array<double, 12> kLps = {-1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1, 0};

template <class In, class Out>
void expectType(std::int16_t code, const std::vector<In>& in, const std::vector<Out>& out) {
    const ScratchFolder folder;
    for (const bool big : {false, true}) {
        for (const int version : {1, 2}) {
            NiftiImage image;
            image.extent = {static_cast<std::int64_t>(in.size()), 1, 1};
            image.datatype = code;
            image.srow = kLps;
            image.bigEndian = big;
            image.version = version;
            image.voxels = voxelBytes(in, big);
            writeFile(folder / "a.nii", niftiBytes(image));
            const auto source = openSource(folder / "a.nii", {});
            EXPECT_EQ(readAll<Out>(*source), out)
                << "datatype " << code << (big ? " big" : " little") << " v" << version;
            EXPECT_EQ(source->info().unit, "");
        }
    }
}

TEST(ImportNifti, EveryNumberTypeInBothByteOrdersAndVersions) {
    expectType<std::uint8_t, std::uint8_t>(2, {0, 1, 255}, {0, 1, 255});
    expectType<std::int8_t, std::int16_t>(256, {-128, 0, 127}, {-128, 0, 127});
    expectType<std::int16_t, std::int16_t>(4, {-32768, -1, 32767}, {-32768, -1, 32767});
    expectType<std::uint16_t, std::uint16_t>(512, {0, 258, 65535}, {0, 258, 65535});
    expectType<std::int32_t, float>(8, {-70000, 3, 16777216}, {-70000, 3, 16777216});
    expectType<std::uint32_t, float>(768, {0, 3, 4294967040u}, {0, 3, 4294967040.f});
    expectType<float, float>(16, {-0.5f, 1e-30f, 3e38f}, {-0.5f, 1e-30f, 3e38f});
    expectType<double, float>(64, {-0.5, 1.0 / 3, 2e5}, {-0.5f, static_cast<float>(1.0 / 3), 2e5f});
}

// NaN became 0, which is water in a CT: an opaque slab around every masked scan.
TEST(ImportNifti, AbsentVoxelsBecomeTheLowestValueOfTheData) {
    const ScratchFolder folder;
    const double inf = std::numeric_limits<double>::infinity(), nan = std::nan("");
    NiftiImage image;
    image.extent = {3, 1, 3}; // the lowest value comes after the first absent voxel, in another slice
    image.datatype = 64;
    image.srow = kLps;
    image.voxels = voxelBytes<double>({7, 1, 2, nan, inf, 1, -inf, -1000, 3});
    writeFile(folder / "a.nii", niftiBytes(image));
    writeFile(folder / "a.nii.gz", gzip(niftiBytes(image)));
    for (const char* name : {"a.nii", "a.nii.gz"}) {
        const auto source = openSource(folder / name, {});
        EXPECT_EQ(readAll<float>(*source), (std::vector<float>{7, 1, 2, -1000, -1000, 1, -1000, -1000, 3}));
        EXPECT_EQ(source->info().nonFiniteVoxels, 3u);
        EXPECT_EQ(source->info().absentStored, -1000);
    }
    image.slope = -2; // the lowest physical value is the highest stored one
    writeFile(folder / "a.nii", niftiBytes(image));
    const auto source = openSource(folder / "a.nii", {});
    EXPECT_EQ(readAll<float>(*source)[3], 7.f);
    // Nothing but NaN, beyond float32, and both.
    image.slope = 0;
    image.voxels = voxelBytes<double>(std::vector<double>(9, nan));
    writeFile(folder / "a.nii", niftiBytes(image));
    EXPECT_EQ(readAll<float>(*openSource(folder / "a.nii", {})), std::vector<float>(9, 0));
    image.voxels = voxelBytes<double>({7, 1, 2, nan, 1e300, 1, -1e300, -1000, 3});
    writeFile(folder / "a.nii", niftiBytes(image));
    const auto huge = openSource(folder / "a.nii", {});
    const float most = std::numeric_limits<float>::max();
    EXPECT_EQ(readAll<float>(*huge), (std::vector<float>{7, 1, 2, -most, most, 1, -most, -1000, 3}));
    EXPECT_EQ(huge->info().clampedVoxels, 2u);
    EXPECT_THAT(huge->describe(), HasSubstr("converted to float32"));
}

TEST(ImportNifti, SlopeZeroMeansNotScaled) {
    const ScratchFolder folder;
    NiftiImage image;
    image.voxels = std::string(48, '\0');
    image.intercept = 5;
    writeFile(folder / "a.nii", niftiBytes(image));
    EXPECT_EQ(openSource(folder / "a.nii", {})->info().rescaleSlope, 1);
    EXPECT_EQ(openSource(folder / "a.nii", {})->info().rescaleIntercept, 0);
    image.slope = 2.5;
    writeFile(folder / "a.nii", niftiBytes(image));
    EXPECT_EQ(openSource(folder / "a.nii", {})->info().rescaleSlope, 2.5);
    EXPECT_EQ(openSource(folder / "a.nii", {})->info().rescaleIntercept, 5);
}

TEST(ImportNifti, QformAndUnits) {
    const ScratchFolder folder;
    NiftiImage image;
    image.voxels = std::string(48, '\0');
    std::string bytes = niftiBytes(image);
    put<std::int16_t>(bytes, 254, 0); // no sform
    put<std::int16_t>(bytes, 252, 1); // qform: a half turn about z gives LPS axes
    put(bytes, 264, 1.f);             // quatern_d
    put(bytes, 76, -1.f);             // qfac: z reversed
    put(bytes, 84, 3.f);              // pixdim[2]
    put(bytes, 268, 7.f);             // qoffset_x, RAS
    writeFile(folder / "a.nii", bytes);
    VolumeInfo info = openSource(folder / "a.nii", {})->info();
    EXPECT_EQ(info.originalOrder.flipped, (std::array{false, false, true}));
    EXPECT_EQ(info.spacingMm(), glm::dvec3(1, 3, 1));
    EXPECT_EQ(firstVoxelCentreMm(info), glm::dvec3(-7, 0, -3)); // z: 4 slices downwards from 0
    bytes[123] = 1;                                             // metres
    writeFile(folder / "a.nii", bytes);
    EXPECT_EQ(openSource(folder / "a.nii", {})->info().spacingMm(), glm::dvec3(1000, 3000, 1000));
    put<std::int16_t>(bytes, 252, 0); // spacing only: the format's RAS axes
    bytes[123] = 2;
    writeFile(folder / "a.nii", bytes);
    EXPECT_EQ(openSource(folder / "a.nii", {})->info().originalOrder.flipped,
              (std::array{true, true, false}));
    EXPECT_TRUE(info.orientationKnown);
    EXPECT_FALSE(openSource(folder / "a.nii", {})->info().orientationKnown);
}

// The unit of time stands in the same byte, in its higher bits.
TEST(ImportNifti, LengthsAreReadBesideAUnitOfTime) {
    NiftiImage image;
    image.srow = {-1, 0, 0, 7, 0, -1, 0, 0, 0, 0, 1, 0};
    std::string bytes = niftiBytes(image);
    constexpr int kSeconds = 8, kMicroseconds = 24;
    for (const auto& [units, mm] : std::vector<std::pair<int, double>>{
             {1, 1000}, {1 | kSeconds, 1000}, {2 | kSeconds, 1}, {3, 1e-3}, {3 | kMicroseconds, 1e-3}}) {
        bytes[123] = static_cast<char>(units);
        const VolumeInfo info = parseNiftiHeader(std::as_bytes(std::span(bytes)), "a.nii").info;
        EXPECT_EQ(info.spacingMm(), glm::dvec3(mm)) << units;
        EXPECT_NEAR(firstVoxelCentreMm(info).x, -7 * mm, 1e-9 * mm) << units;
    }
}

// Both are there: the sform is meant. The qform turns by 60 degrees about z, in RAS.
TEST(ImportNifti, AnObliqueQformTurnsTheRightWayAndGivesWayToAnSform) {
    NiftiImage image;
    std::string bytes = niftiBytes(image);
    put<std::int16_t>(bytes, 252, 1);
    put(bytes, 264, 0.5f); // sin(30 degrees)
    const auto stepX = [&] {
        return glm::dvec3(
            parseNiftiHeader(std::as_bytes(std::span(bytes)), "a.nii").info.patientFromVoxel[0]);
    };
    EXPECT_EQ(stepX(), glm::dvec3(-1, 0, 0));
    put<std::int16_t>(bytes, 254, 0); // no sform
    EXPECT_LT(glm::length(stepX() - glm::dvec3(-0.5, -std::sqrt(0.75), 0)), 1e-6);
}

// Any quaternion, beside spacings and an origin of three values: in RAS, by a rotation of another library.
TEST(ImportNifti, EveryQformIsTheRotationOfItsQuaternion) {
    std::mt19937 random(11);
    std::uniform_real_distribution<double> any(-1, 1);
    const glm::dvec3 toLps(-1, -1, 1), spacing(0.5, 0.75, 1.25), origin(3, -5, 7);
    for (int n = 0; n < 40; ++n) {
        const int version = 1 + n % 2;
        glm::dquat q = glm::normalize(glm::dquat(any(random), any(random), any(random), any(random)));
        if (n < 3) // a half turn about each axis
            q = glm::dquat(0, n == 0, n == 1, n == 2);
        if (q.w < 0)
            q = -q; // the file has the other three numbers
        const double qfac = n % 3 == 0 ? -1 : 1;
        NiftiImage image;
        image.version = version;
        std::string bytes = niftiBytes(image);
        const auto putReal = [&](std::size_t at1, std::size_t at2, std::size_t i, double value) {
            version == 1 ? put(bytes, at1 + 4 * i, static_cast<float>(value))
                         : put(bytes, at2 + 8 * i, value);
        };
        if (version == 1)
            put<std::int16_t>(bytes, 252, 1), put<std::int16_t>(bytes, 254, 0);
        else
            put<std::int32_t>(bytes, 344, 1), put<std::int32_t>(bytes, 348, 0);
        const glm::dvec3 vector(q.x, q.y, q.z);
        putReal(76, 104, 0, qfac);
        for (int i = 0; i < 3; ++i) {
            const auto at = static_cast<std::size_t>(i);
            putReal(76, 104, at + 1, spacing[i]);
            putReal(256, 352, at, vector[i]);
            putReal(268, 376, at, origin[i]);
        }
        const VolumeInfo info = parseNiftiHeader(std::as_bytes(std::span(bytes)), "a.nii").info;
        EXPECT_TRUE(info.orientationKnown);
        const glm::dmat3 turn = glm::mat3_cast(q);
        EXPECT_LT(glm::length(firstVoxelCentreMm(info) - toLps * origin), 1e-6) << n;
        for (int axis = 0; axis < 3; ++axis) {
            const glm::dvec3 step = toLps * turn[axis] * spacing[axis] * (axis == 2 ? qfac : 1);
            EXPECT_LT(glm::length(glm::dvec3(info.patientFromVoxel[axis]) - step), 3e-6) << n << ", " << axis;
        }
    }
}

// Quaternions that rounding made a little longer than one are half turns; longer ones are lies.
TEST(ImportNifti, QuaternionsAreAHundredthLongerThanOneAtMost) {
    NiftiImage image;
    std::string bytes = niftiBytes(image);
    put<std::int16_t>(bytes, 252, 1), put<std::int16_t>(bytes, 254, 0);
    put(bytes, 260, 1.009f); // quatern_c
    const VolumeInfo info = parseNiftiHeader(std::as_bytes(std::span(bytes)), "a.nii").info;
    EXPECT_LT(glm::length(glm::dvec3(info.patientFromVoxel[0]) - glm::dvec3(1, 0, 0)), 1e-6);
    EXPECT_LT(glm::length(glm::dvec3(info.patientFromVoxel[1]) - glm::dvec3(0, -1, 0)), 1e-6);
    put(bytes, 260, 1.015f);
    EXPECT_THAT(refusal([&] { parseNiftiHeader(std::as_bytes(std::span(bytes)), "a.nii"); }),
                HasSubstr("length 1.015"));
}

// The first byte that voxels may begin at, and the last one that they need.
TEST(ImportNifti, OffsetsFromTheHeadersEndOn) {
    const ScratchFolder folder;
    for (const int version : {1, 2}) {
        const double header = version == 1 ? 348 : 540;
        const auto opened = [&](double offset, std::size_t size) -> std::string {
            NiftiImage image;
            image.version = version;
            image.datatype = 2;
            image.voxels = std::string(64, '\0');
            std::string bytes = niftiBytes(image);
            if (version == 1)
                put(bytes, 108, static_cast<float>(offset));
            else
                put(bytes, 168, static_cast<std::int64_t>(offset));
            bytes.resize(size);
            writeFile(folder / "a.nii", bytes);
            try {
                openSource(folder / "a.nii", {});
                return "";
            } catch (const InputError& error) {
                return error.what();
            }
        };
        const auto end = static_cast<std::size_t>(header) + 24; // of voxels behind the header
        EXPECT_EQ(opened(header + 4, end + 4), "");
        EXPECT_EQ(opened(0, end + 4), "") << "as if it said so";
        EXPECT_EQ(opened(header, end), "") << "without the four bytes of extensions";
        EXPECT_EQ(opened(header + 5, end + 5), "");
        for (const double offset : {1., header - 1, header + 1, header + 3})
            EXPECT_THAT(opened(offset, end + 4), HasSubstr("vox_offset " + std::to_string(offset)))
                << version;
        EXPECT_THAT(opened(header + 4, end + 3),
                    ::testing::EndsWith("expected " + std::to_string(end + 4) +
                                        " bytes for 2 x 3 x 4 voxels of uint8, found at most " +
                                        std::to_string(end + 3) + " bytes"));
        EXPECT_EQ(opened(header + 4, end + 5), "") << "less than a row more";
        EXPECT_THAT(opened(header + 4, end + 6), HasSubstr("2 bytes more, 1 rows"));
    }
}

// Values stay below 1e12, whatever the type has; of more than 24 bits a float has as many.
TEST(ImportNifti, SlopesByTheTypesLargestNumber) {
    const auto isTaken = [](std::int16_t datatype, double slope, double intercept) {
        NiftiImage image;
        image.version = 2; // of doubles
        image.datatype = datatype, image.slope = slope, image.intercept = intercept;
        const std::string bytes = niftiBytes(image);
        try {
            parseNiftiHeader(std::as_bytes(std::span(bytes)), "a.nii");
            return true;
        } catch (const InputError&) {
            return false;
        }
    };
    for (const auto& [types, bits] : std::vector<std::pair<std::vector<std::int16_t>, int>>{
             {{2, 256}, 8}, {{4, 512}, 16}, {{8, 768, 1024, 1280}, 24}, {{16, 64}, 0}})
        for (const std::int16_t type : types) {
            const double most = std::ldexp(1e12, -bits);
            EXPECT_TRUE(isTaken(type, 0.999 * most, 0)) << type;
            EXPECT_FALSE(isTaken(type, 1.001 * most, 0)) << type;
            EXPECT_FALSE(isTaken(type, -1.001 * most, 0)) << type;
            EXPECT_EQ(isTaken(type, 1e-6, 100), bits == 0) << type << ": a float tells them apart";
        }
}

TEST(ImportNifti, UpToSevenDimensionsOfOne) {
    const ScratchFolder folder;
    const auto opened = [&](std::int16_t rank, std::vector<std::int16_t> sizes) -> std::string {
        NiftiImage image;
        image.datatype = 2;
        std::size_t voxels = 1;
        for (std::size_t i = 0; i < 3; ++i)
            voxels *=
                i < static_cast<std::size_t>(rank) ? static_cast<std::size_t>(std::max<int>(sizes[i], 1)) : 1;
        image.voxels = std::string(voxels, '\0');
        std::string bytes = niftiBytes(image);
        put(bytes, 40, rank);
        for (std::size_t i = 0; i < 7; ++i)
            put(bytes, 42 + 2 * i, sizes[i]);
        writeFile(folder / "a.nii", bytes);
        try {
            const glm::ivec3 extent = openSource(folder / "a.nii", {})->info().extentVoxels;
            return std::to_string(extent.x) + "x" + std::to_string(extent.y) + "x" + std::to_string(extent.z);
        } catch (const InputError& error) {
            return error.what();
        }
    };
    EXPECT_EQ(opened(3, {4, 3, 2, 9, 9, 9, 9}), "4x3x2");
    EXPECT_EQ(opened(2, {4, 3, 9, 9, 9, 9, 9}), "4x3x1");
    EXPECT_EQ(opened(1, {4, 9, 9, 9, 9, 9, 9}), "4x1x1");
    EXPECT_EQ(opened(7, {4, 3, 2, 1, 0, 1, 1}), "4x3x2");
    EXPECT_THAT(opened(7, {4, 3, 2, 1, 1, 1, 2}), HasSubstr("dim[7] = 2"));
    EXPECT_THAT(opened(0, {4, 3, 2, 1, 1, 1, 1}), HasSubstr("1 to 7 dimensions, found 0"));
    EXPECT_THAT(opened(8, {4, 3, 2, 1, 1, 1, 1}), HasSubstr("1 to 7 dimensions, found 8"));
}

// Counts made while a volume is read are reported of one that is turned around, too.
TEST(ImportNifti, CountsComeThroughTheTurningToLps) {
    const ScratchFolder folder;
    NiftiImage image;
    image.datatype = 64;
    image.voxels = voxelBytes(std::vector<double>(24, 1e300));
    writeFile(folder / "a.nii", niftiBytes(image));
    const auto source = openSource(folder / "a.nii", {});
    readAll<float>(*source);
    EXPECT_EQ(source->info().originalOrder.flipped, (std::array{true, true, false}));
    EXPECT_EQ(source->info().clampedVoxels, 24u);
}

// Voxels begin where the header says, behind its extensions; a second reading, for the lowest value, too.
TEST(ImportNifti, ExtensionsAreNoVoxels) {
    const ScratchFolder folder;
    NiftiImage image;
    image.extent = {3, 1, 1};
    image.datatype = 16;
    image.srow = kLps;
    image.voxels = std::string(32, '\xf0') + voxelBytes<float>({std::nanf(""), -3, 5});
    std::string bytes = niftiBytes(image);
    put(bytes, 108, 384.f);
    writeFile(folder / "a.nii", bytes);
    writeFile(folder / "a.nii.gz", gzip(bytes));
    for (const char* name : {"a.nii", "a.nii.gz"})
        EXPECT_EQ(readAll<float>(*openSource(folder / name, {})), (std::vector<float>{-3, -3, 5})) << name;
}

TEST(ImportNifti, TrailingBytesAreTolerated) {
    const ScratchFolder folder;
    NiftiImage image;
    image.srow = kLps;
    image.extent = {4, 3, 2};
    image.voxels = std::string(48, '\1') + "more"; // less than a row
    writeFile(folder / "a.nii", niftiBytes(image));
    writeFile(folder / "a.nii.gz", gzip(niftiBytes(image)) + "trailing");
    EXPECT_EQ(readAll<std::int16_t>(*openSource(folder / "a.nii", {})), std::vector<std::int16_t>(24, 257));
    EXPECT_EQ(readAll<std::int16_t>(*openSource(folder / "a.nii.gz", {})),
              std::vector<std::int16_t>(24, 257));
}

// A flipped bit in a dimension or the type gave shifted rows, lost slices or bytes of words, without a word.
TEST(ImportNifti, HeadersThatContradictTheFileAreRefused) {
    const ScratchFolder folder;
    NiftiImage sound;
    sound.srow = kLps;
    sound.extent = {8, 9, 10};
    sound.voxels = std::string(2 * 8 * 9 * 10, '\1');
    const auto expect = [&](const auto& change, const char* word) {
        NiftiImage image = sound;
        change(image);
        for (const bool packed : {false, true}) {
            const auto path = folder / (packed ? "a.nii.gz" : "a.nii");
            writeFile(path, packed ? gzip(niftiBytes(image)) : niftiBytes(image));
            EXPECT_THAT(refusal([&] {
                            const auto source = openSource(path, {});
                            const VolumeInfo info = source->info();
                            std::vector<std::byte> all(info.voxelCount() * bytesPerValue(info.type));
                            source->readSlices(info.extentVoxels.z, all);
                        }),
                        HasSubstr(word))
                << packed;
        }
    };
    expect([](NiftiImage& i) { i.datatype = 2, i.bitpix = 16; }, "bitpix 8 for uint8");
    expect([](NiftiImage& i) { i.extent[0] = 7; }, "rows");
    expect([](NiftiImage& i) { i.extent[1] = 8; }, "rows");
    expect([](NiftiImage& i) { i.extent[2] = 9; }, "found 144 bytes more, 9 rows");
    expect([](NiftiImage& i) { i.voxels += i.voxels; }, "90 rows"); // two volumes
    expect([](NiftiImage& i) { i.voxels += std::string(2 * 8, '\1'); }, "found 16 bytes more, 1 rows");
    std::string early = niftiBytes(sound);
    put(early, 108, 351.f);
    writeFile(folder / "a.nii", early);
    EXPECT_THAT(refusalOfOpening(folder / "a.nii"), HasSubstr("vox_offset 351"));
}

TEST(ImportNifti, WholeNumbersThatFloatCannotHoldAreCounted) {
    const ScratchFolder folder;
    NiftiImage image;
    image.extent = {3, 1, 1};
    image.srow = kLps;
    image.datatype = 1024;
    image.voxels = voxelBytes<std::int64_t>({5, (1 << 24) + 1, std::int64_t{1} << 40});
    writeFile(folder / "a.nii", niftiBytes(image));
    writeFile(folder / "a.nii.gz", gzip(niftiBytes(image)));
    for (const char* name : {"a.nii", "a.nii.gz"}) {
        const auto source = openSource(folder / name, {});
        readAll<float>(*source);
        EXPECT_THAT(source->takeTally().notes(),
                    testing::ElementsAre(HasSubstr("1 whole numbers beyond 2^24")));
    }
    image.datatype = 8;
    image.voxels = voxelBytes<std::int32_t>({(1 << 24) + 1, (1 << 24) + 2, -(1 << 24) - 1});
    writeFile(folder / "a.nii", niftiBytes(image));
    const auto source = openSource(folder / "a.nii", {});
    readAll<float>(*source);
    EXPECT_THAT(source->takeTally().notes(), testing::ElementsAre(HasSubstr("2 whole numbers beyond 2^24")));
}

TEST(ImportNifti, DoublesThatFloatCannotHoldAreToldOfAndOthersAreNot) {
    const ScratchFolder folder;
    NiftiImage image;
    image.extent = {3, 1, 1};
    image.srow = kLps;
    image.datatype = 64;
    const auto notes = [&](const std::vector<double>& values) {
        image.voxels = voxelBytes(values);
        writeFile(folder / "a.nii", niftiBytes(image));
        const auto source = openSource(folder / "a.nii", {});
        readAll<float>(*source);
        return source->takeTally().notes();
    };
    EXPECT_THAT(notes({5, 0.1, 1e9 + 0.5}), testing::ElementsAre(HasSubstr("which changed 2 of them")));
    EXPECT_THAT(notes({5, -0.125, 1e9}), testing::IsEmpty());
}

TEST(ImportNifti, EveryTruncationIsRefusedWithTheFileNamed) {
    const ScratchFolder folder;
    NiftiImage image;
    image.srow = kLps;
    image.voxels = std::string(48, '\1');
    const std::string whole = niftiBytes(image), packed = gzip(whole);
    for (std::size_t n = 0; n < whole.size(); n += n < 340 ? 20 : 1) {
        writeFile(folder / "cut.nii", whole.substr(0, n));
        ASSERT_THAT(refusalOfOpening(folder / "cut.nii"), HasSubstr("cut.nii")) << n;
    }
    for (std::size_t n = 0; n < packed.size(); ++n) {
        writeFile(folder / "cut.nii.gz", packed.substr(0, n));
        ASSERT_THAT(refusal([&] { readAll<std::int16_t>(*openSource(folder / "cut.nii.gz", {})); }),
                    HasSubstr("cut.nii.gz"))
            << n;
    }
    std::string damaged = packed;
    damaged[packed.size() - 6] ^= 1; // the checksum
    writeFile(folder / "cut.nii.gz", damaged);
    EXPECT_THAT(refusal([&] { readAll<std::int16_t>(*openSource(folder / "cut.nii.gz", {})); }),
                HasSubstr("damage"));
}

TEST(ImportNifti, LyingHeadersAreRefused) {
    const ScratchFolder folder;
    NiftiImage image;
    image.voxels = std::string(48, '\0');
    const auto refusedWith = [&](auto change, const char* expected, int version = 1) {
        image.version = version;
        std::string bytes = niftiBytes(image);
        change(bytes);
        for (const bool compressed : {false, true}) {
            const auto path = folder / (compressed ? "lie.nii.gz" : "lie.nii");
            writeFile(path, compressed ? gzip(bytes) : bytes);
            const std::string message = refusalOfOpening(path);
            EXPECT_THAT(message, HasSubstr("lie.nii"));
            EXPECT_THAT(message, HasSubstr(expected));
        }
    };
    refusedWith([](std::string& b) { put<std::int16_t>(b, 42, 32767), put<std::int16_t>(b, 44, 32767); },
                "bytes");
    refusedWith([](std::string& b) { put<std::int64_t>(b, 24, std::int64_t{1} << 62); }, "dim[1]", 2);
    refusedWith(
        [](std::string& b) {
            for (std::size_t at : {24u, 32u, 40u})
                put<std::int64_t>(b, at, 2147483647);
        },
        "2^62", 2);
    refusedWith([](std::string& b) { put<std::int16_t>(b, 42, 0); }, "dim[1]");
    refusedWith([](std::string& b) { put<std::int16_t>(b, 42, -5); }, "dim[1]");
    refusedWith([](std::string& b) { put<std::int16_t>(b, 40, 9); }, "dimensions");
    refusedWith(
        [](std::string& b) {
            put<std::int16_t>(b, 40, 5), put<std::int16_t>(b, 48, 1), put<std::int16_t>(b, 50, 2);
        },
        "dim[5]");
    refusedWith([](std::string& b) { put<std::int16_t>(b, 70, 128); }, "datatype 128"); // RGB
    refusedWith([](std::string& b) { put(b, 108, 1e30f); }, "vox_offset");
    refusedWith([](std::string& b) { put(b, 108, -3.f); }, "vox_offset");
    refusedWith([](std::string& b) { put(b, 280, std::nanf("")); }, "spacing");
    refusedWith([](std::string& b) { b.replace(280, 48, std::string(48, '\0')); }, "spacing");
    refusedWith([](std::string& b) { put<std::int16_t>(b, 254, 0), put(b, 80, 0.f); }, "pixdim[1]");
    refusedWith([](std::string& b) { put<std::int16_t>(b, 254, 0), put(b, 84, -1.f); }, "pixdim[2]");
    refusedWith([](std::string& b) { b.replace(344, 3, "ni1"); }, "detached");
    refusedWith([](std::string& b) { b.replace(0, 4, "text"); }, "NIfTI");
}

TEST(ImportNifti, DamagedHeaderBytesNeverDoWorseThanAnError) {
    const ScratchFolder folder;
    NiftiImage image;
    image.voxels = std::string(48, '\1');
    std::mt19937 random(4711);
    for (int n = 0; n < 600; ++n) {
        image.version = 1 + n % 2;
        std::string bytes = niftiBytes(image);
        const std::size_t at = random() % 348;
        for (std::size_t i = at; i < at + 1 + random() % 4; ++i)
            bytes[i] = static_cast<char>(random());
        const bool compressed = n % 4 >= 2;
        const auto path = folder / (compressed ? "d.nii.gz" : "d.nii");
        writeFile(path, compressed ? gzip(bytes) : bytes);
        try {
            const auto source = openSource(path, {});
            ASSERT_LT(source->info().voxelCount(), 1u << 20);
            std::vector<std::byte> out(bytesPerValue(source->info().type) * source->info().voxelCount());
            source->readSlices(source->info().extentVoxels.z, out);
        } catch (const InputError&) {
        }
    }
}

} // namespace
} // namespace tessera::test
