// core/image/image_file.cpp: see image_file.h. Quantisation, the sRGB curve and (un)premultiplication happen
// here, the formats in picture_*.cpp.
#include "core/image/image_file.h"

#include "core/base/error.h"
#include "core/base/files.h"
#include "core/base/output_file.h"
#include "core/base/shown_text.h"
#include "core/base/threads.h"
#include "core/image/colour.h"
#include "core/image/image.h"
#include "core/image/page_format.h"
#include "core/image/picture_codecs.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace tessera {
namespace {

using Format = PictureFormat;

bool isOpaque(const Image& image) {
    return std::all_of(image.pixels.begin(), image.pixels.end(), [](const glm::vec4& p) { return p.a >= 1; });
}

/// Linear premultiplied to encoded, unassociated integers 0..max. NaN becomes 0.
template <typename Integer> class EncodedRows {
  public:
    EncodedRows(const ImageRows& picture, const std::string& manifest, double dpi)
        : rows{picture.size, picture.opaque ? 3 : 4, manifest, dpi,
               [this](int first, int count) { return encode(first, count); }},
          picture_(picture) {}
    EncodedRows(const EncodedRows&) = delete;
    EncodedRows& operator=(const EncodedRows&) = delete;
    SampleRows<Integer> rows;

  private:
    static Integer quantise(double x) {
        constexpr double kMax = static_cast<double>(static_cast<Integer>(~Integer{0}));
        return static_cast<Integer>(x > 0 ? std::lround(std::min(x, 1.0) * kMax) : 0);
    }
    std::span<const Integer> encode(int first, int count) {
        const std::span<const glm::vec4> pixels = picture_.rows(first, count);
        const auto channels = static_cast<std::size_t>(rows.channels),
                   width = static_cast<std::size_t>(rows.size.x);
        samples_.resize(pixels.size() * channels);
        parallelFor(static_cast<std::size_t>(count), 0, [&](std::size_t row) {
            Integer* out = samples_.data() + row * width * channels;
            for (const glm::vec4& p : pixels.subspan(row * width, width)) {
                const double a = std::min(static_cast<double>(p.a), 1.0);
                for (int c = 0; c < 3; ++c) {
                    const double straight = a > 0 ? static_cast<double>(p[c]) / a : 0.0;
                    *out++ = quantise(srgbFromLinear(std::isnan(straight) ? 0.0 : straight));
                }
                if (channels == 4)
                    *out++ = quantise(a);
            }
        });
        return samples_;
    }
    const ImageRows& picture_;
    std::vector<Integer> samples_;
};

/// The image outlives them.
ImageRows rowsOf(const Image& image) {
    const auto width = static_cast<std::size_t>(image.size.x);
    return {image.size, isOpaque(image), [&image, width](int first, int count) {
                return std::span(image.pixels)
                    .subspan(static_cast<std::size_t>(first) * width,
                             static_cast<std::size_t>(count) * width);
            }};
}

std::string oneLine(std::string text) {
    std::replace(text.begin(), text.end(), '\n', ' ');
    return text;
}

void write(CheckedOutput& out, Format format, const ImageRows& picture, const std::string& manifest,
           std::span<const LayerChannel> layers, const LayerRows* over, double dpi) {
    if (picture.size.x < 1 || picture.size.y < 1)
        throw PictureProblem("there are no pixels");
    switch (format) {
    case Format::png:
        return writePng(out, EncodedRows<std::uint8_t>(picture, manifest, dpi).rows);
    case Format::tiff:
        return writeTiff(out, EncodedRows<std::uint16_t>(picture, manifest, dpi).rows);
    case Format::exr:
        return writeExr(out, picture, layers, over, manifest);
    }
}

void writeFile(const std::filesystem::path& path, const ImageRows& picture, const std::string& manifest,
               std::span<const LayerChannel> layers, const LayerRows* over, double dpi) {
    const Format format = pictureFormat(path);
    TESSERA_CHECK((layers.empty() && !over) || format == Format::exr);
    OutputFile file(path);
    CheckedOutput out(file);
    try {
        write(out, format, picture, manifest, layers, over, dpi);
    } catch (const PictureProblem& problem) {
        out.check(); // names the system's reason
        throw Error(printable(path.string()) + ": cannot be written: " + oneLine(problem.what()));
    }
    out.check(); // errors that the library did not report
    file.finish();
}

PictureFile<float> read(const std::filesystem::path& path, PictureParts parts) {
    refusePipeOrDevice(path);
    const Format format = pictureFormat(path);
    try {
        return format == Format::png    ? readPng(path.string(), parts)
               : format == Format::tiff ? readTiff(path.string(), parts)
                                        : readExr(path.string(), parts);
    } catch (const PictureProblem& problem) {
        throw badFile(path.string(), "a readable picture", oneLine(problem.what()));
    }
}

} // namespace

bool CheckedOutput::write(const void* bytes, std::size_t count) noexcept {
    if (problem_)
        return false;
    try {
        file_.writeAt(position, {static_cast<const std::byte*>(bytes), count});
    } catch (const Error&) {
        problem_ = std::current_exception();
        return false;
    }
    position += count;
    size_ = std::max(size_, position);
    return true;
}

void CheckedOutput::check() const {
    if (problem_)
        std::rethrow_exception(problem_);
}

void checkPicture(const glm::ivec2& size, int channels) {
    if (size.x < 1 || size.y < 1 || size.x > kMostPicturePixels || size.y > kMostPicturePixels ||
        (channels != 3 && channels != 4))
        throw PictureProblem("not 3 or 4 channels and at most 32768 pixels an axis");
}

void checkImagePath(const std::filesystem::path& path) {
    pictureFormat(path);
}

void writeImage(const std::filesystem::path& path, const Image& image, const std::string& manifest,
                std::span<const LayerChannel> layers, double dpi) {
    writeFile(path, rowsOf(image), manifest, layers, nullptr, dpi);
}

void writeImageRows(const std::filesystem::path& path, const ImageRows& picture, const std::string& manifest,
                    double dpi, const LayerRows* over) {
    writeFile(path, picture, manifest, {}, over, dpi);
}

Image readImage(const std::filesystem::path& path) {
    const bool linear = pictureFormat(path) == Format::exr;
    const PictureFile<float> file = read(path, PictureParts::all);
    Image image(file.size);
    const float* value = file.samples.data();
    for (glm::vec4& p : image.pixels) {
        p.a = file.channels == 4 ? value[3] : 1.0f;
        for (int c = 0; c < 3; ++c)
            p[c] =
                linear ? value[c] : static_cast<float>(linearFromSrgb(static_cast<double>(value[c]))) * p.a;
        value += file.channels;
    }
    return image;
}

glm::ivec2 pictureSize(const std::filesystem::path& path) {
    return read(path, PictureParts::header).size;
}

void checkPictureIsWhole(const std::filesystem::path& path) {
    if (pageFormat(path))
        readManifest(path); // looks at the end, too
    else
        read(path, PictureParts::headerAndEnd);
}

std::string readManifest(const std::filesystem::path& path) {
    const std::optional<PageFormat> page = pageFormat(path);
    if (!page)
        return read(path, PictureParts::header).description;
    refusePipeOrDevice(path);
    try {
        return *page == PageFormat::pdf ? pdfManifest(path.string()) : svgManifest(path.string());
    } catch (const PictureProblem& problem) {
        throw badFile(path.string(), "a readable figure", oneLine(problem.what()));
    }
}

} // namespace tessera
