// The computations of `tessera accuracy`: the choice of settings, envelopes and their readings, orders and
// intervals. Also the columns of runs.csv, curves of other renderers, and stiff extinction.
#include "tests/bench/accuracy/pareto.h"
#include "tests/bench/accuracy/runs_table.h"
#include "tests/bench/accuracy/scene_section.h"
#include "tests/bench/accuracy/scenes.h"
#include "tests/bench/accuracy/stiff.h"
#include "tests/support/accuracy_fixture.h"

#include "bricking/import/importer.h"
#include "core/base/error.h"
#include "core/base/program_folders.h"
#include "datasets/phantom.h"
#include "render/plan/frame_plan.h"
#include "tests/bench/report/page.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <set>

namespace tessera::accuracy {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(Envelope, KeepsWhatNothingBeatsInBoth) {
    const auto envelope = paretoEnvelope({{0.1, 10, 0},
                                          {0.2, 20, 1},
                                          {0.01, 40, 2},
                                          {0.01, 50, 3},
                                          {0.5, 5, 4},
                                          {0.05, 10, 5},
                                          {0.001, 0, 6}});
    std::vector<std::size_t> settings;
    for (const WorkPoint& p : envelope)
        settings.push_back(p.setting);
    EXPECT_THAT(settings, ElementsAre(4, 5, 2)); // 6 was never timed
}

TEST(Envelope, IsReadBetweenItsPointsAndNeverBeyond) {
    const std::vector<WorkPoint> e = paretoEnvelope({{1e-1, 10, 0}, {1e-3, 1000, 1}});
    EXPECT_NEAR(*timeAtError(e, 1e-2), 100, 1e-9); // half way on the log-log line
    EXPECT_NEAR(*errorAtTime(e, 100), 1e-2, 1e-12);
    EXPECT_EQ(*timeAtError(e, 0.5), 10); // the fastest is better already
    EXPECT_EQ(*errorAtTime(e, 1e6), 1e-3);
    EXPECT_FALSE(timeAtError(e, 1e-4));
    EXPECT_FALSE(errorAtTime(e, 9));
    EXPECT_FALSE(timeAtError({}, 1));
    EXPECT_FALSE(errorAtTime({}, 1));
}

TEST(FittedOrder, IsTheSlopeAboveTheFloor) {
    std::vector<std::pair<double, double>> second;
    for (const double h : {0.125, 2.0, 0.5, 1.0, 0.25})
        second.emplace_back(h, 0.03 * h * h);
    EXPECT_NEAR(fittedOrder(second, 1e-9)->slope, 2, 1e-9);
    EXPECT_EQ(fittedOrder(second, 1e-9)->points, 5u);
    EXPECT_EQ(fittedOrder(second, 0.001)->points, 4u); // 0.00047 is below the floor
    for (auto& [h, error] : second)
        error = std::max(error, 0.007); // stalls from 1/2 on
    EXPECT_EQ(fittedOrder(second, 0)->points, 3u);
    EXPECT_FALSE(fittedOrder({{2, 0.1}, {1, 0.1}, {0.5, 0.1}}, 0));
    EXPECT_FALSE(fittedOrder({{2, 0.1}, {1, 0.05}}, 0));
}

TEST(BootstrapRatio, ClaimsOnlyWhatBlocksAgreeOn) {
    const RatioInterval twice = bootstrapRatio({20, 20.2, 20.1, 20.4, 20.1}, {10, 10.1, 10.3, 10, 10.2});
    EXPECT_GT(twice.low, 1.9);
    EXPECT_LT(twice.high, 2.1);
    EXPECT_TRUE(twice.claimed(2));
    EXPECT_FALSE(bootstrapRatio({20, 9, 14, 11, 30}, {10, 15, 9, 22, 12}).claimed(1));
    EXPECT_FALSE(bootstrapRatio({10.1, 10.1}, {10, 10}).claimed(1.01)) << "one percent is nothing";
}

TEST(Quantiles, AreLinearBetweenRanks) {
    EXPECT_EQ(quantile({3, 1, 2}, 0), 1);
    EXPECT_EQ(quantile({3, 1, 2}, 0.5), 2);
    EXPECT_EQ(quantile({3, 1, 2}, 0.75), 2.5);
    EXPECT_EQ(quantile({7}, 0.95), 7);
}

TEST(Plan, HasTheProductAndASweepAlongEachAxis) {
    for (const bool quick : {true, false}) {
        const std::vector<Planned> plan = plannedSettings(plainScene(), quick);
        std::set<std::string> names, axes;
        std::set<std::pair<Integrator, Fetch>> methods;
        for (const Planned& p : plan) {
            EXPECT_TRUE(names.insert(settingName(p.setting)).second) << settingName(p.setting) << " twice";
            axes.insert(p.axis);
            if (p.axis == "product")
                methods.emplace(p.setting.integrator, p.setting.fetch);
        }
        EXPECT_EQ(methods.size(), 8u);
        EXPECT_THAT(axes, ElementsAre("default", "edges", "levels", "memory", "product", "termination"));
        EXPECT_EQ(plan.front().setting, settingOf(plainScene()));
    }
    Scene lit = plainScene();
    lit.shading.on = true;
    const std::vector<Planned> plan = plannedSettings(lit, true);
    EXPECT_EQ(std::count_if(plan.begin(), plan.end(), [](const Planned& p) { return p.axis == "gradient"; }),
              static_cast<std::ptrdiff_t>(gradientNames().size()) - 1);
}

TEST(Plan, ASettingIsWhatTheSceneIsDrawnWith) {
    Setting s;
    s.stepVoxels = 0.125;
    s.integrator = Integrator::linear;
    s.fetch = Fetch::exact;
    s.termination = 0;
    s.gradient = Gradient::sobel;
    s.detail.finest = false;
    s.detail.maxError = 2;
    s.detail.edgeFunction = EdgeFunction::maximum;
    EXPECT_EQ(settingOf(withSetting(plainScene(), s)), s);
    EXPECT_EQ(settingName(s),
              "linear, exact, step 1/8, termination off, sobel gradient, levels 2, maximum edges");
}

TEST(Fractions, ReadAsPeopleWriteThem) {
    EXPECT_EQ(fractionText(0.0625), "1/16");
    EXPECT_EQ(fractionText(1.0 / 510), "1/510");
    EXPECT_EQ(fractionText(2), "2");
    EXPECT_EQ(fractionText(1e-4), "0.0001");
    EXPECT_EQ(fractionText(0.7), "0.7");
    EXPECT_EQ(fractionText(0), "off");
}

TEST(RunColumns, AreThoseOfThePlan) {
    std::string header;
    for (const std::string& column : runColumns())
        header += (header.empty() ? "" : ",") + column;
    EXPECT_EQ(header, "commit,machine,driver,scene,method,fetch,ert,lod_eps,step_vox,features,block,reps,"
                      "time_min_ms,time_med_ms,iqr_ms,p95_ms,gpu_ms,samples,fetches,bricks,bytes_decoded,"
                      "peak_host_MB,peak_gpu_MB,rmse,max_abs,p99_9,bias,frac_gt_1_255,psnr,ssim,dE_uv_mean,"
                      "dE_uv_p99,flip,nan_count,bound,bound_ok,ref_err");
}
TEST(Peers, AreReadByTheNamesOfTheirColumns) {
    const ScratchFolder folder;
    const auto file = folder / "peers.csv";
    std::ofstream(file)
        << "renderer,distance_voxels,time_min_ms,rmse\nvtk cpu,2,40.5,0.02\nvtk gpu,1,80,0.01\n";
    const std::vector<PeerPoint> points = loadPeers(file, "ct");
    ASSERT_EQ(points.size(), 2u);
    EXPECT_EQ(points[0].renderer, "vtk cpu");
    EXPECT_EQ(points[0].scene, "ct");
    EXPECT_EQ(points[1].ms, 80);
    EXPECT_EQ(points[1].rmse, 0.01);
    std::ofstream(file) << "scene,renderer,time_min_ms,rmse,masked_pixels\nhead,vtk,1,0.5,70\n";
    EXPECT_EQ(loadPeers(file, "ct").at(0).scene, "head");
    EXPECT_EQ(loadPeers(file, "ct").at(0).pixels, 70);
    const auto refused = [&](const std::string& text, const std::string& word) {
        std::ofstream(file) << text;
        try {
            loadPeers(file, "");
            FAIL() << text;
        } catch (const InputError& error) {
            EXPECT_THAT(error.what(), HasSubstr(word));
            EXPECT_THAT(error.what(), HasSubstr("peers.csv"));
        }
    };
    refused("", "column names");
    refused("renderer,time_min_ms\nvtk,1\n", "\"rmse\"");
    refused("renderer,time_min_ms,rmse\nvtk,1\n", "line 2");
    refused("renderer,time_min_ms,rmse\nvtk,fast,0.1\n", "\"fast\"");
    refused("renderer,time_min_ms,rmse\nvtk,1,nan\n", "\"nan\"");
}

TEST(Peers, MayHaveCommasInTheirNames) {
    const ScratchFolder folder;
    const auto file = folder / "peers.csv";
    std::ofstream(file) << "scene,renderer,time_min_ms,rmse\r\n"
                           "ct,\"vtk \"\"gpu\"\", whole volume (4 MiB)\",80,0.01\r\n";
    const std::vector<PeerPoint> points = loadPeers(file, "");
    ASSERT_EQ(points.size(), 1u);
    EXPECT_EQ(points[0].renderer, "vtk \"gpu\", whole volume (4 MiB)");
    EXPECT_EQ(points[0].rmse, 0.01);
}

TEST(Peers, StandBesideTheirOwnScene) {
    const Sweep head = madeUp("head", 0.01, 0.001), foot = madeUp("foot", 0.01, 0.001),
                plain = madeUp("plain", 0.01, 0.001);
    const std::vector<PeerPoint> peers = {{"head", "vtk gpu, whole volume (4 MiB)", 5, 0.005, 90},
                                          {"foot", "another", 7, 0.004, 0},
                                          {"head", "vtk gpu, whole volume (4 MiB)", 3, 0.05, 90}};
    const auto columnsOf = [&](const Sweep& sweep) {
        return sceneSection(sweep, peers).tables.at(0).columns;
    };
    EXPECT_THAT(columnsOf(head), ElementsAre("error", "midpoint, hardware", "vtk gpu, whole volume (4 MiB)",
                                             "fastest", "speed-up"));
    EXPECT_THAT(columnsOf(foot),
                ElementsAre("error", "another", "midpoint, hardware", "fastest", "speed-up"));
    EXPECT_THAT(columnsOf(plain), ElementsAre("error", "midpoint, hardware", "fastest", "speed-up"));
    const bench::Report report = sceneSection(head, peers);
    const auto curves = report.plots.at(0).curves;
    const auto vtk =
        std::find_if(curves.begin(), curves.end(), [](const auto& c) { return c.label.starts_with("vtk"); });
    ASSERT_NE(vtk, curves.end());
    EXPECT_EQ(vtk->points, (std::vector<std::pair<double, double>>{{3, 0.05}, {5, 0.005}}));
    // The input of VTK is reported in sections that hold VTK, and nowhere else.
    EXPECT_THAT(report.text, ::testing::Contains(HasSubstr("opacity unit distance")));
    EXPECT_THAT(report.text, ::testing::Contains(HasSubstr("(4 MiB)` are over 90 pixels.")));
    EXPECT_THAT(sceneSection(foot, peers).text, ::testing::Not(::testing::Contains(HasSubstr("VTK"))));
    EXPECT_THAT(sceneSection(foot, peers).text, ::testing::Contains(HasSubstr("not interleaved")));
    EXPECT_THAT(sceneSection(plain, peers).text,
                ::testing::Not(::testing::Contains(HasSubstr("interleaved"))));
}

// Midpoint with 64 segments.
TEST(Stiff, MidpointIsAsMeasuredElsewhere) {
    const std::vector<StiffCurve> curves = stiffCurves();
    const auto found = std::find_if(curves.begin(), curves.end(),
                                    [](const StiffCurve& c) { return c.name == "midpoint, double"; });
    ASSERT_NE(found, curves.end());
    const auto at = [&](double depth) {
        for (const auto& [x, error] : found->points)
            if (std::abs(x / depth - 1) < 1e-9)
                return error;
        return -1.0;
    };
    EXPECT_NEAR(at(1e-6), 2.6e-11, 1e-12);
    EXPECT_NEAR(at(1), 2.9e-5, 1e-6);
    EXPECT_NEAR(at(100), 6.6e-3, 1e-4);
    EXPECT_NEAR(at(1e6), 2.7e-2, 1e-3);
    EXPECT_EQ(curves.size(), 8u); // every integrator in double and in float
    for (const StiffCurve& curve : curves)
        for (const auto& [depth, error] : curve.points) {
            EXPECT_TRUE(std::isfinite(error) && error >= 0 && error < 0.1) << curve.name << " " << depth;
            if (curve.name.starts_with("linear")) {
                // In float, one segment stays below 1e-6; this is the sum of 64, each rounded.
                EXPECT_LT(error, curve.name == "linear, double" ? 1e-9 : 4e-6) << depth;
            }
        }
}

TEST(Defaults, AreTheFastestWithinOne255th) {
    const Sweep easy = madeUp("easy", 0.001, 0.0001), hard = madeUp("hard", 0.01, 0.002),
                hopeless = madeUp("hopeless", 0.1, 0.05);
    EXPECT_EQ(paretoChoice(easy)->planned.setting.stepVoxels, 1);
    EXPECT_EQ(paretoChoice(hard)->planned.setting.stepVoxels, 0.5);
    EXPECT_EQ(paretoChoice(hopeless), nullptr);
    EXPECT_EQ(easy.measured[0].leastMs(), 10);
    const std::vector<CommonChoice> common = commonChoices({easy, hard, hopeless});
    ASSERT_EQ(common.size(), 1u); // only the finer step serves both
    EXPECT_EQ(common[0].setting.stepVoxels, 0.5);
    EXPECT_NEAR(common[0].slowdown, std::sqrt(2.0), 1e-12); // twice in one, once in the other
}

TEST(RunsTable, HasARowForEveryBlock) {
    const std::string machine = "a machine, of some kind";
    const bench::Table table = runsTable({madeUp("easy", 0.1, 0.01)}, {"Tessera 1", "0123abcd", machine});
    ASSERT_EQ(table.rows.size(), 4u);
    for (const auto& row : table.rows)
        EXPECT_EQ(row.size(), table.columns.size());
    const std::string csv = bench::csvText(table);
    EXPECT_THAT(csv, HasSubstr("\n0123abcd,\"a machine, of some kind\",,easy,midpoint,hardware,"));
    // Without a commit the version stands for it.
    EXPECT_EQ(runsTable({madeUp("easy", 0.1, 0.01)}, {"Tessera 1", "", machine}).rows[0][0],
              bench::Cell("Tessera 1"));
}

} // namespace
} // namespace tessera::accuracy
