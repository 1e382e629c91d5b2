// tests/bench/six_tables.cpp: see six_tables.h.
#include "tests/bench/six_tables.h"

#include "core/base/error.h"
#include "tests/bench/bench_tools.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace tessera::bench {
namespace {

constexpr double kNone = std::numeric_limits<double>::infinity();

/// A ratio of times, of a renderer that may not have got there: then it is more than this.
struct Ratio {
    double value = 0;
    bool atLeast = false;
};

std::string text(const std::optional<Ratio>& ratio) {
    if (!ratio)
        return "n/a";
    char out[32];
    std::snprintf(out, sizeof out, "%s%.2f", ratio->atLeast ? "> " : "", ratio->value);
    return out;
}

std::string text(const TimeAtTarget& time) {
    char out[32];
    std::snprintf(out, sizeof out, "%s%.0f%s", time.reached ? "" : "> ", time.ms,
                  time.reached && time.from == time.to ? " *" : "");
    return out;
}

std::string titleOf(const PictureResult& r) {
    return r.name + (r.lit ? ", lit" : ", plain") + " | " + r.store + " | " + std::to_string(r.size.x) + "x" +
           std::to_string(r.size.y);
}

/// The ratio of the times of the better of VTK's mappers and an engine.
std::optional<Ratio> vtkOver(const PictureResult& r, const std::string& engine, const OfRounds& of) {
    const auto at = [&](const std::string& name) { return r.contenders[indexOf(r.contenders, name)]; };
    const TimeAtTarget ours = timeAt(at(engine), r.target, of);
    if (!ours.reached)
        return std::nullopt;
    double best = kNone;
    for (const Contender& c : r.contenders)
        if (const TimeAtTarget time = timeAt(c, r.target, of); !c.tessera && time.reached)
            best = std::min(best, time.ms);
    if (best < kNone)
        return Ratio{best / ours.ms, false};
    if (indexOf(r.contenders, kVtkGpu) == r.contenders.size())
        return std::nullopt;
    // Neither got there; the GPU mapper's errors fall with the step, so that it would take longer yet.
    return Ratio{timeAt(at(kVtkGpu), r.target, of).ms / ours.ms, true};
}

std::optional<Ratio> engineOver(const PictureResult& r, const std::string& one, const std::string& other,
                                const OfRounds& of) {
    const TimeAtTarget a = timeAt(r.contenders[indexOf(r.contenders, one)], r.target, of);
    const TimeAtTarget b = timeAt(r.contenders[indexOf(r.contenders, other)], r.target, of);
    if (!b.reached)
        return std::nullopt;
    return Ratio{a.ms / b.ms, !a.reached};
}

std::vector<std::string> names(const PictureResult& r, bool tessera) {
    std::vector<std::string> out;
    for (const Contender& c : r.contenders)
        if (c.tessera == tessera)
            out.push_back(c.name);
    return out;
}

/// "| a | b |" and the line below a table's head.
void printHead(const std::vector<std::string>& columns) {
    for (const std::string& column : columns)
        std::printf("| %s ", column.c_str());
    std::printf("|\n");
    for (std::size_t i = 0; i < columns.size(); ++i)
        std::printf("|---");
    std::printf("|\n");
}

/// Of settings that were timed.
std::size_t mostRounds(const PictureResult& r) {
    std::size_t most = 0;
    for (const Contender& c : r.contenders)
        for (const Setting& s : c.settings)
            most = std::max(most, s.ms.size());
    return most;
}

/// The spread of a number over rounds.
struct Spread {
    double least = kNone, greatest = 0;
    void add(double value) {
        least = std::min(least, value);
        greatest = std::max(greatest, value);
    }
    std::string text() const {
        char out[64];
        std::snprintf(out, sizeof out, "%.2f to %.2f", least, greatest);
        return greatest > 0 ? out : "n/a";
    }
};
template <typename RatioOf> Spread spreadOf(const PictureResult& r, const RatioOf& ratioOf) {
    Spread spread;
    for (std::size_t round = 0; round < mostRounds(r); ++round)
        if (const std::optional<Ratio> ratio = ratioOf(r, ofRound(round)))
            spread.add(ratio->value);
    return spread;
}

/// The geometric mean of a ratio over pictures that have it, round by round.
template <typename RatioOf>
Spread spreadOfMean(const std::vector<PictureResult>& results, bool lit, bool bounds,
                    const RatioOf& ratioOf) {
    std::size_t rounds = 0;
    for (const PictureResult& r : results)
        rounds = std::max(rounds, mostRounds(r));
    Spread spread;
    for (std::size_t round = 0; round < rounds; ++round) {
        double sum = 0;
        int n = 0;
        for (const PictureResult& r : results) {
            if (r.lit != lit)
                continue;
            const std::optional<Ratio> ratio = ratioOf(r, ofRound(round));
            if (ratio && (bounds || !ratio->atLeast))
                sum += std::log(ratio->value), ++n;
        }
        if (n > 0)
            spread.add(std::exp(sum / n));
    }
    return spread;
}

/// Geometric means, and the least, of a ratio over pictures.
template <typename RatioOf>
void printMeans(const std::vector<PictureResult>& results, const std::string& what, const OfRounds& of,
                const RatioOf& ratioOf) {
    for (const bool lit : {false, true}) {
        double sum = 0, sumOfAll = 0;
        int n = 0, all = 0, pictures = 0;
        Ratio least{kNone, false};
        for (const PictureResult& r : results) {
            if (r.lit != lit)
                continue;
            ++pictures;
            const std::optional<Ratio> ratio = ratioOf(r, of);
            if (!ratio)
                continue;
            sumOfAll += std::log(ratio->value), ++all;
            if (!ratio->atLeast)
                sum += std::log(ratio->value), ++n;
            if (ratio->value < least.value)
                least = *ratio;
        }
        if (all == 0)
            continue;
        std::printf("- %s, %s: ", what.c_str(), lit ? "lit" : "plain");
        if (n > 0)
            std::printf("geometric mean %.2f (by rounds %s) over %d of %d pictures; ", std::exp(sum / n),
                        spreadOfMean(results, lit, false, ratioOf).text().c_str(), n, pictures);
        if (all > n)
            std::printf("at least %.2f (by rounds %s) over %d, those counted that are only known to be "
                        "larger; ",
                        std::exp(sumOfAll / all), spreadOfMean(results, lit, true, ratioOf).text().c_str(),
                        all);
        std::printf("least %s\n", text(least).c_str());
    }
}

void printTimes(const std::vector<PictureResult>& results) {
    const std::vector<std::string> engines = names(results.front(), true);
    const std::vector<std::string> peers = names(results.front(), false);
    std::vector<std::string> columns = {"scene", "volume", "pixels", "target: rms", "L*u*v* p99"};
    columns.insert(columns.end(), peers.begin(), peers.end());
    columns.insert(columns.end(), engines.begin(), engines.end());
    std::vector<std::pair<std::string, std::string>> pairs; // of engines
    for (const std::string& engine : engines)
        columns.push_back("best VTK / " + engine);
    for (std::size_t i = 1; i < engines.size(); ++i) {
        pairs.emplace_back(engines.front(), engines[i]);
        columns.push_back(engines.front() + " / " + engines[i]);
    }
    std::printf(
        "\nms at the target, minima of the rounds; in brackets the least and the greatest ratio of any "
        "round, where a setting with fewer rounds goes through them again. \"> t\": not reached, its finest "
        "setting takes t; \"*\": "
        "its coarsest setting is better already.\n\n");
    printHead(columns);
    for (const PictureResult& r : results) {
        std::printf("| %s | %.5f | %.2f ", titleOf(r).c_str(), r.target.rms, r.target.luvP99);
        for (const auto& list : {peers, engines})
            for (const std::string& name : list)
                std::printf(
                    "| %s ",
                    text(timeAt(r.contenders[indexOf(r.contenders, name)], r.target, minimum)).c_str());
        const auto print = [&](const auto& ratioOf) {
            std::printf("| %s (%s) ", text(ratioOf(r, minimum)).c_str(), spreadOf(r, ratioOf).text().c_str());
        };
        for (const std::string& engine : engines)
            print(
                [&](const PictureResult& of, const OfRounds& rounds) { return vtkOver(of, engine, rounds); });
        for (const auto& pair : pairs)
            print([&](const PictureResult& of, const OfRounds& rounds) {
                return engineOver(of, pair.first, pair.second, rounds);
            });
        std::printf("|\n");
    }
    std::printf("\n");
    const std::pair<OfRounds, const char*> kinds[] = {{minimum, "minima"}, {medianOf, "medians"}};
    for (const auto& [of, kind] : kinds) {
        for (const std::string& engine : engines)
            printMeans(results, std::string("best VTK / ") + engine + ", " + kind, of,
                       [&](const PictureResult& r, const OfRounds& f) { return vtkOver(r, engine, f); });
        for (const auto& pair : pairs)
            printMeans(results, pair.first + " / " + pair.second + ", " + kind, of,
                       [&](const PictureResult& r, const OfRounds& f) {
                           return engineOver(r, pair.first, pair.second, f);
                       });
    }
}

void printAtCpuError(const std::vector<PictureResult>& results) {
    if (indexOf(results.front().contenders, kVtkCpu) == results.front().contenders.size())
        return;
    const std::vector<std::string> engines = names(results.front(), true);
    std::vector<std::string> columns = {"scene", "volume", "pixels", "rms", "voxels", kVtkCpu};
    columns.insert(columns.end(), engines.begin(), engines.end());
    for (const std::string& engine : engines)
        columns.push_back(std::string(kVtkCpu) + " / " + engine);
    std::printf(
        "\nms at the error of VTK's CPU mapper (the cheapest of its settings within 5 %% of its least "
        "rms), minima; without lit pictures in perspective, whose light it does not know:\n\n");
    printHead(columns);
    for (const PictureResult& r : results) {
        if (!r.cpuMapperSeesTheLight)
            continue;
        const Contender& cpu = r.contenders[indexOf(r.contenders, kVtkCpu)];
        const Setting& best = cpu.settings[cheapestOfBest(cpu)];
        const double cpuMs = minimum(best.ms);
        std::printf("| %s | %.5f | %g | %.0f ", titleOf(r).c_str(), best.error.rms, best.voxels, cpuMs);
        std::vector<TimeAtTarget> times;
        for (const std::string& engine : engines) {
            times.push_back(timeAt(r.contenders[indexOf(r.contenders, engine)],
                                   {best.error.rms, std::numeric_limits<double>::infinity()}, minimum));
            std::printf("| %s ", text(times.back()).c_str());
        }
        for (const TimeAtTarget& time : times)
            if (time.reached)
                std::printf("| %.2f ", cpuMs / time.ms);
            else
                std::printf("| n/a ");
        std::printf("|\n");
    }
}

/// The work of the first setting that meets the target, of engines that count.
void printWork(const std::vector<PictureResult>& results) {
    std::printf("\nWork of the first setting that meets the target:\n\n");
    printHead({"scene", "volume", "pixels", "engine", "voxels", "ms", "segments, M", "samples, M",
               "segments, M/s", "samples, M/s"});
    for (const PictureResult& r : results)
        for (const Contender& c : r.contenders) {
            const TimeAtTarget time = timeAt(c, r.target, minimum);
            const Setting& setting = c.settings[time.to];
            if (!c.tessera || !time.reached || setting.work.segments == 0)
                continue;
            const double ms = minimum(setting.ms),
                         segments = 1e-6 * static_cast<double>(setting.work.segments),
                         samples = 1e-6 * static_cast<double>(setting.work.samples);
            std::printf("| %s | %s | %g | %.0f | %.2f | %.2f | %.1f | %.1f |\n", titleOf(r).c_str(),
                        c.name.c_str(), setting.voxels, ms, segments, samples, 1e3 * segments / ms,
                        1e3 * samples / ms);
        }
}

} // namespace

