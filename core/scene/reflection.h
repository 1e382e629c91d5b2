// core/scene/reflection.h: isosurfaces that mirror what is around them, or let rays through bent
// (docs/sampling.md, "Reflections of isosurfaces").
#pragma once

#include "core/base/names.h"
#include "core/scene/transport.h"

namespace tessera {

/// The share of light that a surface mirrors: the same everywhere; by the angle, as a smooth dielectric;
/// by the length of the field's gradient.
enum class ReflectionKind { constant, fresnel, gradient };
struct Reflection {
    static constexpr double kMostIor = 3;
    ReflectionKind kind = ReflectionKind::constant;
    double strength = 1;       // factor on the share, [0,1]
    GradientWeight gradient{}; // of kind gradient: none at low, all from high on
    double ior = 1.5;          // index of refraction behind the surface, [1,kMostIor]
    bool transmits = false;    // light that is not mirrored goes through, refracted
    bool operator==(const Reflection&) const = default;
};
template <> const NameTable<ReflectionKind>& namesOf<ReflectionKind>();

} // namespace tessera
