// render/transport/environment_map.cpp: see environment_map.h.
#include "render/transport/environment_map.h"

#include "core/base/error.h"
#include "render/transport/path_numbers.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/gtc/constants.hpp>

namespace tessera {
namespace {

/// Sums of weights up to each, over all, from `sums[0]` = 0 to 1: multiples of 2^-24, as the numbers are that
/// look for a place in them. So each place is met with the very chance that its sums differ by. All 0: even.
void fillSums(const double* weights, std::size_t count, float* sums) {
    double all = 0, upTo = 0;
    for (std::size_t n = 0; n < count; ++n)
        all += weights[n];
    for (std::size_t n = 0; n < count; ++n) {
        sums[n] = static_cast<float>(std::round(std::min(upTo, 1.0) * 0x1p24) * 0x1p-24);
        upTo += all > 0 ? weights[n] / all : 1.0 / static_cast<double>(count);
    }
    sums[count] = 1;
}

/// The place whose sums u is between, and how far it is between them.
struct Place {
    std::size_t number;
    float share; // from 0 to below 1
};
Place placeIn(const float* sums, std::size_t count, float u) {
    const auto n = static_cast<std::size_t>(std::upper_bound(sums, sums + count, u) - sums) - 1;
    return {n, (u - sums[n]) / (sums[n + 1] - sums[n])};
}

std::vector<float> luminances(const std::vector<glm::vec3>& radiance) {
    std::vector<float> list;
    list.reserve(radiance.size());
    for (const glm::vec3& texel : radiance)
        list.push_back(luminanceOf(texel));
    return list;
}

} // namespace

DirectionTable::DirectionTable(const glm::ivec2& size, const std::vector<float>& weights) : size_(size) {
    const auto columns = static_cast<std::size_t>(size.x), rows = static_cast<std::size_t>(size.y);
    TESSERA_CHECK(size.x > 0 && size.y > 0 && weights.size() == columns * rows);
    for (int row = 0; row <= size.y; ++row)
        edges_.push_back(static_cast<float>(std::cos(glm::pi<double>() * row / size.y)));
    edges_.back() = -1;
    rows_.resize(rows + 1);
    columns_.resize((columns + 1) * rows);
    densities_.resize(columns * rows);
    std::vector<double> ofRows(rows), ofRow(columns);
    for (std::size_t row = 0; row < rows; ++row) {
        double sum = 0;
        for (std::size_t column = 0; column < columns; ++column)
            sum += ofRow[column] = static_cast<double>(weights[row * columns + column]);
        fillSums(ofRow.data(), columns, &columns_[row * (columns + 1)]);
        ofRows[row] = sum * static_cast<double>(edges_[row] - edges_[row + 1]);
        any_ = any_ || sum > 0;
    }
    fillSums(ofRows.data(), rows, rows_.data());
    for (std::size_t row = 0; row < rows; ++row) {
        const double area = 2 * glm::pi<double>() * static_cast<double>(edges_[row] - edges_[row + 1]) /
                            static_cast<double>(columns);
        const float* sums = &columns_[row * (columns + 1)];
        const double chance = static_cast<double>(rows_[row + 1] - rows_[row]) / area;
        for (std::size_t column = 0; column < columns; ++column)
            densities_[row * columns + column] =
                static_cast<float>(chance * static_cast<double>(sums[column + 1] - sums[column]));
    }
}

std::size_t DirectionTable::bytes(const glm::ivec2& size) {
    const auto columns = static_cast<std::size_t>(size.x), rows = static_cast<std::size_t>(size.y);
    // While it is made, with the weights and their sums.
    return sizeof(float) * (2 * (rows + 1) + (columns + 1) * rows + 2 * columns * rows) +
           sizeof(double) * (columns + rows);
}

std::size_t DirectionTable::texelOf(const glm::vec3& direction) const {
    const auto columns = static_cast<std::size_t>(size_.x);
    const auto below =
        std::upper_bound(edges_.begin() + 1, edges_.end() - 1, direction.z, std::greater<float>());
    const auto row = static_cast<std::size_t>(below - edges_.begin()) - 1;
    const float turn = turnOf(-direction.x, -direction.y); // half a turn from the middle: the first column
    const auto column = static_cast<std::size_t>(turn * static_cast<float>(size_.x));
    return row * columns + std::min(column, columns - 1);
}

DirectionTable::Drawn DirectionTable::draw(const glm::vec2& two) const {
    const auto columns = static_cast<std::size_t>(size_.x), rows = static_cast<std::size_t>(size_.y);
    const Place row = placeIn(rows_.data(), rows, two.y);
    const Place column = placeIn(&columns_[row.number * (columns + 1)], columns, two.x);
    const float z = edges_[row.number] + row.share * (edges_[row.number + 1] - edges_[row.number]);
    const glm::vec2 turn =
        turnedBy((static_cast<float>(column.number) + column.share) / static_cast<float>(size_.x));
    const float across = std::sqrt(std::max(0.0f, 1.0f - z * z));
    return {{-across * turn.x, -across * turn.y, z}, row.number * columns + column.number};
}

EnvironmentMap::EnvironmentMap(const glm::ivec2& size, std::vector<glm::vec3> radiance)
    : radiance_(std::move(radiance)), table_(size, luminances(radiance_)) {}

std::size_t EnvironmentMap::bytes(const glm::ivec2& size) {
    return DirectionTable::bytes(size) +
           sizeof(glm::vec3) * static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y);
}

} // namespace tessera
