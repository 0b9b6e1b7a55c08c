// SPDX-License-Identifier: Apache-2.0
#include "report/histogram.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <numeric>

#include "base/text.hpp"
#include "report/html.hpp"
#include "report/numbers.hpp"

namespace scanmill::report {
namespace {

// The drawing's own units; the page scales it.
constexpr double kWidth = 720, kHeight = 270, kLeft = 70, kRight = 14, kTop = 16, kBottom = 52;
constexpr double kShareShown = 0.999;

struct Window {
  std::size_t first = 0, last = 0;  // steps, end excluded
  std::uint64_t below = 0, above = 0;
};

/// Grows from zero outwards on both sides alike until the share is reached; eight steps a side at least.
Window window_of(const Histogram& h, std::uint64_t total) {
  const auto steps = static_cast<std::int64_t>(h.counts.size());
  const auto zero =
      std::clamp<std::int64_t>(static_cast<std::int64_t>(std::floor(-h.low_mm / h.step_mm + 0.5)), 0, steps);
  std::int64_t reach = 0;
  std::uint64_t inside = 0;
  const auto wanted = static_cast<std::uint64_t>(static_cast<double>(total) * kShareShown);
  while (reach < std::max(zero, steps - zero) && (inside < wanted || reach < 8)) {
    if (zero + reach < steps) inside += h.counts[static_cast<std::size_t>(zero + reach)];
    ++reach;
    if (zero - reach >= 0) inside += h.counts[static_cast<std::size_t>(zero - reach)];
  }
  Window w;
  w.first = static_cast<std::size_t>(std::max<std::int64_t>(0, zero - reach));
  w.last = static_cast<std::size_t>(std::min(steps, zero + reach));
  const auto sum = [&](std::size_t from, std::size_t to) {
    return std::accumulate(h.counts.begin() + static_cast<std::ptrdiff_t>(from),
                           h.counts.begin() + static_cast<std::ptrdiff_t>(to), std::uint64_t{0});
  };
  w.below = h.below + sum(0, w.first);
  w.above = h.above + sum(w.last, h.counts.size());
  return w;
}

std::string number(double v) {
  char buffer[48];
  return {buffer, std::to_chars(buffer, buffer + sizeof buffer, v, std::chars_format::fixed, 2).ptr};
}

/// 1, 2, 5 times a power of ten, not below `value` (> 0).
double step_125(double value) {
  double power = 1;
  while (power > value) power /= 10;
  while (power * 10 <= value) power *= 10;
  for (const double digit : {1.0, 2.0, 5.0})
    if (digit * power >= value) return digit * power;
  return 10 * power;
}

/// Free of the rest of binary fractions: -0.30000000000000004 is "-0.3".
std::string tick_text(double value) {
  char buffer[48];
  double shown = 0;
  const char* end = std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::general, 6).ptr;
  std::from_chars(buffer, end, shown);
  return (value > 0 ? "+" : "") + number_text(shown);
}

std::string line(double x0, double y0, double x1, double y1, const char* style) {
  return "<line x1=\"" + number(x0) + "\" y1=\"" + number(y0) + "\" x2=\"" + number(x1) + "\" y2=\"" + number(y1) +
         "\" " + style + "/>\n";
}

std::string label(double x, double y, const char* anchor, const std::string& text) {
  return "<text x=\"" + number(x) + "\" y=\"" + number(y) + "\" text-anchor=\"" + anchor + "\">" + escaped(text) +
         "</text>\n";
}

}  // namespace

