// bricking/analysis/body/body_marks.cpp: see body_marks.h.
#include "bricking/analysis/body/body_marks.h"

#include <algorithm>
#include <cstdint>
#include <vector>

namespace tessera {

Marks reached(const Marks& firm, const BodyGrid& grid) {
    const glm::ivec3 e = grid.extent;
    Marks marks(firm.size());
    std::vector<glm::ivec3> next;
    const auto take = [&](const glm::ivec3& at) {
        const std::size_t i = linearIndex(at, e);
        if (!firm[i] && !marks[i]) {
            marks[i] = 1;
            next.push_back(at);
        }
    };
    for (int z = 0; z < e.z; ++z) {
        for (int x = 0; x < e.x; ++x)
            take({x, 0, z}), take({x, e.y - 1, z});
        for (int y = 0; y < e.y; ++y)
            take({0, y, z}), take({e.x - 1, y, z});
        for (; !next.empty();) {
            const glm::ivec3 at = next.back();
            next.pop_back();
            for (const glm::ivec3& step : {glm::ivec3(1, 0, 0), glm::ivec3(0, 1, 0)})
                for (const glm::ivec3& beside : {at - step, at + step})
                    if (beside.x >= 0 && beside.y >= 0 && beside.x < e.x && beside.y < e.y)
                        take(beside);
        }
    }
    return marks;
}

Marks beyond(const Marks& body, const Outwards& side, const glm::ivec3& extent) {
    Marks marks(body.size());
    forLines(side, extent, [&](int steps, const auto& at) {
        for (int step = steps - 1; step >= 0 && !body[at(step)]; --step)
            marks[at(step)] = 1;
    });
    return marks;
}

std::size_t facingBody(const Marks& marks, const Marks& body, const Outwards& side,
                       const glm::ivec3& extent) {
    std::size_t count = 0;
    forLines(side, extent, [&](int steps, const auto& at) {
        bool marked = false, meets = false;
        for (int step = 0; step < steps; ++step) {
            marked |= marks[at(step)] != 0;
            meets |= body[at(step)] != 0;
        }
        count += marked && meets;
    });
    return count;
}

Marks dilated(const Marks& marks, const glm::ivec3& e) {
    Marks out = marks, before;
    const std::array<std::size_t, 3> strides = {1, static_cast<std::size_t>(e.x), cellCount({e.x, e.y, 1})};
    for (int axis = 0; axis < 3; ++axis) {
        before = out;
        const std::size_t stride = strides[static_cast<std::size_t>(axis)];
        for (std::size_t i = 0; i < out.size(); ++i) {
            const int at = static_cast<int>(i / stride % static_cast<std::size_t>(e[axis]));
            out[i] = before[i] || (at > 0 && before[i - stride]) || (at + 1 < e[axis] && before[i + stride]);
        }
    }
    return out;
}

void growInto(Marks& marks, const Marks& open, const BodyGrid& grid, double mostMm) {
    std::vector<std::int32_t> next;
    std::vector<float> away(marks.size(), 0);
    for (std::size_t i = 0; i < marks.size(); ++i)
        if (marks[i])
            next.push_back(static_cast<std::int32_t>(i));
    for (std::size_t n = 0; n < next.size(); ++n) {
        const auto from = static_cast<std::size_t>(next[n]);
        const glm::ivec3 place = gridPosition(from, grid.extent);
        grid.beside(from, [&](std::size_t to) {
            if (marks[to] || !open[to])
                return;
            const glm::ivec3 step = gridPosition(to, grid.extent) - place;
            const int axis = step.x != 0 ? 0 : step.y != 0 ? 1 : 2;
            const float far = away[from] + static_cast<float>(grid.spacingMm[axis]);
            if (far > mostMm)
                return;
            marks[to] = 1;
            away[to] = far;
            next.push_back(static_cast<std::int32_t>(to));
        });
    }
}

Marks both(const Marks& a, const Marks& b) {
    Marks out(a.size());
    std::transform(a.begin(), a.end(), b.begin(), out.begin(),
                   [](std::uint8_t one, std::uint8_t other) { return one && other; });
    return out;
}

} // namespace tessera
