// core/image/picture_exr.cpp: OpenEXR by its own library, for picture_codecs.h: float channels R, G, B, A,
// and those of layers, by their full names (openexr.com, "Layers").
#include "core/image/picture_codecs.h"

#include "core/base/error.h"
#include "core/base/interrupt.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#include <ImfStringAttribute.h>
#include <algorithm>
#include <array>
#include <span>
#include <string_view>

namespace tessera {
namespace {

constexpr std::array<const char*, 4> kChannels = {"R", "G", "B", "A"};
constexpr const char* kExrDescription = "comments"; // EXR's name of the attribute

class Stream final : public Imf::OStream {
  public:
    explicit Stream(CheckedOutput& out) : OStream(""), out_(out) {}
    void write(const char* bytes, int count) override {
        if (!out_.write(bytes, static_cast<std::size_t>(count)))
            throw PictureProblem("a write failed");
    }
    std::uint64_t tellp() override { return out_.position; }
    void seekp(std::uint64_t position) override { out_.position = position; }

  private:
    CheckedOutput& out_;
};

/// Channel c of floats that stand pixel after pixel, the first one at the window's corner.
Imf::Slice sliceOf(const float* pixels, std::size_t channels, std::size_t c, const Imath::Box2i& window) {
    const std::size_t pixelBytes = channels * sizeof(float);
    const auto width = static_cast<std::size_t>(window.size().x + 1);
    return Imf::Slice::Make(Imf::FLOAT, pixels + c, window, pixelBytes, pixelBytes * width, 1, 1,
                            c == 3 ? 1.0 : 0.0);
}

PictureFile<float> read(const std::string& path, PictureParts parts) {
    // Before opening, which already takes memory for every line in the header.
    Imf::Header::setMaxImageSize(kMostPicturePixels, kMostPicturePixels);
    Imf::InputFile file(path.c_str(), 0);
    const Imf::Header& header = file.header();
    const Imath::Box2i window = header.dataWindow();
    PictureFile<float> picture;
    const auto extent = [](int low, int high) { // safe for any numbers in a header
        return static_cast<int>(
            std::clamp<std::int64_t>(std::int64_t{high} - low + 1, 0, kMostPicturePixels + 1));
    };
    picture.size = {extent(window.min.x, window.max.x), extent(window.min.y, window.max.y)};
    for (auto channel = header.channels().begin(); channel != header.channels().end(); ++channel) {
        const Imf::Channel& kind = channel.channel();
        if (std::string_view(channel.name()).find('.') != std::string_view::npos)
            continue; // a layer's
        if (kind.xSampling != 1 || kind.ySampling != 1)
            throw PictureProblem("channels of several resolutions");
        ++picture.channels;
    }
    checkPicture(picture.size, picture.channels);
    for (int c = 0; c < picture.channels; ++c)
        if (!header.channels().findChannel(kChannels[static_cast<std::size_t>(c)]))
            throw PictureProblem("channels of other names than R, G, B and A");
    if (const auto* text = header.findTypedAttribute<Imf::StringAttribute>(kExrDescription))
        picture.description = text->value();
    if (parts == PictureParts::header)
        return picture;
    if (parts == PictureParts::headerAndEnd) {
        if (!file.isComplete())
            throw PictureProblem(kPictureEndsTooSoon);
        std::vector<float> row(static_cast<std::size_t>(picture.size.x));
        Imath::Box2i last = window;
        last.min.y = last.max.y;
        Imf::FrameBuffer buffer;
        buffer.insert(kChannels[0], sliceOf(row.data(), 1, 0, last));
        file.setFrameBuffer(buffer);
        file.readPixels(window.max.y, window.max.y);
        return picture;
    }
    const auto channels = static_cast<std::size_t>(picture.channels);
    picture.reserve();
    constexpr int kRows = 64; // at a time, so that a false header takes no memory for missing rows
    std::vector<float> rows;
    for (int y = 0; y < picture.size.y; y += kRows) {
        const int count = std::min(kRows, picture.size.y - y);
        Imath::Box2i band = window;
        band.min.y = window.min.y + y;
        band.max.y = band.min.y + count - 1;
        rows.assign(picture.rowSamples() * static_cast<std::size_t>(count), 0.0f);
        Imf::FrameBuffer buffer;
        for (std::size_t c = 0; c < channels; ++c)
            buffer.insert(kChannels[c], sliceOf(rows.data(), channels, c, band));
        file.setFrameBuffer(buffer);
        file.readPixels(band.min.y, band.max.y);
        picture.samples.insert(picture.samples.end(), rows.begin(), rows.end());
    }
    return picture;
}

} // namespace

void writeExr(CheckedOutput& out, const ImageRows& picture, std::span<const LayerChannel> layers,
              const LayerRows* over, const std::string& description) {
    try {
        Imf::Header header(picture.size.x, picture.size.y);
        header.compression() = Imf::ZIP_COMPRESSION;
        header.insert(kExrDescription, Imf::StringAttribute(description));
        header.insert("Software", Imf::StringAttribute("Tessera"));
        for (const char* channel : kChannels)
            header.channels().insert(channel, Imf::Channel(Imf::FLOAT));
        for (const LayerChannel& layer : layers)
            header.channels().insert(layer.name, Imf::Channel(Imf::FLOAT));
        for (const char* channel : kChannels)
            if (over)
                header.channels().insert(over->name + "." + channel, Imf::Channel(Imf::FLOAT));
        Stream stream(out);
        Imf::OutputFile file(stream, header, 0);
        for (int y = 0; y < picture.size.y; y += ImageRows::kAtOnce) {
            checkInterrupted();
            Imath::Box2i band = header.dataWindow();
            band.min.y = y;
            band.max.y = std::min(y + ImageRows::kAtOnce, picture.size.y) - 1;
            const int count = band.max.y - y + 1;
            const std::span<const glm::vec4> rows = picture.rows(y, count);
            Imf::FrameBuffer buffer;
            for (std::size_t c = 0; c < kChannels.size(); ++c)
                buffer.insert(kChannels[c], sliceOf(&rows[0].x, 4, c, band));
            for (const LayerChannel& layer : layers)
                buffer.insert(layer.name, sliceOf(layer.first, layer.stride, 0, header.dataWindow()));
            const std::span<const glm::vec4> above =
                over ? over->picture.rows(y, count) : std::span<const glm::vec4>();
            for (std::size_t c = 0; over && c < kChannels.size(); ++c)
                buffer.insert(over->name + "." + kChannels[c], sliceOf(&above[0].x, 4, c, band));
            file.setFrameBuffer(buffer);
            file.writePixels(count);
        }
    } catch (const Error&) { // of the rows
        throw;
    } catch (const Interrupted&) {
        throw;
    } catch (const Cancelled&) {
        throw;
    } catch (const std::exception& problem) {
        throw PictureProblem(problem.what());
    }
}

PictureFile<float> readExr(const std::string& path, PictureParts parts) {
    try {
        return read(path, parts);
    } catch (const std::exception& problem) {
        throw PictureProblem(problem.what());
    }
}

} // namespace tessera
