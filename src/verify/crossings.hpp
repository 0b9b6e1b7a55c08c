// SPDX-License-Identifier: Apache-2.0
// All pairs of triangles that cross. Internal to `verify`.
#pragma once
#include <cstdint>
#include <utility>
#include <vector>

#include "base/context.hpp"
#include "mesh/mesh.hpp"

namespace scanmill::verify {

struct CrossingPairs {
  std::uint64_t count = 0;
  std::vector<std::uint8_t> crossed;                           // per triangle: is in a pair
  std::vector<std::pair<std::uint32_t, std::uint32_t>> first;  // (lesser, greater), ascending, as many as asked for
};

/// Every pair whose boxes meet is judged by triangles_cross. Memory does not grow with the number of pairs.
CrossingPairs crossing_pairs(const Mesh& mesh, std::size_t listed, const Context& context);

}  // namespace scanmill::verify
