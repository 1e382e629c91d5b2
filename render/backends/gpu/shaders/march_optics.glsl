// march_optics.glsl: the colour and opacity of a value and the contribution of a segment; as render/contract/optics.h
// has them in float.
// Needs FEATURE_SHADING, FEATURE_HITS, FEATURE_GRADIENT_OPACITY, FEATURE_FUSED, common_ray.glsl. Gives tablePlace(stored),
// extinctionAt(place), colourAt(place), opacityOf(depth), shade(...).

#include "leaf_field.h"
#include "leaf_light_model.h"
#include "leaf_light.h"
#include "leaf_opacity.h"
#include "leaf_table.h"

// Buffer textures, for llvmpipe reads storage buffers lane by lane (render/backends/gpu/bindings.h).
#if FEATURE_FUSED
OF_VOLUME samplerBuffer uTable; // colours; a: extinctions per mm
#define uColours uTable
#define EXTINCTION(i) texelFetch(uTable, i).a
#else
OF_VOLUME samplerBuffer uColours;
OF_VOLUME samplerBuffer uExtinctions; // per mm
#define EXTINCTION(i) texelFetch(uExtinctions, i).x
#endif
OF_VOLUME float uTableScale; // entry = stored value * scale + offset
OF_VOLUME float uTableOffset;
OF_VOLUME int uTableLast;

float tablePlace(float stored) {
    precise float place = stored * uTableScale + uTableOffset;
    return heldPlace(place, float(uTableLast));
}

int tableCell(float place) { return min(int(place), uTableLast - 1); }

// Most values have no extinction: their colour is never read.
float extinctionAt(float place) {
    int i = tableCell(place);
    float a = EXTINCTION(i);
    precise float part = place - float(i);
    return partWay(a, EXTINCTION(i + 1), part);
}

vec3 colourAt(float place) {
    int i = tableCell(place);
    vec3 a = texelFetch(uColours, i).rgb;
    precise float part = place - float(i);
    return partWay(a, texelFetch(uColours, i + 1).rgb, part);
}

// 1 - exp(-depth), accurate also where depth is tiny.
float opacityOf(float depth) {
    return depth < kOneMinusExpBelow ? oneMinusExpBelow(depth) : oneMinusExpAbove(depth);
}

#if FEATURE_SHADING || FEATURE_HITS || FEATURE_GRADIENT_OPACITY
OF_VOLUME mat3 uVoxelFromPatientTransposed; // linear part: patient gradient = this * voxel gradient
#endif
#if FEATURE_SHADING
#if FEATURE_FUSED
OF_VOLUME mat3 uPatientFromVolume; // linear part, mm per voxel
#else
#define uPatientFromVolume uPatientFromVoxel // rays count in its voxels
#endif
uniform vec3 uPhong;                      // ambient, diffuse, specular
uniform int uSpecularPower;               // whole, 1 or more

// gradient: voxel space, any scale; direction: the ray's, unit in voxel space. The head light lies on the ray.
vec3 shade(vec3 colour, vec3 gradient, vec3 direction) {
    vec3 g = transformed(uVoxelFromPatientTransposed, gradient);
    vec3 d = transformed(uPatientFromVolume, direction);
    if (!isHeadLit(g, d, kMaxFloat)) return colour; // no direction to light from, or beyond float
    HeadLight light = headLight(g, d, uPhong.x, uPhong.y, uPhong.z, uSpecularPower);
    precise vec3 lit = colour * light.scale + light.add;
    return lit;
}
#endif
