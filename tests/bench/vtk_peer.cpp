// tests/bench/vtk_peer.cpp: a plain scene drawn by Tessera's GPU ray caster, with each integrator, and by
// VTK's two volume mappers in one interleaved run. It measures each one's distance to the true integral: time
// at equal error, never at equal step.
//
//   xvfb-run -a vtk_peer --scene SCENE.json --rounds 5 --csv build/bench-results/vtk_peer.csv
//   xvfb-run -a vtk_peer --store build/bench-data/torso-thorax.zarr --rounds 5       (the thorax-sized torso)
//   xvfb-run -a vtk_peer --scene SCENE.json --vtk-only 1 --csv PEERS.csv   (for `tessera accuracy --peers`)
//
// Same camera, same points of the transfer function (linear in opacity per unit distance and in RGB, linear
// light), same trilinear field, black background. VTK hands out 8 bits a channel, so the comparison is made
// on pictures rounded to 8 bits, Tessera's too; Tessera's errors before rounding are columns of their own.
// The CSV is what `tessera accuracy --peers FILE.csv` reads. With --vtk-only 1 Tessera is left to that
// command: VTK and the reference alone run, and VTK's names say how much memory its whole volume takes.
// --shifts 1 also measures against references moved by half a pixel: a disagreement about pixel centres would
// show there.
#include "core/base/error.h"
#include "core/image/image_metrics.h"
#include "render/plan/planner.h"
#include "tests/bench/bench_tools.h"
#include "tests/bench/gl_thread.h"
#include "tests/bench/peer_tables.h"
#include "tests/bench/peer_truth.h"
#include "tests/bench/tessera_peer.h"
#include "tests/bench/vtk_renderer.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <iterator>
#include <map>
#include <memory>
#include <optional>

