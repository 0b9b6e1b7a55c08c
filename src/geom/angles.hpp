// SPDX-License-Identifier: Apache-2.0
// Angles by a fixed polynomial: only + - * / and sqrt, so the same bits on every machine (glibc's acos and atan2 differ
// between CPUs).
#pragma once
#include "geom/vec3.hpp"

namespace scanmill {

/// The angle in [0, 180] degrees whose sine and cosine stand in this proportion; sine >= 0; both zero give 0.
/// Off by less than 1e-13 degrees.
double degrees_of(double sine, double cosine);

/// The angle in [0, 180] degrees between two directions of any length; 0 when one is the zero vector. Accurate for
/// small and for flat angles.
double degrees_between(Vec3 u, Vec3 v);

/// The angle in [0, 180] degrees with this cosine; cosines beyond -1 and 1 count as -1 and 1. Off by less than 1e-9
/// degrees (near 0 and 180 that is of the cosine given; where two directions are at hand, degrees_between keeps more).
double acos_degrees(double cosine);

/// The angle in [0, 180] degrees between two unit vectors that are `chord` apart, clamped to [0, 2]; exact to rounding
/// for small angles, where the cosine has nothing left to tell.
double degrees_of_chord(double chord);

struct SineCosine {
  double sine = 0, cosine = 1;
};
/// Sine and cosine of an angle in degrees; exact at multiples of 90, elsewhere off by less than 2e-16. Reduction to
/// [-45, 45] degrees is exact (fmod), so whole turns change nothing.
SineCosine sine_cosine_of(double degrees);

}  // namespace scanmill
