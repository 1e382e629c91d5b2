// render/picture/explain.cpp: the text about the contents of a picture and the parts left out (renderer.h).
#include "core/base/shown_text.h"
#include "render/backends/gpu/features.h"
#include "render/geometry/shape.h"
#include "render/light/scatter_light.h"
#include "render/picture/pixels_again.h" // describe
#include "render/picture/render_scene.h"

#include <cstdio>
#include <string>
#include <vector>

namespace tessera {

std::vector<std::string> explain(const RenderResult& r, const Scene& scene) {
    std::vector<std::string> lines;
    const auto line = [&](const char* format, auto... values) {
        char text[256];
        std::snprintf(text, sizeof text, format, values...);
        lines.emplace_back(text);
    };
    const auto percent = [](std::size_t part, std::size_t whole) {
        return whole ? 100.0 * static_cast<double>(part) / static_cast<double>(whole) : 0.0;
    };
    line("engine: %s%s%s", name(r.engine).c_str(), r.engineReason.empty() ? "" : ", because ",
         r.engineReason.c_str());
    if (r.glVersion.empty())
        line("device: %s", r.device.c_str());
    else {
        line("device: %s, OpenGL %s", r.device.c_str(), r.glVersion.c_str());
        for (const FeatureName& f : featureNames())
            line("%s: %s", f.meaning, (r.features & f.bit) ? "compiled in" : "left out");
    }
    for (int level = 0; level < kLevelCount; ++level)
        if (const std::size_t bricks = r.bricksOfLevel[static_cast<std::size_t>(level)]; bricks > 0)
            line("level %d: %zu bricks, a sample stands for %d^3 voxels", level, bricks, 1 << level);
    for (std::size_t n = 0; n < r.further.size(); ++n)
        line("volume %zu: finest level %d, %s of RAM, %s of GPU memory", n + 2, r.further[n].level,
             formatBytes(r.further[n].ramBytes).c_str(), formatBytes(r.further[n].gpuBytes).c_str());
    if (!r.further.empty())
        line("several volumes: %s; rays through a box of %d x %d x %d voxels; occlusion is each volume's "
             "own",
             nameOf(scene.fusion).c_str(), r.rayExtent.x, r.rayExtent.y, r.rayExtent.z);
    if (r.passes > 0)
        line("atlas: %zu pages of 32^3 texels, %zu at once, %d %s", r.selectionPages, r.atlasPages, r.passes,
             r.passes == 1 ? "pass" : "passes");
    if (const PathWork& w = r.work.paths; w.paths > 0) {
        const auto each = [&](std::uint64_t count) {
            return static_cast<double>(count) / static_cast<double>(w.paths);
        };
        line("paths of light: %llu, with %.2g scatterings, %.3g extinctions read (%.3g of them at "
             "collisions that were none) and %.3g boxes each",
             static_cast<unsigned long long>(w.paths), each(w.bounces), each(w.lookUps),
             each(w.nullCollisions), each(w.cells));
        if (w.alone > 0)
            line("paths of light: %llu one by one, which is slow: lanes know the physical response, the "
                 "midpoint rule, and gradients by differences, and no isosurfaces",
                 static_cast<unsigned long long>(w.alone));
        if (w.exceeded > 0)
            line("paths of light: %llu extinctions above their bound, counted as that",
                 static_cast<unsigned long long>(w.exceeded));
    }
    const Reduction reduction = reductionOf(scene);
    if (reduction == Reduction::sum) {
        line("mode: %s; rays add up what lies along them; light, isosurfaces and integrator are not used",
             nameOf(scene.mode).c_str());
        if (scene.mode != Mode::absorption)
            line("window: sums from %g to %g%s", r.window.low(), r.window.high(),
                 scene.mode == Mode::radiograph ? " mm of water, greys of an sRGB display"
                                                : ", as linear light");
    } else if (reduction != Reduction::composite) {
        line("mode: %s; rays keep the %s value along them%s",
             modeNames()[static_cast<std::size_t>(scene.mode)].c_str(),
             scene.mode == Mode::slice && !(scene.slice.thicknessMm > 0) ? "plane's"
             : reduction == Reduction::average                           ? "mean"
             : reduction == Reduction::minimum                           ? "least"
                                                                         : "greatest",
             "; light, isosurfaces, integrator and opacities are not used");
        if (scene.valueColour == ValueColour::transferFunction)
            line("colours of values: the transfer function's");
        else
            line("window: centre %g, width %g, greys of an sRGB display%s", r.window.centre, r.window.width,
                 scene.valueColour == ValueColour::inverse ? ", from white to black" : "");
    } else if (scene.mode == Mode::isosurface) {
        line("mode: isosurface; the transfer function shows nothing");
    }
    if (reduction != Reduction::composite && !r.levelsOnPurpose)
        line("level of detail: one level for all; what levels cost is not predicted in this mode");
    else if (!r.predictedError && !r.levelsOnPurpose && r.residentBricks > 0)
        line("level of detail: one level for all, because this budget of RAM cannot hold what choosing by "
             "brick needs");
    if (r.predictedError)
        line("level of detail: predicted error (L*u*v*) %.2g in the mean, %.2g at the 99th percentile",
             r.predictedError->mean, r.predictedError->p99);
    line("bricks: %zu resident, %zu (%.1f %%) show nothing and take no memory", r.residentBricks,
         r.emptyBricks, percent(r.emptyBricks, r.residentBricks + r.emptyBricks + r.unseenBricks));
    if (r.unseenBricks > 0)
        line("bricks: %zu lie outside the picture, or of what is drawn, and take no memory", r.unseenBricks);
    if (r.labels && !r.labels->onSlice.empty()) {
        const Labels& labels = scene.volumes.at(0).labels;
        line("labels: %zu of %zu are shown, %zu of them lie on the slice; voxels of level %d, %s borders, "
             "outlines %g pixels wide",
             r.labels->shown, r.labels->all, r.labels->countOnSlice(), r.labels->level,
             nameOf(labels.borders).c_str(), labels.outline);
    } else if (r.labels)
        line("labels: %zu of %zu are drawn, from %d planes beside the values", r.labels->shown, r.labels->all,
             r.labels->channels);
    for (const SceneMesh& mesh : scene.meshes)
        if (mesh.shape && reduction == Reduction::composite)
            line("mesh %s: %zu %s, %s, opacity %g", printable(mesh.name()).c_str(), mesh.shape->parts(),
                 mesh.shape->partName(), formatBytes(mesh.shape->bytes()).c_str(), mesh.opacity);
        else
            line("mesh %s: left out, because %s", printable(mesh.name()).c_str(),
                 mesh.shape ? "this mode shows single values" : "the scene does not show it");
    if (r.patientTable && r.patientTable->why.empty())
        line("table: left out, %.2g l of it", r.patientTable->litres);
    else if (r.patientTable)
        line("table: nothing is left out, because %s", r.patientTable->why.c_str());
    if (reduction != Reduction::composite && reduction != Reduction::sum)
        line("leaps: %s", !scene.quality.skipping || reduction == Reduction::average
                              ? "none"
                              : "over bricks and cells whose values cannot change what a ray has");
    else if (scene.quality.skipping)
        line("cells of 8^3 voxels: %.1f %% can show something; rays leap over the rest, and over blocks of "
             "2^3 "
             "voxels in %zu of them",
             percent(r.occupiedCells, r.cells), r.refinedCells);
    if (traitsOf(r.engine).quick && !traitsOf(r.engine).onContext && scene.quality.fetch == Fetch::hardware)
        line("fetch: exact; there is no hardware here that filters");
    if ((r.features & kFeatureCounting) || traitsOf(r.engine).countsAlways)
        line("work: %llu segments, %llu samples, %llu fetches, %llu dispatches, the longest %.0f ms",
             static_cast<unsigned long long>(r.work.segments),
             static_cast<unsigned long long>(r.work.samples), static_cast<unsigned long long>(r.work.fetches),
             static_cast<unsigned long long>(r.work.dispatches), r.work.longestDispatchMs);
    if (const auto& reflections = r.reflections) {
        std::string ways;
        std::size_t all = 0;
        for (const std::size_t n : reflections->ways)
            if (n > 0) {
                ways += (ways.empty() ? "" : " + ") + std::to_string(n);
                all += n;
            }
        line("reflections: %s rays from isosurfaces, by order, %.1f s; not in the measured errors",
             all > 0 ? ways.c_str() : "no", reflections->seconds);
        line("reflections: %.1f %% of those that met another isosurface did so within two samples, where "
             "they may have missed one",
             percent(reflections->near, reflections->met));
    }
    if (const auto& surfaces = r.surfaceLight)
        line("occlusion of surfaces: %d directions of %g mm from %zu places%s, %s, %.1f s; light of "
             "voxels has none",
             surfaces->rays, surfaces->radiusMm, surfaces->places,
             surfaces->alone > 0 ? (" and " + std::to_string(surfaces->alone) + " more samples").c_str() : "",
             formatBytes(surfaces->bytes).c_str(), surfaces->seconds);
    else if (const auto& occlusion = scene.lighting.occlusion;
             occlusion && occlusion->method == OcclusionMethod::histogram)
        line("occlusion: by the values within %g mm of each sample, kept beside the values%s",
             occlusion->radiusMm,
             occlusion->bleeding > 0 ? ", with the colours around, red, green and blue" : "");
    else if (occlusion)
        line("occlusion: %d rays of %g mm from each sample%s%s, kept beside the values%s", occlusion->rays,
             occlusion->radiusMm,
             occlusion->directions == OcclusionDirections::hemisphere ? ", by its surface's hemisphere" : "",
             occlusion->weights ? ", more from one side" : "",
             r.light && r.light->emission ? ", and the light that tissue sends to it, red, green and blue"
                                          : "");
    if (r.light && r.light->lightMaps > 0)
        line("scattered light: %zu light maps of %d x %d rays, red, green and blue, %s", r.light->lightMaps,
             r.light->lightMapSize, r.light->lightMapSize, formatBytes(r.light->lightMapBytes).c_str());
    else if (scatters(scene.lighting) && r.light)
        line("scattered light: %d rays of %g mm from each sample, red, green and blue", ScatterLight::kRays,
             scene.lighting.scatterRadiusMm);
    if (r.light)
        line("light of voxels: %d of 16 bits a sample, %s beside the bricks, computed in %.1f s",
             r.light->channels, formatBytes(r.light->planeBytes).c_str(), r.light->seconds);
    if (r.light && r.light->maps > 0 && r.light->mapKind == ShadowMapKind::deep)
        line("shadows: %zu deep shadow maps of %d x %d rays, %s, within %.2g of the light but for %.2g %% of "
             "the rays "
             "(%.2g there)",
             r.light->maps, r.light->mapSize, r.light->mapSize, formatBytes(r.light->mapBytes).c_str(),
             static_cast<double>(ShadowQuality().error), 100 * r.light->shareOfMore,
             static_cast<double>(r.light->mapError));
    else if (r.light && r.light->maps > 0)
        line("shadows: %zu %s of %d x %d rays, %s: each ray's first place with an opacity of %g; %d rays to "
             "either side "
             "count",
             r.light->maps,
             r.light->mapKind == ShadowMapKind::first ? "maps of first hits" : "variance maps of first hits",
             r.light->mapSize, r.light->mapSize, formatBytes(r.light->mapBytes).c_str(),
             scene.lighting.shadowMap.threshold, scene.lighting.shadowMap.filter);
    if (!r.light)
        line("light of voxels: none; no planes, no maps of shadows");
    char means[80] = "";
    if (r.stepOfMeans)
        std::snprintf(means, sizeof means, "%g in pixels that are the mean of eight rays or more, ",
                      *r.stepOfMeans);
    const std::string& integrator = integratorNames()[static_cast<std::size_t>(r.integrator)];
    if (traitsOf(r.engine).renderer)
        line("segments: none; the renderer takes no rays");
    else if (r.hulls.count > 0)
        line("segments: %d in each of %d hulls, %s", r.hulls.samples, r.hulls.count, integrator.c_str());
    else
        line("segments: %g voxels, %s%s", r.stepVoxels, means, integrator.c_str());
    if (r.pixels.asked == 1)
        line("pixels: one ray through the middle of each");
    else
        line("pixels: %.3g samples each in the mean, %d at most; %s", r.pixels.taken, r.pixels.most,
             scene.quality.pixels.filter == PixelFilter::box ? "the mean of the pixel's area"
                                                             : "a Gaussian of half a pixel's deviation");
    if (r.pixels.error)
        line("error of the samples' mean: rms %.2g, L*u*v* %.2g in the mean, %.2g at the 99th percentile "
             "(standard error, from how samples of a pixel differ)",
             r.pixels.error->rms, r.pixels.error->luvMean, r.pixels.error->luvP99);
    if (r.errors) {
        const PictureErrors& e = *r.errors;
        if (e.step)
            line("error of the step: rms %.2g, L*u*v* %.2g in the mean, %.2g at the 99th percentile, falling "
                 "at order "
                 "%.1f (estimated from %d pixels)",
                 e.step->error.rms, e.step->error.luvMean, e.step->error.luvP99, e.step->order, e.pixels);
        if (e.filtering)
            line("error of filtered fetches: rms %.2g, L*u*v* %.2g in the mean, %.2g at the 99th percentile",
                 e.filtering->rms, e.filtering->luvMean, e.filtering->luvP99);
    }
    if (r.measured)
        for (const std::string& text : describe(*r.measured))
            lines.push_back(text);
    if (reduction != Reduction::composite)
        return lines;
    if (const auto* const function = std::get_if<TransferFunction>(&scene.volumes.at(0).transferFunction);
        function && !function->gradientOpacity().isOne())
        line("opacity by gradient: %zu points, lengths per %s", function->gradientOpacity().points().size(),
             function->gradientOpacity().per() == GradientOpacity::Per::mm ? "mm" : "voxel");
    line("transfer function table: off by at most %.2g of the largest extinction, steps aside",
         r.tableRelativeError);
    line("ray termination: at most %.2g of a pixel's light is left out",
         scene.quality.terminationTransmittance);
    return lines;
}

} // namespace tessera
