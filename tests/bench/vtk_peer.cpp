// tests/bench/vtk_peer.cpp: a plain scene drawn by Tessera's march, with each integrator, and by VTK's two
// volume mappers in one interleaved run, and how far each is from the true integral: time at equal error,
// never at equal step.
//
//   xvfb-run -a vtk_peer --scene SCENE.json --rounds 5 --csv build/bench-results/vtk_peer.csv
//   xvfb-run -a vtk_peer --store build/bench-data/torso-thorax.zarr --rounds 5       (the thorax-sized torso)
//
// Same camera, same points of the transfer function (linear in opacity per unit distance and in RGB, linear
// light), same trilinear field, black background. VTK hands out 8 bits a channel, so the comparison is made
// on pictures rounded to 8 bits, Tessera's too; Tessera's errors before rounding are columns of their own.
// The CSV is what `tessera accuracy SCENE.json --peers FILE.csv` reads.
// --shifts 1 also measures against references moved by half a pixel: a disagreement about pixel centres would
// show there.
#include "tests/bench/bench_tools.h"
#include "tests/bench/vtk_renderer.h"

#include "core/error.h"
#include "core/image_metrics.h"
#include "render/features.h"
#include "render/march.h"
#include "render/ray.h"
#include "render/reference.h"
#include "viewer/accuracy/work_precision.h"

#include <algorithm>
#include <cmath>
#include <condition_variable>
#include <cstdio>
#include <cstring>
#include <exception>
#include <functional>
#include <glm/matrix.hpp>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <sstream>
#include <thread>

namespace tessera::bench {
namespace {

/// A thread that owns Tessera's GL context: EGL and VTK's GLX cannot both be current on one.
class GlThread {
  public:
    GlThread()
        : thread_([this](const std::stop_token& stop) {
              std::unique_lock lock(mutex_);
              while (wake_.wait(lock, stop, [this] { return job_ != nullptr; })) {
                  try {
                      (*job_)();
                  } catch (...) {
                      failure_ = std::current_exception();
                  }
                  job_ = nullptr;
                  done_.notify_one();
              }
          }) {}
    /// Runs the job there and waits; rethrows what it threw.
    void run(const std::function<void()>& job) {
        std::unique_lock lock(mutex_);
        job_ = &job;
        wake_.notify_one();
        done_.wait(lock, [this] { return job_ == nullptr; });
        if (failure_)
            std::rethrow_exception(std::exchange(failure_, nullptr));
    }

