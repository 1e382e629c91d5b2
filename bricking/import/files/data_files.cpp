// bricking/import/files/data_files.cpp: see data_files.h.
#include "bricking/import/files/data_files.h"

#include "bricking/import/files/header_words.h"
#include "core/base/error.h"
#include "core/base/shown_text.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <utility>
#include <vector>

namespace tessera {

class DataReader::Part {
  public:
    virtual ~Part() = default;
    virtual void read(std::span<std::byte> out) = 0;
    /// Bytes of numbers behind those that were read.
    virtual std::uint64_t finish() = 0;
};

namespace {

constexpr std::size_t kPieceBytes = 64 * 1024;
constexpr double kLargestGzipRatio = 1032; // zlib's technical note: deflate shrinks no more

std::uint64_t valuesOf(const DataFiles& header) {
    std::uint64_t values = 1;
    for (const std::int64_t size : header.sizes)
        values *= static_cast<std::uint64_t>(size);
    return values;
}

std::uint64_t partBytesOf(const DataFiles& header) {
    return valuesOf(header) / std::max<std::size_t>(header.dataFiles.size(), 1) *
           bytesPerFileValue(dataType(header));
}

/// Bytes of a row, or of a voxel's layers where these are the rows.
std::uint64_t rowBytesOf(const DataFiles& header) {
    return static_cast<std::uint64_t>(header.sizes.front()) * bytesPerFileValue(dataType(header));
}

class PlainPart final : public DataReader::Part {
  public:
    PlainPart(InputFile file, std::uint64_t offset) : file_(std::move(file)), at_(offset) {}
    void read(std::span<std::byte> out) override {
        file_.readAt(at_, out);
        at_ += out.size();
    }
    std::uint64_t finish() override { return 0; } // checkDataLengths() knows

