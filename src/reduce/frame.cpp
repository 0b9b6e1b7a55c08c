// SPDX-License-Identifier: Apache-2.0
// Local planes from exact moments (docs/algorithm.md, "Frame"). The moments are integers, the sums over the window run
// in a fixed order, so a frame is the same whichever thread or brick computes it.
#include "reduce/frame.hpp"

#include <algorithm>

#include "base/digest.hpp"
#include "geom/plane_fit.hpp"

namespace scanmill::reduce {
namespace {

constexpr std::size_t kGrain = 4096;
constexpr double kSteps = 1024, kUnit = 1 / kSteps;                // to a bin edge; powers of two, so nothing rounds
constexpr double kWeights[2][3] = {{1.0, 0.60653065971263342, 0},  // exp(-d^2/2), radius 1
                                   {1.0, 0.80073740291680806, 0.41111229050718745}};  // exp(-d^2/4.5), radius 2
// Variance of position under the weights, a bin's own 1/12 included: 0.631 and 1.512 h^2. A curved surface's residual
// grows with its square.
constexpr double kCurvatureGrowth = 5.74;
constexpr std::size_t kNoiseSample = 4096;  // bins, about
constexpr int kMinBins = 4;
constexpr double kMinTrace = 0.05;
constexpr double kSignCosine = 0.25;  // a view this flat to the surface says nothing about its side

/// The weighted moments of a window about the centre of its middle bin, lengths in h/1024. Moving a bin's moments by
/// whole bins is exact; only the weights round.
struct Sums {
  double weight = 0, x = 0, y = 0, z = 0, xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;

  /// Of a bin whose centre lies at (i, j, k).
  void add(const WholeSums& m, double w, double i, double j, double k) {
    const double mx = m.x + m.count * i, my = m.y + m.count * j, mz = m.z + m.count * k;
    weight += w * m.count;
    x += w * mx;
    y += w * my;
    z += w * mz;
    xx += w * (m.xx + i * (m.x + mx));
    xy += w * (m.xy + m.x * j + i * my);
    xz += w * (m.xz + m.x * k + i * mz);
    yy += w * (m.yy + j * (m.y + my));
    yz += w * (m.yz + m.y * k + j * mz);
    zz += w * (m.zz + k * (m.z + mz));
  }
};

bool is_sampled(const BinKey& key, std::uint64_t every) {
  const std::uint64_t hash = mix64(static_cast<std::uint64_t>(key.i) ^
                                   mix64(static_cast<std::uint64_t>(key.j) ^ mix64(static_cast<std::uint64_t>(key.k))));
  return hash % every == 0;
}

Vec3 vector_of(const Direction& d) {
  return {static_cast<double>(d[0]), static_cast<double>(d[1]), static_cast<double>(d[2])};
}

/// What is fixed per cloud, for one frame after the other.
struct Windows {
  const ReducedCloud& cloud;
  const BinCells& cells;
  int radius;

  /// Frame `to` is the frame of `row`.
  void frame_of(std::size_t row, std::span<const BinIndex::Reader::Neighbour> around, Frames& f, std::size_t to) const {
    const double* weight = kWeights[radius - 1];
    const bool is_seen = cells.directions.size() > 0;
    Sums s;
    Vec3 direction;
    for (const auto& near : around) {
      const auto other = static_cast<std::size_t>(near.row);
      const double w = weight[std::abs(near.di)] * weight[std::abs(near.dj)] * weight[std::abs(near.dk)];
      s.add(cells[other].sums, w, kSteps * near.di, kSteps * near.dj, kSteps * near.dk);
      if (is_seen) direction += vector_of(cells.direction(other)) * w;
    }
    const double inverse = 1 / s.weight;
    const Vec3 m = Vec3{s.x * inverse, s.y * inverse, s.z * inverse} * kUnit;
    const double square = kUnit * kUnit * inverse;
    const PlaneFit fit = fit_plane({s.xx * square - m.x * m.x, s.xy * square - m.x * m.y, s.xz * square - m.x * m.z,
                                    s.yy * square - m.y * m.y, s.yz * square - m.y * m.z, s.zz * square - m.z * m.z});
    const double length = norm(direction), cosine = length > 0 ? dot(fit.normal, direction) / length : 0;
    f.centroid[to] = centre_of(cloud.lattice, cloud.key(row)) + m * cloud.lattice.edge_mm;
    f.normal[to] = cosine < 0 ? -fit.normal : fit.normal;
    f.sign_known[to] = std::abs(cosine) > kSignCosine;
    f.residual[to] = static_cast<float>(std::sqrt(fit.least));
    f.variation[to] = static_cast<float>(fit.trace > 0 ? fit.least / fit.trace : 0);
    f.plane_distance[to] = static_cast<float>(std::abs(dot(m, fit.normal)));
    f.valid[to] = static_cast<int>(around.size()) >= kMinBins && fit.trace > kMinTrace;
  }

  /// Frame n is the frame of row_of(n).
  template <class RowOf>
  Frames frames(std::size_t count, const Context& context, RowOf row_of) const {
    Frames f;
    f.resize(count);
    for_each_range(context, count, kGrain, [&](std::size_t begin, std::size_t end) {
      BinIndex::Reader reader(cloud.index);
      std::vector<BinIndex::Reader::Neighbour> around;
      for (std::size_t n = begin; n < end; ++n) {
        around.clear();
        reader.window(cloud.bins[row_of(n)], radius, around);
        frame_of(row_of(n), around, f, n);
      }
    });
    f.median_residual = median_residual_of(f);
    return f;
  }
};

}  // namespace

void Frames::resize(std::size_t count) {
  centroid.resize(count);
  normal.resize(count);
  residual.resize(count);
  variation.resize(count);
  plane_distance.resize(count);
  valid.resize(count);
  sign_known.resize(count);
}

double median_residual_of(const Frames& f) {
  std::vector<float> residuals;
  for (std::size_t row = 0; row < f.valid.size(); ++row)
    if (f.valid[row]) residuals.push_back(f.residual[row]);
  if (residuals.empty()) return 0;
  auto middle = residuals.begin() + static_cast<std::ptrdiff_t>(residuals.size() / 2);
  std::nth_element(residuals.begin(), middle, residuals.end());
  return *middle;
}

Frames frames_of(const ReducedCloud& cloud, const BinCells& cells, int radius, const Context& context) {
  return Windows{cloud, cells, radius}.frames(cloud.size(), context, [](std::size_t n) { return n; });
}

double noise_of(const ReducedCloud& cloud, const BinCells& cells, const Context& context) {
  const std::uint64_t every = cloud.size() / kNoiseSample + 1;
  std::vector<std::size_t> rows;
  for (std::size_t row = 0; row < cloud.size(); ++row)
    if (every == 1 || is_sampled(cloud.key(row), every)) rows.push_back(row);
  auto median = [&](int radius) {
    return Windows{cloud, cells, radius}
        .frames(rows.size(), context, [&](std::size_t n) { return rows[n]; })
        .median_residual;
  };
  const double narrow = median(1), wide = median(2);
  const double square = (kCurvatureGrowth * narrow * narrow - wide * wide) / (kCurvatureGrowth - 1);
  return square > 0 ? std::sqrt(square) : 0;
}

}  // namespace scanmill::reduce
