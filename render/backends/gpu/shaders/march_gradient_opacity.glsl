// march_gradient_opacity.glsl: a factor on extinctions, by the length of the gradient in patient space.
// Needs FEATURE_GRADIENT_OPACITY, march_optics.glsl. Gives gradientOpacity(gradient).

#if FEATURE_GRADIENT_OPACITY
// As in render/contract/scene_numbers.h.
const int kMostGradientPoints = 16;
OF_VOLUME int uGradientPoints;
OF_VOLUME vec3 uGradientOpacity[kMostGradientPoints]; // length, stored units per mm; factor; slope from there on

// gradient: voxel space, stored units.
float gradientOpacity(vec3 gradient) {
    float steep = steepness(transformed(uVoxelFromPatientTransposed, gradient), kMaxFloat);
    float factor = uGradientOpacity[0].y;
    TURNS(16);
    for (int i = 0; i < uGradientPoints; ++i) {
        vec3 point = uGradientOpacity[i];
        factor = factorFrom(factor, steep, point.x, point.y, point.z);
    }
    return heldToOne(factor);
}
#endif
