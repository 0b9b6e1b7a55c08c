// SPDX-License-Identifier: Apache-2.0
#include "grow/runs.hpp"

namespace scanmill::grow {
namespace {

using Sites = std::vector<std::uint32_t>;  // ascending, so that the first of equally near ones comes first

class Nearest {
 public:
  Nearest(std::span<const Vec3> points, std::span<const Vec3> sites, std::vector<std::uint32_t>& out)
      : points_(points), sites_(sites), runs_(points), out_(out), left_(runs_.top() + 1) {}

  void run() {
    Sites all(sites_.size());
    for (std::uint32_t s = 0; s < all.size(); ++s) all[s] = s;
    label(runs_.top(), 0, all);
  }

 private:
  /// `from`: the sites that may be nearest to some point of the node above.
  void label(std::size_t level, std::size_t node, const Sites& from) {
    Sites& left = left_[level];
    left.clear();
    const Bounds& box = runs_.box(level, node);
    double enough = 1e300;  // some site is as near as this to every point of the box
    for (const std::uint32_t s : from) enough = std::min(enough, reach_of(box, sites_[s]).greatest * kSlack);
    for (const std::uint32_t s : from)
      if (reach_of(box, sites_[s]).least <= enough * kSlack) left.push_back(s);
    for (std::size_t n = runs_.first(node); n < runs_.end(level, node); ++n) {
      if (level > 0)
        label(level - 1, n, left);
      else
        out_[n] = nearest_of(points_[n], left);
    }
  }
  std::uint32_t nearest_of(Vec3 at, const Sites& among) const {
    if (among.size() == 1) return among.front();
    double best = 1e300;
    std::uint32_t nearest = among.front();
    for (const std::uint32_t s : among) {
      const double d = norm2(at - sites_[s]);
      if (d < best) {
        best = d;
        nearest = s;
      }
    }
    return nearest;
  }

  std::span<const Vec3> points_, sites_;
  const Runs runs_;
  std::vector<std::uint32_t>& out_;
  std::vector<Sites> left_;  // per level
};

void search(const Runs& runs, std::span<const Vec3> points, Vec3 at, std::size_t level, std::size_t node, double& best,
            std::uint32_t& nearest) {
  if (reach_of(runs.box(level, node), at).least > best * kSlack) return;
  for (std::size_t n = runs.first(node); n < runs.end(level, node); ++n) {
    if (level > 0) {
      search(runs, points, at, level - 1, n, best, nearest);
      continue;
    }
    const double d = norm2(points[n] - at);
    if (d < best) {
      best = d;
      nearest = static_cast<std::uint32_t>(n);
    }
  }
}

void shadow(const Runs& runs, std::span<const Vec3> points, Vec3 at, double spacing2, std::size_t level,
            std::size_t node, std::vector<std::uint8_t>& shadowed) {
  if (reach_of(runs.box(level, node), at).least > spacing2 * kSlack) return;
  for (std::size_t n = runs.first(node); n < runs.end(level, node); ++n) {
    if (level > 0)
      shadow(runs, points, at, spacing2, level - 1, n, shadowed);
    else if (norm2(at - points[n]) < spacing2)
      shadowed[n] = 1;
  }
}

}  // namespace

std::vector<std::uint32_t> nearest_sites(std::span<const Vec3> points, std::span<const Vec3> sites) {
  std::vector<std::uint32_t> nearest(points.size());
  if (!points.empty() && !sites.empty()) Nearest(points, sites, nearest).run();
  return nearest;
}

std::uint32_t nearest_point(const Runs& runs, std::span<const Vec3> points, Vec3 at) {
  double best = 1e300;
  std::uint32_t nearest = kNoPoint;
  if (!runs.empty()) search(runs, points, at, runs.top(), 0, best, nearest);
  return nearest;
}

std::vector<std::uint32_t> spaced_apart(std::span<const Vec3> points, std::span<const std::uint32_t> order,
                                        double spacing2) {
  const Runs runs(points);
  std::vector<std::uint8_t> shadowed(points.size(), 0);
  std::vector<std::uint32_t> taken;
  for (const std::uint32_t k : order) {
    if (shadowed[k]) continue;
    taken.push_back(k);
    shadow(runs, points, points[k], spacing2, runs.top(), 0, shadowed);
  }
  return taken;
}

}  // namespace scanmill::grow
