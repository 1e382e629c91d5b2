// render/geometry/mesh_bits.cpp: see mesh_bits.h.
#include "render/geometry/mesh_bits.h"

#include "core/base/threads.h"
#include "render/geometry/shape.h"
#include "render/geometry/triangle_hit.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <mutex>

namespace tessera {
namespace {

constexpr std::size_t kStrip = 4096;  // triangles per task of a thread
constexpr std::size_t kTogether = 16; // bricks that are charged together

std::size_t cells(const glm::ivec3& n) {
    return static_cast<std::size_t>(n.x) * static_cast<std::size_t>(n.y) * static_cast<std::size_t>(n.z);
}
std::size_t at(const glm::ivec3& i, const glm::ivec3& n) {
    return (static_cast<std::size_t>(i.z) * static_cast<std::size_t>(n.y) + static_cast<std::size_t>(i.y)) *
               static_cast<std::size_t>(n.x) +
           static_cast<std::size_t>(i.x);
}

/// Whole numbers i of [0,extent) with i + 1/2 in [low,high].
struct Centres {
    int first, last;
    Centres(double low, double high, int extent)
        : first(static_cast<int>(std::ceil(std::clamp(low - 0.5, 0.0, double(extent))))),
          last(static_cast<int>(std::floor(std::clamp(high - 0.5, -1.0, extent - 1.0)))) {}
};

/// The voxels of a triangle along an axis: for every centre across it that the triangle covers, edges
/// included, the one at its depth there.
template <typename Put>
void alongAxis(const glm::dvec3 (&p)[3], int w, const glm::ivec3& extent, const Put& put) {
    const int u = (w + 1) % 3, v = (w + 2) % 3;
    const auto least = [&](int axis) { return std::min({p[0][axis], p[1][axis], p[2][axis]}); };
    const auto most = [&](int axis) { return std::max({p[0][axis], p[1][axis], p[2][axis]}); };
    const Centres across(least(u), most(u), extent[u]), up(least(v), most(v), extent[v]);
    if (across.first > across.last || up.first > up.last)
        return;
    const double low = least(w), high = most(w);
    for (int y = up.first; y <= up.last; ++y)
        for (int x = across.first; x <= across.last; ++x) {
            const auto from = [&](const glm::dvec3& q) {
                return glm::dvec3(q[u] - (x + 0.5), q[v] - (y + 0.5), 0);
            };
            const glm::dvec3 a = from(p[0]), b = from(p[1]), c = from(p[2]);
            // Of two triangles that share an edge one has it for sure: its sign changes exactly.
            const double s = triangle::side(b, c), t = triangle::side(c, a), r = triangle::side(a, b);
            if (std::min({s, t, r}) < 0 && std::max({s, t, r}) > 0)
                continue;
            const double depth =
                std::floor(std::clamp((s * p[0][w] + t * p[1][w] + r * p[2][w]) / (s + t + r), low, high));
            if (!(depth >= 0 && depth < extent[w]))
                continue;
            glm::ivec3 voxel;
            voxel[u] = x, voxel[v] = y, voxel[w] = static_cast<int>(depth);
            put(voxel);
        }
}

/// The voxels of a line: of its ends, and one a slice along the axis that it is steepest to.
template <typename Put>
void alongLine(const glm::dvec3& a, const glm::dvec3& b, const glm::ivec3& extent, const Put& put) {
    const auto putAt = [&](const glm::dvec3& place) {
        if (glm::all(glm::greaterThanEqual(place, glm::dvec3(0))) &&
            glm::all(glm::lessThan(place, glm::dvec3(extent))))
            put(glm::ivec3(place));
    };
    putAt(a);
    putAt(b);
    const glm::dvec3 d = glm::abs(b - a);
    const int w = d.x > d.y ? (d.x > d.z ? 0 : 2) : (d.y > d.z ? 1 : 2);
    const Centres slices(std::min(a[w], b[w]), std::max(a[w], b[w]), extent[w]);
    for (int n = slices.first; n <= slices.last; ++n)
        putAt(glm::mix(a, b, (n + 0.5 - a[w]) / (b[w] - a[w])));
}

template <typename Put> void putTriangle(const glm::dvec3 (&p)[3], const glm::ivec3& extent, const Put& put) {
    if (p[1] == p[2]) {
        alongLine(p[0], p[1], extent, put);
        return;
    }
    const glm::dvec3 normal = glm::abs(glm::cross(p[1] - p[0], p[2] - p[0]));
    const double least = 1e-9 * std::max({normal.x, normal.y, normal.z});
    for (int axis = 0; axis < 3; ++axis)
        if (normal[axis] > least) // else it is seen from its edge
            alongAxis(p, axis, extent, put);
}

} // namespace

/// Bricks that several threads set at once; those of one kind.
class MeshBits::Maker {
  public:
    Maker(MeshBits& bits, MemoryBudget* ram) : bits_(bits), ram_(ram) {}

