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
constexpr double kUnit = 1.0 / 1024;
constexpr double kWeights[2][3] = {{1.0, 0.60653065971263342, 0},                     // exp(-d^2/2), radius 1
                                   {1.0, 0.80073740291680806, 0.41111229050718745}};  // exp(-d^2/4.5), radius 2
// Variance of position under the weights, a bin's own 1/12 included: 0.631 and 1.512 h^2. A curved surface's residual
// grows with its square.
constexpr double kCurvatureGrowth = 5.74;
constexpr std::size_t kNoiseSample = 4096;  // bins, about
constexpr int kMinBins = 4;
constexpr double kMinTrace = 0.05;
constexpr double kSignCosine = 0.25;  // a view this flat to the surface says nothing about its side

/// The weighted moments of a window about the centre of its middle bin. Moving a bin's moments by whole bins is exact;
/// only the weights round.
struct Sums {
  double weight = 0, x = 0, y = 0, z = 0, xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;

  void add(const BinSums& m, double w, double i, double j, double k) {
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

/// What is fixed per cloud, for one frame after the other.
struct Windows {
  const ReducedCloud& cloud;
  const std::vector<BinSums>& sums;
  int radius;

  void frame_of(std::size_t row, std::span<const BinIndex::Reader::Neighbour> around, Frames& f) const {
    const double* weight = kWeights[radius - 1];
    Sums s;
    Vec3 direction;
    for (const auto& near : around) {
      const auto other = static_cast<std::size_t>(near.row);
      const double w = weight[std::abs(near.di)] * weight[std::abs(near.dj)] * weight[std::abs(near.dk)];
      s.add(sums[other], w, near.di, near.dj, near.dk);
      direction += sums[other].direction * w;
    }
    const double inverse = 1 / s.weight;
    const Vec3 m{s.x * inverse, s.y * inverse, s.z * inverse};
    const PlaneFit fit =
        fit_plane({s.xx * inverse - m.x * m.x, s.xy * inverse - m.x * m.y, s.xz * inverse - m.x * m.z,
                   s.yy * inverse - m.y * m.y, s.yz * inverse - m.y * m.z, s.zz * inverse - m.z * m.z});
    const double length = norm(direction), cosine = length > 0 ? dot(fit.normal, direction) / length : 0;
    f.centroid[row] = centre_of(cloud.lattice, cloud.key(row)) + m * cloud.lattice.edge_mm;
    f.normal[row] = cosine < 0 ? -fit.normal : fit.normal;
    f.sign_known[row] = std::abs(cosine) > kSignCosine;
    f.residual[row] = static_cast<float>(std::sqrt(fit.least));
    f.variation[row] = static_cast<float>(fit.trace > 0 ? fit.least / fit.trace : 0);
    f.plane_distance[row] = static_cast<float>(std::abs(dot(m, fit.normal)));
    f.valid[row] = static_cast<int>(around.size()) >= kMinBins && fit.trace > kMinTrace;
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

std::vector<BinSums> in_bin_edges(const std::vector<Moments>& moments, const Context& context) {
  constexpr double kSquare = kUnit * kUnit;
  std::vector<BinSums> sums(moments.size());
  auto scaled = [](std::int64_t sum, double unit) { return static_cast<double>(sum) * unit; };
  for_each_range(context, moments.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row < end; ++row) {
      const Moments& m = moments[row];
      sums[row] = {scaled(m.count, 1),
                   scaled(m.sum[0], kUnit),
                   scaled(m.sum[1], kUnit),
                   scaled(m.sum[2], kUnit),
                   scaled(m.product[0], kSquare),
                   scaled(m.product[1], kSquare),
                   scaled(m.product[2], kSquare),
                   scaled(m.product[3], kSquare),
                   scaled(m.product[4], kSquare),
                   scaled(m.product[5], kSquare),
                   {scaled(m.view_direction[0], 1), scaled(m.view_direction[1], 1), scaled(m.view_direction[2], 1)}};
    }
  });
  return sums;
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

Frames frames_of(const ReducedCloud& cloud, const std::vector<BinSums>& moments, int radius, std::uint64_t every,
                 const Context& context) {
  const std::size_t n = cloud.size();
  Frames f;
  f.resize(n);
  const Windows windows{cloud, moments, radius};
  for_each_range(context, n, kGrain, [&](std::size_t begin, std::size_t end) {
    BinIndex::Reader reader(cloud.index);
    std::vector<BinIndex::Reader::Neighbour> around;
    for (std::size_t row = begin; row < end; ++row) {
      if (every > 1 && !is_sampled(cloud.key(row), every)) continue;
      around.clear();
      reader.window(cloud.bins[row], radius, around);
      windows.frame_of(row, around, f);
    }
  });
  f.median_residual = median_residual_of(f);
  return f;
}

double noise_of(const ReducedCloud& cloud, const std::vector<BinSums>& moments, const Context& context) {
  const std::uint64_t every = cloud.size() / kNoiseSample + 1;
  const double narrow = frames_of(cloud, moments, 1, every, context).median_residual;
  const double wide = frames_of(cloud, moments, 2, every, context).median_residual;
  const double square = (kCurvatureGrowth * narrow * narrow - wide * wide) / (kCurvatureGrowth - 1);
  return square > 0 ? std::sqrt(square) : 0;
}

}  // namespace scanmill::reduce
