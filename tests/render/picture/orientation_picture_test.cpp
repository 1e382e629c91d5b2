// tests/render/picture/orientation_picture_test.cpp: left is left from the file to the picture: one
// asymmetric phantom, written in every format, axis permutation and sign, gives one picture. A mark on the
// patient's right appears on the picture's left, and so does the liver of a real abdomen.
#include "tests/support/dicom_writer.h"
#include "tests/support/import_test_tools.h"
#include "tests/support/scene_fixture.h"

#include "bricking/import/importer.h"
#include "render/picture/render_scene.h"

#include <algorithm>
#include <array>
#include <vector>

namespace tessera::test {
namespace {

// LPS order; extents and spacings all differ, steps are exact in float and in short decimals.
constexpr glm::ivec3 kExtent{12, 16, 20};
const glm::dvec3 kSpacing{1.5, 0.75, 1.25}, kOrigin{-10, 20, 30};

/// An L of three boxes and a small one apart, all of different values, in air: no symmetry maps it to itself.
std::int16_t valueAt(const glm::ivec3& p) {
    const auto inside = [&](const glm::ivec3& lo, const glm::ivec3& hi) {
        return p.x >= lo.x && p.y >= lo.y && p.z >= lo.z && p.x < hi.x && p.y < hi.y && p.z < hi.z;
    };
    if (inside({1, 3, 2}, {4, 7, 17}))
        return 200;
    if (inside({4, 3, 2}, {10, 7, 6}))
        return 400;
    if (inside({1, 7, 2}, {4, 14, 5}))
        return 800;
    if (inside({9, 12, 15}, {11, 14, 18}))
        return 1200;
    return -1000;
}

/// The layout of a file: its axis f runs along LPS axis lps[f], backwards if flipped[f].
struct Layout {
    std::array<int, 3> lps = {0, 1, 2};
    std::array<bool, 3> flipped = {false, false, false};

