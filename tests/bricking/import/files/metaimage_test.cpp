// tests/bricking/import/files/metaimage_test.cpp: volumes in MetaImage files that the test writes: types,
// codings, places, VTK's reader as a second one, and every lie refused.
#include "tests/support/import_test_tools.h"
#include "tests/support/vtk_volume.h"

#include <glm/geometric.hpp>
#include <gmock/gmock.h>
#include <vtkMetaImageReader.h>

namespace tessera::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

const std::string kElementSpacing = "ElementSpacing = 2 3 4\n";

std::string metaHeader(const std::string& type, const std::string& data,
                       const std::string& more = kElementSpacing, const std::string& sizes = "3 4 5") {
    return "ObjectType = Image\nNDims = 3\nDimSize = " + sizes + "\nElementType = " + type + "\n" + more +
           "ElementDataFile = " + data + "\n";
}

/// As MetaIO packs data: RFC 1950.
std::string zlibPacked(const std::string& bytes) {
    uLongf size = compressBound(bytes.size());
    std::string out(size, '\0');
    compress(reinterpret_cast<Bytef*>(out.data()), &size, reinterpret_cast<const Bytef*>(bytes.data()),
             bytes.size());
    out.resize(size);
    return out;
}

template <class T> std::vector<T> metaVoxels() {
    std::vector<T> values(60);
    for (std::size_t i = 0; i < values.size(); ++i)
        values[i] = static_cast<T>(static_cast<double>(i * i) * 0.5 - 40);
    values[7] = std::numeric_limits<T>::max();
    values[8] = std::numeric_limits<T>::lowest();
    return values;
}

template <class In, class Out> void expectMetaCodings(const std::string& type) {
    const ScratchFolder folder;
    const std::vector<In> values = metaVoxels<In>();
    const std::vector<Out> expected(values.begin(), values.end());
    for (const bool big : {false, true})
        for (const bool packed : {false, true})
            for (const bool local : {false, true}) {
                const std::string plain = voxelBytes(values, big), data = packed ? zlibPacked(plain) : plain;
                const std::string header = metaHeader(
                    type,
                    local    ? "LOCAL"
                    : packed ? "a.zraw"
                             : "a.raw",
                    kElementSpacing + "BinaryData = True\nElementByteOrderMSB = " + (big ? "True" : "False") +
                        "\nCompressedData = " + (packed ? "True" : "False") + "\n" +
                        (packed ? "CompressedDataSize = " + std::to_string(data.size()) + "\n" : ""));
                const fs::path path = folder / (local ? "a.mha" : "a.mhd");
                writeFile(path, local ? header + data : header);
                if (!local)
                    writeFile(folder / (packed ? "a.zraw" : "a.raw"), data);
                const auto source = openSource(path, {});
                EXPECT_EQ(source->info().spacingMm(), glm::dvec3(2, 3, 4));
                EXPECT_EQ(readAll<Out>(*source), expected) << type << big << packed << local;
                if constexpr (std::is_same_v<In, Out>) {
                    if (!packed) { // VTK 9.1 damages its heap over packed data
                        EXPECT_EQ((vtkVoxels<Out, vtkMetaImageReader>(path)), expected)
                            << "VTK " << type << big;
                    }
                }
            }
}

TEST(ImportMetaImage, DoublesThatFloatCannotHoldAreToldOf) {
    const ScratchFolder folder;
    writeFile(folder / "a.mha",
              metaHeader("MET_DOUBLE", "LOCAL", kElementSpacing + "BinaryData = True\n", "3 1 1") +
                  voxelBytes<double>({5, 0.1, -7}));
    const auto source = openSource(folder / "a.mha", {});
    readAll<float>(*source);
    EXPECT_THAT(source->takeTally().notes(), testing::Contains(HasSubstr("which changed 1 of them")));
}

