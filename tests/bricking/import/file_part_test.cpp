// tests/bricking/import/file_part_test.cpp: a part of a file as the volume: levels of files that have
// several, and boxes, by sources of every kind, in every orientation.
#include "bricking/import/catalogue.h"
#include "bricking/import/file_part.h"
#include "bricking/import/source/file_levels.h"
#include "bricking/import/source/oriented_source.h"
#include "bricking/remote/http_files.h"
#include "bricking/store/remote_files.h"
#include "tests/support/hdf5_corpus.h"
#include "tests/support/http_server.h"
#include "tests/support/zarr_label_image.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <glm/gtc/matrix_transform.hpp>
#include <gmock/gmock.h>
#include <random>
#include <vector>

namespace tessera::test {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
namespace fs = std::filesystem;

int below(std::mt19937& random, int end) {
    return static_cast<int>(random() % static_cast<unsigned>(end));
}

FileBox anyBox(std::mt19937& random, const glm::ivec3& extent) {
    FileBox box;
    for (int axis = 0; axis < 3; ++axis) {
        box.low[axis] = below(random, extent[axis]);
        box.high[axis] = box.low[axis] + 1 + below(random, extent[axis] - box.low[axis]);
    }
    return box;
}

/// What sources of files can do.
enum class Ways { forward, seeking, random, rows };

/// Every voxel has a value of its own.
struct Counted {
    VolumeInfo info;
    int* slicesRead;
    void rows(int z, int first, int count, std::span<std::byte> out) const {
        ASSERT_EQ(out.size(), rowBytesOf(info) * static_cast<std::size_t>(count));
        for (int y = first; y < first + count; ++y)
            for (int x = 0; x < info.extentVoxels.x; ++x, out = out.subspan(2)) {
                const auto value = static_cast<std::uint16_t>(indexOf(info, x, y, z) * 7919);
                std::memcpy(out.data(), &value, 2);
            }
    }
    void slice(int z, std::span<std::byte> out) const {
        ++*slicesRead;
        rows(z, 0, info.extentVoxels.y, out);
    }
};

class ForwardSource final : public SlabSource {
  public:
    ForwardSource(const VolumeInfo& info, int* read, bool seeks) : of_{info, read}, seeks_(seeks) {}
    const VolumeInfo& info() const override { return of_.info; }
    std::string describe() const override { return "slices that are counted"; }
    bool seek(int z) override {
        next_ = seeks_ ? z : next_;
        return seeks_;
    }
    void readSlices(int count, std::span<std::byte> out) override {
        const std::size_t bytes = sliceBytesOf(info());
        for (int i = 0; i < count; ++i)
            of_.slice(next_++, out.subspan(static_cast<std::size_t>(i) * bytes, bytes));
    }

  private:
    Counted of_;
    bool seeks_;
    int next_ = 0;
};

class RandomSource final : public RandomSlabSource {
  public:
    RandomSource(const VolumeInfo& info, int* read, bool hasRows) : of_{info, read}, hasRows_(hasRows) {}
    const VolumeInfo& info() const override { return of_.info; }
    std::string describe() const override { return "slices that are counted"; }
    RowAccess rowAccess() const override { return hasRows_ ? RowAccess::any : RowAccess::none; }
    void readRows(int z, int first, int count, std::span<std::byte> out) override {
        of_.rows(z, first, count, out);
    }
    void readSliceAt(int z, std::span<std::byte> out) override { of_.slice(z, out); }

