// bricking/import/dicom_pixels.cpp: see dicom_pixels.h.
#include "bricking/import/dicom_pixels.h"

#include "bricking/import/dicom_deflated.h"
#include "bricking/import/input_file.h"
#include "bricking/import/vtk_quiet.h"
#include "core/error.h"

#include <cstring>
#include <vtkDICOMReader.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPointData.h>

namespace tessera {
namespace {

/// The bits that belong to the pixel (others may carry overlays), as a number.
std::int32_t storedValue(std::uint32_t word, const DicomSlice& slice) {
    const std::uint32_t mask = (1u << slice.bitsStored) - 1u;
    const std::uint32_t bits = (word >> (slice.highBit + 1 - slice.bitsStored)) & mask;
    const std::uint32_t sign = 1u << (slice.bitsStored - 1);
    const auto value = static_cast<std::int32_t>(bits);
    return slice.isSigned && (bits & sign) ? value - static_cast<std::int32_t>(mask) - 1 : value;
}

/// word(i) gives the i-th cell of the image as an unsigned number.
template <class Word> void unpack(const DicomSlice& slice, std::span<std::int32_t> out, Word word) {
    for (std::size_t i = 0; i < out.size(); ++i)
        out[i] = storedValue(word(i), slice);
}

void decode(const DicomSlice& slice, std::span<std::int32_t> out) {
    const QuietVtk quiet(true);
    vtkNew<vtkDICOMReader> reader;
    reader->SetFileName(slice.file.c_str());
    reader->AutoRescaleOff();
    reader->SortingOff();
    reader->SetMemoryRowOrderToFileNative();
    reader->Update();
    const std::string shape = std::to_string(slice.columns) + " x " + std::to_string(slice.rows);
    vtkImageData* image = reader->GetOutput();
    const int* size = image->GetDimensions();
    if (reader->GetErrorCode() != 0 || quiet.sawError() || !image->GetPointData()->GetScalars())
        throw badFile(slice.file.string(), "compressed pixels of " + shape, "data that cannot be decoded");
    const int valueBytes = image->GetScalarSize();
    if (size[0] != slice.columns || size[1] != slice.rows || size[2] != 1 ||
        image->GetNumberOfScalarComponents() != 1 || valueBytes != slice.bitsAllocated / 8)
        throw badFile(slice.file.string(), "compressed pixels of " + shape,
                      "an image of another shape or type");
    const void* pixels = image->GetScalarPointer();
    if (valueBytes == 1)
        unpack(slice, out, [p = static_cast<const std::uint8_t*>(pixels)](std::size_t i) { return p[i]; });
    else // the reader has masked and sign-extended already; doing so again changes nothing
        unpack(slice, out, [p = static_cast<const std::uint16_t*>(pixels)](std::size_t i) { return p[i]; });
}

} // namespace

void DicomPixels::read(const DicomSlice& slice, std::span<std::int32_t> out) {
    TESSERA_CHECK(out.size() ==
                  static_cast<std::size_t>(slice.columns) * static_cast<std::size_t>(slice.rows));
    if (slice.coding == PixelCoding::compressed)
        return decode(slice, out);
    const auto valueBytes = static_cast<std::size_t>(slice.bitsAllocated / 8);
    buffer_.resize(out.size() * valueBytes);
    if (slice.coding == PixelCoding::deflated) {
        const std::vector<std::byte> whole = inflateDicom(slice.file);
        if (whole.size() < slice.pixelOffsetBytes + buffer_.size())
            throw badFile(slice.file.string(), "the pixels that it had when it was opened", "fewer");
        std::memcpy(buffer_.data(), whole.data() + slice.pixelOffsetBytes, buffer_.size());
    } else {
        InputFile(slice.file).readAt(slice.pixelOffsetBytes, buffer_);
    }
    const auto byte = [this](std::size_t i) { return std::to_integer<std::uint32_t>(buffer_[i]); };
    if (valueBytes == 1) {
        unpack(slice, out, byte);
    } else if (slice.coding == PixelCoding::bigEndian) {
        unpack(slice, out, [&](std::size_t i) { return byte(2 * i) << 8 | byte(2 * i + 1); });
    } else {
        unpack(slice, out, [&](std::size_t i) { return byte(2 * i + 1) << 8 | byte(2 * i); });
    }
}

} // namespace tessera
