// SPDX-License-Identifier: Apache-2.0
// Floating-point expansions after J. R. Shewchuk, "Adaptive precision floating-point arithmetic and fast robust
// geometric predicates", Discrete & Computational Geometry 18 (1997): a number is an exact sum of doubles that do not
// overlap.
#include "geom/predicates.hpp"

#include <algorithm>
#include <cmath>

namespace scanmill {
namespace {

constexpr double kEpsilon = 0x1p-53;
// Error bounds of the plain evaluations, paper section 4.
constexpr double kBound3 = (7 + 56 * kEpsilon) * kEpsilon;
constexpr double kBound2 = (3 + 16 * kEpsilon) * kEpsilon;
constexpr double kSplitter = 0x1p27 + 1;

struct Pair {
  double high, low;
};
Pair two_sum(double a, double b) {
  const double x = a + b, v = x - a;
  return {x, (a - (x - v)) + (b - v)};
}
Pair split(double a) {
  const double c = kSplitter * a, high = c - (c - a);
  return {high, a - high};
}
Pair two_product(double a, double b) {
  const double x = a * b;
  const Pair p = split(a), q = split(b);
  return {x, p.low * q.low - (((x - p.high * q.high) - p.low * q.high) - p.high * q.low)};
}

/// Components of growing magnitude; zeros are left out.
template <int Capacity>
struct Expansion {
  double part[Capacity];
  int size = 0;

