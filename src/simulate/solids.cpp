// SPDX-License-Identifier: Apache-2.0
// Sphere, torus and cube: solids whose distance has a closed form on both sides.
#include "simulate/solids.hpp"

#include "simulate/primitives.hpp"

namespace scanmill::simulate {
namespace {

class Sphere final : public Object {
 public:
  std::string_view name() const override { return "sphere"; }
  double distance(Vec3 p) const override { return sphere(p, {}, kRadius); }
  double surface_distance(Vec3 p) const override { return distance(p); }
  Bounds bounds() const override { return {{-kRadius, -kRadius, -kRadius}, {kRadius, kRadius, kRadius}}; }

 private:
  static constexpr double kRadius = 20;
};

class Torus final : public Object {
 public:
  std::string_view name() const override { return "torus"; }
  double distance(Vec3 p) const override {
    const double off = std::sqrt(p.x * p.x + p.y * p.y) - kRing;
    return std::sqrt(off * off + p.z * p.z) - kTube;
  }
  double surface_distance(Vec3 p) const override { return distance(p); }
  Bounds bounds() const override {
    constexpr double reach = kRing + kTube;
    return {{-reach, -reach, -kTube}, {reach, reach, kTube}};
  }

 private:
  static constexpr double kRing = 20, kTube = 8;
};

/// Off the origin, so that no face lies on a plane of an absolute lattice.
class Cube final : public Object {
 public:
  std::string_view name() const override { return "cube"; }
  double distance(Vec3 p) const override { return box(p, kCentre, kHalf); }
  double surface_distance(Vec3 p) const override { return distance(p); }
  Bounds bounds() const override { return {kCentre - kHalf, kCentre + kHalf}; }

 private:
  static constexpr Vec3 kCentre{0.3, -0.2, 0.1}, kHalf{15, 15, 15};
};

}  // namespace

std::unique_ptr<Object> make_sphere() { return std::make_unique<Sphere>(); }
std::unique_ptr<Object> make_torus() { return std::make_unique<Torus>(); }
std::unique_ptr<Object> make_cube() { return std::make_unique<Cube>(); }

}  // namespace scanmill::simulate