    int axis(int f) const { return lps[static_cast<std::size_t>(f)]; }
    bool backwards(int f) const { return flipped[static_cast<std::size_t>(f)]; }
    glm::ivec3 extent() const { return {kExtent[axis(0)], kExtent[axis(1)], kExtent[axis(2)]}; }
    glm::ivec3 lpsVoxel(const glm::ivec3& file) const {
        glm::ivec3 p;
        for (int f = 0; f < 3; ++f)
            p[axis(f)] = backwards(f) ? kExtent[axis(f)] - 1 - file[f] : file[f];
        return p;
    }
    glm::dvec3 direction(int f) const {
        glm::dvec3 d{0};
        d[axis(f)] = backwards(f) ? -1 : 1;
        return d;
    }
    double spacing(int f) const { return kSpacing[axis(f)]; }
    glm::dvec3 position(const glm::ivec3& file) const {
        return kOrigin + kSpacing * glm::dvec3(lpsVoxel(file));
    }
    /// [z][y][x] of the file
    /// @param slice  one of them, or -1 for all
    std::vector<std::int16_t> voxels(int slice = -1) const {
        std::vector<std::int16_t> out;
        const glm::ivec3 n = extent();
        for (int z = std::max(slice, 0); z < (slice < 0 ? n.z : slice + 1); ++z)
            for (int y = 0; y < n.y; ++y)
                for (int x = 0; x < n.x; ++x)
                    out.push_back(valueAt(lpsVoxel({x, y, z})));
        return out;
    }
    std::string bytes() const {
        const auto values = voxels();
        return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof values[0]};
    }
};

std::vector<Layout> allLayouts() {
    std::vector<Layout> layouts;
    std::array<int, 3> lps = {0, 1, 2};
    do
        for (int signs = 0; signs < 8; ++signs)
            layouts.push_back({lps, {(signs & 1) != 0, (signs & 2) != 0, (signs & 4) != 0}});
    while (std::next_permutation(lps.begin(), lps.end()));
    return layouts;
}

void writeNifti(const std::filesystem::path& path, const Layout& layout) {
    NiftiImage image;
    const glm::ivec3 n = layout.extent();
    image.extent = {n.x, n.y, n.z};
    const glm::dvec3 toRas{-1, -1, 1}, first = layout.position({0, 0, 0});
    for (int row = 0; row < 3; ++row) {
        double* srow = image.srow.data() + 4 * row;
        for (int f = 0; f < 3; ++f)
            srow[f] = toRas[row] * layout.direction(f)[row] * layout.spacing(f);
        srow[3] = toRas[row] * first[row];
    }
    image.voxels = layout.bytes();
    const std::string bytes = niftiBytes(image);
    writeFile(path, path.extension() == ".gz" ? gzip(bytes) : bytes);
}

void writeRaw(const std::filesystem::path& sidecar, const Layout& layout) {
    std::string direction;
    for (int row = 0; row < 3; ++row)
        for (int f = 0; f < 3; ++f)
            direction += (direction.empty() ? "" : ",") + std::to_string(layout.direction(f)[row]);
    const auto list = [](const auto& v) {
        return "[" + std::to_string(v[0]) + "," + std::to_string(v[1]) + "," + std::to_string(v[2]) + "]";
    };
    const glm::dvec3 spacing{layout.spacing(0), layout.spacing(1), layout.spacing(2)};
    const auto data = std::filesystem::path(sidecar).replace_extension(".raw");
    writeFile(data, layout.bytes());
    writeFile(sidecar, R"({"type":"int16","data":")" + data.filename().string() + R"(","extent":)" +
                           list(layout.extent()) + R"(,"spacing":)" + list(spacing) + R"(,"origin":)" +
                           list(layout.position({0, 0, 0})) + R"(,"direction":[)" + direction + "]}");
}

void writeSeries(const std::filesystem::path& folder, const Layout& layout) {
    std::filesystem::create_directory(folder);
    const glm::ivec3 n = layout.extent();
    for (int z = 0; z < n.z; ++z) {
        DicomImage image;
        image.columns = n.x;
        image.rows = n.y;
        image.rowDirection = layout.direction(0);
        image.columnDirection = layout.direction(1);
        image.spacingX = layout.spacing(0);
        image.spacingY = layout.spacing(1);
        image.position = layout.position({0, 0, z});
        for (const std::int16_t value : layout.voxels(z))
            image.pixels.push_back(static_cast<std::uint16_t>(value + 1024));
        writeDicom(folder / (std::to_string(z * 7 % n.z) + ".dcm"), image); // names say nothing of the order
    }
}

/// The values straight into a store: no importer of files has a say.
class PhantomSource : public SlabSource {
  public:
    PhantomSource() {
        info_.extentVoxels = kExtent;
        info_.patientFromVoxel =
            patientFromVoxelOf(kOrigin, {kSpacing.x, 0, 0}, {0, kSpacing.y, 0}, {0, 0, kSpacing.z});
    }
    const VolumeInfo& info() const override { return info_; }
    std::string describe() const override { return "the phantom"; }
    void readSlices(int count, std::span<std::byte> out) override {
        for (int i = 0; i < count; ++i, ++next_) {
            const auto values = Layout{}.voxels(next_);
            const std::size_t bytes = values.size() * sizeof values[0];
            std::memcpy(out.data() + static_cast<std::size_t>(i) * bytes, values.data(), bytes);
        }
    }

  private:
    VolumeInfo info_;
    int next_ = 0;
};

constexpr const char* kBoxes = R"({"scalarOpacity":[[100,0],[200,0.1],[1200,0.6]],
    "rgbTransferFunction":[[200,1,0,0],[400,0,1,0],[800,0,0,1],[1200,1,1,1]]})";

Image draw(const std::filesystem::path& store, const std::string& function, const std::string& view,
           const std::string& rest = "") {
    const Scene scene = parseScene(R"({"tesseraScene":1,"volumes":[{"path":"x.zarr","transferFunction":)" +
                                       function + R"(}],"camera":{"view":")" + view +
                                       R"(","fit":"volume"},"image":{"size":[64,64]})" + rest + "}",
                                   "/", "test");
    Budgets budgets;
    const StoreReader reader(store, budgets.ram);
    RenderOptions options;
    options.engine = EngineKind::mirror;
    return renderScene(scene, reader, budgets.ram, budgets.gpu, options).image;
}

void toStore(SlabSource& source, const std::filesystem::path& store) {
    MemoryBudget ram("RAM", "--ram", std::size_t{256} << 20);
    ImportOptions options;
    options.force = true;
    options.durable = false;
    importToStore(source, store, ram, options);
}

double largestDifference(const Image& a, const Image& b) {
    double largest = 0;
    for (std::size_t i = 0; i < a.pixels.size(); ++i)
        for (int c = 0; c < 4; ++c)
            largest = std::max(largest, std::abs(static_cast<double>(a.pixels[i][c]) - b.pixels[i][c]));
    return largest;
}

