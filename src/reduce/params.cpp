// SPDX-License-Identifier: Apache-2.0
#include "reduce/params.hpp"

namespace scanmill::reduce {

namespace {
constexpr std::string_view kOrigins[] = {"absolute", "bounds"};
constexpr std::string_view kRepresentatives[] = {"surface", "centre"};
constexpr std::string_view kPositions[] = {"projected", "measured"};
}  // namespace

std::span<const Field> LatticeParams::fields() {
  using P = LatticeParams;
  static const Field kTable[] = {
      field<P, &P::bin_mm>("bin_mm", "h", "Edge of a bin, mm.", {0, 1e6, true}),
      field<P, &P::target_points>("target_points", "", "Choose the bin edge so that about this many points are kept.",
                                  {4, 1e12}),
      field<P, &P::target_bins>("target_bins", "", "Choose the bin edge so that about this many bins are occupied.",
                                {4, 1e12}),
      field<P, &P::origin>(
          "origin", "",
          "absolute: bins never depend on the data; bounds: the paper's, anchored at the cloud's lowest corner.", {},
          kOrigins),
  };
  return kTable;
}

std::span<const Field> Params::fields() {
  using P = Params;
  static const Field kTable[] = {
      field<P, &P::representative>("representative", "",
                                   "surface: the point nearest the bin centre's foot on the local surface; centre: the "
                                   "paper's, nearest the bin's centre.",
                                   {}, kRepresentatives),
      field<P, &P::min_points_per_bin>("min_points_per_bin", "", "Bins with fewer points stay empty.", {1, 1e9}),
      field<P, &P::max_centre_distance>(
          "max_centre_distance", "c1",
          "Drop a kept point farther from its bin's centre than this fraction of the bin edge.", {0, 1}),
      field<P, &P::min_neighbour_distance>(
          "min_neighbour_distance", "c2",
          "Drop a kept point nearer than this fraction of the bin edge to a better one; 0 keeps all.", {0, 1}),
      field<P, &P::neighbour_positions>(
          "neighbour_positions", "",
          "Where c2 is measured: projected on the local surface, or at the measured points (paper).", {}, kPositions),
      field<P, &P::edge_aware>("edge_aware", "", "At creases keep the point farthest from the local plane."),
  };
  return kTable;
}

Params Params::paper() {
  Params params;
  params.representative = Representative::Centre;
  params.min_neighbour_distance = 0.5;
  params.neighbour_positions = NeighbourPositions::Measured;
  return params;
}

}  // namespace scanmill::reduce
