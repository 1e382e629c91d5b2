// core/image/picture_png.cpp: PNG by libpng, for picture_codecs.h. The library leaves a call that fails by a
// jump: calls() runs some of them, and nothing in there has a destructor that a jump would pass over.
#include "core/image/picture_codecs.h"

#include <bit>
#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <memory>
#include <png.h>

namespace tessera {
namespace {

/// Keeps the library's message and jumps back.
[[noreturn]] void onError(png_structp png, png_const_charp words) {
    static_cast<std::string*>(png_get_error_ptr(png))->assign(words);
    png_longjmp(png, 1);
}
void onWarning(png_structp, png_const_charp) {}

void onWrite(png_structp png, png_bytep bytes, std::size_t count) {
    if (!static_cast<CheckedOutput*>(png_get_io_ptr(png))->write(bytes, count))
        png_error(png, "a write failed");
}
void onFlush(png_structp) {}

/// The library's two objects, for reading or for writing.
class Png {
  public:
    explicit Png(bool writes) : writes_(writes) {
        png = writes ? png_create_write_struct(PNG_LIBPNG_VER_STRING, &words_, onError, onWarning)
                     : png_create_read_struct(PNG_LIBPNG_VER_STRING, &words_, onError, onWarning);
        info = png ? png_create_info_struct(png) : nullptr;
    }
    ~Png() {
        if (writes_)
            png_destroy_write_struct(&png, &info);
        else
            png_destroy_read_struct(&png, &info, nullptr);
    }
    Png(const Png&) = delete;
    Png& operator=(const Png&) = delete;

    /// Throws PictureProblem where one of the library's calls fails.
    template <typename Body> void calls(const Body& body) {
        if (!png || !info)
            throw PictureProblem("libpng does not start");
        if (!returns(body))
            throw PictureProblem(words_);
    }
    png_structp png;
    png_infop info;

  private:
    template <typename Body> bool returns(const Body& body) {
        if (setjmp(png_jmpbuf(png)) != 0)
            return false;
        body();
        return true;
    }
    const bool writes_;
    std::string words_;
};

constexpr const char* kPngDescription = "Description"; // PNG's keyword
constexpr png_alloc_size_t kMostTextBytes = 16u << 20; // a manifest has some thousands

/// True if the last chunk is that of a file's end.
bool endsWhole(std::FILE* file) {
    constexpr char kEnd[] = "\0\0\0\0IEND\xae\x42\x60\x82"; // length, kind, checksum
    constexpr long kBytes = sizeof kEnd - 1;
    char last[kBytes];
    return std::fseek(file, -kBytes, SEEK_END) == 0 && std::fread(last, 1, kBytes, file) == kBytes &&
           std::memcmp(last, kEnd, kBytes) == 0;
}

} // namespace

void writePng(CheckedOutput& out, const SampleRows<std::uint8_t>& picture) {
    Png file(true);
    const png_structp png = file.png;
    const png_infop info = file.info;
    std::string keys[2] = {kPngDescription, "Software"}, texts[2] = {picture.description, "Tessera"};
    png_text both[2] = {};
    for (int i = 0; i < 2; ++i) {
        both[i].compression = PNG_TEXT_COMPRESSION_NONE;
        both[i].key = keys[i].data();
        both[i].text = texts[i].data();
        both[i].text_length = texts[i].size();
    }
    file.calls([&] {
        png_set_write_fn(png, &out, onWrite, onFlush);
        png_set_IHDR(png, info, static_cast<png_uint_32>(picture.size.x),
                     static_cast<png_uint_32>(picture.size.y), 8,
                     picture.channels == 4 ? PNG_COLOR_TYPE_RGB_ALPHA : PNG_COLOR_TYPE_RGB,
                     PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
        png_set_sRGB_gAMA_and_cHRM(png, info, PNG_sRGB_INTENT_ABSOLUTE);
        png_set_text(png, info, both, 2);
        if (picture.dpi > 0) {
            const auto perMetre = static_cast<png_uint_32>(picture.dpi / 0.0254 + 0.5);
            png_set_pHYs(png, info, perMetre, perMetre, PNG_RESOLUTION_METER);
        }
        png_set_filter(png, 0, PNG_FILTER_NONE); // the other filters cost more time than they save
        png_write_info(png, info);
    });
    picture.eachBand([&](std::span<const std::uint8_t> rows, int, int) {
        file.calls([&] {
            for (std::size_t row = 0; row < rows.size(); row += picture.rowSamples())
                png_write_row(png, &rows[row]);
        });
    });
    file.calls([&] { png_write_end(png, nullptr); });
}

PictureFile<float> readPng(const std::string& path, PictureParts parts) {
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> stream(std::fopen(path.c_str(), "rb"), std::fclose);
    if (!stream)
        throw PictureProblem("a file that cannot be opened");
    Png file(false);
    const png_structp png = file.png;
    const png_infop info = file.info;
    png_textp texts = nullptr;
    int count = 0, bits = 0;
    bool interlaced = false;
    PictureFile<float> picture;
    file.calls([&] {
        png_set_user_limits(png, kMostPicturePixels, kMostPicturePixels);
        png_set_chunk_malloc_max(png, kMostTextBytes);
        png_set_benign_errors(png, 0); // otherwise too long a text is only a warning
        png_init_io(png, stream.get());
        png_read_info(png, info);
        png_set_expand(png); // palettes, transparent colours, less than 8 bits
        if constexpr (std::endian::native == std::endian::little)
            png_set_swap(png);
        interlaced = png_get_interlace_type(png, info) != PNG_INTERLACE_NONE;
        png_read_update_info(png, info);
        picture.size = {png_get_image_width(png, info), png_get_image_height(png, info)};
        picture.channels = png_get_channels(png, info);
        bits = png_get_bit_depth(png, info);
        count = png_get_text(png, info, &texts, &count);
    });
    checkPicture(picture.size, picture.channels);
    for (int i = 0; i < count; ++i)
        if (texts[i].key == std::string(kPngDescription))
            picture.description = texts[i].text;
    if (parts == PictureParts::headerAndEnd && !endsWhole(stream.get()))
        throw PictureProblem(kPictureEndsTooSoon);
    if (parts != PictureParts::all)
        return picture;

    if (interlaced)
        throw PictureProblem("an interlaced PNG");
    picture.reserve();
    std::vector<png_byte> row(picture.rowSamples() * static_cast<std::size_t>(bits / 8));
    for (int y = 0; y < picture.size.y; ++y) {
        file.calls([&] { png_read_row(png, row.data(), nullptr); });
        for (std::size_t i = 0; i < picture.rowSamples(); ++i)
            if (bits == 8) {
                picture.samples.push_back(static_cast<float>(row[i]) / 255);
            } else {
                std::uint16_t word = 0;
                std::memcpy(&word, &row[2 * i], sizeof word);
                picture.samples.push_back(static_cast<float>(word) / 65535);
            }
    }
    return picture;
}

} // namespace tessera