/// Mean place of what shows in [0,1], x to the right and y down.
glm::dvec2 centreOf(const Image& image) {
    glm::dvec2 sum(0);
    double weight = 0;
    for (int y = 0; y < image.size.y; ++y)
        for (int x = 0; x < image.size.x; ++x) {
            const auto a = static_cast<double>(image.at(x, y).a);
            sum += a * (glm::dvec2(x, y) + 0.5) / glm::dvec2(image.size);
            weight += a;
        }
    return sum / weight;
}

TEST(OrientationPicture, EveryFormatAndOrderGivesOnePicture) {
    constexpr double kTolerance = 1e-6; // affines pass through float and decimals
    const ScratchFolder folder;
    PhantomSource source;
    toStore(source, folder / "expected.zarr");
    const Image expected = draw(folder / "expected.zarr", kBoxes, "anterior");
    ASSERT_FALSE(isBlank(expected));
    // Teeth: any other order of the same voxels is another picture.
    for (const char* other : {"posterior", "left", "superior"})
        EXPECT_GT(largestDifference(draw(folder / "expected.zarr", kBoxes, other), expected), 0.05) << other;

    int number = 0, pictures = 0;
    double largest = 0;
    const auto expectSame = [&](const std::filesystem::path& file) {
        toStore(*openSource(file, {.scratchFolder = folder.path()}), folder / "a.zarr");
        const double difference = largestDifference(draw(folder / "a.zarr", kBoxes, "anterior"), expected);
        EXPECT_LE(difference, kTolerance) << file.filename();
        largest = std::max(largest, difference);
        ++pictures;
    };
    for (const Layout& layout : allLayouts()) {
        SCOPED_TRACE(number);
        const auto nifti = folder / (number % 2 ? "a.nii.gz" : "a.nii");
        writeNifti(nifti, layout);
        expectSame(nifti);
        if (number % 3 == 0) { // every permutation and every sign of every axis comes up
            writeRaw(folder / "a.json", layout);
            expectSame(folder / "a.json");
        }
        if (number % 5 == 0) {
            const auto series = folder / std::to_string(number);
            writeSeries(series, layout);
            expectSame(series);
        }
        ++number;
    }
    EXPECT_EQ(pictures, 48 + 16 + 10);
    std::printf("%d pictures, largest difference %.2g\n", pictures, largest);
}

TEST(OrientationPicture, MarksComeOutOnTheirSide) {
    const ScratchFolder folder;
    // One small bright box in a corner of an even cube: patient's right, anterior, superior.
    VolumeInfo info;
    info.extentVoxels = {24, 24, 24};
    info.patientFromVoxel = patientFromVoxelOf({-12, -12, -12}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1});
    std::string voxels(24 * 24 * 24, '\0');
    for (std::size_t z = 18; z < 22; ++z)
        for (std::size_t y = 2; y < 6; ++y)
            for (std::size_t x = 2; x < 6; ++x)
                voxels[(z * 24 + y) * 24 + x] = 100;
    writeFile(folder / "v.raw", voxels);
    writeFile(folder / "v.json", R"({"data":"v.raw","type":"uint8","extent":[24,24,24],"spacing":[1,1,1]})");
    toStore(*openSource(folder / "v.json", {}), folder / "v.zarr");
    struct Expected {
        const char* view;
        bool left, top;
    };
    // The place of the mark for a viewer of that side of a standing patient; from above and below, anterior
    // is up.
    for (const Expected& e : {Expected{"anterior", true, true},
                              {"posterior", false, true},
                              {"left", true, true},
                              {"right", false, true},
                              {"superior", false, true},
                              {"inferior", true, true}}) {
        const glm::dvec2 c =
            centreOf(draw(folder / "v.zarr", R"({"scalarOpacity":[[50,0],[100,1]]})", e.view));
        EXPECT_LT(c.x, e.left ? 0.45 : 1.0) << e.view;
        EXPECT_GT(c.x, e.left ? 0.0 : 0.55) << e.view;
        EXPECT_LT(c.y, e.top ? 0.45 : 1.0) << e.view;
    }
}