    template <typename Brick>
    void put(std::span<const SceneMesh> meshes, bool opaque, int threads,
             std::vector<std::unique_ptr<Brick>>& kept) {
        charge(cells(bits_.bricks_) * (sizeof(kept[0]) + sizeof(std::atomic<Brick*>)));
        kept.resize(cells(bits_.bricks_));
        bits_.bytes_ += kept.size() * sizeof(kept[0]);
        std::vector<std::atomic<Brick*>> table(kept.size());
        std::size_t made = 0;
        const auto brickOf = [&](std::size_t n) -> Brick& {
            if (Brick* const there = table[n].load(std::memory_order_acquire))
                return *there;
            const std::lock_guard lock(mutex_);
            if (!kept[n]) {
                if (made++ % kTogether == 0)
                    charge(kTogether * sizeof(Brick));
                kept[n] = std::make_unique<Brick>();
                bits_.bytes_ += sizeof(Brick);
                table[n].store(kept[n].get(), std::memory_order_release);
            }
            return *kept[n];
        };
        for (const SceneMesh& mesh : meshes)
            if (mesh.isDrawn() && (mesh.opacity < 1) != opaque)
                rasterise(mesh, threads, brickOf);
    }

  private:
    void charge(std::size_t bytes) {
        if (ram_)
            bits_.charges_.push_back(ram_->charge(bytes, "voxelised meshes"));
    }
    template <typename BrickOf>
    void rasterise(const SceneMesh& mesh, int threads, const BrickOf& brickOf) const {
        const VoxelGrid& grid = bits_.grid_;
        const glm::dmat3 turn(grid.fromPatient);
        const glm::dvec3 move(grid.fromPatient[3]);
        const auto alpha = static_cast<std::uint8_t>(std::max(1.0, std::round(255 * mesh.opacity)));
        const std::size_t parts = mesh.shape->parts();
        parallelFor((parts + kStrip - 1) / kStrip, threads, [&](std::size_t strip) {
            const auto put = [&](const glm::ivec3& voxel) {
                const glm::ivec3 in = voxel & (kBrick - 1);
                set(brickOf(at(voxel / kBrick, bits_.bricks_)), in, alpha);
            };
            mesh.shape->forEachTriangle(
                strip * kStrip, std::min(parts, (strip + 1) * kStrip), grid.edgeMm / 4,
                [&](const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
                    const glm::dvec3 p[3] = {turn * a + move, turn * b + move, turn * c + move};
                    putTriangle(p, grid.extent, put);
                });
        });
    }
    static void set(Words& words, const glm::ivec3& in, std::uint8_t) {
        const std::atomic_ref word(words[static_cast<std::size_t>(kBrick * in.z + in.y)]);
        const std::uint32_t bit = 1u << in.x;
        if ((word.load(std::memory_order_relaxed) & bit) == 0)
            word.fetch_or(bit, std::memory_order_relaxed);
    }
    static void set(Alphas& alphas, const glm::ivec3& in, std::uint8_t alpha) {
        const std::atomic_ref kept(alphas[at(in, glm::ivec3(kBrick))]);
        std::uint8_t before = kept.load(std::memory_order_relaxed);
        while (before < alpha && !kept.compare_exchange_weak(before, alpha, std::memory_order_relaxed)) {
        }
    }

