// tests/support/native_fixture.h: prepared scenes by the native engine, with every instruction set that the
// processor has, and by the float mirror, whose bits it must have.
#pragma once

#include "render/backends/native/native_caster.h"
#include "render/plan/planner.h"
#include "tests/support/scene_fixture.h"

#include <optional>
#include <vector>

namespace tessera::test {

/// Those that can run here; the baseline always can.
inline std::vector<const native::PacketTarget*> nativeTargets() {
    const native::PacketTargets targets = native::packetTargets();
    return {targets.all, targets.all + targets.count};
}

struct NativePicture {
    Image image;
    std::vector<SurfaceHit> hits;
    Work work;
    std::size_t refinedCells = 0;
};
struct NativeChoices {
    const native::PacketTarget* target = nullptr;
    Slicing slicing = {};
    bool hits = false;
    bool blocks = false, refine = false; // blocks of empty space: in any case; where they pay
    bool shreds = false;                 // every deadline has passed
    bool ghostLayers = true;
    int threads = 0;
    std::optional<Rays> rays = {}; // else those of the plan
};

/// All bricks of the selection are there.
inline NativePicture nativePicture(Prepared& prepared, const NativeChoices& choices = {}) {
    Planner& p = prepared.p;
    NativeEngine engine(choices.threads, prepared.budgets.gpu, prepared.budgets.ram);
    p.layer().pageEdge = choices.ghostLayers ? kGhostedEdge : kBrickExtent;
    p.chosen.chooser.reset();
    p.chosen.atlasPages = std::max<std::size_t>(1, pagesFor(p.layer().selection.counts));
    NativePicture out;
    loadBricks(engine, p, prepared.budgets.gpu, out.work);
    NativeCaster caster(p, engine, {true, choices.hits, false}, prepared.budgets.gpu, choices.target);
    if (choices.blocks)
        caster.findBlocks();
    if (choices.refine)
        caster.refine();
    caster.begin(choices.rays.value_or(raysOf(p)));
    if (choices.shreds)
        while (!caster.draw(choices.slicing, RayCaster::Clock::time_point::min(), out.work)) {
        }
    else
        drawToTheEnd(caster, engine, p, choices.slicing, out.work);
    out.refinedCells = caster.refinedCells();
    out.image = caster.image();
    out.hits = caster.hits();
    return out;
}

/// How many pixels differ in any bit.
inline std::size_t differing(const Image& a, const Image& b) {
    if (a.size != b.size)
        return a.pixels.size() + 1;
    std::size_t count = 0;
    for (std::size_t i = 0; i < a.pixels.size(); ++i)
        count += std::memcmp(&a.pixels[i], &b.pixels[i], sizeof(glm::vec4)) != 0;
    return count;
}

inline VolumeInfo infoOf(const std::string& store) {
    MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
    return StoreReader(storePath(store), ram).info();
}

inline Image mirrorPicture(const FramePlan& p) {
    Image image(p.view.imageSize);
    Work work;
    MirrorInput input = mirrorInput(p, p.view.quality.skipping);
    std::optional<CutRays> cuts;
    if (p.view.frame.cuts)
        input.cuts = &cuts.emplace(cutRays(p.view.frame, {}, 0));
    input.segmentVoxels = p.view.frame.segmentVoxels;
    image.pixels =
        mirrorRays<float>(input, image.pixels.size(), frameRays(cast<float>(p.view.frame)), 0, work);
    return image;
}
inline Image mirrorPicture(const Prepared& prepared) {
    return mirrorPicture(prepared.p);
}

/// With every instruction set, with ghost layers and without.
/// @param blank  whether nothing is to be seen
inline void expectTheMirrorsBits(Prepared& prepared, bool blank = false) {
    const Image mirror = mirrorPicture(prepared);
    EXPECT_EQ(isBlank(mirror), blank);
    for (const native::PacketTarget* target : nativeTargets())
        for (const bool ghostLayers : {true, false}) {
            NativeChoices choices;
            choices.target = target;
            choices.ghostLayers = ghostLayers;
            EXPECT_EQ(differing(nativePicture(prepared, choices).image, mirror), 0u)
                << target->name << (ghostLayers ? ", ghost layers" : ", no ghost layers");
        }
}

} // namespace tessera::test
