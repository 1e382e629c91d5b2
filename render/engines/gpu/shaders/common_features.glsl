// common_features.glsl: every feature is 0 or 1; a forgotten or misspelt one is an error, not "off".
#if !defined(FEATURE_SHADING) || !defined(FEATURE_SKIPPING) || !defined(FEATURE_HARDWARE) || \
    !defined(FEATURE_NORMALISED) || !defined(FEATURE_TERMINATION) || \
    !defined(FEATURE_COUNTING) || !defined(FEATURE_MIXED) || !defined(FEATURE_PASSES) || \
    !defined(FEATURE_VISIBILITY) || \
    !defined(FEATURE_LINEAR) || !defined(FEATURE_PREINTEGRATED) || !defined(FEATURE_SEENCOLOURS) || \
    !defined(FEATURE_FORWARD_GRADIENT) || !defined(FEATURE_SOBEL_GRADIENT) || \
    !defined(FEATURE_ANALYTIC_GRADIENT) || !defined(FEATURE_SURFACES) || !defined(FEATURE_HITS) || \
    !defined(FEATURE_HALF_CENTRAL_GRADIENT)
#error every FEATURE_ must be defined as 0 or 1 (render/engines/gpu/features.h)
#endif
#if FEATURE_VISIBILITY && (FEATURE_LINEAR || FEATURE_PREINTEGRATED)
#error what is seen of bricks is counted by the midpoint rule
#endif
#if FEATURE_SURFACES && FEATURE_VISIBILITY
#error rays that look for surfaces do not count what is seen
#endif
#if FEATURE_HITS && !FEATURE_SURFACES
#error what rays hit are isosurfaces
#endif
#if FEATURE_FORWARD_GRADIENT + FEATURE_SOBEL_GRADIENT + FEATURE_ANALYTIC_GRADIENT + FEATURE_HALF_CENTRAL_GRADIENT > 1
#error a gradient is taken one way
#endif
