// tests/bench/path_peer.cpp: a scene for other programs (path_peers.py): extinctions of a volume as a grid,
// and pictures of such a grid as plain floats.
//
//   path_peer --store ct.zarr --preset bone --edge 192 --grid grid.json
//   path_peer --store grid.zarr --picture 1.f32 --size 128 --samples 64 --seed 1 --bounces 8 --albedo 0.8
//
// The grid has float32 extinctions per mm at the middles of its voxels, x fastest: a raw file with a sidecar.
// A picture is float32 grey, top row first; its one light is directional and its phase function even. What
// else it is goes to stdout as JSON.
#include "core/base/error.h"
#include "render/picture/render_scene.h"
#include "tests/bench/path_baselines.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <nlohmann/json.hpp>
#include <string>

namespace tessera::bench {
namespace {

void write(const std::filesystem::path& path, const std::vector<float>& values) {
    std::ofstream file(path, std::ios::binary);
    file.write(reinterpret_cast<const char*>(values.data()),
               static_cast<std::streamsize>(values.size() * sizeof(float)));
    if (!file.flush())
        throw Error(path.string() + ": expected a file that can be written, found none");
}

constexpr glm::dvec3 kLight(-0.6, 0.8, 1); // towards it, by the camera's axes

/// A scene with paths of light; without a sky.
Scene sceneOf(const TransferChoice& function, const StoreReader& store, int size, int bounces) {
    Scene scene;
    SceneVolume volume;
    volume.transferFunction = function;
    scene.volumes = {volume};
    scene.imageSize = glm::ivec2(size);
    scene.camera = fitCamera(store.info(), View::anterior, Projection::parallel, scene.imageSize);
    Light light;
    light.kind = LightKind::directional;
    light.direction = kLight;
    light.shadow = true;
    scene.lighting.lights = {light};
    Transport transport;
    transport.bounces = bounces;
    scene.lighting.transport = transport;
    return scene;
}

/// @param perVoxel  the greatest extinction of the grid, per mean pitch: all are scaled to it; 0: they are
/// not
void writeGrid(const StoreReader& store, const std::string& preset, int edge, double perVoxel,
               const std::string& path) {
    Budgets budgets;
    const PathBaseline volume(sceneOf(preset, store, 64, 1), store, budgets, 0);
    const VolumeInfo& info = store.info();
    const glm::ivec3 extent = glm::min(info.extentVoxels, glm::ivec3(edge));
    const glm::dvec3 pitch = glm::dvec3(info.extentVoxels) / glm::dvec3(extent);
    const glm::dmat3 axes(info.patientFromVoxel);
    const glm::dvec3 first(info.patientFromVoxel * glm::dvec4(0.5 * pitch, 1));
    glm::dvec3 spacing(0);
    for (int axis = 0; axis < 3; ++axis)
        spacing[axis] = pitch[axis] * glm::length(axes[axis]);
    const glm::dmat3 rows =
        glm::transpose(glm::dmat3(glm::normalize(axes[0]), glm::normalize(axes[1]), glm::normalize(axes[2])));
    nlohmann::json sidecar;
    const auto listed = [](const auto& v) { return std::vector{v[0], v[1], v[2]}; };
    sidecar["data"] = std::filesystem::path(path).stem().string() + ".raw";
    sidecar["type"] = "float32";
    sidecar["extent"] = listed(extent);
    sidecar["spacing"] = listed(spacing);
    sidecar["origin"] = listed(first);
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column)
            sidecar["direction"].push_back(rows[row][column]);
    std::ofstream(path) << sidecar.dump(1);
    std::vector<float> values = volume.extinctions(extent);
    if (const float most = *std::max_element(values.begin(), values.end()); perVoxel > 0 && most > 0) {
        const double perMm = perVoxel / std::cbrt(spacing.x * spacing.y * spacing.z);
        for (float& value : values)
            value *= static_cast<float>(perMm / double{most});
    }
    write(std::filesystem::path(path).replace_extension(".raw"), values);
}

void writePicture(const StoreReader& store, std::map<std::string, std::string>& options) {
    Budgets budgets;
    const double most = std::stod(options["--most"]), albedo = std::stod(options["--albedo"]);
    const auto linear = TransferFunction::fromExtinction({{0, 0}, {most, most}}, {{0, glm::dvec3(albedo)}});
    Scene scene = sceneOf(linear, store, std::stoi(options["--size"]), std::stoi(options["--bounces"]));
    scene.quality.pixels.samples = std::stoi(options["--samples"]);
    scene.quality.pixels.seed = static_cast<std::uint32_t>(std::stoi(options["--seed"]));
    RenderOptions drawn;
    drawn.engine = EngineKind::native;
    drawn.threads = std::stoi(options["--threads"]);
    const double before = cpuSeconds();
    const auto start = Clock::now();
    const RenderResult result = renderScene(scene, store, budgets.ram, budgets.gpu, drawn);
    const double cpu = cpuSeconds() - before, wall = 1e-3 * msSince(start);
    std::vector<float> grey;
    for (const glm::vec4& pixel : result.image.pixels)
        grey.push_back(pixel.g);
    write(options["--picture"], grey);
    const auto& camera = std::get<Camera>(scene.camera);
    const glm::dmat3 axes = patientFromCamera(camera);
    const auto listed = [](const glm::dvec3& v) { return std::vector{v.x, v.y, v.z}; };
    nlohmann::json told;
    told["cpu"] = cpu;
    told["wall"] = wall;
    told["focal"] = listed(camera.focalPoint);
    told["right"] = listed(axes[0]);
    told["up"] = listed(axes[1]);
    told["back"] = listed(axes[2]);
    told["height"] = 2 * camera.parallelScale;
    told["towardsLight"] = listed(glm::normalize(axes * kLight));
    std::printf("%s\n", told.dump().c_str());
}

void run(int argc, char** argv) {
    auto options = parseOptions(argc, argv,
                                {{"--store", ""},
                                 {"--grid", ""}, // a file to write; and of it:
                                 {"--preset", "bone"},
                                 {"--edge", "192"},    // voxels along an axis, at most
                                 {"--per-voxel", "0"}, // its greatest extinction; 0: the function's
                                 {"--picture", ""},    // a file to write; and of it:
                                 {"--size", "128"},
                                 {"--samples", "64"},
                                 {"--seed", "1"},
                                 {"--bounces", "1"},
                                 {"--albedo", "0.8"},
                                 {"--most", "1"}, // the greatest extinction, per mm
                                 {"--threads", "2"}});
    Budgets budgets;
    const StoreReader store(options["--store"], budgets.ram);
    if (!options["--grid"].empty())
        writeGrid(store, options["--preset"], std::stoi(options["--edge"]), std::stod(options["--per-voxel"]),
                  options["--grid"]);
    if (!options["--picture"].empty())
        writePicture(store, options);
}

} // namespace
} // namespace tessera::bench

int main(int argc, char** argv) {
    return tessera::bench::runMain("path_peer", tessera::bench::run, argc, argv);
}
