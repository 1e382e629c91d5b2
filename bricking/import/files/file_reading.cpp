// bricking/import/files/file_reading.cpp: see file_reading.h.
#include "bricking/import/files/file_reading.h"

#include "bricking/import/source/slice_converter.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"

#include <algorithm>
#include <utility>
#include <vector>
#include <zlib.h>

namespace tessera {
namespace {

constexpr std::size_t kRowsAtOnce = std::size_t{4} << 20; // of a slice that is read and converted at once

/// Calls body(first, count) for runs of rows of at most kRowsAtOnce each.
template <typename Body> void eachPiece(int rows, std::size_t rowBytes, const Body& body) {
    const int most = static_cast<int>(
        std::clamp<std::size_t>(kRowsAtOnce / rowBytes, 1, static_cast<std::size_t>(std::max(rows, 1))));
    for (int first = 0; first < rows; first += most)
        body(first, std::min(most, rows - first));
}

class PlainFileSource final : public RandomSlabSource {
  public:
    PlainFileSource(InputFile file, const VolumeInfo& info, const VoxelLayout& layout,
                    std::string description)
        : file_(std::move(file)), info_(info), layout_(layout), description_(std::move(description)),
          converter_(layout.type, layout.bigEndian, [this](const auto& visit) {
              std::vector<std::byte> piece;
              for (int z = 0; z < info_.extentVoxels.z; ++z) {
                  checkInterrupted();
                  eachPiece(info_.extentVoxels.y, fileRowBytes(), [&](int first, int count) {
                      piece.resize(fileRowBytes() * static_cast<std::size_t>(count));
                      readFileRows(z, first, piece);
                      visit(piece);
                  });
              }
          }) {}

    const VolumeInfo& info() const override { return info_; }
    std::string describe() const override { return description_; }
    VoxelTally takeTally() override { return converter_.takeTally(); }

    void readSliceAt(int z, std::span<std::byte> out) override { readRows(z, 0, info_.extentVoxels.y, out); }
    RowAccess rowAccess() const override { return RowAccess::any; }
    void readRows(int z, int first, int count, std::span<std::byte> out) override {
        const std::size_t rowBytes = rowBytesOf(info_);
        TESSERA_CHECK(z >= 0 && z < info_.extentVoxels.z && first >= 0 &&
                      first + count <= info_.extentVoxels.y &&
                      out.size() == rowBytes * static_cast<std::size_t>(count));
        eachPiece(count, fileRowBytes(), [&](int row, int rows) {
            const auto to = out.subspan(rowBytes * static_cast<std::size_t>(row),
                                        rowBytes * static_cast<std::size_t>(rows));
            if (converter_.keepsBytes()) {
                readFileRows(z, first + row, to);
                return converter_.count(to, info_);
            }
            buffer_.resize(fileRowBytes() * static_cast<std::size_t>(rows));
            readFileRows(z, first + row, buffer_);
            converter_.convert(buffer_, to, info_);
        });
    }

  private:
    std::size_t fileRowBytes() const {
        return static_cast<std::size_t>(info_.extentVoxels.x) * bytesPerFileValue(layout_.type);
    }
    void readFileRows(int z, int first, std::span<std::byte> out) const {
        const auto row = static_cast<std::uint64_t>(z) * layout_.sliceStep *
                             static_cast<std::uint64_t>(info_.extentVoxels.y) +
                         static_cast<std::uint64_t>(first);
        file_.readAt(layout_.offsetBytes + row * fileRowBytes(), out);
    }

    InputFile file_;
    VolumeInfo info_;
    VoxelLayout layout_;
    std::string description_;
    SliceConverter converter_;
    std::vector<std::byte> buffer_; // rows as they lie in the file
};

} // namespace

std::uint64_t voxelBytesInFile(const VolumeInfo& info, FileType type) {
    return info.voxelCount() * bytesPerFileValue(type);
}

std::unique_ptr<SlabSource> makePlainFileSource(InputFile file, const VolumeInfo& info,
                                                const VoxelLayout& layout, std::string description) {
    TESSERA_CHECK(info.type == storedTypeOf(layout.type));
    return std::make_unique<PlainFileSource>(std::move(file), info, layout, std::move(description));
}

// A file may hold several gzip members one after another (RFC 1952, 2.2); bytes after the requested ones are
// not checked.

namespace {
constexpr std::size_t kInputBytes = 64 * 1024;  // per read of the file
constexpr std::size_t kStepBytes = 1024 * 1024; // zlib counts in 32 bits
constexpr int kGzipWindow = 15 + 16;            // zlib: the largest window, gzip wrapper only
constexpr int kAnyWindow = 15 + 32;             // gzip or zlib wrapper
} // namespace

struct GzipStream::State {
    State(InputFile f, std::uint64_t offset, int window)
        : file(std::move(f)), input(kInputBytes), inputOffset(offset), window(window) {
        if (inflateInit2(&stream, window) != Z_OK)
            throw Error("zlib cannot start");
    }
    ~State() { inflateEnd(&stream); }
    State(const State&) = delete;
    State& operator=(const State&) = delete;