TEST(ImportMetaImage, EveryTypeAndCodingReadsBackEqual) {
    expectMetaCodings<std::int8_t, std::int16_t>("MET_CHAR");
    expectMetaCodings<std::uint8_t, std::uint8_t>("MET_UCHAR");
    expectMetaCodings<std::int16_t, std::int16_t>("MET_SHORT");
    expectMetaCodings<std::uint16_t, std::uint16_t>("MET_USHORT");
    expectMetaCodings<float, float>("MET_FLOAT");
}

TEST(ImportMetaImage, HeadersBeforeTheDataTextAndManyFiles) {
    const ScratchFolder folder;
    const std::vector<std::int16_t> values = metaVoxels<std::int16_t>();
    const std::string data = voxelBytes(values), order = kElementSpacing + "ElementByteOrderMSB = False\n";
    const auto read = [&](const std::string& header, const std::string& raw) {
        writeFile(folder / "a.raw", raw);
        writeFile(folder / "a.mhd", header);
        return readAll<std::int16_t>(*openSource(folder / "a.mhd", {}));
    };
    EXPECT_EQ(read(metaHeader("MET_SHORT", "a.raw", order + "HeaderSize = 7\n"), "1234567" + data), values);
    EXPECT_EQ(
        read(metaHeader("MET_SHORT", "a.raw", order + "HeaderSize = -1\n"), std::string(999, 'x') + data),
        values);
    std::string text;
    for (const std::int16_t value : values)
        text += std::to_string(value) + "\n";
    writeFile(folder / "t.mha",
              metaHeader("MET_SHORT", "LOCAL", kElementSpacing + "BinaryData = False\n") + text);
    EXPECT_EQ(readAll<float>(*openSource(folder / "t.mha", {})),
              std::vector<float>(values.begin(), values.end()));
    std::string names;
    for (std::size_t z = 0; z < 5; ++z) {
        const std::string name = "s" + std::to_string(9 + z) + ".dat";
        writeFile(folder / name, data.substr(24 * z, 24));
        names += name + "\n";
    }
    EXPECT_EQ(read(metaHeader("MET_SHORT", "LIST", order) + names, ""), values);
    EXPECT_EQ(read(metaHeader("MET_SHORT", "s%d.dat 9 13 1", order), ""), values);
    fs::remove(folder / "s11.dat");
    EXPECT_THAT(refusalOfOpening(folder / "a.mhd"), HasSubstr("s11.dat"));
}

// MetaIO's spellings.
TEST(ImportMetaImage, LocalAndListsAreWrittenInSeveralWays) {
    const ScratchFolder folder;
    const std::vector<std::uint8_t> values = metaVoxels<std::uint8_t>();
    const std::string data = voxelBytes(values);
    const auto read = [&](const std::string& bytes) {
        writeFile(folder / "a.mhd", bytes);
        return readAll<std::uint8_t>(*openSource(folder / "a.mhd", {}));
    };
    for (const char* word : {"LOCAL", "Local", "local"}) {
        EXPECT_EQ(read(metaHeader("MET_UCHAR", word) + data), values) << word;
        const std::string end = metaHeader("MET_UCHAR", word, kElementSpacing + "HeaderSize = -1\n");
        EXPECT_EQ(read(end + data), values) << word;
        writeFile(folder / "a.mhd", end + data.substr(1));
        EXPECT_THAT(refusalOfOpening(folder / "a.mhd"), HasSubstr("too short")) << word;
    }
    std::string slices, rows;
    for (std::size_t n = 0; n < 20; ++n) {
        writeFile(folder / ("r" + std::to_string(n)), data.substr(3 * n, 3));
        rows += "r" + std::to_string(n) + "\n";
    }
    for (std::size_t z = 0; z < 5; ++z) {
        writeFile(folder / ("s" + std::to_string(z)), data.substr(12 * z, 12));
        slices += "s" + std::to_string(z) + "\n";
    }
    for (const char* list : {"LIST", "LIST 2", "LIST 2D", "LIST 2d"})
        EXPECT_EQ(read(metaHeader("MET_UCHAR", list) + slices), values) << list;
    EXPECT_EQ(read(metaHeader("MET_UCHAR", "LIST 1D") + rows), values);
    for (const char* list : {"LIST 4D", "LIST D", "LIST 2DX", "LISTS"}) {
        writeFile(folder / "a.mhd", metaHeader("MET_UCHAR", list) + slices);
        EXPECT_THAT(refusalOfOpening(folder / "a.mhd"), HasSubstr("ElementDataFile")) << list;
    }
}

