// core/image/picture_tiff.cpp: TIFF by libtiff, for picture_codecs.h: 8 or 16 bits a sample, in strips.
#include "core/image/picture_codecs.h"

#include <algorithm>
#include <cstdarg>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <tiffio.h>

namespace tessera {
namespace {

/// Keeps the library's first error, which is the nearest to the cause.
int onError(TIFF*, void* words, const char*, const char* format, va_list values) {
    char text[512];
    std::vsnprintf(text, sizeof text, format, values);
    auto& kept = *static_cast<std::string*>(words);
    if (kept.empty())
        kept = text;
    return 1; // handled: the library prints nothing
}
int onWarning(TIFF*, void*, const char*, const char*, va_list) {
    return 1;
}

CheckedOutput& outputOf(thandle_t handle) {
    return *static_cast<CheckedOutput*>(handle);
}
tmsize_t onRead(thandle_t, void*, tmsize_t) {
    return 0; // one directory, written once: nothing is read back
}
tmsize_t onWrite(thandle_t handle, void* bytes, tmsize_t count) {
    return outputOf(handle).write(bytes, static_cast<std::size_t>(count)) ? count : -1;
}
toff_t onSeek(thandle_t handle, toff_t offset, int from) {
    CheckedOutput& out = outputOf(handle);
    return out.position = from == SEEK_SET ? offset : (from == SEEK_CUR ? out.position : out.size()) + offset;
}
int onClose(thandle_t) {
    return 0;
}
toff_t onSize(thandle_t handle) {
    return outputOf(handle).size();
}

using Options = std::unique_ptr<TIFFOpenOptions, decltype(&TIFFOpenOptionsFree)>;
using Tiff = std::unique_ptr<TIFF, decltype(&TIFFClose)>;

/// @param words  gets the library's error; must outlive the opened file
Options optionsFor(std::string& words) {
    Options options(TIFFOpenOptionsAlloc(), TIFFOpenOptionsFree);
    if (options) {
        TIFFOpenOptionsSetErrorHandlerExtR(options.get(), onError, &words);
        TIFFOpenOptionsSetWarningHandlerExtR(options.get(), onWarning, nullptr);
    }
    return options;
}

void setTags(TIFF* tiff, const SampleRows<std::uint16_t>& picture) {
    constexpr int kRowsPerStrip = 32;
    TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, picture.size.x);
    TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, picture.size.y);
    TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 16);
    TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, SAMPLEFORMAT_UINT);
    TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, picture.channels);
    TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_RGB);
    TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
    TIFFSetField(tiff, TIFFTAG_ORIENTATION, ORIENTATION_TOPLEFT);
    TIFFSetField(tiff, TIFFTAG_COMPRESSION, COMPRESSION_LZW);
    TIFFSetField(tiff, TIFFTAG_PREDICTOR, PREDICTOR_HORIZONTAL);
    TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, kRowsPerStrip);
    TIFFSetField(tiff, TIFFTAG_IMAGEDESCRIPTION, picture.description.c_str());
    TIFFSetField(tiff, TIFFTAG_SOFTWARE, "Tessera");
    if (picture.dpi > 0) {
        TIFFSetField(tiff, TIFFTAG_RESOLUTIONUNIT, RESUNIT_INCH);
        TIFFSetField(tiff, TIFFTAG_XRESOLUTION, picture.dpi);
        TIFFSetField(tiff, TIFFTAG_YRESOLUTION, picture.dpi);
    }
    const std::uint16_t straight = EXTRASAMPLE_UNASSALPHA;
    if (picture.channels == 4)
        TIFFSetField(tiff, TIFFTAG_EXTRASAMPLES, 1, &straight);
}

template <typename Sample> void readRows(TIFF* tiff, PictureFile<float>& picture, const std::string& words) {
    std::vector<Sample> row(picture.rowSamples());
    picture.reserve();
    constexpr auto kMax = static_cast<float>(static_cast<Sample>(~Sample{0}));
    for (int y = 0; y < picture.size.y; ++y) {
        if (TIFFReadScanline(tiff, row.data(), static_cast<std::uint32_t>(y), 0) != 1)
            throw PictureProblem(words);
        for (const Sample sample : row)
            picture.samples.push_back(static_cast<float>(sample) / kMax);
    }
}

