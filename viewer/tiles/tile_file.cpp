// viewer/tiles/tile_file.cpp: see tile_file.h.
#include "viewer/tiles/tile_file.h"

#include "bricking/store/codec.h" // crc32c
#include "core/base/error.h"
#include "core/base/output_file.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <glm/common.hpp>
#include <string_view>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>
#include <vector>

namespace tessera {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers of the file are little-endian");

constexpr std::string_view kKind = "tessera tile 1\n\n"; // 16 bytes: pixels are aligned
constexpr std::uint32_t kOpaque = 1, kBlank = 2;
constexpr std::int32_t kAdded = 1, kOffsets = 2; // pictures
/// Pixels count as those that measured errors count (render/picture/pixels_again.h).
constexpr float kShown = 1.0f / 255;

struct Header {
    std::int32_t from[2], size[2], pictures;
    std::uint32_t bits;
    std::uint64_t shown;
    char key[16];
    std::uint8_t rest[16];
};
static_assert(sizeof(Header) == 64);
constexpr std::uint64_t kPixelsAt = kKind.size() + sizeof(Header);

std::uint64_t bytesOf(const PictureTile& tile, std::int32_t pictures) {
    const std::uint64_t count = 1 + ((pictures & kAdded) != 0 ? 1 : 0) + ((pictures & kOffsets) != 0 ? 1 : 0);
    return kPixelsAt + count * tile.pixels() * sizeof(glm::vec4) + sizeof(std::uint32_t);
}
std::int32_t picturesOf(const TileFacts& facts) {
    return (facts.added ? kAdded : 0) | (facts.offsets ? kOffsets : 0);
}

/// As the picture shows it.
glm::vec4 sumOf(const glm::vec4& colour, const glm::vec4& added) {
    return glm::max(colour + added, glm::vec4(0));
}

} // namespace

void writeTile(const std::filesystem::path& path, const DrawnTile& drawn, const std::string& key) {
    const PictureTile& tile = drawn.tile;
    const Image &colours = drawn.colours, &added = drawn.added, &offsets = drawn.offsets;
    const bool lit = !added.pixels.empty(), varies = !offsets.pixels.empty();
    TESSERA_CHECK(colours.size == tile.size && (!lit || added.size == tile.size) &&
                  (!varies || offsets.size == tile.size) && key.size() == sizeof Header::key);
    Header header{};
    header.from[0] = tile.from.x, header.from[1] = tile.from.y;
    header.size[0] = tile.size.x, header.size[1] = tile.size.y;
    header.pictures = (lit ? kAdded : 0) | (varies ? kOffsets : 0);
    header.bits = kOpaque | kBlank;
    std::memcpy(header.key, key.data(), key.size());
    for (std::size_t i = 0; i < colours.pixels.size(); ++i) {
        const glm::vec4& colour = colours.pixels[i];
        const float alpha = lit ? sumOf(colour, added.pixels[i]).a : colour.a;
        header.shown += !(colour.a <= kShown) ? 1 : 0;
        if (!(alpha >= 1))
            header.bits &= ~kOpaque;
        if (alpha > kBlankAlpha)
            header.bits &= ~kBlank;
    }
    OutputFile file(path);
    std::uint64_t position = 0;
    std::uint32_t sum = 0;
    const auto write = [&](std::span<const std::byte> bytes) {
        sum = crc32c(bytes, sum);
        file.writeAt(position, bytes);
        position += bytes.size();
    };
    write(std::as_bytes(std::span(kKind)));
    write(std::as_bytes(std::span(&header, 1)));
    write(std::as_bytes(std::span(colours.pixels)));
    write(std::as_bytes(std::span(added.pixels)));
    write(std::as_bytes(std::span(offsets.pixels)));
    file.writeAt(position, std::as_bytes(std::span(&sum, 1)));
    file.finish();
}