/// A level of a volume of int16 as physical values, [z][y][x].
std::vector<double> physicalLevel(const StoreReader& reader, int level) {
    const VolumeInfo& info = reader.info();
    const glm::ivec3 extent = levelExtent(info.extentVoxels, level),
                     grid = chunkGrid(info.extentVoxels, level);
    std::vector<double> values(cellCount(extent));
    std::vector<std::byte> chunk(reader.chunkBytes());
    for (int k = 0; k < grid.z; ++k)
        for (int j = 0; j < grid.y; ++j)
            for (int i = 0; i < grid.x; ++i) {
                reader.readChunk({level, i, j, k}, chunk);
                const glm::ivec3 first = glm::ivec3(i, j, k) * kChunkExtent;
                const glm::ivec3 valid = glm::min(extent - first, glm::ivec3(kChunkExtent));
                for (int z = 0; z < valid.z; ++z)
                    for (int y = 0; y < valid.y; ++y)
                        for (int x = 0; x < valid.x; ++x) {
                            std::int16_t stored = 0;
                            const auto at = linearIndex({x, y, z}, glm::ivec3(kChunkExtent));
                            std::memcpy(&stored, chunk.data() + sizeof stored * at, sizeof stored);
                            values[linearIndex(first + glm::ivec3(x, y, z), extent)] =
                                info.rescaleSlope * stored + info.rescaleIntercept;
                        }
            }
    return values;
}

TEST(OrientationPicture, TheLiverIsOnThePicturesLeft) {
    const auto store = storePath("abdomen");
    if (!std::filesystem::exists(store))
        GTEST_SKIP() << "the abdomen is absent (TESSERA_TEST_DATA, or ../shared/data beside the sources)";
    // Contrast-enhanced liver: the one large body of such values through and through. Vessels, kidneys and
    // bowel share them, so a voxel of level 2 (4.3 x 4.3 x 12 mm) counts only with all its 26 neighbours in
    // range.
    constexpr double kLowest = 90, kHighest = 150;
    constexpr int kLevel = 2;
    Budgets budgets;
    const StoreReader reader(store, budgets.ram);
    const VolumeInfo& info = reader.info();
    ASSERT_EQ(info.type, ValueType::i16);
    const std::vector<double> values = physicalLevel(reader, kLevel);
    const glm::ivec3 extent = levelExtent(info.extentVoxels, kLevel);
    const double middle = (info.patientFromVoxel * glm::dvec4(0.5 * glm::dvec3(info.extentVoxels), 1)).x;
    std::array<std::size_t, 2> voxels{}; // patient's right, left
    for (int z = 1; z + 1 < extent.z; ++z)
        for (int y = 1; y + 1 < extent.y; ++y)
            for (int x = 1; x + 1 < extent.x; ++x) {
                bool bulk = true;
                for (int n = 0; n < 27 && bulk; ++n) {
                    const double hu =
                        values[linearIndex({x + n % 3 - 1, y + n / 3 % 3 - 1, z + n / 9 - 1}, extent)];
                    bulk = hu >= kLowest && hu <= kHighest;
                }
                const glm::dvec3 voxel = (glm::dvec3(x, y, z) + 0.5) * static_cast<double>(1 << kLevel);
                if (bulk)
                    ++voxels[(info.patientFromVoxel * glm::dvec4(voxel, 1)).x > middle ? 1 : 0];
            }
    std::printf("bulk of %g to %g HU: %zu voxels on the patient's right, %zu on the left\n", kLowest,
                kHighest, voxels[0], voxels[1]);
    EXPECT_GT(voxels[0], 3 * voxels[1]);

    // In the picture the liver is where most of it lies behind one another.
    const std::string liver =
        R"({"scalarOpacityUnitDistance":200,"scalarOpacity":[[85,0],[90,0.5],[150,0.5],[155,0]]})";
    const auto weigh = [&](const char* view) {
        const Image image =
            draw(store, liver, view, R"(,"shading":{"shade":false},"quality":{"stepVoxels":2})");
        float most = 0;
        for (const glm::vec4& pixel : image.pixels)
            most = std::max(most, pixel.a);
        std::array<std::size_t, 2> pixels{};
        for (int y = 0; y < image.size.y; ++y)
            for (int x = 0; x < image.size.x; ++x)
                if (image.at(x, y).a > 0.7f * most)
                    ++pixels[x < image.size.x / 2 ? 0 : 1];
        std::printf("%s: thick at %zu pixels on the picture's left, %zu on its right\n", view, pixels[0],
                    pixels[1]);
        return pixels;
    };
    const auto front = weigh("anterior"), back = weigh("posterior");
    EXPECT_GT(front[0], 3 * front[1]);
    EXPECT_GT(back[1], 3 * back[0]);
}

} // namespace
} // namespace tessera::test
