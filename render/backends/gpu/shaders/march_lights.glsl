// march_lights.glsl: the scene's own lights, and what answers to them; twin of litBy() in render/contract/leaves.h,
// operation by operation.
// Needs FEATURE_LIGHTS, FEATURE_MATERIALS, FEATURE_EMISSION, march_optics.glsl, march_segment.glsl. Gives ReceivedLight, allLight(),
// materialPlace(front, back), shadeByLights(...).

#if FEATURE_LIGHTS
// Twin of render/contract/light_numbers.h.
const int kMostLights = 4;
const int kDirectional = 1;
const int kPoint = 2;
uniform int uLights;
uniform int uLightSort[kMostLights];
uniform vec3 uLightPlace[kMostLights];  // directional: towards it, unit, patient space, or 0; point: voxels
uniform vec3 uLightColour[kMostLights]; // times intensity
uniform vec3 uLightFading[kMostLights]; // point: constant, linear, quadratic
uniform int uHalfway;                   // highlights follow the direction halfway between light and viewer
uniform float uWeightLow, uWeightScale; // of gradients, stored units per mm

// Shares of light that reach a sample.
struct ReceivedLight {
    vec3 fromAllSides;
    float from[kMostLights];
};
// All of it: costs nothing, for compilers leave out what is multiplied by 1.
ReceivedLight allLight() { return ReceivedLight(vec3(1.0), float[kMostLights](1.0, 1.0, 1.0, 1.0)); }

struct Material {
    vec3 phong; // ambient, diffuse, specular
    int power;
};
#if FEATURE_MATERIALS
const int kMostMaterials = 8;
uniform int uMaterials;
uniform vec2 uMaterialPlaces[kMostMaterials]; // from up to, not with, to, of the table's entries
uniform vec3 uMaterialPhong[kMostMaterials];
uniform int uMaterialPower[kMostMaterials];

Material materialAt(float place) {
    Material material = Material(uPhong, uSpecularPower);
    TURNS(8);
    for (int i = 0; i < uMaterials; ++i)
        if (place >= uMaterialPlaces[i].x && place < uMaterialPlaces[i].y)
            material = Material(uMaterialPhong[i], uMaterialPower[i]);
    return material;
}

#if FEATURE_EMISSION
uniform vec3 uMaterialEmission[kMostMaterials];

// Light that what has such a value sends.
vec3 emissionAt(float place) {
    vec3 sent = vec3(0.0);
    TURNS(8);
    for (int i = 0; i < uMaterials; ++i)
        if (place >= uMaterialPlaces[i].x && place < uMaterialPlaces[i].y) sent = uMaterialEmission[i];
    return sent;
}
#endif

// Of the value halfway between a segment's ends.
float materialPlace(SegmentEnd front, SegmentEnd back) {
#if FEATURE_ENDS
    precise float halfway = 0.5 * (front.place + back.place);
    return halfway;
#else
    return back.unlimited;
#endif
}
#else
Material materialAt(float place) { return Material(uPhong, uSpecularPower); }
float materialPlace(SegmentEnd front, SegmentEnd back) { return 0.0; }
#endif

float dot3(vec3 a, vec3 b) {
    precise float sum = a.x * b.x + a.y * b.y + a.z * b.z;
    return sum;
}

// gradient: voxel space, any scale; direction: the ray's, unit in voxel space; p: voxels; place: of the value.
vec3 shadeByLights(vec3 colour, vec3 gradient, vec3 direction, vec3 p, float place, ReceivedLight received) {
    precise vec3 g = uVoxelFromPatientTransposed[0] * gradient.x + uVoxelFromPatientTransposed[1] * gradient.y +
                     uVoxelFromPatientTransposed[2] * gradient.z;
    precise vec3 d = uPatientFromVoxel[0] * direction.x + uPatientFromVoxel[1] * direction.y +
                     uPatientFromVoxel[2] * direction.z;
    Material m = materialAt(place);
    precise float steepness = dot3(g, g);
    precise float distance = dot3(d, d);
    bool isSurface = steepness > 0.0 && steepness <= kMaxFloat && distance > 0.0 && distance <= kMaxFloat;
    precise float steep = sqrt(steepness);
    precise float far = sqrt(distance);
    precise float facing = (dot3(g, d) > 0.0 ? -1.0 : 1.0) / steep;
    precise vec3 n = vec3(0.0);
    precise vec3 v = vec3(0.0);
    precise float weight = 0.0;
    if (isSurface) {
        n = g * facing;
        v = (0.0 - d) / far;
        precise float above = min(1.0, max(0.0, (steep - uWeightLow) * uWeightScale));
        weight = above * above * (3.0 - 2.0 * above);
    }
    precise float towardsViewer = dot3(n, v);
    precise vec3 everywhere = vec3(0.0);
    precise vec3 facingIt = vec3(0.0);
    precise vec3 mirrored = vec3(0.0);
    for (int i = 0; i < uLights; ++i) {
        TURNS(12);
        precise vec3 l = v;
        precise float shares = 1.0;
        if (uLightSort[i] == kDirectional) l = uLightPlace[i];
        if (uLightSort[i] == kPoint) {
            precise vec3 o = uLightPlace[i] - p;
            precise vec3 to = uPatientFromVoxel[0] * o.x + uPatientFromVoxel[1] * o.y + uPatientFromVoxel[2] * o.z;
            precise float squared = min(dot3(to, to), kMaxFloat);
            precise float away = sqrt(squared);
            precise vec3 unit = to / away;
            l = squared > 0.0 ? unit : vec3(0.0);
            shares = 1.0 / (uLightFading[i].x + uLightFading[i].y * away + uLightFading[i].z * squared);
        }
        shares = received.from[i] * shares;
        precise float slant = dot3(n, l);
        precise float cosine = min(1.0, max(0.0, slant));
        precise float sharp = 0.0;
        if (uHalfway != 0) {
            precise vec3 h = l + v;
            precise float squared = dot3(h, h);
            precise float along = dot3(n, h) / sqrt(squared);
            sharp = squared > 0.0 ? along : 0.0;
        } else {
            sharp = 2.0 * slant * towardsViewer - dot3(l, v);
        }
        float highlight = wholePower(min(1.0, max(0.0, sharp)), m.power);
        float shine = slant > 0.0 ? highlight : 0.0;
        precise vec3 power = uLightColour[i] * shares;
        everywhere = everywhere + power;
        facingIt = facingIt + power * cosine;
        mirrored = mirrored + power * shine;
    }
    precise vec3 ambient = received.fromAllSides * m.phong.x;
    precise vec3 volume = ambient + m.phong.y * everywhere;
    precise vec3 surface = ambient + m.phong.y * facingIt;
    precise vec3 scale = volume + weight * (surface - volume);
    precise vec3 add = weight * (m.phong.z * mirrored);
    precise vec3 lit = colour * scale + add;
#if FEATURE_EMISSION && FEATURE_MATERIALS
    lit = lit + emissionAt(place);
#endif
    return lit;
}
#endif