    MeshBits& bits_;
    MemoryBudget* ram_;
    std::mutex mutex_;
};

MeshBits::MeshBits(std::span<const SceneMesh> meshes, const VoxelGrid& grid, MemoryBudget* ram, int threads,
                   bool distances)
    : grid_(grid), bricks_(grid.bricks()), blocks_((grid.extent + (kBlock - 1)) / kBlock) {
    Maker maker(*this, ram);
    maker.put(meshes, true, threads, words_);
    if (std::any_of(meshes.begin(), meshes.end(),
                    [](const SceneMesh& m) { return m.isDrawn() && m.opacity < 1; }))
        maker.put(meshes, false, threads, alphas_);
    if (!distances)
        return;
    if (ram)
        charges_.push_back(ram->charge(cells(blocks_), "voxelised meshes"));
    bytes_ += cells(blocks_);
    findDistances();
}

std::size_t MeshBits::bytesAtMost(std::span<const SceneMesh> meshes, const VoxelGrid& grid, bool distances) {
    const std::size_t all = cells(grid.bricks());
    std::size_t bits = 0, alphas = 0;
    bool translucent = false;
    for (const SceneMesh& mesh : meshes) {
        const ShapeBox& box = mesh.shape->box();
        glm::dvec3 low(std::numeric_limits<double>::max()), high(-low);
        for (int corner = 0; corner < 8; ++corner) {
            const glm::dvec3 p(corner & 1 ? box.high.x : box.low.x, corner & 2 ? box.high.y : box.low.y,
                               corner & 4 ? box.high.z : box.low.z);
            const glm::dvec3 place(grid.fromPatient * glm::dvec4(p, 1));
            low = glm::min(low, place), high = glm::max(high, place);
        }
        const glm::dvec3 extent(grid.extent);
        const glm::ivec3 from = glm::ivec3(glm::clamp(low - 1.0, glm::dvec3(0), extent)) / kBrick,
                         to = glm::min(glm::ivec3(glm::clamp(high + 1.0, glm::dvec3(0), extent)) / kBrick + 1,
                                       grid.bricks());
        (mesh.opacity < 1 ? alphas : bits) += cells(glm::max(to - from, glm::ivec3(0)));
        translucent = translucent || mesh.opacity < 1;
    }
    const auto bytes = [&](std::size_t bricks, std::size_t each) {
        return (std::min(bricks, all) + kTogether) * each + all * 2 * sizeof(void*);
    };
    return bytes(bits, sizeof(Words)) + (translucent ? bytes(alphas, sizeof(Alphas)) : 0) +
           (distances ? cells((grid.extent + (kBlock - 1)) / kBlock) : 0);
}

/// Of every block, by two sweeps (chessboard distance).
void MeshBits::findDistances() {
    constexpr int kMost = 255;
    distances_.assign(cells(blocks_), kMost);
    const auto mark = [&](const glm::ivec3& brick, int x, int y, int z) {
        const glm::ivec3 block = (brick * kBrick + glm::ivec3(x, y, z)) / kBlock;
        if (glm::all(glm::lessThan(block, blocks_)))
            distances_[at(block, blocks_)] = 0;
    };
    glm::ivec3 b;
    for (b.z = 0; b.z < bricks_.z; ++b.z)
        for (b.y = 0; b.y < bricks_.y; ++b.y)
            for (b.x = 0; b.x < bricks_.x; ++b.x) {
                const std::uint32_t* const words = brickBits(b);
                const std::uint8_t* const alphas = brickAlphas(b);
                for (int row = 0; row < kBrick * kBrick; ++row)
                    for (int x = 0; x < kBrick; x += kBlock) {
                        const bool set = words && (words[row] >> x & ((1u << kBlock) - 1)) != 0;
                        if (set || (alphas &&
                                    std::any_of(alphas + row * kBrick + x, alphas + row * kBrick + x + kBlock,
                                                [](std::uint8_t a) { return a != 0; })))
                            mark(b, x, row % kBrick, row / kBrick);
                    }
            }
    const auto sweep = [&](int sign) {
        const auto turned = [&](int n, int count) { return sign > 0 ? n : count - 1 - n; };
        for (int k = 0; k < blocks_.z; ++k)
            for (int j = 0; j < blocks_.y; ++j)
                for (int i = 0; i < blocks_.x; ++i) {
                    const glm::ivec3 here(turned(i, blocks_.x), turned(j, blocks_.y), turned(k, blocks_.z));
                    int least = distances_[at(here, blocks_)];
                    for (int n = 0; n < 13 && least > 1; ++n) { // the neighbours that came before
                        const glm::ivec3 to = here - sign * glm::ivec3((n + 14) % 3 - 1, (n + 14) / 3 % 3 - 1,
                                                                       (n + 14) / 9 - 1);
                        if (glm::all(glm::greaterThanEqual(to, glm::ivec3(0))) &&
                            glm::all(glm::lessThan(to, blocks_)))
                            least = std::min(least, distances_[at(to, blocks_)] + 1);
                    }
                    distances_[at(here, blocks_)] = static_cast<std::uint8_t>(least);
                }
    };
    sweep(1);
    sweep(-1);
}

const std::uint32_t* MeshBits::brickBits(const glm::ivec3& brick) const {
    const auto& kept = words_[at(brick, bricks_)];
    return kept ? kept->data() : nullptr;
}
const std::uint8_t* MeshBits::brickAlphas(const glm::ivec3& brick) const {
    if (alphas_.empty())
        return nullptr;
    const auto& kept = alphas_[at(brick, bricks_)];
    return kept ? kept->data() : nullptr;
}

bool MeshBits::isSet(const glm::ivec3& voxel) const {
    if (glm::any(glm::lessThan(voxel, glm::ivec3(0))) || glm::any(glm::greaterThanEqual(voxel, grid_.extent)))
        return false;
    const std::uint32_t* const words = brickBits(voxel / kBrick);
    const glm::ivec3 in = voxel & (kBrick - 1);
    return words && (words[kBrick * in.z + in.y] >> in.x & 1) != 0;
}
std::uint8_t MeshBits::alphaOf(const glm::ivec3& voxel) const {
    if (glm::any(glm::lessThan(voxel, glm::ivec3(0))) || glm::any(glm::greaterThanEqual(voxel, grid_.extent)))
        return 0;
    const std::uint8_t* const alphas = brickAlphas(voxel / kBrick);
    return alphas ? alphas[at(voxel & (kBrick - 1), glm::ivec3(kBrick))] : std::uint8_t{0};
}

float MeshBits::coverage(const glm::vec3& place) const {
    const glm::vec3 low = glm::floor(place - 0.5f), f = place - 0.5f - low;
    const glm::ivec3 i(low), in = i & (kBrick - 1);
    std::uint32_t rows[4]; // two bits each, of (y, z), (y + 1, z), (y, z + 1), (y + 1, z + 1)
    if (glm::all(glm::greaterThanEqual(i, glm::ivec3(0))) && glm::all(glm::lessThan(i, grid_.extent)) &&
        std::max({in.x, in.y, in.z}) < kBrick - 1) {
        const std::uint32_t* words = brickBits(i / kBrick);
        if (!words)
            return 0;
        words += kBrick * in.z + in.y;
        rows[0] = words[0] >> in.x & 3, rows[1] = words[1] >> in.x & 3;
        rows[2] = words[kBrick] >> in.x & 3, rows[3] = words[kBrick + 1] >> in.x & 3;
    } else {
        for (int n = 0; n < 4; ++n) {
            const glm::ivec3 row = i + glm::ivec3(0, n & 1, n >> 1);
            rows[n] = (isSet(row) ? 1u : 0u) | (isSet(row + glm::ivec3(1, 0, 0)) ? 2u : 0u);
        }
    }
    if ((rows[0] | rows[1] | rows[2] | rows[3]) == 0)
        return 0;
    const float along[4] = {0, 1 - f.x, f.x, 1};
    return (1 - f.z) * ((1 - f.y) * along[rows[0]] + f.y * along[rows[1]]) +
           f.z * ((1 - f.y) * along[rows[2]] + f.y * along[rows[3]]);
}

float MeshBits::thicknessOf(std::uint8_t alpha) {
    static const auto table = [] {
        std::array<float, 256> t{};
        for (int n = 0; n < 255; ++n)
            t[static_cast<std::size_t>(n)] =
                static_cast<float>(std::min(-std::log1p(-n / 255.0), double{kOpaque}));
        t[255] = kOpaque;
        return t;
    }();
    return table[alpha];
}

float MeshBits::thickness(const glm::vec3& place) const {
    if (alphas_.empty())
        return 0;
    const glm::vec3 low = glm::floor(place - 0.5f), f = place - 0.5f - low;
    float sum = 0;
    for (int n = 0; n < 8; ++n) {
        const glm::ivec3 corner(n & 1, n >> 1 & 1, n >> 2);
        if (const std::uint8_t alpha = alphaOf(glm::ivec3(low) + corner)) {
            const glm::vec3 w = glm::mix(1.0f - f, f, glm::vec3(corner));
            sum += w.x * w.y * w.z * thicknessOf(alpha);
        }
    }
    return sum;
}

int MeshBits::clearVoxels(const glm::vec3& place) const {
    const glm::ivec3 block = glm::ivec3(glm::floor(place)) >> 2;
    static_assert(kBlock == 4);
    if (glm::any(glm::lessThan(block, glm::ivec3(0))) || glm::any(glm::greaterThanEqual(block, blocks_)))
        return 0;
    // Values reach a voxel further than bits.
    return kBlock * (distances_[at(block, blocks_)] - 1) - 1;
}

std::size_t MeshBits::count() const {
    std::size_t sum = 0;
    for (const auto& words : words_)
        if (words)
            for (const std::uint32_t word : *words)
                sum += static_cast<std::size_t>(std::popcount(word));
    return sum;
}

} // namespace tessera
