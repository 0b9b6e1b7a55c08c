// SPDX-License-Identifier: Apache-2.0
#include "pipeline/no_surface.hpp"

#include <algorithm>

#include "base/text.hpp"
#include "pipeline/density.hpp"

namespace scanmill::pipeline {
namespace {

constexpr std::uint64_t kFewPoints = 10;
constexpr double kLineWidth = 0.01;         // of its length
constexpr std::uint64_t kPointsPerBin = 4;  // of bins that suit the points

std::size_t farthest_from(const std::vector<Vec3>& points, Vec3 place) {
  std::size_t best = 0;
  for (std::size_t n = 1; n < points.size(); ++n)
    if (norm2(points[n] - place) > norm2(points[best] - place)) best = n;
  return best;
}

bool on_a_line(const std::vector<Vec3>& points) {
  const Vec3 from = points[farthest_from(points, points[0])], to = points[farthest_from(points, from)];
  const Vec3 along = to - from;
  const double length2 = norm2(along);
  return std::all_of(points.begin(), points.end(), [&](const Vec3& p) {
    return norm2(cross(p - from, along)) <= kLineWidth * kLineWidth * length2 * length2;
  });
}

}  // namespace

std::string no_surface_text(const reduce::ReducedCloud& cloud, const reduce::LatticeParams& lattice,
                            std::uint64_t kept) {
  std::uint64_t points = 0;
  for (const auto count : cloud.counts) points += static_cast<std::uint64_t>(count);
  const std::string text = "no triangle can be made of " + counted(points, "point") + " in " +
                           counted(cloud.size(), "bin") + " of " + number_text(cloud.lattice.edge_mm) + " mm (" +
                           grouped(kept) + " kept): ";
  if (points < kFewPoints) return text + "so few points are no surface";
  if (on_a_line(cloud.measured)) return text + "they lie on a line; wanted points of a surface";
  const auto wanted = lattice.target_points ? lattice.target_points : lattice.target_bins;
  if (wanted && *wanted * static_cast<double>(kPointsPerBin) > static_cast<double>(points))
    return text + "lattice." + (lattice.target_points ? "target_points" : "target_bins") + " is " +
           number_text(*wanted) + ", more than so many points can fill; set it to at most " +
           grouped(std::max<std::uint64_t>(points / kPointsPerBin, 1)) + ", or give lattice.bin_mm";
  const auto spacing = spacing_of(cloud);
  if (spacing && cloud.lattice.edge_mm < kFinestBinSpacings * *spacing)
    return text + "the bins are finer than the points, which lie about " + number_text(two_digits(*spacing)) +
           " mm apart; set lattice.bin_mm to about " + number_text(two_digits(kGoodBinSpacings * *spacing)) +
           ", or set units if the numbers are in another unit";
  return text + "is lattice.bin_mm finer than the sensor's pitch, or are the units wrong?";
}

}  // namespace scanmill::pipeline