/// True if all strips or tiles lie within the file, and what writeTiff() writes last does.
bool endsWhole(TIFF* tiff) {
    if (const char* text = nullptr; TIFFGetField(tiff, TIFFTAG_SOFTWARE, &text) != 1)
        return false;
    const std::uint64_t size = TIFFGetSizeProc(tiff)(TIFFClientdata(tiff));
    const std::uint32_t count = TIFFIsTiled(tiff) ? TIFFNumberOfTiles(tiff) : TIFFNumberOfStrips(tiff);
    for (std::uint32_t n = 0; n < count; ++n) {
        const std::uint64_t at = TIFFGetStrileOffset(tiff, n), bytes = TIFFGetStrileByteCount(tiff, n);
        if (at == 0 || bytes == 0 || at > size || bytes > size - at)
            return false;
    }
    return true;
}

} // namespace

void writeTiff(CheckedOutput& out, const SampleRows<std::uint16_t>& picture) {
    std::string words;
    const Options options = optionsFor(words);
    // A file of 4 GiB and more is a BigTIFF; compression may make it longer than its samples.
    constexpr std::uint64_t kMostOfClassic = std::uint64_t{5} << 29;
    const std::uint64_t bytes =
        picture.rowSamples() * sizeof(std::uint16_t) * static_cast<std::uint64_t>(picture.size.y);
    Tiff tiff(TIFFClientOpenExt("", bytes > kMostOfClassic ? "w8" : "w", &out, onRead, onWrite, onSeek,
                                onClose, onSize, nullptr, nullptr, options.get()),
              TIFFClose);
    if (!tiff)
        throw PictureProblem(words);
    setTags(tiff.get(), picture);
    std::vector<std::uint16_t> row; // the library changes what it is given
    picture.eachBand([&](std::span<const std::uint16_t> rows, int first, int count) {
        for (int y = 0; y < count; ++y) {
            const auto mine =
                rows.subspan(picture.rowSamples() * static_cast<std::size_t>(y), picture.rowSamples());
            row.assign(mine.begin(), mine.end());
            if (TIFFWriteScanline(tiff.get(), row.data(), static_cast<std::uint32_t>(first + y), 0) != 1)
                throw PictureProblem(words);
        }
    });
    if (TIFFFlush(tiff.get()) != 1)
        throw PictureProblem(words);
}

PictureFile<float> readTiff(const std::string& path, PictureParts parts) {
    std::string words;
    const Options options = optionsFor(words);
    const Tiff tiff(TIFFOpenExt(path.c_str(), "r", options.get()), TIFFClose);
    if (!tiff)
        throw PictureProblem(words);
    std::uint32_t width = 0, height = 0;
    std::uint16_t channels = 0, bits = 0, format = 0, planes = 0, meaning = 0;
    TIFFGetField(tiff.get(), TIFFTAG_IMAGEWIDTH, &width);
    TIFFGetField(tiff.get(), TIFFTAG_IMAGELENGTH, &height);
    TIFFGetFieldDefaulted(tiff.get(), TIFFTAG_SAMPLESPERPIXEL, &channels);
    TIFFGetFieldDefaulted(tiff.get(), TIFFTAG_BITSPERSAMPLE, &bits);
    TIFFGetFieldDefaulted(tiff.get(), TIFFTAG_SAMPLEFORMAT, &format);
    TIFFGetFieldDefaulted(tiff.get(), TIFFTAG_PLANARCONFIG, &planes);
    TIFFGetField(tiff.get(), TIFFTAG_PHOTOMETRIC, &meaning);
    constexpr std::uint32_t kMost =
        kMostPicturePixels + 1; // larger sizes are refused as well, and this fits an int
    PictureFile<float> picture{{std::min(width, kMost), std::min(height, kMost)}, channels};
    checkPicture(picture.size, picture.channels);
    if (const char* text = nullptr; TIFFGetField(tiff.get(), TIFFTAG_IMAGEDESCRIPTION, &text) == 1)
        picture.description = text;
    if (parts == PictureParts::headerAndEnd && !endsWhole(tiff.get()))
        throw PictureProblem(kPictureEndsTooSoon);
    if (parts != PictureParts::all)
        return picture;
    if ((bits != 8 && bits != 16) || format != SAMPLEFORMAT_UINT || planes != PLANARCONFIG_CONTIG ||
        meaning != PHOTOMETRIC_RGB || TIFFIsTiled(tiff.get()))
        throw PictureProblem("a TIFF that is not RGB of 8 or 16 bits in strips");
    if (bits == 8)
        readRows<std::uint8_t>(tiff.get(), picture, words);
    else
        readRows<std::uint16_t>(tiff.get(), picture, words);
    return picture;
}

} // namespace tessera
