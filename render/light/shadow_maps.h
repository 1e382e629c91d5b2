// render/light/shadow_maps.h: shadow maps of the drawn field, seen from the scene's lights. A light with
// softness has several, from points spread over it. A light inside the volume has six, to all sides.
#pragma once

#include "bricking/cache/brick_cache.h"
#include "bricking/levels/selection.h"
#include "core/base/budget.h"
#include "core/base/progress.h" // ShareDone
#include "core/scene/camera.h"
#include "core/scene/lighting.h"
#include "core/scene/mesh.h"
#include "render/backends/native/packet.h"
#include "render/contract/optics.h"
#include "render/contract/strides.h"
#include "render/empty_space/occupancy.h"
#include "render/geometry/shape_shade.h" // ShadeStep
#include "render/labels/label_field.h"
#include "render/light/deep_shadow_map.h"
#include "render/light/first_hit_map.h"
#include "render/light/light_map.h"

#include <chrono>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace tessera {

class MapSweep;

/// A light in patient space.
struct PlacedLight {
    bool isPoint = false;
    glm::dvec3 towards{0, 0, 1}; // directional: unit, to the light
    glm::dvec3 position{0};      // point: mm
    double softness = 0;         // degrees
    bool scatters = false;       // tissue scatters its light
};

/// Rays of maps through the bricks that an engine holds: the numbers of lightAlong(). For several threads.
class ShadowRays {
  public:
    virtual ~ShadowRays() = default;
    virtual std::size_t mostAtOnce() const = 0;
    /// @param room  of the samples, until the next call
    /// @param dark  light below which a ray ends
    /// @param samples  output, one a ray
    /// Returns false where a brick is lacking: then the samples mean nothing.
    virtual bool along(std::span<const SegmentedRay<float>> rays, std::span<const float> mmAtEntry,
                       float dark, std::vector<LightLeft>& room,
                       std::span<std::span<const LightLeft>> samples) const = 0;
};

/// The inputs. All outlive the maps.
struct LightPath {
    BrickCache* cache = nullptr;
    const VolumeInfo* info = nullptr;
    const Selection* selection = nullptr;
    const LevelMap* levels = nullptr; // null: the selection has one level
    const Optics* optics = nullptr;
    const Occupancy* occupancy = nullptr;   // null: no skipping
    const ShadowRays* rays = nullptr;       // null: by the cache's samples, one by one
    LabelBricks* labels = nullptr;          // null: the scene has none
    std::span<const SceneMesh> meshes = {}; // that take light besides
};

/// A light as a camera sees it.
PlacedLight placedLight(const Light& light, const Camera& camera);

struct ShadowQuality {
    int mapSize = 512;                   // rays along a side of the map of a light without softness
    double stepVoxels = 1;               // of its rays
    float error = 1.0f / 128;            // error of light in maps, if the layers suffice
    int layers = DeepShadowMap::kLayers; // points stored per ray; at most kLayers
    /// Offset of lookups towards the light, in samples of the light's level, but at least half the distance
    /// of a map's rays. So the visible part of a surface is lit, not shadowed by its outermost samples.
    double offset = 2;
    ShadowMapping mapping = {}; // the scene's
    /// Of lights whose light tissue scatters; none: there are no light maps.
    std::optional<LightMapping> lightMap = {};
    int lightMapPart = 1; // light maps have this part of the scene's rays along a side
    static constexpr int kMapsOfSoftLight = 4;
};

/// The same for a scene's lighting: what its maps keep.
ShadowQuality qualityOf(ShadowQuality quality, const Lighting& lighting);

class ShadowMaps {
  public:
    /// @param field  its selection gives the box of the maps
    ShadowMaps(const PlacedLight& light, const LightPath& field, const ShadowQuality& quality);

    /// Memory of the maps, by size; half the side takes a quarter. With light maps, at most.
    static std::size_t bytes(const Light& light, const ShadowQuality& quality);
    /// Room in which a light map is made.
    static std::size_t sweepBytes(const Light& light, const ShadowQuality& quality);

    /// Casts all rays.
    /// @param threads  0: all processors
    void build(const LightPath& field, int threads, const ShareDone& progress = {});
    /// Casts rays until the deadline, at least some; inputs must not change until all are cast. Returns true
    /// then.
    bool buildUntil(const LightPath& field, int threads, std::chrono::steady_clock::time_point deadline);

    /// Share of the light that reaches a point, patient space; [0,1].
    /// @param level  of the samples to light
    float light(const glm::dvec3& place, int level = 0) const;
    /// The same at native::kOcclusionRun places.
    /// @param step  from one to the next
    void light(const glm::dvec3& place, const glm::dvec3& step, int level, const native::PacketTarget& target,
               float* out) const;

