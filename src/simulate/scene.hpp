// SPDX-License-Identifier: Apache-2.0
// What stands before the sensor: the object, a built-in solid or a mesh, and the bodies around it.
#pragma once
#include <cstdint>
#include <vector>

#include "simulate/object.hpp"
#include "simulate/ray_tree.hpp"

namespace scanmill::simulate {

/// A box in a frame of its own: the deck, the fixture.
struct Block {
  Pose frame;  // of the box -> global frame
  Bounds box;
};

/// What a ray meets first.
struct Sight {
  double t = 0;
  Vec3 normal;             // unit, outward; of meshes the side that the ray meets
  std::int32_t body = -1;  // in the order of adding; -1: nothing in range
};

/// Bodies given by reference must outlive the scene. Any thread may look.
class Scene {
 public:
  void add(const Object& object);
  void add(const RayTree& mesh);
  void add(const Block& block);

  /// The nearest body in `range`; at the same t the one added first.
  Sight first(const Ray& ray, Interval range) const;

 private:
  struct Body {
    const Object* object = nullptr;
    const RayTree* mesh = nullptr;
    Bounds box;
    Pose to_box;  // global frame -> that of the box; blocks only
    Pose from_box;
  };
  std::vector<Body> bodies_;
};

}  // namespace scanmill::simulate
