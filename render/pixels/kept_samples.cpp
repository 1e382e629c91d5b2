// render/pixels/kept_samples.cpp: see kept_samples.h.
#include "render/pixels/kept_samples.h"

#include "core/base/error.h"
#include "core/base/files.h"
#include "core/base/interrupt.h"
#include "core/base/output_file.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <sstream>
#include <utility>

namespace tessera {
namespace {

namespace fs = std::filesystem;

static_assert(std::endian::native == std::endian::little, "numbers of the file are little-endian");

constexpr std::string_view kKind = "tessera samples 1\n";
constexpr std::uint64_t kMostHeader = 1 << 20; // bytes
constexpr std::size_t kBlock = 1 << 16;        // bytes that are read or written at a time
constexpr std::uint64_t kStart = kKind.size() + sizeof(std::uint64_t);

/// Of a run of bytes, eight at a time: which of them changed by chance shows with all but 2^-64.
class Checksum {
  public:
    void take(std::span<const std::byte> bytes) {
        for (const std::byte byte : bytes) {
            word_ = word_ << 8 | std::to_integer<std::uint64_t>(byte);
            if (++count_ % 8 == 0)
                mix();
        }
    }
    std::uint64_t value() const {
        Checksum end = *this;
        end.mix();
        end.word_ = count_;
        end.mix();
        return end.sum_;
    }

  private:
    void mix() { // the finaliser of SplitMix64
        std::uint64_t x = (sum_ ^ word_) + 0x9e3779b97f4a7c15ULL;
        x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
        x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
        sum_ = x ^ (x >> 31);
        word_ = 0;
    }
    std::uint64_t sum_ = 0, word_ = 0, count_ = 0;
};

template <typename T> std::span<const std::byte> bytesOf(const T& value) {
    return std::as_bytes(std::span(&value, 1));
}

/// Floats of a pixel.
std::size_t floatsOf(int samples) {
    return samples > PixelSums::kManySamples ? 16 : 8;
}

std::uint64_t sumsBytes(const glm::ivec2& size, int samples, std::size_t pictures) {
    return std::uint64_t{pictures} * static_cast<std::uint64_t>(size.x) * static_cast<std::uint64_t>(size.y) *
           floatsOf(samples) * sizeof(float);
}

/// A file that is read from its beginning to its end.
class Reader {
  public:
    explicit Reader(const fs::path& path) : path_(path), file_(path, std::ios::binary) {
        if (!file_)
            throw InputError(path.string() + ": cannot be read");
    }
    void read(std::span<std::byte> bytes) {
        if (!file_.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size())))
            throw badFile(path_.string(), "kept samples to their end", "fewer bytes");
    }

  private:
    fs::path path_;
    std::ifstream file_;
};

class Writer {
  public:
    explicit Writer(OutputFile& file) : file_(file) { block_.reserve(kBlock + 64); }
    void write(std::span<const std::byte> bytes) {
        checksum_.take(bytes);
        block_.insert(block_.end(), bytes.begin(), bytes.end());
        if (block_.size() >= kBlock)
            flush();
    }
    void finish() {
        const std::uint64_t sum = checksum_.value();
        write(bytesOf(sum));
        flush();
        file_.finish();
    }

  private:
    void flush() {
        checkInterrupted();
        file_.writeAt(position_, block_);
        position_ += block_.size();
        block_.clear();
    }
    OutputFile& file_;
    std::vector<std::byte> block_;
    std::uint64_t position_ = 0;
    Checksum checksum_;
};

/// Whole numbers with blanks between them, and nothing else.
template <typename... Numbers> bool parsed(const std::string& text, Numbers&... numbers) {
    std::istringstream stream(text);
    (stream >> ... >> numbers);
    return !stream.fail() && (stream >> std::ws).eof();
}

} // namespace

std::string fingerprint(std::span<const std::byte> data) {
    Checksum sum;
    sum.take(data);
    char text[17];
    std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(sum.value()));
    return text;
}

KeptSamples::KeptSamples(fs::path path, Parts parts) : path_(std::move(path)), parts_(std::move(parts)) {
    parts_["arithmetic of samples"] = std::to_string(kArithmetic);
    if (exists())
        requireParts(read());
}

bool KeptSamples::exists() const {
    refusePipeOrDevice(path_);
    std::error_code ignored;
    return fs::exists(path_, ignored);
}

