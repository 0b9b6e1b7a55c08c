// SPDX-License-Identifier: Apache-2.0
// One view of a scene as a rig would take it: with all that goes wrong in one, drawn from a seed.
#pragma once
#include <cstdint>
#include <span>

#include "base/context.hpp"
#include "base/fields.hpp"
#include "cloud/sensor.hpp"
#include "simulate/scene.hpp"

namespace scanmill::simulate {

/// What the sensor's own numbers (field, pixels, depth band, noise, max_incidence_deg) do not say. As given here
/// nothing goes wrong. Everything is drawn from (seed, station, pixel, purpose).
struct Effects {
  double noise_by_incidence = 0;     // noise grows by this times (1 / cos(incidence) - 1)
  double dropout_from_deg = 90;      // from here to max_incidence_deg the share of lost returns grows to all, by cosine
  double outlier_share = 0;          // of the returns lie somewhere else on their ray
  double outlier_mm = 5;             // uniformly up to so far before or behind
  std::int64_t missing_patches = 0;  // round holes in every view, where nothing came back
  double missing_radius_mm = 2;      // at the stand-off
  double projector_mm = 0;  // the light comes from so far along +x of the camera; what it does not reach is not seen
  double station_mm = 0;    // each view is taken so far off its station, in some direction ...
  double station_deg = 0;   // ... and turned so much about some axis through the sensor's reference point
  static std::span<const Field> fields();
};

/// Counts of one view.
struct RigCounts {
  std::uint64_t returns = 0;   // pixels with a point
  std::uint64_t outliers = 0;  // of them
  std::uint64_t dropped = 0;   // lost at grazing incidence, below the sensor's limit
  std::uint64_t missing = 0;   // in holes
  std::uint64_t unlit = 0;     // seen by the camera, not by the projector
  std::uint64_t around = 0;    // of the returns: from bodies other than the first of the scene
};

struct RigView {
  RangeMap map;
  RigCounts counts;
  Pose pose;  // where the view was really taken from
};

/// The place of a view that was sent to `pose`.
Pose displaced(const Pose& pose, const Effects& effects, std::uint64_t seed);

/// As `scan` of object.hpp, and the same bits where `effects` is as given and the scene is that object alone.
/// pose  where the machine says the sensor is
/// errors  BadParameter when sensor or effects are out of their limits; Cancelled
/// cost  about 0.3 us a pixel over a mesh of 100,000 triangles, 2 us over the figurine
Result<RigView> take_view(const Scene& scene, const Sensor& sensor, const Effects& effects, const Pose& pose,
                          std::uint64_t seed, const Context& context);

}  // namespace scanmill::simulate
