// bricking/import/dicom/encapsulated_frames.h: the positions of compressed frames in a DICOM file (PS3.5,
// A.4). Frames are items of a sequence: the first is a table of offsets, the others are fragments of frames.
#pragma once

#include "bricking/import/source/source_files.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace tessera {

struct Fragment {
    std::uint64_t offsetBytes = 0; // of its content, in the file
    std::uint32_t lengthBytes = 0;
};

/// The fragments of each frame. offsetBytes: of the first item, after the pixel element's own header.
/// A single frame takes all fragments; several need a table of offsets or one fragment each. Throws
/// InputError naming the file if items are not contiguous up to the sequence's end, if one ends beyond the
/// file, and if fragments cannot be assigned to frames.
std::vector<std::vector<Fragment>> framesOf(const InputFile& file, std::uint64_t offsetBytes, int frames);

/// The assembled stream of a frame.
/// @pre its fragments are within the file, as checked by framesOf()
std::vector<std::byte> readFrame(const InputFile& file, const std::vector<Fragment>& fragments);

} // namespace tessera
