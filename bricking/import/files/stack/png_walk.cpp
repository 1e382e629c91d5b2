// bricking/import/files/stack/png_walk.cpp: walkPng() and walkPicture() of picture_walk.h. Rules: the PNG
// specification, second edition.
#include "bricking/import/files/stack/picture_walk.h"
#include "core/base/error.h"

#include <algorithm>
#include <array>
#include <limits>
#include <string_view>
#include <vector>
#include <zlib.h>

namespace tessera {
namespace {

constexpr std::string_view kPngMark = "\x89PNG\r\n\x1a\n";
constexpr double kMostDeflateRatio = 1032; // zlib's technical note

std::uint32_t bigWord(std::span<const std::byte> bytes, std::size_t at) {
    std::uint32_t word = 0;
    for (std::size_t i = 0; i < 4; ++i)
        word = word << 8 | std::to_integer<std::uint32_t>(bytes[at + i]);
    return word;
}

/// Of a chunk, by its first bytes: length and name.
std::string_view nameIn(std::span<const std::byte, 8> frame) {
    return {reinterpret_cast<const char*>(frame.data()) + 4, 4};
}

} // namespace

PictureHead walkPng(const InputFile& file) {
    const auto refuse = [&](const std::string& expected, const std::string& found) {
        throw badFile(file.path().string(), expected, found);
    };
    constexpr std::uint64_t kChunkFrame = 12; // length, name, checksum
    constexpr std::size_t kHeaderBytes = 13;
    PictureHead head;
    head.shape.format = "png";
    std::uint64_t at = kPngMark.size(), packed = 0;
    bool isFirst = true;
    for (bool isLast = false; !isLast; isFirst = false) {
        std::array<std::byte, 8> frame{};
        if (file.readSome(at, frame) < frame.size())
            refuse("PNG chunks up to IEND", "the end of the file (is it truncated?)");
        const std::uint64_t length = bigWord(frame, 0);
        const std::string_view name = nameIn(frame);
        if (length > file.sizeBytes() || at + kChunkFrame + length > file.sizeBytes())
            refuse("PNG chunks up to IEND",
                   "a chunk that goes on behind the end of the file (is it truncated?)");
        if (isFirst != (name == "IHDR") || (isFirst && length != kHeaderBytes))
            refuse("a PNG that begins with one IHDR", "another order of chunks");
        if (name == "IHDR") {
            std::array<std::byte, kHeaderBytes> header{};
            file.readAt(at + frame.size(), header);
            const std::uint32_t width = bigWord(header, 0), height = bigWord(header, 4);
            const int bits = std::to_integer<int>(header[8]), colour = std::to_integer<int>(header[9]);
            constexpr std::array kColours = {"grey",
                                             "?",
                                             "red, green, blue",
                                             "a palette of colours",
                                             "grey and opacity",
                                             "?",
                                             "red, green, blue, opacity"};
            if (colour != 0)
                refuse("a picture of one channel (grey)", static_cast<std::size_t>(colour) < kColours.size()
                                                              ? kColours[static_cast<std::size_t>(colour)]
                                                              : "colour type " + std::to_string(colour));
            if (bits != 8 && bits != 16)
                refuse("8 or 16 bits a pixel", std::to_string(bits));
            if (header[12] != std::byte{0})
                refuse("rows one after another", "an interlaced PNG");
            if (width < 1 || height < 1 || width > std::numeric_limits<std::int32_t>::max() ||
                height > std::numeric_limits<std::int32_t>::max())
                refuse("at least one pixel, and 2^31 along a side at most",
                       std::to_string(width) + "x" + std::to_string(height));
            head.shape.size = {static_cast<int>(width), static_cast<int>(height)};
            head.shape.type = bits == 8 ? FileType::u8 : FileType::u16;
        }
        if (name == "tRNS")
            refuse("a picture of one channel (grey)", "a transparent grey");
        if (name == "pHYs" && length == 9) {
            std::array<std::byte, 9> density{};
            file.readAt(at + frame.size(), density);
            constexpr double kMetre = 1000;
            head.perUnit = glm::dvec2(bigWord(density, 0), bigWord(density, 4));
            head.unitMm = density[8] == std::byte{1} ? kMetre : 0;
        }
        packed += name == "IDAT" ? length : 0;
        isLast = name == "IEND";
        at += kChunkFrame + length;
    }
    const double needed = static_cast<double>(head.shape.size.y) *
                          (1 + static_cast<double>(head.shape.size.x) *
                                   static_cast<double>(bytesPerFileValue(head.shape.type)));
    if (needed > static_cast<double>(packed) * kMostDeflateRatio)
        refuse(std::to_string(head.shape.size.x) + "x" + std::to_string(head.shape.size.y) + " pixels",
               std::to_string(packed) + " bytes of them, too few");
    return head;
}

void checkPngSums(const InputFile& file) {
    constexpr std::size_t kPieceBytes = 64 * 1024;
    std::vector<std::byte> piece(kPieceBytes);
    bool isLast = false; // bytes may follow IEND
    for (std::uint64_t at = kPngMark.size(); !isLast;) {
        std::array<std::byte, 8> frame{};
        file.readAt(at, frame);
        isLast = nameIn(frame) == "IEND";
        std::array<std::byte, 4> word{};
        file.readAt(at, word);
        std::uint64_t left = std::uint64_t{bigWord(word, 0)} + 4; // its name is part of the sum
        uLong sum = 0;
        at += word.size();
        while (left > 0) {
            const std::size_t now = std::min<std::uint64_t>(left, piece.size());
            file.readAt(at, std::span(piece).first(now));
            sum = crc32(sum, reinterpret_cast<const Bytef*>(piece.data()), static_cast<uInt>(now));
            at += now;
            left -= now;
        }
        file.readAt(at, word);
        if (bigWord(word, 0) != sum)
            throw badFile(file.path().string(), "PNG chunks with their checksums",
                          "another before byte " + std::to_string(at) + " (damage)");
        at += word.size();
    }
}

PictureHead walkPicture(const InputFile& file) {
    if (beginsAsTiff(file))
        return walkTiff(file);
    if (beginsAsJpeg2000(file))
        return walkJpeg2000Picture(file);
    std::array<char, kPngMark.size()> mark{};
    if (file.readSome(0, std::as_writable_bytes(std::span(mark))) < mark.size() ||
        std::string_view(mark.data(), mark.size()) != kPngMark)
        throw badFile(file.path().string(), "a TIFF, PNG or JPEG 2000 file",
                      file.sizeBytes() == 0 ? "an empty file" : "another beginning");
    return walkPng(file);
}

} // namespace tessera