  private:
    std::mutex mutex_;
    std::condition_variable_any wake_;
    std::condition_variable done_;
    const std::function<void()>* job_ = nullptr;
    std::exception_ptr failure_;
    std::jthread thread_; // last: it uses all of the above
};

/// Every level-0 voxel, for VTK, which holds volumes whole.
std::vector<std::byte> wholeVolume(const StoreReader& store) {
    const VolumeInfo& info = store.info();
    const std::size_t valueBytes = bytesPerValue(info.type);
    std::vector<std::byte> voxels(static_cast<std::size_t>(info.voxelCount()) * valueBytes);
    std::vector<std::byte> chunk(store.chunkBytes());
    const glm::ivec3 grid = chunkGrid(info.extentVoxels, 0);
    for (std::size_t n = 0; n < cellCount(grid); ++n) {
        const auto flat = static_cast<int>(n);
        const glm::ivec3 at(flat % grid.x, flat / grid.x % grid.y, flat / (grid.x * grid.y));
        store.readChunk({0, at.x, at.y, at.z}, chunk);
        const glm::ivec3 low = at * kChunkExtent,
                         size = glm::min(info.extentVoxels - low, glm::ivec3(kChunkExtent));
        for (int z = 0; z < size.z; ++z)
            for (int y = 0; y < size.y; ++y)
                std::memcpy(voxels.data() +
                                linearIndex(low + glm::ivec3(0, y, z), info.extentVoxels) * valueBytes,
                            chunk.data() + linearIndex({0, y, z}, glm::ivec3(kChunkExtent)) * valueBytes,
                            static_cast<std::size_t>(size.x) * valueBytes);
    }
    return voxels;
}

Image roundedTo8Bits(Image image) {
    for (glm::vec4& pixel : image.pixels)
        pixel = glm::round(glm::clamp(pixel, 0.0f, 1.0f) * 255.0f) / 255.0f;
    return image;
}

/// True where a ray runs through the outermost half voxel of a side that it does not enter by facing it.
/// VTK's volume ends at voxel centres, ours at voxel faces: there the two differ by definition.
bool grazesBorder(const ReferenceRay& ray, const VolumeInfo& info) {
    const glm::dvec3 extent(info.extentVoxels), along = glm::abs(ray.direction);
    double t0 = 0, t1 = 0;
    if (!clipToBox(RayLine<double>{ray.base, ray.direction, ray.tMin, 1}, extent, t0, t1))
        return true;
    for (int axis = 0; axis < 3; ++axis) {
        if (along[axis] == std::max({along.x, along.y, along.z}))
            continue;
        const double a = ray.base[axis] + t0 * ray.direction[axis];
        const double b = ray.base[axis] + t1 * ray.direction[axis];
        if (std::min(a, b) < 0.5 || std::max(a, b) > extent[axis] - 0.5)
            return true;
    }
    return false;
}

/// The pixels of thinned(), by the reference; shift moves the ray inside each pixel.
/// @param border  if not null: where grazesBorder()
Image referenceImage(BrickCache& cache, const PreparedScene& p, const glm::ivec2& size, int stride,
                     const glm::dvec2& shift, std::vector<bool>* border) {
    const VolumeInfo& info = p.info();
    const RayPlane plane = rayPlane(p.camera, info, size);
    const glm::dmat4 voxelFromPatient = glm::inverse(info.patientFromVoxel);
    Image out(thinnedSize(size, stride));
    std::vector<ReferenceRay> rays;
    for (int y = 0; y < out.size.y; ++y)
        for (int x = 0; x < out.size.x; ++x) {
            const glm::dvec2 pixel = glm::dvec2(thinnedPixel({x, y}, size, stride)) + 0.5 + shift;
            const PatientRay ray = pixelRay(plane, pixel, size);
            rays.push_back({glm::dvec3(voxelFromPatient * glm::dvec4(ray.base, 1)),
                            glm::dmat3(voxelFromPatient) * ray.direction,
                            std::max(ray.minT, -std::numeric_limits<double>::max())});
        }
    if (border)
        for (const ReferenceRay& ray : rays)
            border->push_back(grazesBorder(ray, info));
    Shading off;
    off.on = false;
    const ReferenceInput input{&cache, &info, &p.function, off, &p.statistics};
    const std::vector<glm::dvec4> values = renderReference(input, rays, 0);
    std::transform(values.begin(), values.end(), out.pixels.begin(),
                   [](const glm::dvec4& v) { return glm::vec4(v); });
    return out;
}

/// The picture, black and transparent where left out: such pixels are in no error.
Image without(Image image, const std::vector<bool>& leftOut) {
    for (std::size_t i = 0; i < image.pixels.size(); ++i)
        if (leftOut[i])
            image.pixels[i] = glm::vec4(0);
    return image;
}

/// One renderer at one sample distance.
struct Method {
    std::string family;
    double distanceVoxels = 0;
    bool tessera = false;           // then it is known before rounding too
    std::function<double()> draw;   // milliseconds
    std::function<Image()> picture; // of the last draw
    std::vector<double> ms;
    Image pixels;                  // thinned, as it came
    ImageDifference asIs, rounded; // against the reference, without the border
    double rmsWithBorder = 0;      // rounded
    Work work;                     // Tessera's only
};

/// A family's envelope: error of 8-bit pictures, least time.
std::vector<accuracy::WorkPoint> envelopeOf(const std::vector<Method>& methods, const std::string& family) {
    std::vector<accuracy::WorkPoint> points;
    for (std::size_t i = 0; i < methods.size(); ++i)
        if (methods[i].family == family)
            points.push_back({methods[i].rounded.rms, minimum(methods[i].ms), i});
    return accuracy::paretoEnvelope(std::move(points));
}

void printTables(const std::vector<Method>& methods, const std::vector<std::string>& families) {
    std::printf("\n| renderer | distance, voxels | min ms | median ms | rms 8 bit | max | L*u*v* p99 | with "
                "border | rms float |\n"
                "|---|---|---|---|---|---|---|---|---|\n");
    for (const Method& m : methods) {
        std::printf("| %s | %g | %.0f | %.0f | %.5f | %.3f | %.2f | %.5f | ", m.family.c_str(),
                    m.distanceVoxels, minimum(m.ms), median(m.ms), m.rounded.rms, m.rounded.maxAbs,
                    m.rounded.luvP99, m.rmsWithBorder);
        if (m.tessera)
            std::printf("%.6f |\n", m.asIs.rms);
        else
            std::printf("n/a |\n");
    }
    std::printf(
        "\nMinimum ms at equal error (rms of 8-bit pictures), interpolated, not extrapolated:\n\n| rms |");
    for (const std::string& family : families)
        std::printf(" %s |", family.c_str());
    std::printf("\n|---|");
    for (std::size_t i = 0; i < families.size(); ++i)
        std::printf("---|");
    std::vector<double> targets = {0.02, 0.01, 1.0 / 255, 0.002, 0.0015};
    for (const Method& m : methods)
        if (!m.tessera)
            targets.push_back(m.rounded.rms);
    std::sort(targets.rbegin(), targets.rend());
    for (const double target : targets) {
        std::printf("\n| %.5f |", target);
        for (const std::string& family : families)
            if (const auto ms = accuracy::timeAtError(envelopeOf(methods, family), target))
                std::printf(" %.0f |", *ms);
            else
                std::printf(" not reached |");
    }
    std::printf("\n");
}

struct RunOn {
    std::string scene, tesseraDevice, vtkDevice;
    double loadBefore = 0;
};

/// Errors are those of 8-bit pictures, by which all can be compared; "_float" is before rounding.
void writeCsv(const std::string& path, const std::vector<Method>& methods, const RunOn& on) {
    std::FILE* file = std::fopen(path.c_str(), "w");
    if (!file)
        throw InputError(path + ": expected a file that can be written");
    std::fprintf(file, "scene,renderer,distance_voxels,time_min_ms,time_med_ms,rmse,max_abs,dE_uv_p99,"
                       "rmse_float,max_abs_float,dE_uv_p99_float,bias,dE_uv_mean,rmse_with_border,"
                       "masked_pixels,rounds,segments,samples,fetches,load_before,load_after,device\n");
    for (const Method& m : methods) {
        std::string device = m.tessera ? on.tesseraDevice : on.vtkDevice;
        std::replace(device.begin(), device.end(), ',', ';');
        std::fprintf(file, "%s,%s,%g,%.2f,%.2f,%.6f,%.5f,%.4f,", on.scene.c_str(), m.family.c_str(),
                     m.distanceVoxels, minimum(m.ms), median(m.ms), m.rounded.rms, m.rounded.maxAbs,
                     m.rounded.luvP99);
        if (m.tessera)
            std::fprintf(file, "%.3e,%.3e,%.5f,", m.asIs.rms, m.asIs.maxAbs, m.asIs.luvP99);
        else
            std::fprintf(file, "n/a,n/a,n/a,");
        std::fprintf(
            file, "%.6f,%.4f,%.6f,%zu,%zu,%llu,%llu,%llu,%.2f,%.2f,%s\n", m.rounded.bias, m.rounded.luvMean,
            m.rmsWithBorder, m.rounded.maskedPixels, m.ms.size(),
            static_cast<unsigned long long>(m.work.segments), static_cast<unsigned long long>(m.work.samples),
            static_cast<unsigned long long>(m.work.fetches), on.loadBefore, loadAverage(), device.c_str());
    }
    std::fclose(file);
}

/// What both programs can draw alike; throws InputError where they cannot.
Scene comparableScene(std::map<std::string, std::string>& options) {
    Scene scene;
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

std::vector<std::string> splitAtCommas(const std::string& text) {
    std::vector<std::string> out;
    std::istringstream parts(text);
    for (std::string part; std::getline(parts, part, ',');)
        out.push_back(part);
    return out;
}

/// Tessera with one integrator and one way to fetch.
struct Variant {
    Integrator integrator;
    Fetch fetch;
    std::string name() const {
        return "tessera " + integratorNames()[static_cast<std::size_t>(integrator)] +
               (fetch == Fetch::exact ? " exact" : "");
    }
};
std::vector<Variant> parseVariants(const std::string& integrators, const std::string& fetches) {
    std::vector<Variant> out;
    for (const std::string& fetch : splitAtCommas(fetches))
        for (const std::string& integrator : splitAtCommas(integrators)) {
            out.push_back({parseIntegrator(integrator, "--integrators"), parseFetch(fetch, "--fetch")});
            if (out.back().integrator == Integrator::automatic)
                throw InputError("--integrators: expected the names of integrators, found " + integrator);
        }
    return out;
}

/// A scene on the device, drawn with any integrator and step.
class TesseraScene {
  public:
    TesseraScene(const Scene& scene, const StoreReader& store, const std::string& device, Budgets& budgets)
        : scene_(scene), budgets_(budgets), context_(GlDeviceChoice{device}),
          onDevice_(scene, store, context_, budgets) {}

    const PreparedScene& prepared() const { return onDevice_.prepared(); }
    std::string device() const { return context_.renderer(); }
    /// The tables are made beforehand: they are a scene's, not a frame's.
    Optics optics(Integrator integrator, double stepVoxels) const {
        const PreparedScene& p = prepared();
        Optics optics = makeOptics(p.table, p.info(), scene_.shading, scene_.quality.terminationTransmittance,
                                   integrator);
        const double voxelMm = std::cbrt(std::abs(glm::determinant(glm::dmat3(p.info().patientFromVoxel))));
        prepareSeenColours(optics, stepVoxels * voxelMm, 0, 1);
        return optics;
    }
    double draw(const Optics& optics, double stepVoxels, Fetch fetch, bool counting, Image& picture,
                Work& work) {
        const PreparedScene& p = prepared();
        std::uint32_t features = onDevice_.features(fetch) & ~kIntegratorFeatures;
        features |= integratorFeatures(optics.integrator) | (counting ? kFeatureCounting : 0u);
        const Occupancy* occupancy = (features & kFeatureSkipping) ? &p.occupancy : nullptr;
        Strides strides = p.strides();
        strides.segmentVoxels = stepVoxels;
        March march(features, rayFrame(p.camera, p.info(), scene_.imageSize, stepVoxels), p.info(), strides,
                    optics, occupancy, budgets_.gpu);
        work = {};
        march.run({&onDevice_.atlas(), nullptr, p.selection.finest()}, MarchSlicing{}, work);
        const auto reading = Clock::now();
        picture = march.image();
        return work.marchMs + msSince(reading);
    }

  private:
    Scene scene_;
    Budgets& budgets_;
    GlContext context_;
    SceneOnDevice onDevice_;
};

void run(int argc, char** argv) {
    auto options = parseOptions(argc, argv,
                                {{"--scene", ""},
                                 {"--store", "build/bench-data/torso-thorax.zarr"},
                                 {"--phantom", "512x512x749"},
                                 {"--preset", "bone"},
                                 {"--size", ""},
                                 {"--rounds", "6"},
                                 {"--stride", "4"},
                                 {"--distances", "2,1,0.5,0.25"},
                                 {"--integrators", "midpoint,linear,pre-integrated,pre-integrated-2d"},
                                 {"--fetch", "hardware"},
                                 {"--device", "software"},
                                 {"--shifts", "0"},
                                 {"--csv", ""}});
    const auto number = [&](const char* option) {
        return static_cast<int>(std::atof(options[option].c_str()));
    };
    Scene scene = comparableScene(options);
    const glm::ivec2 size = scene.imageSize;
    const int stride = static_cast<int>(parseNumbers(options["--stride"], "--stride").at(0));
    const std::vector<Variant> variants = parseVariants(options["--integrators"], options["--fetch"]);

    Budgets budgets;
    const StoreReader store(scene.volumes.at(0).path, budgets.ram);
    const VolumeInfo& info = store.info();
    if (const auto* view = std::get_if<FittedView>(&scene.camera)) // for this size
        scene.camera = fitCamera(info, view->view, view->projection, size);

    GlThread glThread;
    std::optional<TesseraScene> tessera;
    glThread.run([&] { tessera.emplace(scene, store, options["--device"], budgets); });
    const PreparedScene& p = tessera->prepared();
    if (p.selection.finest() != 0)
        throw Error("the volume does not fit the device at full resolution");
    const std::vector<std::byte> voxels = wholeVolume(store);
    VtkRenderer cpu(VtkMapper::cpu, info, voxels, p.function, p.camera, size);
    VtkRenderer gpu(VtkMapper::gpu, info, voxels, p.function, p.camera, size);
    // VTK counts in mm along the ray, Tessera in voxels; between anisotropic voxels the mean is as fair as
    // any.
    const glm::dvec3 spacing = info.spacingMm();
    const double voxelMm = std::cbrt(spacing.x * spacing.y * spacing.z);

    std::vector<std::string> families;
    for (const Variant& variant : variants)
        families.push_back(variant.name());
    families.insert(families.end(), {"vtk cpu", "vtk gpu"});
    std::vector<Method> methods;
    Image last; // of Tessera
    for (const double d : parseNumbers(options["--distances"], "--distances")) {
        for (const Variant& variant : variants) {
            Method m;
            m.family = variant.name();
            m.distanceVoxels = d;
            m.tessera = true;
            const auto optics = std::make_shared<const Optics>(tessera->optics(variant.integrator, d));
            m.draw = [&glThread, &tessera, &last, d, fetch = variant.fetch, optics] {
                double ms = 0;
                Work work;
                glThread.run([&] { ms = tessera->draw(*optics, d, fetch, false, last, work); });
                return ms;
            };
            m.picture = [&last] { return last; };
            glThread.run([&] { tessera->draw(*optics, d, variant.fetch, true, last, m.work); });
            methods.push_back(std::move(m));
        }
        for (VtkRenderer* vtk : {&cpu, &gpu}) {
            Method m;
            m.family = vtk == &cpu ? "vtk cpu" : "vtk gpu";
            m.distanceVoxels = d;
            m.draw = [vtk, d, voxelMm] { return vtk->drawMs(d * voxelMm); };
            m.picture = [vtk] { return vtk->picture(); };
            methods.push_back(std::move(m));
        }
    }
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
    std::vector<bool> border;
    const Image all = referenceImage(cache, p, size, stride, glm::dvec2(0), &border);
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
    on.tesseraDevice = tessera->device();
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

    if (number("--shifts")) {
        std::printf("\nrms against a reference whose rays are moved, pixels right and down:\n\n| moved |");
        const double finest = methods.back().distanceVoxels; // the last of a sorted family
        for (const std::string& family : families)
            std::printf(" %s |", family.c_str());
        std::printf("\n|---|---|---|---|---|");
        for (const glm::dvec2 shift : {glm::dvec2(0, 0),
                                       {0.5, 0},
                                       {-0.5, 0},
                                       {0, 0.5},
                                       {0, -0.5},
                                       {0.5, 0.5},
                                       {-0.5, -0.5},
                                       {0.5, -0.5},
                                       {-0.5, 0.5}}) {
            const Image moved = without(referenceImage(cache, p, size, stride, shift, nullptr), border);
            std::printf("\n| %g, %g |", shift.x, shift.y);
            for (const std::string& family : families)
                for (const Method& m : methods)
                    if (m.family == family && m.distanceVoxels == finest)
                        std::printf(" %.5f |", compare(roundedTo8Bits(m.pixels), moved).rms);
        }
        std::printf("\n");
    }
    glThread.run([&] { tessera.reset(); });
}

} // namespace
} // namespace tessera::bench

int main(int argc, char** argv) {
    return tessera::bench::runMain("vtk_peer", tessera::bench::run, argc, argv);
}
