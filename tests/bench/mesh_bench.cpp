// tests/bench/mesh_bench.cpp: time of rays among triangles: making the tree, and casting a picture's rays to
// the first surface and through all of them. The mesh is a sphere with bumps that fills most of the picture.
//
//   mesh_bench --rings 500 --size 512 --threads 2 --rounds 7
#include "core/base/threads.h"
#include "render/geometry/mesh_shape.h"
#include "tests/bench/bench_tools.h"
#include "tests/support/mesh_shapes.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string>
#include <vector>

namespace tessera::bench {
namespace {

double millisecondsOf(const std::function<void()>& work) {
    const auto start = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

void run(int argc, char** argv) {
    auto options = parseOptions(
        argc, argv, {{"--rings", "500"}, {"--size", "512"}, {"--threads", "0"}, {"--rounds", "7"}});
    const int rings = std::stoi(options["--rings"]), size = std::stoi(options["--size"]),
              threads = std::stoi(options["--threads"]);
    TriangleMesh mesh = test::sphereMesh({0, 0, 0}, 100, rings);
    for (glm::vec3& p : mesh.points)
        p *= 1 + 0.03f * std::sin(0.31f * p.x) * std::sin(0.27f * p.y) * std::sin(0.37f * p.z);
    MemoryBudget ram("RAM", "--ram", std::size_t{4} << 30);
    std::unique_ptr<MeshShape> shape;
    const double making = millisecondsOf([&] { shape = std::make_unique<MeshShape>(mesh, ram, "a mesh"); });
    std::printf("%zu triangles, %.1f MiB, made in %.0f ms, peak %.1f MiB\n", shape->parts(),
                static_cast<double>(shape->bytes()) / (1 << 20), making,
                static_cast<double>(ram.peakBytes()) / (1 << 20));
    std::atomic<std::size_t> hits = 0;
    const auto cast = [&](bool all) {
        parallelFor(static_cast<std::size_t>(size), threads, [&](std::size_t row) {
            std::size_t met = 0;
            for (int x = 0; x < size; ++x) {
                const double u = (x + 0.5) / size - 0.5, v = (static_cast<double>(row) + 0.5) / size - 0.5;
                const ShapeRay ray{{210 * u, 210 * v, -50}, {0.2 * u, 0.2 * v, 1}};
                HitOrder after{-1e30, 0};
                for (ShapeHit hit; shape->next(ray, after, 1e30, {}, hit); after = hit.at) {
                    ++met;
                    if (!all)
                        break;
                }
            }
            hits += met;
        });
    };
    for (const bool all : {false, true}) {
        std::vector<double> times;
        for (int round = 0; round < std::stoi(options["--rounds"]); ++round) {
            hits = 0;
            times.push_back(millisecondsOf([&] { cast(all); }));
        }
        std::sort(times.begin(), times.end());
        std::printf("%s: %zu hits, median %.1f ms, least %.1f ms\n", all ? "all surfaces" : "first surface",
                    hits.load(), times[times.size() / 2], times[0]);
    }
}

} // namespace
} // namespace tessera::bench

int main(int argc, char** argv) {
    return tessera::bench::runMain("mesh_bench", tessera::bench::run, argc, argv);
}
