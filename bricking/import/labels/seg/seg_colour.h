// bricking/import/labels/seg/seg_colour.h: DICOM's CIE L*a*b* as linear light. Private to the reader of
// segmentations.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>

namespace tessera {

/// RecommendedDisplayCIELabValue (PS3.3, C.10.7.1.1: L* from 0 to 100, a* and b* from -128 to 127, each as 0
/// to 65535, white point D50), as linear Rec. 709, clamped to [0,1].
glm::vec3 linearFromDicomLab(std::uint32_t l, std::uint32_t a, std::uint32_t b);

} // namespace tessera
