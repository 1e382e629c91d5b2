// bricking/import/codecs/jpeg2000.cpp: decodeJpeg2000 of stream.h, by OpenJPEG in its strict mode.
#include "bricking/import/codecs/stream.h"
#include "core/base/error.h"

#include <algorithm>
#include <cstring>
#include <memory>
#include <openjpeg.h>

namespace tessera {
namespace {

/// The stream as the library reads it.
struct Cursor {
    Bytes bytes;
    std::size_t at = 0;
};
constexpr auto kNoMore = static_cast<OPJ_SIZE_T>(-1);

OPJ_SIZE_T readSome(void* to, OPJ_SIZE_T count, void* user) {
    auto& cursor = *static_cast<Cursor*>(user);
    const std::size_t got = std::min(count, cursor.bytes.size() - cursor.at);
    if (got == 0)
        return kNoMore;
    std::memcpy(to, cursor.bytes.data() + cursor.at, got);
    cursor.at += got;
    return got;
}
OPJ_OFF_T skipSome(OPJ_OFF_T count, void* user) {
    auto& cursor = *static_cast<Cursor*>(user);
    const auto left = static_cast<OPJ_OFF_T>(cursor.bytes.size() - cursor.at);
    if (count < 0 || count > left)
        return -1;
    cursor.at += static_cast<std::size_t>(count);
    return count;
}
OPJ_BOOL seekTo(OPJ_OFF_T place, void* user) {
    auto& cursor = *static_cast<Cursor*>(user);
    if (place < 0 || static_cast<std::size_t>(place) > cursor.bytes.size())
        return OPJ_FALSE;
    cursor.at = static_cast<std::size_t>(place);
    return OPJ_TRUE;
}

/// Other output of the library, which is not printed.
void complain(const char*, void* user) {
    *static_cast<bool*>(user) = true;
}
void sayNothing(const char*, void*) {}

// The library's codec and stream are the same type to C++, so each has a deleter of its own.
struct DestroyCodec {
    void operator()(opj_codec_t* codec) const { opj_destroy_codec(codec); }
};
struct DestroyStream {
    void operator()(opj_stream_t* stream) const { opj_stream_destroy(stream); }
};
struct DestroyImage {
    void operator()(opj_image_t* image) const { opj_image_destroy(image); }
};

} // namespace

void decodeJpeg2000(Bytes bytes, const StreamHeader& header, const std::string& where,
                    std::span<std::int32_t> out) {
    Cursor cursor{bytes};
    bool complained = false;
    const std::unique_ptr<opj_codec_t, DestroyCodec> codec(opj_create_decompress(OPJ_CODEC_J2K));
    const std::unique_ptr<opj_stream_t, DestroyStream> stream(opj_stream_default_create(OPJ_TRUE));
    if (!codec || !stream)
        throw Error("no memory for a JPEG 2000 decoder");
    opj_set_info_handler(codec.get(), sayNothing, nullptr);
    opj_set_warning_handler(codec.get(), complain, &complained);
    opj_set_error_handler(codec.get(), complain, &complained);
    opj_stream_set_read_function(stream.get(), readSome);
    opj_stream_set_skip_function(stream.get(), skipSome);
    opj_stream_set_seek_function(stream.get(), seekTo);
    opj_stream_set_user_data(stream.get(), &cursor, nullptr);
    opj_stream_set_user_data_length(stream.get(), bytes.size());

    opj_dparameters_t parameters;
    opj_set_default_decoder_parameters(&parameters);
    opj_image_t* read = nullptr;
    bool good = opj_setup_decoder(codec.get(), &parameters) &&
                opj_decoder_set_strict_mode(codec.get(), OPJ_TRUE) &&
                opj_read_header(stream.get(), codec.get(), &read);
    const std::unique_ptr<opj_image_t, DestroyImage> image(read);
    good = good && opj_decode(codec.get(), stream.get(), image.get()) &&
           opj_end_decompress(codec.get(), stream.get());
    if (!good || complained || image->numcomps != 1 || !image->comps[0].data)
        throw badFile(where, "compressed pixels that decode without a fault", "damaged JPEG 2000 data");
    const opj_image_comp_t& samples = image->comps[0];
    if (static_cast<int>(samples.w) != header.columns || static_cast<int>(samples.h) != header.rows ||
        static_cast<int>(samples.prec) != header.bits || (samples.sgnd != 0) != header.isSigned)
        throw badFile(where, "one JPEG 2000 header", "two that differ");
    std::copy_n(samples.data, out.size(), out.begin());
}

} // namespace tessera