  void add(double value) {
    int kept = 0;
    for (int i = 0; i < size; ++i) {
      const Pair s = two_sum(value, part[i]);
      value = s.high;
      if (s.low != 0) part[kept++] = s.low;
    }
    if (value != 0) part[kept++] = value;
    size = kept;
  }
  template <int Other>
  void add(const Expansion<Other>& other, double sign) {
    for (int i = 0; i < other.size; ++i) add(sign * other.part[i]);
  }
  int sign() const { return size == 0 ? 0 : part[size - 1] > 0 ? 1 : -1; }
};

using Difference = Expansion<2>;

Difference difference(double a, double b) {
  Difference d;
  const Pair s = two_sum(a, -b);
  if (s.low != 0) d.part[d.size++] = s.low;
  if (s.high != 0) d.part[d.size++] = s.high;
  return d;
}

template <int A, int B>
Expansion<2 * A * B> product(const Expansion<A>& a, const Expansion<B>& b) {
  Expansion<2 * A * B> out;
  for (int i = 0; i < a.size; ++i)
    for (int j = 0; j < b.size; ++j) {
      const Pair p = two_product(a.part[i], b.part[j]);
      if (p.low != 0) out.add(p.low);
      out.add(p.high);
    }
  return out;
}

Expansion<16> minor(const Difference& a, const Difference& b, const Difference& c, const Difference& d) {  // a d - b c
  Expansion<16> out;
  out.add(product(a, d), 1);
  out.add(product(b, c), -1);
  return out;
}

int orientation_exact(Vec3 a, Vec3 b, Vec3 c, Vec3 d) {
  const Difference bx = difference(b.x, a.x), by = difference(b.y, a.y), bz = difference(b.z, a.z);
  const Difference cx = difference(c.x, a.x), cy = difference(c.y, a.y), cz = difference(c.z, a.z);
  const Difference dx = difference(d.x, a.x), dy = difference(d.y, a.y), dz = difference(d.z, a.z);
  Expansion<192> sum;
  sum.add(product(minor(by, bz, cy, cz), dx), 1);
  sum.add(product(minor(bx, bz, cx, cz), dy), -1);
  sum.add(product(minor(bx, by, cx, cy), dz), 1);
  return sum.sign();
}

double coordinate(Vec3 p, int axis) { return axis == 0 ? p.x : axis == 1 ? p.y : p.z; }

/// All five points in one plane whose image along `axis` keeps abc's area.
bool segment_meets_triangle_flat(Vec3 p, Vec3 q, Vec3 a, Vec3 b, Vec3 c, int axis) {
  auto inside = [&](Vec3 r) {
    const int e = orientation_flat(a, b, r, axis), f = orientation_flat(b, c, r, axis),
              g = orientation_flat(c, a, r, axis);
    return (e >= 0 && f >= 0 && g >= 0) || (e <= 0 && f <= 0 && g <= 0);
  };
  if (inside(p) || inside(q)) return true;
  auto cuts = [&](Vec3 u, Vec3 v) {  // touching ends were found above or belong to a neighbouring edge's proper cut
    const int e = orientation_flat(p, q, u, axis), f = orientation_flat(p, q, v, axis);
    const int g = orientation_flat(u, v, p, axis), h = orientation_flat(u, v, q, axis);
    return e * f <= 0 && g * h <= 0 && !(e == 0 && f == 0);
  };
  return cuts(a, b) || cuts(b, c) || cuts(c, a);
}

/// The axis along which abc keeps an area, or -1 when its corners lie on a line.
int flat_axis(Vec3 a, Vec3 b, Vec3 c) {
  const Vec3 n = cross(b - a, c - a);
  const double size[3] = {std::abs(n.x), std::abs(n.y), std::abs(n.z)};
  int order[3] = {0, 1, 2};
  std::sort(order, order + 3, [&](int i, int j) { return size[i] > size[j]; });
  for (const int axis : order)
    if (orientation_flat(a, b, c, axis) != 0) return axis;
  return -1;
}

/// True when t lies clearly outside s across one of s's edges, seen along s's normal; shared corners may touch that
/// edge. The margin is a thousand times what rounding can do: a clear answer here needs no exact test.
bool clearly_apart(const Corners& s, const Corners& t) {
  constexpr double kMargin2 = 1e-24;
  const Vec3 n = cross(s.at[1] - s.at[0], s.at[2] - s.at[0]);
  for (unsigned e = 0; e < 3; ++e) {
    const unsigned f = (e + 1) % 3;
    const Vec3 edge = s.at[f] - s.at[e], out = cross(edge, n);  // points away from the triangle
    const double size2 =
        norm2(edge) * norm2(s.at[1] - s.at[0]) * norm2(s.at[2] - s.at[0]);  // of what out is made of, squared
    bool apart = true;
    unsigned touching = 0;
    for (unsigned k = 0; k < 3 && apart; ++k) {
      if (t.id[k] == s.id[e] || t.id[k] == s.id[f]) {
        ++touching;
        continue;
      }
      const Vec3 d = t.at[k] - s.at[e];
      const double side = dot(d, out);
      apart = side > 0 && side * side > kMargin2 * norm2(d) * size2;
    }
    if (apart && touching <= 1) return true;
  }
  return false;
}

}  // namespace

int orientation(Vec3 a, Vec3 b, Vec3 c, Vec3 d) {
  const Vec3 u = b - a, v = c - a, w = d - a;
  const double yz = u.y * v.z, zy = u.z * v.y, xz = u.x * v.z, zx = u.z * v.x, xy = u.x * v.y, yx = u.y * v.x;
  const double det = (yz - zy) * w.x - (xz - zx) * w.y + (xy - yx) * w.z;
  const double size = (std::abs(yz) + std::abs(zy)) * std::abs(w.x) + (std::abs(xz) + std::abs(zx)) * std::abs(w.y) +
                      (std::abs(xy) + std::abs(yx)) * std::abs(w.z);
  const double bound = kBound3 * size;
  if (det > bound) return 1;
  if (det < -bound) return -1;
  return orientation_exact(a, b, c, d);
}

int orientation_flat(Vec3 a, Vec3 b, Vec3 c, int axis) {
  const int i = (axis + 1) % 3, j = (axis + 2) % 3;
  const double ax = coordinate(a, i), ay = coordinate(a, j), bx = coordinate(b, i), by = coordinate(b, j);
  const double cx = coordinate(c, i), cy = coordinate(c, j);
  const double left = (bx - ax) * (cy - ay), right = (by - ay) * (cx - ax), det = left - right;
  const double bound = kBound2 * (std::abs(left) + std::abs(right));
  if (det > bound) return 1;
  if (det < -bound) return -1;
  return minor(difference(bx, ax), difference(by, ay), difference(cx, ax), difference(cy, ay)).sign();
}

bool segment_meets_triangle(Vec3 p, Vec3 q, Vec3 a, Vec3 b, Vec3 c) {
  const int s = orientation(a, b, c, p), t = orientation(a, b, c, q);
  if (s * t > 0) return false;
  if (s == 0 && t == 0) {
    const int axis = flat_axis(a, b, c);
    return axis >= 0 && segment_meets_triangle_flat(p, q, a, b, c, axis);
  }
  const int u = orientation(p, q, a, b), v = orientation(p, q, b, c), w = orientation(p, q, c, a);
  return (u >= 0 && v >= 0 && w >= 0) || (u <= 0 && v <= 0 && w <= 0);
}

bool triangles_cross(const Corners& s, const Corners& t) {
  unsigned shared = 0, own_s = 0, own_t = 0, common_s = 0, common_t = 0;
  bool in_t[3] = {}, in_s[3] = {};
  for (unsigned i = 0; i < 3; ++i)
    for (unsigned j = 0; j < 3; ++j)
      if (s.id[i] == t.id[j]) {
        ++shared;
        in_t[i] = in_s[j] = true;
        common_s = i;
        common_t = j;
      }
  if (shared == 3) return true;
  for (unsigned k = 0; k < 3; ++k) {
    if (!in_t[k]) own_s = k;
    if (!in_s[k]) own_t = k;
  }
  if (shared == 2) {  // flat over the shared edge: coplanar, on the same side
    const Vec3 p = s.at[(own_s + 1) % 3], q = s.at[(own_s + 2) % 3], a = s.at[own_s], b = t.at[own_t];
    if (orientation(p, q, a, b) != 0) return false;
    const int axis = flat_axis(p, q, a);
    return axis >= 0 && orientation_flat(p, q, a, axis) * orientation_flat(p, q, b, axis) > 0;
  }
  if (clearly_apart(s, t) || clearly_apart(t, s)) return false;
  if (flat_axis(s.at[0], s.at[1], s.at[2]) < 0 || flat_axis(t.at[0], t.at[1], t.at[2]) < 0) return false;
  if (shared == 1)  // the sides opposite the common vertex decide
    return segment_meets_triangle(s.at[(common_s + 1) % 3], s.at[(common_s + 2) % 3], t.at[0], t.at[1], t.at[2]) ||
           segment_meets_triangle(t.at[(common_t + 1) % 3], t.at[(common_t + 2) % 3], s.at[0], s.at[1], s.at[2]);
  for (unsigned i = 0; i < 3; ++i)
    if (segment_meets_triangle(s.at[i], s.at[(i + 1) % 3], t.at[0], t.at[1], t.at[2]) ||
        segment_meets_triangle(t.at[i], t.at[(i + 1) % 3], s.at[0], s.at[1], s.at[2]))
      return true;
  return false;
}

}  // namespace scanmill
