// bricking/import/labels/nrrd/nrrd_data.cpp: see nrrd_data.h.
#include "bricking/import/labels/nrrd/nrrd_data.h"

#include "bricking/import/files/file_reading.h"
#include "bricking/import/labels/nrrd/nrrd_fields.h"
#include "core/base/error.h"
#include "core/base/shown_text.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <utility>
#include <vector>

namespace tessera {

class NrrdData::Part {
  public:
    virtual ~Part() = default;
    virtual void read(std::span<std::byte> out) = 0;
    /// Bytes of numbers behind those that were read.
    virtual std::uint64_t finish() = 0;
};

namespace {

constexpr std::size_t kPieceBytes = 64 * 1024;
constexpr double kLargestGzipRatio = 1032; // zlib's technical note: deflate shrinks no more

std::uint64_t valuesOf(const NrrdHeader& header) {
    std::uint64_t values = 1;
    for (const std::int64_t size : header.sizes)
        values *= static_cast<std::uint64_t>(size);
    return values;
}

std::uint64_t partBytesOf(const NrrdHeader& header) {
    return valuesOf(header) / std::max<std::size_t>(header.dataFiles.size(), 1) *
           bytesPerFileValue(nrrdDataType(header));
}

/// Bytes of a row, or of a voxel's layers where these are the rows.
std::uint64_t rowBytesOf(const NrrdHeader& header) {
    return static_cast<std::uint64_t>(header.sizes.front()) * bytesPerFileValue(nrrdDataType(header));
}

class PlainPart final : public NrrdData::Part {
  public:
    PlainPart(InputFile file, std::uint64_t offset) : file_(std::move(file)), at_(offset) {}
    void read(std::span<std::byte> out) override {
        file_.readAt(at_, out);
        at_ += out.size();
    }
    std::uint64_t finish() override { return 0; } // checkNrrdLengths() knows

  private:
    InputFile file_;
    std::uint64_t at_;
};

class GzipPart final : public NrrdData::Part {
  public:
    GzipPart(InputFile file, std::uint64_t offset, std::int64_t skipped) : stream_(std::move(file), offset) {
        std::array<std::byte, 4096> piece;
        for (auto left = static_cast<std::uint64_t>(skipped); left > 0;) {
            const auto step = std::min<std::uint64_t>(left, piece.size());
            stream_.read(std::span(piece).first(step));
            left -= step;
        }
    }
    void read(std::span<std::byte> out) override { stream_.read(out); }
    std::uint64_t finish() override { return stream_.finish(); }

  private:
    GzipStream stream_;
};

class TextPart final : public NrrdData::Part {
  public:
    TextPart(InputFile file, std::uint64_t offset) : file_(std::move(file)), at_(offset) {}

    void read(std::span<std::byte> out) override {
        for (std::size_t i = 0; i + sizeof(double) <= out.size(); i += sizeof(double)) {
            const std::string word = nextWord();
            const std::optional<double> value = realNumberOf(word);
            if (!value)
                throw badFile(file_.path().string(), "numbers as text",
                              word.empty() ? "the end of the file (is it truncated?)"
                                           : "\"" + printable(word) + "\"");
            std::memcpy(out.data() + i, &*value, sizeof(double));
        }
    }
    std::uint64_t finish() override {
        std::uint64_t bytes = 0;
        while (!nextWord().empty())
            bytes += sizeof(double);
        return bytes;
    }

  private:
    /// "" at the end of the file. Longer words are no numbers, and cut.
    std::string nextWord() {
        constexpr std::size_t kLongest = 64;
        std::string word;
        for (;; ++next_) {
            if (next_ == have_) {
                have_ = file_.readSome(at_, std::as_writable_bytes(std::span(text_)));
                at_ += have_;
                next_ = 0;
                if (have_ == 0)
                    return word;
            }
            const char c = text_[next_];
            if (std::string_view(" \t\r\n\v\f,").find(c) == std::string_view::npos)
                word += c;
            else if (!word.empty())
                return word;
            if (word.size() > kLongest)
                return word;
        }
    }

