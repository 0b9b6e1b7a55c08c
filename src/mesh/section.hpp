// SPDX-License-Identifier: Apache-2.0
// A plane cut through a mesh and the measured points beside it: plain values that verify fills and writers draw.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/ids.hpp"
#include "geom/vec3.hpp"

namespace scanmill {

/// A place in a cutting plane, mm.
struct Uv {
  double u = 0, v = 0;
  friend constexpr bool operator==(const Uv&, const Uv&) = default;
};

/// Unit vectors, right x up = normal; the viewer stands on the normal's side. Global frame, mm.
struct SectionFrame {
  std::string name;  // "z = 12.5 mm"
  Vec3 origin, right, up, normal;
  double slab_mm = 0;  // points within half of it on either side of the plane belong to the section

  Uv at(Vec3 p) const { return {dot(p - origin, right), dot(p - origin, up)}; }
  Vec3 place(Uv p) const { return origin + right * p.u + up * p.v; }
};

/// Where the mesh crosses the plane, with the material on the left as long as the mesh is oriented outward.
struct SectionLine {
  std::vector<Uv> points;  // of a closed line the first is not repeated
  bool closed = false;
};

/// A measured point of the slab.
struct SectionPoint {
  Vec3 place;  // global frame, mm
  SourceKey source;
  Uv at;                  // its foot on the plane
  double signed_mm = 0;   // exact distance from the mesh in space, positive on the normal's side
  Uv foot, outward;       // nearest place of the section's lines, and the unit direction away from the material there
  bool has_foot = false;  // false beyond the ends of open lines, and where the surface lies flat in the slab
};

struct Section {
  SectionFrame frame;
  std::vector<SectionLine> lines;
  double length_mm = 0;  // of all lines
  std::uint64_t points_in_slab = 0;
  std::uint64_t points_at_open_border = 0;  // of them: nearest to an open edge, so measured beyond the mesh
  double max_mm = 0, rms_mm = 0;            // of the others
  std::vector<SectionPoint> points;         // a fair sample of them, by source
  std::optional<SectionPoint> worst;        // of those that are not at an open border
  double magnify = 1;                       // of deviations in drawings
};

}  // namespace scanmill