  private:
    InputFile file_;
    std::uint64_t at_;
};

class GzipPart final : public DataReader::Part {
  public:
    GzipPart(InputFile file, std::uint64_t offset, std::int64_t skipped)
        : stream_(std::move(file), offset, GzipStream::Wrapper::any) {
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

class TextPart final : public DataReader::Part {
  public:
    TextPart(InputFile file, std::uint64_t offset) : file_(std::move(file)), at_(offset) {}

    void read(std::span<std::byte> out) override {
        for (std::size_t i = 0; i + sizeof(double) <= out.size(); i += sizeof(double)) {
            const std::string word = nextWord();
            const std::optional<double> value = realNumberOf(word);
            if (!value)
                throw badFile(file_.path().string(), "numbers as text",
                              word.empty() ? "the end of the file (is it truncated?)"
                                           : shownWord(word) + " before byte " + std::to_string(place()));
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
    /// Of the next character.
    std::uint64_t place() const { return at_ - have_ + next_; }

    /// "" at the end of the file.
    std::string nextWord() {
        constexpr std::size_t kLongest = 64; // of a number
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
                throw badFile(file_.path().string(),
                              "numbers as text, of " + std::to_string(kLongest) + " characters at most",
                              shownWord(word) + " before byte " + std::to_string(place() + 1));
        }
    }

    InputFile file_;
    std::uint64_t at_;
    std::array<char, 4096> text_{};
    std::size_t next_ = 0, have_ = 0;
};

/// Behind the header and the lines that are skipped. Throws InputError if there are fewer.
std::uint64_t headerEnd(const DataFiles& header, const InputFile& file) {
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
    return at;
}

} // namespace

std::uint64_t dataOffset(const DataFiles& header, const InputFile& file) {
    const std::uint64_t end = headerEnd(header, file), bytes = partBytesOf(header), all = file.sizeBytes();
    if (header.byteSkip == -1) // checkLength() refuses a file that is too short
        return all < bytes ? end : std::max(end, all - bytes);
    const bool isSkippedHere = header.encoding != DataEncoding::gzip;
    return end + (isSkippedHere ? static_cast<std::uint64_t>(header.byteSkip) : 0);
}

namespace {

void checkLength(const DataFiles& header, const InputFile& file) {
    const std::uint64_t bytes = partBytesOf(header), at = dataOffset(header, file);
    const std::uint64_t behind = file.sizeBytes() - std::min(at, file.sizeBytes());
    const bool isText = header.encoding == DataEncoding::text;
    const double most =
        header.encoding == DataEncoding::gzip
            ? static_cast<double>(behind) * kLargestGzipRatio - static_cast<double>(header.byteSkip)
        : isText ? static_cast<double>(behind + 1) / 2 * sizeof(double)
                 : static_cast<double>(behind);
    std::string sizes;
    for (const std::int64_t size : header.sizes)
        sizes += (sizes.empty() ? "" : " x ") + std::to_string(size);
    if (static_cast<double>(bytes) > most)
        throw badFile(file.path().string(),
                      std::to_string(bytes / bytesPerFileValue(dataType(header))) + " values of " + sizes,
                      "a file of " + std::to_string(behind) + " bytes behind the header, too short for them");
    if (header.encoding == DataEncoding::raw && behind - bytes >= rowBytesOf(header))
        throw badFile(file.path().string(), "values of " + sizes + " up to the end of the file",
                      std::to_string(behind - bytes) + " bytes more");
}

} // namespace

namespace {

std::int64_t wholeIn(const std::string& text, const std::string& field, std::int64_t least, std::int64_t most,
                     const std::string& where) {
    const std::optional<std::int64_t> value = wholeNumberOf(text);
    if (!value || *value < least || *value > most)
        throw badFile(where,
                      "\"" + field + "\" as a whole number from " + std::to_string(least) + " to " +
                          std::to_string(most),
                      shownWord(text));
    return *value;
}

/// Throws for another number of files than the sizes need, if each has a part of `each` axes.
void checkFileCount(std::uint64_t count, std::int64_t each, const std::vector<std::int64_t>& sizes,
                    const std::string& where) {
    constexpr std::uint64_t kMostFiles = 65536;
    const auto axes = static_cast<std::int64_t>(sizes.size());
    std::uint64_t runs = each == axes ? static_cast<std::uint64_t>(sizes.back()) : 1;
    for (std::int64_t axis = each; axis < axes; ++axis)
        runs *= static_cast<std::uint64_t>(sizes[static_cast<std::size_t>(axis)]);
    if (each == axes ? runs % count != 0 : runs != count)
        throw badFile(where, std::to_string(runs) + " data files, as its sizes say", std::to_string(count));
    if (count > kMostFiles)
        throw badFile(where, std::to_string(kMostFiles) + " data files at most", std::to_string(count));
}

std::vector<std::string> patternNames(const std::string& field, const std::vector<std::string>& words,
                                      std::int64_t each, const std::vector<std::int64_t>& sizes,
                                      const std::string& where) {
    constexpr std::int64_t kMostNumber = 999'999'999;
    const std::int64_t first = wholeIn(words[1], field, 0, kMostNumber, where),
                       last = wholeIn(words[2], field, 0, kMostNumber, where),
                       step = wholeIn(words[3], field, -kMostNumber, kMostNumber, where);
    if (step == 0 || (last - first) / step < 0)
        throw badFile(where, "a step of \"" + field + "\" that leads from its first number to its last",
                      std::to_string(step));
    const std::int64_t count = (last - first) / step + 1;
    checkFileCount(static_cast<std::uint64_t>(count), each, sizes, where); // before names are made
    std::vector<std::string> names;
    for (std::int64_t i = 0; i < count; ++i) {
        const std::optional<std::string> name = numberedName(words[0], first + i * step);
        if (!name)
            throw badFile(where, "one %d in the pattern of \"" + field + "\"", shownWord(words[0]));
        names.push_back(*name);
    }
    return names;
}

} // namespace

std::vector<std::filesystem::path> namedDataFiles(const std::string& field, const std::string& value,
                                                  const std::vector<std::string>& listed,
                                                  const std::vector<std::int64_t>& sizes,
                                                  const std::filesystem::path& header) {
    const std::string where = header.string();
    const auto axes = static_cast<std::int64_t>(sizes.size());
    std::vector<std::string> names = listed;
    // As many files as there are runs of `each` axes; of all axes: parts along the slowest one.
    std::int64_t each = axes - 1;
    const std::vector<std::string> words = wordsOf(value);
    if (value.starts_with("LIST")) {
        if (words[0] != "LIST" || words.size() > 2 || names.empty())
            throw badFile(where, "\"" + field + ": LIST\" and names, a line each", shownWord(value));
        if (words.size() == 2) // MetaIO writes "2D"
            each = wholeIn(words[1].substr(0, words[1].find_last_not_of("dD") + 1), field, 1, axes, where);
    } else if (words.size() >= 4 && words[0].find('%') != std::string::npos) {
        if (words.size() > 5)
            throw badFile(where, "\"" + field + "\" as PATTERN MIN MAX STEP", shownWord(value));
        if (words.size() == 5)
            each = wholeIn(words[4], field, 1, axes, where);
        names = patternNames(field, words, each, sizes, where);
    } else {
        return {header.parent_path() / value};
    }
    checkFileCount(names.size(), each, sizes, where);
    std::vector<std::filesystem::path> files;
    for (const std::string& name : names)
        files.push_back(header.parent_path() / name);
    return files;
}

FileType dataType(const DataFiles& header) {
    return header.encoding == DataEncoding::text ? FileType::f64 : header.type;
}

bool isDataBigEndian(const DataFiles& header) {
    return header.encoding != DataEncoding::text && header.bigEndian;
}

void checkDataLengths(const DataFiles& header, const std::filesystem::path& file) {
    if (header.dataFiles.empty())
        checkLength(header, InputFile(file));
    for (const std::filesystem::path& data : header.dataFiles)
        checkLength(header, InputFile(data));
}

DataReader::DataReader(DataFiles header, std::filesystem::path file)
    : header_(std::move(header)), file_(std::move(file)), partBytes_(partBytesOf(header_)) {}
DataReader::~DataReader() = default;

void DataReader::openNext() {
    const std::size_t parts = std::max<std::size_t>(header_.dataFiles.size(), 1);
    TESSERA_CHECK(opened_ < parts);
    if (part_)
        finish();
    InputFile file(header_.dataFiles.empty() ? file_ : header_.dataFiles[opened_]);
    const std::uint64_t offset = dataOffset(header_, file);
    if (header_.encoding == DataEncoding::raw)
        part_ = std::make_unique<PlainPart>(std::move(file), offset);
    else if (header_.encoding == DataEncoding::gzip)
        part_ = std::make_unique<GzipPart>(std::move(file), offset, header_.byteSkip);
    else
        part_ = std::make_unique<TextPart>(std::move(file), offset);
    ++opened_;
    leftBytes_ = partBytes_;
}

void DataReader::read(std::span<std::byte> out) {
    while (!out.empty()) {
        if (leftBytes_ == 0)
            openNext();
        const auto step = std::min<std::uint64_t>(leftBytes_, out.size());
        part_->read(out.first(step));
        out = out.subspan(step);
        leftBytes_ -= step;
    }
}

void DataReader::skip(std::uint64_t bytes) {
    std::vector<std::byte> piece(std::min<std::uint64_t>(bytes, kPieceBytes));
    for (; bytes > 0; bytes -= std::min<std::uint64_t>(bytes, piece.size()))
        read(std::span(piece).first(std::min<std::uint64_t>(bytes, piece.size())));
}

void DataReader::finish() {
    TESSERA_CHECK(part_ && leftBytes_ == 0);
    const std::uint64_t least = header_.encoding == DataEncoding::text ? 1 : rowBytesOf(header_);
    if (const std::uint64_t surplus = part_->finish(); surplus >= least)
        throw badFile((header_.dataFiles.empty() ? file_ : header_.dataFiles[opened_ - 1]).string(),
                      "no values behind the last one that the header says",
                      std::to_string(surplus / bytesPerFileValue(dataType(header_))) + " more");
}

std::unique_ptr<SlabSource> openDataFiles(const DataFiles& files, const std::filesystem::path& header,
                                          const VolumeInfo& info, std::string description) {
    const FileType type = dataType(files);
    if (files.dataFiles.size() > 1)
        description += " in " + std::to_string(files.dataFiles.size()) + " files";
    if (losesPrecision(type))
        description += ", converted to float32";
    if (files.encoding != DataEncoding::raw || files.dataFiles.size() > 1)
        return makeForwardFileSource([files, header] { return std::make_unique<DataReader>(files, header); },
                                     info, type, isDataBigEndian(files), std::move(description));
    InputFile file(files.dataFiles.empty() ? header : files.dataFiles.front());
    const std::uint64_t offset = dataOffset(files, file);
    return makePlainFileSource(std::move(file), info, {type, isDataBigEndian(files), offset},
                               std::move(description));
}

} // namespace tessera
