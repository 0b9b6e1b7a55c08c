// SPDX-License-Identifier: Apache-2.0
#include "pipeline/density.hpp"

#include <algorithm>
#include <cmath>

#include "base/text.hpp"

namespace scanmill::pipeline {
namespace {

constexpr std::uint64_t kEnoughToTell = 100;  // points
constexpr std::uint64_t kPointsPerBin = 9;
constexpr double kBinsPerFace = 1.5;  // a smooth surface crosses about so many bins per bin face of its area

std::string edge_text(double value) { return number_text(two_digits(value)) + " mm"; }

std::string percent_text(std::uint64_t part, std::uint64_t whole) {
  const double tenths = std::floor(static_cast<double>(part) / static_cast<double>(whole) * 1000);
  return number_text(tenths / 10) + " %";
}

}  // namespace

double two_digits(double value) {
  if (!(value > 0) || !std::isfinite(value)) return 0;
  double scale = 1;
  while (value * scale < 10) scale *= 10;
  double step = 1;
  while (value >= 100 * step) step *= 10;
  return std::floor(value * scale / step + 0.5) * step / scale;
}

std::optional<double> spacing_of(const reduce::ReducedCloud& cloud, std::span<const std::uint8_t> rows) {
  std::vector<LocalBin> bins;
  std::uint64_t points = 0;
  for (std::size_t row = 0; row < cloud.size(); ++row) {
    if (!rows.empty() && rows[row] == 0) continue;
    bins.push_back(cloud.bins[row]);
    points += static_cast<std::uint64_t>(cloud.counts[row]);
  }
  if (points < kEnoughToTell) return std::nullopt;
  double edge = cloud.lattice.edge_mm;
  while (bins.size() * kPointsPerBin > points) {
    for (LocalBin& bin : bins)
      for (std::int32_t& axis : bin) axis >>= 1;
    std::sort(bins.begin(), bins.end());
    bins.erase(std::unique(bins.begin(), bins.end()), bins.end());
    edge *= 2;
  }
  return std::sqrt(static_cast<double>(bins.size()) / kBinsPerFace / static_cast<double>(points)) * edge;
}

std::string fine_bins_note(const reduce::ReducedCloud& cloud) {
  const auto spacing = spacing_of(cloud);
  if (!spacing || cloud.lattice.edge_mm >= kFinestBinSpacings * *spacing) return {};
  return "bins of " + number_text(cloud.lattice.edge_mm) + " mm are too fine: the points lie about " +
         edge_text(*spacing) +
         " apart, so many bins are empty and the surface gets holes; set lattice.bin_mm to about " +
         edge_text(kGoodBinSpacings * *spacing);
}

std::string coverage_note(std::uint64_t meshed, std::uint64_t points, const Unmeshed& off,
                          const reduce::ReducedCloud& cloud, bool cover) {
  if (points == 0 || static_cast<double>(meshed) >= kLeastMeshedShare * static_cast<double>(points)) return {};
  std::string text = "the mesh stands for " + percent_text(meshed, points) + " of the points: " + grouped(meshed) +
                     " of " + grouped(points) + " lie within a bin edge of a triangle";
  if (!cover) return text + "; the job leaves out what no given seed reaches (seeds.cover: false)";
  const auto spacing = spacing_of(cloud, off.rows);
  if (spacing && cloud.lattice.edge_mm < kFinestBinSpacings * *spacing)
    return text + "; the others lie about " + edge_text(*spacing) + " apart, too far for bins of " +
           number_text(cloud.lattice.edge_mm) + " mm: set lattice.bin_mm to about " +
           edge_text(kGoodBinSpacings * *spacing);
  return text +
         "; the others stray about or form pieces too small to keep: take them out (clean.outliers), or set "
         "lattice.bin_mm larger";
}

}  // namespace scanmill::pipeline