    /// Scattered light that reaches a point by the light maps, relative to the light with nothing in the way;
    /// red, green, blue. There must be such maps.
    glm::vec3 scattered(const glm::dvec3& place) const;

    /// The largest error bound of a ray's fit, and the share of rays with a larger bound than requested.
    float largestError() const { return largestError_; }
    double shareOfMore() const {
        return static_cast<double>(more_) / static_cast<double>(mapRows() * static_cast<std::size_t>(size_));
    }
    /// Of a point light, patient space, mm.
    const glm::dvec3& position() const { return light_; }
    const std::vector<std::shared_ptr<ShadowMap>>& maps() const { return maps_; }
    /// One for each view, or none.
    const std::vector<std::shared_ptr<LightMap>>& lightMaps() const { return lightMaps_; }
    /// The view of a map.
    const Camera& camera(std::size_t map) const { return views_[map].camera; }

  private:
    struct View {
        Camera camera;
        RayPlane plane;
        glm::dvec3 right{0}, up{0}; // over the square of their length
        double far = 0;             // perspective: distance of the plane's centre
    };
    struct Row { // of a view's rays
        std::vector<SegmentedRay<float>> rays;
        std::vector<float> entries; // their distances from where they start, mm
    };
    Row rowOf(const VolumeInfo& info, const View& view, int size, int y) const;
    template <typename Visit>
    void castRow(const LightPath& field, const Row& row, float dark, const Visit& visit) const;
    void buildRow(const LightPath& field, std::size_t row, std::size_t& more, float& largest);
    void buildLightRow(const LightPath& field, std::size_t row);
    void buildSome(const LightPath& field, int threads, std::size_t most, const ShareDone& progress);
    std::vector<ShadeStep> shadesOf(const LightPath& field, const View& view, const glm::dvec2& pixel,
                                    int size) const;
    std::size_t mapRows() const { return maps_.size() * static_cast<std::size_t>(size_); }
    std::size_t rows() const;
    bool isBuilt() const { return rowsBuilt_ == rows() && !sweep_; }
    void addView(const Camera& camera, const VolumeInfo& info, const std::vector<glm::dvec3>& corners,
                 bool scatters);
    void finish();
    /// The view, among those of the n-th place of the light, in which a point lies.
    std::size_t viewOf(std::size_t first, const glm::dvec3& place) const;
    /// The position of a point on a map, and its distance from the start of rays. False: behind a point
    /// light.
    bool placeOn(const View& view, const glm::dvec3& place, glm::vec2& at, float& mm) const;

    ShadowQuality quality_;
    glm::dvec3 light_{0}; // a direction, or a point
    bool isPoint_ = false;
    double offsetMm_ = 0; // of level 0
    double rayMm_ = 0;    // directional: largest distance of a map's rays, for the offset
    int perLight_ = 1;    // number of views to different sides
    bool isSoft_ = false; // several places
    std::vector<View> views_;
    int size_ = 1;                                     // rays along a side of a map
    std::vector<std::shared_ptr<ShadowMap>> maps_;     // of copies, too, which are not built again
    std::vector<std::shared_ptr<LightMap>> lightMaps_; // likewise
    std::shared_ptr<MapSweep> sweep_;                  // of the one that is built
    std::size_t rowsBuilt_ = 0, more_ = 0;             // rays with a larger bound
    float largestError_ = 0;
};

/// The light left along a ray: at the start and end of segments that take some.
/// @param field  value(p) and gradient(p); labels(p), where there are labels
/// @param samples  output, replaced
/// @param dark  light below which it ends
template <typename Field>
void lightAlong(const SegmentedRay<float>& ray, Field& field, const LightPath& lit, const Strides& strides,
                float mmAtEntry, std::vector<LightLeft>& samples, float dark = DeepShadowMap::kDark) {
    samples.clear();
    float left = 1;
    int last = -1; // end of the last recorded segment
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
        extinction = LabelledSample<float>(*lit.optics, field, middle).take(extinction);
        if (extinction > 0) {
            if (last != i)
                samples.push_back({mmAtEntry + static_cast<float>(i) * ray.segmentMm, left});
            left = left * (1 - opacityOf(extinction * (length * ray.segmentMm)));
            samples.push_back({mmAtEntry + (static_cast<float>(i) + length) * ray.segmentMm, left});
            last = i + n;
            if (left < dark)
                break;
        }
        i += n;
    }
}

} // namespace tessera
