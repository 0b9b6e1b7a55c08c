// SPDX-License-Identifier: Apache-2.0
// Boxes over runs of points that stand in an order that keeps neighbours together, and boxes over those: what lies near
// is found without looking at the rest. Internal to `grow`.
#pragma once
#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "geom/vec3.hpp"

namespace scanmill::grow {

/// Least and greatest squared distance of a box's points. Rounding may be off by a few units in the last place: allow
/// for kSlack in comparisons with distances between points.
struct Reach {
  double least = 0, greatest = 0;
};
inline constexpr double kSlack = 1 + 1e-9;

inline Reach reach_of(const Bounds& box, Vec3 from) {
  Reach reach;
  auto along = [&](double at, double low, double high) {
    const double out = at < low ? low - at : at > high ? at - high : 0, far = std::max(at - low, high - at);
    reach.least += out * out;
    reach.greatest += far * far;
  };
  along(from.x, box.low.x, box.high.x);
  along(from.y, box.low.y, box.high.y);
  along(from.z, box.low.z, box.high.z);
  return reach;
}

/// Level 0: a box for every kRun points; each further level: a box for every kRun of the one before; at last one box.
class Runs {
 public:
  static constexpr std::size_t kRun = 32;

  explicit Runs(std::span<const Vec3> points) : size_(points.size()) {
    fold(points.size(), [&](Bounds& box, std::size_t n) { box.add(points[n]); });
    while (!levels_.back().empty() && levels_.back().size() > 1) {
      const std::vector<Bounds> lower = levels_.back();
      fold(lower.size(), [&](Bounds& box, std::size_t n) { box.add(lower[n]); });
    }
  }
  bool empty() const { return size_ == 0; }
  std::size_t top() const { return levels_.size() - 1; }
  const Bounds& box(std::size_t level, std::size_t node) const { return levels_[level][node]; }
  /// The nodes under one node, or the points when level is 0.
  std::size_t first(std::size_t node) const { return node * kRun; }
  std::size_t end(std::size_t level, std::size_t node) const {
    return std::min((node + 1) * kRun, level == 0 ? size_ : levels_[level - 1].size());
  }

 private:
  template <class Add>
  void fold(std::size_t count, Add add) {
    std::vector<Bounds> level((count + kRun - 1) / kRun);
    for (std::size_t n = 0; n < count; ++n) add(level[n / kRun], n);
    levels_.push_back(std::move(level));
  }

  std::size_t size_;
  std::vector<std::vector<Bounds>> levels_;
};

/// nearest[n]: the place in `sites` of the one nearest to points[n], the first of equally near ones; the same as asking
/// every pair (squared distances below 1e300), at a cost that hardly depends on the number of sites.
std::vector<std::uint32_t> nearest_sites(std::span<const Vec3> points, std::span<const Vec3> sites);

/// The first of the points nearest to `at`; kNoPoint when none has a squared distance below 1e300.
inline constexpr std::uint32_t kNoPoint = 0xffffffffu;
std::uint32_t nearest_point(const Runs& runs, std::span<const Vec3> points, Vec3 at);

/// Takes points one after another as `order` lists them, leaving out those with a squared distance below spacing2 to
/// one taken before. Returns the taken.
std::vector<std::uint32_t> spaced_apart(std::span<const Vec3> points, std::span<const std::uint32_t> order,
                                        double spacing2);

}  // namespace scanmill::grow
