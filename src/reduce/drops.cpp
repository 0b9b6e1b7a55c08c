// SPDX-License-Identifier: Apache-2.0
#include "reduce/drops.hpp"

#include "base/large_pages.hpp"
#include "reduce/thin.hpp"

namespace scanmill::reduce {
namespace {

constexpr std::size_t kGrain = 1 << 15;  // rows

double centre_distance2(const ReducedCloud& cloud, std::size_t row) {
  return norm2(cloud.measured[row] - centre_of(cloud.lattice, cloud.key(row)));
}

}  // namespace

void drop_alone(ReducedCloud& cloud, const Params& params, const Context& context) {
  const double h = cloud.lattice.edge_mm;
  for_each_range(context, cloud.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row < end; ++row) {
      if (cloud.drop[row] != Drop::Kept) continue;
      if (!cloud.frame_valid[row])
        cloud.drop[row] = Drop::Isolated;
      else if (params.max_centre_distance &&
               centre_distance2(cloud, row) > (*params.max_centre_distance * h) * (*params.max_centre_distance * h))
        cloud.drop[row] = Drop::CentreDistance;
    }
  });
}

std::vector<std::uint8_t> drop_near(ReducedCloud& cloud, const std::vector<std::uint8_t>& seen, const Params& params,
                                    const Context& context) {
  if (!params.min_neighbour_distance || !(*params.min_neighbour_distance > 0))
    return std::vector<std::uint8_t>(seen.size(), 0);
  std::vector<double> order;
  resize_large(order, cloud.size());
  for_each_range(context, cloud.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row < end; ++row)
      order[row] =
          params.representative == Representative::Centre ? centre_distance2(cloud, row) : cloud.plane_distance[row];
  });
  const bool on_projected = params.neighbour_positions == NeighbourPositions::Projected;
  return thin(cloud, order, *params.min_neighbour_distance, on_projected, seen, context);
}

void count_drops(const ReducedCloud& cloud, Report& report) {
  report.bins = cloud.size();
  for (const Drop drop : cloud.drop) switch (drop) {
      case Drop::Kept:
        ++report.kept;
        break;
      case Drop::TooFewPoints:
        ++report.dropped_too_few;
        break;
      case Drop::Isolated:
        ++report.dropped_isolated;
        break;
      case Drop::CentreDistance:
        ++report.dropped_centre_distance;
        break;
      case Drop::NeighbourDistance:
        ++report.dropped_neighbour_distance;
        break;
    }
}

}  // namespace scanmill::reduce