// ITK: the matrix has the directions of the axes one after another; "Offset" is the first voxel's centre, in
// LPS.
TEST(ImportMetaImage, PlacesAreAsItkReadsThem) {
    const ScratchFolder folder;
    const std::string data(60, '\1');
    const auto infoOf = [&](const std::string& more) {
        writeFile(folder / "a.mha", metaHeader("MET_UCHAR", "LOCAL", more) + data);
        return openSource(folder / "a.mha", {})->info();
    };
    const VolumeInfo info =
        infoOf(kElementSpacing + "Offset = 10 20 30\nTransformMatrix = 1 0 0 0 0.8 0.6 0 -0.6 0.8\n");
    EXPECT_TRUE(info.orientationKnown);
    const glm::dvec3 expected = glm::dvec3(10, 20, 30) + 1 * 2.0 * glm::dvec3(1, 0, 0) +
                                2 * 3.0 * glm::dvec3(0, 0.8, 0.6) + 3 * 4.0 * glm::dvec3(0, -0.6, 0.8);
    EXPECT_LT(glm::length(centreMm(info, 1, 2, 3) - expected), 1e-9);
    EXPECT_FALSE(infoOf(kElementSpacing).orientationKnown);
    EXPECT_EQ(infoOf("ElementSize = 2 3 4\n").spacingMm(), glm::dvec3(2, 3, 4));
    EXPECT_EQ(infoOf(kElementSpacing + "DistanceUnits = um\nOffset = 1000 0 0\n").spacingMm(),
              1e-3 * glm::dvec3(2, 3, 4));
    EXPECT_NEAR(firstVoxelCentreMm(infoOf(kElementSpacing + "DistanceUnits = um\nOffset = 1000 0 0\n")).x, 1,
                1e-12);
    const std::string identity = kElementSpacing + "TransformMatrix = 1 0 0 0 1 0 0 0 1\n";
    EXPECT_TRUE(infoOf(identity + "AnatomicalOrientation = RAI\n").remarks.empty());
    EXPECT_THAT(infoOf(identity + "AnatomicalOrientation = LPI\n").remarks,
                testing::Contains(HasSubstr("AnatomicalOrientation contradicts")));
    const VolumeInfo scaled =
        infoOf(kElementSpacing + "ElementToIntensityFunctionSlope = 2\n"
                                 "ElementToIntensityFunctionOffset = -5\nModality = MET_MOD_CT\n");
    EXPECT_EQ(scaled.rescaleSlope, 2);
    EXPECT_EQ(scaled.rescaleIntercept, -5);
    EXPECT_EQ(scaled.acquisition.modality, "CT");
}

TEST(ImportMetaImage, AnUnknownSpacingIsAskedFor) {
    const ScratchFolder folder;
    writeFile(folder / "a.mha", metaHeader("MET_UCHAR", "LOCAL", "") + std::string(60, '\1'));
    EXPECT_THAT(refusalOfOpening(folder / "a.mha"), HasSubstr("--spacing X,Y,Z"));
    EXPECT_EQ(openSource(folder / "a.mha", {.spacingMm = glm::dvec3(2, 5, 7)})->info().spacingMm(),
              glm::dvec3(2, 5, 7));
    writeFile(folder / "a.mha", metaHeader("MET_UCHAR", "LOCAL") + std::string(60, '\1'));
    EXPECT_THAT(refusalOfOpening(folder / "a.mha", {.spacingMm = glm::dvec3(1)}), HasSubstr("one that does"));
}

