// render/contract/scene_numbers.h: a scene's lights, materials and gradient opacity as plain floats, one text
// for all engines. Packets include it, so it brings no functions.
#pragma once

#include <cstdint>

namespace tessera::leaf {

constexpr int kMostLights = 4, kMostMaterials = 8;

#define LEAF_DEFAULT(value) = value
#include "render/contract/leaf_light_model.h"

enum class LightSort : std::int32_t { head, directional, point };

struct LightNumbers {
    LightSort sort = LightSort::head;
    float place[3] = {};         // directional: towards it, unit, patient space, or 0; point: voxels
    float colour[3] = {1, 1, 1}; // times intensity
    float fading[3] = {1, 0, 0}; // point: constant, linear, quadratic
    std::int32_t channel = -1;   // of voxels' light: its share that gets there; -1: all of it
};

struct LightingNumbers {
    std::int32_t count = 0;
    LightModel model;
    LightNumbers lights[kMostLights];
    std::int32_t channels = 0;          // of light that voxels have
    std::int32_t occlusionChannel = -1; // of them, for ambient light; -1: all of it gets everywhere
    std::int32_t ambientChannels = 1;   // from that one on: one for all colours, or one each
    bool emits = false;                 // a material does
};

/// Light of voxels is kept as texel / kLightOne, from 0 to nearly 4.
constexpr float kLightOne = 16384;
constexpr int kMostLightChannels = 4;

/// One slab of a body that cuts a volume apart from others, in its voxels (docs/sampling.md, "Several
/// volumes"): the space where low <= normal * place <= high. A body is what its slabs have in common.
struct CutSlab {
    float normal[3] = {}, low = 0, high = 0;
    bool endsBody = true;      // else the next slab is of the same body
    bool keepsOutside = false; // of the body; else its inside is kept
};

/// Labels as planes of factors beside the values (docs/sampling.md, "Labels"). A channel that no voxel needs
/// is -1, and its factor 0. They are kept as light is, by kLightOne.
struct LabelNumbers {
    std::int32_t count = 0;   // of channels; 0: the scene has no labels
    std::int32_t plain = -1;  // share of the function as it is
    std::int32_t tinted = -1; // share of the function's extinction, in the labels' colour
    std::int32_t solid = -1;  // share of the labels' own medium
    std::int32_t dense = -1;  // that share times the medium's relative extinction; -1: it is 1
    std::int32_t colour = -1; // the first of three: the labels' colour times (tinted + solid)
    float density = 0;        // extinction per mm of the densest medium
    bool nearest = false;     // a place has the factors of the sample that holds it
};
constexpr int kMostLabelChannels = 7;

/// Voxels by which ways of light go beyond a box of bounds: more than rounding of places
/// (render/transport/tracking.h).
constexpr float kWayOverlap = 1.0f / 512;
/// Light on a way that is less goes on by chance; behind such a depth, e^-24, none does.
constexpr float kLittleLight = 0.25f, kDarkDepth = 24.0f;

/// Of stored values from one up to, not with, another, by their places in the table (placeOf()).
struct MaterialNumbers {
    float from = 0, to = 0;
    float ambient = 0, diffuse = 0, specular = 0;
    std::int32_t power = 1;
    float emission[3] = {};
};

constexpr int kMostGradientPoints = 16;

/// Points of the factor, by the length of the gradient in patient space, stored units per mm. From a point on
/// the factor goes on by its slope, until the next one; before the first it is the first one's.
template <typename N> struct GradientNumbers {
    std::int32_t count = 0; // 0: there is none
    N length[kMostGradientPoints] = {}, factor[kMostGradientPoints] = {}, slope[kMostGradientPoints] = {};
};

} // namespace tessera::leaf
