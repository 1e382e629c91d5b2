// march_gradient_opacity.glsl: a factor on extinctions, by the length of the gradient in patient space; twin of
// gradientOpacity() in render/contract/leaves.h, operation by operation.
// Needs FEATURE_GRADIENT_OPACITY, march_optics.glsl. Gives gradientOpacity(gradient).

#if FEATURE_GRADIENT_OPACITY
// Twin of render/contract/gradient_numbers.h.
const int kMostGradientPoints = 16;
uniform int uGradientPoints;
uniform vec3 uGradientOpacity[kMostGradientPoints]; // length, stored units per mm; factor; slope from there on

// gradient: voxel space, stored units.
float gradientOpacity(vec3 gradient) {
    precise vec3 g = uVoxelFromPatientTransposed[0] * gradient.x + uVoxelFromPatientTransposed[1] * gradient.y +
                     uVoxelFromPatientTransposed[2] * gradient.z;
    precise float squared = g.x * g.x + g.y * g.y + g.z * g.z;
    precise float steep = sqrt(squared <= kMaxFloat ? squared : kMaxFloat); // also where it is no number
    precise float factor = uGradientOpacity[0].y;
    TURNS(16);
    for (int i = 0; i < uGradientPoints; ++i) {
        vec3 point = uGradientOpacity[i];
        precise float along = point.y + (steep - point.x) * point.z;
        factor = point.x <= steep ? along : factor;
    }
    return min(1.0, max(0.0, factor));
}
#endif