/// The header, once the whole file is what was written. Takes no more memory than the file has bytes.
KeptSamples::Header KeptSamples::read() const {
    const std::string shown = path_.string();
    const auto damaged = [&](const std::string& found) {
        return badFile(shown, "samples that --keep-state kept", found);
    };
    std::error_code failure;
    const std::uint64_t bytes = fs::file_size(path_, failure);
    if (failure)
        throw damaged("no regular file");
    Reader file(path_);
    std::array<char, kStart> start{};
    if (bytes < kStart + sizeof(std::uint64_t))
        throw damaged("a file of " + std::to_string(bytes) + " bytes");
    file.read(std::as_writable_bytes(std::span(start)));
    if (std::string_view(start.data(), kKind.size()) != kKind)
        throw damaged("another kind of file");
    std::uint64_t length = 0;
    std::memcpy(&length, start.data() + kKind.size(), sizeof length);
    if (length > kMostHeader || length > bytes - kStart - sizeof(std::uint64_t))
        throw damaged("a header of " + std::to_string(length) + " bytes in a file of " +
                      std::to_string(bytes));
    std::string text(length, '\0');
    file.read(std::as_writable_bytes(std::span(text)));
    Checksum sum;
    sum.take(std::as_bytes(std::span(start)));
    sum.take(std::as_bytes(std::span(text)));
    std::vector<std::byte> block(kBlock);
    for (std::uint64_t left = bytes - kStart - length - sizeof(std::uint64_t); left > 0;) {
        const auto some = std::span(block).first(std::min<std::uint64_t>(left, kBlock));
        file.read(some);
        sum.take(some);
        left -= some.size();
    }
    std::uint64_t expected = 0;
    file.read(std::as_writable_bytes(std::span(&expected, 1)));
    if (expected != sum.value())
        throw damaged("a damaged file: its checksum is of other bytes");

    Header header;
    header.sumsAt = kStart + length;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
        const std::size_t tab = line.find('\t');
        if (tab == std::string::npos ||
            !header.parts.emplace(line.substr(0, tab), line.substr(tab + 1)).second)
            throw damaged("a header that is none");
    }
    const auto taken = [&](const char* name) {
        const auto node = header.parts.extract(name);
        return node.empty() ? std::string() : node.mapped();
    };
    if (!parsed(taken("size"), header.size.x, header.size.y) || !parsed(taken("samples"), header.samples) ||
        !parsed(taken("pictures"), header.pictures) || header.size.x < 1 || header.size.y < 1 ||
        header.size.x > 1 << 16 || header.size.y > 1 << 16 || header.pictures < 1 || header.pictures > 8 ||
        header.samples < 2 || header.samples > PixelSampling::kMost ||
        !std::has_single_bit(static_cast<unsigned>(header.samples)))
        throw damaged("a header that is none");
    if (bytes !=
        header.sumsAt + sumsBytes(header.size, header.samples, header.pictures) + sizeof(std::uint64_t))
        throw damaged("a file of " + std::to_string(bytes) + " bytes, which are not those of " +
                      std::to_string(header.size.x) + " x " + std::to_string(header.size.y) + " pixels");
    return header;
}

void KeptSamples::requireParts(const Header& header) const {
    for (const auto& [name, value] : parts_) {
        const auto found = header.parts.find(name);
        if (found == header.parts.end() || found->second != value)
            throw badFile(path_.string(),
                          "samples of this picture, with " + name + " " + value +
                              " (name another file for --keep-state to begin anew)",
                          found == header.parts.end() ? "samples without it" : found->second);
    }
}

int KeptSamples::restore(AreaPicture& picture, int most, Parts ofPlan) {
    samples_ = 0;
    for (auto& [name, value] : ofPlan)
        parts_.insert_or_assign(name, value);
    if (!exists())
        return 0;
    const Header header = read();
    requireParts(header);
    for (const auto& [name, value] : header.parts)
        if (!parts_.contains(name))
            throw badFile(path_.string(),
                          "samples of this picture, without " + name +
                              " (name another file for --keep-state to begin anew)",
                          value);
    const glm::ivec2 size = picture.sums().size();
    const std::size_t pictures = picture.allSums().size();
    if (header.size != size || header.pictures != pictures)
        throw badFile(path_.string(),
                      "sums of " + std::to_string(pictures) + " pictures of " + std::to_string(size.x) +
                          " x " + std::to_string(size.y),
                      std::to_string(header.pictures) + " of " + std::to_string(header.size.x) + " x " +
                          std::to_string(header.size.y));
    if (header.samples > most)
        throw badFile(path_.string(), "at most the " + std::to_string(most) + " samples a pixel of --samples",
                      std::to_string(header.samples));
    Reader file(path_);
    std::vector<std::byte> before(header.sumsAt);
    file.read(before);
    const std::size_t floats = floatsOf(header.samples);
    picture.goOnFrom(header.samples, [&](std::span<PixelSums*> all) {
        std::vector<float> numbers(floats * 1024);
        for (PixelSums* const sums : all)
            for (std::size_t i = 0; i < sums->count(); i += 1024) {
                const std::size_t count = std::min<std::size_t>(1024, sums->count() - i);
                const auto some = std::span(numbers).first(count * floats);
                file.read(std::as_writable_bytes(some));
                for (const float number : some)
                    if (!std::isfinite(number))
                        throw badFile(path_.string(), "sums that are numbers", "one that is none");
                for (std::size_t n = 0; n < count; ++n) {
                    PixelSums::Kept kept{};
                    std::memcpy(&kept, &numbers[n * floats], floats * sizeof(float));
                    sums->restore(i + n, kept, header.samples);
                }
            }
    });
    return samples_ = header.samples;
}

void KeptSamples::keep(const AreaPicture& picture) {
    const int samples = picture.wholeSamples();
    if (samples <= samples_)
        return;
    const std::vector<const PixelSums*> all = picture.allSums();
    const glm::ivec2 size = all.front()->size();
    std::ostringstream header;
    header << "size\t" << size.x << ' ' << size.y << "\nsamples\t" << samples << "\npictures\t" << all.size()
           << '\n';
    for (const auto& [name, value] : parts_)
        header << name << '\t' << value << '\n';
    const std::string text = header.str();
    const std::uint64_t length = text.size();
    if (length > kMostHeader)
        throw Error(path_.string() + ": the scene is too long to be kept: " + std::to_string(length) +
                    " bytes of its keys, at most " + std::to_string(kMostHeader));
    OutputFile output(path_);
    Writer file(output);
    file.write(std::as_bytes(std::span(kKind)));
    file.write(bytesOf(length));
    file.write(std::as_bytes(std::span(text)));
    const std::size_t bytes = floatsOf(samples) * sizeof(float);
    for (const PixelSums* const sums : all)
        for (std::size_t i = 0; i < sums->count(); ++i) {
            const PixelSums::Kept kept = sums->kept(i);
            file.write(bytesOf(kept).first(bytes));
        }
    file.finish();
    samples_ = samples;
}

} // namespace tessera
