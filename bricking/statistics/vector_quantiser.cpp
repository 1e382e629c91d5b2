// bricking/statistics/vector_quantiser.cpp: see vector_quantiser.h. Sums are whole numbers, so their order
// does not matter.
#include "bricking/statistics/vector_quantiser.h"

#include "core/base/error.h"
#include "core/base/threads.h"

#include <algorithm>
#include <cstdlib>
#include <numeric>
#include <queue>
#include <tuple>
#include <utility>

namespace tessera {
namespace {

using ByteVector = VectorQuantiser::Vector;
using Sums = std::array<std::uint32_t, VectorQuantiser::kLength>;

constexpr std::size_t kBranches = 8;   // that a search follows
constexpr int kSplitRounds = 6;        // of the two halves of a cluster
constexpr std::size_t kBlock = 1024;   // vectors of a task
constexpr std::uint64_t kEnough = 500; // rounds end where one gains less than a part in so many

void add(Sums& sums, const ByteVector& vector) {
    for (std::size_t i = 0; i < vector.size(); ++i)
        sums[i] += vector[i];
}
/// @param count  at least 1
ByteVector meanOf(const Sums& sums, std::size_t count) {
    ByteVector mean{};
    for (std::size_t i = 0; i < mean.size(); ++i)
        mean[i] = static_cast<std::uint8_t>((sums[i] + count / 2) / count);
    return mean;
}

struct Half {
    ByteVector centre{};
    std::uint64_t error = 0;
    std::size_t count = 0;
};

/// Sorts a cluster's members into two halves, the first one first. One is empty where all are equal.
std::array<Half, 2> halve(std::span<const ByteVector> sample, std::span<std::uint32_t> members,
                          const ByteVector& centre, std::vector<std::uint8_t>& side) {
    const auto furthestFrom = [&](const ByteVector& from) {
        return sample[*std::max_element(members.begin(), members.end(), [&](auto a, auto b) {
            return std::tuple(VectorQuantiser::distance(sample[a], from), b) <
                   std::tuple(VectorQuantiser::distance(sample[b], from), a);
        })];
    };
    std::array<Half, 2> halves;
    halves[0].centre = furthestFrom(centre);
    halves[1].centre = furthestFrom(halves[0].centre);
    side.assign(members.size(), 2);
    for (int round = 0; round < kSplitRounds; ++round) {
        std::array<Half, 2> now;
        std::array<Sums, 2> sums{};
        bool changes = false;
        for (std::size_t n = 0; n < members.size(); ++n) {
            const ByteVector& vector = sample[members[n]];
            const unsigned to[2] = {VectorQuantiser::distance(vector, halves[0].centre),
                                    VectorQuantiser::distance(vector, halves[1].centre)};
            const std::uint8_t nearer = to[1] < to[0] ? 1 : 0;
            changes = changes || side[n] != nearer;
            side[n] = nearer;
            add(sums[nearer], vector);
            ++now[nearer].count;
            now[nearer].error += to[nearer];
        }
        for (std::size_t h = 0; h < 2; ++h)
            now[h].centre = now[h].count > 0 ? meanOf(sums[h], now[h].count) : halves[h].centre;
        halves = now;
        if (!changes || now[0].count == 0 || now[1].count == 0)
            break;
    }
    std::vector<std::uint32_t> second;
    std::size_t first = 0;
    for (std::size_t n = 0; n < members.size(); ++n)
        if (side[n] == 0)
            members[first++] = members[n];
        else
            second.push_back(members[n]);
    std::copy(second.begin(), second.end(), members.begin() + static_cast<std::ptrdiff_t>(first));
    return halves;
}

} // namespace

unsigned VectorQuantiser::distance(const Vector& a, const Vector& b) {
    int sum = 0;
    for (std::size_t i = 0; i < kLength; ++i)
        sum += std::abs(int(a[i]) - int(b[i]));
    return static_cast<unsigned>(sum);
}

std::size_t VectorQuantiser::bytes(std::size_t sample, std::size_t most) {
    return sample * (3 * sizeof(std::uint32_t)) + 2 * most * (sizeof(Node) + sizeof(Sums));
}

VectorQuantiser::VectorQuantiser(std::span<const Vector> sample, std::size_t most, int threads) {
    TESSERA_CHECK(!sample.empty() && most >= 1 && most <= 65536);
    split(sample, most);
    for (std::uint32_t n = 0; n < nodes_.size(); ++n)
        if (nodes_[n].below[0] == kLeaf) {
            nodes_[n].number = static_cast<std::uint32_t>(leaves_.size());
            leaves_.push_back(n);
        }
    settle(sample, threads);
}

void VectorQuantiser::split(std::span<const Vector> sample, std::size_t most) {
    std::vector<std::uint32_t> members(sample.size());
    std::iota(members.begin(), members.end(), 0u);
    struct Cluster {
        std::uint64_t error;
        std::uint32_t node;
        std::size_t first, count;
        bool operator<(const Cluster& other) const {
            return error != other.error ? error < other.error : node > other.node;
        }
    };
    Sums all{};
    for (const Vector& vector : sample)
        add(all, vector);
    nodes_.push_back({meanOf(all, sample.size())});
    std::priority_queue<Cluster> clusters;
    clusters.push({UINT64_MAX, 0, 0, sample.size()});
    std::vector<std::uint8_t> side;
    for (std::size_t leaves = 1; leaves < most && !clusters.empty();) {
        const Cluster whole = clusters.top();
        clusters.pop();
        if (whole.error == 0 || whole.count < 2)
            continue;
        const auto halves = halve(sample, std::span(members).subspan(whole.first, whole.count),
                                  nodes_[whole.node].centre, side);
        if (halves[0].count == 0 || halves[1].count == 0)
            continue; // all alike
        std::size_t first = whole.first;
        for (std::size_t h = 0; h < 2; ++h) {
            const auto node = static_cast<std::uint32_t>(nodes_.size());
            nodes_[whole.node].below[h] = node;
            nodes_.push_back({halves[h].centre});
            clusters.push({halves[h].error, node, first, halves[h].count});
            first += halves[h].count;
        }
        ++leaves;
    }
}

void VectorQuantiser::settle(std::span<const Vector> sample, int threads) {
    std::vector<std::uint16_t> numbers(sample.size());
    std::vector<Sums> sums(nodes_.size());
    std::vector<std::size_t> counts(nodes_.size());
    const std::size_t blocks = (sample.size() + kBlock - 1) / kBlock;
    std::uint64_t before = UINT64_MAX;
    for (int round = 0; round < kRounds; ++round) {
        parallelFor(blocks, threads, [&](std::size_t block) {
            for (std::size_t n = block * kBlock; n < std::min(sample.size(), (block + 1) * kBlock); ++n)
                numbers[n] = nearest(sample[n]);
        });
        std::fill(sums.begin(), sums.end(), Sums{});
        std::fill(counts.begin(), counts.end(), std::size_t{0});
        std::uint64_t error = 0;
        for (std::size_t n = 0; n < sample.size(); ++n) {
            const std::uint32_t node = leaves_[numbers[n]];
            error += distance(sample[n], nodes_[node].centre);
            add(sums[node], sample[n]);
            ++counts[node];
        }
        for (std::size_t node = nodes_.size(); node-- > 0;) {
            for (const std::uint32_t below : nodes_[node].below)
                if (below != kLeaf) {
                    counts[node] += counts[below];
                    for (std::size_t i = 0; i < kLength; ++i)
                        sums[node][i] += sums[below][i];
                }
            if (counts[node] > 0)
                nodes_[node].centre = meanOf(sums[node], counts[node]);
        }
        if (error == 0 || (before != UINT64_MAX && error + before / kEnough >= before))
            break;
        before = error;
    }
}

std::uint16_t VectorQuantiser::nearest(const Vector& vector) const {
    using Candidate = std::pair<unsigned, std::uint32_t>; // distance, node
    std::array<Candidate, 2 * kBranches> found;
    std::size_t count = 1;
    found[0] = {0, 0};
    for (bool goesOn = true; goesOn;) {
        goesOn = false;
        std::array<Candidate, 2 * kBranches> next;
        std::size_t most = 0;
        for (std::size_t n = 0; n < count; ++n) {
            const Node& node = nodes_[found[n].second];
            if (node.below[0] == kLeaf) {
                next[most++] = found[n];
                continue;
            }
            goesOn = true;
            for (const std::uint32_t below : node.below)
                next[most++] = {distance(vector, nodes_[below].centre), below};
        }
        count = std::min(most, kBranches);
        std::partial_sort(next.begin(), next.begin() + static_cast<std::ptrdiff_t>(count),
                          next.begin() + static_cast<std::ptrdiff_t>(most));
        found = next;
    }
    return static_cast<std::uint16_t>(nodes_[found[0].second].number);
}

} // namespace tessera
