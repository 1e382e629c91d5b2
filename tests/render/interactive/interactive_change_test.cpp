// tests/render/interactive/interactive_change_test.cpp: changes of an interactive renderer: a camera, a
// function or both are set, or a picture is dropped. It converges to the picture of a fresh renderer, bit for
// bit, and to the still's.
#include "bricking/statistics/statistics.h"
#include "core/image/image_metrics.h"
#include "core/scene/preset.h"
#include "render/picture/render_scene.h"
#include "tests/support/graded.h"
#include "tests/support/interactive_fixture.h"
#include "tests/support/lights.h"
#include "tests/support/native_fixture.h"

#include <functional>
#include <gtest/gtest.h>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace tessera {
namespace {

using namespace tessera::test;
using std::chrono::microseconds;
using Clock = InteractiveRenderer::Clock;

constexpr glm::ivec2 kSize(28, 24);
constexpr std::size_t kAmple = std::size_t{1} << 30;

enum Function { kSoft, kLittle, kSpike, kGraded };
TransferFunction functionOf(Function function) {
    ValueSummary values;
    values.isHu = true;
    switch (function) {
    case kLittle: // dense bone alone
        return TransferFunction::fromOpacity({{300, 0}, {500, 0.9}}, {{300, {1, 0.3, 0.1}}}, 1);
    case kSpike: // the midpoint rule would step over it
        return TransferFunction::fromOpacity({{39, 0}, {40, 0.9}, {41, 0}}, {{40, {0.2, 1, 0.4}}}, 1);
    case kGraded:
        return graded(presetFunction("soft-tissue", values));
    case kSoft:
        break;
    }
    return presetFunction("soft-tissue", values);
}

struct Change {
    const char* name;
    std::function<void(InteractiveRenderer&)> make;
    int camera; // as it is afterwards
    Function function;
};

/// One dispatch or a little more of the picture that is due.
void begin(InteractiveRenderer& renderer) {
    for (int n = 0; n < 3; ++n)
        renderer.advance(Clock::now() + microseconds(1));
}

/// Cameras and functions, one after the other, in every way to set them. The visible part becomes less and
/// more.
std::vector<Change> changes(const VolumeInfo& info) {
    const auto camera = [info](int number) { return cameraNumber(number, info, kSize); };
    return {
        {"nothing", [](auto&) {}, 0, kSoft},
        {"camera", [=](auto& r) { r.setCamera(camera(1)); }, 1, kSoft},
        {"a function of less", [](auto& r) { r.setFunction(functionOf(kLittle)); }, 1, kLittle},
        {"opacity by gradient", [](auto& r) { r.setFunction(functionOf(kGraded)); }, 1, kGraded},
        {"a function of more", [](auto& r) { r.setFunction(functionOf(kSoft)); }, 1, kSoft},
        {"both in one step",
         [=](auto& r) {
             r.setCamera(camera(2));
             r.setFunction(functionOf(kSpike));
         },
         2, kSpike},
        {"both, the function first, and two functions",
         [=](auto& r) {
             r.setFunction(functionOf(kLittle));
             r.setFunction(functionOf(kSoft));
             r.setCamera(camera(0));
         },
         0, kSoft},
        {"a function while a picture is in the works",
         [=](auto& r) {
             r.setCamera(camera(1));
             begin(r);
             r.setFunction(functionOf(kLittle));
         },
         1, kLittle},
        {"a camera while a picture is in the works, which is dropped",
         [=](auto& r) {
             r.setFunction(functionOf(kSoft));
             begin(r);
             r.setCamera(camera(0));
             r.cancel();
             begin(r);
         },
         0, kSoft},
        {"a picture that is dropped and nothing else",
         [=](auto& r) {
             r.setCamera(camera(2));
             begin(r);
             r.cancel();
         },
         2, kSoft},
    };
}

struct Case {
    const char* name;
    bool lit, surfaces;
    Integrator integrator;
    bool native = false, lights = false;
};
class InteractiveChange : public testing::TestWithParam<Case> {};
INSTANTIATE_TEST_SUITE_P(Scenes, InteractiveChange,
                         testing::Values(Case{"lit", true, false, Integrator::automatic},
                                         Case{"surfacesUnlit", false, true, Integrator::midpoint},
                                         Case{"native", true, false, Integrator::automatic, true},
                                         Case{"lights", true, false, Integrator::midpoint, false, true},
                                         Case{"nativeLights", true, true, Integrator::midpoint, true, true},
                                         Case{"nativeSurfaces", false, true, Integrator::midpoint, true}),
                         [](const auto& info) { return std::string(info.param.name); });

// Memory is ample, so that no view before has a say in the levels.
TEST_P(InteractiveChange, ComesToWhatAFreshOneComesTo) {
    Scene scene = interactiveScene("soft-tissue", 0, kSize);
    scene.shading.on = GetParam().lit;
    scene.quality.integrator = GetParam().integrator;
    if (GetParam().lights)
        lightWithAll(scene, infoOf("torso"), ShadingModel::phong, false);
    if (GetParam().surfaces)
        scene.surfaces = {{-300, {0.9, 0.6, 0.5}, 0.3}, {250, {0.95, 0.9, 0.8}, 1}};
    const bool native = GetParam().native;
    std::vector<Change> all;
    std::vector<Image> pictures;
    VolumeInfo info;
    {
        Session session(scene, kAmple, {}, storePath("torso"),
                        native); // the next one has a context of its own, which must not come between
        info = session.reader.info();
        all = changes(info);
        for (const Change& change : all) {
            change.make(session.renderer);
            session.converge();
            pictures.push_back(session.renderer.picture());
        }
    }
    std::map<std::pair<int, Function>, Image> fresh;
    for (std::size_t i = 0; i < all.size(); ++i) {
        SCOPED_TRACE(all[i].name);
        EXPECT_FALSE(isBlank(pictures[i]));
        if (i > 0) {
            EXPECT_FALSE(bitEqual(pictures[i], pictures[i - 1]));
        }
        Image& mine = fresh[{all[i].camera, all[i].function}];
        if (mine.pixels.empty()) {
            scene.camera = cameraNumber(all[i].camera, info, kSize);
            scene.volumes[0].transferFunction = functionOf(all[i].function);
            Session session(scene, kAmple, {}, storePath("torso"), native);
            session.converge();
            mine = session.renderer.picture();
        }
        EXPECT_TRUE(bitEqual(pictures[i], mine)) << compare(pictures[i], mine).maxAbs;
    }
    // The still of the last one; it reads one level as such, so that it differs by rounding.
    MemoryBudget ram("RAM", "--ram", kRam), gpu("GPU memory", "--gpu-memory", kAmple);
    const StoreReader reader(storePath("torso"), ram);
    RenderOptions options;
    options.engine = native ? EngineKind::native : EngineKind::gpu;
    options.device.text = "software";
    scene.camera = cameraNumber(all.back().camera, info, kSize);
    scene.volumes[0].transferFunction = functionOf(all.back().function);
    const Image still = renderScene(scene, reader, ram, gpu, options).image;
    EXPECT_LE(compare(pictures.back(), still).luvMean, 1e-3);
}

// Every brick shows something under either function and keeps its level: nothing but the function itself
// tells that rays may no longer leap where they did.
class InteractiveChanges : public testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(Engines, InteractiveChanges, testing::Bool(),
                         [](const auto& info) { return info.param ? "native" : "gpu"; });

TEST_P(InteractiveChanges, AFunctionIsMappedWhereNoLevelChanges) {
    MemoryBudget probe("RAM", "--ram", std::size_t{64} << 20);
    const std::filesystem::path store = storePath("marschner-lobb");
    const StoreReader reader(store, probe);
    const Statistics statistics = loadStatistics(reader, probe, 1);
    const double low = statistics.lowest, range = static_cast<double>(statistics.highest) - low;
    // Two bands each, because a brick of this store has values of one half of the range only.
    const auto bands = [&](double first, double second) {
        std::vector<OpacityPoint> points;
        for (const double share : {first, second})
            for (const auto& [beside, opacity] :
                 {std::pair(-0.05, 0.0), std::pair(0.0, 0.9), std::pair(0.05, 0.0)})
                points.push_back({reader.info().rescaleSlope * (low + (share + beside) * range) +
                                      reader.info().rescaleIntercept,
                                  opacity});
        return TransferFunction::fromOpacity(points, {{points[0].value, {1, 0.5, 0.2}}}, 4);
    };
    const TransferFunction functions[] = {bands(0.1, 0.9), bands(0.3, 0.7), bands(0.1, 0.9)};
    Scene scene = sceneOn(reader.info(), "auto", 0, kSize);
    scene.volumes[0].transferFunction = functions[0];
    std::vector<Image> pictures;
    std::vector<std::vector<std::uint8_t>> levels;
    {
        Session session(scene, kAmple, {}, store, GetParam());
        for (const TransferFunction& function : functions) {
            session.renderer.setFunction(function);
            session.converge();
            pictures.push_back(session.renderer.picture());
            levels.push_back(session.renderer.resident().levels);
        }
    }
    EXPECT_EQ(levels[0], levels[1]);
    EXPECT_FALSE(bitEqual(pictures[0], pictures[1]));
    for (const std::size_t i : {std::size_t{1}, std::size_t{2}}) {
        scene.volumes[0].transferFunction = functions[i];
        Session fresh(scene, kAmple, {}, store, GetParam());
        fresh.converge();
        EXPECT_FALSE(isBlank(pictures[i]));
        EXPECT_TRUE(bitEqual(pictures[i], fresh.renderer.picture())) << i;
    }
}

// Memory is short, and no page is kept free. After a new function, levels do not depend on earlier pictures.
// After a new camera alone they depend on the visibility before, so that its picture may differ a little
// until the next function.
TEST_P(InteractiveChanges, ComeToTheSameLevelsWhereMemoryIsShort) {
    Scene scene = interactiveScene("soft-tissue", 0, {48, 48});
    InteractiveOptions options;
    options.spareShare = 0;
    // The GPU ray caster gets 55 pages of the memory that is planned for 40.
    const std::size_t budget = gpuBytesFor(scene, GetParam() ? 55 : 40, GetParam());
    struct State {
        Image picture;
        std::vector<std::uint8_t> levels;
    };
    const auto stateOf = [](Session& session) {
        session.converge();
        EXPECT_GT(session.renderer.predictedError().mean, 0) << "the budget must be short";
        return State{session.renderer.picture(), session.renderer.resident().levels};
    };
    std::vector<State> states;
    const TransferFunction soft = functionOf(kSoft);
    VolumeInfo info;
    {
        Session session(scene, budget, options, storePath("torso"), GetParam());
        info = session.reader.info();
        states.push_back(stateOf(session));
        session.renderer.setFunction(functionOf(kLittle));
        session.converge();
        session.renderer.setFunction(soft);
        states.push_back(stateOf(session));
        session.renderer.setCamera(cameraNumber(1, info, {48, 48}));
        session.renderer.setFunction(soft); // the same: what was seen is forgotten
        states.push_back(stateOf(session));
        session.renderer.setCamera(cameraNumber(0, info, {48, 48}));
        states.push_back(stateOf(session));
    }
    State fresh[2];
    for (int camera = 0; camera < 2; ++camera) {
        scene.camera = cameraNumber(camera, info, {48, 48});
        Session session(scene, budget, options, storePath("torso"), GetParam());
        fresh[camera] = stateOf(session);
    }
    for (const auto& [state, camera] : {std::pair(0, 0), std::pair(1, 0), std::pair(2, 1)}) {
        const auto& mine = states[static_cast<std::size_t>(state)];
        EXPECT_EQ(mine.levels, fresh[camera].levels) << state;
        EXPECT_TRUE(bitEqual(mine.picture, fresh[camera].picture)) << state;
    }
    EXPECT_LE(compare(states[3].picture, fresh[0].picture).luvMean, 0.3);
    EXPECT_FALSE(bitEqual(states[3].picture, states[2].picture));
}

} // namespace
} // namespace tessera
