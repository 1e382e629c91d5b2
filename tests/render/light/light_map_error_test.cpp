// tests/render/light/light_map_error_test.cpp: how near pictures with light maps come to those by paths of
// light; TESSERA_TELL=1: what maps take, and what their grid would err by as a shadow's.
#include "render/contract/lattice.h"
#include "render/light/light_sweep.h"
#include "tests/support/light_maps.h"
#include "tests/support/native_fixture.h"
#include "tests/support/paths_and_kept.h"
#include "tests/support/reference_light.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <glm/trigonometric.hpp>
#include <gtest/gtest.h>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace tessera::test {
namespace {

/// Lit from behind: what light maps add is nearer to what paths of up to 64 scatterings add to those of one.
/// Kept light answers to all sides alike: f is what the phase function makes of the angle from light to
/// viewer. TESSERA_TELL=1 tells of sizes and of g; TESSERA_SCATTER_STORE=a.zarr of another store.
TEST(LightMapError, IsNearerToPaths) {
    const char* const other = std::getenv("TESSERA_SCATTER_STORE");
    const bool tells = std::getenv("TESSERA_TELL") != nullptr;
    for (const std::string preset : {"soft-tissue", "bone-1"})
        for (const double g : {0.8, 0.95}) {
            if (!tells && (preset != "soft-tissue" || g > 0.9))
                continue;
            PathsAndKept pictures(other ? other : storePath("torso").string(), preset, backLight(),
                                  tells ? 128 : 96, 8, g);
            const double cosine = std::cos(glm::radians(30.0)),
                         f = (1 - g * g) / std::pow(1 + g * g - 2 * g * cosine, 1.5);
            const double without = pictures.rms(0, false, f), all = pictures.rms(0, true, f);
            tell("%s, g %g: f %.3f (fitted %.3f), rms of further scatterings %.4f, of all light %.4f\n",
                 preset.c_str(), g, f, pictures.ofPhase(), without, all);
            const auto measure = [&](const std::string& what, const std::function<void(Lighting&)>& change) {
                pictures.scatter(change);
                const double best = pictures.bestFactor(false, f), ofBest = pictures.rms(best, false, f);
                const double with = pictures.rms(1, false, f), allWith = pictures.rms(1, true, f);
                tell("    %s: %.4f, %.2f (%.2f: %.2f); of all light %.4f, %.2f\n", what.c_str(), with,
                     with / without, best, ofBest / without, allWith, allWith / all);
                std::fflush(stdout);
                return std::pair(with / without, ofBest / without);
            };
            const auto ofMap = [&](int size, double mapG) {
                return measure("map of " + std::to_string(size) + ", g " + std::to_string(mapG).substr(0, 4),
                               [=](Lighting& lighting) {
                                   lighting.scatterBy = ScatterSource::map;
                                   lighting.lightMap = {size, mapG};
                               });
            };
            if (!tells) {
                const auto [with, best] = ofMap(128, g);
                EXPECT_LT(with, 0.53) << "of the rms without";
                EXPECT_LT(best, 0.5) << "with the best factor";
                continue;
            }
            measure("rays of 2 mm", [](Lighting&) {});
            for (const int size : {48, 96, 128, 192})
                ofMap(size, g);
            for (const double mapG : {0.5, 0.8, 0.9})
                ofMap(128, mapG);
        }
}

/// The share of light that gets to a place, from the nodes of a light map's grid (figure 10.2: no deep map
/// beside it): kept as exactly as numbers allow.
class DirectGrid {
  public:
    DirectGrid(const LightPath& path, const ShadowMaps& maps) : grid_(maps.lightMaps().front()->grid()) {
        const RayFrame<float> frame =
            cast<float>(rayFrame(maps.camera(0), *path.info, glm::ivec2(grid_.size), 1));
        plane_ = rayPlane(maps.camera(0), *path.info, glm::ivec2(grid_.size));
        light_.assign(grid_.nodes(), 1);
        withCacheField<float>(
            *path.cache, *path.info, *path.selection, nullptr, Gradient::central, [&](auto& values) {
                std::vector<LightLeft> samples;
                std::vector<LightSlice> slices(static_cast<std::size_t>(grid_.slices));
                struct Unlabelled {
                    std::decay_t<decltype(values)>& field;
                    float value(const glm::vec3& p) { return field.value(p); }
                    glm::vec3 gradient(const glm::vec3& p) { return field.gradient(p); }
                    leaf::LabelShares<float> labels(const glm::vec3&) { return {}; }
                } field{values};
                Strides strides;
                strides.uniformSegments = 1;
                strides.segmentVoxels = 1;
                for (int y = 0; y < grid_.size; ++y)
                    for (int x = 0; x < grid_.size; ++x) {
                        const auto ray = segmentedRay(frame, glm::vec2(x, y) + 0.5f);
                        const glm::dvec3 entry(path.info->patientFromVoxel *
                                               glm::dvec4(glm::dvec3(ray.entry), 1));
                        const auto mm = static_cast<float>(glm::dot(entry - plane_.centre, plane_.forward));
                        lightAlong(ray, field, path, strides, mm, samples, 1e-30f);
                        std::fill(slices.begin(), slices.end(), LightSlice{});
                        for (std::size_t n = 1; n < samples.size(); ++n)
                            if (samples[n].light > 0 && samples[n].light < samples[n - 1].light)
                                addToSlices(grid_, samples[n - 1].mm, samples[n].mm,
                                            std::log(samples[n - 1].light / samples[n].light), {}, slices);
                        double depth = 0;
                        for (int k = 0; k < grid_.slices; ++k) {
                            depth += static_cast<double>(slices[static_cast<std::size_t>(k)].depth);
                            light_[nodeAt({x, y, k + 1})] = static_cast<float>(std::exp(-depth));
                        }
                    }
            });
    }
    double at(const glm::dvec3& place) const {
        const glm::dvec3 d = place - plane_.centre;
        const auto along = [&](const glm::dvec3& side) { return glm::dot(d, side) / glm::dot(side, side); };
        const glm::dvec3 node(0.5 * (1 + along(plane_.right)) * grid_.size - 0.5,
                              0.5 * (1 - along(plane_.up)) * grid_.size - 0.5,
                              (glm::dot(d, plane_.forward) - grid_.nearMm) / grid_.sliceMm);
        const glm::ivec3 low(glm::floor(node)), most(grid_.size - 1, grid_.size - 1, grid_.slices);
        double sum = 0;
        for (int n = 0; n < 8; ++n) {
            const glm::ivec3 corner = low + glm::ivec3(n & 1, (n >> 1) & 1, n >> 2);
            const glm::dvec3 weights = 1.0 - glm::abs(node - glm::dvec3(corner));
            sum += weights.x * weights.y * weights.z *
                   double{light_[nodeAt(glm::clamp(corner, glm::ivec3(0), most))]};
        }
        return sum;
    }

