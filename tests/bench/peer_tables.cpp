// tests/bench/peer_tables.cpp: see peer_tables.h.
#include "tests/bench/peer_tables.h"

#include "core/base/error.h"
#include "tests/bench/bench_tools.h"
#include "tests/bench/report/work_precision.h"

#include <algorithm>
#include <cstdio>

namespace tessera::bench {
namespace {

/// A family's envelope: error of 8-bit pictures, least time.
std::vector<accuracy::WorkPoint> envelopeOf(const std::vector<Method>& methods, const std::string& family) {
    std::vector<accuracy::WorkPoint> points;
    for (std::size_t i = 0; i < methods.size(); ++i)
        if (methods[i].family == family)
            points.push_back({methods[i].rounded.rms, minimum(methods[i].ms), i});
    return accuracy::paretoEnvelope(std::move(points));
}

/// As a field of a CSV file.
std::string field(const std::string& text) {
    return text.find(',') == std::string::npos ? text : "\"" + text + "\"";
}

} // namespace

void printTables(const std::vector<Method>& methods, const std::vector<std::string>& families) {
    std::printf("\n| renderer | distance, voxels | min ms | median ms | rms 8 bit | max | L*u*v* p99 | with "
                "border | rms float |\n"
                "|---|---|---|---|---|---|---|---|---|\n");
    for (const Method& m : methods) {
        std::printf("| %s | %g | %.0f | %.0f | %.5f | %.3f | %.2f | %.5f | ", m.family.c_str(),
                    m.distanceVoxels, minimum(m.ms), median(m.ms), m.rounded.rms, m.rounded.maxAbs,
                    m.rounded.luvP99, m.rmsWithBorder);
        if (m.tessera)
            std::printf("%.6f |\n", m.asIs.rms);
        else
            std::printf("n/a |\n");
    }
    std::printf(
        "\nMinimum ms at equal error (rms of 8-bit pictures), interpolated, not extrapolated:\n\n| rms |");
    for (const std::string& family : families)
        std::printf(" %s |", family.c_str());
    std::printf("\n|---|");
    for (std::size_t i = 0; i < families.size(); ++i)
        std::printf("---|");
    std::vector<double> targets = {0.02, 0.01, 1.0 / 255, 0.002, 0.0015};
    for (const Method& m : methods)
        if (!m.tessera)
            targets.push_back(m.rounded.rms);
    std::sort(targets.rbegin(), targets.rend());
    for (const double target : targets) {
        std::printf("\n| %.5f |", target);
        for (const std::string& family : families)
            if (const auto ms = accuracy::timeAtError(envelopeOf(methods, family), target))
                std::printf(" %.0f |", *ms);
            else
                std::printf(" not reached |");
    }
    std::printf("\n");
}

void writeCsv(const std::string& path, const std::vector<Method>& methods, const RunOn& on) {
    std::FILE* file = std::fopen(path.c_str(), "w");
    if (!file)
        throw InputError(path + ": expected a file that can be written");
    std::fprintf(file, "scene,renderer,distance_voxels,time_min_ms,time_med_ms,rmse,max_abs,dE_uv_p99,"
                       "rmse_float,max_abs_float,dE_uv_p99_float,bias,dE_uv_mean,rmse_with_border,"
                       "masked_pixels,rounds,segments,samples,fetches,load_before,load_after,device\n");
    for (const Method& m : methods) {
        std::string device = m.tessera ? on.tesseraDevice : on.vtkDevice;
        std::replace(device.begin(), device.end(), ',', ';');
        std::fprintf(file, "%s,%s,%g,%.2f,%.2f,%.6f,%.5f,%.4f,", on.scene.c_str(), field(m.family).c_str(),
                     m.distanceVoxels, minimum(m.ms), median(m.ms), m.rounded.rms, m.rounded.maxAbs,
                     m.rounded.luvP99);
        if (m.tessera)
            std::fprintf(file, "%.3e,%.3e,%.5f,", m.asIs.rms, m.asIs.maxAbs, m.asIs.luvP99);
        else
            std::fprintf(file, "n/a,n/a,n/a,");
        std::fprintf(
            file, "%.6f,%.4f,%.6f,%zu,%zu,%llu,%llu,%llu,%.2f,%.2f,%s\n", m.rounded.bias, m.rounded.luvMean,
            m.rmsWithBorder, m.rounded.maskedPixels, m.ms.size(),
            static_cast<unsigned long long>(m.work.segments), static_cast<unsigned long long>(m.work.samples),
            static_cast<unsigned long long>(m.work.fetches), on.loadBefore, loadAverage(), device.c_str());
    }
    std::fclose(file);
}

} // namespace tessera::bench
