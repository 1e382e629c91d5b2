// render/light/shadow_maps.h: deep shadow maps of the field that is drawn, seen from the scene's lights. A
// light of some size has several, from points spread over it. A light inside the volume has six,
// to all sides.
#pragma once

#include "bricking/cache/brick_cache.h"
#include "bricking/levels/selection.h"
#include "core/base/budget.h"
#include "core/base/progress.h" // ShareDone
#include "core/scene/camera.h"
#include "core/scene/lighting.h"
#include "render/contract/optics.h"
#include "render/contract/strides.h"
#include "render/empty_space/occupancy.h"
#include "render/light/deep_shadow_map.h"

#include <chrono>
#include <cstddef>
#include <vector>

namespace tessera {

/// A light, fixed to the patient.
struct PlacedLight {
    bool isPoint = false;
    glm::dvec3 towards{0, 0, 1}; // directional: unit, to the light
    glm::dvec3 position{0};      // point: mm
    double softness = 0;         // degrees
};

/// What light goes through. All outlive what is made of it.
struct LightPath {
    BrickCache* cache = nullptr;
    const VolumeInfo* info = nullptr;
    const Selection* selection = nullptr;
    const LevelMap* levels = nullptr; // null: the selection has one level
    const Optics* optics = nullptr;
    const Occupancy* occupancy = nullptr; // null: nothing is skipped
};

/// A light as a camera sees it.
PlacedLight placedLight(const Light& light, const Camera& camera);

struct ShadowQuality {
    int mapSize = 512;                   // rays along a side of the one map of a light without size
    double stepVoxels = 1;               // of its rays
    float error = 1.0f / 128;            // of the light that maps hold, where layers are enough
    int layers = DeepShadowMap::kLayers; // places kept of a ray; at most so many
    /// Towards the light, of the place whose light is asked for, in samples of the light's level and, where
    /// that is more, half of what lies between a map's rays: what is shown of a surface lies in the light,
    /// not in the shade of its outermost samples.
    double offset = 2;
    static constexpr int kMapsOfSoftLight = 4;
};

class ShadowMaps {
  public:
    /// @param field  its selection decides where there is anything to look at
    ShadowMaps(const PlacedLight& light, const LightPath& field, const ShadowQuality& quality);

    /// Memory of the maps, which size decides; half the side takes a quarter.
    static std::size_t bytes(const Light& light, const ShadowQuality& quality);

    /// Sends the rays.
    /// @param threads  0: all processors
    void build(const LightPath& field, int threads, const ShareDone& progress = {});
    /// As many as there is time for, at least some; what they go through must be the same until all are sent.
    /// True then.
    bool buildUntil(const LightPath& field, int threads, std::chrono::steady_clock::time_point deadline);

    /// Share of the light that gets to a place, patient space; [0,1].
    /// @param level  of the samples that it is for
    float light(const glm::dvec3& place, int level = 0) const;

    /// The largest error that a ray's fit may make, and the share of rays whose fit may make more than was
    /// asked for.
    float largestError() const { return largestError_; }
    double shareOfMore() const {
        return static_cast<double>(more_) /
               static_cast<double>(rows() * static_cast<std::size_t>(maps_.front().size()));
    }
    const std::vector<DeepShadowMap>& maps() const { return maps_; }
    /// Where the rays of a map come from.
    const Camera& camera(std::size_t map) const { return views_[map].camera; }

  private:
    struct View {
        Camera camera;
        RayPlane plane;
        glm::dvec3 right{0}, up{0}; // over the square of their length
        double far = 0;             // perspective: distance of the plane's centre
    };
    void buildRow(const LightPath& field, std::size_t row, std::size_t& more, float& largest);
    std::size_t rows() const { return maps_.size() * static_cast<std::size_t>(maps_.front().size()); }
    void addView(const Camera& camera, const VolumeInfo& info, int size);
    /// Where a place lies on a map, and how far from where its rays start. False: behind a point light.
    bool placeOn(const View& view, const glm::dvec3& place, glm::vec2& at, float& mm) const;

    ShadowQuality quality_;
    glm::dvec3 light_{0}; // a direction, or a place
    bool isPoint_ = false;
    double offsetMm_ = 0; // of level 0
    double rayMm_ = 0;    // directional: what lies between rays of a map at most, as far as offset says
    int perLight_ = 1;    // views that look to different sides
    std::vector<View> views_;
    std::vector<DeepShadowMap> maps_;
    std::size_t rowsBuilt_ = 0, more_ = 0; // of rays whose fit may make more
    float largestError_ = 0;
};

/// The light left along a ray: at the ends of the segments that take some, and where those start.
/// @param field  value(p) and gradient(p)
/// @param samples  replaced
template <typename Field>
void lightAlong(const SegmentedRay<float>& ray, Field& field, const LightPath& lit, const Strides& strides,
                float mmAtEntry, std::vector<LightLeft>& samples) {
    samples.clear();
    float left = 1;
    int last = -1; // segment up to which light is known
    for (int i = 0; i < ray.count;) {
        const int n = strideAt(strides, ray, i);
        const float length = strideLength(ray, i, n);
        const glm::vec3 middle = stridePosition(ray, i, length);
        if (lit.occupancy) {
            const int next = nextOccupied(*lit.occupancy, strides, ray, i, n, middle);
            if (next > i) {
                i = next;
                continue;
            }
        }
        const float stored = field.value(middle);
        float extinction = occlusionExtinction(*lit.optics, stored);
        if (extinction > 0 && lit.optics->grades())
            extinction =
                occlusionExtinction(*lit.optics, stored, gradientFactor(*lit.optics, field.gradient(middle)));
        if (extinction > 0) {
            if (last != i)
                samples.push_back({mmAtEntry + static_cast<float>(i) * ray.segmentMm, left});
            left = left * (1 - opacityOf(extinction * (length * ray.segmentMm)));
            samples.push_back({mmAtEntry + (static_cast<float>(i) + length) * ray.segmentMm, left});
            last = i + n;
            if (left < DeepShadowMap::kDark)
                break;
        }
        i += n;
    }
}

} // namespace tessera
