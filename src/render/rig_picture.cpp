// SPDX-License-Identifier: Apache-2.0
#include "render/rig_picture.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "render/camera.hpp"
#include "render/colours.hpp"
#include "render/overlay.hpp"
#include "render/raster.hpp"
#include "render/strokes.hpp"

namespace scanmill::render {
namespace {

constexpr double kFarthest = 1e9;  // mm; what lies beyond is not drawn

bool can_be_drawn(Vec3 p) {
  return std::abs(p.x) < kFarthest && std::abs(p.y) < kFarthest && std::abs(p.z) < kFarthest;
}

std::array<Vec3, 8> corners_of(const RigBody& body) {
  std::array<Vec3, 8> corners;
  for (std::size_t k = 0; k < 8; ++k)
    corners[k] = body.frame.apply(
        {k & 1 ? body.high.x : body.low.x, k & 2 ? body.high.y : body.low.y, k & 4 ? body.high.z : body.low.z});
  return corners;
}

/// All bodies as one mesh, a patch per body; corners are not shared between faces, so that faces are flat.
Mesh mesh_of(const std::vector<RigBody>& bodies) {
  constexpr std::size_t kFaces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                        {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  Mesh mesh;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const auto corners = corners_of(bodies[b]);
    if (!std::all_of(corners.begin(), corners.end(), can_be_drawn)) continue;
    for (const auto& face : kFaces) {
      const auto first = static_cast<std::uint32_t>(mesh.positions.size());
      for (const std::size_t c : face) mesh.positions.push_back(corners[c]);
      mesh.triangles.push_back({first, first + 1, first + 2});
      mesh.triangles.push_back({first, first + 2, first + 3});
      mesh.patch.insert(mesh.patch.end(), 2, static_cast<std::uint32_t>(b));
    }
  }
  return mesh;
}

Spot in_samples(const Spot& s) { return {s.x * kSamplesPerPixel, s.y * kSamplesPerPixel, s.depth * kSamplesPerPixel}; }

Extent extent_of(const RigScene& scene, View view) {
  Bounds box = scene.focus;
  if (box.empty()) {
    for (const RigBody& body : scene.bodies)
      for (const Vec3 p : corners_of(body))
        if (can_be_drawn(p)) box.add(p);
    for (const RigLine& line : scene.lines)
      for (const Vec3 p : line.points)
        if (can_be_drawn(p)) box.add(p);
    for (const Vec3 p : scene.points)
      if (can_be_drawn(p)) box.add(p);
  }
  Extent extent{axes_of(view), {}, {}};
  if (box.empty()) return extent;
  extent.anchor = box.low + box.size() * 0.5;
  for (std::size_t k = 0; k < 8; ++k)
    extent.add({k & 1 ? box.high.x : box.low.x, k & 2 ? box.high.y : box.low.y, k & 4 ? box.high.z : box.low.z});
  return extent;
}

/// Far outside the picture a line is cut, so that its ends stay on the grid.
bool clip_line(Spot& a, Spot& b, double width, double height) {
  const double low[2] = {-width, -height}, high[2] = {2 * width, 2 * height};
  const double from[2] = {a.x, a.y}, way[2] = {b.x - a.x, b.y - a.y};
  double begin = 0, end = 1;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    if (way[axis] == 0) {
      if (from[axis] < low[axis] || from[axis] > high[axis]) return false;
      continue;
    }
    const double t0 = (low[axis] - from[axis]) / way[axis], t1 = (high[axis] - from[axis]) / way[axis];
    begin = std::max(begin, std::min(t0, t1));
    end = std::min(end, std::max(t0, t1));
  }
  if (begin > end) return false;
  const Spot start = a, whole{b.x - a.x, b.y - a.y, b.depth - a.depth};
  a = {start.x + whole.x * begin, start.y + whole.y * begin, start.depth + whole.depth * begin};
  b = {start.x + whole.x * end, start.y + whole.y * end, start.depth + whole.depth * end};
  return true;
}

struct Panel {
  View view;
  const char* name;
};
constexpr Panel kPanels[] = {
    {View::Iso, "isometric"}, {View::MinusY, "front"}, {View::PlusZ, "top"}, {View::PlusX, "right side"}};

void add_bodies(const Mesh& mesh, const Projection& project, Drawing& drawing) {
  constexpr double kGrid = static_cast<double>(kSamplesPerPixel) * kGridPerSample;
  const auto snapped = [](double v) {
    return static_cast<std::int32_t>(std::clamp(std::floor(v * kGrid + 0.5), -3e6, 3e6));
  };
  for (const Vec3 p : mesh.positions) {
    const Spot s = project(p);
    drawing.corners.push_back({snapped(s.x), snapped(s.y), static_cast<float>(s.depth * kSamplesPerPixel)});
  }
  drawing.normals.assign(mesh.positions.size(), Vec3{});
  for (const Triangle& t : mesh.triangles) {
    const Vec3 n = cross(mesh.positions[t[1]] - mesh.positions[t[0]], mesh.positions[t[2]] - mesh.positions[t[0]]);
    for (const std::uint32_t v : t)
      drawing.normals[v] = unit({dot(n, project.axes.right), dot(n, project.axes.up), dot(n, project.axes.toward)});
  }
}

Result<Image> panel_of(const RigScene& scene, const Mesh& mesh, std::span<const Rgb> colours, const Panel& panel,
                       int width, int height, const Context& context) {
  Image image(width, height, kPaper);
  const Layout layout = layout_of(width, height, false, 0);
  const Projection project = fit(extent_of(scene, panel.view), layout.part);
  Drawing drawing;
  drawing.mesh = &mesh;
  drawing.surface.paint = Surface::Paint::Patches;
  drawing.surface.back = {140, 140, 140};
  drawing.surface.colours = colours;
  add_bodies(mesh, project, drawing);
  const double w = static_cast<double>(width) * kSamplesPerPixel, h = static_cast<double>(height) * kSamplesPerPixel;
  for (const RigLine& line : scene.lines)
    for (std::size_t i = 0; i + 1 < line.points.size(); ++i) {
      if (!can_be_drawn(line.points[i]) || !can_be_drawn(line.points[i + 1])) continue;
      Spot a = in_samples(project(line.points[i])), b = in_samples(project(line.points[i + 1]));
      if (!clip_line(a, b, w, h)) continue;
      drawing.lines.push_back({a, b, line.width_px * kSamplesPerPixel / 2, 1, line.colour});
    }
  const double area = std::max(1.0, layout.part.width * layout.part.height * 0.02);
  const double radius =
      std::clamp(std::sqrt(area / static_cast<double>(std::max<std::size_t>(scene.points.size(), 1))), 0.6, 2.0) *
      kSamplesPerPixel;
  for (const Vec3 p : scene.points) {
    if (!can_be_drawn(p)) continue;
    const Spot at = in_samples(project(p));
    if (at.x > -9 && at.y > -9 && at.x < w + 9 && at.y < h + 9) drawing.dots.push_back({at, radius, 0, kPointInk});
  }
  TRY(draw(drawing, image, context));
  for (const RigLabel& label : scene.labels) {
    if (!can_be_drawn(label.at)) continue;
    const Spot at = project(label.at);
    if (at.x < 0 || at.y < layout.text || at.x > width - 2 * layout.text || at.y > layout.strip.top) continue;
    draw_text(image, at.x + 0.5 * layout.text, at.y - 0.5 * layout.text, label.text, layout.text * 0.85, kInk);
  }
  draw_scale_bar(image, layout, project.px_per_mm);
  draw_axes(image, layout, project.axes);
  std::vector<std::string> caption;
  if (panel.view == View::Iso) caption = scene.caption;
  caption.push_back(panel.name);
  draw_caption(image, layout, caption);
  return image;
}

void copy_into(const Image& from, int left, int top, Image& to) {
  for (int y = 0; y < from.height; ++y)
    std::copy_n(from.at(0, y), static_cast<std::size_t>(from.width) * 3, to.at(left, top + y));
}

}  // namespace

