// bricking/import/labels/nrrd/nrrd_data.h: the data of an NRRD file as one run of numbers, forward only:
// behind the header or in files of their own; plain, gzip or text. Private to the NRRD reader.
#pragma once

#include "bricking/import/labels/nrrd/nrrd_header.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>

namespace tessera {

/// Type of the numbers that NrrdData gives: numbers in text are doubles, little endian.
FileType nrrdDataType(const NrrdHeader& header);
bool isNrrdDataBigEndian(const NrrdHeader& header);

/// Compares the lengths of all data files with the header. Throws InputError naming the file that is missing
/// or shorter than the header says (of gzip: than any compression could make it, of text: than any digits),
/// or of raw data a row or more longer.
void checkNrrdLengths(const NrrdHeader& header, const std::filesystem::path& file);

class NrrdData {
  public:
    /// @param header  must outlive it
    /// @param file  of the header
    NrrdData(const NrrdHeader& header, std::filesystem::path file);
    ~NrrdData();

    /// The next numbers, as the header types and orders their bytes. Throws InputError naming the data file
    /// for damage, for text that is no number, and at its end.
    void read(std::span<std::byte> out);
    void skip(std::uint64_t bytes);
    /// After the last number: throws InputError if the last file has a row or more behind it, and if its
    /// checksum is wrong.
    void finish();

    class Part; // one file
  private:
    void openNext();

    const NrrdHeader& header_;
    std::filesystem::path file_;
    std::uint64_t partBytes_ = 0, leftBytes_ = 0; // of a file's numbers; of those, not read yet
    std::size_t opened_ = 0;
    std::unique_ptr<Part> part_;
};

} // namespace tessera
