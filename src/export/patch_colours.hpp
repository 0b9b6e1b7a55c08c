// SPDX-License-Identifier: Apache-2.0
// Colours of patches in CAD files: those of the pictures' patch view.
#pragma once
#include <array>
#include <cstdint>

namespace scanmill::exporting {

using PatchColour = std::array<std::uint8_t, 3>;  // red, green, blue

/// Three tints of ten colours; neighbouring numbers differ most.
PatchColour patch_colour(std::uint32_t patch);
/// The same with each channel in [0, 1].
std::array<double, 3> patch_colour_shares(std::uint32_t patch);

}  // namespace scanmill::exporting
