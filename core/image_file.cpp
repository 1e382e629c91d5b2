// core/image_file.cpp: see image_file.h. Quantisation, the sRGB curve and (un)premultiplication happen here,
// not in OpenImageIO: it would premultiply encoded values, and its readers and writers differ in when they
// do. "oiio:UnassociatedAlpha" tells it to leave our numbers alone, on both ways.
#include "core/image_file.h"

#include "core/colour.h"
#include "core/error.h"
#include "core/output_file.h"
#include "core/picture_format.h"
#include "core/printable_text.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <exception>

namespace tessera {
namespace {

using Format = PictureFormat;
constexpr int kMaxExtent = 16384; // pixels an axis; a header that says more is a lie to us

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

/// What a picture's library writes through: it may forget to say that a write failed, this does not.
class CheckedOutput final : public OIIO::Filesystem::IOProxy {
  public:
    explicit CheckedOutput(OutputFile& file) : IOProxy("", Write), file_(file) {}
    const char* proxytype() const override { return "tessera"; }
    bool seek(int64_t offset) override {
        m_pos = offset;
        return true;
    }
    size_t write(const void* bytes, size_t size) override {
        const size_t put = pwrite(bytes, size, m_pos);
        m_pos += static_cast<int64_t>(put);
        return put;
    }
    size_t pwrite(const void* bytes, size_t size, int64_t offset) override {
        if (problem_)
            return 0;
        try { // the library is not made for exceptions
            file_.writeAt(static_cast<std::uint64_t>(offset), {static_cast<const std::byte*>(bytes), size});
        } catch (const Error&) {
            problem_ = std::current_exception();
            return 0;
        }
        size_ = std::max(size_, static_cast<size_t>(offset) + size);
        return size;
    }
    size_t size() const override { return size_; }
    /// Throws the Error of the first write that failed.
    void check() const {
        if (problem_)
            std::rethrow_exception(problem_);
    }

  private:
    OutputFile& file_;
    std::exception_ptr problem_;
    size_t size_ = 0;
};

std::string oneLine(std::string text) {
    std::replace(text.begin(), text.end(), '\n', ' ');
    return text;
}

/// Whether a file holds this picture and manifest, value for value.
bool isOnDisk(const std::filesystem::path& path, const std::vector<std::uint16_t>& words,
              const std::string& manifest) {
    OIIO::ImageSpec hints;
    hints["oiio:UnassociatedAlpha"] = 1;
    // By format, not by name: the temporary one has no extension that tells.
    const auto input = OIIO::ImageInput::create("tif");
    OIIO::ImageSpec spec;
    if (!input || !input->open(path.string(), spec, hints) ||
        spec.get_string_attribute("ImageDescription") != manifest)
        return false;
    const auto rowWords = static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.nchannels);
    if (rowWords * static_cast<std::size_t>(spec.height) != words.size())
        return false;
    std::vector<std::uint16_t> row(rowWords);
    auto expected = words.begin();
    for (int y = 0; y < spec.height; ++y, expected += static_cast<std::ptrdiff_t>(rowWords))
        if (!input->read_scanline(y, 0, OIIO::TypeDesc::UINT16, row.data()) ||
            !std::equal(row.begin(), row.end(), expected))
            return false;
    return true;
}

std::unique_ptr<OIIO::ImageInput> openPicture(const std::filesystem::path& path) {
    pictureFormat(path);
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
    pictureFormat(path);
}

void writeImage(const std::filesystem::path& path, const Image& image, const std::string& manifest) {
    const Format format = pictureFormat(path);
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

    OutputFile file(path);
    const auto fail = [&path](const std::string& why) -> Error {
        return Error(printable(path.string()) + ": cannot be written: " + oneLine(why));
    };
    // Created by its name's extension, so that the temporary name decides nothing.
    auto output = OIIO::ImageOutput::create(path.extension().string().substr(1));
    if (!output)
        throw fail(OIIO::geterror());
    // TIFF's writer needs to read what it wrote, which OpenImageIO 2.4 forgot here; isOnDisk() checks
    // instead.
    CheckedOutput through(file);
    if (format != Format::tiff) {
        TESSERA_CHECK(output->supports("ioproxy"));
        output->set_ioproxy(&through);
    }
    const bool opened = output->open(file.path().string(), spec);
    bool written = false;
    std::vector<std::uint16_t> words; // of a TIFF
    if (!opened)
        ; // told below
    else if (format == Format::exr)
        written = output->write_image(OIIO::TypeDesc::FLOAT, image.pixels.data());
    else if (format == Format::png)
        written = output->write_image(type, encode<std::uint8_t>(image, channels).data());
    else {
        words = encode<std::uint16_t>(image, channels);
        written = output->write_image(type, words.data());
    }
    const bool closed = output->close();
    through.check(); // names the system's reason
    if (!written || !closed)
        throw fail(output->geterror());
    if (format == Format::tiff && !isOnDisk(file.path(), words, manifest))
        throw fail("the file did not keep what was written to it; is the disk full?");
    file.finish();
}

Image readImage(const std::filesystem::path& path) {
    const bool linear = pictureFormat(path) == Format::exr;
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
