// march_optics.glsl: what a value looks like and what a segment adds; twin of render/contract/optics.h. Powers and
// exponentials are written out in additions and multiplications, because drivers' own differ by many ulp.
// Needs FEATURE_SHADING, FEATURE_HITS, FEATURE_GRADIENT_OPACITY, common_ray.glsl. Gives tablePlace(stored), extinctionAt(place), colourAt(place),
// opacityOf(depth), shade(...).

// Buffer textures, for llvmpipe reads storage buffers lane by lane; twin of render/backends/gpu/function_tables.cpp.
uniform samplerBuffer uColours;
uniform samplerBuffer uExtinctions; // per mm
uniform float uTableScale, uTableOffset; // entry = stored value * scale + offset
uniform int uTableLast;

float tablePlace(float stored) {
    precise float place = stored * uTableScale + uTableOffset;
    return place > 0.0 ? min(place, float(uTableLast)) : 0.0; // clamp() may keep what is not a number
}

int tableCell(float place) { return min(int(place), uTableLast - 1); }

// Most values have no extinction: their colour is never read.
float extinctionAt(float place) {
    int i = tableCell(place);
    float a = texelFetch(uExtinctions, i).x;
    precise float extinction = a + (place - float(i)) * (texelFetch(uExtinctions, i + 1).x - a);
    return extinction;
}

vec3 colourAt(float place) {
    int i = tableCell(place);
    vec3 a = texelFetch(uColours, i).rgb;
    precise vec3 colour = a + (place - float(i)) * (texelFetch(uColours, i + 1).rgb - a);
    return colour;
}

// 1 - exp(-depth), accurate also where depth is tiny.
float opacityOf(float depth) {
    precise float x = depth;
    if (x < 0.25) {
        precise float small = x * (1.0 - x * (1.0 / 2.0) * (1.0 - x * (1.0 / 3.0) * (1.0 - x * (1.0 / 4.0) *
                              (1.0 - x * (1.0 / 5.0) * (1.0 - x * (1.0 / 6.0))))));
        return small;
    }
    precise float y = max(x * -1.44269504, -126.0); // -depth / ln 2
    precise float n = floor(y);
    precise float r = (y - n) * 0.693147181;        // 2^(y-n) = e^r, r in [0, ln 2): Taylor to r^8/8!
    precise float p = 1.0 + r * (1.0 + r * (1.0 / 2.0) * (1.0 + r * (1.0 / 3.0) * (1.0 + r * (1.0 / 4.0) *
                      (1.0 + r * (1.0 / 5.0) * (1.0 + r * (1.0 / 6.0) * (1.0 + r * (1.0 / 7.0) *
                      (1.0 + r * (1.0 / 8.0))))))));
    precise float alpha = 1.0 - p * uintBitsToFloat(uint(int(n) + 127) << 23);
    return alpha;
}

#if FEATURE_SHADING || FEATURE_HITS || FEATURE_GRADIENT_OPACITY
uniform mat3 uVoxelFromPatientTransposed; // linear part: patient gradient = this * voxel gradient
#endif
#if FEATURE_SHADING
uniform vec3 uPhong;                      // ambient, diffuse, specular
uniform int uSpecularPower;               // whole, 1 or more

float wholePower(float x, int n) {
    precise float result = 1.0;
    precise float square = x;
    for (; n > 0; n >>= 1) {
        if ((n & 1) != 0) result = result * square;
        square = square * square;
    }
    return result;
}

// gradient: voxel space, any scale; direction: the ray's, unit in voxel space. The head light lies on the ray.
vec3 shade(vec3 colour, vec3 gradient, vec3 direction) {
    precise vec3 g = uVoxelFromPatientTransposed[0] * gradient.x + uVoxelFromPatientTransposed[1] * gradient.y +
                     uVoxelFromPatientTransposed[2] * gradient.z;
    precise vec3 d = uPatientFromVoxel[0] * direction.x + uPatientFromVoxel[1] * direction.y +
                     uPatientFromVoxel[2] * direction.z;
    precise float lengths = (g.x * g.x + g.y * g.y + g.z * g.z) * (d.x * d.x + d.y * d.y + d.z * d.z);
    if (!(lengths > 0.0 && lengths <= kMaxFloat)) return colour; // no direction to light from, or beyond float
    precise float cosine = min(1.0, abs(g.x * d.x + g.y * d.y + g.z * d.z) / sqrt(lengths));
    precise float mirrored = max(0.0, 2.0 * cosine * cosine - 1.0); // r.v with light, viewer on one line
    precise vec3 lit = colour * (uPhong.x + uPhong.y * cosine) + uPhong.z * wholePower(mirrored, uSpecularPower);
    return lit;
}
#endif