  private:
    std::size_t nodeAt(const glm::ivec3& at) const {
        return static_cast<std::size_t>(at.z) * grid_.nodesOfPlane() +
               static_cast<std::size_t>(at.y * grid_.size + at.x);
    }
    LightGrid grid_;
    RayPlane plane_;
    std::vector<float> light_;
};

/// Light left at a place, by the midpoint rule in double with short segments.
double lightByRay(const LightPath& path, const glm::dvec3& place, const glm::dvec3& towards) {
    const glm::dmat4 voxels = glm::inverse(path.info->patientFromVoxel);
    constexpr double kStep = 0.1;
    double depth = 0;
    withCacheField<double>(*path.cache, *path.info, *path.selection, path.levels, Gradient::central,
                           [&](auto& field) {
                               for (double t = kStep / 2;; t += kStep) {
                                   const glm::dvec3 p(voxels * glm::dvec4(place + t * towards, 1));
                                   if (glm::any(glm::lessThan(p, glm::dvec3(0))) ||
                                       glm::any(glm::greaterThan(p, glm::dvec3(path.info->extentVoxels))))
                                       break;
                                   depth += kStep * lookUp(*path.optics, field.value(p)).a;
                               }
                           });
    return std::exp(-depth);
}

/// TESSERA_TELL=1: what light maps cost, and what their grid would err by as a shadow's.
TEST(LightMapError, TellsWhatTheyTakeAndErrBy) {
    if (!std::getenv("TESSERA_TELL"))
        GTEST_SKIP() << "TESSERA_TELL is not set";
    for (const auto& [store, preset] : {std::pair{"torso", "soft-tissue"},
                                        {"abdomen", "soft-tissue"},
                                        {"abdomen", "bone-1"},
                                        {"head", "skin-1"}}) {
        if (!std::filesystem::exists(storePath(store)))
            continue;
        Prepared prepared(store, sceneOn(infoOf(store), preset, 0, {16, 16}));
        PlacedLight light;
        light.towards = glm::normalize(glm::dvec3(0.4, -0.7, 0.5));
        light.scatters = true;
        const double deepAlone = MadeMaps(prepared, light, std::nullopt).seconds;
        const VolumeInfo& info = prepared.p.info();
        std::vector<glm::dvec3> places;
        std::vector<double> truth;
        std::mt19937 random(7);
        std::uniform_real_distribution<double> anywhere(0.02, 0.98);
        for (const int size : {64, 96, 128, 192}) {
            const MadeMaps made(prepared, light, LightMapping{size, 0.8});
            for (int n = 0; places.size() < 300 && n < 400000; ++n) {
                const glm::dvec3 voxel = glm::dvec3(info.extentVoxels) *
                                         glm::dvec3(anywhere(random), anywhere(random), anywhere(random));
                const glm::dvec3 place(info.patientFromVoxel * glm::dvec4(voxel, 1));
                bool shows = false;
                withCacheField<double>(
                    *made.path.cache, info, *made.path.selection, nullptr, Gradient::central,
                    [&](auto& field) { shows = lookUp(*made.path.optics, field.value(voxel)).a > 0.01; });
                const double left = shows ? lightByRay(made.path, place, light.towards) : 0;
                if (left >= 0.02) {
                    places.push_back(place);
                    truth.push_back(left);
                }
            }
            const DirectGrid direct(made.path, made.maps);
            ShadowQuality exact;
            exact.offset = 0;
            ShadowMaps deep(light, made.path, exact);
            deep.build(made.path, 0);
            double ofGrid = 0, ofMap = 0;
            for (std::size_t n = 0; n < places.size(); ++n) {
                ofGrid += std::pow(direct.at(places[n]) - truth[n], 2);
                ofMap += std::pow(double{deep.light(places[n])} - truth[n], 2);
            }
            const auto count = static_cast<double>(places.size());
            tell("%s, %s, %d rays, %d slices: %.2f s beside %.2f s of a deep map, %.1f MiB kept, %.1f MiB of "
                 "room; rms of direct light by its grid %.4f, by the deep map %.4f (%zu places)\n",
                 store, preset, size, made.maps.lightMaps().front()->grid().slices, made.seconds - deepAlone,
                 deepAlone, static_cast<double>(made.maps.lightMaps().front()->bytes()) / 1048576,
                 static_cast<double>(MapSweep::bytes(size)) / 1048576, std::sqrt(ofGrid / count),
                 std::sqrt(ofMap / count), places.size());
            std::fflush(stdout);
        }
    }
}

} // namespace
} // namespace tessera::test
