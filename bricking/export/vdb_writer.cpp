// bricking/export/vdb_writer.cpp: OpenVDB files: one grid, a fog volume, of physical values as floats, or as
// halves on disk. Index (i,j,k) is the centre of a voxel, and the grid's transform leads from it to the
// patient (LPS, mm). The background is the lowest value of the box: air. A voxel is active where it has
// another. The library holds a grid as a whole, so RAM limits the box.
#include "bricking/export/exported_place.h"
#include "bricking/export/exported_values.h"
#include "bricking/export/volume_file.h"
#include "bricking/export/volume_writer.h"
#include "core/base/error.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <openvdb/io/Archive.h>
#include <openvdb/math/Transform.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Dense.h>
#include <optional>
#include <ostream>
#include <streambuf>
#include <vector>

namespace tessera {
namespace {

/// What the library writes, in the file; its faults leave as exceptions.
class VdbBuffer final : public std::streambuf {
  public:
    VdbBuffer(const std::filesystem::path& path, Existing existing)
        : file_(path, existing), kept_(std::size_t{1} << 20) {}
    /// The first failure of writing, if any.
    void rethrow() const {
        if (failure_)
            std::rethrow_exception(failure_);
    }
    void finish() {
        flush();
        rethrow();
        file_.finish();
    }
    std::uint64_t size() const { return size_; }

  protected:
    int_type overflow(int_type c) override {
        if (traits_type::eq_int_type(c, traits_type::eof()))
            return traits_type::not_eof(c);
        const char one = traits_type::to_char_type(c);
        return xsputn(&one, 1) == 1 ? c : traits_type::eof();
    }
    std::streamsize xsputn(const char* text, std::streamsize count) override {
        const auto bytes = std::as_bytes(std::span(text, static_cast<std::size_t>(count)));
        if (used_ + bytes.size() > kept_.size() && !flush())
            return 0;
        if (bytes.size() > kept_.size())
            return write(bytes) ? count : 0;
        std::copy(bytes.begin(), bytes.end(), kept_.begin() + static_cast<std::ptrdiff_t>(used_));
        used_ += bytes.size();
        return count;
    }
    pos_type seekoff(off_type by, std::ios_base::seekdir from, std::ios_base::openmode) override {
        if (!flush())
            return pos_type(off_type(-1));
        const std::uint64_t base = from == std::ios_base::cur ? at_ : from == std::ios_base::end ? size_ : 0;
        at_ = base + static_cast<std::uint64_t>(by);
        return pos_type(static_cast<off_type>(at_));
    }
    pos_type seekpos(pos_type to, std::ios_base::openmode which) override {
        return seekoff(off_type(to), std::ios_base::beg, which);
    }
    int sync() override { return flush() ? 0 : -1; }