TEST(ImportMetaImage, LiesAreRefused) {
    const ScratchFolder folder;
    const std::string data(60, '\1');
    const auto expectRefusal = [&](const std::string& text, const char* what) {
        writeFile(folder / "a.mha", text);
        EXPECT_THAT(refusal([&] { readAll<std::uint8_t>(*openSource(folder / "a.mha", {})); }),
                    AllOf(HasSubstr("a.mha"), HasSubstr(what)));
    };
    const auto withMore = [&](const std::string& more) {
        return metaHeader("MET_UCHAR", "LOCAL", kElementSpacing + more) + data;
    };
    const auto withSizes = [&](const std::string& sizes) {
        return metaHeader("MET_UCHAR", "LOCAL", kElementSpacing, sizes) + data;
    };
    expectRefusal(withSizes("3 4 6"), "too short");
    expectRefusal(withSizes("3 4 4"), "12 bytes more");
    expectRefusal(withSizes("2000000000 2000000000 2000000000"), "2^58");
    expectRefusal(withSizes("3 4 0"), "at least 1");
    expectRefusal(withSizes("3 4"), "of 3 numbers");
    expectRefusal(metaHeader("MET_UCHAR", "LOCAL", kElementSpacing + "CompressedData = True\n",
                             "2000000 2000000 1000") +
                      zlibPacked(data),
                  "too short");
    expectRefusal(withMore("CompressedData = True\nCompressedDataSize = 100\n"),
                  "100 bytes of compressed data");
    expectRefusal(withMore("ElementNumberOfChannels = 3\n"), "one value per voxel");
    expectRefusal(withMore("ElementByteOrderMSB = maybe\n"), "True or False");
    expectRefusal(withMore("ElementByteOrderMSB = True\nBinaryDataByteOrderMSB = False\n"), "differ");
    expectRefusal(withMore("HeaderSize = 5\n"), "LOCAL");
    expectRefusal(withMore("TransformMatrix = 2 0 0 0 1 0 0 0 1\n"), "length 1");
    expectRefusal(withMore("TransformMatrix = 1 0 0 1 0 0 0 0 1\n"), "singular");
    expectRefusal(withMore("Offset = 1 nan 0\n"), "finite");
    expectRefusal(withMore("ElementSpacing = 1 1 1\n"), "again");
    expectRefusal(withMore("ElementToIntensityFunctionSlope = 0\n"), "slope");
    expectRefusal(withMore("DistanceUnits = furlong\n"), "DistanceUnits");
    expectRefusal(metaHeader("MET_UCHAR", "LOCAL", "ElementSpacing = 1 0 1\n") + data, "above 0");
    expectRefusal(metaHeader("MET_UCHAR_ARRAY", "LOCAL") + data, "MET_UCHAR_ARRAY");
    expectRefusal("ObjectType = Scene\nNDims = 3\nElementDataFile = LOCAL\n" + data, "Scene");
    expectRefusal("ObjectType = Image\nNDims = 2\nElementDataFile = LOCAL\n" + data, "NDims = 3");
    expectRefusal("ObjectType = Image\nNDims = 3\n", "truncated");
    expectRefusal("hello = world\n", "begins with ObjectType");
}

TEST(ImportMetaImage, EveryTruncationAndRandomDamageIsAnErrorOrRead) {
    const ScratchFolder folder;
    const std::string data = voxelBytes(metaVoxels<std::int16_t>());
    for (const bool packed : {false, true}) {
        const std::string header =
                              metaHeader("MET_SHORT", "LOCAL",
                                         kElementSpacing + "ElementByteOrderMSB = False\nCompressedData = " +
                                             (packed ? "True\n" : "False\n")),
                          whole = header + (packed ? zlibPacked(data) : data);
        expectPrefixesRefused(folder / "a.mha", whole,
                              folder.path().string() + "/"); // LOC: a data file of that name
        expectDamageHarmless(folder / "a.mha", whole, header.size());
    }
}

} // namespace
} // namespace tessera::test
