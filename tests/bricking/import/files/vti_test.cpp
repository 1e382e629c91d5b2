// tests/bricking/import/files/vti_test.cpp: VTK's images in XML, as VTK's writer and the test write them:
// types, codings, places, slabs, and every lie refused.
#include "core/base/brick.h"
#include "tests/support/import_test_tools.h"

#include <cmath>
#include <fstream>
#include <glm/geometric.hpp>
#include <gmock/gmock.h>
#include <limits>
#include <vtkDataArray.h>
#include <vtkFloatArray.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkXMLImageDataWriter.h>

namespace tessera::test {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

const glm::ivec3 kSize(5, 4, 7);

template <class T> vtkNew<vtkImageData> imageOf(int vtkType, const glm::ivec3& size = kSize) {
    vtkNew<vtkImageData> image;
    image->SetExtent(2, size.x + 1, -3, size.y - 4, 10, size.z + 9);
    image->SetSpacing(0.5, 0.75, 2);
    image->SetOrigin(10, -20, 30);
    image->AllocateScalars(vtkType, 1);
    image->GetPointData()->GetScalars()->SetName("density");
    auto* const values = static_cast<T*>(image->GetScalarPointer());
    const std::size_t count = static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y) *
                              static_cast<std::size_t>(size.z);
    for (std::size_t i = 0; i < count; ++i)
        values[i] = static_cast<T>(i * i % 101 + i % 7);
    values[1] = std::numeric_limits<T>::max();
    values[2] = std::numeric_limits<T>::lowest();
    return image;
}

