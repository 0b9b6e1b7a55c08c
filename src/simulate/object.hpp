// SPDX-License-Identifier: Apache-2.0
// Built-in solids for the virtual scanner, as exact signed distances.
#pragma once
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
  /// Signed distance, negative inside; a lower bound of the true distance is enough outside (Lipschitz constant <= 1).
  virtual double distance(Vec3 p) const = 0;
  virtual Bounds bounds() const = 0;
  /// False where the part is not meant to be seen (the handset's bottom).
  virtual bool is_seen(Vec3) const { return true; }
};

std::span<const std::string_view> object_names();  // figurine handset sphere torus cube
/// errors  BadUsage with the nearest name
Result<std::unique_ptr<Object>> make_object(std::string_view name);

/// One view: range maps are row-major, pixels_y rows of pixels_x; a cell without return is NaN in all coordinates.
struct RangeMap {
  std::int64_t pixels_x = 0, pixels_y = 0;
  std::vector<Vec3> points;  // sensor frame, mm
};

/// Sphere-traces every pixel's ray: nearest hit within the depth band, not steeper than max_incidence_deg, noise along the
/// ray from (seed, pixel). Same bits for any number of threads.
Result<RangeMap> scan(const Object& object, const Sensor& sensor, const Pose& pose, std::uint64_t seed, const Context& context);

}  // namespace scanmill::simulate
