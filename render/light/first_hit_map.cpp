// render/light/first_hit_map.cpp: see first_hit_map.h.
#include "render/light/first_hit_map.h"

#include "core/base/error.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>

namespace tessera {

bool isBeyond(const glm::vec2& at, int size, int filter) {
    const auto least = static_cast<float>(-filter - 1), most = static_cast<float>(size + filter + 1);
    return !(at.x > least && at.y > least && at.x < most && at.y < most);
}

float firstHit(std::span<const LightLeft> samples, float threshold) {
    const float dark = 1 - threshold;
    for (std::size_t n = 0; n < samples.size(); ++n)
        if (samples[n].light <= dark) {
            if (n == 0)
                return samples[n].mm;
            const LightLeft &before = samples[n - 1], &behind = samples[n];
            return before.mm +
                   (behind.mm - before.mm) * ((before.light - dark) / (before.light - behind.light));
        }
    return std::numeric_limits<float>::infinity();
}

FirstHitMap::FirstHitMap(int size, const FirstHits& hits)
    : ShadowMap(size), hits_(hits), mm_(static_cast<std::size_t>(size) * static_cast<std::size_t>(size),
                                        std::numeric_limits<float>::infinity()) {
    TESSERA_CHECK(hits.threshold > 0 && hits.threshold < 1 && hits.filter >= 0);
}

float FirstHitMap::fit(const glm::ivec2& ray, std::span<const LightLeft> samples, float) {
    mm_[static_cast<std::size_t>(ray.y * size() + ray.x)] = firstHit(samples, hits_.threshold);
    return 0;
}

float FirstHitMap::between(const glm::vec2& at, float mm) const {
    if (isBeyond(at, size(), hits_.filter))
        return 1;
    const glm::ivec2 ray(static_cast<int>(std::floor(at.x)), static_cast<int>(std::floor(at.y)));
    const int reach = hits_.filter;
    int lit = 0;
    for (int y = ray.y - reach; y <= ray.y + reach; ++y)
        for (int x = ray.x - reach; x <= ray.x + reach; ++x) {
            const glm::ivec2 in = glm::clamp(glm::ivec2(x, y), 0, size() - 1);
            const bool beyond = !hits_.oneOfSides && in != glm::ivec2(x, y);
            lit += beyond || mm_[static_cast<std::size_t>(in.y * size() + in.x)] + hits_.biasMm >= mm ? 1 : 0;
        }
    const int across = 2 * reach + 1;
    return static_cast<float>(lit) / static_cast<float>(across * across);
}

VarianceMap::VarianceMap(int size, const FirstHits& hits, float middleMm, float leastMm)
    : ShadowMap(size), hits_(hits), middleMm_(middleMm), leastMm_(leastMm),
      rays_(static_cast<std::size_t>(size) * static_cast<std::size_t>(size)) {
    TESSERA_CHECK(hits.threshold > 0 && hits.threshold < 1 && hits.filter >= 0 && leastMm > 0);
}

float VarianceMap::fit(const glm::ivec2& ray, std::span<const LightLeft> samples, float) {
    const float mm = firstHit(samples, hits_.threshold) - middleMm_;
    rays_[static_cast<std::size_t>(ray.y * size() + ray.x)] =
        std::isfinite(mm) ? Moments{1, mm, mm * mm} : Moments{};
    return 0;
}

void VarianceMap::finish() {
    const int reach = hits_.filter;
    if (reach == 0)
        return;
    std::vector<Moments> line(static_cast<std::size_t>(size()));
    for (const bool along : {true, false})
        for (int n = 0; n < size(); ++n) {
            const auto rayAt = [&](int k) -> Moments& {
                const int x = along ? k : n, y = along ? n : k;
                return rays_[static_cast<std::size_t>(y * size() + x)];
            };
            for (int k = 0; k < size(); ++k)
                line[static_cast<std::size_t>(k)] = rayAt(k);
            for (int k = 0; k < size(); ++k) {
                const int first = std::max(0, k - reach), last = std::min(size() - 1, k + reach);
                Moments sum;
                for (int i = first; i <= last; ++i) {
                    const Moments& of = line[static_cast<std::size_t>(i)];
                    sum.hits += of.hits, sum.mm += of.mm, sum.squares += of.squares;
                }
                const float part = 1 / static_cast<float>(last - first + 1);
                rayAt(k) = {sum.hits * part, sum.mm * part, sum.squares * part};
            }
        }
}

VarianceMap::Moments VarianceMap::at(int x, int y) const {
    const glm::ivec2 in = glm::clamp(glm::ivec2(x, y), 0, size() - 1);
    return hits_.oneOfSides || in == glm::ivec2(x, y) ? rays_[static_cast<std::size_t>(in.y * size() + in.x)]
                                                      : Moments{};
}

float VarianceMap::between(const glm::vec2& at, float mm) const {
    if (isBeyond(at, size(), 0))
        return 1;
    const glm::vec2 corner(std::floor(at.x - 0.5f), std::floor(at.y - 0.5f)), part = at - 0.5f - corner;
    const auto x = static_cast<int>(corner.x), y = static_cast<int>(corner.y);
    const Moments m[4] = {this->at(x, y), this->at(x + 1, y), this->at(x, y + 1), this->at(x + 1, y + 1)};
    const auto mixed = [&](float Moments::*of) {
        const float above = m[0].*of + part.x * (m[1].*of - m[0].*of);
        const float below = m[2].*of + part.x * (m[3].*of - m[2].*of);
        return above + part.y * (below - above);
    };
    const float hits = mixed(&Moments::hits);
    if (!(hits > 0))
        return 1;
    const float mean = mixed(&Moments::mm) / hits, square = mixed(&Moments::squares) / hits;
    const float behind = mm - middleMm_ - hits_.biasMm - mean;
    if (!(behind > 0))
        return 1;
    const float variance = std::max(square - mean * mean, leastMm_ * leastMm_);
    const float passes = variance / (variance + behind * behind);
    return 1 - hits + hits * std::max(0.0f, (passes - kBleeding) / (1 - kBleeding));
}

} // namespace tessera