Result<Image> draw_rig(const RigScene& scene, int width, int height, const Context& context) {
  if (width < 640 || height < 480 || width > 16384 || height > 16384)
    return fail(Code::BadParameter, "a picture of a rig is 640x480 to 16384x16384 pixels", "picture");
  Image image(width, height, kPaper);
  const double text = std::clamp(std::min(width, height) / 72.0, 8.0, 60.0);
  const int top = scene.title.empty() ? 0 : static_cast<int>(3.2 * text);
  if (!scene.title.empty())
    draw_text(image, 1.6 * text, 2.4 * text, text_within(scene.title, 1.15 * text, width - 3 * text), 1.15 * text,
              kInk);
  const Mesh mesh = mesh_of(scene.bodies);
  std::vector<Rgb> colours;
  for (const RigBody& body : scene.bodies) colours.push_back(body.colour);
  const int w = width / 2, h = (height - top) / 2;
  for (int n = 0; n < 4; ++n) {
    TRY_ASSIGN(const Image panel, panel_of(scene, mesh, colours, kPanels[n], w, h, context));
    copy_into(panel, n % 2 * w, top + n / 2 * h, image);
  }
  const double x = w, y = top + h;
  const std::array<Segment, 2> cross_lines{
      {{x, static_cast<double>(top), x, static_cast<double>(height)}, {0, y, static_cast<double>(width), y}}};
  draw_strokes(image, cross_lines, 1, {205, 208, 212});
  return image;
}

