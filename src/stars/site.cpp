// SPDX-License-Identifier: Apache-2.0
#include "stars/site.hpp"

#include <algorithm>
#include <cmath>

namespace scanmill::stars {

double pseudo_angle(double x, double y) {
  const double sum = std::abs(x) + std::abs(y);
  if (sum == 0) return 0;
  const double p = y / sum;  // -1..1, growing with the angle on the right half
  if (x >= 0) return p >= 0 ? p : 4 + p;
  return 2 - p;
}

Site::Site(const SurfacePoints& surface, const Params& params, std::vector<Vec3> normals)
    : complex(surface.kept),
      normal(std::move(normals)),
      points(surface),
      range2_(params.range_bins * params.range_bins * surface.edge_mm * surface.edge_mm),
      cos_min_angle_(cos_of_degrees(params.min_angle_deg)),
      // Farthest a point of a triangle with edges <= g1 can be from its nearest corner: g1 / sqrt(3).
      reach_(params.range_bins * surface.edge_mm * 0.57736),
      front_radius_(static_cast<int>(std::ceil(params.range_bins))),
      reader_(*surface.index) {}

std::span<const std::uint32_t> Site::in_range_of(std::uint32_t v) const {
  if (range_begin_.empty()) range_begin_.assign(points.bins.size(), kNone);
  if (range_begin_[v] == kNone) {
    rows_.clear();
    around(v, front_radius_, rows_);
    range_begin_[v] = static_cast<std::uint32_t>(range_rows_.size());
    range_rows_.push_back(0);
    for (const std::int32_t row : rows_)
      if (const auto w = static_cast<std::uint32_t>(row); w != v && in_range(v, w)) range_rows_.push_back(w);
    const auto first = range_rows_.begin() + range_begin_[v] + 1;
    std::sort(first, range_rows_.end());
    range_rows_[range_begin_[v]] = static_cast<std::uint32_t>(range_rows_.end() - first);
  }
  return {range_rows_.data() + range_begin_[v] + 1, range_rows_[range_begin_[v]]};
}

Vec3 Site::normal_of(const Triangle& t) const {
  return unit(cross(measured(t[1]) - measured(t[0]), measured(t[2]) - measured(t[0])));
}

bool Site::within_limits(const Triangle& t) const {
  return in_range(t[0], t[1]) && in_range(t[1], t[2]) && in_range(t[2], t[0]) &&
         angles_at_least(measured(t[0]), measured(t[1]), measured(t[2]), cos_min_angle_);
}

namespace {
/// Directions around a vertex, on projected positions, about its normal.
struct Compass {
  Vec3 origin, e1, e2;
  Compass(Vec3 at, Vec3 n) : origin(at) {
    e1 = perpendicular(n);
    e2 = cross(n, e1);
  }
  double operator()(Vec3 p) const { return pseudo_angle(dot(p - origin, e1), dot(p - origin, e2)); }
};
}  // namespace

double Site::angle_at(std::uint32_t v, std::uint32_t a) const { return Compass(projected(v), normal[v])(projected(a)); }

bool Site::sector_free(std::uint32_t v, std::uint32_t a, std::uint32_t b) const {
  const Compass compass(projected(v), normal[v]);
  const double from = compass(projected(a)), to = compass(projected(b)), width = turn(from, to);
  if (width >= 2 - 1e-9) return false;  // half a turn or more
  for (const std::uint32_t k : complex.fan(v)) {
    std::uint32_t x, y;
    complex.after(k, v, x, y);
    if (x == a || y == b) return false;
    const double begin = compass(projected(x)), end = compass(projected(y)), other = turn(begin, end);
    if (x != b && turn(from, begin) < width) return false;
    if (y != a && turn(from, end) < width) return false;
    if (y != a && turn(begin, from) < other) return false;
    if (x != b && turn(begin, to) < other) return false;
  }
  return true;
}

bool Site::fold_free(const Triangle& t, double least) const {
  const Vec3 n = normal_of(t);
  for (std::size_t e = 0; e < 3; ++e) {
    const std::uint32_t k = complex.half(t[(e + 1) % 3], t[e]);
    if (k != kNone && dot(n, normal_of(complex.triangle(k))) < least) return false;
  }
  return true;
}

void Site::rows_in_reach(const Triangle& t) const {
  // A triangle that meets t has a corner within reach_ of a point of t: look up the bins of t's box widened by reach_.
  LocalBin low = points.bins[t[0]], high = low;
  Bounds box;
  for (const std::uint32_t v : t) box.add(measured(v));
  for (std::size_t k = 0; k < 3; ++k)
    for (const std::uint32_t v : t) {
      low[k] = std::min(low[k], points.bins[v][k]);
      high[k] = std::max(high[k], points.bins[v][k]);
    }
  const int widen = static_cast<int>(reach_ / points.edge_mm) + 1;
  for (std::size_t k = 0; k < 3; ++k) {
    low[k] -= widen;
    high[k] += widen;
  }
  rows_.clear();
  reader_.box(low, high, rows_);
  std::size_t near = 0;
  for (const std::int32_t row : rows_) {
    const Vec3 p = measured(static_cast<std::uint32_t>(row));
    const bool within = p.x >= box.low.x - reach_ && p.x <= box.high.x + reach_ && p.y >= box.low.y - reach_ &&
                        p.y <= box.high.y + reach_ && p.z >= box.low.z - reach_ && p.z <= box.high.z + reach_;
    if (within) rows_[near++] = row;
  }
  rows_.resize(near);
}

namespace {
bool boxes_meet(const Corners& s, const Corners& t) {
  auto apart = [](double a, double b, double c, double d, double e, double f) {
    return std::max({a, b, c}) < std::min({d, e, f}) || std::max({d, e, f}) < std::min({a, b, c});
  };
  return !apart(s.at[0].x, s.at[1].x, s.at[2].x, t.at[0].x, t.at[1].x, t.at[2].x) &&
         !apart(s.at[0].y, s.at[1].y, s.at[2].y, t.at[0].y, t.at[1].y, t.at[2].y) &&
         !apart(s.at[0].z, s.at[1].z, s.at[2].z, t.at[0].z, t.at[1].z, t.at[2].z);
}
}  // namespace

std::uint32_t Site::crossing_of(const Triangle& t) const {
  rows_in_reach(t);
  seen_.resize(complex.triangle_count(), 0);
  ++query_;
  const Corners mine = corners(t);
  for (const std::int32_t row : rows_)
    for (const std::uint32_t k : complex.fan(static_cast<std::uint32_t>(row))) {
      if (seen_[k] == query_) continue;
      seen_[k] = query_;
      const Corners other = corners(complex.triangle(k));
      if (boxes_meet(mine, other) && triangles_cross(mine, other)) return k;
    }
  return kNone;
}

}  // namespace scanmill::stars
