// tests/bench/lod/area_truth.cpp: see area_truth.h.
#include "tests/bench/lod/area_truth.h"

#include "bricking/store/store_reader.h"
#include "core/base/interrupt.h"
#include "core/base/progress.h"
#include "core/image/colour.h"
#include "core/image/image_metrics.h"
#include "render/backends/native/native_engine.h"
#include "render/backends/reference/reference_engine.h"
#include "render/picture/picture.h"
#include "render/picture/render_scene.h" // pictureBytesPerPixel
#include "render/plan/planner.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <memory>
#include <random>
#include <span>
#include <vector>

namespace tessera::bench {
namespace {

constexpr int kAcross = 16; // pixels of a row of the array of rays
constexpr float kShown = 1.0f / 255;
constexpr std::size_t kTruthBytes = std::size_t{4} << 30;

/// From 0 to below 1, the same with every compiler.
double unit(std::mt19937_64& random) {
    return static_cast<double>(random() >> 11) * 0x1p-53;
}

Scene truthScene(const Scene& scene, double stepVoxels) {
    Scene truth = scene;
    truth.quality.stepVoxels = stepVoxels;
    truth.quality.automaticStep = false;
    truth.quality.fetch = Fetch::exact;
    truth.quality.terminationTransmittance = 0;
    truth.quality.maxError = 0;
    truth.quality.pixels.samples = 1; // places are given ray by ray
    return truth;
}

/// A scene on an engine, with all bricks at the finest level; draws pixels' means over their areas.
class AreaCaster {
  public:
    AreaCaster(const Scene& scene, Engine& engine, EngineKind kind, MemoryBudget& ram, MemoryBudget& gpu)
        : engine_(engine), store_(scene.volumes.front().path, ram),
          plan_(planScene(scene, store_, engine.limits(), {ram, gpu, 0}, LevelChoice::finest,
                          pictureBytesPerPixel(kind))),
          size_(scene.imageSize) {
        Work work;
        const bool passes = loadBricks(engine, plan_, gpu, work);
        caster_ = engine.caster({false, false, passes}, gpu);
    }
    ~AreaCaster() {
        caster_.reset();
        engine_.close();
    }
    AreaCaster(const AreaCaster&) = delete;
    AreaCaster& operator=(const AreaCaster&) = delete;

    /// Pixels whose rays are no more than the picture's own.
    std::size_t atOnce(int side) const {
        const std::size_t pixels = rayCount(size_) / static_cast<std::size_t>(side * side);
        return std::max<std::size_t>(kAcross, pixels / kAcross * kAcross);
    }

    /// Each half of the samples is stratified by itself, with one sample anywhere in each cell of a grid. The
    /// cells are twice as high as wide in one half, and twice as wide as high in the other.
    struct Mean {
        glm::vec4 all{0}, half[2] = {glm::vec4(0), glm::vec4(0)};
    };
    /// At most atOnce() of them.
    std::vector<Mean> means(std::span<const glm::ivec2> pixels, int side, std::mt19937_64& random) {
        const int rows = (static_cast<int>(pixels.size()) + kAcross - 1) / kAcross;
        Rays rays = raysOf(plan_);
        rays.arraySize = {kAcross * side, rows * side};
        std::vector<glm::vec2> places(rayCount(rays.arraySize), glm::vec2(pixels.back()) + 0.5f);
        const auto slot = [&](std::size_t n, int x, int y) {
            const int column = static_cast<int>(n) % kAcross * side + x,
                      row = static_cast<int>(n) / kAcross * side + y;
            return static_cast<std::size_t>(row) * static_cast<std::size_t>(rays.arraySize.x) +
                   static_cast<std::size_t>(column);
        };
        for (std::size_t n = 0; n < pixels.size(); ++n)
            for (int y = 0; y < side; ++y)
                for (int x = 0; x < side; ++x) {
                    const bool wide = 2 * y >= side;
                    const int k = (wide ? y - side / 2 : y) * side + x, columns = wide ? side / 2 : side,
                              rowsOfHalf = wide ? side : side / 2;
                    const double right = (k % columns + unit(random)) / columns;
                    const double down = (k / columns + unit(random)) / rowsOfHalf;
                    places[slot(n, x, y)] = glm::vec2(glm::dvec2(pixels[n]) + glm::dvec2(right, down));
                }
        rays.places = places;
        caster_->begin(rays);
        Work work;
        drawToTheEnd(*caster_, engine_, plan_, Slicing{}, work);
        const Image drawn = caster_->image();
        std::vector<Mean> out(pixels.size());
        const double cells = static_cast<double>(side) * side;
        for (std::size_t n = 0; n < pixels.size(); ++n) {
            glm::dvec4 half[2] = {glm::dvec4(0), glm::dvec4(0)};
            for (int y = 0; y < side; ++y)
                for (int x = 0; x < side; ++x)
                    half[2 * y >= side] += glm::dvec4(drawn.pixels[slot(n, x, y)]);
            out[n].all = glm::vec4((half[0] + half[1]) / cells);
            for (int h = 0; h < 2; ++h)
                out[n].half[h] = glm::vec4(half[h] / (0.5 * cells));
        }
        return out;
    }

