// SPDX-License-Identifier: Apache-2.0
// A telephone handset of about 200 x 50 x 35 mm on the plane z = 0: a round earpiece, a square mouthpiece and a lower,
// narrower grip between them. All convex edges are sharp; the creases where the grip meets its ends open by 90 to 125
// degrees. No dimension is a multiple of half a millimetre, so no face lies on a plane of the usual lattices.
#include "simulate/primitives.hpp"
#include "simulate/solids.hpp"

namespace scanmill::simulate {
namespace {

constexpr double kHeight = 35.3;
constexpr double kGripTop = 21.7, kGripSide = 14.3;
constexpr double kEarX = -75.2, kEarRadius = 25.1;
constexpr double kMouthLow = 51.3, kMouthHigh = 100.2, kMouthSide = 24.8;

struct BoxShape {
  Vec3 low, high;
  double distance(Vec3 p) const { return box(p, (low + high) * 0.5, (high - low) * 0.5); }
};
// The grip runs from the earpiece's axis well into the mouthpiece; its ends lie inside and are no surface.
constexpr BoxShape kGrip{{kEarX, -kGripSide, 0}, {70, kGripSide, kGripTop}};
constexpr BoxShape kMouth{{kMouthLow, -kMouthSide, 0}, {kMouthHigh, kMouthSide, kHeight}};

double ear_distance(Vec3 p) { return cylinder_z(p, {kEarX, 0, kHeight / 2}, kEarRadius, kHeight / 2); }

double to_segment(Vec3 p, Vec3 a, Vec3 b) {
  const Vec3 along = b - a;
  return norm(p - a - along * std::clamp(dot(p - a, along) / norm2(along), 0.0, 1.0));
}

class Handset final : public Object {
 public:
  std::string_view name() const override { return "handset"; }

  double distance(Vec3 p) const override {
    return std::min(ear_distance(p), std::min(kGrip.distance(p), kMouth.distance(p)));
  }

  /// Outside, the least of the three distances is exact. Inside, the nearest surface point is the foot of a
  /// perpendicular on a face, where no other part covers it, or lies on a crease: a ball that fits inside never touches
  /// a convex edge first.
  double surface_distance(Vec3 p) const override {
    const double outside = distance(p);
    if (outside >= 0) return outside;
    double least = to_creases(p);
    auto foot = [&](Vec3 q) {
      if (distance(q) > -1e-9) least = std::min(least, norm(p - q));
    };
    for (const BoxShape* part : {&kGrip, &kMouth})
      if (part->distance(p) < 0) {
        for (const double x : {part->low.x, part->high.x}) foot({x, p.y, p.z});
        for (const double y : {part->low.y, part->high.y}) foot({p.x, y, p.z});
        for (const double z : {part->low.z, part->high.z}) foot({p.x, p.y, z});
      }
    if (ear_distance(p) < 0) {
      const double x = p.x - kEarX, r = std::sqrt(x * x + p.y * p.y);
      if (r > 0) foot({kEarX + x * (kEarRadius / r), p.y * (kEarRadius / r), p.z});
      foot({p.x, p.y, 0});
      foot({p.x, p.y, kHeight});
    }
    return -least;
  }

  Bounds bounds() const override { return {{kEarX - kEarRadius, -kEarRadius, 0}, {kMouthHigh, kEarRadius, kHeight}}; }
  bool is_seen(Vec3 p) const override { return p.z > 1e-6; }

 private:
  static double to_creases(Vec3 p) {
    const double ear_x = kEarX + std::sqrt(kEarRadius * kEarRadius - kGripSide * kGripSide);
    double least = to_segment(p, {kMouthLow, -kGripSide, kGripTop}, {kMouthLow, kGripSide, kGripTop});
    for (const double x : {ear_x, kMouthLow})
      for (const double y : {-kGripSide, kGripSide})
        least = std::min(least, to_segment(p, {x, y, 0}, {x, y, kGripTop}));
    // The arc of the earpiece's wall over the top of the grip; its ends are ends of the segments above.
    const double x = p.x - kEarX, r = std::sqrt(x * x + p.y * p.y);
    if (r > 0 && x > 0 && std::abs(p.y) * kEarRadius <= kGripSide * r)
      least = std::min(least, norm(Vec3{r - kEarRadius, 0, p.z - kGripTop}));
    return least;
  }
};

}  // namespace

std::unique_ptr<Object> make_handset() { return std::make_unique<Handset>(); }

}  // namespace scanmill::simulate
