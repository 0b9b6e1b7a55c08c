// SPDX-License-Identifier: Apache-2.0
// Every kept point finds its own star among the kept points of the 5x5x5 bins: neighbours are mapped to its tangent
// plane at their true distance and the Delaunay star is walked from neighbour to neighbour by the smallest circumcentre
// parameter. Co-circular points (exact grids) are told apart by tiny weights hashed from bin keys, the same for every
// star: a regular triangulation, so all stars break a tie alike.
#include "stars/star.hpp"

#include <algorithm>

#include "base/digest.hpp"

namespace scanmill::stars {
namespace {

constexpr std::size_t kGrain = 1024;
constexpr double kSheet = 0.8;          // greatest |offset from the tangent plane| / distance of a neighbour
constexpr double kNormalDot = 0.3;      // least |n.n'| of a neighbour (n.n' where both signs are known: thin walls)
constexpr double kCircumradius = 0.64;  // of g1: a wider empty circle is a gap (1.6 h at g1 2.5)
constexpr double kWeight = 1e-3;        // of h^2: small against any real difference, large against rounding

double tie_weight(const SurfacePoints& points, std::size_t row) {
  const LocalBin& bin = points.bins[row];
  const std::uint64_t key = mix64(static_cast<std::uint64_t>(points.base.i + bin[0]) ^
                                  mix64(static_cast<std::uint64_t>(points.base.j + bin[1]) ^
                                        mix64(static_cast<std::uint64_t>(points.base.k + bin[2]))));
  return kWeight * static_cast<double>(key >> 40) * 0x1p-24;
}

/// Neighbours on the tangent plane; x, y in bin edges, power = squared distance less the difference of weights.
struct Tangent {
  static constexpr int kMax = 124;
  double x[kMax], y[kMax], power[kMax];
  std::uint32_t row[kMax];
  int size = 0;

  /// Next neighbour of the star after `a`, turning left (sign 1) or right (-1); -1 at a gap.
  int next(int a, double sign, double radius2) const {
    const double aa = x[a] * x[a] + y[a] * y[a], f = power[a] / (2 * aa);
    double best = 1e300;
    int found = -1;
    for (int b = 0; b < size; ++b) {
      const double turn = sign * (x[a] * y[b] - y[a] * x[b]);
      if (turn <= 1e-9 * aa) continue;
      const double t = (power[b] / 2 - f * (x[a] * x[b] + y[a] * y[b])) / turn;
      if (t < best) {
        best = t;
        found = b;
      }
    }
    return found >= 0 && (f * f + best * best) * aa > radius2 ? -1 : found;
  }
};

class StarBuilder {
 public:
  StarBuilder(const SurfacePoints& points, const Params& params)
      : points_(points), reader_(*points.index), range2_(params.range_bins * params.range_bins) {
    radius2_ = kCircumradius * kCircumradius * range2_;
  }
  std::uint64_t refused_range = 0;

  void build(std::size_t row, Star& star) {
    gather(row);
    star.size = 0;
    star.gaps = 0;
    if (tangent_.size < 2) return;
    walk(star);
    for (int k = 0; k < star.size; ++k) {
      const auto a = star.vertex[static_cast<std::size_t>(k)];
      const auto b = star.vertex[static_cast<std::size_t>(k + 1 < star.size ? k + 1 : 0)];
      if (star.gap(k)) continue;
      const bool too_long =
          a != b && norm2(points_.measured[a] - points_.measured[b]) > range2_ * points_.edge_mm * points_.edge_mm;
      refused_range += too_long;
      if (a == b || too_long) star.gaps |= 1u << k;
    }
    if (star.size == 2) star.gaps |= 2;
  }

 private:
  void gather(std::size_t row) {
    const Vec3 n = points_.normal[row], at = points_.projected[row], measured = points_.measured[row];
    const Vec3 e1 = perpendicular(n), e2 = cross(n, e1);
    const double scale = 1 / points_.edge_mm, own = tie_weight(points_, row);
    const double limit2 = range2_ * points_.edge_mm * points_.edge_mm;
    tangent_.size = 0;
    around_.clear();
    reader_.window(points_.bins[row], 2, around_);
    for (const std::int32_t near : around_) {
      const auto other = static_cast<std::size_t>(near);
      if (other == row || !points_.kept[other]) continue;
      const double agreement = dot(points_.normal[other], n);
      const bool sure = points_.sign_known[other] && points_.sign_known[row];
      if ((sure ? agreement : std::abs(agreement)) < kNormalDot) continue;
      const Vec3 d = (points_.projected[other] - at) * scale;
      const double d2 = norm2(d), along = dot(d, n);
      if (d2 > range2_ || d2 <= 0 || along * along > kSheet * kSheet * d2) continue;
      if (norm2(points_.measured[other] - measured) > limit2) {
        ++refused_range;
        continue;
      }
      const double x = dot(d, e1), y = dot(d, e2), stretch = std::sqrt(d2 / (x * x + y * y));
      const int k = tangent_.size++;
      tangent_.x[k] = x * stretch;
      tangent_.y[k] = y * stretch;
      tangent_.power[k] = d2 + own - tie_weight(points_, other);
      tangent_.row[k] = static_cast<std::uint32_t>(other);
    }
  }

  void walk(Star& star) {
    int start = 0;
    for (int k = 1; k < tangent_.size; ++k)
      if (tangent_.power[k] < tangent_.power[start]) start = k;
    int left[Star::kMax], right[Star::kMax], lefts = 0, rights = 0;
    bool met[Tangent::kMax] = {}, closed = false;
    left[lefts++] = start;
    met[start] = true;
    for (int at = start; lefts < Star::kMax;) {
      const int found = tangent_.next(at, 1, radius2_);
      if (found == start && lefts > 2) closed = true;
      if (found < 0 || met[found]) break;
      met[found] = true;
      left[lefts++] = at = found;
    }
    for (int at = start; !closed && lefts + rights < Star::kMax;) {
      const int found = tangent_.next(at, -1, radius2_);
      if (found < 0 || met[found]) break;
      met[found] = true;
      right[rights++] = at = found;
    }
    for (int k = rights - 1; k >= 0; --k) star.vertex[star.size++] = tangent_.row[right[k]];
    for (int k = 0; k < lefts; ++k) star.vertex[star.size++] = tangent_.row[left[k]];
    if (!closed) star.gaps |= 1u << (star.size - 1);
  }

  const SurfacePoints& points_;
  BinIndex::Reader reader_;
  double range2_, radius2_;
  Tangent tangent_;
  std::vector<std::int32_t> around_;
};

}  // namespace

std::vector<Star> stars_of(const SurfacePoints& points, const Params& params, RefusalCounts& refused,
                           const Context& context) {
  const std::size_t n = points.bins.size();
  std::vector<Star> stars(n);
  std::vector<std::uint64_t> refused_by_piece((n + kGrain - 1) / kGrain, 0);
  for_each_piece(context, n, kGrain, [&](std::size_t begin, std::size_t end, std::size_t piece, int) {
    StarBuilder builder(points, params);
    for (std::size_t row = begin; row < end; ++row)
      if (points.kept[row]) builder.build(row, stars[row]);
    refused_by_piece[piece] = builder.refused_range;
  });
  for (const std::uint64_t count : refused_by_piece) refused.range += count;
  return stars;
}

}  // namespace scanmill::stars
