// SPDX-License-Identifier: Apache-2.0
// Angles for reports by fixed polynomials, so the same bits on every machine (glibc's acos differs between CPUs).
#pragma once

namespace scanmill {

/// Angle in [0, 180] degrees whose cosine is `cosine`, clamped to [-1, 1]; off by less than 1e-9 degrees.
double acos_degrees(double cosine);

/// Angle in [0, 180] degrees between two unit vectors that are `chord` apart, clamped to [0, 2]; off by less than 1e-9
/// degrees, and exact to rounding for small angles, where the cosine has nothing left to tell.
double degrees_of_chord(double chord);

}  // namespace scanmill
