// tests/bench/path_peer.cpp: a scene for other programs (path_peers.py): extinctions of a volume as a grid,
// and pictures of such a grid as plain floats.
//
//   path_peer --store ct.zarr --preset bone --edge 192 --grid grid.nrrd
//   path_peer --store grid.zarr --picture 1.f32 --size 128 --samples 64 --seed 1 --bounces 8 --albedo 0.8
//
// The grid has float32 extinctions per mm at the middles of its voxels, NRRD, x fastest. A picture is float32
// grey, top row first; its one light is directional and its phase function even. What else it is goes to
// stdout as JSON.
#include "core/base/error.h"
#include "render/picture/render_scene.h"
#include "tests/bench/path_baselines.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <glm/matrix.hpp>
#include <string>

namespace tessera::bench {
namespace {

void write(const std::string& path, const std::string& header, const std::vector<float>& values) {
    std::ofstream file(path, std::ios::binary);
    file << header;
    file.write(reinterpret_cast<const char*>(values.data()),
               static_cast<std::streamsize>(values.size() * sizeof(float)));
    if (!file.flush())
        throw Error(path + ": expected a file that can be written, found none");
}

std::string inBrackets(const glm::dvec3& v, char open, char close) {
    char text[120];
    std::snprintf(text, sizeof text, "%c%.9g,%.9g,%.9g%c", open, v.x, v.y, v.z, close);
    return text;
}
std::string vectorOf(const glm::dvec3& v) {
    return inBrackets(v, '(', ')');
}
std::string listOf(const glm::dvec3& v) {
    return inBrackets(v, '[', ']');
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

void writeGrid(const StoreReader& store, const std::string& preset, int edge, const std::string& path) {
    Budgets budgets;
    const PathBaseline volume(sceneOf(preset, store, 64, 1), store, budgets, 0);
    const VolumeInfo& info = store.info();
    const glm::ivec3 extent = glm::min(info.extentVoxels, glm::ivec3(edge));
    const glm::dvec3 pitch = glm::dvec3(info.extentVoxels) / glm::dvec3(extent);
    const glm::dmat3 axes(info.patientFromVoxel);
    const glm::dvec3 first(info.patientFromVoxel * glm::dvec4(0.5 * pitch, 1));
    std::string header = "NRRD0004\ntype: float\ndimension: 3\nspace: left-posterior-superior\nsizes:";
    for (int axis = 0; axis < 3; ++axis)
        header += " " + std::to_string(extent[axis]);
    header += "\nspace directions:";
    for (int axis = 0; axis < 3; ++axis)
        header += " " + vectorOf(pitch[axis] * axes[axis]);
    header += "\nkinds: domain domain domain\nendian: little\nencoding: raw\nspace origin: " +
              vectorOf(first) + "\n\n";
    write(path, header, volume.extinctions(extent));
}

void writePicture(const StoreReader& store, std::map<std::string, std::string>& options) {
    Budgets budgets;
    const double most = std::stod(options["--most"]), albedo = std::stod(options["--albedo"]);
    const auto linear = TransferFunction::fromExtinction({{0, 0}, {most, most}}, {{0, glm::dvec3(albedo)}});
    Scene scene =
        sceneOf(linear, store, std::stoi(options["--size"]), std::stoi(options["--bounces"]));
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
    write(options["--picture"], "", grey);
    const auto& camera = std::get<Camera>(scene.camera);
    const glm::dmat3 axes = patientFromCamera(camera);
    std::printf("{\"cpu\": %.3f, \"wall\": %.3f, \"lookUpsAPath\": %.1f, \"focal\": %s, \"right\": %s, \"up\": "
                "%s, \"back\": %s, \"height\": %.9g, \"towardsLight\": %s}\n",
                cpu, wall,
                static_cast<double>(result.work.paths.lookUps) /
                    static_cast<double>(std::max<std::uint64_t>(result.work.paths.paths, 1)),
                listOf(camera.focalPoint).c_str(), listOf(axes[0]).c_str(), listOf(axes[1]).c_str(),
                listOf(axes[2]).c_str(), 2 * camera.parallelScale,
                listOf(glm::normalize(axes * kLight)).c_str());
}

void run(int argc, char** argv) {
    auto options = parseOptions(argc, argv,
                                {{"--store", ""},
                                 {"--grid", ""}, // a file to write; and of it:
                                 {"--preset", "bone"},
                                 {"--edge", "192"}, // voxels along an axis, at most
                                 {"--picture", ""}, // a file to write; and of it:
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
        writeGrid(store, options["--preset"], std::stoi(options["--edge"]), options["--grid"]);
    if (!options["--picture"].empty())
        writePicture(store, options);
}

} // namespace
} // namespace tessera::bench

int main(int argc, char** argv) {
    return tessera::bench::runMain("path_peer", tessera::bench::run, argc, argv);
}
