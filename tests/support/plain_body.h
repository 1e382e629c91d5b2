// tests/support/plain_body.h: the search of a body and of the table under it, voxel by voxel: sets
// as bytes, distances by a transform of the whole level. It is slow and plain; findTable() must find the
// same.
#pragma once

#include "bricking/analysis/body/body_voxels.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace tessera::test {

/// A byte for each voxel, x fastest.
using PlainMarks = std::vector<std::uint8_t>;

Marks bitsOf(const PlainMarks& plain, const glm::ivec3& extent);
PlainMarks bytesOf(const Marks& marks);

/// Squared distances to the nearest voxel with mark `of`, mm2: lower envelopes of parabolas, an axis after
/// another (core/base/lower_envelope.h).
std::vector<float> plainDistances(const PlainMarks& marks, std::uint8_t of, const BodyGrid& grid);
/// Calls part(voxels) for the connected parts, by faces.
void plainParts(const PlainMarks& marks, const BodyGrid& grid,
                const std::function<void(std::span<const std::size_t>)>& part);
PlainMarks plainDilated(const PlainMarks& marks, const glm::ivec3& extent);
void plainGrowInto(PlainMarks& marks, const PlainMarks& open, const BodyGrid& grid, double mostMm);
PlainMarks plainBody(const PlainMarks& dense, const BodyGrid& grid, double& ballMm);

struct PlainTable {
    PlainMarks hidden; // empty: nothing is
    double litres = 0;
    std::string why;
};
PlainTable plainTable(const ChunkSource& source, int level);

} // namespace tessera::test
