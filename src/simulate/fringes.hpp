// SPDX-License-Identifier: Apache-2.0
// Pictures that a camera takes of a scene under shifted fringes.
#pragma once
#include <cstdint>
#include <vector>

#include "base/context.hpp"
#include "cloud/sensor.hpp"
#include "fringe/phase.hpp"
#include "simulate/scene.hpp"

namespace scanmill::simulate {

/// What the sensor of the plan does not say. Lengths in mm.
struct FringeRig {
  double baseline_mm = 60;
  std::vector<double> periods_mm{16, 2, 0.5};  // 0.5: two line pairs a millimetre
  std::int64_t steps = 4, bits = 8;
  double noise_levels = 1;  // of brightness, in 255ths of white
  double visibility = 0.8;  // of the fringes in focus; they fade out within a tenth of the depth band behind it
};

/// The rig as the decoder sees it.
fringe::Optics optics_of(const Sensor& sensor, const FringeRig& rig);

/// Pictures by grating and shift: [g * steps + k]. Brightness falls with the cosine of the light's incidence; what the
/// projector does not reach has none but noise. Drawn from (seed, pixel).
/// errors  BadParameter when the sensor has parallel rays or numbers are out of their limits; Cancelled
Result<std::vector<fringe::Picture>> take_fringes(const Scene& scene, const Sensor& sensor, const FringeRig& rig,
                                                  const Pose& pose, std::uint64_t seed, const Context& context);
/// The same of the reference plate.
Result<std::vector<fringe::Picture>> take_plate(const Sensor& sensor, const FringeRig& rig, std::uint64_t seed,
                                                const Context& context);

}  // namespace scanmill::simulate
