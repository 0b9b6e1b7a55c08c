// SPDX-License-Identifier: Apache-2.0
#include "simulate/object.hpp"

#include "base/text.hpp"
#include "simulate/solids.hpp"

namespace scanmill::simulate {
namespace {

struct Maker {
  std::string_view name;
  std::unique_ptr<Object> (*make)();
};
constexpr Maker kMakers[] = {{"figurine", make_figurine},
                             {"handset", make_handset},
                             {"sphere", make_sphere},
                             {"torus", make_torus},
                             {"cube", make_cube}};
constexpr std::string_view kNames[] = {"figurine", "handset", "sphere", "torus", "cube"};

}  // namespace

std::span<const std::string_view> object_names() { return kNames; }

Result<std::unique_ptr<Object>> make_object(std::string_view name) {
  for (const Maker& maker : kMakers)
    if (maker.name == name) return maker.make();
  std::string list;
  for (const std::string_view known : kNames) list += (list.empty() ? "" : ", ") + std::string(known);
  const std::string_view nearest = nearest_name(name, kNames);
  return fail(Code::BadUsage, "there is no built-in object \"" + std::string(name) + "\"; the objects are " + list +
                                  (nearest.empty() ? "" : "; did you mean " + std::string(nearest) + "?"));
}

Vec3 normal_at(const Object& object, Vec3 p) {
  constexpr double e = 1e-4;  // small against every radius, large against rounding (1e-14 mm)
  const double a = object.distance({p.x + e, p.y - e, p.z - e}), b = object.distance({p.x - e, p.y - e, p.z + e});
  const double c = object.distance({p.x - e, p.y + e, p.z - e}), d = object.distance({p.x + e, p.y + e, p.z + e});
  return unit({a - b - c + d, c - a - b + d, b - a - c + d});
}

}  // namespace scanmill::simulate
