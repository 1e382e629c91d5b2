// bricking/import/dicom/dicom_bare.h: recognizes DICOM data sets without the preamble of 128 bytes and the
// mark "DICM", as from old archives and network dumps.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace tessera {

/// True if the first bytes of a file of that size are a data set in little endian, explicit or implicit.
/// Elements begin in group 0002 or 0008, ascend, and have lengths that fit.
bool looksLikeBareDicom(std::span<const std::byte> head, std::uint64_t fileBytes);

} // namespace tessera
