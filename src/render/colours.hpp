// SPDX-License-Identifier: Apache-2.0
// The colours of all pictures, chosen so that nothing rests on telling red from green.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "render/image.hpp"

namespace scanmill::render {

inline constexpr Rgb kPaper{255, 255, 255};
inline constexpr Rgb kInk{34, 38, 44};
inline constexpr Rgb kFaintInk{110, 116, 124};
inline constexpr Rgb kFront{186, 200, 216};     // outside of the surface: blue-grey
inline constexpr Rgb kBack{226, 140, 48};       // inside: orange
inline constexpr Rgb kBoundary{205, 0, 30};     // edges with one triangle
inline constexpr Rgb kPointInk{104, 148, 196};  // measured points
inline constexpr Rgb kRemoved{214, 40, 40};     // points taken out
inline constexpr Rgb kUnknown{176, 176, 176};   // vertices without an error

/// Three tints of ten colours; neighbouring numbers differ most.
Rgb patch_colour(std::uint32_t patch);

/// Blue (-1) over white (0) to red (+1), linear between few stops; beyond both ends a darker shade of its own.
class ErrorScale {
 public:
  ErrorScale();
  /// t in units of the range; NaN gives kUnknown
  Rgb at(double t) const;
  static constexpr Rgb kBelow{32, 16, 84}, kAbove{84, 0, 22};

 private:
  static constexpr int kSteps = 512;
  std::array<Rgb, 2 * kSteps + 1> table_;
};

/// The least of 1, 2, 5 times a power of ten that is not below `value`; 0.001 for values that are not positive.
double rounded_up_125(double value);
/// The greatest of them that is not above `value` (> 0).
double rounded_down_125(double value);

}  // namespace scanmill::render