std::string histogram_figure(const Histogram& h, std::optional<double> limit_mm) {
  const std::uint64_t total = std::accumulate(h.counts.begin(), h.counts.end(), h.below + h.above);
  if (h.counts.empty() || total == 0 || !(h.step_mm > 0) || !std::isfinite(h.low_mm)) return {};
  const Window w = window_of(h, total);
  const double low = h.low_mm + static_cast<double>(w.first) * h.step_mm;
  const double high = h.low_mm + static_cast<double>(w.last) * h.step_mm;
  const double right = kWidth - kRight, bottom = kHeight - kBottom, plot = right - kLeft, tall = bottom - kTop;
  const auto x_of = [&](double mm) { return kLeft + (mm - low) / (high - low) * plot; };
  std::uint64_t most = 1;
  for (std::size_t i = w.first; i < w.last; ++i) most = std::max(most, h.counts[i]);
  const double count_step = std::max(1.0, step_125(static_cast<double>(most) / 4));
  const double top_count = std::ceil(static_cast<double>(most) / count_step) * count_step;
  const auto y_of = [&](double count) { return bottom - count / top_count * tall; };

  std::string svg = "<svg viewBox=\"0 0 720 270\" role=\"img\" aria-label=\"Histogram of signed distances of " +
                    grouped(total) + " points, " + escaped(figure(low)) + " to " + escaped(figure(high)) +
                    " mm\" font-size=\"13\" font-family=\"sans-serif\" fill=\"#1f2328\">\n";
  for (double count = 0; count <= top_count * 1.0001; count += count_step) {
    svg += line(kLeft, y_of(count), right, y_of(count), "stroke=\"#d5dae0\"");
    svg += label(kLeft - 6, y_of(count) + 4.5, "end", grouped(static_cast<std::uint64_t>(count + 0.5)));
  }
  for (std::size_t i = w.first; i < w.last; ++i) {
    if (h.counts[i] == 0) continue;
    const double from = h.low_mm + static_cast<double>(i) * h.step_mm;
    const double x = x_of(from), y = y_of(static_cast<double>(h.counts[i]));
    const double width = std::max(0.5, x_of(from + h.step_mm) - x - 0.5);
    const bool negative = from + h.step_mm / 2 < 0;
    svg += "<rect x=\"" + number(x) + "\" y=\"" + number(y) + "\" width=\"" + number(width) + "\" height=\"" +
           number(bottom - y) + "\" fill=\"" + (negative ? "#3f7fc0" : "#cf6a4c") + "\"><title>" +
           escaped(signed_figure(from) + " to " + signed_figure(from + h.step_mm) + " mm: " + grouped(h.counts[i])) +
           "</title></rect>\n";
  }
  const double tick = step_125((high - low) / 9);
  for (double n = std::ceil(low / tick - 1e-9); n * tick <= high + tick * 1e-9; n += 1) {
    svg += line(x_of(n * tick), bottom, x_of(n * tick), bottom + 5, "stroke=\"#1f2328\"");
    svg += label(x_of(n * tick), bottom + 20, "middle", n == 0 ? "0" : tick_text(n * tick));
  }
  svg += line(kLeft, bottom, right, bottom, "stroke=\"#1f2328\" stroke-width=\"1.5\"");
  if (low < 0 && high > 0) svg += line(x_of(0), kTop, x_of(0), bottom, "stroke=\"#1f2328\" stroke-width=\"0.8\"");
  if (limit_mm && *limit_mm > 0)
    for (const double at : {-*limit_mm, *limit_mm})
      if (at > low && at < high)
        svg +=
            line(x_of(at), kTop, x_of(at), bottom, "stroke=\"#1f2328\" stroke-width=\"1.2\" stroke-dasharray=\"6 4\"");
  svg += label((kLeft + right) / 2, kHeight - 10, "middle",
               "distance of a point from the mesh, mm (- inside, + outside); points per " + figure(h.step_mm) + " mm");
  svg += "</svg>\n";

  std::string caption = "Signed distances of " + grouped(total) + " points.";
  if (w.below + w.above > 0)
    caption += " Not shown: " + grouped(w.below) + " below " + figure(low) + " mm, " + grouped(w.above) + " above " +
               signed_figure(high) + " mm.";
  if (limit_mm && *limit_mm > 0)
    caption += *limit_mm < std::max(-low, high) ? " Dashed: the gate at " + figure(*limit_mm) + " mm."
                                                : " The gate at " + figure(*limit_mm) + " mm lies outside.";
  return "<figure class=\"chart\">\n" + svg + "<figcaption>" + escaped(caption) + "</figcaption></figure>\n";
}

}  // namespace scanmill::report