  private:
    Counted of_;
    bool hasRows_;
};

std::unique_ptr<SlabSource> sourceOf(Ways ways, const VolumeInfo& info, int* read) {
    if (ways == Ways::forward || ways == Ways::seeking)
        return std::make_unique<ForwardSource>(info, read, ways == Ways::seeking);
    return std::make_unique<RandomSource>(info, read, ways == Ways::rows);
}

/// Axes in any order, either way, oblique.
glm::dmat4 anyAffine(std::mt19937& random) {
    std::array<int, 3> axes = {0, 1, 2};
    std::shuffle(axes.begin(), axes.end(), random);
    std::array<glm::dvec3, 3> step{};
    for (std::size_t i = 0; i < 3; ++i) {
        for (int part = 0; part < 3; ++part)
            step[i][part] = 0.05 * below(random, 5);
        step[i][axes[i]] = (below(random, 2) ? 1 : -1) * (0.5 + 0.25 * below(random, 5));
    }
    return patientFromVoxelOf({-30.25, 17, 4.5}, step[0], step[1], step[2]);
}

/// Every voxel of a part is the whole's voxel at its place.
void expectPartOf(SlabSource& part, const VolumeInfo& whole, const std::vector<std::uint16_t>& values) {
    const VolumeInfo info = part.info();
    const std::vector<std::uint16_t> found = readAll<std::uint16_t>(part);
    const glm::dmat4 wholeFromPatient = glm::inverse(whole.patientFromVoxel);
    for (int z = 0; z < info.extentVoxels.z; ++z)
        for (int y = 0; y < info.extentVoxels.y; ++y)
            for (int x = 0; x < info.extentVoxels.x; ++x) {
                const glm::dvec3 at(wholeFromPatient * glm::dvec4(centreMm(info, x, y, z), 1));
                const glm::ivec3 voxel(glm::floor(at));
                ASSERT_LT(glm::length(at - 0.5 - glm::dvec3(voxel)), 1e-6) << "between voxels";
                ASSERT_EQ(found[indexOf(info, x, y, z)], values[indexOf(whole, voxel.x, voxel.y, voxel.z)]);
            }
}

TEST(FilePart, EveryVoxelOfABoxIsThatOfTheWholeAtItsPlace) {
    std::mt19937 random(11);
    for (int trial = 0; trial < 120; ++trial) {
        const auto ways = static_cast<Ways>(trial % 4);
        VolumeInfo info;
        info.type = ValueType::u16;
        info.extentVoxels = {1 + below(random, 7), 1 + below(random, 6), 1 + below(random, 8)};
        info.patientFromVoxel = anyAffine(random);
        SCOPED_TRACE(trial);
        int read = 0;
        const auto open = [&](const SourceOptions&) { return sourceOf(ways, info, &read); };
        const auto whole = orientToLps(open({}), {});
        const auto values = readAll<std::uint16_t>(*whole);
        SourceOptions options;
        options.fileBox = anyBox(random, whole->info().extentVoxels);
        const auto part = orientToLps(openFilePart(open, options, "it"), {});
        EXPECT_EQ(part->info().extentVoxels, options.fileBox->high - options.fileBox->low);
        ASSERT_TRUE(part->info().filePart);
        EXPECT_EQ(part->info().filePart->box, *options.fileBox);
        EXPECT_EQ(part->info().filePart->levelVoxels, whole->info().extentVoxels);
        EXPECT_EQ(part->info().originalOrder, whole->info().originalOrder);
        read = 0;
        expectPartOf(*part, whole->info(), values);
        const FileBox box = alongSourceAxes(whole->info(), *options.fileBox);
        EXPECT_LE(read, ways == Ways::forward ? box.high.z : box.high.z - box.low.z) << "only its slices";
        if (ways != Ways::forward) { // from any slice on
            const auto again = openFilePart(open, options, "it");
            std::vector<std::byte> slice(sliceBytesOf(again->info())), last = slice;
            for (int z = 0; z < again->info().extentVoxels.z; ++z)
                again->readSlices(1, last);
            ASSERT_TRUE(again->seek(again->info().extentVoxels.z - 1));
            again->readSlices(1, slice);
            EXPECT_EQ(slice, last);
        }
    }
}

TEST(FilePart, BoxesBeyondTheVolumeAreRefused) {
    VolumeInfo info;
    info.type = ValueType::u16;
    info.extentVoxels = {4, 5, 6};
    int read = 0;
    const auto open = [&](const SourceOptions&) { return sourceOf(Ways::random, info, &read); };
    for (const FileBox& box : {FileBox{{0, 0, 0}, {4, 5, 7}}, FileBox{{-1, 0, 0}, {1, 1, 1}},
                               FileBox{{2, 2, 2}, {2, 3, 3}}, FileBox{{4, 0, 0}, {5, 1, 1}}}) {
        SourceOptions options;
        options.fileBox = box;
        EXPECT_THAT(refusal([&] { openFilePart(open, options, "it"); }),
                    AllOf(HasSubstr("it: "), HasSubstr("--file-box within 0,4,0,5,0,6")));
    }
    SourceOptions options;
    options.fileLevel = 1;
    EXPECT_THAT(refusal([&] { openFilePart(open, options, "it"); }), HasSubstr("a file of several levels"));
}

// Levels.

/// An image of OME-Zarr in which each level halves the one before; values differ from level to level.
struct WrittenLevels {
    std::vector<std::vector<std::size_t>> shapes;
    std::vector<std::vector<std::uint32_t>> values;
};
WrittenLevels writeLevels(const fs::path& group, WrittenZarr zarr, int levels,
                          const glm::dvec3& shift = glm::dvec3(0)) {
    WrittenLevels written;
    Json datasets = Json::array(), axes = Json::array();
    for (const char* const name : {"z", "y", "x"})
        axes.push_back({{"name", name}, {"type", "space"}, {"unit", "millimeter"}});
    for (int level = 0; level < levels; ++level) {
        const double pitch = std::ldexp(1.0, level);
        const Json scale = {2 * pitch, 0.5 * pitch, 0.25 * pitch};
        const glm::dvec3 first = (pitch - 1) / 2 * glm::dvec3(2, 0.5, 0.25) +
                                 (level > 0 ? pitch * shift * glm::dvec3(2, 0.5, 0.25) : glm::dvec3(0));
        const Json placed = Json::array(
            {{{"type", "scale"}, {"scale", scale}},
             {{"type", "translation"}, {"translation", {first.x - 100, first.y + 20, first.z + 30}}}});
        const Json row = {{"path", std::to_string(level)}, {"coordinateTransformations", placed}};
        datasets.insert(datasets.begin(), row); // the coarsest comes first
        std::size_t count = 1;
        for (const std::size_t side : zarr.shape)
            count *= side;
        written.shapes.push_back(zarr.shape);
        written.values.emplace_back();
        for (std::size_t n = 0; n < count; ++n) // none is the fill
            written.values.back().push_back(static_cast<std::uint32_t>(1 + level + n * 7919 % 60000));
        writeZarrArray(group / std::to_string(level), zarr, written.values.back());
        for (std::size_t& side : zarr.shape)
            side = (side + 1) / 2;
    }
    Json scales = {{"axes", axes}, {"datasets", datasets}}, ome = Json::object();
    (zarr.version == 2 ? scales : ome)["version"] = zarr.version == 2 ? "0.4" : "0.5";
    ome["multiscales"] = Json::array({scales});
    writeZarrGroup(group, zarr.version, ome);
    return written;
}

WrittenZarr smallZarr(int version = 3) {
    WrittenZarr zarr;
    zarr.version = version;
    zarr.shape = {11, 14, 9};
    zarr.chunk = {3, 4, 5};
    return zarr;
}

std::vector<std::uint16_t> asU16(const std::vector<std::uint32_t>& values) {
    return {values.begin(), values.end()};
}

TEST(FilePart, LevelsOfOmeZarrHaveTheirOwnPlacesAndValues) {
    const ScratchFolder folder;
    for (const int version : {2, 3}) {
        const fs::path path = folder / ("levels" + std::to_string(version));
        const WrittenLevels written = writeLevels(path, smallZarr(version), 4);
        const Catalogue catalogue = lookThrough(path);
        const std::vector<VolumeInfo> levels = fileLevelsOf(catalogue, catalogue.rows.front(), {});
        ASSERT_EQ(levels.size(), 4u);
        for (int level = 0; level < 4; ++level) {
            SourceOptions options;
            options.fileLevel = level;
            const auto source = openSource(path, options);
            const VolumeInfo info = source->info();
            const auto n = static_cast<std::size_t>(level);
            EXPECT_EQ(info.extentVoxels, levels[n].extentVoxels);
            EXPECT_EQ(info.patientFromVoxel, levels[n].patientFromVoxel);
            EXPECT_EQ(info.spacingMm(), std::ldexp(1.0, level) * glm::dvec3(0.25, 0.5, 2));
            EXPECT_EQ(info.filePart.has_value(), level > 0);
            EXPECT_THAT(info.remarks, IsEmpty()) << "each level begins where the finest does";
            EXPECT_EQ(readAll<std::uint16_t>(*source), asU16(written.values[n]));
        }
        SourceOptions options;
        options.fileLevel = 4;
        EXPECT_THAT(refusalOfOpening(path, options), HasSubstr("--file-level from 0 (finest) to 3"));
        // As many bytes as a level has take that level.
        EXPECT_EQ(levelWithin(levels, 2 * 11 * 14 * 9), 0);
        EXPECT_EQ(levelWithin(levels, 2 * 11 * 14 * 9 - 1), 1);
        EXPECT_EQ(levelWithin(levels, 2 * 3 * 4 * 3), 2);
        EXPECT_EQ(levelWithin(levels, 1), 3) << "the coarsest where none is as small";
    }
}

TEST(FilePart, ALevelThatLiesElsewhereIsTold) {
    const ScratchFolder folder;
    const std::vector<std::pair<glm::dvec3, bool>> shifts = {
        {{0, 0.49, 0}, false}, {{0, 0.51, 0}, true}, {{0, 0, -0.51}, true}};
    for (const auto& [shift, told] : shifts) { // z, y, x, in voxels of the level
        const fs::path path = folder / std::to_string(shift.y + shift.z);
        writeLevels(path, smallZarr(), 2, shift);
        SourceOptions options;
        options.fileLevel = 1;
        const auto source = openSource(path, options);
        if (told)
            EXPECT_THAT(source->info().remarks, ElementsAre(HasSubstr("does not lie over the finest one")));
        else
            EXPECT_THAT(source->info().remarks, IsEmpty());
    }
}

/// Files of chunks that a box of an array does not touch become damaged.
void damageOutside(const fs::path& array, const WrittenZarr& zarr, const FileBox& box) {
    const std::vector<std::size_t>& side = zarr.shard.empty() ? zarr.chunk : zarr.shard;
    const std::array<int, 3> low = {box.low.z, box.low.y, box.low.x},
                             high = {box.high.z, box.high.y, box.high.x};
    std::vector<std::size_t> grid;
    for (std::size_t axis = 0; axis < 3; ++axis)
        grid.push_back((zarr.shape[axis] - 1) / side[axis] + 1);
    eachPlace(grid, [&](const std::vector<std::size_t>& at) {
        bool isTouched = true;
        for (std::size_t axis = 0; axis < 3; ++axis)
            isTouched = isTouched && static_cast<int>(at[axis] * side[axis]) < high[axis] &&
                        static_cast<int>((at[axis] + 1) * side[axis]) > low[axis];
        const fs::path file = array / (zarr.version == 3 ? "c" : "") / std::to_string(at[0]) /
                              std::to_string(at[1]) / std::to_string(at[2]);
        if (!isTouched && fs::exists(file))
            std::ofstream(file, std::ios::binary) << "damage";
    });
}

TEST(FilePart, OfAZarrOnlyTheChunksThatTheBoxTouchesAreRead) {
    const ScratchFolder folder;
    std::mt19937 random(3);
    for (int trial = 0; trial < 24; ++trial) {
        SCOPED_TRACE(trial);
        WrittenZarr zarr = smallZarr(trial % 2 ? 3 : 2);
        if (trial % 4 == 3)
            zarr.shard = {6, 8, 10};
        if (trial % 3 == 1)
            zarr.order = {2, 1, 0};
        const fs::path path = folder / std::to_string(trial);
        writeLevels(path, zarr, 2);
        SourceOptions options;
        options.fileLevel = trial % 5 == 0 ? 1 : 0;
        const auto whole = openSource(path, options);
        const VolumeInfo info = whole->info();
        const auto values = readAll<std::uint16_t>(*whole);
        options.fileBox = anyBox(random, info.extentVoxels);
        if (options.fileLevel == 1)
            for (std::size_t& side : zarr.shape)
                side = (side + 1) / 2;
        damageOutside(path / std::to_string(options.fileLevel), zarr, *options.fileBox);
        const auto part = openSource(path, options);
        EXPECT_LE(part->roomBytes(), whole->roomBytes());
        expectPartOf(*part, info, values);
    }
}

TEST(FilePart, BehindAnAddressOnlyTheChunksOfABoxAreFetched) {
    const ScratchFolder served, kept;
    WrittenZarr zarr;
    zarr.shape = {32, 32, 32};
    zarr.chunk = {4, 4, 4};
    const WrittenLevels written = writeLevels(served / "a.zarr", zarr, 2);
    HttpServer server{served.path()};
    const std::string address = server.address("a.zarr");
    makeReachable(address, openRemoteFiles(address, {kept.path(), std::uint64_t{1} << 30}));
    SourceOptions options;
    options.fileBox = FileBox{{3, 8, 17}, {9, 12, 20}}; // chunks: 3 along x, 1 along y, 1 along z
    const auto part = openSource(address, options);
    EXPECT_EQ(readAll<std::uint16_t>(*part).size(), 6u * 4 * 3);
    const auto chunks = std::ranges::count_if(
        server.asked(), [](const AskedOf& one) { return one.target.find("/c/") != std::string::npos; });
    EXPECT_EQ(chunks, 3);
}

TEST(FilePart, BoxesOfHdf5AreTheSameOfEveryLayout) {
    std::mt19937 random(17);
    int boxes = 0;
    for (const fs::path& path : hdf5Files(false)) {
        const std::vector<Hdf5Volume> wholes = openHdf5Volumes(path);
        for (int trial = 0; trial < 4; ++trial) {
            std::vector<Hdf5Volume> parts = openHdf5Volumes(path);
            for (std::size_t n = 0; n < parts.size(); ++n) {
                SlabSource& part = *parts[n].source;
                const VolumeInfo whole = wholes[n].source->info();
                const FileBox box = anyBox(random, whole.extentVoxels);
                ASSERT_TRUE(part.crop(box));
                const std::vector<double> found = valuesOf(part);
                const auto again = openHdf5Volumes(path);
                const std::vector<double> values = valuesOf(*again[n].source);
                const VolumeInfo& info = part.info();
                EXPECT_LT(
                    glm::distance(centreMm(info, 0, 0, 0), centreMm(whole, box.low.x, box.low.y, box.low.z)),
                    1e-9);
                for (int z = 0; z < info.extentVoxels.z; ++z)
                    for (int y = 0; y < info.extentVoxels.y; ++y)
                        for (int x = 0; x < info.extentVoxels.x; ++x)
                            ASSERT_EQ(found[indexOf(info, x, y, z)],
                                      values[indexOf(whole, x + box.low.x, y + box.low.y, z + box.low.z)])
                                << path << " " << parts[n].name << " " << x << " " << y << " " << z;
                ++boxes;
            }
        }
    }
    EXPECT_GT(boxes, 100);
}

TEST(FilePart, LevelsOfImarisHaveTheImagesBox) {
    const fs::path path = hdf5Corpus() / "levels.ims";
    const auto finest = openSource(path, {});
    const PatientBox box = patientBoxOf(finest->info());
    for (int level = 0; level < 3; ++level) {
        SourceOptions options;
        options.fileLevel = level;
        const auto source = openSource(path, options);
        const VolumeInfo& info = source->info();
        EXPECT_EQ(info.extentVoxels, (std::array{glm::ivec3(7, 6, 5), glm::ivec3(4, 3, 3),
                                                 glm::ivec3(2, 2, 2)}[static_cast<std::size_t>(level)]));
        EXPECT_LT(glm::length(patientBoxOf(info).low - box.low), 1e-9);
        EXPECT_LT(glm::length(patientBoxOf(info).high - box.high), 1e-9);
        EXPECT_THAT(info.remarks, IsEmpty());
        const std::vector<double> values = valuesOf(*source);
        EXPECT_EQ(values[indexOf(info, 1, 1, 1)], 10000 * level + 111);
    }
    SourceOptions options;
    options.fileLevel = 3;
    EXPECT_THAT(refusalOfOpening(path, options), HasSubstr("--file-level from 0 (finest) to 2"));
    EXPECT_THAT(refusalOfOpening(hdf5Corpus() / "spacing_earliest.h5", options),
                HasSubstr("a file of several levels"));
}

} // namespace
} // namespace tessera::test
