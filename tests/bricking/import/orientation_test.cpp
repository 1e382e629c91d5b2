// tests/bricking/import/orientation_test.cpp: one asymmetric phantom in every format, axis permutation and
// sign gives the same LPS voxels and the same patient position of every voxel.
#include "bricking/import/source/oriented_source.h"
#include "tests/support/dicom_writer.h"
#include "tests/support/import_test_tools.h"

#include <algorithm>
#include <glm/geometric.hpp>

namespace tessera::test {
namespace {

// The phantom in LPS order: 5 x 6 x 7 voxels of 0.5 x 0.75 x 1.25 mm, every voxel of another value.
constexpr glm::ivec3 kExtent{5, 6, 7};
const glm::dvec3 kSpacing{0.5, 0.75, 1.25}, kOrigin{-10, 20, 30}; // exact in float
std::int16_t phantomValue(const glm::ivec3& p) {
    return static_cast<std::int16_t>(100 * p.z + 10 * p.y + p.x - 300);
}

/// The layout of a file: file axis f runs along LPS axis lps[f], backwards if flipped[f].
struct Layout {
    std::array<int, 3> lps = {0, 1, 2};
    std::array<bool, 3> flipped = {false, false, false};

    glm::ivec3 extent() const { return {kExtent[lps[0]], kExtent[lps[1]], kExtent[lps[2]]}; }
    glm::ivec3 lpsVoxel(const glm::ivec3& file) const {
        glm::ivec3 p;
        for (int f = 0; f < 3; ++f) {
            const auto at = static_cast<std::size_t>(f);
            p[lps[at]] = flipped[at] ? kExtent[lps[at]] - 1 - file[f] : file[f];
        }
        return p;
    }
    glm::dvec3 direction(int f) const {
        glm::dvec3 d{0};
        d[lps[static_cast<std::size_t>(f)]] = flipped[static_cast<std::size_t>(f)] ? -1 : 1;
        return d;
    }
    glm::dvec3 step(int f) const { return direction(f) * kSpacing[lps[static_cast<std::size_t>(f)]]; }
    glm::dvec3 position(const glm::ivec3& file) const {
        return kOrigin + kSpacing * glm::dvec3(lpsVoxel(file));
    }
    std::vector<std::int16_t> voxels() const {
        std::vector<std::int16_t> out;
        const glm::ivec3 n = extent();
        for (int z = 0; z < n.z; ++z)
            for (int y = 0; y < n.y; ++y)
                for (int x = 0; x < n.x; ++x)
                    out.push_back(phantomValue(lpsVoxel({x, y, z})));
        return out;
    }
    std::string bytes() const {
        const auto v = voxels();
        return {reinterpret_cast<const char*>(v.data()), v.size() * 2};
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

/// The equality that is claimed: voxels, positions, and the recorded original order.
void expectPhantom(SlabSource& source, const Layout& layout, double toleranceMm,
                   bool sliceOrderFree = false) {
    ASSERT_EQ(source.info().extentVoxels, kExtent);
    const auto values = readAll<std::int16_t>(source);
    const VolumeInfo& info = source.info();
    for (int z = 0; z < kExtent.z; ++z)
        for (int y = 0; y < kExtent.y; ++y)
            for (int x = 0; x < kExtent.x; ++x) {
                ASSERT_EQ(values[indexOf(info, x, y, z)], phantomValue({x, y, z}))
                    << x << ' ' << y << ' ' << z;
                const glm::dvec3 expected = kOrigin + kSpacing * glm::dvec3(x, y, z);
                ASSERT_LT(glm::length(centreMm(info, x, y, z) - expected), toleranceMm);
            }
    for (int f = 0; f < 3; ++f) { // original order: LPS axis lps[f] came from file axis f
        const auto axis = static_cast<std::size_t>(layout.lps[static_cast<std::size_t>(f)]);
        EXPECT_EQ(info.originalOrder.sourceAxis[axis], f);
        if (!(sliceOrderFree && f == 2)) {
            EXPECT_EQ(info.originalOrder.flipped[axis], layout.flipped[static_cast<std::size_t>(f)]);
        }
    }
}

NiftiImage niftiOf(const Layout& layout) {
    NiftiImage image;
    const glm::ivec3 n = layout.extent();
    image.extent = {n.x, n.y, n.z};
    const glm::dvec3 toRas{-1, -1, 1};
    for (std::size_t row = 0; row < 3; ++row) {
        const int r = static_cast<int>(row);
        for (int column = 0; column < 3; ++column)
            image.srow[4 * row + static_cast<std::size_t>(column)] = toRas[r] * layout.step(column)[r];
        image.srow[4 * row + 3] = toRas[r] * layout.position({0, 0, 0})[r];
    }
    image.voxels = layout.bytes();
    return image;
}

TEST(ImportOrientation, NiftiInEveryOrderGivesOneVolume) {
    const ScratchFolder folder;
    int n = 0;
    for (const Layout& layout : allLayouts()) {
        SCOPED_TRACE(n);
        NiftiImage image = niftiOf(layout);
        image.version = 1 + n % 2; // both versions, plain and gzip, share the 48 orders
        const bool compressed = n / 2 % 2 == 1;
        const auto path = folder / (compressed ? "a.nii.gz" : "a.nii");
        writeFile(path, compressed ? gzip(niftiBytes(image)) : niftiBytes(image));
        const auto source = openSource(path, {.scratchFolder = folder.path()});
        expectPhantom(*source, layout, 1e-9);
        ++n;
    }
    EXPECT_EQ(n, 48);
}

TEST(ImportOrientation, RawInEveryOrderGivesOneVolume) {
    const ScratchFolder folder;
    for (const Layout& layout : allLayouts()) {
        const glm::ivec3 n = layout.extent();
        const glm::dvec3 origin = layout.position({0, 0, 0});
        const auto list = [](auto a, auto b, auto c) {
            return "[" + std::to_string(a) + "," + std::to_string(b) + "," + std::to_string(c) + "]";
        };
        std::string direction;
        for (int row = 0; row < 3; ++row)
            for (int column = 0; column < 3; ++column)
                direction += (direction.empty() ? "" : ",") + std::to_string(layout.direction(column)[row]);
        const glm::dvec3 spacing{glm::length(layout.step(0)), glm::length(layout.step(1)),
                                 glm::length(layout.step(2))};
        writeFile(folder / "a.raw", layout.bytes());
        writeFile(folder / "a.json", R"({"data":"a.raw","type":"int16","extent":)" + list(n.x, n.y, n.z) +
                                         ",\"spacing\":" + list(spacing.x, spacing.y, spacing.z) +
                                         ",\"origin\":" + list(origin.x, origin.y, origin.z) +
                                         ",\"direction\":[" + direction + "]}");
        const auto source = openSource(folder / "a.json", {});
        expectPhantom(*source, layout, 1e-9);
    }
}

std::string wordsWith(const glm::dvec3& v, const char* between) {
    return std::to_string(v.x) + between + std::to_string(v.y) + between + std::to_string(v.z);
}

// NRRD and MetaImage: plain (read by position) and packed (forward) share the 48 orders.
TEST(ImportOrientation, NrrdAndMetaImageInEveryOrderGiveOneVolume) {
    const ScratchFolder folder;
    int n = 0;
    for (const Layout& layout : allLayouts()) {
        SCOPED_TRACE(n);
        const bool isPacked = n % 2 == 1;
        const std::string data = isPacked ? gzip(layout.bytes()) : layout.bytes();
        const glm::ivec3 size = layout.extent();
        const std::string sizes =
            std::to_string(size.x) + " " + std::to_string(size.y) + " " + std::to_string(size.z) + "\n";
        std::string steps, directions, spacings;
        const glm::dvec3 toRas{-1, -1, 1};
        for (int f = 0; f < 3; ++f) {
            steps += " (" + wordsWith(toRas * layout.step(f), ",") + ")";
            directions += " " + wordsWith(layout.direction(f), " ");
            spacings += " " + std::to_string(glm::length(layout.step(f)));
        }
        const glm::dvec3 origin = layout.position({0, 0, 0});
        writeFile(folder / "a.nrrd", "NRRD0004\ntype: short\ndimension: 3\nsizes: " + sizes +
                                         "endian: little\nspace: RAS\nspace directions:" + steps +
                                         "\nspace origin: (" + wordsWith(toRas * origin, ",") +
                                         ")\nencoding: " + (isPacked ? "gzip" : "raw") + "\n\n" + data);
        writeFile(
            folder / "a.mha",
            "ObjectType = Image\nNDims = 3\nCompressedData = " + std::string(isPacked ? "True" : "False") +
                "\nElementByteOrderMSB = False\nTransformMatrix =" + directions +
                "\nOffset = " + wordsWith(origin, " ") + "\nElementSpacing =" + spacings +
                "\nDimSize = " + sizes + "ElementType = MET_SHORT\nElementDataFile = LOCAL\n" + data);
        for (const char* name : {"a.nrrd", "a.mha"})
            expectPhantom(*openSource(folder / name, {.scratchFolder = folder.path()}), layout, 1e-9);
        ++n;
    }
}

TEST(ImportOrientation, DicomInEveryOrderGivesOneVolume) {
    const ScratchFolder folder;
    int number = 0;
    for (const Layout& layout : allLayouts()) {
        SCOPED_TRACE(number);
        const auto series = folder / std::to_string(number++);
        std::filesystem::create_directory(series);
        const glm::ivec3 n = layout.extent();
        const auto voxels = layout.voxels();
        const std::size_t perSlice = static_cast<std::size_t>(n.x * n.y);
        for (int z = 0; z < n.z; ++z) {
            DicomImage image;
            image.columns = n.x;
            image.rows = n.y;
            image.rowDirection = layout.direction(0);
            image.columnDirection = layout.direction(1);
            image.spacingX = glm::length(layout.step(0));
            image.spacingY = glm::length(layout.step(1));
            image.position = layout.position({0, 0, z});
            for (std::size_t i = 0; i < perSlice; ++i)
                image.pixels.push_back(
                    static_cast<std::uint16_t>(voxels[static_cast<std::size_t>(z) * perSlice + i] + 1024));
            writeDicom(series / (std::to_string(z * 11 % n.z) + ".dcm"), image); // names shuffled
        }
        const auto source = openSource(series, {});
        expectPhantom(*source, layout, 1e-6, true); // slices have no order of their own
    }
}

TEST(ImportOrientation, ObliqueAndShearedAffinesAreKept) {
    // Columns near L, P, S but turned by 20 degrees and sheared: nothing to move, nothing changed.
    VolumeInfo info;
    info.extentVoxels = {4, 5, 6};
    info.patientFromVoxel = patientFromVoxelOf({1, 2, 3}, {0.9, 0.3, 0}, {-0.3, 0.9, 0}, {0, 0.4, 1.2});
    EXPECT_EQ(nearestLpsOrder(info.patientFromVoxel), AxisOrder{});
    EXPECT_EQ(orientedInfo(info).patientFromVoxel, info.patientFromVoxel);
    // Two source axes nearest to one patient axis must still become two axes.
    const auto order = nearestLpsOrder(patientFromVoxelOf({0, 0, 0}, {1, 0, 0}, {0.9, 0.5, 0}, {0, 0, 1}));
    EXPECT_EQ(order, AxisOrder{});
}

} // namespace
} // namespace tessera::test