std::optional<TileFile> TileFile::open(const std::filesystem::path& path, const PictureTile& tile,
                                       const std::string& key, std::string& why) {
    TileFile file(path, FileHandle(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)));
    struct stat facts {};
    const int descriptor = file.file_.descriptor();
    if (descriptor < 0 || ::fstat(descriptor, &facts) != 0 || !S_ISREG(facts.st_mode)) {
        why = "no file that can be read";
        return std::nullopt;
    }
    const auto bytes = static_cast<std::uint64_t>(facts.st_size);
    std::array<char, kKind.size()> kind{};
    Header header{};
    if (bytes < kPixelsAt) {
        why = "a file of " + std::to_string(bytes) + " bytes";
        return std::nullopt;
    }
    file.read(0, std::as_writable_bytes(std::span(kind)));
    file.read(kKind.size(), std::as_writable_bytes(std::span(&header, 1)));
    if (std::string_view(kind.data(), kind.size()) != kKind)
        why = "another kind of file";
    else if (std::string_view(header.key, sizeof header.key) != key)
        why = "a tile of another picture";
    else if (glm::ivec2(header.from[0], header.from[1]) != tile.from ||
             glm::ivec2(header.size[0], header.size[1]) != tile.size)
        why = "another tile";
    else if (header.pictures < 0 || header.pictures > (kAdded | kOffsets) || header.shown > tile.pixels())
        why = "a header that is none";
    else if (bytes != bytesOf(tile, header.pictures))
        why = "a file of " + std::to_string(bytes) + " bytes, not " +
              std::to_string(bytesOf(tile, header.pictures));
    else {
        file.facts_ = {tile,
                       (header.pictures & kAdded) != 0,
                       (header.pictures & kOffsets) != 0,
                       (header.bits & kOpaque) != 0,
                       (header.bits & kBlank) != 0,
                       header.shown};
        return file;
    }
    return std::nullopt;
}

void TileFile::read(std::uint64_t offset, std::span<std::byte> bytes) const {
    while (!bytes.empty()) {
        const ssize_t got =
            ::pread(file_.descriptor(), bytes.data(), bytes.size(), static_cast<off_t>(offset));
        if (got < 0 && errno == EINTR)
            continue;
        if (got <= 0)
            throw badFile(path_.string(), "a tile that can be read to its end",
                          got < 0 ? std::strerror(errno) : "fewer bytes");
        offset += static_cast<std::uint64_t>(got);
        bytes = bytes.subspan(static_cast<std::size_t>(got));
    }
}

std::string TileFile::damage() const {
    constexpr std::uint64_t kBlock = 1 << 18;
    std::vector<std::byte> block(kBlock);
    const std::uint64_t end = bytesOf(facts_.tile, picturesOf(facts_)) - sizeof(std::uint32_t);
    std::uint32_t sum = 0, expected = 0;
    for (std::uint64_t at = 0; at < end; at += kBlock) {
        const std::span some = std::span(block).first(std::min(kBlock, end - at));
        read(at, some);
        sum = crc32c(some, sum);
    }
    read(end, std::as_writable_bytes(std::span(&expected, 1)));
    return sum == expected ? "" : "a damaged tile: its checksum is of other bytes";
}

std::uint64_t TileFile::offsetOf(int picture, const glm::ivec2& at) const {
    const std::size_t pixel = static_cast<std::size_t>(at.y) * static_cast<std::size_t>(facts_.tile.size.x) +
                              static_cast<std::size_t>(at.x);
    return kPixelsAt +
           (static_cast<std::uint64_t>(picture) * facts_.tile.pixels() + pixel) * sizeof(glm::vec4);
}

void TileFile::readRow(int row, std::span<glm::vec4> out) const {
    TESSERA_CHECK(out.size() == static_cast<std::size_t>(facts_.tile.size.x));
    read(offsetOf(0, {0, row}), std::as_writable_bytes(out));
    if (!facts_.added)
        return;
    std::vector<glm::vec4> added(out.size());
    read(offsetOf(1, {0, row}), std::as_writable_bytes(std::span(added)));
    std::transform(out.begin(), out.end(), added.begin(), out.begin(), sumOf);
}

void TileFile::readRow(int row, std::span<glm::vec4> colours, std::span<glm::vec4> offsets) const {
    TESSERA_CHECK(colours.size() == static_cast<std::size_t>(facts_.tile.size.x) &&
                  offsets.size() == colours.size());
    read(offsetOf(0, {0, row}), std::as_writable_bytes(colours));
    if (facts_.offsets)
        read(offsetOf(facts_.added ? 2 : 1, {0, row}), std::as_writable_bytes(offsets));
    else
        std::fill(offsets.begin(), offsets.end(), glm::vec4(0));
}

glm::vec4 TileFile::colour(const glm::ivec2& at) const {
    glm::vec4 out(0);
    read(offsetOf(0, at), std::as_writable_bytes(std::span(&out, 1)));
    return out;
}

} // namespace tessera