  private:
    bool flush() {
        const bool isWritten = used_ == 0 || write(std::span(kept_).first(used_));
        used_ = 0;
        return isWritten;
    }
    bool write(std::span<const std::byte> bytes) {
        try {
            file_.writeAt(at_, bytes);
        } catch (...) {
            failure_ = failure_ ? failure_ : std::current_exception();
            return false;
        }
        at_ += bytes.size();
        size_ = std::max(size_, at_);
        return true;
    }
    OutputFile file_;
    std::vector<std::byte> kept_;
    std::size_t used_ = 0;
    std::uint64_t at_ = 0, size_ = 0;
    std::exception_ptr failure_;
};

/// An archive in any stream, with the offsets of grids that readers of parts need.
class VdbArchive final : public openvdb::io::Archive {
  public:
    void put(std::ostream& out, const openvdb::GridCPtrVec& grids) const { write(out, grids, true); }
    using Archive::write;
};

openvdb::math::Transform::Ptr vdbTransform(const VolumeInfo& info) {
    const ExportedPlace place = placeOf(info);
    openvdb::Mat4R matrix = openvdb::Mat4R::identity(); // of row vectors
    for (int axis = 0; axis < 3; ++axis)
        for (int at = 0; at < 3; ++at)
            matrix(axis, at) = place.step[static_cast<std::size_t>(axis)][at];
    for (int at = 0; at < 3; ++at)
        matrix(3, at) = place.firstCentre[at];
    return openvdb::math::Transform::createLinearTransform(matrix);
}

/// Most bytes of the leaves that some slices of the box touch.
std::size_t bytesOfLeaves(const glm::ivec3& extent, int slices) {
    using Leaf = openvdb::FloatTree::LeafNodeType;
    constexpr std::size_t kBytes = sizeof(Leaf) + Leaf::SIZE * sizeof(float) + 64; // and its place above
    const glm::ivec3 leaves = ceilDiv(glm::ivec3(extent.x, extent.y, slices), Leaf::DIM) + 1;
    return kBytes * cellCount(leaves);
}

ExportReport writeGrid(BoxSource& box, const ExportRequest& request, bool asHalf) {
    openvdb::initialize();
    const VolumeInfo& info = box.info();
    VdbBuffer buffer(request.out, request.existing());
    const ExportedValues values{FileType::f32, info.rescaleSlope, info.rescaleIntercept, false};
    const ValueRange range = storedRange(box, request.ram, request.progress);
    const auto background = static_cast<float>(
        info.rescaleSlope * (info.rescaleSlope > 0 ? range.least : range.most) + info.rescaleIntercept);
    constexpr double kMostHalf = 65504;
    for (const double stored : {range.least, range.most}) {
        const double value = info.rescaleSlope * stored + info.rescaleIntercept;
        if (asHalf && std::abs(value) > kMostHalf)
            throw badFile(request.out.string(), "values from -65504 to 65504, which halves hold",
                          std::to_string(value) + "; --format vdb has floats");
    }
    const openvdb::FloatGrid::Ptr grid = openvdb::FloatGrid::create(background);
    grid->setName("density");
    grid->setGridClass(openvdb::GRID_FOG_VOLUME);
    grid->setTransform(vdbTransform(info));
    grid->setSaveFloatAsHalf(asHalf);
    grid->insertMeta("unit", openvdb::StringMetadata(info.unit));
    // So that a volume with margins of the background comes back as it was.
    const glm::ivec3 n = info.extentVoxels;
    grid->insertMeta("tessera_extent", openvdb::Vec3IMetadata(openvdb::Vec3i(n.x, n.y, n.z)));
    if (info.orientationKnown)
        grid->insertMeta("tessera_space", openvdb::StringMetadata("left-posterior-superior, mm"));
    const std::string what = "the grid, which OpenVDB holds as a whole; a box or a --level takes less";
    const std::size_t sliceValues = static_cast<std::size_t>(n.x) * static_cast<std::size_t>(n.y);
    request.progress.stage("making the grid of " + request.out.string());
    std::optional<Charge> held;
    std::vector<float> numbers;
    const std::size_t slab =
        static_cast<std::size_t>(std::min(n.z, kChunkExtent)) * sliceValues * sizeof(float);
    const Charge floats = request.ram.charge(slab, "slices as floats");
    streamSlices(
        box, request.ram, request.progress,
        [&](int first, int count, std::span<const std::byte> stored) {
            const Charge adding = request.ram.charge(bytesOfLeaves(n, count), what);
            numbers.resize(static_cast<std::size_t>(count) * sliceValues);
            convertValues(info.type, stored, values, std::as_writable_bytes(std::span(numbers)));
            const openvdb::CoordBBox place(openvdb::Coord(0, 0, first),
                                           openvdb::Coord(n.x - 1, n.y - 1, first + count - 1));
            const openvdb::tools::Dense<float, openvdb::tools::LayoutXYZ> dense(place, numbers.data());
            openvdb::tools::copyFromDense(dense, *grid, 0.f);
            held.reset();
            held = request.ram.charge(static_cast<std::size_t>(grid->memUsage()), what);
        },
        bytesOfLeaves(n, std::min(n.z, kChunkExtent)));
    request.progress.stage("writing " + request.out.string());
    VdbArchive archive;
    archive.setCompression(openvdb::io::COMPRESS_ACTIVE_MASK |
                           (request.compress ? openvdb::io::COMPRESS_BLOSC : openvdb::io::COMPRESS_NONE));
    std::ostream out(&buffer);
    try {
        archive.put(out, {grid});
    } catch (const openvdb::Exception& problem) {
        buffer.rethrow();
        throw Error(request.out.string() + ": OpenVDB cannot write it: " + problem.what());
    }
    if (!out.good()) {
        buffer.rethrow();
        throw Error(request.out.string() + ": OpenVDB could not write it");
    }
    buffer.finish();
    ExportReport report{buffer.size(), sayValues(info, values, false), {}};
    if (asHalf)
        report.notes.emplace_back("values are rounded to halves: whole numbers are exact up to 2048");
    return report;
}

} // namespace

ExportReport writeVdb(BoxSource& box, const ExportRequest& request) {
    return writeGrid(box, request, false);
}

ExportReport writeHalfVdb(BoxSource& box, const ExportRequest& request) {
    return writeGrid(box, request, true);
}

} // namespace tessera
