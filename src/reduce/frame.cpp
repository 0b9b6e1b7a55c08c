// SPDX-License-Identifier: Apache-2.0
// Local planes from exact moments (docs/algorithm.md, "Frame"). The moments are integers, the sums over the window run
// in a fixed order, so a frame is the same whichever thread or brick computes it.
#include "reduce/frame.hpp"

#include <algorithm>
#include <array>

#include "base/digest.hpp"
#include "base/large_pages.hpp"
#include "base/wide.hpp"
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

using Four = double __attribute__((vector_size(32)));
using FourAnywhere = double __attribute__((vector_size(32), aligned(8), may_alias));
using Lanes = long long __attribute__((vector_size(32)));

/// Of a bin of a window: its weight, and how its moments move to the middle of the window. Lanes belong together.
struct Step {
  double weight[4];
  double here[4];              // centre of the bin, i j k, lengths in h/1024; 0
  double first[4], second[4];  // j k k 0 and i j i 0
};

/// One per bin of a window, k running fastest.
std::vector<Step> steps_of(int radius) {
  const double* weight = kWeights[radius - 1];
  std::vector<Step> steps;
  for (int di = -radius; di <= radius; ++di)
    for (int dj = -radius; dj <= radius; ++dj)
      for (int dk = -radius; dk <= radius; ++dk) {
        const double w = weight[std::abs(di)] * weight[std::abs(dj)] * weight[std::abs(dk)];
        const double i = kSteps * di, j = kSteps * dj, k = kSteps * dk;
        steps.push_back(Step{{w, w, w, w}, {i, j, k, 0}, {j, k, k, 0}, {i, j, i, 0}});
      }
  return steps;
}

/// A bin of a window.
struct Near {
  const double* sums;  // xx yy zz n xy yz xz z x y
  const Step* step;
  std::int32_t row;
};

/// The weighted moments of a window about the centre of its middle bin, lengths in h/1024.
struct Sums {
  double squares[4], mixed[4], plain[4];  // xx yy zz weight; xy yz xz -; x y z -
};

/// Moving a bin's moments by whole bins is exact; only the weights round.
SCANMILL_WIDE void add_up(const Near* near, std::size_t count, Sums* sums) {
  Four squares{}, mixed{}, plain{};
  for (std::size_t n = 0; n < count; ++n) {
    const double* m = near[n].sums;
    const FourAnywhere* step = reinterpret_cast<const FourAnywhere*>(near[n].step);
    const Four weight = step[0], here = step[1], first = step[2], second = step[3];
    const Four square = *reinterpret_cast<const FourAnywhere*>(m), mix = *reinterpret_cast<const FourAnywhere*>(m + 4),
               rest = *reinterpret_cast<const FourAnywhere*>(m + 6);  // xz z x y
    const Four points = {m[3], m[3], m[3], m[3]};
    const Four from = __builtin_shuffle(rest, Lanes{2, 3, 1, 1}), to = from + points * here;
    squares += weight * (square + here * (from + to));
    mixed += weight * (mix + __builtin_shuffle(from, Lanes{0, 1, 0, 3}) * first +
                       __builtin_shuffle(to, Lanes{1, 2, 2, 3}) * second);
    plain += weight * to;
  }
  FourAnywhere* out = reinterpret_cast<FourAnywhere*>(sums);
  out[0] = squares;
  out[1] = mixed;
  out[2] = plain;
}

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
  std::vector<Step> steps = steps_of(radius);

  /// Appends the bins around one, asking the memory for their sums.
  void look_around(std::size_t row, BinIndex::Reader& reader, std::vector<BinIndex::Reader::Neighbour>& around,
                   std::vector<Near>& near) const {
    around.clear();
    reader.window(cloud.bins[row], radius, around);
    const int side = 2 * radius + 1;
    for (const auto& bin : around) {
      const double* sums = &cells[static_cast<std::size_t>(bin.row)].sums.xx;
      __builtin_prefetch(sums);
      __builtin_prefetch(sums + sizeof(WholeSums) / sizeof(double) - 1);
      const int step = ((bin.di + radius) * side + bin.dj + radius) * side + bin.dk + radius;
      near.push_back({sums, &steps[static_cast<std::size_t>(step)], bin.row});
    }
  }

  /// Frame `to` is the frame of `row`.
  void frame_of(std::size_t row, std::span<const Near> around, Frames& f, std::size_t to) const {
    Sums s;
    add_up(around.data(), around.size(), &s);
    Vec3 direction;
    if (cells.directions.size() > 0)
      for (const Near& near : around)
        direction += vector_of(cells.direction(static_cast<std::size_t>(near.row))) * near.step->weight[0];
    const double inverse = 1 / s.squares[3];
    const Vec3 m = Vec3{s.plain[0] * inverse, s.plain[1] * inverse, s.plain[2] * inverse} * kUnit;
    const double square = kUnit * kUnit * inverse;
    const PlaneFit fit = fit_plane({s.squares[0] * square - m.x * m.x, s.mixed[0] * square - m.x * m.y,
                                    s.mixed[2] * square - m.x * m.z, s.squares[1] * square - m.y * m.y,
                                    s.mixed[1] * square - m.y * m.z, s.squares[2] * square - m.z * m.z});
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
    constexpr std::size_t kAtOnce = 16;  // bins looked at before the first of them is worked on
    Frames f;
    f.resize(count);
    for_each_range(context, count, kGrain, [&](std::size_t begin, std::size_t end) {
      BinIndex::Reader reader(cloud.index);
      std::vector<BinIndex::Reader::Neighbour> around;
      std::vector<Near> near;
      std::array<std::size_t, kAtOnce + 1> ends{};
      for (std::size_t first = begin; first < end; first += kAtOnce) {
        const std::size_t last = std::min(first + kAtOnce, end);
        near.clear();
        for (std::size_t n = first; n < last; ++n) {
          look_around(row_of(n), reader, around, near);
          ends[n - first + 1] = near.size();
        }
        for (std::size_t n = first; n < last; ++n)
          frame_of(row_of(n), std::span(near).subspan(ends[n - first], ends[n - first + 1] - ends[n - first]), f, n);
      }
    });
    f.median_residual = median_residual_of(f);
    return f;
  }
};

}  // namespace

void Frames::resize(std::size_t count) {
  resize_large(centroid, count);
  resize_large(normal, count);
  resize_large(residual, count);
  resize_large(variation, count);
  resize_large(plane_distance, count);
  resize_large(valid, count);
  resize_large(sign_known, count);
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
