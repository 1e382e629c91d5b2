// render/picture/ray_tiles.cpp: pictures that rays draw tile by tile (ray_renderer.h).
#include "core/base/error.h"
#include "core/base/progress.h"
#include "core/image/picture_tile.h"
#include "render/exposure/exposed_caster.h"
#include "render/picture/picture.h"
#include "render/picture/ray_renderer.h"
#include "render/picture/rays_drawn.h"
#include "render/picture_tiles.h"

#include <algorithm>
#include <glm/common.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace tessera {

/// One that starts from a plan has the bits of another with these.
PictureTiles::Parts RayRenderer::partsOfTiles(const FramePlan& p) const {
    PictureTiles::Parts parts = RaysDrawn(p).parts(p, exact_);
    const ShadowQuality& maps = p.view.shadowQuality;
    parts["shadow maps, as RAM allows:"] =
        std::to_string(maps.mapSize) + " rays a side, " + std::to_string(maps.layers) + " points, offset " +
        digitsOf(maps.offset, 17) + ", light maps 1/" + std::to_string(maps.lightMapPart);
    parts["map of empty space, as budgets allow:"] =
        std::string(p.layer().mapScale == MapScale::cells ? "cells" : "bricks") +
        (p.layer().mapsSurfaces ? ", and isosurfaces" : "");
    if (const auto& window = p.layer().look.window; p.view.exposure || p.layer().reduces())
        parts["window"] = digitsOf(window.centre, 17) + " +- " + digitsOf(window.width, 17);
    return parts;
}

void RayRenderer::drawTile(const FrameTask& task, const PictureTile& tile, RenderResult& result) {
    const FramePlan& p = task.plan;
    const PixelSampling& sampling = p.view.quality.pixels;
    Slicing slicing = task.options.slicing;
    slicing.progress = {}; // the tiles'
    const auto draw = [&](const Rays& rays) {
        caster_->begin(rays);
        result.passes = std::max(result.passes, drawToTheEnd(*caster_, *engine_, p, slicing, result.work));
    };
    Rays rays = picturesRays(p, false);
    const auto drawMiddles = [&](const PictureTile& of, std::vector<glm::vec2>& middles) {
        middles = of.middles();
        Rays through = rays;
        through.places = middles;
        through.arraySize = of.size;
        draw(through);
    };
    std::vector<glm::vec2> middles;
    std::optional<DeferredLight> light;
    if (DeferredLight::isOf(p)) {
        const PictureTile around = DeferredLight::around(tile, p);
        light.emplace(p, task.options.threads, exact_, around);
        if (light->needsMiddles()) {
            drawMiddles(around, middles);
            light->lookAround(*caster_, task.context.progress);
        }
    }
    DrawnTile drawn{tile, {}, {}, {}};
    if (sampling.samples == 1) {
        drawMiddles(tile, middles);
        drawn.colours = caster_->image();
        if (light)
            drawn.added = light->added(*caster_, *engine_, middles, tile.size, slicing, result.work);
    } else {
        AreaPicture picture(
            rays, sampling, task.options.threads, {}, {}, {}, light ? 1 : 0,
            AreaOfPicture{tile, glm::min(glm::ivec2(task.options.tiles->side()), p.view.imageSize)});
        while (const std::optional<Rays> next = picture.next()) {
            draw(*next);
            const Image colours = caster_->image();
            if (!light) {
                picture.add(colours);
                continue;
            }
            const Image more =
                light->added(*caster_, *engine_, next->places, next->size(), slicing, result.work);
            picture.add(colours, std::span(&more, 1));
        }
        drawn.colours = picture.image();
        if (light)
            drawn.added = picture.other(0);
        drawn.offsets = picture.sums().offsets();
    }
    task.options.tiles->keep(drawn);
    if (light)
        light->addReport(result);
}

void RayRenderer::drawTiles(const FrameTask& task, RenderResult& result) {
    PictureTiles& tiles = *task.options.tiles;
    const PixelSampling& sampling = task.plan.view.quality.pixels;
    TESSERA_CHECK(sampling.samples != PixelSampling::kAutomatic && !(sampling.noise > 0) &&
                  !sampling.denoise && !task.options.layers.paths && !task.options.layers.errors &&
                  !task.options.kept && !task.plan.layer().sliceLabels);
    tiles.begin(partsOfTiles(task.plan));
    const ShareDone done = task.context.progress.shares();
    while (const std::optional<PictureTile> tile = tiles.next()) {
        drawTile(task, *tile, result);
        if (done)
            done(tiles.share());
    }
    result.pixels.asked = result.pixels.most = sampling.samples;
    result.pixels.taken = sampling.samples;
    if (sampling.samples > 1 && tiles.finishes()) {
        task.context.progress.stage("measuring the picture's noise");
        result.pixels.error = standardError([&](const auto& visit) { tiles.eachPixel(visit); });
    }
}

} // namespace tessera
