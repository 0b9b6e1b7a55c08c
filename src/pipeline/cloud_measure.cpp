// SPDX-License-Identifier: Apache-2.0
#include "pipeline/cloud_measure.hpp"

#include <algorithm>
#include <cmath>

#include "reduce/reduce.hpp"

namespace scanmill::pipeline {
namespace {

constexpr std::uint64_t kEnoughToTell = 100, kEnoughForNoise = 1000;  // points
constexpr double kSpacings = 2, kMostSpacings = 3, kNoises = 8, kFewestBins = 8;
constexpr double kShapeGrowth = 2;
constexpr double kTrialBins = 4000;
constexpr std::uint64_t kPointsPerBin = 4;
constexpr double kBinsPerFace = 1.5;  // a smooth surface crosses about so many bins per bin face of its area

}  // namespace

Result<CloudMeasure> measure_cloud(const PointSource& points, const Context& context) {
  reduce::LatticeParams lattice;
  reduce::Params params;
  params.representative = reduce::Representative::Centre;
  lattice.target_bins = kTrialBins;
  TRY_ASSIGN(reduce::Reduction coarse, reduce::reduce_cloud(points, lattice, params, context));
  if (coarse.report.bins * kPointsPerBin > coarse.report.points_used && coarse.report.points_used >= kEnoughToTell) {
    // So few points that most have a bin of their own, and the bins tell no area.
    lattice.target_bins = static_cast<double>(coarse.report.points_used / kPointsPerBin);
    TRY_ASSIGN(coarse, reduce::reduce_cloud(points, lattice, params, context));
  }
  const reduce::Report& seen = coarse.report;
  CloudMeasure measure;
  measure.points_read = seen.points_read;
  measure.points_used = seen.points_used;
  measure.bounds = seen.bounds;
  if (seen.points_used < kEnoughToTell) return measure;
  const double area = static_cast<double>(seen.bins) * seen.bin_mm * seen.bin_mm / kBinsPerFace;
  const double spacing = std::sqrt(area / static_cast<double>(seen.points_used));
  if (!(spacing > 0)) return measure;
  measure.spacing_mm = spacing;
  const Vec3 size = seen.bounds.size();
  const double largest = std::max({size.x, size.y, size.z});
  measure.suggested_bin_mm = std::min(kSpacings * spacing, largest / kFewestBins);
  if (seen.points_used < kEnoughForNoise) return measure;
  lattice = {};
  lattice.bin_mm = 3 * spacing;
  TRY_ASSIGN(const reduce::Reduction fine, reduce::reduce_cloud(points, lattice, params, context));
  measure.noise_mm = fine.report.median_residual * fine.report.bin_mm;
  if (kNoises * *measure.noise_mm <= kSpacings * spacing) return measure;
  // Noise is the same at any scale; the residual of a crease grows with the scale, that of a curved surface with its
  // square. What doubles from a scale to its double is shape: larger bins would lose it.
  lattice.bin_mm = 2 * fine.report.bin_mm;
  TRY_ASSIGN(const reduce::Reduction wide, reduce::reduce_cloud(points, lattice, params, context));
  measure.shape_prevails = wide.report.median_residual * wide.report.bin_mm >= kShapeGrowth * *measure.noise_mm;
  if (measure.shape_prevails) return measure;
  measure.suggested_bin_mm = std::min({kNoises * *measure.noise_mm, kMostSpacings * spacing, largest / kFewestBins});
  return measure;
}

}  // namespace scanmill::pipeline
