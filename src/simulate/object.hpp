// SPDX-License-Identifier: Apache-2.0
// Built-in solids for the virtual scanner, as exact signed distances.
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/context.hpp"
#include "base/result.hpp"
#include "cloud/sensor.hpp"
#include "geom/pose.hpp"

namespace scanmill::simulate {

/// A solid in its own frame = the global frame, mm.
class Object {
 public:
  virtual ~Object() = default;
  virtual std::string_view name() const = 0;
  /// Signed field, negative inside, zero exactly on the surface. Lipschitz constant <= 1, so its size is a lower bound
  /// of the true distance on both sides. Outside it is the true distance, except for the figurine, whose blends only
  /// bound it.
  virtual double distance(Vec3 p) const = 0;
  /// True signed distance to the surface, for judging points near it: exact, or (figurine) refined to 1e-7 mm where
  /// |distance| <= 1 mm; farther off the figurine it is an estimate.
  virtual double surface_distance(Vec3 p) const = 0;
  virtual Bounds bounds() const = 0;
  /// False for points of the surface that are not meant to be seen (the handset's bottom).
  virtual bool is_seen(Vec3) const { return true; }
};

std::span<const std::string_view> object_names();  // figurine handset sphere torus cube
/// errors  BadUsage with the nearest name
Result<std::unique_ptr<Object>> make_object(std::string_view name);

/// Unit gradient of the field by four differences: the outward normal near the surface, a mean of them at an edge.
Vec3 normal_at(const Object& object, Vec3 p);

/// `count` points of the surface (|distance| <= 1e-9 mm), uniform by area: where straight lines, uniform among all that
/// meet the object's bounding sphere, cross the surface. The unseen part is included. Cost about 3 us a point.
std::vector<Vec3> sample_surface(const Object& object, std::size_t count, std::uint64_t seed);

/// One view: range maps are row-major, pixels_y rows of pixels_x; a cell without return is NaN in all coordinates.
struct RangeMap {
  std::int64_t pixels_x = 0, pixels_y = 0;
  std::vector<Vec3> points;  // sensor frame, mm; every coordinate is a float32
};

/// The seed of station number `station` in an archive with seed `seed`, so that no two views share their noise.
std::uint64_t view_seed(std::uint64_t seed, std::uint64_t station);

/// Sphere-traces the ray through every pixel's centre (of the field at the stand-off): nearest hit, if it lies in the
/// depth band before and after noise and is not steeper than max_incidence_deg; noise along the ray from (seed, pixel).
/// Same bits for any number of threads.
/// errors  BadParameter when the sensor is out of its limits; Cancelled
Result<RangeMap> scan(const Object& object, const Sensor& sensor, const Pose& pose, std::uint64_t seed,
                      const Context& context);

}  // namespace scanmill::simulate
