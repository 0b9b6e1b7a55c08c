// SPDX-License-Identifier: Apache-2.0
// One patch of the paper's growth: a front that goes round once and takes one point after the other.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "base/context.hpp"
#include "base/result.hpp"
#include "front/point_grid.hpp"
#include "front/surface.hpp"
#include "mesh/limits.hpp"

namespace scanmill::front {

/// The limits in the units the tests use.
struct Rules {
  double range_mm;                                  // g1
  double cos_min_angle;                             // g2
  double min_dot;                                   // g3
  double clearance_mm;                              // layers closer than this are one surface
  double tolerance_mm;                              // rim by which projections of neighbours may overlap
  double reach() const { return 1.25 * range_mm; }  // a triangle that meets another has a corner this near its centre
};

struct Refused {
  RefusalCounts limits;
  std::uint64_t overlap = 0;
};

class PatchGrowth {
 public:
  PatchGrowth(std::span<const Vec3> points, std::span<const Vec3> normals, const PointGrid& grid, const Rules& rules,
              Surface& surface);

  /// Rows that left the set: inside a finished patch.
  bool finished(std::uint32_t row) const { return finished_[row] != 0; }

  /// Grows patch number `patch` from `seed`. False when no first triangle was found.
  Result<bool> grow(Vec3 seed, std::uint32_t patch, const CancelFlag& cancel);

  /// Joins the patches: triangles between open edges and vertices of different patches, then ears along all open edges,
  /// until nothing is added. Across a seam g3 does not hold (it is why the patches ended there); nothing folds over.
  void join_patches();
  /// Ears only; leaves a mesh without several fans at a vertex without them.
  bool close_seams();

  const Refused& refused() const { return refused_; }

 private:
  enum class Count { Yes, No };
  /// What the normal of a new triangle is held against: g3 and the patch's local normal; nothing for a first triangle.
  struct Local {
    Vec3 normal;
    double min_dot = -2;
  };
  bool first_triangle(const std::vector<std::uint32_t>& order);
  bool orient(Triangle& corners) const;
  bool attach(std::uint32_t p, bool first_pass);
  std::uint32_t nearest_on_front(std::uint32_t p) const;
  void walk_forward(std::uint32_t p);
  void walk_in_reverse(std::uint32_t p);
  bool close_ears();
  bool try_triangle(const Triangle& corners, const Local& local, Count count);
  bool within_limits(const Triangle& corners, const Facet& facet, const Local& local, Count count);
  bool overlaps_any(const Facet& facet);
  bool bridge_seams();
  std::uint32_t nearest_beyond_seam(std::uint32_t u, std::uint32_t v, std::uint32_t patch) const;
  Local at(std::span<const std::uint32_t> vertices) const;
  Local across_seam(std::span<const std::uint32_t> vertices) const;
  Vec3 mean_normal(std::span<const std::uint32_t> vertices, std::optional<std::uint32_t> patch) const;
  void link(std::uint32_t a, std::uint32_t b);
  void leave_front(std::uint32_t v);
  void end_patch();

  std::span<const Vec3> points_, normals_;
  const PointGrid& grid_;
  const Rules rules_;
  Surface& surface_;
  Refused refused_;
  std::uint32_t patch_ = 0;
  std::vector<std::uint8_t> finished_;
  std::vector<std::uint8_t> in_patch_;          // joined by the patch now growing
  std::vector<std::uint32_t> next_, previous_;  // the front, a ring; kNoTriangle off the front
  std::uint32_t front_size_ = 0;
  std::vector<std::uint64_t> tested_;  // per triangle: the last overlap question it was part of
  std::uint64_t question_ = 0;
};

}  // namespace scanmill::front
