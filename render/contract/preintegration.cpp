// render/contract/preintegration.cpp: see preintegration.h.
#include "render/contract/preintegration.h"

#include "core/base/error.h"
#include "core/base/threads.h"

#include <algorithm>
#include <cmath>

namespace tessera {
namespace {

glm::dvec4 entryAt(const std::vector<glm::vec4>& table, std::size_t bin, double f) {
    const glm::dvec4 a(table[bin]), b(table[bin + 1]);
    return a + f * (b - a);
}

/// Extinction times colour, and extinction.
glm::dvec4 radiance(const glm::dvec4& entry) {
    return {glm::dvec3(entry) * entry.a, entry.a};
}

/// Integral inside a bin from its start to f: a product of two linear functions, which Simpson has exactly.
glm::dvec4 insideBin(const std::vector<glm::vec4>& table, std::size_t bin, double f) {
    return f / 6 *
           (radiance(entryAt(table, bin, 0)) + 4.0 * radiance(entryAt(table, bin, f / 2)) +
            radiance(entryAt(table, bin, f)));
}

/// Segments are cut into slices of which equally much is seen, so that their mean colours weigh the same.
constexpr int kSlices = 32;
/// The last of an opaque segment ends where this is left.
constexpr double kLeft = 1.0 / 1024;

} // namespace

std::vector<glm::vec4> extinctionBins(const std::vector<glm::vec4>& table) {
    std::vector<glm::vec4> bins;
    bins.reserve(table.size() + 1);
    const auto append = [&](float start, float rise, double sum) {
        const float high = static_cast<float>(sum);
        bins.emplace_back(start, rise, high, static_cast<float>(sum - static_cast<double>(high)));
    };
    double sum = 0;
    append(table.front().a, 0, -static_cast<double>(table.front().a));
    for (std::size_t i = 0; i + 1 < table.size(); ++i) {
        append(table[i].a, table[i + 1].a - table[i].a, sum);
        sum += 0.5 * (static_cast<double>(table[i].a) + static_cast<double>(table[i + 1].a));
    }
    append(table.back().a, 0, sum);
    return bins;
}

std::vector<glm::vec4> colourSums(const std::vector<glm::vec4>& table) {
    std::vector<glm::vec4> sums;
    sums.reserve(2 * (table.size() + 2));
    const auto append = [&](const glm::dvec4& sum) {
        const glm::vec4 high(sum);
        sums.push_back(high);
        sums.emplace_back(sum - glm::dvec4(high));
    };
    glm::dvec4 sum(0);
    append(-radiance(glm::dvec4(table.front())));
    append(sum);
    for (std::size_t bin = 0; bin + 1 < table.size(); ++bin)
        append(sum += insideBin(table, bin, 1));
    append(sum + radiance(glm::dvec4(table.back())));
    return sums;
}

TableIntegral::TableIntegral(const std::vector<glm::vec4>& table) : table_(table) {
    glm::dvec4 sum(0);
    sums_.push_back(sum);
    for (std::size_t bin = 0; bin + 1 < table.size(); ++bin)
        sums_.push_back(sum += insideBin(table, bin, 1));
}

glm::dvec4 TableIntegral::upTo(double place) const {
    const auto bin = std::min(static_cast<std::size_t>(place), table_.size() - 2);
    return sums_[bin] + insideBin(table_, bin, place - static_cast<double>(bin));
}

double TableIntegral::placeOfDepth(double depth) const {
    const auto after = std::lower_bound(sums_.begin(), sums_.end(), depth,
                                        [](const glm::dvec4& sum, double d) { return sum.a < d; });
    if (after == sums_.begin())
        return 0;
    if (after == sums_.end())
        return static_cast<double>(table_.size() - 1);
    const auto bin = static_cast<std::size_t>(after - sums_.begin()) - 1;
    // Inside the bin: a f + (b - a) f^2 / 2 = rest, in the form that does not cancel.
    const double a = table_[bin].a, slope = static_cast<double>(table_[bin + 1].a) - a;
    const double rest = depth - sums_[bin].a;
    const double root = std::sqrt(std::max(0.0, a * a + 2 * slope * rest));
    const double f = a + root > 0 ? 2 * rest / (a + root) : 1;
    return static_cast<double>(bin) + std::clamp(f, 0.0, 1.0);
}

glm::dvec3 TableIntegral::colour(double place) const {
    const auto bin = std::min(static_cast<std::size_t>(place), table_.size() - 2);
    return glm::dvec3(entryAt(table_, bin, place - static_cast<double>(bin)));
}

glm::dvec3 preintegratedColour(const TableIntegral& integral, double front, double back, double length) {
    if (front == back)
        return integral.colour(front);
    const glm::dvec4 atFront = integral.upTo(front), atBack = integral.upTo(back);
    const double sign = back > front ? 1 : -1;
    const double perPlace = length / std::abs(back - front);
    const double depth = sign * (atBack.a - atFront.a) * perPlace;
    if (!(depth > 1e-12)) { // too thin to hide anything of itself
        const double thin = atBack.a - atFront.a;
        if (thin == 0)
            return integral.colour(0.5 * (front + back));
        return glm::dvec3(atBack - atFront) / thin;
    }
    const double seen = -std::expm1(-depth);
    glm::dvec3 sum(0);
    glm::dvec4 before = atFront;
    for (int slice = 1; slice <= kSlices; ++slice) {
        const double left = 1 - seen * slice / kSlices;
        const double end = slice == kSlices ? std::min(depth, -std::log(kLeft)) : -std::log(left);
        const double place = std::clamp(integral.placeOfDepth(atFront.a + sign * end / perPlace),
                                        std::min(front, back), std::max(front, back));
        const glm::dvec4 at = slice == kSlices && depth <= -std::log(kLeft) ? atBack : integral.upTo(place);
        const double thickness = at.a - before.a;
        sum += thickness != 0 ? glm::dvec3(at - before) / thickness : integral.colour(place);
        before = at;
    }
    return glm::clamp(sum / static_cast<double>(kSlices), glm::dvec3(0), glm::dvec3(1));
}

Preintegration2d::Preintegration2d(const std::vector<glm::vec4>& table, double length, int firstLayer,
                                   int layers)
    : length_(length), firstLayer_(firstLayer), layers_(layers) {
    TESSERA_CHECK(layers > 0 && table.size() >= 2);
    update(table);
}

std::size_t Preintegration2d::update(const std::vector<glm::vec4>& table) {
    // Places between which something changed: a bin is another's where one of its entries is.
    double lowest = 0, highest = static_cast<double>(table.size() - 1);
    if (table.size() == table_.size()) {
        const auto first = std::mismatch(table.begin(), table.end(), table_.begin()).first;
        if (first == table.end())
            return 0;
        const auto last = std::mismatch(table.rbegin(), table.rend(), table_.rbegin()).first;
        lowest = static_cast<double>(first - table.begin()) - 1;
        highest = static_cast<double>(table.rend() - last);
    }
    table_ = table;
    colours_.resize(bytes(layers_) / sizeof(glm::vec4));
    const TableIntegral integral(table_);
    const double placesPerEntry = static_cast<double>(table_.size() - 1) / (kEdge - 1);
    const std::size_t rows = static_cast<std::size_t>(layers_) * kEdge;
    std::vector<std::size_t> computed(rows);
    parallelFor(rows, 0, [&](std::size_t row) {
        const int layer = static_cast<int>(row / kEdge), j = static_cast<int>(row % kEdge);
        const double back = j * placesPerEntry, length = std::ldexp(length_, firstLayer_ + layer);
        for (int i = 0; i < kEdge; ++i) {
            const double front = i * placesPerEntry;
            if (std::max(front, back) < lowest || std::min(front, back) > highest)
                continue;
            colours_[row * kEdge + static_cast<std::size_t>(i)] =
                glm::vec4(glm::vec3(preintegratedColour(integral, front, back, length)), 0);
            ++computed[row];
        }
    });
    std::size_t pairs = 0;
    for (const std::size_t n : computed)
        pairs += n;
    return pairs;
}

} // namespace tessera
