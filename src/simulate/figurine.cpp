// SPDX-License-Identifier: Apache-2.0
// A head on a foot, about 60 x 40 x 30 mm, lying on its back: x from foot to crown, y from ear to ear, z towards the
// face. Spheres and capsules joined by round blends, so that every concavity has a radius of at least 4 mm and every
// ridge 2 mm.
#include "simulate/primitives.hpp"
#include "simulate/solids.hpp"

namespace scanmill::simulate {
namespace {

class Figurine final : public Object {
 public:
  std::string_view name() const override { return "figurine"; }

  double distance(Vec3 p) const override {
    const Vec3 m{p.x, std::abs(p.y), p.z};  // ears and eyes come in pairs
    const double cranium = capsule_y(p, {16.2, 0, -2}, 5.4, 13);
    const double jaw = capsule_y(p, {1.5, 0, 0}, 2, 11);
    const double foot = capsule_y(p, {-22.3, 0, -2.5}, 7, 7.3);
    const double neck = capsule_x(p, {-21, 0, -3}, 17, 6.6);
    const double nose = capsule_x(p, {4, 0, 10.2}, 6, 3.8);
    const double ear = sphere(m, {9.5, 14.0, -3.5}, 4.9);
    const double eye = sphere(m, {11, 9, 14.8}, 6.2);
    const double mouth = capsule_y(p, {-3.6, 0, 14.2}, 3.5, 5.2);
    double d = smooth_union(cranium, jaw, 12);
    d = smooth_union(d, smooth_union(neck, foot, 9), 9);
    d = smooth_union(d, ear, 7);
    d = smooth_cut(d, eye, 3.6);
    d = smooth_cut(d, mouth, 4.5);
    return smooth_union(d, nose, 7);
  }

  /// The nearest point q of the surface is where p - q is along the normal: slide the foot along the tangent plane by
  /// what is left of p - q there, drop it back on the surface, repeat. Converges like |d| / radius, so a few rounds do.
  double surface_distance(Vec3 p) const override {
    const double here = distance(p);
    Vec3 q = p;
    double last = -1;
    for (int round = 0; round < 100; ++round) {
      for (int drop = 0; drop < 8; ++drop) {
        const double off_surface = distance(q);
        if (std::abs(off_surface) < 1e-12) break;
        const Vec3 g = gradient(q);
        q += g * (-off_surface / std::max(norm2(g), 0.05));  // deep inside, the gradient may vanish
      }
      const double length = norm(p - q);
      if (std::abs(length - last) < 1e-11) break;
      last = length;
      const Vec3 n = unit(gradient(q)), off = p - q;
      q += off - n * dot(off, n);
    }
    return here < 0 ? -last : last;
  }

  Bounds bounds() const override { return {{-31.1, -20.2, -15.2}, {29.3, 20.2, 15.1}}; }

 private:
  Vec3 gradient(Vec3 p) const {
    constexpr double e = 1e-5;
    return Vec3{distance({p.x + e, p.y, p.z}) - distance({p.x - e, p.y, p.z}),
                distance({p.x, p.y + e, p.z}) - distance({p.x, p.y - e, p.z}),
                distance({p.x, p.y, p.z + e}) - distance({p.x, p.y, p.z - e})} *
           (0.5 / e);
  }
};

}  // namespace

std::unique_ptr<Object> make_figurine() { return std::make_unique<Figurine>(); }

}  // namespace scanmill::simulate
