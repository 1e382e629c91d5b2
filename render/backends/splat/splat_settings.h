// render/backends/splat/splat_settings.h: the numbers of splats, and what comparisons vary.
#pragma once

namespace tessera {

/// What a footprint is convolved with (docs/sampling.md, "Splats"). reconstruction: nothing, as if pixels
/// were points; lowPass: the pixel's filter stands for all of it; full: both. adaptive: one of these for
/// every patch of samples, by its depth.
enum class SplatFilter { reconstruction, lowPass, full, adaptive };

/// sheet: optical depths of a slice add up, and slices are composited. every: each splat is composited.
enum class SplatComposition { sheet, every };

struct SplatSettings {
    double sigma = 0.6;   // standard deviation of a kernel, in samples of its level
    double lowPass = 0.5; // that of a pixel's filter, pixels
    double cutOff = 3;    // radius of footprints, in standard deviations
    SplatFilter filter = SplatFilter::adaptive;
    SplatComposition composition = SplatComposition::sheet;
    double fade = 3; // degrees within which pictures by two orders of slices are mixed; 0: never
};

} // namespace tessera
