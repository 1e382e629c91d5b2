// march_lights.glsl: the scene's own lights, and materials; the loop of litBy() in render/contract/leaves.h. Needs
// FEATURE_LIGHTS, FEATURE_MATERIALS, FEATURE_EMISSION, FEATURE_FUSED, march_optics.glsl, march_segment.glsl. Gives
// HAS_LIGHTS, ReceivedLight, allLight(), materialPlace(front, back), shadeByLights(...).

#if FEATURE_LIGHTS
// As in render/contract/scene_numbers.h.
const int kMostLights = 4;
const int kDirectional = 1;
const int kPoint = 2;
#if FEATURE_FUSED
OF_VOLUME int uHasLights; // 0: a head light's shading is the volume's
#define HAS_LIGHTS (uHasLights != 0)
#else
#define HAS_LIGHTS true
#endif
OF_VOLUME int uLights;
OF_VOLUME int uLightSort[kMostLights];
OF_VOLUME vec3 uLightPlace[kMostLights]; // directional: towards it, unit, patient space, or 0; point: voxels
OF_VOLUME vec3 uLightColour[kMostLights]; // times intensity
OF_VOLUME vec3 uLightFading[kMostLights]; // point: constant, linear, quadratic
OF_VOLUME LightModel uLightModel;

// Shares of light that reach a sample.
struct ReceivedLight {
    vec3 fromAllSides;
    float from[kMostLights];
};
// All of it: costs nothing, for compilers leave out factors of 1.
ReceivedLight allLight() { return ReceivedLight(vec3(1.0), float[kMostLights](1.0, 1.0, 1.0, 1.0)); }

struct Material {
    vec3 phong; // ambient, diffuse, specular
    int power;
};
#if FEATURE_MATERIALS
const int kMostMaterials = 8;
OF_VOLUME int uMaterials;
OF_VOLUME vec2 uMaterialPlaces[kMostMaterials]; // from up to, not with, to, of the table's entries
OF_VOLUME vec3 uMaterialPhong[kMostMaterials];
OF_VOLUME int uMaterialPower[kMostMaterials];

Material materialAt(float place) {
    Material material = Material(uPhong, uSpecularPower);
    TURNS(8);
    for (int i = 0; i < uMaterials; ++i)
        if (place >= uMaterialPlaces[i].x && place < uMaterialPlaces[i].y)
            material = Material(uMaterialPhong[i], uMaterialPower[i]);
    return material;
}

#if FEATURE_EMISSION
OF_VOLUME vec3 uMaterialEmission[kMostMaterials];

// Emission of such a value.
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

// gradient: voxel space, any scale; direction: the ray's, unit in voxel space; p: voxels; place: of the value.
vec3 shadeByLights(vec3 colour, vec3 gradient, vec3 direction, vec3 p, float place, ReceivedLight received) {
    vec3 g = transformed(uVoxelFromPatientTransposed, gradient);
    vec3 d = transformed(uPatientFromVolume, direction);
    Material m = materialAt(place);
    vec3 n;
    vec3 v;
    Met met = meetLight(g, d, uLightModel, kMaxFloat, n, v);
    precise vec3 everywhere = vec3(0.0);
    precise vec3 facingIt = vec3(0.0);
    precise vec3 mirrored = vec3(0.0);
    for (int i = 0; i < uLights; ++i) {
        TURNS(12);
        vec3 l = v;
        float shares = 1.0;
        if (uLightSort[i] == kDirectional) l = uLightPlace[i];
        if (uLightSort[i] == kPoint) {
            precise vec3 o = uLightPlace[i] - p;
            vec3 fading = uLightFading[i];
            meetPoint(transformed(uPatientFromVolume, o), fading.x, fading.y, fading.z, kMaxFloat, l, shares);
        }
        precise float received_ = received.from[i] * shares;
        float slant = dot3(n, l);
        float cosine = heldToOne(slant);
        float highlight = wholePower(sharpness(n, v, l, slant, met, uLightModel), m.power);
        float shine = slant > 0.0 ? highlight : 0.0;
        precise vec3 power = uLightColour[i] * received_;
        everywhere = everywhere + power;
        facingIt = facingIt + power * cosine;
        mirrored = mirrored + power * shine;
    }
    precise vec3 ambient = received.fromAllSides * m.phong.x;
#define OF(c) litScale(met, ambient.c, m.phong.y, everywhere.c, facingIt.c)
    vec3 scale = vec3(OF(x), OF(y), OF(z));
#undef OF
#define OF(c) litAdd(met, m.phong.z, mirrored.c)
    vec3 add = vec3(OF(x), OF(y), OF(z));
#undef OF
    precise vec3 lit = colour * scale + add;
#if FEATURE_EMISSION && FEATURE_MATERIALS
    lit = lit + emissionAt(place);
#endif
    return lit;
}
#endif
