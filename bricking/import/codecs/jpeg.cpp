// bricking/import/codecs/jpeg.cpp: decodeJpeg of stream.h, by DCMTK, whose three builds of the IJG library
// take samples of 8, 12 and 16 bits.
#include "bricking/import/codecs/stream.h"
#include "core/base/error.h"

// DCMTK's configuration must come before its other headers.
#include <dcmtk/config/osconfig.h>
#include <dcmtk/dcmjpeg/djcparam.h>
#include <dcmtk/dcmjpeg/djdijg12.h>
#include <dcmtk/dcmjpeg/djdijg16.h>
#include <dcmtk/dcmjpeg/djdijg8.h>

namespace tessera {
namespace {

/// A decoder that remembers warnings instead of logging them: "premature end", "bad Huffman code",
/// "extraneous bytes". The library continues after them with invented samples.
template <class Decoder> class StrictDecoder final : public Decoder {
  public:
    using Decoder::Decoder;
    void emitMessage(int level) const override { warned_ = warned_ || level < 0; }
    bool warned() const { return warned_; }

  private:
    mutable bool warned_ = false;
};

template <class Decoder, class Sample>
void decode(Bytes stream, const std::string& where, std::span<std::int32_t> out) {
    const DJCodecParameter parameter(ECC_monochrome, EDC_never, EUC_never, EPC_default);
    StrictDecoder<Decoder> decoder(parameter, OFFalse);
    std::vector<Sample> samples(out.size());
    OFCondition result = decoder.init();
    if (result.good()) // the library reads only, though its pointer is not to const
        result = decoder.decode(reinterpret_cast<Uint8*>(const_cast<std::byte*>(stream.data())),
                                static_cast<Uint32>(stream.size()), reinterpret_cast<Uint8*>(samples.data()),
                                static_cast<Uint32>(samples.size() * sizeof(Sample)), OFFalse);
    if (result.bad() || decoder.warned())
        throw badFile(where, "compressed pixels that decode without a fault",
                      decoder.warned() ? "damaged JPEG data" : "damaged JPEG data that breaks off");
    for (std::size_t i = 0; i < out.size(); ++i)
        out[i] = static_cast<std::int32_t>(samples[i]);
}

} // namespace

void decodeJpeg(Bytes stream, const StreamHeader& header, const std::string& where,
                std::span<std::int32_t> out) {
    if (stream.size() > UINT32_MAX || out.size() > UINT32_MAX / 2)
        throw badFile(where, "a compressed image below 4 GiB", std::to_string(stream.size()) + " bytes");
    if (header.bits <= 8)
        return decode<DJDecompressIJG8Bit, Uint8>(stream, where, out);
    if (header.frameMarker == 0xC3)
        return decode<DJDecompressIJG16Bit, Uint16>(stream, where, out);
    return decode<DJDecompressIJG12Bit, Uint16>(stream, where, out);
}

} // namespace tessera
