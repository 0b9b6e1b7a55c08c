// SPDX-License-Identifier: Apache-2.0
// Two panels side by side, both axes in powers of ten.
#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>

#include "base/text.hpp"
#include "pipeline/scale_report.hpp"
#include "render/strokes.hpp"

namespace scanmill::pipeline {
namespace {

using render::Align;
using render::Image;
using render::Rgb;
using render::Segment;

constexpr int kCurveWidth = 1200, kCurveHeight = 550;
constexpr double kTop = 114, kBottom = 486, kText = 10, kSmall = 8;
constexpr Rgb kInk{34, 40, 49}, kGrid{222, 226, 231}, kPaper{255, 255, 255};
constexpr Rgb kCurves[] = {{31, 104, 173}, {214, 98, 34}, {52, 134, 72}, {141, 73, 160}, {120, 120, 120}};
constexpr Rgb kCap{176, 24, 48};
/// Pixels drawn and left out, by the place of the edge among those of the report; in one piece there are no gaps.
struct Dash {
  double on, off;
};
constexpr Dash kDashes[] = {{14, 7}, {3, 7}, {8, 5}, {24, 7}, {5, 12}, {16, 14}};

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

/// Runs that a curve joins.
struct Series {
  std::int64_t threads, bricks;
  Rgb colour;
  std::optional<Dash> dash;
};

/// The line in pieces; `walked` is what was walked of the dash and goes on into the next line of the curve.
void add_dashed(std::vector<Segment>& to, const Segment& line, const std::optional<Dash>& dash, double& walked) {
  if (!dash) return to.push_back(line);
  const double dx = line.x1 - line.x0, dy = line.y1 - line.y0, length = std::sqrt(dx * dx + dy * dy);
  for (double at = 0; at < length;) {
    const double into = std::fmod(walked, dash->on + dash->off);
    const bool is_on = into < dash->on;
    const double step = std::min(length - at, std::max(0.5, (is_on ? dash->on : dash->on + dash->off) - into));
    const double from = at / length, end = (at + step) / length;
    if (is_on) to.push_back({line.x0 + dx * from, line.y0 + dy * from, line.x0 + dx * end, line.y0 + dy * end});
    at += step;
    walked += step;
  }
}

using Value = std::function<double(const ScaleRun&)>;
double points_of(const ScaleRun& run) { return static_cast<double>(run.points); }
double mebibytes(std::uint64_t bytes) { return static_cast<double>(bytes) / (1 << 20); }

/// Of cut scans the dots are rings.
void draw_series(Image& image, const Panel& panel, const ScaleReport& report, const Series& series,
                 const Value& value) {
  std::vector<Segment> line, dots;
  const ScaleRun* last = nullptr;
  double walked = 0;
  for (const ScaleRun& run : report.runs) {
    if (run.threads != series.threads || run.bricks != series.bricks) continue;
    const double x = panel.px(points_of(run)), y = panel.py(value(run));
    dots.push_back({x, y, x, y});
    if (last) add_dashed(line, {panel.px(points_of(*last)), panel.py(value(*last)), x, y}, series.dash, walked);
    last = &run;
  }
  draw_strokes(image, line, 2, series.colour);
  draw_strokes(image, dots, 7, series.colour);
  if (series.dash) draw_strokes(image, dots, 3, kPaper);
}

void draw_cap(Image& image, const Panel& panel, double cap, const std::string& words) {
  const double y = panel.py(cap);
  draw_strokes(image, std::vector<Segment>{{panel.left, y, panel.right, y}}, 1.5, kCap);
  draw_text(image, panel.left + 8, y - 6, "cap " + words, kSmall, kCap);
}

/// Threads by colour; below, bricks by dash, unless all runs were in one piece.
void draw_legend(Image& image, const std::vector<Series>& all) {
  constexpr double kLeft = 700, kStep = 116, kThreads = 34, kBricks = 58, kSample = 34;
  std::vector<std::int64_t> threads, bricks;
  const bool is_cut = std::any_of(all.begin(), all.end(), [](const Series& s) { return s.bricks != 0; });
  for (const Series& series : all) {
    if (std::find(threads.begin(), threads.end(), series.threads) == threads.end()) {
      const double x = kLeft + kStep * static_cast<double>(threads.size());
      draw_strokes(image, std::vector<Segment>{{x, kThreads - 4, x + kSample, kThreads - 4}}, 3, series.colour);
      draw_text(image, x + kSample + 6, kThreads, counted(static_cast<std::uint64_t>(series.threads), "thread"), kSmall,
                kInk);
      threads.push_back(series.threads);
    }
    if (is_cut && std::find(bricks.begin(), bricks.end(), series.bricks) == bricks.end()) {
      const double x = kLeft + kStep * static_cast<double>(bricks.size());
      std::vector<Segment> sample;
      double walked = 0;
      add_dashed(sample, {x, kBricks - 4, x + kSample, kBricks - 4}, series.dash, walked);
      draw_strokes(image, sample, 2, kInk);
      draw_text(image, x + kSample + 6, kBricks,
                series.bricks == 0 ? "one piece" : "bricks " + std::to_string(series.bricks), kSmall, kInk);
      bricks.push_back(series.bricks);
    }
  }
}

/// In the order of the runs.
std::vector<Series> series_of(const ScaleReport& report) {
  std::vector<std::int64_t> threads, edges;
  const auto place_of = [](std::vector<std::int64_t>& seen, std::int64_t value) {
    const auto at = std::find(seen.begin(), seen.end(), value);
    const auto place = static_cast<std::size_t>(at - seen.begin());
    if (at == seen.end()) seen.push_back(value);
    return place;
  };
  std::vector<Series> all;
  for (const ScaleRun& run : report.runs) {
    if (std::any_of(all.begin(), all.end(),
                    [&](const Series& s) { return s.threads == run.threads && s.bricks == run.bricks; }))
      continue;
    Series series{run.threads, run.bricks, kCurves[place_of(threads, run.threads) % std::size(kCurves)], {}};
    if (run.bricks != 0) series.dash = kDashes[place_of(edges, run.bricks) % std::size(kDashes)];
    all.push_back(series);
  }
  return all;
}

}  // namespace

Image scale_picture(const ScaleReport& report) {
  Image image(kCurveWidth, kCurveHeight, kPaper);
  if (report.runs.empty()) return image;
  const Value rate = [](const ScaleRun& run) { return run.points_per_cpu_s(); };
  const Value memory = [](const ScaleRun& run) { return mebibytes(run.peak_bytes); };
  const double cap = mebibytes(parse_size(report.memory).value_or(0));  // 0: none was given
  const auto axis = [&](const Value& value, double more) {              // more: shown as well unless 0
    double least = 1e300, most = more;
    for (const ScaleRun& run : report.runs) {
      least = std::min(least, value(run));
      most = std::max(most, value(run));
    }
    return Axis::over(more > 0 ? std::min(least, more) : least, most);
  };
  draw_text(image, 40, 34,
            "scanmill " + report.version + ", whole job, " + number_text(report.per_bin) + " points a bin, memory " +
                (report.memory.empty() ? "by default" : report.memory),
            12, kInk);
  const Axis size = axis(points_of, 0);
  const Panel panels[] = {{100, 560, size, axis(rate, 0)}, {700, 1160, size, axis(memory, cap)}};
  draw_frame(image, panels[0], "points per CPU second", "");
  draw_frame(image, panels[1], "peak memory of all processes", " MiB");
  if (cap > 0) draw_cap(image, panels[1], cap, report.memory);
  const std::vector<Series> all = series_of(report);
  for (const Series& series : all) {
    draw_series(image, panels[0], report, series, rate);
    draw_series(image, panels[1], report, series, memory);
  }
  draw_legend(image, all);
  return image;
}

}  // namespace scanmill::pipeline
