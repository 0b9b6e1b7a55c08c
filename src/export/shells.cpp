// SPDX-License-Identifier: Apache-2.0
#include "export/shells.hpp"

#include <algorithm>
#include <limits>

#include "mesh/groups.hpp"

namespace scanmill::exporting {
namespace {

constexpr std::uint32_t kNone = 0xffffffffu;

bool has_edges(const Triangle& t) { return t[0] != t[1] && t[1] != t[2] && t[2] != t[0]; }

/// A side of a triangle, filed under its lower row.
struct Side {
  std::uint32_t high, triangle;
  std::uint8_t corner;
  bool forward;  // runs from low to high
};

/// Sides by lower row; `begin` has one entry more than there are vertices.
std::vector<Side> sides_by_low_row(const Mesh& mesh, std::vector<std::size_t>& begin) {
  begin.assign(mesh.positions.size() + 1, 0);
  auto each = [&](auto&& take) {
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
      if (const Triangle& corners = mesh.triangles[t]; has_edges(corners))
        for (std::uint8_t e = 0; e < 3; ++e) take(t, e, corners[e], corners[(e + 1) % 3]);
  };
  each([&](std::uint32_t, std::uint8_t, std::uint32_t a, std::uint32_t b) { ++begin[std::min(a, b) + 1]; });
  for (std::size_t v = 1; v < begin.size(); ++v) begin[v] += begin[v - 1];
  std::vector<std::size_t> at(begin.begin(), begin.end() - 1);
  std::vector<Side> sides(begin.back());
  each([&](std::uint32_t t, std::uint8_t e, std::uint32_t a, std::uint32_t b) {
    sides[at[std::min(a, b)]++] = {std::max(a, b), t, e, a < b};
  });
  for (std::size_t v = 0; v + 1 < begin.size(); ++v)
    std::sort(sides.begin() + static_cast<std::ptrdiff_t>(begin[v]),
              sides.begin() + static_cast<std::ptrdiff_t>(begin[v + 1]), [](const Side& a, const Side& b) {
                return a.high != b.high ? a.high < b.high : a.triangle < b.triangle;
              });
  return sides;
}

std::uint8_t one_more(std::uint8_t count) {
  return count == std::numeric_limits<std::uint8_t>::max() ? count : static_cast<std::uint8_t>(count + 1);
}

void add_shells(const Mesh& mesh, Groups& groups, Shells& out) {
  std::vector<std::uint32_t> shell_of(mesh.triangles.size(), kNone);
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    if (!has_edges(mesh.triangles[t])) continue;
    std::uint32_t& shell = shell_of[groups.root(t)];
    if (shell == kNone) {
      shell = static_cast<std::uint32_t>(out.shells.size());
      out.shells.push_back({{}, true, 0});
    }
    Shell& here = out.shells[shell];
    here.triangles.push_back(t);
    for (const std::uint32_t edge : out.edge_of[t])
      here.closed = here.closed && out.used_forward[edge] == 1 && out.used_backward[edge] == 1;
    const auto& [a, b, c] = mesh.triangles[t];
    here.volume_mm3 += dot(mesh.positions[a], cross(mesh.positions[b], mesh.positions[c])) / 6;
  }
}

}  // namespace

Shells shells_of(const Mesh& mesh) {
  Shells out;
  out.edge_of.assign(mesh.triangles.size(), {kNone, kNone, kNone});
  std::vector<std::size_t> begin;
  const std::vector<Side> sides = sides_by_low_row(mesh, begin);
  Groups groups(mesh.triangles.size());
  for (std::uint32_t low = 0; low + 1 < begin.size(); ++low)
    for (std::size_t s = begin[low]; s < begin[low + 1]; ++s) {
      const Side& side = sides[s];
      if (s == begin[low] || sides[s - 1].high != side.high) {
        out.edges.push_back({low, side.high});
        out.first_triangle.push_back(side.triangle);
        out.used_forward.push_back(0);
        out.used_backward.push_back(0);
      }
      const auto edge = static_cast<std::uint32_t>(out.edges.size() - 1);
      out.edge_of[side.triangle][side.corner] = edge;
      std::uint8_t& used = side.forward ? out.used_forward[edge] : out.used_backward[edge];
      used = one_more(used);
      groups.join(out.first_triangle[edge], side.triangle);
    }
  for (std::uint32_t edge = 0; edge < out.edges.size(); ++edge)
    if (out.used_forward[edge] > 1 || out.used_backward[edge] > 1)
      if (out.overused_edges++ == 0) out.first_overused = edge;
  add_shells(mesh, groups, out);
  return out;
}

}  // namespace scanmill::exporting
