// tests/render/plan/plan_revisions_test.cpp: a change of a plan gives a new number to what it changed, and to
// nothing else; numbers are never the same twice; and a change that needs another plan is refused whole.
#include "render/plan/planner.h"

#include "core/base/error.h"
#include "render/plan/frame_plan.h"
#include "tests/support/mixed_fixture.h"   // randomShownLevels()
#include "tests/support/surface_fixture.h" // Stored

#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <set>

namespace tessera::test {
namespace {

Stored hills() {
    return Stored(
        [](const glm::dvec3& p) { return 400 + 300 * std::sin(0.3 * p.x) * std::cos(0.2 * p.y + 0.1 * p.z); },
        {70, 40, 33}, true, 1, ValueType::i16);
}
TransferFunction rising(double from) {
    return TransferFunction::fromExtinction({{from, 0}, {from + 200, 0.3}}, {{0, {1, 0.5, 0.2}}});
}

class PlanNumbers : public testing::Test {
  protected:
    PlanNumbers() {
        scene_ = stored_.scene({}, 0, 12);
        scene_.volumes[0].transferFunction = rising(300);
        scene_.shading.on = true;
        prepared_ = stored_.prepare(scene_);
    }
    /// What a change renews: f(unction), t(ables), l(evels), e(mpty space).
    std::string renewed(const std::function<void(Planner&)>& change) {
        Planner& p = prepared_->p;
        const PlanRevisions before = p.revisions;
        change(p);
        std::string what;
        const auto look = [&](std::uint64_t old, std::uint64_t now, char letter) {
            if (old != now)
                what += letter;
            EXPECT_GE(now, old);
        };
        look(before.function, p.revisions.function, 'f');
        look(before.tables, p.revisions.tables, 't');
        look(before.levels, p.revisions.levels, 'l');
        look(before.emptySpace, p.revisions.emptySpace, 'e');
        return what;
    }
    Selection selectionOf(int level) const {
        Selection s = prepared_->p.layer().selection;
        s.counts = {};
        for (std::uint8_t& mine : s.levels) {
            mine = mine == Selection::kEmpty ? mine : static_cast<std::uint8_t>(level);
            ++s.counts[mine];
        }
        return s;
    }
    const Stored stored_ = hills();
    Scene scene_;
    std::unique_ptr<Prepared> prepared_;
};

TEST_F(PlanNumbers, AreNewWhereSomethingChanged) {
    EXPECT_EQ(renewed([](Planner&) {}), "");
    EXPECT_EQ(renewed([&](Planner& p) { p.setSelection(selectionOf(1)); }), "le");
    EXPECT_EQ(renewed([&](Planner& p) { p.mapLevels(false); }), "le");
    EXPECT_EQ(renewed([&](Planner& p) { p.setFunction(rising(350), scene_); }), "ft");
    EXPECT_EQ(renewed([](Planner& p) { p.mapFunction(); }), "e");
    EXPECT_EQ(renewed([](Planner& p) { p.setTermination(0.1f); }), "t");
    EXPECT_EQ(prepared_->p.layer().optics.termination, 0.1f);
    EXPECT_EQ(renewed([](Planner& p) { p.setIntegrator(Integrator::preintegrated); }), "t");
    EXPECT_EQ(renewed([](Planner& p) { p.setIntegrator(Integrator::preintegrated); }), "") << "as it was";
    EXPECT_EQ(renewed([](Planner& p) { p.setStep(0.75); }), "") << "sums know no length";
    EXPECT_EQ(renewed([](Planner& p) { p.setIntegrator(Integrator::preintegrated2d); }), "t");
    EXPECT_EQ(renewed([](Planner& p) { p.setStep(0.5); }), "t") << "colours by both ends do";
    EXPECT_EQ(prepared_->p.view.frame.segmentVoxels, 0.5);
    EXPECT_EQ(renewed([](Planner& p) { p.setFetch(Fetch::hardware); }), "");
    EXPECT_EQ(renewed([&](Planner& p) { p.look(cameraNumber(1, stored_.info, {12, 12})); }), "");
}

TEST_F(PlanNumbers, AreNeverTheSameTwice) {
    std::set<std::uint64_t> seen;
    for (int n = 0; n < 100; ++n)
        EXPECT_TRUE(seen.insert(PlanRevisions::next()).second);
    for (int n = 0; n < 3; ++n)
        EXPECT_TRUE(seen.insert(stored_.prepare(scene_)->p.revisions.levels).second);
    EXPECT_EQ(*seen.begin() > 0, true) << "0 is what nobody has";
}

TEST_F(PlanNumbers, LightIsTakenOrRefusedWhole) {
    Planner& p = prepared_->p;
    Scene bright = scene_;
    bright.shading.ambient = 0.7;
    bright.lighting.lights.resize(2);
    bright.lighting.lights[1].intensity = 0.25;
    EXPECT_EQ(renewed([&](Planner& q) { EXPECT_TRUE(q.setLight(bright)); }), "ft");
    EXPECT_EQ(p.view.lighting.lights.size(), 2u);
    EXPECT_EQ(p.view.shading.ambient, 0.7);
    EXPECT_FLOAT_EQ(static_cast<float>(p.layer().optics.phong.x), 0.7f);
    const auto refused = [&](const std::function<void(Scene&)>& change) {
        Scene other = bright;
        change(other);
        EXPECT_EQ(renewed([&](Planner& q) { EXPECT_FALSE(q.setLight(other)); }), "");
        EXPECT_EQ(p.view.shading.ambient, 0.7);
        EXPECT_EQ(p.view.lighting.lights.size(), 2u);
    };
    refused([](Scene& s) { s.shading.on = false; });
    refused([](Scene& s) { s.shading.gradient = Gradient::sobel; });
    refused([](Scene& s) { s.lighting.occlusion.emplace(); });
    refused([](Scene& s) {
        s.lighting.lights[1].kind = LightKind::directional;
        s.lighting.lights[1].shadow = true;
    });
}

TEST(ViewChanges, AreTakenOnce) {
    Changes changes(kCameraChanged | kLevelsChanged);
    EXPECT_TRUE(changes.any());
    EXPECT_FALSE(changes.any(kFunctionChanged));
    EXPECT_FALSE(changes.take(kFunctionChanged));
    EXPECT_TRUE(changes.take(kLevelsChanged | kLightChanged));
    EXPECT_FALSE(changes.take(kLevelsChanged));
    EXPECT_TRUE(changes.any(kCameraChanged)) << "others stay";
    changes.add(kEmptySpaceChanged);
    EXPECT_TRUE(changes.take(kCameraChanged));
    EXPECT_TRUE(changes.take(kEmptySpaceChanged));
    EXPECT_FALSE(changes.any());
}

// A stride is as long as the levels and the sampling say.
TEST_F(PlanNumbers, StridesFollowLevelsAndSampling) {
    Planner& p = prepared_->p;
    for (const int level : {0, 1, 3}) {
        p.setSelection(selectionOf(level));
        const Strides strides = p.strides();
        EXPECT_EQ(strides.map, nullptr);
        EXPECT_EQ(strides.segmentVoxels, p.view.quality.stepVoxels);
        EXPECT_EQ(strides.sampling, p.view.quality.sampling);
        EXPECT_GE(strides.uniformSegments, 1);
        EXPECT_LE(strides.uniformSegments, 1 << level);
    }
    Selection mixed = selectionOf(1);
    const auto first = static_cast<std::size_t>(
        std::find(mixed.levels.begin(), mixed.levels.end(), std::uint8_t{1}) - mixed.levels.begin());
    ASSERT_LT(first, mixed.levels.size());
    --mixed.counts[1], ++mixed.counts[0], mixed.levels[first] = 0;
    p.setSelection(mixed);
    EXPECT_TRUE(p.layer().mixed());
    EXPECT_EQ(p.strides().map, &p.layer().levels);
}

// Levels that mix for a while leave no map of themselves, and none of its bytes.
TEST_F(PlanNumbers, LevelsAreThoseOfTheLastSelection) {
    Planner& p = prepared_->p;
    p.setSelection(selectionOf(1));
    const std::size_t before = prepared_->budgets.ram.usedBytes();
    p.setSelection(randomShownLevels(selectionOf(1), 3));
    ASSERT_TRUE(p.layer().mixed());
    EXPECT_GT(prepared_->budgets.ram.usedBytes(), before);
    p.setSelection(selectionOf(1));
    EXPECT_FALSE(p.layer().mixed());
    EXPECT_EQ(p.strides().map, nullptr);
    EXPECT_EQ(prepared_->budgets.ram.usedBytes(), before);
}

} // namespace
} // namespace tessera::test
