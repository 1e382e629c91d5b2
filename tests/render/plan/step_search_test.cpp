// tests/render/plan/step_search_test.cpp: the search takes the cheapest step and integrator that are good
// enough, and draws no step that could not be taken. Pictures are grey, wrong by a function of the step.
#include "render/plan/step_search.h"

#include "tests/support/surface_fixture.h" // Stored

#include <algorithm>
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <map>

namespace tessera::test {
namespace {

constexpr float kWrong = 0.1f, kGrey = 0.4f;
constexpr StepSearch::Goal kGoal = {StepSearch::Goal::Measure::rms, 1.0 / 255};

/// How far the picture of a step is off: pictures that are alike are right.
using ErrorOfStep = std::function<float(double)>;
ErrorOfStep rightUpTo(double longest) {
    return [longest](double step) { return step <= longest ? 0 : kWrong * static_cast<float>(1 + step); };
}

class StepSearchOnGrey : public testing::Test {
  protected:
    StepSearchOnGrey() {
        scene_ = stored_.scene({}, 0, 12);
        // Far narrower than the change of the value over a voxel: both integrators are tried.
        scene_.volumes[0].transferFunction =
            TransferFunction::fromExtinction({{400, 0}, {401, 0.3}, {402, 0}}, {{0, {1, 0.5, 0.2}}});
        scene_.quality.integrator = Integrator::automatic;
        prepared_ = stored_.prepare(scene_);
    }
    struct Found {
        double step = 0, error = 0;
        Integrator integrator = Integrator::midpoint;
        std::map<Integrator, double> finest; // step that was drawn
        int pictures = 0;
    };
    Found search(const ErrorOfStep& midpoint, const ErrorOfStep& other) {
        Planner& p = prepared_->p;
        Found found;
        StepSearch search(p, [&](const RayFrame<double>& frame, const Strides& strides) {
            EXPECT_EQ(frame.segmentVoxels, strides.segmentVoxels);
            EXPECT_EQ(frame.segmentVoxels, p.view.quality.stepVoxels);
            const Integrator integrator = p.layer().optics.integrator;
            const auto [finest, isNew] = found.finest.emplace(integrator, frame.segmentVoxels);
            finest->second = std::min(finest->second, frame.segmentVoxels);
            ++found.pictures;
            Image image{glm::ivec2(frame.imageSize)};
            const float error = (integrator == Integrator::midpoint ? midpoint : other)(frame.segmentVoxels);
            std::fill(image.pixels.begin(), image.pixels.end(), glm::vec4(kGrey + error));
            return image;
        });
        found.error = search.chooseStep(kGoal);
        found.step = p.view.quality.stepVoxels;
        found.integrator = p.layer().optics.integrator;
        return found;
    }
    const Stored stored_{
        [](const glm::dvec3& p) { return 400 + 300 * std::sin(0.3 * p.x) * std::cos(0.2 * p.y + 0.1 * p.z); },
        {70, 40, 33},
        true,
        1,
        ValueType::i16};
    Scene scene_;
    std::unique_ptr<Prepared> prepared_;
};

TEST_F(StepSearchOnGrey, TakesTheLongestStepThatIsGoodEnough) {
    ASSERT_EQ(prepared_->p.integratorsToTry().size(), 2u);
    const ErrorOfStep never = [](double step) { return static_cast<float>(step); };
    for (const auto& [longest, step] :
         {std::pair(3.0, 2.0), std::pair(1.8, 1.75), std::pair(1.6, 1.5), std::pair(0.7, 0.625),
          std::pair(0.5, 0.5), std::pair(0.0625, 0.0625)}) {
        const Found found = search(rightUpTo(longest), never);
        EXPECT_EQ(found.step, step);
        EXPECT_EQ(found.integrator, Integrator::midpoint);
        EXPECT_EQ(found.error, 0);
    }
}

// Half a voxel by the midpoint rule costs two. The other integrator costs half as much again: three at half a
// voxel, but 1.71 at 7/8 of one, which is tried beside it.
TEST_F(StepSearchOnGrey, TakesALongerStepBesideOneThatWouldCostMore) {
    const Found found = search(rightUpTo(0.5), rightUpTo(0.9));
    EXPECT_EQ(found.step, 0.875);
    EXPECT_NE(found.integrator, Integrator::midpoint);
    EXPECT_EQ(search(rightUpTo(0.5), rightUpTo(0.8)).step, 0.5) << "three quarters of one cost two as well";
}

// One voxel by the midpoint rule costs one. The other integrator's cheapest step beside half a voxel costs
// 1.71: the steps that judge it, down to an eighth, are not drawn.
TEST_F(StepSearchOnGrey, DrawsNoStepThatCouldNotBeTaken) {
    const Found found = search(rightUpTo(1), rightUpTo(0.5));
    EXPECT_EQ(found.step, 1);
    EXPECT_EQ(found.integrator, Integrator::midpoint);
    for (const auto& [integrator, finest] : found.finest)
        EXPECT_EQ(finest, 0.25) << (integrator == Integrator::midpoint ? "midpoint" : "the other");
    EXPECT_EQ(found.pictures, 4 + 3 + 4);
}

TEST_F(StepSearchOnGrey, TakesTheNearestWhereNoneIsGoodEnough) {
    const Found found = search([](double step) { return static_cast<float>(step); },
                               [](double step) { return static_cast<float>(0.5 * step); });
    EXPECT_EQ(found.step, StepSearch::kFinestStep);
    EXPECT_NE(found.integrator, Integrator::midpoint);
    EXPECT_GT(found.error, kGoal.limit);
}

} // namespace
} // namespace tessera::test
