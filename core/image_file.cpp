// core/image_file.cpp: see image_file.h. Quantisation, the sRGB curve and (un)premultiplication happen here,
// not in OpenImageIO: it would premultiply encoded values, and its readers and writers differ in when they
// do. "oiio:UnassociatedAlpha" tells it to leave our numbers alone, on both ways.
#include "core/image_file.h"

#include "core/colour.h"
#include "core/error.h"
#include "core/interrupt.h"

#include <OpenImageIO/imageio.h>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <unistd.h> // getpid: a temporary name of our own

namespace tessera {
namespace {

enum class Format { png, exr, tiff };
constexpr int kMaxExtent = 16384; // pixels an axis; a header that says more is a lie to us

Format formatOf(const std::filesystem::path& path) {
    std::string extension = path.extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (extension == ".png")
        return Format::png;
    if (extension == ".exr")
        return Format::exr;
    if (extension == ".tif" || extension == ".tiff")
        return Format::tiff;
    throw badFile(path.string(), "a picture's name ending in .png, .exr, .tif or .tiff",
                  extension.empty() ? "no extension" : "\"" + extension + "\"");
}

bool isOpaque(const Image& image) {
    return std::all_of(image.pixels.begin(), image.pixels.end(), [](const glm::vec4& p) { return p.a >= 1; });
}

/// Linear premultiplied to encoded, unassociated integers 0..max. What is not a number becomes 0.
template <typename Integer> std::vector<Integer> encode(const Image& image, int channels) {
    constexpr double kMax = static_cast<double>(static_cast<Integer>(~Integer{0}));
    const auto quantise = [](double x) {
        return static_cast<Integer>(x > 0 ? std::lround(std::min(x, 1.0) * kMax) : 0);
    };
    std::vector<Integer> out;
    out.reserve(image.pixels.size() * static_cast<std::size_t>(channels));
    for (const glm::vec4& p : image.pixels) {
        const double a = std::min(static_cast<double>(p.a), 1.0);
        for (int c = 0; c < 3; ++c) {
            const double straight = a > 0 ? static_cast<double>(p[c]) / a : 0.0;
            out.push_back(quantise(srgbFromLinear(std::isnan(straight) ? 0.0 : straight)));
        }
        if (channels == 4)
            out.push_back(quantise(a));
    }
    return out;
}

/// An unfinished picture; removed unless it gets its final name.
class TemporaryFile {
  public:
    explicit TemporaryFile(const std::filesystem::path& target)
        : path_(target.parent_path() / std::string(".")
                                           .append(std::to_string(::getpid()))
                                           .append("-")
                                           .append(target.filename().string())),
          target_(target), unfinished_(path_) {}
    TemporaryFile(const TemporaryFile&) = delete;
    TemporaryFile& operator=(const TemporaryFile&) = delete;
    ~TemporaryFile() {
        std::error_code ignored;
        if (!renamed_)
            std::filesystem::remove(path_, ignored);
    }
    void finish() {
        std::error_code error;
        unfinished_.forget();
        std::filesystem::rename(path_, target_, error);
        if (error)
            throw Error(target_.string() + ": cannot be written: " + error.message());
        renamed_ = true;
    }
    std::string name() const { return path_.string(); }

  private:
    std::filesystem::path path_, target_;
    TemporaryPath unfinished_;
    bool renamed_ = false;
};

std::string oneLine(std::string text) {
    std::replace(text.begin(), text.end(), '\n', ' ');
    return text;
}

std::unique_ptr<OIIO::ImageInput> openPicture(const std::filesystem::path& path) {
    formatOf(path);
    OIIO::ImageSpec hints;
    hints["oiio:UnassociatedAlpha"] = 1;
    auto input = OIIO::ImageInput::open(path.string(), &hints);
    if (!input)
        throw badFile(path.string(), "a readable picture", oneLine(OIIO::geterror()));
    const OIIO::ImageSpec& spec = input->spec();
    if (spec.width < 1 || spec.height < 1 || spec.width > kMaxExtent || spec.height > kMaxExtent ||
        spec.depth > 1 || (spec.nchannels != 3 && spec.nchannels != 4))
        throw badFile(path.string(), "3 or 4 channels and at most 16384 pixels an axis",
                      std::to_string(spec.nchannels) + " channels, " + std::to_string(spec.width) + "x" +
                          std::to_string(spec.height));
    return input;
}

} // namespace

void checkImagePath(const std::filesystem::path& path) {
    formatOf(path);
}

void writeImage(const std::filesystem::path& path, const Image& image, const std::string& manifest) {
    const Format format = formatOf(path);
    if (std::filesystem::is_directory(path))
        throw badFile(path.string(), "a file to write", "a folder");
    const int channels = format == Format::exr || !isOpaque(image) ? 4 : 3;
    const OIIO::TypeDesc type = format == Format::exr   ? OIIO::TypeDesc::FLOAT
                                : format == Format::png ? OIIO::TypeDesc::UINT8
                                                        : OIIO::TypeDesc::UINT16;
    OIIO::ImageSpec spec(image.size.x, image.size.y, channels, type);
    spec["ImageDescription"] = manifest;
    spec["oiio:ColorSpace"] = format == Format::exr ? "Linear" : "sRGB";
    spec["Software"] = "Tessera";
    if (format != Format::exr)
        spec["oiio:UnassociatedAlpha"] = 1;
    spec["compression"] = format == Format::tiff ? "lzw" : "zip"; // both lossless; png ignores it

    TemporaryFile file(path);
    const auto fail = [&path](const std::string& why) -> Error {
        return Error(path.string() + ": cannot be written: " + oneLine(why));
    };
    // Created by its name's extension, so that the temporary name decides nothing.
    auto output = OIIO::ImageOutput::create(path.extension().string().substr(1));
    if (!output)
        throw fail(OIIO::geterror());
    if (!output->open(file.name(), spec))
        throw fail(output->geterror());
    bool written = false;
    if (format == Format::exr)
        written = output->write_image(OIIO::TypeDesc::FLOAT, image.pixels.data());
    else if (format == Format::png)
        written = output->write_image(type, encode<std::uint8_t>(image, channels).data());
    else
        written = output->write_image(type, encode<std::uint16_t>(image, channels).data());
    if (!written || !output->close())
        throw fail(output->geterror());
    file.finish();
}

Image readImage(const std::filesystem::path& path) {
    const bool linear = formatOf(path) == Format::exr;
    const auto input = openPicture(path);
    const int channels = input->spec().nchannels;
    Image image(glm::ivec2(input->spec().width, input->spec().height));
    std::vector<float> values(image.pixels.size() * static_cast<std::size_t>(channels));
    if (!input->read_image(0, 0, 0, channels, OIIO::TypeDesc::FLOAT, values.data()))
        throw badFile(path.string(), "a whole picture", oneLine(input->geterror()));
    const float* value = values.data();
    for (glm::vec4& p : image.pixels) {
        p.a = channels == 4 ? value[3] : 1.0f;
        for (int c = 0; c < 3; ++c)
            p[c] =
                linear ? value[c] : static_cast<float>(linearFromSrgb(static_cast<double>(value[c]))) * p.a;
        value += channels;
    }
    return image;
}

std::string readManifest(const std::filesystem::path& path) {
    return openPicture(path)->spec().get_string_attribute("ImageDescription");
}

} // namespace tessera
