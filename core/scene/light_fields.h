// core/scene/light_fields.h: the tables of what light consists of, and the kinds of keys that several of them
// have. Their files are light_fields.cpp (lights, and all together), occlusion_fields.cpp, shading_fields.cpp
// and transport_fields.cpp.
#pragma once

#include "core/scene/scene_fields.h"

#include <string>

namespace tessera {

constexpr double kFarthestLightMm = 1e7, kMostIntensity = 1e6;

/// Three numbers.
Kind<glm::dvec3> vectorWithin(double lowest, double highest, const std::string& expected);
/// [low, high], ascending.
Kind<GradientWeight> gradientWeightKind();

const Fields<Occlusion>& occlusionFields();
const Fields<SurfaceOcclusion>& surfaceOcclusionFields();
const Fields<ShadowMapping>& shadowMappingFields();
const Fields<Transport>& transportFields();
const Fields<Environment>& environmentFields();

} // namespace tessera
