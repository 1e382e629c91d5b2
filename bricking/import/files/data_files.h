// bricking/import/files/data_files.h: data that a header describes, as one run of numbers, forward only:
// behind the header or in files of their own; plain, packed by gzip or zlib, or text. For NRRD, MetaImage
// and Volume Graphics.
#pragma once

#include "bricking/import/files/file_reading.h"
#include "bricking/import/source/slice_converter.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace tessera {

enum class DataEncoding : std::uint8_t { raw, gzip, text }; // gzip: zlib too

/// What a header says of its data.
struct DataFiles {
    std::vector<std::int64_t> sizes; // of the axes, the fastest first; each at least 1, 2^58 values at most
    FileType type = FileType::u8;
    bool bigEndian = false;
    DataEncoding encoding = DataEncoding::raw;
    std::int64_t lineSkip = 0, byteSkip = 0; // before the data of each file; byteSkip -1: they are its end
    /// Of a detached header, each with as many numbers. Empty: the data follow the header.
    std::vector<std::filesystem::path> dataFiles;
    std::uint64_t bytes = 0; // of the header
};

/// The data files that a detached header names: one; NAME%03d MIN MAX STEP; or LIST, with their names a line
/// each. Behind STEP and LIST: of how many axes each file has a part. Throws InputError naming the header for
/// other words, and for other than as many files as there are parts, at most one a row.
/// @param field  "data file", for messages
std::vector<std::filesystem::path> namedDataFiles(const std::string& field, const std::string& value,
                                                  const std::vector<std::string>& listed,
                                                  const std::vector<std::int64_t>& sizes,
                                                  const std::filesystem::path& header);

/// Type of the numbers that DataReader gives: numbers in text are doubles, little endian.
FileType dataType(const DataFiles& files);
bool isDataBigEndian(const DataFiles& files);

/// Compares the lengths of all data files with the header. Throws InputError naming the file that is missing
/// or shorter than the header says (of packed data: than any compression could make it, of text: than any
/// digits), or of raw data a row or more longer.
/// @param header  the header's file
void checkDataLengths(const DataFiles& files, const std::filesystem::path& header);

/// Of the first number in a file of raw data.
std::uint64_t dataOffset(const DataFiles& files, const InputFile& file);
/// The voxels of a volume whose data they are: by position where they are raw in one file, else forward.
/// @param header  the header's file
/// @param info  of sizes as the data have them
std::unique_ptr<SlabSource> openDataFiles(const DataFiles& files, const std::filesystem::path& header,
                                          const VolumeInfo& info, std::string description);

class DataReader final : public VoxelStream {
  public:
    /// @param file  of the header
    DataReader(DataFiles header, std::filesystem::path file);
    ~DataReader() override;

    /// The next numbers, of dataType(). Throws InputError naming the data file
    /// for damage, for text that is no number, and at its end.
    void read(std::span<std::byte> out) override;
    void skip(std::uint64_t bytes);
    /// After the last number: throws InputError if the last file has a row or more behind it, and if its
    /// checksum is wrong.
    void finish() override;

    class Part; // one file
  private:
    void openNext();

    DataFiles header_;
    std::filesystem::path file_;
    std::uint64_t partBytes_ = 0, leftBytes_ = 0; // of a file's numbers; of those, not read yet
    std::size_t opened_ = 0;
    std::unique_ptr<Part> part_;
};

} // namespace tessera
