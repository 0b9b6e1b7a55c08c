// SPDX-License-Identifier: Apache-2.0
// Two panels side by side, both axes in powers of ten.
#include <algorithm>
#include <cmath>
#include <functional>

#include "base/text.hpp"
#include "pipeline/scale_report.hpp"
#include "render/strokes.hpp"

namespace scanmill::pipeline {
namespace {

using render::Align;
using render::Image;
using render::Rgb;
using render::Segment;

constexpr int kCurveWidth = 1200, kCurveHeight = 520;
constexpr double kTop = 84, kBottom = 456, kText = 10, kSmall = 8;
constexpr Rgb kInk{34, 40, 49}, kGrid{222, 226, 231}, kPaper{255, 255, 255};
constexpr Rgb kCurves[] = {{31, 104, 173}, {214, 98, 34}, {52, 134, 72}, {141, 73, 160}, {120, 120, 120}};

/// From decade to decade.
struct Axis {
  int low = 0, high = 1;  // powers of ten
  static Axis over(double least, double most) {
    const int low = static_cast<int>(std::floor(std::log10(std::max(least, 1e-9)) + 1e-9));
    return {low, std::max(low + 1, static_cast<int>(std::ceil(std::log10(std::max(most, 1e-9)) - 1e-9)))};
  }
  double share(double value) const { return (std::log10(std::max(value, 1e-9)) - low) / (high - low); }
};

struct Panel {
  double left, right;
  Axis x, y;
  double px(double value) const { return left + (right - left) * x.share(value); }
  double py(double value) const { return kBottom - (kBottom - kTop) * y.share(value); }
};

double power_of_ten(int power) {
  double value = 1;
  for (; power > 0; --power) value *= 10;
  for (; power < 0; ++power) value /= 10;
  return value;
}

std::string decade_text(int power) {
  constexpr const char* kUnits[] = {"", " k", " M", " G", " T"};
  if (power < 0 || power > 14) return "1e" + std::to_string(power);
  return std::to_string(static_cast<int>(power_of_ten(power % 3))) + kUnits[power / 3];
}

void draw_frame(Image& image, const Panel& panel, const std::string& title, const std::string& unit) {
  std::vector<Segment> grid, frame;
  for (int p = panel.x.low; p <= panel.x.high; ++p) {
    const double x = panel.px(power_of_ten(p));
    grid.push_back({x, kTop, x, kBottom});
    draw_text(image, x, kBottom + 20, decade_text(p), kSmall, kInk, Align::Middle);
  }
  for (int p = panel.y.low; p <= panel.y.high; ++p) {
    const double y = panel.py(power_of_ten(p));
    grid.push_back({panel.left, y, panel.right, y});
    draw_text(image, panel.left - 8, y + kSmall / 2, decade_text(p) + unit, kSmall, kInk, Align::Right);
  }
  draw_strokes(image, grid, 1, kGrid);
  frame = {{panel.left, kTop, panel.left, kBottom}, {panel.left, kBottom, panel.right, kBottom}};
  draw_strokes(image, frame, 1.5, kInk);
  draw_text(image, panel.left, kTop - 14, title, kText, kInk);
  draw_text(image, (panel.left + panel.right) / 2, kBottom + 44, "points", kText, kInk, Align::Middle);
}

}  // namespace

Image scale_picture(const ScaleReport& report) {
  Image image(kCurveWidth, kCurveHeight, kPaper);
  if (report.runs.empty()) return image;
  using Value = std::function<double(const ScaleRun&)>;
  const Value points = [](const ScaleRun& run) { return static_cast<double>(run.points); };
  const Value rate = [](const ScaleRun& run) { return run.points_per_cpu_s(); };
  const Value megabytes = [](const ScaleRun& run) { return static_cast<double>(run.peak_bytes) / (1 << 20); };
  const auto axis = [&](const Value& value) {
    double least = 1e300, most = 0;
    for (const ScaleRun& run : report.runs) {
      least = std::min(least, value(run));
      most = std::max(most, value(run));
    }
    return Axis::over(least, most);
  };
  std::vector<std::int64_t> threads;
  for (const ScaleRun& run : report.runs)
    if (std::find(threads.begin(), threads.end(), run.threads) == threads.end()) threads.push_back(run.threads);
  draw_text(image, 40, 34,
            "scanmill " + report.version + ", whole job, " + number_text(report.per_bin) + " points a bin, memory " +
                (report.memory.empty() ? "by default" : report.memory),
            12, kInk);
  const Panel panels[] = {{100, 560, axis(points), axis(rate)}, {700, 1160, axis(points), axis(megabytes)}};
  const Value values[] = {rate, megabytes};
  draw_frame(image, panels[0], "points per CPU second", "");
  draw_frame(image, panels[1], "peak memory of all processes", " MiB");
  for (std::size_t curve = 0; curve < threads.size(); ++curve) {
    const Rgb colour = kCurves[curve % std::size(kCurves)];
    for (std::size_t p = 0; p < 2; ++p) {
      std::vector<Segment> line, dots;
      const ScaleRun* last = nullptr;
      for (const ScaleRun& run : report.runs) {
        if (run.threads != threads[curve]) continue;
        const double x = panels[p].px(points(run)), y = panels[p].py(values[p](run));
        dots.push_back({x, y, x, y});
        if (last) line.push_back({panels[p].px(points(*last)), panels[p].py(values[p](*last)), x, y});
        last = &run;
      }
      draw_strokes(image, line, 2, colour);
      draw_strokes(image, dots, 7, colour);
    }
    const double x = 700 + 110 * static_cast<double>(curve), y = 34;
    draw_strokes(image, std::vector<Segment>{{x, y - 4, x + 18, y - 4}}, 3, colour);
    draw_text(image, x + 24, y, counted(static_cast<std::uint64_t>(threads[curve]), "thread"), kSmall, kInk);
  }
  return image;
}

}  // namespace scanmill::pipeline
