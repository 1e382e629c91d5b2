// render/light/light_sweep.cpp: see light_sweep.h.
#include "render/light/light_sweep.h"

#include "core/base/error.h"
#include "core/base/threads.h"
#include "render/contract/leaves.h"
#include "render/contract/optics.h" // opacityOf

#include <algorithm>
#include <cmath>

namespace tessera {
namespace {

constexpr float kMostAngle = 1;     // mean square of scattered light's angle within a half space
constexpr float kMostReach = 8;     // rays to either side that light of one gets to in a slice
constexpr std::size_t kAtATime = 8; // rows, columns
constexpr float kUnit16 = 65535;    // of shares up to 1

std::uint16_t texelOf(float light) {
    return static_cast<std::uint16_t>(std::min(light * leaf::kLightOne + 0.5f, 65535.0f));
}
float lightOf(std::uint16_t texel) {
    return static_cast<float>(texel) * (1 / leaf::kLightOne);
}

/// A ray's light goes on in five parts: here, and at two neighbouring rays to either side, so that its
/// variance grows by the given one exactly.
struct Spread {
    int reach = 1;
    float here = 1, nearer = 0, farther = 0; // of either side at reach and at reach + 1
    explicit Spread(float variance) {
        // Gauss and Hermite's three places for a wide one.
        const float place = std::min(std::max(1.0f, std::sqrt(3 * variance)), kMostReach - 1);
        reach = static_cast<int>(place);
        const float part = place - static_cast<float>(reach), r = static_cast<float>(reach);
        const float square = (1 - part) * r * r + part * (r + 1) * (r + 1);
        const float side = std::min(variance / (2 * square), 0.5f);
        here = 1 - 2 * side;
        nearer = side * (1 - part);
        farther = side * part;
    }
};

} // namespace

SweptScattering::SweptScattering(double g) {
    TESSERA_CHECK(g >= 0 && g < 1);
    const double ahead = g < 1e-6 ? 0.5 : (1 - g * g) / (2 * g) * (1 / (1 - g) - 1 / std::sqrt(1 + g * g));
    onwards = static_cast<float>(ahead);
    back = static_cast<float>(1 - ahead);
    turned = static_cast<float>((1 - g) / 2);
    angle = static_cast<float>(std::min(2 * (1 - g), static_cast<double>(kMostAngle)));
}

/// Of dS/dx = -a S + b B + c on D, -dB/dx = -a B + b S + c back D, D = e^-x: the general solution by e^(+-k
/// x), k^2 = a^2 - b^2, and a particular one that falls as D.
SweptLayer sweptLayer(float depth, float gone, float albedo, const SweptScattering& s) {
    constexpr float kThin = 1e-3f, kLeast = 1e-3f, kNear = 0.01f;
    SweptLayer layer;
    if (!(depth > 0))
        return layer;
    const float b = SweptScattering::kObliquity * albedo * s.turned;
    float a = SweptScattering::kObliquity * (1 - albedo) + b;
    if (depth < kThin) {
        layer.through = 1 - a * depth;
        layer.returned = b * depth;
        layer.sent = depth * albedo * s.onwards;
        layer.sentBack = depth * albedo * s.back;
        return layer;
    }
    // Where k is 0 or 1 the solution has another form, and that of a k beside it is as good.
    float square = std::max((a - b) * (a + b), kLeast * kLeast);
    if (std::abs(square - 1) < kNear)
        square = square < 1 ? 1 - kNear : 1 + kNear;
    a = std::sqrt(b * b + square);
    const float k = std::sqrt(square), taken = opacityOf(k * depth), left = 1 - taken;
    const float both = taken * (1 + left); // 1 - left^2
    const float over = 1 / (k * (1 + left * left) + a * both);
    layer.through = 2 * k * left * over;
    layer.returned = b * both * over;
    const float beam = 1 - gone, on = albedo * s.onwards, back = albedo * s.back;
    const float special = 1 / (square - 1);
    const float ahead = (on * (1 + a) + b * back) * special, behind = ((a - 1) * back + b * on) * special;
    layer.sent = std::max(0.0f, ahead * (beam - layer.through) - behind * beam * layer.returned);
    layer.sentBack = std::max(0.0f, behind * (1 - beam * layer.through) - ahead * layer.returned);
    return layer;
}

MapSweep::MapSweep(const LightGrid& grid, double g)
    : grid_(grid), scattering_(g), depth_(grid.nodes()), albedo_(grid.nodes()), beam_(grid.nodes()),
      mirror_(grid.nodes()), here_(grid.nodesOfPlane()), there_(grid.nodesOfPlane()),
      beamHere_(grid.nodesOfPlane()), mirrorHere_(grid.nodesOfPlane()) {}

std::size_t MapSweep::bytes(int size) {
    LightGrid grid;
    grid.size = grid.slices = size;
    return grid.nodes() * (sizeof(float) + 3 * sizeof(std::uint8_t) + 4 * sizeof(std::uint16_t)) +
           grid.nodesOfPlane() * (2 * sizeof(Ray) + sizeof(float) + sizeof(glm::vec3));
}

void MapSweep::setRay(const glm::ivec2& ray, std::span<const LightSlice> slices) {
    TESSERA_CHECK(slices.size() == static_cast<std::size_t>(grid_.slices));
    std::size_t at = static_cast<std::size_t>(ray.y) * static_cast<std::size_t>(grid_.size) +
                     static_cast<std::size_t>(ray.x);
    for (const LightSlice& slice : slices) {
        depth_[at] = slice.depth;
        for (int c = 0; c < 3; ++c)
            albedo_[at][static_cast<std::size_t>(c)] =
                static_cast<std::uint8_t>(std::clamp(slice.albedo[c], 0.0f, 1.0f) * 255 + 0.5f);
        at += grid_.nodesOfPlane();
    }
}

float MapSweep::beam(std::size_t node) const {
    return lightOf(beam_[node]);
}

/// From a ray of a line to others of it.
/// @param pitch   from one to the next
/// @param square  of the slice's thickness, in distances of rays
void MapSweep::spread(const Ray* from, Ray* to, int at, std::size_t pitch, float square) const {
    const Ray ray = from[static_cast<std::size_t>(at) * pitch];
    const float light = ray.light[0] + ray.light[1] + ray.light[2];
    if (!(light > 0))
        return;
    const int last = grid_.size - 1;
    const auto give = [&](int n, float share) {
        if (n < 0 || n > last) {
            if (!grid_.oneOfSides)
                return;
            n = std::clamp(n < 0 ? -1 - n : 2 * last + 1 - n, 0, last);
        }
        Ray& other = to[static_cast<std::size_t>(n) * pitch];
        for (std::size_t c = 0; c < 3; ++c)
            other.light[c] += share * ray.light[c];
        other.angle += share * ray.angle;
        other.drift += share * ray.drift;
    };
    // Of the variance 2 A1 + A0, for a thickness of 1, each axis has a half.
    const Spread kernel(square * (ray.drift + 0.5f * ray.angle) / light);
    give(at, kernel.here);
    for (const int side : {-1, 1}) {
        give(at + side * kernel.reach, kernel.nearer);
        if (kernel.farther > 0)
            give(at + side * (kernel.reach + 1), kernel.farther);
    }
}

/// Spreads the light of a plane along rows, then along columns, and lets it cross a slice.
/// @param cross  of every node, when here_ has the light that comes to it
template <typename Cross> void MapSweep::crossSlice(int slice, int threads, const Cross& cross) {
    const auto size = static_cast<std::size_t>(grid_.size);
    const double rayMm = 0.5 * (grid_.rayMmAt(slice) + grid_.rayMmAt(slice + 1));
    const double thickness = grid_.sliceMm / std::max(1e-9, rayMm);
    const auto square = static_cast<float>(std::min(thickness * thickness, 1e6));
    const std::size_t parts = (size + kAtATime - 1) / kAtATime;
    const auto clear = [](Plane& plane, std::size_t first, std::size_t end) {
        std::fill(plane.begin() + static_cast<std::ptrdiff_t>(first),
                  plane.begin() + static_cast<std::ptrdiff_t>(end), Ray{});
    };
    parallelFor(parts, threads, [&](std::size_t part) { // rows
        for (std::size_t y = part * kAtATime; y < std::min(size, (part + 1) * kAtATime); ++y) {
            clear(there_, y * size, (y + 1) * size);
            for (int x = 0; x < grid_.size; ++x)
                spread(here_.data() + y * size, there_.data() + y * size, x, 1, square);
        }
    });
    parallelFor(parts, threads, [&](std::size_t part) { // columns
        const std::size_t first = part * kAtATime, end = std::min(size, first + kAtATime);
        for (std::size_t y = 0; y < size; ++y)
            clear(here_, y * size + first, y * size + end);
        for (int y = 0; y < grid_.size; ++y)
            for (std::size_t x = first; x < end; ++x)
                spread(there_.data() + x, here_.data() + x, y, size, square);
        for (std::size_t y = 0; y < size; ++y)
            for (std::size_t x = first; x < end; ++x)
                cross(y * size + x);
    });
}

SweptLayer MapSweep::layerOf(std::size_t node, float gone, std::size_t colour) const {
    return sweptLayer(depth_[node], gone, static_cast<float>(albedo_[node][colour]) * (1.0f / 255),
                      scattering_);
}

/// From a plane to the next: here_ is the scattered light that comes to the slice, and then behind it.
void MapSweep::goOn(int slice, std::size_t at, LightMap& map) {
    const std::size_t node = static_cast<std::size_t>(slice) * grid_.nodesOfPlane() + at;
    Ray& ray = here_[at];
    float& beam = beamHere_[at];
    glm::vec3& mirror = mirrorHere_[at];
    beam_[node] = texelOf(beam);
    std::uint16_t* const kept = map.node(node);
    for (std::size_t c = 0; c < 3; ++c) {
        kept[c] = texelOf(ray.light[c]);
        mirror_[node][c] = static_cast<std::uint16_t>(mirror[static_cast<int>(c)] * kUnit16 + 0.5f);
    }
    const float depth = depth_[node];
    if (!(depth > 0)) {
        ray.drift += ray.angle;
        return;
    }
    const float gone = opacityOf(depth);
    float before = 0, through = 0, sent = 0, again = 0;
    for (std::size_t c = 0; c < 3; ++c) {
        const SweptLayer layer = layerOf(node, gone, c);
        float& seen = mirror[static_cast<int>(c)];
        const float often = 1 / (1 - layer.returned * seen), light = ray.light[c];
        const float born = layer.sent * beam, on = layer.through * light;
        const float turned = layer.through * seen * often * (layer.returned * light + layer.sentBack * beam);
        before += light, through += on, sent += born, again += turned;
        ray.light[c] = on + born + turned;
        seen = layer.returned + layer.through * layer.through * seen * often;
    }
    // Light that went on was scattered once more per depth; that which was born, so often as what is left of
    // a beam and of what it became; what came back has forgotten its way.
    const float share = before > 0 ? through / before : 0;
    const float angle = ray.angle;
    const float more =
        before > 0 ? std::min(scattering_.angle * depth * before, kMostAngle * before - angle) : 0;
    const float births = std::min(scattering_.angle * depth / gone, kMostAngle) * sent;
    ray.angle = share * (angle + more) + births + kMostAngle * again;
    ray.drift = share * (ray.drift + angle + 0.5f * more) + 0.5f * (births + kMostAngle * again);
    ray.angle = std::min(ray.angle, kMostAngle * (through + sent + again));
    beam *= 1 - gone;
}

/// From a plane to the one before: here_ is the light that comes back to the slice, and then before it.
void MapSweep::goBack(int slice, std::size_t at, LightMap& map) {
    const std::size_t node = static_cast<std::size_t>(slice) * grid_.nodesOfPlane() + at;
    Ray& ray = here_[at];
    std::uint16_t* const kept = map.node(node);
    const float beam = lightOf(beam_[node]), gone = opacityOf(depth_[node]);
    float before = 0, through = 0, born = 0;
    for (std::size_t c = 0; c < 3; ++c) {
        const SweptLayer layer = layerOf(node, gone, c);
        const float seen = static_cast<float>(mirror_[node][c]) * (1 / kUnit16), on = lightOf(kept[c]);
        const float often = 1 / (1 - layer.returned * seen);
        const float mine = often * layer.through * ray.light[c],
                    more = often * (layer.returned * on + layer.sentBack * beam);
        before += ray.light[c], through += mine, born += more;
        ray.light[c] = mine + more;
        kept[c] = texelOf(SweptScattering::kObliquity * (on + (1 + seen) * ray.light[c]));
    }
    const float share = before > 0 ? through / before : 0;
    ray.drift = share * (ray.drift + ray.angle) + 0.5f * kMostAngle * born;
    ray.angle = kMostAngle * (through + born);
}

void MapSweep::begin() {
    std::fill(here_.begin(), here_.end(), Ray{});
    std::fill(beamHere_.begin(), beamHere_.end(), 1.0f);
    std::fill(mirrorHere_.begin(), mirrorHere_.end(), glm::vec3(0));
}

/// At the last plane, to which nothing comes back.
void MapSweep::turn(LightMap& map) {
    const std::size_t plane = grid_.nodesOfPlane(), last = grid_.nodes() - plane;
    glm::dvec3 sum(0);
    for (std::size_t at = 0; at < plane; ++at) {
        beam_[last + at] = texelOf(beamHere_[at]);
        for (std::size_t c = 0; c < 3; ++c) {
            const float light = here_[at].light[c];
            sum[static_cast<int>(c)] += static_cast<double>(light + beamHere_[at]);
            map.node(last + at)[c] = texelOf(SweptScattering::kObliquity * light);
        }
        here_[at] = Ray{};
    }
    ahead_ = sum / static_cast<double>(plane);
}

bool MapSweep::cross(int slices, int threads, LightMap& map) {
    TESSERA_CHECK(map.grid().size == grid_.size && map.grid().slices == grid_.slices);
    for (const int end = std::min(crossed_ + slices, 2 * grid_.slices); crossed_ < end; ++crossed_) {
        if (crossed_ == 0)
            begin();
        if (crossed_ == grid_.slices)
            turn(map);
        const bool onwards = crossed_ < grid_.slices;
        const int slice = onwards ? crossed_ : 2 * grid_.slices - 1 - crossed_;
        if (onwards)
            crossSlice(slice, threads, [&](std::size_t at) { goOn(slice, at, map); });
        else
            crossSlice(slice, threads, [&](std::size_t at) { goBack(slice, at, map); });
    }
    if (crossed_ < 2 * grid_.slices)
        return false;
    glm::dvec3 sum(0);
    for (const Ray& ray : here_)
        for (std::size_t c = 0; c < 3; ++c)
            sum[static_cast<int>(c)] += static_cast<double>(ray.light[c]);
    back_ = sum / static_cast<double>(grid_.nodesOfPlane());
    return true;
}

} // namespace tessera
