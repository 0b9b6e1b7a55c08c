// SPDX-License-Identifier: Apache-2.0
#include "front/patch_growth.hpp"

#include <algorithm>
#include <array>

namespace scanmill::front {
namespace {

constexpr std::uint32_t kNone = kNoTriangle;
/// The first triangle is looked for among so many points nearest to the seed.
constexpr std::size_t kFirstCandidates = 24;
/// A sine this small is a line, whatever g2 says.
constexpr double kLeastSquaredSine = 1e-20;
/// From how clear an agreement with its surroundings a first triangle takes its orientation.
constexpr double kClearAgreement = 0.3;
/// A triangle across a seam may lean from the mean of both sides, but not turn its back on it.
constexpr double kSeamAgreement = 0;

struct Ranked {
  double distance2;
  std::uint32_t row;
  friend bool operator<(const Ranked& a, const Ranked& b) {
    return a.distance2 != b.distance2 ? a.distance2 < b.distance2 : a.row < b.row;
  }
};

}  // namespace

PatchGrowth::PatchGrowth(std::span<const Vec3> points, std::span<const Vec3> normals, const PointGrid& grid,
                         const Rules& rules, Surface& surface)
    : points_(points),
      normals_(normals),
      grid_(grid),
      rules_(rules),
      surface_(surface),
      finished_(points.size(), 0),
      in_patch_(points.size(), 0),
      next_(points.size(), kNone),
      previous_(points.size(), kNone) {}

Result<bool> PatchGrowth::grow(Vec3 seed, std::uint32_t patch, const CancelFlag& cancel) {
  patch_ = patch;
  std::vector<Ranked> ranked;
  for (std::uint32_t row = 0; row < points_.size(); ++row)
    if (!finished_[row]) ranked.push_back({norm2(points_[row] - seed), row});
  std::sort(ranked.begin(), ranked.end());
  std::vector<std::uint32_t> order;
  order.reserve(ranked.size());
  for (const Ranked& r : ranked) order.push_back(r.row);

  if (!first_triangle(order)) return false;
  bool added = true;
  for (bool first_pass = true; added && front_size_ > 0; first_pass = false) {
    added = false;
    for (const std::uint32_t p : order) {
      if (in_patch_[p] || front_size_ == 0) continue;
      if (cancel.is_set()) return fail(Code::Cancelled, "stopped while a patch was growing");
      added |= attach(p, first_pass);
    }
    if (!added) added = close_ears();
  }
  end_patch();
  return true;
}

/// The first valid triple by distance: (0,1,2), (0,1,3), (0,2,3), (1,2,3), ... At least one corner must be new, or
/// finished patches would be grown again.
bool PatchGrowth::first_triangle(const std::vector<std::uint32_t>& order) {
  const std::size_t count = std::min(order.size(), kFirstCandidates);
  for (std::size_t k = 2; k < count; ++k)
    for (std::size_t j = 1; j < k; ++j)
      for (std::size_t i = 0; i < j; ++i) {
        Triangle corners{order[i], order[j], order[k]};
        const bool fresh =
            std::any_of(corners.begin(), corners.end(), [&](auto v) { return surface_.around(v).empty(); });
        if (!fresh || !within_limits(corners, surface_.make_facet(corners), {}, Count::No) || !orient(corners))
          continue;
        if (!try_triangle(corners, {}, Count::No)) continue;
        link(corners[0], corners[1]);
        link(corners[1], corners[2]);
        link(corners[2], corners[0]);
        front_size_ = 3;
        for (const std::uint32_t v : corners) in_patch_[v] = 1;
        return true;
      }
  return false;
}

/// Turns a first triangle as the patches around it are turned, else as the point normals say.
bool PatchGrowth::orient(Triangle& corners) const {
  const Facet facet = surface_.make_facet(corners);
  double agreement = 0;
  std::uint64_t seen = 0;
  grid_.each_within(facet.corners[0], rules_.range_mm, [&](std::uint32_t row) {
    for (const std::uint32_t t : surface_.around(row)) {
      agreement += dot(surface_.facet(t).normal, facet.normal);
      ++seen;
    }
  });
  if (seen > 0) agreement /= static_cast<double>(seen);
  if (std::abs(agreement) < kClearAgreement && !normals_.empty()) {
    agreement = 0;
    for (const std::uint32_t v : corners) agreement += dot(normals_[v], facet.normal);
  }
  if (agreement < 0) std::swap(corners[1], corners[2]);
  return surface_.has_room(corners);
}

std::uint32_t PatchGrowth::nearest_on_front(std::uint32_t p) const {
  Ranked best{1e300, kNone};
  grid_.each_within(points_[p], rules_.range_mm, [&](std::uint32_t row) {
    if (next_[row] == kNone) return;
    const Ranked candidate{norm2(points_[row] - points_[p]), row};
    if (candidate < best) best = candidate;
  });
  return best.row;
}

/// Joins p to the nearest vertex of the front and its neighbour, then as far round as triangles are accepted.
bool PatchGrowth::attach(std::uint32_t p, bool first_pass) {
  const std::uint32_t b = nearest_on_front(p);
  if (b == kNone) {
    if (first_pass) ++refused_.limits.range;  // later passes would count the same gap again
    return false;
  }
  const std::array<std::pair<std::uint32_t, std::uint32_t>, 2> edges{{{b, next_[b]}, {previous_[b], b}}};
  for (const auto& [from, to] : edges) {  // forward first, then in reverse
    const std::array<std::uint32_t, 2> ends{from, to};
    if (!try_triangle({to, from, p}, at(ends), Count::Yes)) continue;
    link(from, p);
    link(p, to);
    ++front_size_;
    in_patch_[p] = 1;
    if (from == b) walk_forward(p);
    if (front_size_ > 0) walk_in_reverse(p);
    return true;
  }
  return false;
}

void PatchGrowth::walk_forward(std::uint32_t p) {
  while (front_size_ > 2) {
    const std::uint32_t from = next_[p], to = next_[from];
    const std::array<std::uint32_t, 2> ends{from, to};
    if (!try_triangle({to, from, p}, at(ends), Count::Yes)) return;
    leave_front(from);
  }
}

void PatchGrowth::walk_in_reverse(std::uint32_t p) {
  while (front_size_ > 2) {
    const std::uint32_t to = previous_[p], from = previous_[to];
    const std::array<std::uint32_t, 2> ends{from, to};
    if (!try_triangle({to, from, p}, at(ends), Count::Yes)) return;
    leave_front(to);
  }
}

/// Shortest third edge first. No point is lost to an ear that could still have been joined: passes end before.
bool PatchGrowth::close_ears() {
  std::vector<Ranked> ears;
  for (std::uint32_t v = 0; v < points_.size(); ++v)
    if (next_[v] != kNone) ears.push_back({norm2(points_[next_[v]] - points_[previous_[v]]), v});
  std::sort(ears.begin(), ears.end());
  bool closed = false;
  for (const Ranked& ear : ears) {
    const std::uint32_t v = ear.row;
    if (next_[v] == kNone || front_size_ < 3) continue;
    const std::uint32_t u = previous_[v], w = next_[v];
    if (norm2(points_[u] - points_[w]) != ear.distance2) continue;  // the front moved on
    const std::array<std::uint32_t, 3> all{u, v, w};
    if (!try_triangle({w, v, u}, at(all), Count::No)) continue;
    leave_front(v);
    closed = true;
  }
  return closed;
}

void PatchGrowth::join_patches() {
  close_seams();
  while (bridge_seams()) close_seams();
}

bool PatchGrowth::close_seams() {
  bool any = false;
  for (bool closed = true; closed; any |= closed) {
    closed = false;
    std::vector<Ranked> ears;
    std::uint32_t u = 0, w = 0;
    for (std::uint32_t v = 0; v < points_.size(); ++v)
      if (surface_.single_gap(v, u, w)) ears.push_back({norm2(points_[u] - points_[w]), v});
    std::sort(ears.begin(), ears.end());
    for (const Ranked& ear : ears) {
      const std::uint32_t v = ear.row;
      if (!surface_.single_gap(v, u, w)) continue;
      const std::array<std::uint32_t, 3> all{u, v, w};
      patch_ = surface_.patch(surface_.owner(u, v));
      const bool seam = patch_ != surface_.patch(surface_.owner(v, w));
      closed |= try_triangle({w, v, u}, seam ? across_seam(all) : at(all), Count::No);
    }
  }
  return any;
}

/// One triangle from each open edge to the nearest open vertex of another patch, edges in order of rows.
bool PatchGrowth::bridge_seams() {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (std::uint32_t t = 0; t < surface_.size(); ++t)
    for (std::size_t e = 0; e < 3; ++e) {
      const std::uint32_t u = surface_.triangle(t)[e], v = surface_.triangle(t)[(e + 1) % 3];
      if (surface_.alive(t) && surface_.owner(v, u) == kNone) edges.emplace_back(u, v);
    }
  std::sort(edges.begin(), edges.end());
  bool bridged = false;
  for (const auto& [u, v] : edges) {
    if (surface_.owner(v, u) != kNone) continue;
    patch_ = surface_.patch(surface_.owner(u, v));
    const std::uint32_t p = nearest_beyond_seam(u, v, patch_);
    if (p == kNone) continue;
    const std::array<std::uint32_t, 3> all{u, v, p};
    bridged |= try_triangle({v, u, p}, across_seam(all), Count::No);
  }
  return bridged;
}

std::uint32_t PatchGrowth::nearest_beyond_seam(std::uint32_t u, std::uint32_t v, std::uint32_t patch) const {
  Ranked best{1e300, kNone};
  grid_.each_within(points_[u], rules_.range_mm, [&](std::uint32_t row) {
    if (row == u || row == v || surface_.around(row).empty() || surface_.closed(row)) return;
    for (const std::uint32_t t : surface_.around(row))
      if (surface_.patch(t) == patch) return;
    const Ranked candidate{std::max(norm2(points_[row] - points_[u]), norm2(points_[row] - points_[v])), row};
    if (candidate < best) best = candidate;
  });
  return best.row;
}

/// Adds the triangle to the patch unless a rule refuses it.
bool PatchGrowth::try_triangle(const Triangle& corners, const Local& local, Count count) {
  const Facet facet = surface_.make_facet(corners);
  if (!within_limits(corners, facet, local, count)) return false;
  if (!surface_.has_room(corners) || overlaps_any(facet)) {
    if (count == Count::Yes) ++refused_.overlap;
    return false;
  }
  surface_.add(corners, facet, patch_);
  return true;
}

bool PatchGrowth::within_limits(const Triangle& corners, const Facet& facet, const Local& local, Count count) {
  const auto refuse = [&](std::uint64_t& counter) {
    if (count == Count::Yes) ++counter;
    return false;
  };
  const Vec3 a = points_[corners[0]], b = points_[corners[1]], c = points_[corners[2]];
  if (!within_range(a, b, c, rules_.range_mm)) return refuse(refused_.limits.range);
  const double area2 = norm2(cross(b - a, c - a));
  const bool line = !(area2 > kLeastSquaredSine * norm2(b - a) * norm2(c - a));
  if (line || !angles_at_least(a, b, c, rules_.cos_min_angle)) return refuse(refused_.limits.angle);
  if (!normals_agree(facet.normal, local.normal, local.min_dot)) return refuse(refused_.limits.normal);
  return true;
}

bool PatchGrowth::overlaps_any(const Facet& facet) {
  const Vec3 centre = (facet.corners[0] + facet.corners[1] + facet.corners[2]) * (1.0 / 3);
  ++question_;
  tested_.resize(surface_.size(), 0);
  bool found = false;
  grid_.each_within(centre, rules_.reach(), [&](std::uint32_t row) {
    if (found) return;
    for (const std::uint32_t t : surface_.around(row)) {
      if (std::exchange(tested_[t], question_) == question_) continue;
      found = found || overlap(facet, surface_.facet(t), rules_.clearance_mm, rules_.tolerance_mm);
    }
  });
  return found;
}

PatchGrowth::Local PatchGrowth::at(std::span<const std::uint32_t> vertices) const {
  return {mean_normal(vertices, patch_), rules_.min_dot};
}

PatchGrowth::Local PatchGrowth::across_seam(std::span<const std::uint32_t> vertices) const {
  return {mean_normal(vertices, {}), kSeamAgreement};
}

/// Mean of the normals of the patch's (or all) triangles that touch the vertices; each counts once.
Vec3 PatchGrowth::mean_normal(std::span<const std::uint32_t> vertices, std::optional<std::uint32_t> patch) const {
  Vec3 sum;
  for (std::size_t i = 0; i < vertices.size(); ++i)
    for (const std::uint32_t t : surface_.around(vertices[i])) {
      if (patch && surface_.patch(t) != *patch) continue;
      const Triangle& corners = surface_.triangle(t);
      const bool counted =
          std::any_of(vertices.begin(), vertices.begin() + static_cast<std::ptrdiff_t>(i),
                      [&](auto v) { return std::find(corners.begin(), corners.end(), v) != corners.end(); });
      if (!counted) sum += surface_.facet(t).normal;
    }
  return unit(sum);
}

void PatchGrowth::link(std::uint32_t a, std::uint32_t b) {
  next_[a] = b;
  previous_[b] = a;
}

void PatchGrowth::leave_front(std::uint32_t v) {
  link(previous_[v], next_[v]);
  next_[v] = previous_[v] = kNone;
  if (--front_size_ > 2) return;
  // Two vertices: the edges between them close each other, the patch has no border left.
  next_.assign(next_.size(), kNone);
  previous_.assign(previous_.size(), kNone);
  front_size_ = 0;
}

void PatchGrowth::end_patch() {
  for (std::uint32_t v = 0; v < points_.size(); ++v) {
    if (in_patch_[v] && surface_.closed(v)) finished_[v] = 1;
    in_patch_[v] = 0;
    next_[v] = previous_[v] = kNone;
  }
  front_size_ = 0;
}

}  // namespace scanmill::front
