// bricking/export/volume_file.h: a file that is written from its beginning to its end, in part deflated.
#pragma once

#include "core/base/output_file.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string_view>

namespace tessera {

/// Appends to an OutputFile.
class VolumeFile {
  public:
    explicit VolumeFile(const std::filesystem::path& path, Existing existing = Existing::isReplaced)
        : file_(path, existing) {}
    void append(std::span<const std::byte> bytes) {
        file_.writeAt(size_, bytes);
        size_ += bytes.size();
    }
    void append(std::string_view text) { append(std::as_bytes(std::span(text))); }
    /// Replaces bytes that were written.
    void replace(std::uint64_t offset, std::span<const std::byte> bytes) { file_.writeAt(offset, bytes); }
    std::uint64_t size() const { return size_; }
    const std::filesystem::path& path() const { return file_.path(); }
    void finish() { file_.finish(); }

  private:
    OutputFile file_;
    std::uint64_t size_ = 0;
};

/// Deflates what it gets and appends that to a file. Memory: half a megabyte.
class DeflateStream {
  public:
    enum class Wrapper { gzip, zlib };
    DeflateStream(VolumeFile& file, Wrapper wrapper);
    ~DeflateStream();
    DeflateStream(const DeflateStream&) = delete;
    DeflateStream& operator=(const DeflateStream&) = delete;

    void append(std::span<const std::byte> bytes);
    /// Ends the stream: its checksum is written.
    void finish();

  private:
    void deflateAll(int flush);
    struct State;
    std::unique_ptr<State> state_;
};

/// Bytes of any number, little-endian.
template <class T> std::span<const std::byte> bytesOf(const T& value) {
    return std::as_bytes(std::span(&value, 1));
}

} // namespace tessera
