// tests/support/lit_picture.h: the mirror's pictures with light per voxel.
#pragma once

#include "core/image/image.h"
#include "render/backends/mirror/mirror.h"
#include "render/light/scene_light.h"
#include "tests/support/scene_fixture.h"

namespace tessera::test {

inline Image mirrorLit(Prepared& prepared, const RaySource<float>& rays) {
    const FramePlan& p = prepared.p;
    SceneLight light(p, 0);
    const StoredLight stored(light, p, prepared.budgets.ram);
    MirrorInput input = mirrorInput(p, p.view.quality.skipping);
    input.light = &stored;
    Image image(p.view.imageSize);
    Work work;
    image.pixels = mirrorRays<float>(input, image.pixels.size(), rays, 0, work);
    return image;
}

/// By the rays of its pixels.
inline Image mirrorLit(Prepared& prepared) {
    return mirrorLit(prepared, frameRays(cast<float>(prepared.p.view.frame)));
}

} // namespace tessera::test
