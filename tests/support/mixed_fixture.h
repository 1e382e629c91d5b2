// tests/support/mixed_fixture.h: scenes whose bricks have levels drawn at random.
#pragma once

#include "render/plan/planner.h"
#include "tests/support/scene_fixture.h"

#include <memory>
#include <random>
#include <string>
#include <utility>

namespace tessera::test {

/// Random levels, every eighth brick empty whatever it shows: the field does not ask why a brick is empty.
inline Selection randomLevels(const Selection& like, unsigned seed, bool withEmpty) {
    std::mt19937 random(seed);
    std::uniform_int_distribution<int> level(0, kLevelCount - 1), eighth(0, 7);
    Selection s = like;
    s.counts = {};
    for (std::uint8_t& mine : s.levels) {
        if (mine != Selection::kEmpty || !withEmpty)
            mine = static_cast<std::uint8_t>(withEmpty && eighth(random) == 0 ? int{Selection::kEmpty}
                                                                              : level(random));
        ++s.counts[mine];
    }
    return s;
}

/// Random levels that keep what is proven empty, for pictures.
inline Selection randomShownLevels(const Selection& like, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_int_distribution<int> level(0, kLevelCount - 1);
    Selection s = like;
    s.counts = {};
    for (std::uint8_t& mine : s.levels) {
        if (mine != Selection::kEmpty)
            mine = static_cast<std::uint8_t>(level(random));
        ++s.counts[mine];
    }
    return s;
}

inline constexpr EdgeFunction kEdgeFunctions[] = {EdgeFunction::nearest, EdgeFunction::minimum,
                                                  EdgeFunction::split, EdgeFunction::maximum};

struct MixedScene {
    MixedScene(const std::string& store, const std::string& preset, int camera, EdgeFunction edge,
               Sampling sampling = Sampling::limited, glm::ivec2 size = {32, 32},
               Integrator integrator = Integrator::midpoint) {
        MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
        const VolumeInfo info = StoreReader(storePath(store), ram).info();
        Scene scene = sceneOn(info, preset, camera, size);
        scene.quality.edgeFunction = edge;
        scene.quality.sampling = sampling;
        scene.quality.integrator = integrator;
        prepared = std::make_unique<Prepared>(store, scene);
    }
    Planner& p() { return prepared->p; }
    void choose(Selection s) { p().setSelection(std::move(s)); }
    std::unique_ptr<Prepared> prepared;
};

} // namespace tessera::test
