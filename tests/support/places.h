// tests/support/places.h: arrays of places that rays go through (Rays::places).
#pragma once

#include "render/engine.h"

#include <random>
#include <utility>
#include <vector>

namespace tessera::test {

struct Places {
    std::vector<glm::vec2> all;
    glm::ivec2 size{0};

    /// The rays of a frame through them; they outlive what is drawn.
    Rays of(const RayFrame<double>& frame, const Strides& strides) const {
        return {frame, strides, all, size};
    }
};

/// Anywhere on a picture and a pixel around it, in no order.
inline Places randomPlaces(const glm::ivec2& picture, const glm::ivec2& size, unsigned seed) {
    std::mt19937 random(seed);
    const auto within = [&](int extent) {
        return static_cast<float>(random() >> 8) / static_cast<float>(1 << 24) *
                   static_cast<float>(extent + 2) -
               1;
    };
    Places places{{}, size};
    for (std::size_t i = 0; i < rayCount(size); ++i) {
        const float x = within(picture.x);
        places.all.emplace_back(x, within(picture.y));
    }
    return places;
}

/// The middles of the pixels of a picture of `finer` times as many each way, row by row.
inline Places middles(const glm::ivec2& picture, int finer) {
    Places places{{}, picture * finer};
    for (int y = 0; y < places.size.y; ++y)
        for (int x = 0; x < places.size.x; ++x)
            places.all.push_back((glm::vec2(x, y) + 0.5f) / static_cast<float>(finer));
    return places;
}

} // namespace tessera::test
