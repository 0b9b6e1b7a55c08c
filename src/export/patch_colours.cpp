// SPDX-License-Identifier: Apache-2.0
#include "export/patch_colours.hpp"

#include <iterator>

namespace scanmill::exporting {
namespace {

constexpr PatchColour kColours[] = {{94, 164, 214}, {236, 152, 56},  {96, 184, 120}, {196, 118, 178}, {240, 216, 84},
                                    {208, 94, 72},  {126, 126, 196}, {150, 196, 64}, {164, 124, 92},  {112, 200, 200}};

}  // namespace

PatchColour patch_colour(std::uint32_t patch) {
  constexpr auto kCount = static_cast<std::uint32_t>(std::size(kColours));
  PatchColour colour = kColours[patch % kCount];
  const std::uint32_t tint = patch / kCount % 3;
  if (tint == 0) return colour;
  for (std::uint8_t& c : colour)
    c = tint == 1 ? static_cast<std::uint8_t>(c + (255 - c) * 2 / 5) : static_cast<std::uint8_t>(c * 4 / 5);
  return colour;
}

std::array<double, 3> patch_colour_shares(std::uint32_t patch) {
  const PatchColour colour = patch_colour(patch);
  return {colour[0] / 255.0, colour[1] / 255.0, colour[2] / 255.0};
}

}  // namespace scanmill::exporting
