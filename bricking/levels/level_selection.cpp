// bricking/levels/level_selection.cpp: see level_selection.h.
#include "bricking/levels/level_selection.h"

#include "core/base/error.h"
#include "core/base/threads.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <optional>
#include <utility>

namespace tessera {
namespace {

constexpr int kCoarsest = kLevelCount - 1;
constexpr std::size_t kBricksPerTask = 4096;
constexpr std::size_t kFewPages =
    256; // more than enough for a page of every level to be open while others fill

std::size_t pagesFor(std::size_t bricks, int level) {
    return (bricks + bricksPerPage(level) - 1) / bricksPerPage(level);
}
/// A brick's share of a page.
constexpr std::array<double, kLevelCount> kShare = {1, 1.0 / 8, 1.0 / 64, 1.0 / 512, 1.0 / 4096, 0};

/// An edge of a brick's lower hull: from a level to a finer one, and what it gains per page.
struct Step {
    std::uint32_t key = 0; // bits of the gain: order of positive floats
    std::uint32_t brick = 0;
    std::uint8_t from = 0, to = 0;
};

double weightOf(const ViewWeights& weights, Visibility visibility, std::size_t brick) {
    const double area = static_cast<double>(weights.area[brick]);
    return visibility.empty() ? area : area * static_cast<double>(visibility[brick]);
}

/// Appends the edges of the lower convex hull of (share of a page, weighted error) from `start` on, coarsest
/// first.
void addSteps(const std::array<float, kLevelCount>& errors, double weight, int start, int finest,
              std::uint32_t brick, std::vector<Step>& out) {
    std::array<int, kLevelCount> hull{};
    std::size_t count = 0;
    const auto error = [&](int level) {
        return static_cast<double>(errors[static_cast<std::size_t>(level)]);
    };
    const auto share = [](int level) { return kShare[static_cast<std::size_t>(level)]; };
    const auto slope = [&](int a, int b) { return (error(a) - error(b)) / (share(b) - share(a)); };
    hull[count++] = start;
    for (int level = start - 1; level >= finest; --level) {
        if (!(error(level) < error(hull[count - 1])))
            continue; // larger and not better
        while (count >= 2 && slope(hull[count - 1], level) >= slope(hull[count - 2], hull[count - 1]))
            --count;
        hull[count++] = level;
    }
    for (std::size_t n = 1; n < count; ++n) {
        const auto gain = static_cast<float>(weight * slope(hull[n - 1], hull[n]));
        if (gain > 0)
            out.push_back({std::bit_cast<std::uint32_t>(gain), brick, static_cast<std::uint8_t>(hull[n - 1]),
                           static_cast<std::uint8_t>(hull[n])});
    }
}

/// Largest key first; equal keys stay in order: three passes of 11 bits.
void sortByGain(std::vector<Step>& steps) {
    std::vector<Step> other(steps.size());
    for (int shift = 0; shift < 33; shift += 11) {
        std::array<std::size_t, 2048> start{};
        const auto digit = [&](const Step& step) { return std::size_t{2047} - (step.key >> shift & 2047u); };
        for (const Step& step : steps)
            ++start[digit(step)];
        std::size_t sum = 0;
        for (std::size_t& s : start)
            sum += std::exchange(s, sum);
        for (const Step& step : steps)
            other[start[digit(step)]++] = step;
        steps.swap(other);
    }
}

/// All at the coarsest level, or empty.
Selection coarsest(const LevelErrors& errors, std::span<const float> means) {
    TESSERA_CHECK(errors.errors.size() == errors.shows.size() && means.size() == errors.shows.size());
    TESSERA_CHECK(errors.shows.size() == cellCount(errors.bricks) && errors.shows.size() < UINT32_MAX);
    Selection s;
    s.bricks = errors.bricks;
    s.means.assign(means.begin(), means.end());
    s.levels.resize(errors.shows.size());
    for (std::size_t brick = 0; brick < s.levels.size(); ++brick) {
        s.levels[brick] = errors.shows[brick] ? std::uint8_t{kCoarsest} : Selection::kEmpty;
        ++s.counts[s.levels[brick]];
    }
    return s;
}

void move(Selection& s, std::size_t brick, int to) {
    --s.counts[s.levels[brick]];
    s.levels[brick] = static_cast<std::uint8_t>(to);
    ++s.counts[s.levels[brick]];
}

/// Pages after one brick changed its level.
std::size_t pagesAfter(const Selection& s, std::size_t pages, int from, int to) {
    const auto at = [&](int level) { return s.counts[static_cast<std::size_t>(level)]; };
    if (from < kCoarsest)
        pages -= pagesFor(at(from), from) - pagesFor(at(from) - 1, from);
    if (to < kCoarsest)
        pages += pagesFor(at(to) + 1, to) - pagesFor(at(to), to);
    return pages;
}

double weightedError(const Selection& s, const LevelErrors& errors, const ViewWeights& weights,
                     Visibility visibility) {
    double sum = 0;
    for (std::size_t brick = 0; brick < s.levels.size(); ++brick)
        if (s.levels[brick] != Selection::kEmpty)
            sum += weightOf(weights, visibility, brick) *
                   static_cast<double>(errors.errors[brick][s.levels[brick]]);
    return sum;
}

/// Free slots of allocated pages go to the bricks that gain most, finest level first.
void fillPages(Selection& s, const LevelErrors& errors, const ViewWeights& weights, Visibility visibility) {
    struct Wish {
        double gain;
        std::uint32_t brick;
    };
    std::vector<Wish> wishes;
    for (int level = 0; level < kCoarsest; ++level) {
        const auto at = static_cast<std::size_t>(level);
        const std::size_t room = pagesFor(s.counts[at], level) * bricksPerPage(level) - s.counts[at];
        if (room == 0)
            continue;
        wishes.clear();
        for (std::size_t brick = 0; brick < s.levels.size(); ++brick) {
            const std::uint8_t now = s.levels[brick];
            if (now == Selection::kEmpty || now <= level || weights.finest[brick] > level)
                continue;
            const double gain =
                weightOf(weights, visibility, brick) * (static_cast<double>(errors.errors[brick][now]) -
                                                        static_cast<double>(errors.errors[brick][at]));
            if (gain > 0)
                wishes.push_back({gain, static_cast<std::uint32_t>(brick)});
        }
        const std::size_t taken = std::min(room, wishes.size());
        std::nth_element(wishes.begin(), wishes.begin() + static_cast<std::ptrdiff_t>(taken), wishes.end(),
                         [](const Wish& a, const Wish& b) {
                             return a.gain != b.gain ? a.gain > b.gain : a.brick < b.brick;
                         });
        for (std::size_t n = 0; n < taken; ++n)
            move(s, wishes[n].brick, level);
    }
}

void checkSizes(const Selection& s, const ViewWeights& weights, Visibility visibility) {
    TESSERA_CHECK(weights.area.size() == s.levels.size() && weights.finest.size() == s.levels.size());
    TESSERA_CHECK(visibility.empty() || visibility.size() == s.levels.size());
}

/// Error of a level against the finest that a pixel can show. Errors are known against level 0. The part
/// common to both levels is invisible, and independent differences add as squares.
double shownError(const std::array<float, kLevelCount>& errors, int level, int finest) {
    if (level <= finest)
        return 0;
    const auto a = static_cast<double>(errors[static_cast<std::size_t>(level)]);
    const auto b = static_cast<double>(errors[static_cast<std::size_t>(finest)]);
    return std::sqrt(std::max(a * a - b * b, 0.0));
}

/// The greedy choice that starts with all visible bricks at one level; nullopt if that does not fit.
std::optional<Selection> selectFrom(int start, Selection s, const LevelErrors& errors,
                                    const ViewWeights& weights, std::size_t pages, Visibility visibility,
                                    int threads) {
    const auto startOf = [&](std::size_t brick) {
        const bool seen = errors.shows[brick] && weightOf(weights, visibility, brick) > 0;
        return seen ? std::max(start, static_cast<int>(weights.finest[brick])) : kCoarsest;
    };
    const std::size_t count = s.levels.size();
    if (start < kCoarsest)
        for (std::size_t brick = 0; brick < count; ++brick)
            if (errors.shows[brick])
                move(s, brick, startOf(brick));
    std::size_t used = pagesOf(s);
    if (used > pages)
        return {};
    // Each task has its own list; concatenated in order, they equal the list of a single task.
    std::vector<std::vector<Step>> parts((count + kBricksPerTask - 1) / kBricksPerTask);
    parallelFor(parts.size(), threads, [&](std::size_t task) {
        const std::size_t end = std::min(count, (task + 1) * kBricksPerTask);
        parts[task].reserve(2 * kBricksPerTask);
        for (std::size_t brick = task * kBricksPerTask; brick < end; ++brick)
            if (errors.shows[brick])
                addSteps(errors.errors[brick], weightOf(weights, visibility, brick), startOf(brick),
                         weights.finest[brick], static_cast<std::uint32_t>(brick), parts[task]);
    });
    std::vector<Step> steps;
    for (std::vector<Step>& part : parts) {
        steps.insert(steps.end(), part.begin(), part.end());
        part = {};
    }
    sortByGain(steps);
    for (const Step& step : steps) {
        if (s.levels[step.brick] != step.from)
            continue; // an earlier step of this brick found no room
        const std::size_t after = pagesAfter(s, used, step.from, step.to);
        if (after > pages)
            continue;
        used = after;
        move(s, step.brick, step.to);
    }
    fillPages(s, errors, weights, visibility);
    return s;
}

/// A visible brick's mean error and its share of the picture.
struct BrickError {
    double error = 0, share = 0;
};
std::vector<BrickError> brickErrors(const Selection& s, const LevelErrors& errors, const ViewWeights& weights,
                                    Visibility visibility) {
    std::vector<BrickError> out;
    double total = 0;
    for (std::size_t brick = 0; brick < s.levels.size(); ++brick) {
        const double weight = weightOf(weights, visibility, brick);
        if (s.levels[brick] == Selection::kEmpty || !(weight > 0))
            continue;
        out.push_back({shownError(errors.errors[brick], s.levels[brick], weights.finest[brick]), weight});
        total += weight;
    }
    for (BrickError& b : out)
        b.share /= total;
    return out;
}

constexpr double kTailShare = 0.01; // pixels above the 99th percentile

/// Share of pixels whose error is above x, 0 or more: the model of PredictedError.
double shareAbove(double x, const std::vector<BrickError>& bricks) {
    double sum = 0;
    for (const BrickError& b : bricks)
        if (b.error > 0)
            sum += b.share * std::exp(-x / b.error);
    return sum;
}

} // namespace

std::size_t pagesOf(const Selection& selection) {
    std::size_t pages = 0;
    for (int level = 0; level < kCoarsest; ++level)
        pages += pagesFor(selection.counts[static_cast<std::size_t>(level)], level);
    return pages;
}

std::size_t selectLevelsBytes(std::size_t bricks) {
    // Steps of every brick, three times (made, concatenated, sorted), with spare capacity of vectors; three
    // selections: start, trial and best.
    return bricks * (3 * 2 * (kLevelCount - 1) * sizeof(Step) + 3 * (sizeof(float) + 1));
}

Selection selectLevels(const LevelErrors& errors, const ViewWeights& weights, std::span<const float> means,
                       std::size_t pages, Visibility visibility, int threads) {
    const Selection none = coarsest(errors, means);
    checkSizes(none, weights, visibility);
    Selection best = selectFrom(kCoarsest, none, errors, weights, pages, visibility, threads).value();
    // With few pages, steps of single bricks get stuck. The first brick of a level must pay for a whole page
    // while others still hold the page of the level before. Moving all bricks together may succeed.
    if (pages < kFewPages) {
        double least = weightedError(best, errors, weights, visibility);
        for (int start = kCoarsest - 1; start >= 0; --start) {
            auto other = selectFrom(start, none, errors, weights, pages, visibility, threads);
            if (!other)
                break;
            const double error = weightedError(*other, errors, weights, visibility);
            if (error < least) {
                least = error;
                best = std::move(*other);
            }
        }
    }
    TESSERA_CHECK(pagesOf(best) <= pages);
    return best;
}

Selection selectForError(const LevelErrors& errors, const ViewWeights& weights, std::span<const float> means,
                         double maxError, Visibility visibility) {
    const Selection none = coarsest(errors, means);
    checkSizes(none, weights, visibility);
    // Every visible brick takes the coarsest level whose mean error is at most `limit`.
    const auto within = [&](double limit) {
        Selection s = none;
        for (std::size_t brick = 0; brick < s.levels.size(); ++brick) {
            if (!errors.shows[brick] || !(weightOf(weights, visibility, brick) > 0))
                continue;
            const int finest = weights.finest[brick];
            int level = limit > 0 ? kCoarsest : finest;
            while (level > finest && shownError(errors.errors[brick], level, finest) > limit)
                --level;
            move(s, brick, level);
        }
        return s;
    };
    if (!(maxError > 0))
        return within(0);
    // With this limit every single brick meets maxError; the search is for the largest limit for which all
    // together do.
    double low = maxError / std::log(100.0), high = low;
    for (const auto& e : errors.errors)
        high = std::max(high, static_cast<double>(*std::max_element(e.begin(), e.end())));
    Selection best = within(low);
    for (int n = 0; n < 16 && high > low; ++n) {
        const double limit = n == 0 ? high : 0.5 * (low + high);
        Selection s = within(limit);
        if (shareAbove(maxError, brickErrors(s, errors, weights, visibility)) <= kTailShare) {
            best = std::move(s);
            low = limit;
        } else {
            high = limit;
        }
    }
    return best;
}

void limitPrefilterLoss(const LevelErrors& errors, ViewWeights& weights) {
    constexpr float kNoticeable = 2;
    for (std::size_t brick = 0; brick < errors.biases.size(); ++brick) {
        std::uint8_t& finest = weights.finest[brick];
        if (!errors.shows[brick] || !(weights.area[brick] > 0))
            continue;
        while (finest > 0 && errors.biases[brick][finest] > kNoticeable)
            --finest;
    }
}

Selection selectUniform(const LevelErrors& errors, std::span<const float> means, std::size_t pages) {
    Selection s = coarsest(errors, means);
    int level = 0;
    while (level < kCoarsest && pagesFor(s.counts[kCoarsest], level) > pages)
        ++level;
    for (std::size_t brick = 0; brick < s.levels.size(); ++brick)
        if (errors.shows[brick])
            move(s, brick, level);
    return s;
}

PredictedError predictError(const Selection& selection, const LevelErrors& errors, const ViewWeights& weights,
                            Visibility visibility) {
    checkSizes(selection, weights, visibility);
    const std::vector<BrickError> bricks = brickErrors(selection, errors, weights, visibility);
    PredictedError predicted;
    double largest = 0;
    for (const BrickError& b : bricks) {
        predicted.mean += b.share * b.error;
        largest = std::max(largest, b.error);
    }
    double low = 0,
           high = largest * std::log(1 / kTailShare); // error above which no brick has more than that share
    for (int n = 0; n < 40; ++n) {
        const double middle = 0.5 * (low + high);
        (shareAbove(middle, bricks) <= kTailShare ? high : low) = middle;
    }
    predicted.p99 = high;
    return predicted;
}

} // namespace tessera
