// bricking/import/codecs/jpegls.cpp: decodeJpegLs of stream.h, by CharLS, which stops at the first fault.
#include "bricking/import/codecs/stream.h"
#include "core/base/error.h"

#include <charls/charls.h>

namespace tessera {
namespace {

template <class Sample> void decode(charls::jpegls_decoder& decoder, std::span<std::int32_t> out) {
    std::vector<Sample> samples(out.size());
    decoder.decode(samples.data(), samples.size() * sizeof(Sample));
    for (std::size_t i = 0; i < out.size(); ++i)
        out[i] = static_cast<std::int32_t>(samples[i]);
}

} // namespace

void decodeJpegLs(Bytes stream, const StreamHeader& header, const std::string& where,
                  std::span<std::int32_t> out) {
    try {
        charls::jpegls_decoder decoder(stream.data(), stream.size(), true);
        const charls::frame_info& frame = decoder.frame_info();
        // The marker check and the library read the same header: a difference means that one of them was
        // misled.
        if (static_cast<int>(frame.width) != header.columns ||
            static_cast<int>(frame.height) != header.rows || frame.component_count != 1 ||
            frame.bits_per_sample != header.bits ||
            decoder.destination_size() != out.size() * (header.bits > 8 ? 2 : 1))
            throw badFile(where, "one JPEG-LS frame header", "two that differ");
        if (header.bits > 8)
            decode<std::uint16_t>(decoder, out);
        else
            decode<std::uint8_t>(decoder, out);
    } catch (const charls::jpegls_error&) {
        throw badFile(where, "compressed pixels that decode without a fault", "damaged JPEG-LS data");
    }
}

} // namespace tessera