std::string fileBytes(const fs::path& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

enum class Coding { text, base64, appendedBase64, raw };
void write(vtkImageData* image, const fs::path& path, Coding coding, int compressor) {
    const vtkNew<vtkXMLImageDataWriter> writer;
    writer->SetFileName(path.c_str());
    writer->SetInputData(image);
    coding == Coding::text     ? writer->SetDataModeToAscii()
    : coding == Coding::base64 ? writer->SetDataModeToBinary()
                               : writer->SetDataModeToAppended();
    writer->SetEncodeAppendedData(coding == Coding::appendedBase64 ? 1 : 0);
    writer->SetCompressorType(compressor);
    writer->SetBlockSize(32); // several blocks
    ASSERT_EQ(writer->Write(), 1);
}

template <class In, class Out> void expectEveryCoding(int vtkType) {
    const ScratchFolder folder;
    const vtkNew<vtkImageData> image = imageOf<In>(vtkType);
    const auto* const values = static_cast<const In*>(image->GetScalarPointer());
    const std::vector<Out> expected(values, values + kSize.x * kSize.y * kSize.z);
    for (const Coding coding : {Coding::text, Coding::base64, Coding::appendedBase64, Coding::raw})
        for (const int compressor :
             {static_cast<int>(vtkXMLWriter::NONE), static_cast<int>(vtkXMLWriter::ZLIB),
              static_cast<int>(vtkXMLWriter::LZ4), static_cast<int>(vtkXMLWriter::LZMA)}) {
            write(image, folder / "a.vti", coding, compressor);
            const auto source = openSource(folder / "a.vti", {});
            EXPECT_EQ(source->info().extentVoxels, kSize);
            EXPECT_EQ(readAll<Out>(*source), expected)
                << vtkType << " coding " << static_cast<int>(coding) << " by " << compressor;
        }
}

TEST(ImportVti, EveryTypeAndCodingReadsBackEqual) {
    expectEveryCoding<std::int8_t, std::int16_t>(VTK_SIGNED_CHAR);
    expectEveryCoding<std::uint8_t, std::uint8_t>(VTK_UNSIGNED_CHAR);
    expectEveryCoding<std::int16_t, std::int16_t>(VTK_SHORT);
    expectEveryCoding<std::uint16_t, std::uint16_t>(VTK_UNSIGNED_SHORT);
    expectEveryCoding<std::int32_t, float>(VTK_INT);
    expectEveryCoding<std::int64_t, float>(VTK_LONG_LONG);
    expectEveryCoding<float, float>(VTK_FLOAT);
}

TEST(ImportVti, PlaceAndSlabs) {
    const ScratchFolder folder;
    const glm::ivec3 size(700, 800, 50); // more than VTK holds at once
    vtkNew<vtkImageData> image = imageOf<std::uint8_t>(VTK_UNSIGNED_CHAR, size);
    image->SetDirectionMatrix(0.8, -0.6, 0, 0.6, 0.8, 0, 0, 0, 1);
    const auto* const values = static_cast<const std::uint8_t*>(image->GetScalarPointer());
    const std::vector<std::uint8_t> expected(values, values + cellCount(size));
    write(image, folder / "a.vti", Coding::raw, vtkXMLWriter::NONE);
    const auto source = openSource(folder / "a.vti", {});
    for (const glm::dvec3& voxel : {glm::dvec3(0, 0, 0), {1, 0, 0}, {0, 3, 0}, {5, 6, 7}}) {
        const glm::dvec3 index = voxel + glm::dvec3(2, -3, 10);
        glm::dvec3 mm;
        image->TransformContinuousIndexToPhysicalPoint(&index.x, &mm.x);
        const glm::dvec3 found(source->info().patientFromVoxel * glm::dvec4(voxel + 0.5, 1));
        EXPECT_LT(glm::distance(found, mm), 1e-9);
    }
    EXPECT_FALSE(source->info().orientationKnown);
    std::vector<std::uint8_t> found(expected.size());
    const std::size_t slice = static_cast<std::size_t>(size.x * size.y);
    int z = 0;
    for (const int count : {1, 29, 3, 17}) {
        source->readSlices(
            count, std::as_writable_bytes(std::span(found).subspan(static_cast<std::size_t>(z) * slice,
                                                                   static_cast<std::size_t>(count) * slice)));
        z += count;
    }
    EXPECT_EQ(z, size.z);
    EXPECT_TRUE(found == expected);
}

// Another pass over all slices, which VTK holds a part of, is for the lowest value.
TEST(ImportVti, VoxelsWithoutANumber) {
    const ScratchFolder folder;
    const glm::ivec3 size(700, 800, 20);
    const vtkNew<vtkImageData> image = imageOf<float>(VTK_FLOAT, size);
    auto* const values = static_cast<float*>(image->GetScalarPointer());
    const std::size_t count = cellCount(size);
    for (std::size_t i = 0; i < count; ++i)
        values[i] = static_cast<float>(i % 1009) - 20;
    values[5] = values[count / 2] = std::numeric_limits<float>::quiet_NaN();
    write(image, folder / "a.vti", Coding::raw, vtkXMLWriter::NONE);
    const auto source = openSource(folder / "a.vti", {});
    const std::vector<float> found = readAll<float>(*source);
    EXPECT_EQ(source->info().nonFiniteVoxels, 2u);
    std::size_t wrong = 0;
    for (std::size_t i = 0; i < count; ++i)
        wrong += found[i] != (std::isnan(values[i]) ? -20 : values[i]);
    EXPECT_EQ(wrong, 0u);
}

// An image in pieces, as parallel programs write it.
TEST(ImportVti, Pieces) {
    const ScratchFolder folder;
    const auto piece = [](const std::string& extent, const std::string& values) {
        return "<Piece Extent=\"" + extent +
               "\"><PointData Scalars=\"v\"><DataArray type=\"Int16\" Name=\"v\" format=\"ascii\">" + values +
               "</DataArray></PointData></Piece>\n";
    };
    const auto written = [&](const std::string& pieces) {
        writeFile(folder / "a.vti",
                  "<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" "
                  "header_type=\"UInt64\">\n"
                  "<ImageData WholeExtent=\"0 1 0 1 0 2\" Origin=\"0 0 0\" Spacing=\"1 1 1\">\n" +
                      pieces + "</ImageData>\n</VTKFile>\n");
    };
    const std::string low = piece("0 1 0 1 0 0", "1 2 3 4"), left = piece("0 0 0 1 1 2", "5 7 9 11"),
                      right = piece("1 1 0 1 1 2", "6 8 10 12");
    written(low + left + right);
    EXPECT_EQ(readAll<std::int16_t>(*openSource(folder / "a.vti", {})),
              (std::vector<std::int16_t>{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}));
    for (const std::string& pieces :
         {low, low + left, low + left + left, low + left + piece("1 1 0 1 1 3", "6 8 10 12 13 14")}) {
        written(pieces);
        EXPECT_THAT(refusalOfOpening(folder / "a.vti"),
                    HasSubstr("pieces that hold every voxel of WholeExtent once"))
            << pieces;
    }
}

TEST(ImportVti, WhichArray) {
    const ScratchFolder folder;
    vtkNew<vtkImageData> image = imageOf<std::int16_t>(VTK_SHORT);
    const vtkNew<vtkFloatArray> more;
    more->SetName("other");
    more->SetNumberOfTuples(image->GetNumberOfPoints());
    more->Fill(3);
    image->GetPointData()->AddArray(more);
    write(image, folder / "a.vti", Coding::raw, vtkXMLWriter::NONE);
    EXPECT_EQ(openSource(folder / "a.vti", {})->info().type, ValueType::i16); // the scalars
    image->GetPointData()->SetActiveScalars("other");
    write(image, folder / "a.vti", Coding::raw, vtkXMLWriter::NONE);
    EXPECT_EQ(readAll<float>(*openSource(folder / "a.vti", {})).front(), 3);
    image->GetPointData()->SetActiveScalars(nullptr);
    write(image, folder / "a.vti", Coding::raw, vtkXMLWriter::NONE);
    EXPECT_THAT(refusalOfOpening(folder / "a.vti"),
                HasSubstr("one array of values of points, or one that is named as Scalars, found 2 arrays"));
    vtkNew<vtkImageData> colours = imageOf<std::uint8_t>(VTK_UNSIGNED_CHAR);
    colours->AllocateScalars(VTK_UNSIGNED_CHAR, 3);
    write(colours, folder / "a.vti", Coding::raw, vtkXMLWriter::NONE);
    EXPECT_THAT(refusalOfOpening(folder / "a.vti"),
                HasSubstr("an array of one value per voxel, found 3 values"));
}

// A file that ends early, or says what it does not hold, is refused when it is opened or read.
TEST(ImportVti, LiesAreRefused) {
    const ScratchFolder folder;
    const vtkNew<vtkImageData> image = imageOf<std::int16_t>(VTK_SHORT);
    const fs::path path = folder / "a.vti";
    const auto refusal = [&]() -> std::string {
        try {
            const auto source = openSource(path, {});
            readAll<std::int16_t>(*source);
        } catch (const InputError& error) {
            EXPECT_THAT(error.what(), HasSubstr("a.vti"));
            return error.what();
        }
        return {};
    };
    for (const Coding coding : {Coding::text, Coding::raw})
        for (const int compressor :
             {static_cast<int>(vtkXMLWriter::NONE), static_cast<int>(vtkXMLWriter::ZLIB)}) {
            write(image, path, coding, compressor);
            const std::string whole = fileBytes(path);
            EXPECT_EQ(refusal(), "");
            const std::size_t values =
                whole.find(coding == Coding::text ? "</DataArray>" : "</AppendedData>");
            ASSERT_NE(values, std::string::npos);
            for (std::size_t length = 0; length + 20 < values; length += 1 + length / 60) {
                writeFile(path, whole.substr(0, length));
                EXPECT_NE(refusal(), "") << length << " of " << whole.size();
            }
        }
    write(image, path, Coding::raw, vtkXMLWriter::NONE);
    const std::string whole = fileBytes(path);
    const auto with = [&](const std::string& old, const std::string& other) {
        std::string text = whole;
        for (std::size_t at = text.find(old); at != std::string::npos; at = text.find(old, at + other.size()))
            text.replace(at, old.size(), other);
        EXPECT_NE(text, whole) << old;
        writeFile(path, text);
        return refusal();
    };
    const std::string extent = "2 6 -3 0 10 16";
    EXPECT_THAT(with(extent, "2 6 -3 0 10 9"), HasSubstr("WholeExtent of at least one voxel"));
    EXPECT_THAT(with(extent, "0 9999 0 9999 0 9999"), HasSubstr("bytes of values, as its extent says"));
    EXPECT_NE(with(extent, "2 6 -3 0 10 17"), ""); // a slice more than there is
    EXPECT_THAT(with("Piece Extent=\"" + extent, "Piece Extent=\"2 6 -3 0 10 15"),
                HasSubstr("pieces that hold every voxel"));
    EXPECT_THAT(with("Spacing=\"0.5", "Spacing=\"0"), HasSubstr("a Spacing above 0"));
    EXPECT_THAT(with("Spacing=\"0.5", "Spacing=\"1e9"), HasSubstr("Spacing"));
    EXPECT_THAT(with("Direction=\"1", "Direction=\"2"), HasSubstr("columns have length 1"));
    EXPECT_NE(with("type=\"Int16\"", "type=\"Word\""), "");
    EXPECT_NE(with("offset=\"0\"", "offset=\"999999\""), "");
    EXPECT_NE(with("ImageData", "PolyData"), "");
}

// Packed values have checksums: no damage of them passes. Damage elsewhere does no harm.
TEST(ImportVti, DamageIsFound) {
    const ScratchFolder folder;
    const vtkNew<vtkImageData> image = imageOf<std::int16_t>(VTK_SHORT, {20, 20, 10});
    const fs::path path = folder / "a.vti";
    write(image, path, Coding::raw, vtkXMLWriter::ZLIB);
    const std::string whole = fileBytes(path);
    const std::size_t from = whole.find("<AppendedData"), to = whole.find("</AppendedData>");
    std::size_t silent = 0, tried = 0;
    for (std::size_t at = whole.find('_', from) + 1; at + 4 < to; at += 7) {
        std::string damaged = whole;
        damaged[at] = static_cast<char>(damaged[at] ^ (1 << (at % 8)));
        writeFile(path, damaged);
        ++tried;
        try {
            const auto source = openSource(path, {});
            const auto values = readAll<std::int16_t>(*source);
            const auto* const truth = static_cast<const std::int16_t*>(image->GetScalarPointer());
            silent += !std::equal(values.begin(), values.end(), truth);
        } catch (const InputError&) {
        }
    }
    EXPECT_GT(tried, 100u);
    EXPECT_EQ(silent, 0u) << "of " << tried;
}

// VTK divides by these numbers, and allocates what they say.
TEST(ImportVti, LyingSizesOfBlocksAreRefused) {
    const ScratchFolder folder;
    const vtkNew<vtkImageData> image = imageOf<std::int16_t>(VTK_SHORT);
    const fs::path path = folder / "a.vti";
    for (const Coding coding : {Coding::raw, Coding::base64, Coding::appendedBase64}) {
        write(image, path, coding, vtkXMLWriter::ZLIB);
        const std::string whole = fileBytes(path);
        const std::size_t from =
            coding == Coding::base64
                ? whole.find_first_not_of(" \n", whole.find('>', whole.find("<DataArray")) + 1)
                : whole.find('_', whole.find("<AppendedData")) + 1;
        for (const std::string& lie :
             {std::string("\377\377\377\377\40\0\0\0\30\0\0\0", 12),
              std::string("\11\0\0\0\0\0\0\0\30\0\0\0", 12), std::string("\11\0\0\0\40\0\0\0\60\0\0\0", 12),
              std::string("\11\0\0\0\377\377\377\377\30\0\0\0", 12)}) {
            std::string text = lie;
            if (coding != Coding::raw) { // 12 bytes are 16 letters
                const char* const letters =
                    "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
                text.clear();
                for (std::size_t i = 0; i < lie.size(); i += 3) {
                    const std::uint32_t bits =
                        static_cast<std::uint32_t>(static_cast<unsigned char>(lie[i])) << 16 |
                        static_cast<std::uint32_t>(static_cast<unsigned char>(lie[i + 1])) << 8 |
                        static_cast<unsigned char>(lie[i + 2]);
                    for (const int shift : {18, 12, 6, 0})
                        text += letters[bits >> shift & 63u];
                }
            }
            std::string damaged = whole;
            damaged.replace(from, text.size(), text);
            writeFile(path, damaged);
            EXPECT_THAT(refusalOfOpening(path), HasSubstr("packed blocks of an array"))
                << static_cast<int>(coding);
        }
    }
}

} // namespace
} // namespace tessera::test
