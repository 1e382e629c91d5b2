// bricking/export/volume_file.cpp: see volume_file.h.
#include "bricking/export/volume_file.h"

#include "core/base/error.h"

#include <algorithm>
#include <limits>
#include <vector>
#include <zlib.h>

namespace tessera {

struct DeflateStream::State {
    explicit State(VolumeFile& to) : file(to) {}
    VolumeFile& file;
    z_stream stream{};
    std::vector<std::byte> out = std::vector<std::byte>(std::size_t{256} * 1024);
};

DeflateStream::DeflateStream(VolumeFile& file, Wrapper wrapper) : state_(std::make_unique<State>(file)) {
    constexpr int kLevel = 6, kWindow = 15, kGzip = 16, kMemory = 8;
    if (deflateInit2(&state_->stream, kLevel, Z_DEFLATED, kWindow + (wrapper == Wrapper::gzip ? kGzip : 0),
                     kMemory, Z_DEFAULT_STRATEGY) != Z_OK)
        throw Error("zlib: no memory for deflating");
}

DeflateStream::~DeflateStream() {
    deflateEnd(&state_->stream);
}

void DeflateStream::deflateAll(int flush) {
    z_stream& z = state_->stream;
    std::vector<std::byte>& out = state_->out;
    int result = Z_OK;
    do {
        z.next_out = reinterpret_cast<Bytef*>(out.data());
        z.avail_out = static_cast<uInt>(out.size());
        result = deflate(&z, flush);
        TESSERA_CHECK(result != Z_STREAM_ERROR);
        state_->file.append(std::span(out).first(out.size() - z.avail_out));
    } while (z.avail_out == 0 || (flush == Z_FINISH && result != Z_STREAM_END));
}

void DeflateStream::append(std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
        const std::size_t now = std::min<std::size_t>(bytes.size(), std::numeric_limits<int>::max());
        state_->stream.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(bytes.data()));
        state_->stream.avail_in = static_cast<uInt>(now);
        deflateAll(Z_NO_FLUSH);
        bytes = bytes.subspan(now);
    }
}

void DeflateStream::finish() {
    state_->stream.next_in = nullptr;
    state_->stream.avail_in = 0;
    deflateAll(Z_FINISH);
}

} // namespace tessera
