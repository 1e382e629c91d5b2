// render/plan/choose_integrator.cpp: see choose_integrator.h.
#include "render/plan/choose_integrator.h"

#include "render/contract/integrators.h"
#include "render/contract/preintegration.h"

#include <algorithm>
#include <cmath>

namespace tessera {
namespace {

/// From here on the midpoint rule misses or doubles features: its error on a linear rise is half of the
/// integral. Below it midpoint with shorter steps is as accurate in the same time
/// (docs/measurements/accuracy.md).
constexpr double kSharp = 0.5;
/// Up to here pre-integration gained nothing on any scan and preset.
constexpr double kSmooth = 0.05;
constexpr int kTriedPhases = 16;
constexpr double kMostSegments = 20000; // of a rise: narrower ones make no difference

} // namespace

double typicalChangePerVoxel(const Statistics& statistics, const TransferTable& table,
                             const VolumeInfo& info) {
    const auto physical = [&](float stored) {
        return info.rescaleSlope * static_cast<double>(stored) + info.rescaleIntercept;
    };
    const auto empty = [&](float lowest, float highest) {
        const double a = physical(lowest), b = physical(highest);
        return table.emptyOver(std::min(a, b), std::max(a, b));
    };
    std::vector<float> ranges;
    for (std::size_t b = 0; b < statistics.brickMin.size(); ++b) {
        if (empty(statistics.brickMin[b], statistics.brickMax[b]))
            continue; // and all of its cells
        const glm::ivec3 first = gridPosition(b, statistics.bricks) * kCellsPerBrick;
        const glm::ivec3 end = glm::min(first + kCellsPerBrick, statistics.cells);
        for (int z = first.z; z < end.z; ++z)
            for (int y = first.y; y < end.y; ++y)
                for (int x = first.x; x < end.x; ++x) {
                    const std::size_t cell = linearIndex({x, y, z}, statistics.cells);
                    const float lowest = statistics.cellMin[cell], highest = statistics.cellMax[cell];
                    if (!empty(lowest, highest))
                        ranges.push_back(static_cast<float>(std::abs(physical(highest) - physical(lowest))));
                }
    }
    if (ranges.empty())
        return 0;
    const auto rank =
        ranges.begin() + static_cast<std::ptrdiff_t>(0.9 * static_cast<double>(ranges.size() - 1));
    std::nth_element(ranges.begin(), rank, ranges.end());
    return static_cast<double>(*rank) / 3;
}

double midpointRampError(const TransferTable& table, double change, double lowest, double highest) {
    const auto last = static_cast<double>(table.entries.size() - 1);
    const double perValue = static_cast<double>(table.entriesPerValue);
    const double first = std::min(0.0, (lowest - static_cast<double>(table.firstValue)) * perValue);
    const double end = std::max(last, (highest - static_cast<double>(table.firstValue)) * perValue);
    const double step = std::max(change * perValue, (end - first) / kMostSegments);
    const TableIntegral integral(table.entries);
    const auto upTo = [&](double place) { // constant beyond the table
        const double inside = std::clamp(place, 0.0, last);
        const double beyond = place < 0 ? place * static_cast<double>(table.entries.front().a)
                                        : (place - inside) * static_cast<double>(table.entries.back().a);
        return integral.upTo(inside).a + beyond;
    };
    const auto extinction = [&](double place) {
        const double inside = std::clamp(place, 0.0, last);
        const auto bin = std::min(static_cast<std::size_t>(inside), table.entries.size() - 2);
        const double a = table.entries[bin].a, b = table.entries[bin + 1].a;
        return a + (inside - static_cast<double>(bin)) * (b - a);
    };
    const double whole = upTo(end) - upTo(first);
    if (!(whole > 0))
        return 0;
    double squares = 0;
    for (int phase = 0; phase < kTriedPhases; ++phase) {
        double error = 0;
        for (double x = first - step * (phase + 0.5) / kTriedPhases; x < end; x += step)
            error += step * extinction(x + 0.5 * step) - (upTo(x + step) - upTo(x));
        squares += error * error / kTriedPhases;
    }
    return std::sqrt(squares) / whole;
}

double attenuationDifference(const TransferTable& table, double change, double segmentMm) {
    Optics o;
    o.table = table.entries;
    setIntegrator(o, Integrator::preintegrated);
    o.scale = 1; // units are stored values
    const auto last = static_cast<double>(table.entries.size() - 1);
    const double step = std::min(change * static_cast<double>(table.entriesPerValue), last);
    const TableIntegral integral(o.table);
    double largest = 0;
    constexpr int kPlaces = 64;
    for (int i = 0; i < kPlaces; ++i) {
        const double low = (last - step) * i / (kPlaces - 1);
        for (const bool rises : {true, false}) {
            const auto front = endOf(o, rises ? low : low + step), back = endOf(o, rises ? low + step : low);
            const double alpha = opacityOf(segmentExtinction(o, front, back) * segmentMm);
            const glm::dvec3 difference = preintegratedColour(integral, front.place, back.place, segmentMm) -
                                          meanColour(o, front, back);
            for (int c = 0; c < 3; ++c)
                largest = std::max(largest, alpha * std::abs(difference[c]));
        }
    }
    return largest;
}

namespace {
double rampError(const Statistics& statistics, const TransferTable& table, const VolumeInfo& info,
                 double stepVoxels) {
    const double change = stepVoxels * typicalChangePerVoxel(statistics, table, info);
    const double a = info.rescaleSlope * static_cast<double>(statistics.lowest) + info.rescaleIntercept;
    const double b = info.rescaleSlope * static_cast<double>(statistics.highest) + info.rescaleIntercept;
    return midpointRampError(table, change, std::min(a, b), std::max(a, b));
}
} // namespace

bool isSharp(const Statistics& statistics, const TransferTable& table, const VolumeInfo& info,
             double stepVoxels) {
    return rampError(statistics, table, info, stepVoxels) >= kSharp;
}

bool isSmooth(const Statistics& statistics, const TransferTable& table, const VolumeInfo& info,
              double stepVoxels) {
    return rampError(statistics, table, info, stepVoxels) <= kSmooth;
}

} // namespace tessera
