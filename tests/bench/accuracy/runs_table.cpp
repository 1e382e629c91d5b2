// tests/bench/accuracy/runs_table.cpp: see runs_table.h.
#include "tests/bench/accuracy/runs_table.h"

#include "tests/bench/report/work_precision.h"

#include <algorithm>

namespace tessera::accuracy {
namespace {

constexpr double kMiB = 1024.0 * 1024.0;

/// Compiled features, and properties of the setting that no other column gives.
std::string featuresText(const Measured& m) {
    const Setting& s = m.planned.setting;
    std::string text = m.features;
    const auto add = [&text](const std::string& name, const std::string& value) {
        text += "+" + name + "=" + value;
    };
    if (s.gradient)
        add("gradient", gradientNames()[static_cast<std::size_t>(*s.gradient)]);
    if (!s.detail.finest)
        add("levels", "chosen");
    if (s.detail.memoryShare != 1)
        add("memory", "1/" + std::to_string(s.detail.memoryShare));
    if (s.detail.memoryShare != 1 || s.detail.maxError)
        add("edges", edgeFunctionNames()[static_cast<std::size_t>(s.detail.edgeFunction)]);
    return text;
}

} // namespace

const std::vector<std::string>& runColumns() {
    static const std::vector<std::string> columns = {
        "commit",       "machine",     "driver",     "scene",     "method",  "fetch",       "ert",
        "lod_eps",      "step_vox",    "features",   "block",     "reps",    "time_min_ms", "time_med_ms",
        "iqr_ms",       "p95_ms",      "gpu_ms",     "samples",   "fetches", "bricks",      "bytes_decoded",
        "peak_host_MB", "peak_gpu_MB", "rmse",       "max_abs",   "p99_9",   "bias",        "frac_gt_1_255",
        "psnr",         "ssim",        "dE_uv_mean", "dE_uv_p99", "flip",    "nan_count",   "bound",
        "bound_ok",     "ref_err"};
    return columns;
}

bench::Table runsTable(const std::vector<Sweep>& sweeps, const MeasuredOn& on) {
    bench::Table table{"runs", "Every scene, setting and block:", runColumns(), {}, false};
    for (const Sweep& sweep : sweeps)
        for (const Measured& m : sweep.measured) {
            const Setting& s = m.planned.setting;
            const ImageError& e = m.error;
            for (std::size_t block = 0; block < m.blocks.size(); ++block) {
                const std::vector<double>& ms = m.blocks[block].wallMs;
                if (ms.empty())
                    continue;
                const auto count = [](auto n) { return static_cast<double>(n); };
                table.rows.push_back({on.commit.empty() ? on.version : on.commit,
                                      on.machine,
                                      sweep.device,
                                      sweep.scene.name,
                                      integratorNames()[static_cast<std::size_t>(s.integrator)],
                                      fetchNames()[static_cast<std::size_t>(s.fetch)],
                                      s.termination,
                                      s.detail.maxError ? bench::Cell(*s.detail.maxError) : bench::Cell(""),
                                      s.stepVoxels,
                                      featuresText(m),
                                      count(block + 1),
                                      count(ms.size()),
                                      quantile(ms, 0),
                                      quantile(ms, 0.5),
                                      quantile(ms, 0.75) - quantile(ms, 0.25),
                                      quantile(ms, 0.95),
                                      m.blocks[block].gpuMs,
                                      count(m.work.samples),
                                      count(m.work.fetches),
                                      count(m.work.bricksUploaded),
                                      count(m.bytesDecoded),
                                      count(m.peakRamBytes) / kMiB,
                                      count(m.peakGpuBytes) / kMiB,
                                      e.rmse,
                                      e.maxAbs,
                                      e.p999,
                                      e.bias,
                                      e.fracAbove1Of255,
                                      e.psnr,
                                      e.ssim,
                                      e.luvMean,
                                      e.luvP99,
                                      "",
                                      count(e.nanCount),
                                      m.bound,
                                      m.boundOk ? 1.0 : 0.0,
                                      sweep.proof.error()});
            }
        }
    return table;
}

bench::Table failTable(const std::vector<Sweep>& sweeps) {
    bench::Table table{"fail", "What was refused or went wrong:", {"scene", "setting", "what"}, {}, true};
    for (const Sweep& sweep : sweeps)
        for (const Failure& f : sweep.failures)
            table.rows.push_back({f.scene, f.setting, f.what});
    return table;
}

} // namespace tessera::accuracy
