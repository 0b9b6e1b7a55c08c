// SPDX-License-Identifier: Apache-2.0
// The triangles grown so far, by vertex. Keeps the one promise of the engine: a directed edge exists at most once.
#pragma once
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "front/overlap.hpp"
#include "mesh/mesh.hpp"

namespace scanmill::front {

class Surface {
 public:
  explicit Surface(std::span<const Vec3> points) : points_(points), around_(points.size()) {}

  std::size_t size() const { return triangles_.size(); }  // removed ones included
  bool alive(std::uint32_t t) const { return alive_[t] != 0; }
  const Triangle& triangle(std::uint32_t t) const { return triangles_[t]; }
  std::uint32_t patch(std::uint32_t t) const { return patches_[t]; }
  const Facet& facet(std::uint32_t t) const { return facets_[t]; }
  const std::vector<std::uint32_t>& around(std::uint32_t v) const { return around_[v]; }

  Facet make_facet(const Triangle& corners) const;

  /// The triangle that holds the directed edge a -> b, or kNoTriangle.
  std::uint32_t owner(std::uint32_t a, std::uint32_t b) const;
  /// All three directed edges are free.
  bool has_room(const Triangle& corners) const;
  /// Needs has_room.
  void add(const Triangle& corners, const Facet& facet, std::uint32_t patch);
  void remove(std::uint32_t t);

  /// The vertex has triangles, and every edge at it has two.
  bool closed(std::uint32_t v) const;
  /// The neighbours (u, w) of the single gap at v, open edges u -> v and v -> w; false when there is none or several.
  bool single_gap(std::uint32_t v, std::uint32_t& u, std::uint32_t& w) const;

  /// At each vertex with several fans keep the largest (then the one with the least triangle), until none is left.
  void remove_lesser_fans();

 private:
  /// Fan number per triangle around v; returns the number of fans.
  std::uint32_t fans_at(std::uint32_t v, std::vector<std::uint32_t>& fan) const;

  std::span<const Vec3> points_;
  std::vector<Triangle> triangles_;
  std::vector<Facet> facets_;
  std::vector<std::uint32_t> patches_;
  std::vector<std::uint8_t> alive_;
  std::vector<std::vector<std::uint32_t>> around_;
};

}  // namespace scanmill::front