  private:
    Engine& engine_;
    StoreReader store_;
    Planner plan_;
    glm::ivec2 size_;
    std::unique_ptr<RayCaster> caster_;
};

glm::dvec3 luvOf(const glm::vec4& pixel) {
    return luvFromLinear(glm::clamp(glm::dvec3(pixel), glm::dvec3(0.0), glm::dvec3(1.0)));
}

/// The possible error of a pixel's mean, L*u*v*.
double noiseOf(const Image (&halves)[2], const glm::ivec2& at) {
    return 0.5 * glm::length(luvOf(halves[0].at(at.x, at.y)) - luvOf(halves[1].at(at.x, at.y)));
}

/// Draws means, and hands each over with its number.
template <typename Take>
void drawMeans(AreaCaster& caster, const std::vector<glm::ivec2>& pixels, int side, std::mt19937_64& random,
               const Take& take) {
    const std::size_t atOnce = caster.atOnce(side);
    for (std::size_t first = 0; first < pixels.size(); first += atOnce) {
        checkInterrupted();
        const auto some = std::span(pixels).subspan(first, std::min(atOnce, pixels.size() - first));
        const auto means = caster.means(some, side, random);
        for (std::size_t n = 0; n < means.size(); ++n)
            take(first + n, means[n]);
    }
}

/// Means of some pixels as a picture of one row.
Image rowOf(AreaCaster& caster, const std::vector<glm::ivec2>& pixels, int side, std::uint64_t seed) {
    std::mt19937_64 random(seed);
    Image row(glm::ivec2(static_cast<int>(pixels.size()), 1));
    drawMeans(caster, pixels, side, random,
              [&](std::size_t n, const AreaCaster::Mean& mean) { row.pixels[n] = mean.all; });
    return row;
}

/// Some of the pixels that show something, all as likely.
std::vector<glm::ivec2> someShown(const Image& image, int count, std::mt19937_64& random) {
    std::vector<glm::ivec2> shown, some;
    for (int y = 0; y < image.size.y; ++y)
        for (int x = 0; x < image.size.x; ++x)
            if (image.at(x, y).a > kShown)
                shown.emplace_back(x, y);
    while (!shown.empty() && some.size() < static_cast<std::size_t>(count)) {
        const auto n = static_cast<std::size_t>(unit(random) * static_cast<double>(shown.size()));
        some.push_back(shown[n]);
        shown[n] = shown.back();
        shown.pop_back();
    }
    return some;
}

/// All but the comparison with the reference.
void drawTruth(AreaCaster& caster, const AreaTruthEffort& effort, std::mt19937_64& random, AreaTruth& truth) {
    const glm::ivec2 size = truth.means.size;
    std::vector<glm::ivec2> pixels, noisy;
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x)
            pixels.emplace_back(x, y);
    Image(&halves)[2] = truth.halves;
    halves[0] = halves[1] = Image(size);
    const auto draw = [&](const std::vector<glm::ivec2>& some, int side) {
        drawMeans(caster, some, side, random, [&](std::size_t n, const AreaCaster::Mean& mean) {
            truth.means.at(some[n].x, some[n].y) = mean.all;
            for (int h = 0; h < 2; ++h)
                halves[h].at(some[n].x, some[n].y) = mean.half[h];
        });
    };
    draw(pixels, effort.side);
    for (const glm::ivec2& at : pixels)
        if (noiseOf(halves, at) > effort.noisy)
            noisy.push_back(at);
    draw(noisy, 2 * effort.side);
    truth.noisy = noisy.size();
    const ImageDifference noise = compare(halves[0], halves[1]);
    truth.noiseLuvP99 = 0.5 * noise.luvP99;
    truth.shown = noise.maskedPixels;
}

} // namespace

