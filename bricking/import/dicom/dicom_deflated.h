// bricking/import/dicom/dicom_deflated.h: undoes the deflated transfer syntax, which vtk-dicom does not read.
// The result is "the plain file": explicit little endian with the same data set. Data may inflate a
// thousandfold, so the whole file is never in memory.
#pragma once

#include "bricking/import/source/source_files.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

namespace tessera {

constexpr const char* kDeflatedSyntax = "1.2.840.10008.1.2.1.99";
/// Bytes of the plain file within which pixels must begin.
constexpr std::uint64_t kMostInflatedHeader = std::uint64_t{16} << 20;

/// The plain file under a name that a parser can open, in memory only (headers hold identifiers). Its first
/// 16 MiB and its last 1 MiB are exact, with zeros between.
class InflatedFile {
  public:
    /// Throws InputError naming the file if it is damaged or larger than 512 MiB when inflated.
    explicit InflatedFile(const std::filesystem::path& path);
    ~InflatedFile();
    InflatedFile(const InflatedFile&) = delete;
    InflatedFile& operator=(const InflatedFile&) = delete;
    std::string path() const { return "/proc/self/fd/" + std::to_string(descriptor_); }
    std::uint64_t sizeBytes() const { return sizeBytes_; }

  private:
    int descriptor_;
    std::uint64_t sizeBytes_ = 0;
};

/// Fills out from byte `offset` of the plain file on, skipping bytes before it. Throws InputError naming the
/// file if it ends earlier.
void readInflated(const std::filesystem::path& path, std::uint64_t offset, std::span<std::byte> out);

/// Appends the plain file to a spool, whole. Throws as InflatedFile does.
void spoolInflated(const std::filesystem::path& path, SpoolFile& spool);

} // namespace tessera