    InputFile file_;
    std::uint64_t at_;
    std::array<char, 4096> text_{};
    std::size_t next_ = 0, have_ = 0;
};

/// Behind the header and the lines that are skipped. Throws InputError if there are fewer.
std::uint64_t offsetOf(const NrrdHeader& header, const InputFile& file) {
    std::uint64_t at = header.dataFiles.empty() ? header.bytes : 0;
    std::vector<char> piece(header.lineSkip > 0 ? kPieceBytes : 0);
    for (std::int64_t left = header.lineSkip; left > 0;) {
        const std::size_t got = file.readSome(at, std::as_writable_bytes(std::span(piece)));
        if (got == 0)
            throw badFile(file.path().string(),
                          std::to_string(header.lineSkip) + " lines before the data, as \"line skip\" says",
                          std::to_string(header.lineSkip - left));
        std::size_t used = 0;
        while (used < got && left > 0)
            left -= piece[used++] == '\n' ? 1 : 0;
        at += used;
    }
    if (header.encoding != NrrdEncoding::gzip && header.byteSkip > 0)
        at += static_cast<std::uint64_t>(header.byteSkip);
    if (header.byteSkip == -1)
        at = file.sizeBytes() - std::min(file.sizeBytes(), partBytesOf(header));
    return at;
}

void checkLength(const NrrdHeader& header, const InputFile& file) {
    const std::uint64_t bytes = partBytesOf(header), at = offsetOf(header, file);
    const std::uint64_t behind = file.sizeBytes() - std::min(at, file.sizeBytes());
    const bool isText = header.encoding == NrrdEncoding::text;
    const double most =
        header.encoding == NrrdEncoding::gzip
            ? static_cast<double>(behind) * kLargestGzipRatio - static_cast<double>(header.byteSkip)
        : isText ? static_cast<double>(behind + 1) / 2 * sizeof(double)
                 : static_cast<double>(behind);
    std::string sizes;
    for (const std::int64_t size : header.sizes)
        sizes += (sizes.empty() ? "" : " x ") + std::to_string(size);
    if (static_cast<double>(bytes) > most)
        throw badFile(file.path().string(),
                      std::to_string(bytes / bytesPerFileValue(nrrdDataType(header))) + " values of " + sizes,
                      "a file of " + std::to_string(behind) + " bytes behind the header, too short for them");
    if (header.encoding == NrrdEncoding::raw && behind - bytes >= rowBytesOf(header))
        throw badFile(file.path().string(), "values of " + sizes + " up to the end of the file",
                      std::to_string(behind - bytes) + " bytes more");
}

} // namespace

FileType nrrdDataType(const NrrdHeader& header) {
    return header.encoding == NrrdEncoding::text ? FileType::f64 : header.type;
}

bool isNrrdDataBigEndian(const NrrdHeader& header) {
    return header.encoding != NrrdEncoding::text && header.bigEndian;
}

void checkNrrdLengths(const NrrdHeader& header, const std::filesystem::path& file) {
    if (header.dataFiles.empty())
        checkLength(header, InputFile(file));
    for (const std::filesystem::path& data : header.dataFiles)
        checkLength(header, InputFile(data));
}

NrrdData::NrrdData(const NrrdHeader& header, std::filesystem::path file)
    : header_(header), file_(std::move(file)), partBytes_(partBytesOf(header)) {}
NrrdData::~NrrdData() = default;

void NrrdData::openNext() {
    const std::size_t parts = std::max<std::size_t>(header_.dataFiles.size(), 1);
    TESSERA_CHECK(opened_ < parts);
    if (part_)
        finish();
    InputFile file(header_.dataFiles.empty() ? file_ : header_.dataFiles[opened_]);
    const std::uint64_t offset = offsetOf(header_, file);
    if (header_.encoding == NrrdEncoding::raw)
        part_ = std::make_unique<PlainPart>(std::move(file), offset);
    else if (header_.encoding == NrrdEncoding::gzip)
        part_ = std::make_unique<GzipPart>(std::move(file), offset, header_.byteSkip);
    else
        part_ = std::make_unique<TextPart>(std::move(file), offset);
    ++opened_;
    leftBytes_ = partBytes_;
}

void NrrdData::read(std::span<std::byte> out) {
    while (!out.empty()) {
        if (leftBytes_ == 0)
            openNext();
        const auto step = std::min<std::uint64_t>(leftBytes_, out.size());
        part_->read(out.first(step));
        out = out.subspan(step);
        leftBytes_ -= step;
    }
}

void NrrdData::skip(std::uint64_t bytes) {
    std::vector<std::byte> piece(std::min<std::uint64_t>(bytes, kPieceBytes));
    for (; bytes > 0; bytes -= std::min<std::uint64_t>(bytes, piece.size()))
        read(std::span(piece).first(std::min<std::uint64_t>(bytes, piece.size())));
}

void NrrdData::finish() {
    TESSERA_CHECK(part_ && leftBytes_ == 0);
    if (const std::uint64_t surplus = part_->finish(); surplus >= rowBytesOf(header_))
        throw badFile((header_.dataFiles.empty() ? file_ : header_.dataFiles[opened_ - 1]).string(),
                      "no values behind the last one that \"sizes\" says",
                      std::to_string(surplus / bytesPerFileValue(nrrdDataType(header_))) + " more");
}

} // namespace tessera
