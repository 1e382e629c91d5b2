// bricking/import/files/gzip_stream.h: one forward pass over a gzip file, with bounded memory; every damage
// is reported.
#pragma once

#include "bricking/import/source/input_file.h"

#include <cstddef>
#include <memory>
#include <span>

namespace tessera {

class GzipStream {
  public:
    explicit GzipStream(InputFile file);
    ~GzipStream();
    GzipStream(GzipStream&&) noexcept;

    const InputFile& file() const;
    /// Fills out with the next decompressed bytes. Throws InputError naming the file if it is damaged (bad
    /// block, wrong checksum) or ends before.
    void read(std::span<std::byte> out);
    /// Skips to the end of the current member, so that its checksum is compared; returns the number of bytes
    /// skipped. Throws InputError as read() does.
    std::uint64_t finish();

  private:
    bool inflateStep(std::span<std::byte> out, std::size_t& done);
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace tessera