    InputFile file;
    std::vector<std::byte> input;
    std::uint64_t inputOffset = 0, outputOffset = 0;
    int window;
    z_stream stream{};
    bool atMemberEnd = false;
};

GzipStream::GzipStream(InputFile file, std::uint64_t offsetBytes, Wrapper wrapper)
    : state_(std::make_unique<State>(std::move(file), offsetBytes,
                                     wrapper == Wrapper::any ? kAnyWindow : kGzipWindow)) {}
GzipStream::~GzipStream() = default;
GzipStream::GzipStream(GzipStream&&) noexcept = default;

const InputFile& GzipStream::file() const {
    return state_->file;
}

/// One call of inflate into out; done is what it gave. True at the end of a member.
bool GzipStream::inflateStep(std::span<std::byte> out, std::size_t& done) {
    State& s = *state_;
    if (s.stream.avail_in == 0) {
        const std::size_t got = s.file.readSome(s.inputOffset, s.input);
        if (got == 0)
            throw badFile(s.file.path().string(),
                          "more data after decompressed byte " + std::to_string(s.outputOffset),
                          "the end of the file (is it truncated?)");
        s.inputOffset += got;
        s.stream.next_in = reinterpret_cast<Bytef*>(s.input.data());
        s.stream.avail_in = static_cast<uInt>(got);
    }
    const std::size_t step = std::min(out.size(), kStepBytes);
    s.stream.next_out = reinterpret_cast<Bytef*>(out.data());
    s.stream.avail_out = static_cast<uInt>(step);
    const int result = inflate(&s.stream, Z_NO_FLUSH);
    done = step - s.stream.avail_out;
    s.outputOffset += done;
    if (result != Z_OK && result != Z_BUF_ERROR && result != Z_STREAM_END)
        throw badFile(s.file.path().string(), "gzip data",
                      "damage near decompressed byte " + std::to_string(s.outputOffset));
    return result == Z_STREAM_END;
}

void GzipStream::read(std::span<std::byte> out) {
    while (!out.empty()) {
        std::size_t done = 0;
        state_->atMemberEnd = inflateStep(out, done);
        out = out.subspan(done);
        if (state_->atMemberEnd && !out.empty())
            inflateReset2(&state_->stream, state_->window);
    }
}

std::uint64_t GzipStream::finish() {
    std::vector<std::byte> rest(kInputBytes);
    std::size_t done = 0;
    std::uint64_t passed = 0;
    for (; !state_->atMemberEnd; passed += done)
        state_->atMemberEnd = inflateStep(rest, done);
    return passed;
}

namespace {

class ForwardFileSource final : public SlabSource {
  public:
    ForwardFileSource(std::function<std::unique_ptr<VoxelStream>()> open, const VolumeInfo& info,
                      FileType type, bool bigEndian, std::string description)
        : open_(std::move(open)), info_(info), type_(type), description_(std::move(description)),
          converter_(type, bigEndian, [this](const auto& visit) {
              const std::unique_ptr<VoxelStream> second = open_();
              std::vector<std::byte> piece;
              for (int z = 0; z < info_.extentVoxels.z; ++z) {
                  checkInterrupted();
                  eachPiece(info_.extentVoxels.y, fileRowBytes(), [&](int, int rows) {
                      piece.resize(fileRowBytes() * static_cast<std::size_t>(rows));
                      second->read(piece);
                      visit(piece);
                  });
              }
          }) {}

    const VolumeInfo& info() const override { return info_; }
    std::string describe() const override { return description_; }
    VoxelTally takeTally() override { return converter_.takeTally(); }

    void readSlices(int count, std::span<std::byte> out) override {
        const std::size_t sliceBytes = sliceBytesOf(info_);
        TESSERA_CHECK(count >= 0 && next_ + count <= info_.extentVoxels.z);
        TESSERA_CHECK(out.size() == static_cast<std::size_t>(count) * sliceBytes);
        for (int i = 0; i < count; ++i)
            readRows(next_, 0, info_.extentVoxels.y,
                     out.subspan(static_cast<std::size_t>(i) * sliceBytes, sliceBytes));
    }
    RowAccess rowAccess() const override { return RowAccess::inOrder; }
    void readRows(int z, int first, int count, std::span<std::byte> out) override {
        const std::size_t rowBytes = rowBytesOf(info_);
        TESSERA_CHECK(z == next_ && first == nextRow_ && first + count <= info_.extentVoxels.y &&
                      out.size() == rowBytes * static_cast<std::size_t>(count));
        if (!stream_)
            stream_ = open_();
        eachPiece(count, fileRowBytes(), [&](int row, int rows) {
            buffer_.resize(fileRowBytes() * static_cast<std::size_t>(rows));
            stream_->read(buffer_);
            converter_.convert(buffer_,
                               out.subspan(rowBytes * static_cast<std::size_t>(row),
                                           rowBytes * static_cast<std::size_t>(rows)),
                               info_);
        });
        nextRow_ += count;
        if (nextRow_ < info_.extentVoxels.y)
            return;
        nextRow_ = 0;
        if (++next_ == info_.extentVoxels.z)
            stream_->finish();
    }

  private:
    std::size_t fileRowBytes() const {
        return static_cast<std::size_t>(info_.extentVoxels.x) * bytesPerFileValue(type_);
    }

    std::function<std::unique_ptr<VoxelStream>()> open_;
    VolumeInfo info_;
    FileType type_;
    std::string description_;
    std::unique_ptr<VoxelStream> stream_;
    SliceConverter converter_;
    int next_ = 0, nextRow_ = 0;
    std::vector<std::byte> buffer_; // rows as they lie in the file
};

} // namespace

std::unique_ptr<SlabSource> makeForwardFileSource(std::function<std::unique_ptr<VoxelStream>()> open,
                                                  const VolumeInfo& info, FileType type, bool bigEndian,
                                                  std::string description) {
    TESSERA_CHECK(info.type == storedTypeOf(type));
    return std::make_unique<ForwardFileSource>(std::move(open), info, type, bigEndian,
                                               std::move(description));
}

} // namespace tessera