namespace tessera::bench {
namespace {

constexpr int kComparedExtent = 128; // pixels an axis, at most

/// The scene that both programs can draw alike; throws InputError if they cannot.
Scene comparableScene(std::map<std::string, std::string>& options) {
    Scene scene;
    scene.camera = FittedView{View::anterior, Projection::perspective, Fit::volume};
    const std::string& file = options["--scene"];
    if (file.empty()) {
        ensurePhantomStore(options["--store"], "torso", parseExtent(options["--phantom"], "--phantom"));
        scene.volumes = {{options["--store"], options["--preset"]}};
        scene.shading.on = false;
        scene.imageSize = glm::ivec2(512);
    } else {
        scene = loadScene(file);
        // VTK's normals are differences over two voxels, and 12-bit codes of these in the CPU mapper; a lit
        // picture would compare these and not the integrals.
        if (scene.shading.on)
            throw InputError(file +
                             ": expected a plain scene (\"shade\": false), because the two do not take "
                             "normals alike");
        if (!scene.surfaces.empty())
            throw InputError(file + ": expected a scene without surfaces, which VTK's mappers do not mix in");
    }
    if (!options["--size"].empty())
        scene.imageSize = glm::ivec2(static_cast<int>(parseNumbers(options["--size"], "--size").at(0)));
    return scene;
}

/// Tessera's frames at every distance; they all leave their picture in `last`.
std::vector<Method> tesseraMethods(TesseraScene& tessera, GlThread& glThread, const Variant& variant,
                                   const std::vector<double>& distances, Image& last) {
    std::vector<Method> methods;
    for (const double d : distances) {
        Method m;
        m.family = variant.name();
        m.distanceVoxels = d;
        m.tessera = true;
        const auto optics = std::make_shared<const Optics>(tessera.optics(variant.integrator, d));
        m.draw = [&glThread, &tessera, &last, d, fetch = variant.fetch, optics] {
            double ms = 0;
            Work work;
            glThread.run([&] { ms = tessera.draw(*optics, d, fetch, false, last, work); });
            return ms;
        };
        m.picture = [&last] { return last; };
        glThread.run([&] { tessera.draw(*optics, d, variant.fetch, true, last, m.work); });
        methods.push_back(std::move(m));
    }
    return methods;
}

std::vector<Method> vtkMethods(VtkRenderer& vtk, const std::string& family,
                               const std::vector<double>& distances, double voxelMm) {
    std::vector<Method> methods;
    for (const double d : distances) {
        Method m;
        m.family = family;
        m.distanceVoxels = d;
        m.draw = [&vtk, d, voxelMm] { return vtk.drawMs(d * voxelMm); };
        m.picture = [&vtk] { return vtk.picture(); };
        methods.push_back(std::move(m));
    }
    return methods;
}

/// Errors of every family's finest pictures against references whose rays are moved.
void printShifts(const std::vector<Method>& methods, const std::vector<std::string>& families,
                 const std::function<Image(const glm::dvec2&)>& moved) {
    std::printf("\nrms against a reference whose rays are moved, pixels right and down:\n\n| moved |");
    const double finest = methods.back().distanceVoxels; // the last of a sorted family
    for (const std::string& family : families)
        std::printf(" %s |", family.c_str());
    std::printf("\n|---|");
    for (std::size_t i = 0; i < families.size(); ++i)
        std::printf("---|");
    for (const glm::dvec2 shift : {glm::dvec2(0, 0),
                                   {0.5, 0},
                                   {-0.5, 0},
                                   {0, 0.5},
                                   {0, -0.5},
                                   {0.5, 0.5},
                                   {-0.5, -0.5},
                                   {0.5, -0.5},
                                   {-0.5, 0.5}}) {
        const Image truth = moved(shift);
        std::printf("\n| %g, %g |", shift.x, shift.y);
        for (const std::string& family : families)
            for (const Method& m : methods)
                if (m.family == family && m.distanceVoxels == finest)
                    std::printf(" %.5f |", compare(roundedTo8Bits(m.pixels), truth).rms);
    }
    std::printf("\n");
}

void run(int argc, char** argv) {
    auto options = parseOptions(argc, argv,
                                {{"--scene", ""},
                                 {"--store", "build/bench-data/torso-thorax.zarr"},
                                 {"--phantom", "512x512x749"},
                                 {"--preset", "bone-1"},
                                 {"--size", ""},
                                 {"--rounds", "6"},
                                 {"--stride", ""},
                                 {"--distances", "2,1,0.5,0.25"},
                                 {"--integrators", "midpoint,linear,pre-integrated,pre-integrated-2d"},
                                 {"--fetch", "hardware"},
                                 {"--device", "software"},
                                 {"--vtk-only", "0"},
                                 {"--shifts", "0"},
                                 {"--csv", ""}});
    const auto number = [&](const char* option) {
        return static_cast<int>(std::atof(options[option].c_str()));
    };
    Scene scene = comparableScene(options);
    const glm::ivec2 size = scene.imageSize;
    // Else as many pixels as `tessera accuracy` compares.
    const int stride = options["--stride"].empty()
                           ? (std::max(size.x, size.y) + kComparedExtent - 1) / kComparedExtent
                           : static_cast<int>(parseNumbers(options["--stride"], "--stride").at(0));
    const bool vtkOnly = number("--vtk-only") != 0;

    Budgets budgets;
    const StoreReader store(scene.volumes.at(0).path, budgets.ram);
    const VolumeInfo& info = store.info();
    if (const auto* view = std::get_if<FittedView>(&scene.camera)) // for this size
        scene.camera = fitCamera(info, view->view, view->projection, size);

    GlThread glThread;
    std::optional<TesseraScene> tessera;
    std::optional<Planner> view; // if Tessera does not draw: the reference's input
    if (vtkOnly)
        view = planView(scene, store, budgets.ram, 0);
    else
        glThread.run([&] { tessera.emplace(scene, store, options["--device"], budgets); });
    const FramePlan& p = vtkOnly ? *view : tessera->prepared();
    if (!vtkOnly && p.layer().selection.finest() != 0)
        throw InputError("the volume does not fit the device at full resolution: expected --vtk-only 1");
    const std::vector<std::byte> voxels = wholeVolume(store);
    VtkRenderer cpu(VtkMapper::cpu, info, voxels, p.layer().function, scene.shading, p.view.camera, size);
    VtkRenderer gpu(VtkMapper::gpu, info, voxels, p.layer().function, scene.shading, p.view.camera, size);
    // VTK counts in mm along the ray, Tessera in voxels; between anisotropic voxels the mean is as fair as
    // any.
    const glm::dvec3 spacing = info.spacingMm();
    const double voxelMm = std::cbrt(spacing.x * spacing.y * spacing.z);

    std::vector<std::string> families;
    std::vector<Method> methods;
    const auto add = [&](const std::string& family, std::vector<Method> more) {
        families.push_back(family);
        std::move(more.begin(), more.end(), std::back_inserter(methods));
    };
    const std::vector<double> distances = parseNumbers(options["--distances"], "--distances");
    Image last; // of Tessera
    if (tessera)
        for (const Variant& variant : parseVariants(options["--integrators"], options["--fetch"]))
            add(variant.name(), tesseraMethods(*tessera, glThread, variant, distances, last));
    // Alone, VTK is compared with a Tessera that may have less memory: the name tells.
    const std::string memory = vtkOnly ? ", whole volume (" + formatBytes(voxels.size()) + ")" : "";
    add("vtk cpu" + memory, vtkMethods(cpu, "vtk cpu" + memory, distances, voxelMm));
    add("vtk gpu" + memory, vtkMethods(gpu, "vtk gpu" + memory, distances, voxelMm));
    std::sort(methods.begin(), methods.end(), [](const Method& a, const Method& b) {
        return std::pair(a.family, -a.distanceVoxels) < std::pair(b.family, -b.distanceVoxels);
    });

    // Warm-up: also where the pictures are taken. A second turn, because VTK's first frame uploads.
    for (Method& m : methods) {
        m.draw();
        m.pixels = thinned(m.picture(), stride);
    }
    BrickCache cache(store, budgets.ram, std::size_t{1} << 30, 0);
    const auto referenceStart = Clock::now();
    const std::vector<bool> border = borderPixels(p, size, stride);
    const Image all = referenceImage(cache, p, scene.shading, size, stride, glm::dvec2(0));
    const Image truth = without(all, border);
    const double referenceMs = msSince(referenceStart);
    for (Method& m : methods) {
        m.rmsWithBorder = compare(roundedTo8Bits(m.pixels), all).rms;
        m.pixels = without(m.pixels, border);
        m.asIs = compare(m.pixels, truth);
        m.rounded = compare(roundedTo8Bits(m.pixels), truth);
    }

    RunOn on;
    on.scene = options["--scene"].empty() ? "torso-" + options["--preset"]
                                          : std::filesystem::path(options["--scene"]).stem().string();
    on.tesseraDevice = tessera ? tessera->device() : "no device (--vtk-only)";
    on.vtkDevice = gpu.device();
    on.loadBefore = loadAverage();
    for (int round = 0; round < number("--rounds"); ++round)
        for (std::size_t i = 0; i < methods.size(); ++i) {
            Method& m = methods[round % 2 ? methods.size() - 1 - i : i];
            m.ms.push_back(m.draw());
        }

    std::printf(
        "volume %dx%dx%d, spacing %.4g x %.4g x %.4g mm, one voxel of distance = %.4g mm\n"
        "picture %dx%d, scene %s; errors on every %d. pixel of every %d. row: %zu pixels, %zu not "
        "black\nTessera on %s; VTK %s on %s\n%d rounds after one of warming up; load %.1f before, %.1f "
        "after; "
        "reference %.0f ms\n",
        info.extentVoxels.x, info.extentVoxels.y, info.extentVoxels.z, spacing.x, spacing.y, spacing.z,
        voxelMm, size.x, size.y, on.scene.c_str(), stride, stride, truth.pixels.size(),
        methods.front().rounded.maskedPixels, on.tesseraDevice.c_str(), VtkRenderer::version().c_str(),
        on.vtkDevice.c_str(), number("--rounds"), on.loadBefore, loadAverage(), referenceMs);
    printTables(methods, families);
    if (!options["--csv"].empty())
        writeCsv(options["--csv"], methods, on);

    if (number("--shifts"))
        printShifts(methods, families, [&](const glm::dvec2& shift) {
            return without(referenceImage(cache, p, scene.shading, size, stride, shift), border);
        });
    glThread.run([&] { tessera.reset(); });
}

} // namespace
} // namespace tessera::bench

int main(int argc, char** argv) {
    return tessera::bench::runMain("vtk_peer", tessera::bench::run, argc, argv);
}