Result<Image> draw_timeline(std::span<const TimelineLane> lanes, std::span<const TimelineMark> marks,
                            const std::string& title, const std::string& abscissa, int width, int height) {
  if (width < 640 || height < 240 || width > 16384 || height > 16384)
    return fail(Code::BadParameter, "a timeline is 640x240 to 16384x16384 pixels", "picture");
  Image image(width, height, kPaper);
  const double t = std::clamp(width / 110.0, 8.0, 30.0);
  draw_text(image, 1.6 * t, 2.4 * t, text_within(title, 1.15 * t, width - 3 * t), 1.15 * t, kInk);
  double end = 0;
  for (const TimelineLane& lane : lanes)
    if (!lane.at.empty()) end = std::max(end, lane.at.back());
  for (const TimelineMark& mark : marks) end = std::max(end, mark.at);
  if (!(end > 0)) end = 1;
  const double left = 11 * t, right = width - 2 * t, top = 8 * t, bottom = height - 5 * t;
  const auto x_of = [&](double at) { return left + (right - left) * at / end; };
  double last_name = -1e9;
  for (const TimelineMark& mark : marks) {
    const double x = x_of(mark.at);
    draw_strokes(image, std::array<Segment, 1>{{{x, top - 0.6 * t, x, bottom}}}, 1, {214, 218, 224});
    const double size = 0.8 * t, wide = text_width(mark.text, size);
    if (x - wide / 2 < last_name + 0.8 * t || x + wide / 2 > width) continue;
    draw_text(image, x, top - 1.2 * t, mark.text, size, kFaintInk, Align::Middle);
    last_name = x + wide / 2;
  }
  const double lane_height = lanes.empty() ? 0 : (bottom - top) / static_cast<double>(lanes.size());
  for (std::size_t n = 0; n < lanes.size(); ++n) {
    const TimelineLane& lane = lanes[n];
    const double y0 = top + lane_height * static_cast<double>(n), y1 = y0 + lane_height;
    draw_strokes(image, std::array<Segment, 1>{{{left, y1, right, y1}}}, 1, {150, 154, 160});
    draw_text(image, left - t, (y0 + y1) / 2 + t / 2, lane.name, t, kInk, Align::Right);
    if (lane.value.empty()) continue;
    const auto [low, high] = std::minmax_element(lane.value.begin(), lane.value.end());
    const double span = *high > *low ? *high - *low : 1, pad = 0.14 * lane_height;
    const auto y_of = [&](double v) {
      return y1 - pad - (lane_height - 2 * pad) * (*high > *low ? (v - *low) / span : 0.5);
    };
    std::vector<Segment> curve;
    for (std::size_t i = 0; i + 1 < lane.at.size(); ++i)
      curve.push_back({x_of(lane.at[i]), y_of(lane.value[i]), x_of(lane.at[i + 1]), y_of(lane.value[i + 1])});
    draw_strokes(image, curve, std::max(1.6, t / 6), patch_colour(static_cast<std::uint32_t>(n)));
    const double step = rounded_down_125(span / 100);
    const double size = 0.75 * t;
    draw_text(image, left - 0.3 * t, y_of(*high) + size / 2, length_text(*high, step), size, kFaintInk, Align::Right);
    if (*high > *low)
      draw_text(image, left - 0.3 * t, y_of(*low) + size / 2, length_text(*low, step), size, kFaintInk, Align::Right);
  }
  const double tick = rounded_up_125(end / 12);
  for (double at = 0; at <= end * (1 + 1e-9); at += tick) {
    const double x = x_of(at);
    draw_strokes(image, std::array<Segment, 1>{{{x, bottom, x, bottom + 0.5 * t}}}, 1.2, kInk);
    draw_text(image, x, bottom + 1.9 * t, length_text(at, tick), 0.85 * t, kInk, Align::Middle);
  }
  draw_text(image, right, bottom + 3.6 * t, abscissa, 0.85 * t, kInk, Align::Right);
  return image;
}

}  // namespace scanmill::render
