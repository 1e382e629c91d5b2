// datasets/tissue_painter.cpp: see tissue_painter.h.
#include "datasets/tissue_painter.h"

#include "core/base/error.h"

#include <algorithm>

namespace tessera {
namespace {

constexpr int kCoarseTile = 40; // points; a multiple of kFineTile
constexpr int kFineTile = 8;
constexpr Box kEverywhere = {glm::vec3(-1e9F), glm::vec3(1e9F)};

/// Minimum that rounds the crease where a and b meet over the width k (a parabola; equal to min beyond it).
float smoothMin(float a, float b, float k) {
    const float overlap = std::max(k - std::abs(a - b), 0.0F);
    return std::min(a, b) - (overlap > 0 ? overlap * overlap / (4 * k) : 0.0F);
}

bool meet(const Box& a, const Box& b) {
    return a.low.x <= b.high.x && b.low.x <= a.high.x && a.low.y <= b.high.y && b.low.y <= a.high.y &&
           a.low.z <= b.high.z && b.low.z <= a.high.z;
}

} // namespace

TissuePainter::TissuePainter(std::deque<Tissue> tissues, float backgroundHu, float blendMm)
    : tissues_(std::move(tissues)), backgroundHu_(backgroundHu), halfBlendMm_(0.5F * blendMm) {
    TESSERA_CHECK(blendMm > 0);
    for (const Tissue& tissue : tissues_) {
        const float reach = std::max(0.0F, tissue.shells.front().offsetMm) + halfBlendMm_ + tissue.smoothMm;
        if (tissue.clip) {
            all_.push_back({&tissue, tissue.clip.get(), 0});
            boxes_.push_back(kEverywhere);
        }
        for (const auto& shape : tissue.shapes) {
            const Box box = shape->box();
            all_.push_back({&tissue, shape.get(), 0});
            boxes_.push_back({box.low - reach, box.high + reach});
        }
    }
}

float TissuePainter::valueAt(const glm::vec3& p) const {
    return paint(all_, p);
}

float TissuePainter::paint(std::span<const Active> active, const glm::vec3& p) const {
    float value = backgroundHu_;
    const float perBlend = 0.5F / halfBlendMm_;
    for (std::size_t i = 0; i < active.size();) {
        const Tissue& tissue = *active[i].tissue;
        if (active[i].shape == nullptr) {
            value = tissue.shells[active[i++].shell].hu;
            continue;
        }
        float distance = 1e9F, clip = -1e9F;
        for (; i < active.size() && active[i].tissue == &tissue; ++i) {
            const float d = active[i].shape->distance(p);
            if (active[i].shape == tissue.clip.get())
                clip = d - tissue.clipOffsetMm;
            else
                distance =
                    tissue.smoothMm > 0 ? smoothMin(distance, d, tissue.smoothMm) : std::min(distance, d);
        }
        distance = std::max(distance, clip);
        for (const Shell& shell : tissue.shells) {
            const float coverage = 0.5F - (distance - shell.offsetMm) * perBlend;
            if (coverage <= 0)
                break;
            value += (shell.hu - value) * std::min(coverage, 1.0F);
        }
    }
    return value;
}

void TissuePainter::prune(std::span<const Active> from, const glm::vec3& centre, float radius,
                          std::vector<Active>& kept) const {
    kept.clear();
    for (std::size_t i = 0; i < from.size();) {
        const Tissue& tissue = *from[i].tissue;
        if (from[i].shape == nullptr) {
            kept.clear(); // it covers all that was painted before
            kept.push_back(from[i++]);
            continue;
        }
        const std::size_t first = kept.size();
        const float outermost = tissue.shells.front().offsetMm + halfBlendMm_;
        const float innermost = tissue.shells.back().offsetMm - halfBlendMm_;
        Range whole{1e9F, 1e9F}, clip{-1e9F, -1e9F};
        bool clipMatters = false;
        for (; i < from.size() && from[i].tissue == &tissue; ++i) {
            const Range range = from[i].shape->bounds(centre, radius);
            if (from[i].shape == tissue.clip.get()) {
                clip = {range.low - tissue.clipOffsetMm, range.high - tissue.clipOffsetMm};
                clipMatters = clip.high > innermost; // else the clip is 1 wherever the shapes could be
                if (clipMatters)
                    kept.push_back(from[i]);
            } else if (range.low <= outermost + 2 * tissue.smoothMm) {
                kept.push_back(from[i]);
                whole.low = std::min(whole.low, range.low);
                whole.high = std::min(whole.high, range.high);
            }
        }
        whole = {std::max(whole.low - tissue.smoothMm, clip.low), std::max(whole.high, clip.high)};
        if (whole.low > outermost || kept.size() == first + (clipMatters ? 1 : 0)) {
            kept.resize(first);
            continue;
        }
        if (whole.high > tissue.shells.front().offsetMm - halfBlendMm_)
            continue;
        kept.erase(kept.begin(), kept.begin() + static_cast<std::ptrdiff_t>(first)); // opaque all over
        std::size_t shell = 0;
        while (shell + 1 < tissue.shells.size() &&
               whole.high <= tissue.shells[shell + 1].offsetMm - halfBlendMm_)
            ++shell;
        if (shell + 1 == tissue.shells.size() ||
            whole.low >= tissue.shells[shell + 1].offsetMm + halfBlendMm_)
            kept.assign(1, {&tissue, nullptr, shell});
    }
}

void TissuePainter::slice(const glm::vec3& first, float stepX, float stepY, int nx, int ny,
                          std::span<float> out) const {
    const auto pointAt = [&](float i, float j) { return first + glm::vec3(i * stepX, j * stepY, 0); };
    std::vector<Active> inSlice, inBox, coarse, fine;
    std::vector<Box> boxes;
    for (std::size_t i = 0; i < all_.size(); ++i)
        if (boxes_[i].low.z <= first.z && boxes_[i].high.z >= first.z) {
            inSlice.push_back(all_[i]);
            boxes.push_back(boxes_[i]);
        }
    // the ball around the tile of points [x0,x1) x [y0,y1)
    const auto pruneTile = [&](std::span<const Active> from, int x0, int x1, int y0, int y1,
                               std::vector<Active>& kept) {
        const auto half = [](int a, int b) { return 0.5F * static_cast<float>(a + b - 1); };
        const glm::vec3 centre = pointAt(half(x0, x1), half(y0, y1));
        const glm::vec3 corner = pointAt(static_cast<float>(x0), static_cast<float>(y0));
        prune(from, centre, glm::length(corner - centre) + 1e-3F, kept);
    };
    for (int cy = 0; cy < ny; cy += kCoarseTile)
        for (int cx = 0; cx < nx; cx += kCoarseTile) {
            const int ex = std::min(cx + kCoarseTile, nx), ey = std::min(cy + kCoarseTile, ny);
            const Box tile{pointAt(static_cast<float>(cx), static_cast<float>(cy)),
                           pointAt(static_cast<float>(ex - 1), static_cast<float>(ey - 1))};
            inBox.clear();
            for (std::size_t i = 0; i < inSlice.size(); ++i)
                if (meet(boxes[i], tile))
                    inBox.push_back(inSlice[i]);
            pruneTile(inBox, cx, ex, cy, ey, coarse);
            for (int fy = cy; fy < ey; fy += kFineTile)
                for (int fx = cx; fx < ex; fx += kFineTile) {
                    const int lx = std::min(fx + kFineTile, ex), ly = std::min(fy + kFineTile, ey);
                    pruneTile(coarse, fx, lx, fy, ly, fine);
                    for (int y = fy; y < ly; ++y)
                        for (int x = fx; x < lx; ++x)
                            out[static_cast<std::size_t>(y) * static_cast<std::size_t>(nx) +
                                static_cast<std::size_t>(x)] =
                                paint(fine, pointAt(static_cast<float>(x), static_cast<float>(y)));
                }
        }
}

} // namespace tessera