std::size_t indexOf(const std::vector<Contender>& contenders, const std::string& name) {
    const auto found = std::find_if(contenders.begin(), contenders.end(),
                                    [&](const Contender& c) { return c.name == name; });
    return static_cast<std::size_t>(found - contenders.begin());
}

void printSixTables(const std::vector<PictureResult>& results) {
    if (results.empty())
        return;
    printTimes(results);
    printAtCpuError(results);
    printWork(results);
}

void writeSixCsv(const std::filesystem::path& path, const std::vector<PictureResult>& results) {
    std::FILE* file = std::fopen(path.c_str(), "w");
    if (!file)
        throw InputError(path.string() + ": expected a file that can be written");
    std::fprintf(file,
                 "scene,light,volume,width,height,renderer,distance_voxels,time_min_ms,time_med_ms,rounds,"
                 "first_ms,rmse,max_abs,dE_uv_p99,rmse_float,dE_uv_p99_float,meets,segments,samples,"
                 "compared_pixels,rounding_dE_uv_p99,load_before,load_after\n");
    for (const PictureResult& r : results)
        for (const Contender& c : r.contenders)
            for (const Setting& s : c.settings) {
                std::fprintf(file, "%s,%s,%s,%d,%d,%s,%g,", r.name.c_str(), r.lit ? "lit" : "plain",
                             r.store.c_str(), r.size.x, r.size.y, c.name.c_str(), s.voxels);
                if (s.ms.empty())
                    std::fprintf(file, "n/a,n/a,0,");
                else
                    std::fprintf(file, "%.2f,%.2f,%zu,", minimum(s.ms), median(s.ms), s.ms.size());
                std::fprintf(file, "%.2f,%.6f,%.5f,%.4f,", s.firstMs, s.error.rms, s.error.maxAbs,
                             s.error.luvP99);
                if (c.tessera)
                    std::fprintf(file, "%.6f,%.4f,", s.unrounded.rms, s.unrounded.luvP99);
                else
                    std::fprintf(file, "n/a,n/a,");
                std::fprintf(file, "%d,%llu,%llu,%zu,%.4f,%.2f,%.2f\n", r.target.met(s.error) ? 1 : 0,
                             static_cast<unsigned long long>(s.work.segments),
                             static_cast<unsigned long long>(s.work.samples), r.comparedPixels,
                             r.roundingLuvP99, r.loadBefore, r.loadAfter);
            }
    std::fclose(file);
}

} // namespace tessera::bench
