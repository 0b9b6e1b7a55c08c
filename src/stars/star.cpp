// SPDX-License-Identifier: Apache-2.0
// Every kept point finds its own star among the kept points of the 5x5x5 bins: neighbours are mapped to its tangent
// plane at their true distance and the Delaunay star is walked from neighbour to neighbour by the smallest circumcentre
// parameter. Co-circular points (exact grids) are told apart by tiny weights hashed from bin keys, the same for every
// star: a regular triangulation, so all stars break a tie alike.
#include "stars/star.hpp"

#include <algorithm>

#include "base/digest.hpp"
#include "stars/tangent.hpp"

namespace scanmill::stars {
namespace {

constexpr std::size_t kGrain = 1024;
constexpr double kCircumradius = 0.64;  // of g1: a wider empty circle is a gap (1.6 h at g1 2.5)
constexpr double kWeight = 1e-3;        // of h^2: small against any real difference, large against rounding

double tie_weight(const SurfacePoints& points, std::size_t row) {
  const LocalBin& bin = points.bins[row];
  const std::uint64_t key = mix64(static_cast<std::uint64_t>(points.base.i + bin[0]) ^
                                  mix64(static_cast<std::uint64_t>(points.base.j + bin[1]) ^
                                        mix64(static_cast<std::uint64_t>(points.base.k + bin[2]))));
  return kWeight * static_cast<double>(key >> 40) * 0x1p-24;
}

class StarBuilder {
 public:
  StarBuilder(const SurfacePoints& points, const std::vector<double>& weights, const Params& params)
      : points_(points), weights_(weights), reader_(*points.index), range2_(params.range_bins * params.range_bins) {
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
  /// Kept points of the window, unless they are the row itself.
  void list_near(std::size_t row) {
    around_.clear();
    reader_.window(points_.bins[row], 2, around_);
    const bool own_sure = points_.sign_known[row] != 0;
    int n = 0;
    for (const std::int32_t other : around_) {  // no branch: which points are kept is anybody's guess
      near_.row[n] = static_cast<std::uint32_t>(other);
      n += static_cast<int>(points_.kept[static_cast<std::size_t>(other)] != 0) &
           static_cast<int>(static_cast<std::size_t>(other) != row);
    }
    for (int k = 0; k < n; ++k) {
      const std::uint32_t other = near_.row[k];
      const Vec3 &p = points_.projected[other], &normal = points_.normal[other];
      near_.x[k] = p.x, near_.y[k] = p.y, near_.z[k] = p.z;
      near_.nx[k] = normal.x, near_.ny[k] = normal.y, near_.nz[k] = normal.z;
      near_.sure[k] = own_sure && points_.sign_known[other] ? 1 : 0;
      near_.weight[k] = weights_[other];
    }
    near_.size = n;
  }

  void gather(std::size_t row) {
    list_near(row);
    const Vec3 n = points_.normal[row], measured = points_.measured[row], e1 = perpendicular(n);
    look(near_, {points_.projected[row], n, e1, cross(n, e1), 1 / points_.edge_mm, range2_, weights_[row]}, seen_);
    const double limit2 = range2_ * points_.edge_mm * points_.edge_mm;
    tangent_.size = 0;
    for (int k = 0; k < near_.size; ++k) {
      const bool belongs = seen_.belongs[k] > 0, far = norm2(points_.measured[near_.row[k]] - measured) > limit2;
      const int at = tangent_.size;
      tangent_.x[at] = seen_.x[k];
      tangent_.y[at] = seen_.y[k];
      tangent_.power[at] = seen_.power[k];
      tangent_.row[at] = near_.row[k];
      tangent_.size += static_cast<int>(belongs) & static_cast<int>(!far);
      refused_range += static_cast<unsigned>(belongs) & static_cast<unsigned>(far);
    }
    tangent_.pad();
  }

  void walk(Star& star) {
    int start = 0;
    for (int k = 1; k < tangent_.size; ++k)
      if (tangent_.power[k] < tangent_.power[start]) start = k;
    int left[Star::kMax], right[Star::kMax], lefts = 0, rights = 0;
    bool met[kMostNear] = {}, closed = false;
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
  const std::vector<double>& weights_;  // per row
  BinIndex::Reader reader_;
  double range2_, radius2_;
  Near near_{};
  Seen seen_{};
  Tangent tangent_{};
  std::vector<std::int32_t> around_;
};

}  // namespace

std::vector<Star> stars_of(const SurfacePoints& points, std::span<const Role> roles, const Params& params,
                           RefusalCounts& refused, const Context& context) {
  const std::size_t n = points.bins.size();
  std::vector<Star> stars(n);
  std::vector<std::uint64_t> refused_by_piece((n + kGrain - 1) / kGrain, 0);
  std::vector<double> weights(n);
  for_each_range(context, n, kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row < end; ++row) weights[row] = tie_weight(points, row);
  });
  for_each_piece(context, n, kGrain, [&](std::size_t begin, std::size_t end, std::size_t piece, int) {
    StarBuilder builder(points, weights, params);
    for (std::size_t row = begin; row < end; ++row) {
      const Role role = roles.empty() ? Role::Own : roles[row];
      if (!points.kept[row] || role == Role::Around) continue;
      const std::uint64_t before = builder.refused_range;
      builder.build(row, stars[row]);
      if (role == Role::Own) refused_by_piece[piece] += builder.refused_range - before;
    }
  });
  for (const std::uint64_t count : refused_by_piece) refused.range += count;
  return stars;
}

}  // namespace scanmill::stars
