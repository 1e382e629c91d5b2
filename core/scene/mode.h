// core/scene/mode.h: the modes of a picture: compositing, one value, the mean or a sum along a ray, the
// isosurfaces alone, or the values of a plane. The window turns one value into grey (docs/sampling.md,
// "Modes"). The appearance of one value in modes that show single values, exactly and as the table of floats
// that engines read (docs/sampling.md, "Modes").
#pragma once

#include "core/base/names.h"
#include "core/scene/preset.h" // ValueSummary
#include "core/scene/transfer_function.h"

#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace tessera {

enum class Mode { composite, maximum, minimum, average, isosurface, slice, emission, absorption, radiograph };

/// The reduction of what lies along a ray: compositing, one value, or a sum (core/scene/exposure.h).
enum class Reduction { composite, maximum, minimum, average, sum };

/// DICOM's linear window (PS3.3 C.11.2.1.3.2, LINEAR_EXACT): grey rises from 0 at centre - width/2 to 1 at
/// centre + width/2, in physical units.
struct GreyWindow {
    double centre = 0, width = 1; // width above 0
    double low() const { return centre - width / 2; }
    double high() const { return centre + width / 2; }
    bool operator==(const GreyWindow&) const = default;
};
/// By name, or as numbers. "auto" is chosen by windowOf().
using WindowChoice = std::variant<std::string, GreyWindow>;

/// The colour of a single value: a grey of the window, the transfer function's colour, or a grey from white
/// to black, as in nuclear medicine.
enum class ValueColour { window, transferFunction, inverse };

enum class Orientation { axial, coronal, sagittal, oblique };

/// A plane in patient space (LPS, mm), or a slab around it.
struct SlicePlane {
    Orientation orientation = Orientation::axial;
    /// Position along the plane's axis: z of axial, y of coronal, x of sagittal planes. None: the volume's
    /// middle.
    std::optional<double> positionMm = {};
    glm::dvec3 point{0}, normal{0, 0, 1};     // oblique; any length but 0
    double thicknessMm = 0;                   // 0: the plane alone, one sample a ray
    Reduction reduction = Reduction::average; // of a slab; one value
    bool operator==(const SlicePlane&) const = default;
};

/// The plane of a slice and its view, from the side of its normal. By radiology's convention axial slices are
/// seen from the feet and coronal ones from the front, both with the patient's right at the picture's left.
/// Sagittal ones are seen from the patient's left, with the front at the picture's left. Up is superior, or
/// anterior where the normal is nearer to that than 1 degree.
struct SlicePose {
    glm::dvec3 point{0}, normal{0, 0, 1};   // mm; unit
    glm::dvec3 right{1, 0, 0}, up{0, 1, 0}; // of the picture, unit
};
/// @param middle  of the volume, mm
SlicePose poseOf(const SlicePlane& slice, const glm::dvec3& middle);

/// The window of a choice on such values. "auto" of values in HU, or that look like HU, is abdomen, in mode
/// maximum one that shows vessels and bone. Of other values it has all but fill values; the highest
/// thousandth is left out if it spans more than half of their range (a bladder in a PET). Throws InputError
/// for an unknown name.
GreyWindow windowOf(const WindowChoice& choice, const ValueSummary& values, Mode mode);

template <> const NameTable<Mode>& namesOf<Mode>();
template <> const NameTable<Reduction>& namesOf<Reduction>(); // of a slab: one value
template <> const NameTable<Orientation>& namesOf<Orientation>();
template <> const NameTable<ValueColour>& namesOf<ValueColour>();
inline const std::vector<std::string>& modeNames() {
    return namesOf<Mode>().all();
}
inline const std::vector<std::string>& reductionNames() {
    return namesOf<Reduction>().all();
}
inline const std::vector<std::string>& orientationNames() {
    return namesOf<Orientation>().all();
}
inline const std::vector<std::string>& valueColourNames() {
    return namesOf<ValueColour>().all();
}
/// "auto" and those of CT; all in HU. The numbers are customary ones (Radiopaedia, "Windowing (CT)").
const std::vector<std::string>& windowNames();

/// These throw InputError naming where.
/// A name, or "CENTRE,WIDTH".
WindowChoice parseWindow(const std::string& text, const std::string& where);
/// Checks that centre and width are finite, width above 0, and both ends within the range of a voxel.
GreyWindow checkedWindow(double centre, double width, const std::string& where);
/// Checks that the thickness is at least 0, the normal not 0, and numbers within bounds
/// (core/base/magnitude.h).
void checkSlice(const SlicePlane& slice, const std::string& where);

struct ValueLook {
    ValueColour colour = ValueColour::window;
    GreyWindow window;
};

/// Linear light: the window's grey, rising or falling, is a display value (sRGB), as in radiology viewers.
/// @param value  physical units
glm::dvec3 colourOfValue(const ValueLook& look, const TransferFunction& function, double value);

/// Colours by value. An entry's extinction says only whether values there can change what a ray of this
/// reduction shows, so that bricks are culled by it. The lowest entry cannot change a maximum, nor the
/// highest a minimum.
/// @param reduction  one value
TransferTable valueTable(const ValueLook& look, const TransferFunction& function, Reduction reduction);

} // namespace tessera
