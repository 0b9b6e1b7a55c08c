// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <vector>

#include "render/colours.hpp"
#include "render/render.hpp"

namespace scanmill::render {
namespace {
constexpr std::string_view kStyles[] = {"points", "wire", "shaded", "patches", "error"};
constexpr std::string_view kViews[] = {"iso", "+x", "-x", "+y", "-y", "+z", "-z"};
}  // namespace

std::span<const std::string_view> style_words() { return kStyles; }
std::span<const std::string_view> view_words() { return kViews; }

std::span<const Field> PictureParams::fields() {
  using P = PictureParams;
  static const Field kTable[] = {
      field<P, &P::style>("as", "", "What the picture shows.", {}, kStyles),
      field<P, &P::view>("view", "", "The side the viewer stands on.", {}, kViews),
      field<P, &P::width>("width", "", "Width of the picture, pixels.", {320, 16384}),
      field<P, &P::height>("height", "", "Height of the picture, pixels.", {240, 16384}),
      field<P, &P::error_range_mm>(
          "error_range_mm", "",
          "Both ends of the error scale, mm; 0: the 99th percentile of the errors, rounded up to 1, 2 or 5.", {0, 1e6}),
  };
  return kTable;
}

double automatic_error_range(std::span<const double> errors) {
  std::vector<double> sizes;
  sizes.reserve(errors.size());
  for (const double e : errors)
    if (std::isfinite(e)) sizes.push_back(std::abs(e));
  if (sizes.empty()) return 0.001;
  const std::size_t rank = (sizes.size() - 1) * 99 / 100;
  std::nth_element(sizes.begin(), sizes.begin() + static_cast<std::ptrdiff_t>(rank), sizes.end());
  return rounded_up_125(sizes[rank]);
}

}  // namespace scanmill::render
