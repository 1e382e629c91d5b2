// tests/support/stream_writer.h: compressed streams for DICOM fixtures, by the libraries' encoders: samples
// [y][x] as words.
#pragma once

#include "bricking/import/codecs/stream.h"

// DCMTK's configuration must come before its other headers.
#include <dcmtk/config/osconfig.h>

#include <charls/charls.h>
#include <cstdint>
#include <cstring>
#include <dcmtk/dcmjpeg/djcparam.h>
#include <dcmtk/dcmjpeg/djeijg12.h>
#include <dcmtk/dcmjpeg/djeijg16.h>
#include <dcmtk/dcmjpeg/djeijg8.h>
#include <dcmtk/dcmjpeg/djrploss.h>
#include <gtest/gtest.h>
#include <openjpeg.h>
#include <string>
#include <vector>

namespace tessera::test {

inline Bytes bytesOf(const std::string& text) {
    return std::as_bytes(std::span(text));
}

/// One segment a byte, most significant first; literals only, rows of at most 128.
inline std::string encodeRle(const std::vector<std::uint16_t>& words, int bytesPerSample = 2) {
    std::vector<std::string> segments;
    for (int byte = bytesPerSample - 1; byte >= 0; --byte) {
        std::string segment;
        for (std::size_t i = 0; i < words.size();) {
            std::size_t run = 1;
            const auto at = [&](std::size_t k) { return static_cast<char>(words[k] >> (8 * byte) & 255); };
            while (run < 128 && i + run < words.size() && at(i + run) == at(i))
                ++run;
            if (run > 2) {
                segment += static_cast<char>(257 - run);
                segment += at(i);
            } else {
                run = std::min<std::size_t>(words.size() - i, 64);
                segment += static_cast<char>(run - 1);
                for (std::size_t k = 0; k < run; ++k)
                    segment += at(i + k);
            }
            i += run;
        }
        if (segment.size() % 2)
            segment += '\0';
        segments.push_back(segment);
    }
    std::string stream(64, '\0');
    const auto put = [&](std::size_t at, std::size_t value) {
        for (std::size_t i = 0; i < 4; ++i)
            stream[at + i] = static_cast<char>(value >> (8 * i) & 255);
    };
    put(0, segments.size());
    for (std::size_t i = 0; i < segments.size(); ++i) {
        put(4 + 4 * i, stream.size());
        stream += segments[i];
    }
    return stream;
}

/// @param near  the largest error of a sample; 0: lossless
inline std::string encodeJpegLs(const std::vector<std::uint16_t>& words, int columns, int rows, int bits,
                                int near = 0) {
    charls::jpegls_encoder encoder;
    encoder.frame_info({static_cast<std::uint32_t>(columns), static_cast<std::uint32_t>(rows), bits, 1});
    encoder.near_lossless(near);
    std::string stream(encoder.estimated_destination_size() + 1024, '\0');
    encoder.destination(stream.data(), stream.size());
    if (bits > 8) {
        stream.resize(encoder.encode(words.data(), 2 * words.size()));
    } else {
        const std::vector<std::uint8_t> narrow(words.begin(), words.end());
        stream.resize(encoder.encode(narrow.data(), narrow.size()));
    }
    return stream;
}

template <class Encoder, class Sample>
std::string encodeJpegWith(Encoder& encoder, const std::vector<std::uint16_t>& words, int columns, int rows) {
    std::vector<Sample> samples(words.begin(), words.end());
    Uint8* to = nullptr;
    Uint32 length = 0;
    EXPECT_TRUE(encoder
                    .encode(static_cast<Uint16>(columns), static_cast<Uint16>(rows), EPI_Monochrome2, 1,
                            samples.data(), to, length)
                    .good());
    std::string stream(reinterpret_cast<char*>(to), length);
    delete[] to;
    return stream;
}
inline const DJCodecParameter& encoderParameter() {
    static const DJCodecParameter parameter(ECC_monochrome, EDC_never, EUC_never, EPC_default);
    return parameter;
}
/// 16 bits a sample.
/// @param pointTransform  low bits that are left out: lossy above 0
inline std::string encodeJpegLossless(const std::vector<std::uint16_t>& words, int columns, int rows,
                                      int predictor = 1, int pointTransform = 0) {
    DJCompressIJG16Bit encoder(encoderParameter(), EJM_lossless, predictor, pointTransform);
    return encodeJpegWith<DJCompressIJG16Bit, Uint16>(encoder, words, columns, rows);
}
inline std::string encodeJpegLossy12(const std::vector<std::uint16_t>& words, int columns, int rows,
                                     int quality = 90) {
    DJCompressIJG12Bit encoder(encoderParameter(), EJM_sequential, static_cast<Uint8>(quality));
    return encodeJpegWith<DJCompressIJG12Bit, Uint16>(encoder, words, columns, rows);
}
inline std::string encodeJpegLossy8(const std::vector<std::uint16_t>& words, int columns, int rows,
                                    int quality = 90) {
    DJCompressIJG8Bit encoder(encoderParameter(), EJM_baseline, static_cast<Uint8>(quality));
    return encodeJpegWith<DJCompressIJG8Bit, Uint8>(encoder, words, columns, rows);
}

struct Jpeg2000Options {
    int bits = 16;
    bool isSigned = false, reversible = true;
    int layers = 1;
    float ratio = 0;            // of the last layer; 0: all there is
    bool packetMarkers = false; // SOP before every packet
    int tile = 0;               // its side; 0: one tile
    int components = 1;         // all alike
};
inline std::string encodeJpeg2000(const std::vector<std::int32_t>& values, int columns, int rows,
                                  const Jpeg2000Options& options = {}) {
    opj_cparameters_t p;
    opj_set_default_encoder_parameters(&p);
    p.tcp_numlayers = options.layers;
    for (int layer = 0; layer < options.layers; ++layer)
        p.tcp_rates[layer] = layer + 1 < options.layers
                                 ? static_cast<float>(1 << (options.layers - 1 - layer))
                                 : options.ratio;
    p.cp_disto_alloc = 1;
    p.irreversible = options.reversible ? 0 : 1;
    p.numresolution = 4;
    if (options.packetMarkers)
        p.csty |= 2;
    if (options.tile > 0) {
        p.tile_size_on = OPJ_TRUE;
        p.cp_tdx = p.cp_tdy = options.tile;
    }
    opj_image_cmptparm_t component{};
    component.dx = component.dy = 1;
    component.w = static_cast<OPJ_UINT32>(columns);
    component.h = static_cast<OPJ_UINT32>(rows);
    component.prec = static_cast<OPJ_UINT32>(options.bits);
    component.sgnd = options.isSigned ? 1 : 0;
    std::vector<opj_image_cmptparm_t> components(static_cast<std::size_t>(options.components), component);
    opj_image_t* image =
        opj_image_create(static_cast<OPJ_UINT32>(options.components), components.data(), OPJ_CLRSPC_GRAY);
    image->x1 = component.w;
    image->y1 = component.h;
    for (int c = 0; c < options.components; ++c)
        std::copy(values.begin(), values.end(), image->comps[c].data);
    opj_codec_t* codec = opj_create_compress(OPJ_CODEC_J2K);
    opj_stream_t* stream = opj_stream_default_create(OPJ_FALSE);
    struct Sink {
        std::string bytes;
        std::size_t at = 0;
    } sink;
    opj_stream_set_user_data(stream, &sink, nullptr);
    opj_stream_set_write_function(stream, [](void* from, OPJ_SIZE_T count, void* user) {
        auto& s = *static_cast<Sink*>(user);
        s.bytes.resize(std::max(s.bytes.size(), s.at + count));
        std::memcpy(s.bytes.data() + s.at, from, count);
        s.at += count;
        return count;
    });
    opj_stream_set_seek_function(stream, [](OPJ_OFF_T to, void* user) -> OPJ_BOOL {
        static_cast<Sink*>(user)->at = static_cast<std::size_t>(to);
        return OPJ_TRUE;
    });
    opj_stream_set_skip_function(stream, [](OPJ_OFF_T by, void* user) -> OPJ_OFF_T {
        static_cast<Sink*>(user)->at += static_cast<std::size_t>(by);
        return by;
    });
    EXPECT_TRUE(opj_setup_encoder(codec, &p, image) && opj_start_compress(codec, image, stream) &&
                opj_encode(codec, stream) && opj_end_compress(codec, stream));
    opj_stream_destroy(stream);
    opj_destroy_codec(codec);
    opj_image_destroy(image);
    return sink.bytes;
}

} // namespace tessera::test
