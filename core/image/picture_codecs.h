// core/image/picture_codecs.h: picture files by the formats' own libraries, for image_file.cpp: numbers as
// stored. No library's exception or longjmp leaves these functions.
#pragma once

#include "core/base/output_file.h"
#include "core/image/image.h"
#include "core/image/image_file.h" // LayerRows

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace tessera {

constexpr int kMostPicturePixels = 32768; // per axis; larger headers are refused

/// A problem of a library or a file, in its own words.
class PictureProblem : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

/// Row after row from the top, R, G, B and, where there are four channels, A.
template <typename Sample> struct PictureFile {
    glm::ivec2 size{0};
    int channels = 0;
    std::vector<Sample> samples = {}; // none where only the header was read
    std::string description = {};

    std::size_t rowSamples() const {
        return static_cast<std::size_t>(size.x) * static_cast<std::size_t>(channels);
    }
    /// Room for samples that come row by row; of larger pictures it grows with them, for a header may be
    /// false.
    void reserve() {
        constexpr std::size_t kMost = std::size_t{1} << 30;
        samples.reserve(std::min(kMost, rowSamples() * static_cast<std::size_t>(size.y)));
    }
};

/// Rows to write: numbers as stored, as PictureFile has them.
template <typename Sample> struct SampleRows {
    glm::ivec2 size{0};
    int channels = 0;
    std::string description;
    double dpi = 0; // 0: not told
    /// As ImageRows::rows.
    std::function<std::span<const Sample>(int first, int count)> rows;

    std::size_t rowSamples() const {
        return static_cast<std::size_t>(size.x) * static_cast<std::size_t>(channels);
    }
    /// Calls visit(rows, first, count) for all of them, from the top down.
    template <typename Visit> void eachBand(const Visit& visit) const {
        for (int y = 0; y < size.y; y += ImageRows::kAtOnce) {
            const int count = std::min(ImageRows::kAtOnce, size.y - y);
            visit(rows(y, count), y, count);
        }
    }
};

/// The output of a picture's library: it reports failed writes, which the library may not.
class CheckedOutput {
  public:
    explicit CheckedOutput(OutputFile& file) : file_(file) {}
    /// Writes at the position and advances it. Returns false if that failed, and ever after: throws nothing,
    /// because a C library calls it.
    bool write(const void* bytes, std::size_t count) noexcept;
    std::uint64_t position = 0;
    std::uint64_t size() const { return size_; }
    /// Throws the Error of the first write that failed.
    void check() const;

  private:
    OutputFile& file_;
    std::uint64_t size_ = 0;
    std::exception_ptr problem_;
};

/// headerAndEnd: the end is there, though no samples are kept.
enum class PictureParts { header, headerAndEnd, all };
constexpr const char* kPictureEndsTooSoon = "a picture that ends too soon";

// All throw PictureProblem; those that write throw the file's Error too, and what the rows throw.
void writePng(CheckedOutput& out, const SampleRows<std::uint8_t>& picture);
void writeTiff(CheckedOutput& out, const SampleRows<std::uint16_t>& picture);
void writeExr(CheckedOutput& out, const ImageRows& picture, std::span<const LayerChannel> layers,
              const LayerRows* over, const std::string& description);
/// The manifest that a page keeps; "" if none.
std::string pdfManifest(const std::string& path);
std::string svgManifest(const std::string& path);
/// Integers become shares of the largest.
PictureFile<float> readPng(const std::string& path, PictureParts parts);
PictureFile<float> readTiff(const std::string& path, PictureParts parts);
/// Of the channels without a layer's name.
PictureFile<float> readExr(const std::string& path, PictureParts parts);

/// Throws PictureProblem unless it is a picture that this program could have written.
void checkPicture(const glm::ivec2& size, int channels);

} // namespace tessera
