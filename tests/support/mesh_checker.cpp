// SPDX-License-Identifier: Apache-2.0
#include "support/mesh_checker.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <ostream>
#include <set>

#include "support/shapes.hpp"

namespace scanmill::support {
namespace {

__extension__ typedef __int128 Wide;
using Whole = std::array<std::int64_t, 3>;  // multiples of kGrid
using Edge = std::pair<std::uint32_t, std::uint32_t>;

Whole minus(const Whole& a, const Whole& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

int sign(Wide x) { return (x > 0) - (x < 0); }

std::array<Wide, 3> across(const Whole& u, const Whole& v) {
  const auto c = [&](std::size_t i, std::size_t j) { return Wide{u[i]} * v[j] - Wide{u[j]} * v[i]; };
  return {c(1, 2), c(2, 0), c(0, 1)};
}

int side_of_plane(const Whole& a, const Whole& b, const Whole& c, const Whole& p) {
  const auto n = across(minus(b, a), minus(c, a));
  const Whole d = minus(p, a);
  return sign(n[0] * d[0] + n[1] * d[1] + n[2] * d[2]);
}

/// Sign of the area of abc as seen along `axis`.
int flat_turn(const Whole& a, const Whole& b, const Whole& c, std::size_t axis) {
  return sign(across(minus(b, a), minus(c, a))[axis]);
}

using Corner = std::array<Whole, 3>;

int axis_of(const Corner& t) {
  const auto n = across(minus(t[1], t[0]), minus(t[2], t[0]));
  for (int k = 0; k < 3; ++k)
    if (n[static_cast<std::size_t>(k)] != 0) return k;
  return -1;
}

/// Segment and triangle in one plane: apart only if a side of the triangle or the segment's own line parts them.
bool meet_in_plane(const Whole& p, const Whole& q, const Corner& t, std::size_t axis) {
  const int way = flat_turn(t[0], t[1], t[2], axis);
  for (std::size_t e = 0; e < 3; ++e) {
    const Whole &a = t[e], &b = t[(e + 1) % 3];
    if (flat_turn(a, b, p, axis) * way < 0 && flat_turn(a, b, q, axis) * way < 0) return false;
  }
  const int x = flat_turn(p, q, t[0], axis), y = flat_turn(p, q, t[1], axis), z = flat_turn(p, q, t[2], axis);
  return !((x > 0 && y > 0 && z > 0) || (x < 0 && y < 0 && z < 0));
}

bool meet(const Whole& p, const Whole& q, const Corner& t) {
  const int above = side_of_plane(t[0], t[1], t[2], p), below = side_of_plane(t[0], t[1], t[2], q);
  if (above == 0 && below == 0) return meet_in_plane(p, q, t, static_cast<std::size_t>(axis_of(t)));
  if (above * below > 0) return false;
  int least = 1, most = -1;
  for (std::size_t e = 0; e < 3; ++e) {
    const int s = side_of_plane(p, q, t[e], t[(e + 1) % 3]);
    least = std::min(least, s);
    most = std::max(most, s);
  }
  return least >= 0 || most <= 0;
}

struct Face {
  Triangle corners;
  Corner at;
  Whole low, high;
};

bool crosses(const Face& s, const Face& t) {
  std::vector<std::size_t> own_s, own_t;
  for (std::size_t k = 0; k < 3; ++k) {
    if (std::count(t.corners.begin(), t.corners.end(), s.corners[k]) == 0) own_s.push_back(k);
    if (std::count(s.corners.begin(), s.corners.end(), t.corners[k]) == 0) own_t.push_back(k);
  }
  if (own_s.empty()) return true;
  if (own_s.size() == 1) {  // beyond the common edge only a flat fold can meet
    const std::size_t k = own_s[0], axis = static_cast<std::size_t>(axis_of(s.at));
    const Whole &a = s.at[(k + 1) % 3], &b = s.at[(k + 2) % 3], &c = t.at[own_t[0]];
    return side_of_plane(s.at[0], s.at[1], s.at[2], c) == 0 &&
           flat_turn(a, b, s.at[k], axis) == flat_turn(a, b, c, axis);
  }
  // A common point outside the common vertex lies on a ray from it; where the ray leaves the first of the two
  // triangles, the side opposite the vertex meets the other.
  if (own_s.size() == 2)
    return meet(s.at[own_s[0]], s.at[own_s[1]], t.at) || meet(t.at[own_t[0]], t.at[own_t[1]], s.at);
  for (std::size_t e = 0; e < 3; ++e)
    if (meet(s.at[e], s.at[(e + 1) % 3], t.at) || meet(t.at[e], t.at[(e + 1) % 3], s.at)) return true;
  return false;
}

class Checker {
 public:
  Checker(std::span<const Vec3> positions, std::span<const Triangle> triangles)
      : positions_(positions), triangles_(triangles) {}

  MeshFindings run(double longest, double least_angle) {
    for (const Triangle& t : triangles_)
      for (const std::uint32_t v : t)
        if (v >= positions_.size())
          fault(found_.bad_indices, "vertex " + std::to_string(v) + " of " + name(t) + " is not there");
    if (found_.bad_indices > 0) return found_;
    found_.triangles = triangles_.size();
    measure(longest, least_angle);
    count_edges();
    count_fans();
    count_crossings();
    return found_;
  }

 private:
  static std::string name(const Triangle& t) {
    return "(" + std::to_string(t[0]) + " " + std::to_string(t[1]) + " " + std::to_string(t[2]) + ")";
  }
  void fault(std::size_t& count, const std::string& text) {
    if (count++ == 0) found_.first_fault += text + "; ";
  }

  Whole whole(Vec3 p) {
    Whole w{};
    const double c[3] = {p.x, p.y, p.z};
    for (std::size_t k = 0; k < 3; ++k) {
      const double scaled = c[k] / kGrid;
      if (scaled != std::floor(scaled) || std::abs(c[k]) > 2048)
        fault(found_.bad_indices, "coordinate " + std::to_string(c[k]) + " is off the grid");
      w[k] = static_cast<std::int64_t>(scaled);
    }
    return w;
  }

  void measure(double longest, double least_angle) {
    std::set<std::array<std::uint32_t, 3>> seen;
    for (const Triangle& t : triangles_) {
      Triangle sorted = t;
      std::sort(sorted.begin(), sorted.end());
      if (!seen.insert(sorted).second) fault(found_.duplicate_triangles, name(t) + " twice");
      const Vec3 a = positions_[t[0]], b = positions_[t[1]], c = positions_[t[2]];
      found_.area += norm(cross(b - a, c - a)) / 2;
      found_.volume += dot(a, cross(b, c)) / 6;
      for (std::size_t e = 0; e < 3; ++e) {
        const Vec3 p = positions_[t[e]], q = positions_[t[(e + 1) % 3]], r = positions_[t[(e + 2) % 3]];
        const double length = norm(q - p);
        const double angle = std::atan2(norm(cross(q - p, r - p)), dot(q - p, r - p)) * 57.29577951308232;
        found_.longest_edge = std::max(found_.longest_edge, length);
        found_.least_angle_deg = std::min(found_.least_angle_deg, angle);
        if (length > longest * (1 + 1e-12))
          fault(found_.long_edges, name(t) + " has an edge of " + std::to_string(length) + " mm");
        if (angle < least_angle - 1e-9)
          fault(found_.small_angles, name(t) + " has an angle of " + std::to_string(angle) + " deg");
      }
      Face face{t, {whole(a), whole(b), whole(c)}, {}, {}};
      if (axis_of(face.at) < 0) {
        fault(found_.degenerate_triangles, name(t) + " has no area");
        continue;
      }
      for (std::size_t k = 0; k < 3; ++k) {
        face.low[k] = std::min({face.at[0][k], face.at[1][k], face.at[2][k]});
        face.high[k] = std::max({face.at[0][k], face.at[1][k], face.at[2][k]});
      }
      faces_.push_back(face);
    }
  }

  std::uint32_t root(std::vector<std::uint32_t>& up, std::uint32_t v) {
    while (up[v] != v) v = up[v] = up[up[v]];
    return v;
  }

  void count_edges() {
    std::map<Edge, int> directed, plain;
    std::vector<std::uint32_t> up(positions_.size());
    std::iota(up.begin(), up.end(), 0u);
    std::set<std::uint32_t> used;
    for (const Triangle& t : triangles_)
      for (std::size_t e = 0; e < 3; ++e) {
        const std::uint32_t a = t[e], b = t[(e + 1) % 3];
        ++directed[{a, b}];
        ++plain[{std::min(a, b), std::max(a, b)}];
        up[root(up, a)] = root(up, b);
        used.insert(a);
      }
    std::multimap<std::uint32_t, std::uint32_t> open;
    for (const auto& [edge, count] : plain) {
      const auto text = [&] { return "edge " + std::to_string(edge.first) + "-" + std::to_string(edge.second); };
      if (count > 2) fault(found_.nonmanifold_edges, text() + " has " + std::to_string(count) + " triangles");
      const auto forward = directed.find(edge);
      const bool is_forward = forward != directed.end() && forward->second == 1;
      if (count == 2 && !is_forward) fault(found_.misoriented_edges, text() + " is run twice one way");
      if (count != 1) continue;
      ++found_.boundary_edges;
      if (is_forward)
        open.insert({edge.first, edge.second});
      else
        open.insert({edge.second, edge.first});
    }
    found_.vertices = used.size();
    found_.edges = plain.size();
    for (const std::uint32_t v : used) found_.components += root(up, v) == v;
    found_.euler = static_cast<std::int64_t>(used.size()) - static_cast<std::int64_t>(plain.size()) +
                   static_cast<std::int64_t>(triangles_.size());
    while (!open.empty()) {
      ++found_.loops;
      for (auto at = open.begin(); at != open.end();) {
        const std::uint32_t next = at->second;
        open.erase(at);
        at = open.find(next);
      }
    }
  }

  /// Triangles at a vertex, joined where they share an edge at it, must be one group.
  void count_fans() {
    std::vector<std::vector<std::uint32_t>> at(positions_.size());
    for (std::uint32_t t = 0; t < triangles_.size(); ++t)
      for (const std::uint32_t v : triangles_[t]) at[v].push_back(t);
    for (std::uint32_t v = 0; v < at.size(); ++v) {
      if (at[v].empty()) continue;
      std::vector<std::uint32_t> group{at[v][0]}, rest(at[v].begin() + 1, at[v].end());
      for (std::size_t g = 0; g < group.size(); ++g)
        for (std::size_t r = 0; r < rest.size();) {
          int common = 0;
          for (const std::uint32_t x : triangles_[group[g]])
            common += static_cast<int>(std::count(triangles_[rest[r]].begin(), triangles_[rest[r]].end(), x));
          if (common >= 2) {
            group.push_back(rest[r]);
            rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(r));
          } else {
            ++r;
          }
        }
      if (!rest.empty()) fault(found_.nonmanifold_vertices, "vertex " + std::to_string(v) + " has several fans");
    }
  }

  void count_crossings() {
    std::sort(faces_.begin(), faces_.end(), [](const Face& a, const Face& b) { return a.low[0] < b.low[0]; });
    for (std::size_t i = 0; i < faces_.size(); ++i)
      for (std::size_t j = i + 1; j < faces_.size() && faces_[j].low[0] <= faces_[i].high[0]; ++j) {
        const Face &s = faces_[i], &t = faces_[j];
        if (s.low[1] > t.high[1] || t.low[1] > s.high[1] || s.low[2] > t.high[2] || t.low[2] > s.high[2]) continue;
        if (crosses(s, t)) fault(found_.crossing_pairs, name(s.corners) + " crosses " + name(t.corners));
      }
  }

  std::span<const Vec3> positions_;
  std::span<const Triangle> triangles_;
  std::vector<Face> faces_;
  MeshFindings found_;
};

}  // namespace

std::ostream& operator<<(std::ostream& out, const MeshFindings& f) {
  out << f.vertices << " vertices, " << f.triangles << " triangles, " << f.edges << " edges, euler " << f.euler << ", "
      << f.components << " components, " << f.boundary_edges << " open edges in " << f.loops << " loops\n";
  out << "non-manifold edges " << f.nonmanifold_edges << ", vertices " << f.nonmanifold_vertices << ", mis-oriented "
      << f.misoriented_edges << ", duplicates " << f.duplicate_triangles << ", degenerate " << f.degenerate_triangles
      << ", crossing pairs " << f.crossing_pairs << ", long edges " << f.long_edges << ", small angles "
      << f.small_angles << "\n";
  out << "area " << f.area << " mm2, volume " << f.volume << " mm3, longest edge " << f.longest_edge
      << " mm, least angle " << f.least_angle_deg << " deg";
  if (!f.first_fault.empty()) out << "\n" << f.first_fault;
  return out;
}

MeshFindings check_mesh(std::span<const Vec3> positions, std::span<const Triangle> triangles, double longest_mm,
                        double least_angle_deg) {
  return Checker(positions, triangles).run(longest_mm, least_angle_deg);
}

}  // namespace scanmill::support
