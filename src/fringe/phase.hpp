// SPDX-License-Identifier: Apache-2.0
// N pictures of fringes, each shifted by an Nth of a period, to phases; phases of object and plate to a range map.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "fringe/optics.hpp"

namespace scanmill::fringe {

/// Rows of pixels from the top.
struct Picture {
  std::int64_t width = 0, height = 0;
  std::vector<std::uint16_t> pixels;
};

/// Pictures of one grating, in the order of the shifts: object and plate, as many of each, at least three.
struct Shifted {
  double period_mm = 0.5;  // on the plate
  std::vector<Picture> object, plate;
};

struct Quality {
  double min_visibility = 0.2;     // modulation over mean brightness: less is shadow or out of focus
  double min_modulation = 0.03;    // of white: less is too dark
  double max_disagreement = 0.35;  // turns by which a finer grating may miss what the coarser ones say
  static std::span<const Field> fields();
};

/// What is wrong with a pixel; the first that applies.
enum class Flaw : std::uint8_t { None, Saturated, Dark, Shadow, Ambiguous, OutOfBand };

struct RangeMap {
  std::int64_t width = 0, height = 0;
  std::vector<double> wrapped;    // object less plate by the finest grating, turns in [-0.5, 0.5); NaN where flawed
  std::vector<double> unwrapped;  // the same with its whole turns; NaN where flawed
  std::vector<float> visibility;  // of the object's fringes, the least over all gratings
  std::vector<Flaw> flaws;
  std::vector<Vec3> points;  // sensor frame; NaN where flawed
  std::size_t regions = 0;   // unwrapped each by itself; 0 where coarser gratings tell the turns
  std::uint64_t count(Flaw flaw) const;
};

/// Phase shift of a pixel's samples in turns in [-0.5, 0.5], I_k = A + B cos(2 pi (turns + k / N)), and A and B.
struct Wave {
  double turns = 0, mean = 0, modulation = 0;
};
Wave wave_of(std::span<const double> samples);

/// gratings  one, or several whose periods fall; the coarsest then spans the depth band within half a turn either way,
///           and each finer one is unwrapped by the one before it, pixel by pixel. A single grating is unwrapped along
///           neighbours, best visibility first (Su and Chen 2004), each region by itself from the turn nearest to the
///           plate: steps of more than half a turn are then lost.
/// white     greatest pixel value: pixels that reach it are saturated
/// errors    BadInput for pictures of different sizes, too few or unlike in number; BadParameter for optics that cannot
///           be, or a coarsest of several gratings that is too fine for the band
Result<RangeMap> range_map(const Optics& optics, std::span<const Shifted> gratings, std::uint16_t white,
                           const Quality& quality);

}  // namespace scanmill::fringe
