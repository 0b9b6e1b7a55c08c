// SPDX-License-Identifier: Apache-2.0
#include "simulate/scene.hpp"

#include <algorithm>
#include <cmath>

namespace scanmill::simulate {
namespace {

/// The face of a box through which a ray enters; `box` in the frame of the ray. False when it misses or begins inside.
bool enter(const Ray& ray, const Bounds& box, Interval range, double& t, Vec3& normal) {
  const double o[3] = {ray.origin.x, ray.origin.y, ray.origin.z},
               d[3] = {ray.direction.x, ray.direction.y, ray.direction.z};
  const double low[3] = {box.low.x, box.low.y, box.low.z}, high[3] = {box.high.x, box.high.y, box.high.z};
  double in = -1e300, out = 1e300;
  int axis = -1;
  for (int k = 0; k < 3; ++k) {
    if (d[k] == 0) {
      if (o[k] < low[k] || o[k] > high[k]) return false;
      continue;
    }
    const double a = (low[k] - o[k]) / d[k], b = (high[k] - o[k]) / d[k];
    if (std::min(a, b) > in) {
      in = std::min(a, b);
      axis = k;
    }
    out = std::min(out, std::max(a, b));
  }
  if (axis < 0 || in > out || in < range.low || in > range.high) return false;
  t = in;
  const double sign = d[axis] > 0 ? -1 : 1;
  normal = {axis == 0 ? sign : 0, axis == 1 ? sign : 0, axis == 2 ? sign : 0};
  return true;
}

}  // namespace

void Scene::add(const Object& object) {
  Body body;
  body.object = &object;
  // A hair around the box keeps rays that run along one of its faces.
  body.box = object.bounds();
  body.box.low = body.box.low - Vec3{0.01, 0.01, 0.01};
  body.box.high = body.box.high + Vec3{0.01, 0.01, 0.01};
  bodies_.push_back(body);
}

void Scene::add(const RayTree& mesh) {
  Body body;
  body.mesh = &mesh;
  bodies_.push_back(body);
}

void Scene::add(const Block& block) {
  Body body;
  body.box = block.box;
  body.from_box = block.frame;
  body.to_box = block.frame.inverse();
  bodies_.push_back(body);
}

Sight Scene::first(const Ray& ray, Interval range) const {
  Sight best;
  double last = range.high;
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const Body& body = bodies_[i];
    Sight sight;
    sight.body = static_cast<std::int32_t>(i);
    if (body.object != nullptr) {
      Interval inside = clip(ray, body.box);
      inside.low = std::max(inside.low, range.low);
      inside.high = std::min(inside.high, last);
      if (inside.low > inside.high) continue;
      sight.t = first_crossing(*body.object, ray, inside, 1);
      if (sight.t > inside.high) continue;
    } else if (body.mesh != nullptr) {
      const RayTree::Hit hit = body.mesh->first(ray, {range.low, last});
      if (hit.triangle == kNoTriangle) continue;
      sight.t = hit.t;
      sight.normal = body.mesh->normal(hit.triangle);
      if (dot(sight.normal, ray.direction) > 0) sight.normal = -sight.normal;
    } else {
      const Ray own{body.to_box.apply(ray.origin), body.to_box.turn(ray.direction)};
      if (!enter(own, body.box, {range.low, last}, sight.t, sight.normal)) continue;
      sight.normal = body.from_box.turn(sight.normal);
    }
    if (best.body >= 0 && !(sight.t < best.t)) continue;
    best = sight;
    last = sight.t;
  }
  if (best.body >= 0)
    if (const Object* object = bodies_[static_cast<std::size_t>(best.body)].object)
      best.normal = normal_at(*object, ray.at(best.t));
  return best;
}

}  // namespace scanmill::simulate
