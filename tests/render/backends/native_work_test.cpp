// tests/render/backends/native_work_test.cpp: the native engine counts the work that the mirror does, with
// every instruction set, and the lanes that are used of its packets.
#include "tests/support/graded.h"
#include "tests/support/native_fixture.h"
#include "tests/support/surface_fixture.h" // Stored

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <string>
#include <vector>

namespace tessera {
namespace {

using namespace tessera::test;

struct Counted {
    Work work;
    NativeCaster::Lanes lanes;
};

Counted counted(Prepared& prepared, const native::PacketTarget& target, const Slicing& slicing = {},
                bool blocks = false) {
    Planner& p = prepared.p;
    NativeEngine engine(2, prepared.budgets.gpu, prepared.budgets.ram);
    p.layer().pageEdge = kGhostedEdge;
    p.chosen.chooser.reset();
    p.chosen.atlasPages = std::max<std::size_t>(1, pagesFor(p.layer().selection.counts));
    Counted out;
    loadBricks(engine, p, prepared.budgets.gpu, out.work);
    out.work = {};
    NativeCaster caster(p, engine, {true, false, false}, prepared.budgets.gpu, &target);
    if (blocks)
        caster.findBlocks();
    caster.begin(raysOf(p));
    drawToTheEnd(caster, engine, p, slicing, out.work);
    out.lanes = caster.lanes();
    return out;
}
Work ofTheMirror(const Prepared& prepared) {
    const FramePlan& p = prepared.p;
    Work work;
    MirrorInput input = mirrorInput(p, p.view.quality.skipping);
    input.segmentVoxels = p.view.frame.segmentVoxels;
    mirrorRays<float>(input, rayCount(p.view.imageSize), frameRays(cast<float>(p.view.frame)), 2, work);
    return work;
}

/// Waves of 0 to 1000 in a cube, and nothing around it.
Stored waves() {
    return Stored(
        [](const glm::dvec3& p) {
            const bool inside = p.x > 9 && p.x < 35 && p.y > 11 && p.y < 30 && p.z > 13 && p.z < 40;
            return inside
                       ? 500 + 300 * std::sin(0.7 * p.x) * std::cos(0.53 * p.y) + 200 * std::sin(0.61 * p.z)
                       : -500;
        },
        {44, 40, 48}, true);
}
TransferFunction thin() {
    return TransferFunction::fromOpacity({{300, 0}, {900, 0.2}}, {{0, {1, 0.5, 0.2}}}, 1);
}

class NativeWork : public testing::Test {
  protected:
    /// @param leaps  over empty space come a little later than the mirror's: then more segments are taken
    void check(const Scene& scene, bool leaps = false) {
        const auto prepared = stored_.prepare(scene);
        const Work mirror = ofTheMirror(*prepared);
        ASSERT_GT(mirror.segments, 1000u);
        for (const native::PacketTarget* target : nativeTargets()) {
            SCOPED_TRACE(target->name);
            const Counted mine = counted(*prepared, *target);
            const auto more = static_cast<double>(mine.work.segments) / static_cast<double>(mirror.segments);
            EXPECT_GE(more, 1);
            EXPECT_LE(more, leaps ? 1.05 : 1);
            EXPECT_EQ(mine.work.samples - mine.work.segments, mirror.samples - mirror.segments);
            EXPECT_GE(mine.work.iterations, mine.work.segments);
            EXPECT_NEAR(static_cast<double>(mine.work.iterations) / static_cast<double>(mirror.iterations), 1,
                        0.08);
            const auto width = static_cast<std::uint64_t>(target->lanes());
            EXPECT_EQ(mine.lanes.width, target->lanes());
            EXPECT_LE(mine.lanes.turns, mine.lanes.used);
            EXPECT_LE(mine.lanes.used, mine.lanes.turns * width);
            EXPECT_GE(mine.lanes.used, mine.work.segments);
            // All other samples are those of gradients.
            ASSERT_LE(mine.lanes.used, mine.work.samples);
            if (scene.shading.on) {
                EXPECT_EQ((mine.work.samples - mine.lanes.used) % 6, 0u);
            } else {
                EXPECT_EQ(mine.lanes.used, mine.work.samples);
            }
            EXPECT_GE(static_cast<double>(mine.lanes.used),
                      0.5 * static_cast<double>(mine.lanes.turns * width))
                << "most lanes of a packet have something to do";
            Slicing cut;
            cut.fixedIterations = 7;
            const Counted parts = counted(*prepared, *target, cut);
            EXPECT_LE(static_cast<double>(parts.work.segments), 1.05 * static_cast<double>(mirror.segments));
            EXPECT_GE(parts.work.segments, mirror.segments);
            EXPECT_GE(parts.work.samples - parts.work.segments, mirror.samples - mirror.segments);
        }
    }
    Stored stored_ = waves();
};

TEST_F(NativeWork, OfAVolumeIsTheMirrors) {
    for (const bool skipping : {true, false})
        for (const bool lit : {false, true}) {
            SCOPED_TRACE(lit ? "lit" : "unlit");
            Scene scene = stored_.scene({}, 1, 37);
            scene.volumes[0].transferFunction = thin();
            scene.quality.skipping = skipping;
            scene.shading.on = lit;
            check(scene, skipping);
        }
}

TEST_F(NativeWork, OfSegmentsByTheirEndsIsTheMirrors) {
    for (const Integrator integrator :
         {Integrator::linear, Integrator::preintegrated, Integrator::preintegrated2d}) {
        Scene scene = stored_.scene({}, 1, 37);
        scene.volumes[0].transferFunction = thin();
        scene.quality.integrator = integrator;
        check(scene);
    }
}

TEST_F(NativeWork, OfIsosurfacesIsTheMirrors) {
    for (const bool volume : {false, true}) {
        Scene scene = stored_.scene({{600, {1, 1, 1}, 0.4}}, 1, 37);
        if (volume)
            scene.volumes[0].transferFunction = thin();
        check(scene);
    }
}

TEST_F(NativeWork, OfSingleValuesIsTheMirrors) {
    for (const Mode mode : {Mode::maximum, Mode::average}) {
        Scene scene = stored_.scene({}, 1, 37);
        scene.volumes[0].transferFunction = "auto";
        scene.mode = mode;
        check(scene);
    }
}

/// Ridges of 0 to 900 along each axis, of different widths, by sums that are exact on every machine; and
/// nothing around them.
Stored ridges() {
    const auto ridge = [](double x) { return std::abs(x - 2 * std::floor(0.5 * x) - 1); }; // 1, 0, 1, ...
    return Stored(
        [=](const glm::dvec3& p) {
            const bool inside = p.x > 5 && p.x < 52 && p.y > 9 && p.y < 41 && p.z > 11 && p.z < 60;
            return inside ? 300 * (ridge(p.x / 8) + ridge(p.y / 16) + ridge(p.z / 4 + p.x / 32)) : -500.0;
        },
        {61, 50, 67}, true);
}

struct Figures {
    std::string target;
    std::uint64_t iterations, segments, samples, turns, used;
};
// Rays that leap less, wait longer for one another or take samples twice give the same picture, later. So
// their work is held to what it was when this was written, a five-hundredth more or less.
TEST(NativeWorkFigures, AreWhatTheyWere) {
#if !defined(__x86_64__)
    GTEST_SKIP() << "packets of other processors have other registers, and wait otherwise";
#endif
    struct Row {
        std::string what;
        Scene scene;
        std::vector<Figures> figures; // of each instruction set
    };
    const Stored stored = ridges();
    const TransferFunction thin =
                               TransferFunction::fromOpacity({{500, 0}, {800, 0.1}}, {{0, {1, 0.5, 0.2}}}, 1),
                           dense = TransferFunction::fromOpacity({{400, 0}, {450, 0.9}}, {}, 1);
    const auto sceneOf = [&](const TransferFunction& function, bool lit, Integrator integrator, Mode mode,
                             int camera) {
        Scene scene = stored.scene({}, camera, 53);
        scene.volumes[0].transferFunction = function;
        scene.shading.on = lit;
        scene.quality.integrator = integrator;
        scene.mode = mode;
        return scene;
    };
    const auto composite = [&](const TransferFunction& function, bool lit, Integrator integrator,
                               int camera) {
        return sceneOf(function, lit, integrator, Mode::composite, camera);
    };
    std::vector<Row> rows = {
        {"thin",
         composite(thin, false, Integrator::midpoint, 0),
         {{"baseline", 172823, 163794, 163794, 22546, 163794},
          {"avx2", 172643, 163617, 163617, 11724, 163617},
          {"avx512", 172073, 163049, 163049, 6336, 163049}}},
        {"lit",
         composite(thin, true, Integrator::midpoint, 1),
         {{"baseline", 152349, 149296, 333010, 19712, 149296},
          {"avx2", 152349, 149296, 333010, 10752, 149296},
          {"avx512", 152349, 149296, 333010, 6720, 149296}}},
        {"dense",
         composite(dense, false, Integrator::midpoint, 2),
         {{"baseline", 222003, 220073, 220073, 30367, 220073},
          {"avx2", 221562, 219632, 219632, 15945, 219632},
          {"avx512", 221269, 219339, 219339, 8172, 219339}}},
        {"linear",
         composite(thin, false, Integrator::linear, 1),
         {{"baseline", 153413, 149296, 150629, 19712, 150629},
          {"avx2", 153413, 149296, 150629, 10752, 150629},
          {"avx512", 153413, 149296, 150629, 6720, 150629}}},
        {"preintegrated",
         composite(thin, true, Integrator::preintegrated, 0),
         {{"baseline", 170844, 164260, 380765, 22700, 166781},
          {"avx2", 170844, 164260, 380765, 11822, 166781},
          {"avx512", 170844, 164260, 380765, 6387, 166781}}},
        {"maximum",
         sceneOf(thin, false, Integrator::midpoint, Mode::maximum, 1),
         {{"baseline", 230073, 229234, 229234, 33980, 229234},
          {"avx2", 230073, 229234, 229234, 17206, 229234},
          {"avx512", 230073, 229234, 229234, 9468, 229234}}},
        {"minimum",
         sceneOf(thin, false, Integrator::midpoint, Mode::minimum, 0),
         {{"baseline", 2792, 2792, 2792, 373, 2792},
          {"avx2", 2792, 2792, 2792, 193, 2792},
          {"avx512", 2792, 2792, 2792, 98, 2792}}},
        {"average",
         sceneOf(thin, false, Integrator::midpoint, Mode::average, 2),
         {{"baseline", 230930, 230930, 230930, 31979, 230930},
          {"avx2", 230930, 230930, 230930, 16805, 230930},
          {"avx512", 230930, 230930, 230930, 8629, 230930}}},
        {"mixed",
         composite(thin, false, Integrator::midpoint, 1),
         {{"baseline", 125403, 124941, 124941, 18764, 124941},
          {"avx2", 125421, 124959, 124959, 9504, 124959},
          {"avx512", 125421, 124959, 124959, 5805, 124959}}},
        {"mixed, linear",
         composite(thin, true, Integrator::linear, 0),
         {{"baseline", 145111, 144181, 275700, 20156, 147168},
          {"avx2", 145111, 144181, 275700, 10502, 147168},
          {"avx512", 145111, 144181, 275700, 5907, 147168}}},
        {"blocks",
         composite(thin, false, Integrator::midpoint, 1),
         {{"baseline", 92931, 69767, 69767, 10643, 69767},
          {"avx2", 92115, 68951, 68951, 6115, 68951},
          {"avx512", 91995, 68831, 68831, 3471, 68831}}},
        {"surfaces",
         stored.scene({{300, {1, 1, 1}, 0.3}, {650, {1, 0, 0}, 0.5}}, 1, 53),
         {{"baseline", 153413, 149296, 483493, 59312, 449221},
          {"avx2", 153413, 149296, 483493, 32352, 449221},
          {"avx512", 153413, 149296, 483493, 20220, 449221}}},
        {"surfaces in a volume",
         stored.scene({{300, {1, 1, 1}, 0.3}}, 0, 53),
         {{"baseline", 173075, 164270, 1262603, 204913, 1029899},
          {"avx2", 173075, 164270, 1262603, 116679, 1029899},
          {"avx512", 173075, 164270, 1262603, 68174, 1029899}}},
    };
    rows.back().scene.volumes[0].transferFunction = thin;
    for (const auto& [name, scene, figures] : rows) {
        SCOPED_TRACE(name);
        const auto prepared = stored.prepare(scene);
        if (name.starts_with("mixed")) {
            Selection levels = prepared->p.layer().selection;
            levels.counts = {};
            for (std::size_t b = 0; b < levels.levels.size(); ++b) {
                if (levels.levels[b] != Selection::kEmpty)
                    levels.levels[b] = static_cast<std::uint8_t>(b * 5 % 4);
                ++levels.counts[levels.levels[b]];
            }
            prepared->p.setSelection(levels);
            ASSERT_TRUE(prepared->p.layer().mixed());
        }
        for (const native::PacketTarget* target : nativeTargets()) {
            SCOPED_TRACE(target->name);
            const Counted now = counted(*prepared, *target, {}, name == "blocks");
            const auto then = std::find_if(figures.begin(), figures.end(),
                                           [&](const Figures& f) { return target->name == f.target; });
            ASSERT_NE(then, figures.end());
            const auto expectAbout = [](std::uint64_t found, std::uint64_t expected) {
                EXPECT_NEAR(static_cast<double>(found), static_cast<double>(expected),
                            0.002 * static_cast<double>(expected));
            };
            expectAbout(now.work.iterations, then->iterations);
            expectAbout(now.work.segments, then->segments);
            expectAbout(now.work.samples, then->samples);
            expectAbout(now.lanes.turns, then->turns);
            expectAbout(now.lanes.used, then->used);
        }
    }
}

/// Rays of a packet that stay inside the middle brick of three along each axis: in the cells that begin
/// there.
native::PacketJob jobInside(const native::PacketTarget& target) {
    native::PacketJob job;
    for (int lane = 0; lane < target.lanes(); ++lane) {
        const float across[3] = {static_cast<float>(lane % 4), static_cast<float>(lane / 4 % 4),
                                 static_cast<float>(lane / 16)};
        for (int axis = 0; axis < 3; ++axis) { // from corner to corner, from face to face
            const float from = 32.53125f + 4 * across[axis], to = 64.46875f - 3 * across[(axis + 1) % 3];
            job.entry[axis][lane] = lane % 2 ? to : from;
            job.step[axis][lane] = (lane % 2 ? from - to : to - from) / 64;
            job.direction[axis][lane] = job.step[axis][lane];
        }
        job.segmentMm[lane] = 0.5f;
        job.tail[lane] = 0.75f;
        job.count[lane] = 64;
        job.next[lane] = 0;
        for (auto& channel : job.colour)
            channel[lane] = 0;
    }
    return job;
}

// With ghost layers a brick has all that rays inside it need, gradients included: they read no other brick
// and ask the scalar text for nothing. If all others are taken away, no bit changes.
TEST(NativeWorkFigures, RaysInsideABrickNeedNoOther) {
    for (const ValueType type : {ValueType::f32, ValueType::i16}) {
        const Stored stored(
            [](const glm::dvec3& p) {
                return 400 + 3 * p.x - 2 * p.y + 40 * (std::fmod(p.z, 7) - 3) + 10 * std::fmod(p.x + p.y, 5);
            },
            {96, 80, 96}, true, 1, type);
        struct Row {
            const char* what;
            Gradient gradient;
            Integrator integrator;
            Mode mode = Mode::composite;
            bool surfaces = false;
        };
        for (const Row& row :
             {Row{"central", Gradient::central, Integrator::midpoint},
              Row{"half central", Gradient::centralHalf, Integrator::midpoint},
              Row{"forward", Gradient::forward, Integrator::midpoint},
              Row{"Sobel", Gradient::sobel, Integrator::linear},
              Row{"cubic", Gradient::cubic, Integrator::midpoint},
              Row{"preintegrated", Gradient::central, Integrator::preintegrated},
              Row{"maximum", Gradient::central, Integrator::midpoint, Mode::maximum},
              Row{"average", Gradient::central, Integrator::midpoint, Mode::average},
              Row{"surfaces", Gradient::sobel, Integrator::midpoint, Mode::composite, true}}) {
            SCOPED_TRACE(row.what);
            Scene scene = stored.scene({}, 0, 16);
            if (row.surfaces)
                scene.surfaces = {{420, {1, 0.5, 0.2}, 0.1}, {500, {0.2, 0.5, 1}, 0.2}};
            else
                scene.volumes[0].transferFunction =
                    TransferFunction::fromOpacity({{100, 0.01}, {900, 0.05}}, {{300, {1, 0.5, 0.2}}}, 1);
            scene.shading.on = row.mode == Mode::composite;
            scene.shading.gradient = row.gradient;
            scene.quality.integrator = row.integrator;
            scene.quality.skipping = false;
            scene.mode = row.mode;
            const auto prepared = stored.prepare(scene, false);
            Planner& p = prepared->p;
            NativeEngine engine(1, prepared->budgets.gpu, prepared->budgets.ram);
            p.layer().pageEdge = kGhostedEdge;
            p.chosen.chooser.reset();
            p.chosen.atlasPages = pagesFor(p.layer().selection.counts);
            Work work;
            loadBricks(engine, p, prepared->budgets.gpu, work);
            NativeCaster caster(p, engine, {true, false, false}, prepared->budgets.gpu, nullptr);
            caster.begin(raysOf(p));
            drawToTheEnd(caster, engine, p, {}, work); // all is settled
            native::PacketScene whole = caster.packetScene();
            ASSERT_EQ(p.layer().selection.bricks, glm::ivec3(3, 3, 3));
            int asked = 0;
            whole.help.context = &asked;
            whole.help.expired = [](const void*) { return false; };
            whole.help.gradient = [](const void* context, const float*, float* gradient, bool*) {
                ++*static_cast<int*>(const_cast<void*>(context));
                std::fill(gradient, gradient + 3, 1.0f);
            };
            std::vector<native::PacketBrick> bricks(whole.field.bricks, whole.field.bricks + 27);
            for (std::size_t b = 0; b < 27; ++b)
                if (b != 13) {
                    bricks[b] = {};
                    bricks[b].low = native::PacketBrick::kAbsent << 24 | 0x090909;
                    bricks[b].high = 0x080808;
                }
            native::PacketScene alone = whole;
            alone.field.bricks = bricks.data();
            for (const native::PacketTarget* target : nativeTargets()) {
                native::PacketJob first = jobInside(*target), second = first;
                target->march(whole)(whole, first);
                target->march(alone)(alone, second);
                EXPECT_EQ(first.waiting, 0u);
                EXPECT_EQ(second.waiting, 0u) << target->name << ": they wait for a brick";
                bool seen = false;
                for (int lane = 0; lane < target->lanes(); ++lane)
                    for (int c = 0; c < 4; ++c) {
                        EXPECT_EQ(second.colour[c][lane], first.colour[c][lane]) << target->name << lane;
                        seen = seen || first.colour[c][lane] > 0;
                    }
                EXPECT_TRUE(seen);
                EXPECT_EQ(asked, 0) << target->name;
            }
        }
    }
}

} // namespace
} // namespace tessera
