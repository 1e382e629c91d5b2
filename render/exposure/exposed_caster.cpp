// render/exposure/exposed_caster.cpp: see exposed_caster.h.
#include "render/exposure/exposed_caster.h"

#include "core/base/error.h"
#include "core/base/threads.h"
#include "render/contract/ray_cuts.h"
#include "render/geometry/mesh_caster.h"
#include "render/parts/part_caster.h"

namespace tessera {

ExposedCaster::ExposedCaster(std::unique_ptr<RayCaster> sums, const FramePlan& plan, int threads)
    : sums_(std::move(sums)), plan_(plan), threads_(threads) {
    TESSERA_CHECK(plan.view.exposure);
}

void ExposedCaster::begin(const Rays& rays) {
    rays_ = rays;
    sums_->begin(rays);
}

Image ExposedCaster::image() const {
    Image picture = sums_->image();
    const Exposure& exposure = *plan_.view.exposure;
    window_ = exposure.window ? *exposure.window : exposure.windowOf(picture);
    const auto width = static_cast<std::size_t>(picture.size.x);
    const RayFrame<double>& frame = rays_.frame;
    parallelFor(static_cast<std::size_t>(picture.size.y), threads_, [&](std::size_t row) {
        std::vector<RayPart> parts;
        const auto meets = [&](std::size_t ray) {
            const RayLine<double> line = pixelLine(frame, glm::dvec2(rays_.placeOf(ray)));
            double from = 0, to = 0;
            if (!drawnPartOf(frame, line, from, to))
                return false;
            parts.assign(1, {from, to});
            if (frame.cuts)
                frame.cuts->parts(line.base, line.direction, from, to, parts);
            return !parts.empty();
        };
        for (std::size_t ray = row * width; ray < (row + 1) * width; ++ray) {
            glm::vec4& pixel = picture.pixels[ray];
            pixel = exposure.shown(pixel, *window_,
                                   exposure.mode == Mode::radiograph && (pixel.a > 0 || meets(ray)));
        }
    });
    return picture;
}

std::unique_ptr<RayCaster> casterOf(Engine& engine, const FramePlan& plan, const CasterOptions& options,
                                    MemoryBudget& gpu, int threads, bool shadows) {
    if (plan.shared)
        return std::make_unique<PartCaster>(engine.caster(options, gpu), plan, threads);
    if (!plan.view.exposure)
        return casterWithMeshes(engine, plan, options, gpu, threads, shadows);
    return std::make_unique<ExposedCaster>(engine.caster(options, gpu), plan, threads);
}

} // namespace tessera