ImageDifference differenceTo(const AreaTruth& truth, const Image& image) {
    ImageDifference d = compare(image, truth.means);
    double noise = 0, once = 0, twice = 0;
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
        if (!(truth.means.pixels[i].a > kShown))
            continue;
        const glm::dvec4 between =
            0.5 * (glm::dvec4(truth.halves[0].pixels[i]) - glm::dvec4(truth.halves[1].pixels[i]));
        noise += glm::dot(between, between);
        const glm::dvec3 is = luvOf(image.pixels[i]);
        once += glm::length(is - luvOf(truth.means.pixels[i]));
        for (const Image& half : truth.halves)
            twice += 0.5 * glm::length(is - luvOf(half.pixels[i]));
    }
    if (d.maskedPixels == 0)
        return d;
    const double count = static_cast<double>(d.maskedPixels);
    d.rms = std::sqrt(std::max(0.0, d.rms * d.rms - noise / (4 * count)));
    d.luvMean = std::sqrt(std::max(0.0, 2 * once * once - twice * twice)) / count;
    return d;
}

AreaTruth areaTruth(const Scene& scene, const AreaTruthEffort& effort, std::size_t ramBytes) {
    AreaTruth truth;
    truth.means = Image(scene.imageSize);
    const Scene asItIs = truthScene(scene, effort.stepVoxels);
    std::vector<glm::ivec2> chosen; // for the reference
    Image native;
    const auto start = std::chrono::steady_clock::now();
    {
        std::mt19937_64 random(effort.seed);
        MemoryBudget ram("RAM", "--ram", ramBytes), gpu("GPU memory", "--gpu-memory", kTruthBytes);
        NativeEngine engine(0, gpu, ram);
        AreaCaster caster(asItIs, engine, EngineKind::native, ram, gpu);
        drawTruth(caster, effort, random, truth);
        chosen = someShown(truth.means, effort.referencePixels, random);
        native = rowOf(caster, chosen, effort.referenceSide, effort.seed + 1);
    }
    truth.secondsNative = secondsSince(start);
    truth.referencePixels = static_cast<int>(chosen.size());
    if (chosen.empty())
        return truth;
    const auto second = std::chrono::steady_clock::now();
    MemoryBudget ram("RAM", "--ram", ramBytes), gpu("GPU memory", "--gpu-memory", kTruthBytes);
    ReferenceEngine engine(0);
    AreaCaster caster(asItIs, engine, EngineKind::reference, ram, gpu);
    const Image reference = rowOf(caster, chosen, effort.referenceSide, effort.seed + 1);
    const ImageDifference off = compare(native, reference);
    truth.referenceLuvP99 = off.luvP99;
    truth.referenceRms = off.rms;
    truth.secondsReference = secondsSince(second);
    return truth;
}

} // namespace tessera::bench
