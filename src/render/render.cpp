// SPDX-License-Identifier: Apache-2.0
// From a scene to a drawing: what is seen, where it lands, which borders are lines; then tiles (raster) and lettering.
#include "render/render.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "base/text.hpp"
#include "render/colours.hpp"
#include "render/overlay.hpp"
#include "render/raster.hpp"

namespace scanmill::render {
namespace {

constexpr double kFarthest = 1e150;  // coordinates beyond: differences or their squares would not be finite
constexpr std::size_t kGrain = 65536;
constexpr std::size_t kMostThings = 1000000000;  // three times as many, the borders, still have 32-bit numbers

bool can_be_drawn(Vec3 p) {
  return std::abs(p.x) < kFarthest && std::abs(p.y) < kFarthest && std::abs(p.z) < kFarthest;
}

/// The scene as one style sees it, in the frame of the mesh (global less `offset`).
struct Subject {
  const Mesh* given = nullptr;   // of surfaces; null in style Points
  std::optional<Mesh> cleaned;   // in its place when triangles had to be left out
  std::span<const Vec3> points;  // of clouds
  Vec3 points_offset;            // to be taken off them
  std::uint64_t left_out = 0;    // points or triangles that are not finite
  const Mesh* mesh() const { return cleaned ? &*cleaned : given; }
};

Result<void> check(const Scene& scene, const PictureParams& params) {
  PictureParams copy = params;
  std::string problems;
  for (const std::string& line : problems_of(PictureParams::fields(), &copy))
    problems += (problems.empty() ? "" : "; ") + line;
  if (!problems.empty()) return fail(Code::BadParameter, problems, "picture");
  if (scene.points.size() + scene.removed.size() > kMostThings ||
      (scene.mesh != nullptr && scene.mesh->triangles.size() > kMostThings))
    return fail(Code::Unsupported, "more than a thousand million points or triangles; draw a sample", "picture");
  const std::size_t vertices = scene.mesh != nullptr ? scene.mesh->positions.size() : 0;
  if (params.style == Style::Error && scene.vertex_error.empty() && vertices > 0)
    return fail(Code::BadParameter,
                "as: error asks for a fit error per vertex and there is none; verify the mesh "
                "against its cloud first, or choose shaded",
                "picture");
  if (!scene.vertex_error.empty() && scene.vertex_error.size() != vertices)
    return fail(
        Code::BadInput,
        grouped(scene.vertex_error.size()) + " fit errors for " + grouped(vertices) + " vertices; give one per vertex",
        "picture");
  for (std::size_t t = 0; scene.mesh != nullptr && t < scene.mesh->triangles.size(); ++t)
    for (const std::uint32_t v : scene.mesh->triangles[t])
      if (v >= vertices)
        return fail(Code::BadInput,
                    "triangle " + grouped(t) + " names vertex " + grouped(v) + " of " + grouped(vertices) +
                        "; the mesh is broken",
                    "picture");
  return {};
}

Subject subject_of(const Scene& scene, Style style) {
  Subject s;
  if (style == Style::Points) {
    s.points = scene.points;
    if (scene.points.empty() && scene.mesh != nullptr)
      s.points = scene.mesh->positions;
    else if (scene.mesh != nullptr)
      s.points_offset = scene.mesh->offset;
    s.left_out = static_cast<std::uint64_t>(
        std::count_if(s.points.begin(), s.points.end(), [](Vec3 p) { return !can_be_drawn(p); }));
    return s;
  }
  if (scene.mesh == nullptr) return s;
  s.given = scene.mesh;
  const auto& p = scene.mesh->positions;
  if (std::all_of(p.begin(), p.end(), can_be_drawn)) return s;
  Mesh& kept = s.cleaned.emplace(*scene.mesh);
  kept.triangles.clear();
  kept.patch.clear();
  for (std::size_t t = 0; t < scene.mesh->triangles.size(); ++t) {
    const Triangle& v = scene.mesh->triangles[t];
    if (!can_be_drawn(p[v[0]]) || !can_be_drawn(p[v[1]]) || !can_be_drawn(p[v[2]])) {
      ++s.left_out;
      continue;
    }
    kept.triangles.push_back(v);
    if (t < scene.mesh->patch.size()) kept.patch.push_back(scene.mesh->patch[t]);
  }
  for (Vec3& q : kept.positions)
    if (!can_be_drawn(q)) q = {};
  return s;
}

/// Least and greatest of what is drawn: vertices of triangles, or points.
Extent extent_of(const Subject& s, View view) {
  Extent extent{axes_of(view), {}, {}};
  Bounds box;
  std::vector<std::uint8_t> used;  // vertices without a triangle are not seen
  if (s.mesh() != nullptr) {
    used.assign(s.mesh()->positions.size(), 0);
    for (const Triangle& t : s.mesh()->triangles)
      for (const std::uint32_t v : t) used[v] = 1;
  }
  const auto each = [&](auto&& take) {
    for (std::size_t v = 0; v < used.size(); ++v)
      if (used[v] != 0) take(s.mesh()->positions[v]);
    for (const Vec3 p : s.points)
      if (can_be_drawn(p)) take(p - s.points_offset);
  };
  each([&](Vec3 p) { box.add(p); });
  if (box.empty()) return extent;
  extent.anchor = box.low + box.size() * 0.5;
  each([&](Vec3 p) { extent.add(p); });
  return extent;
}

/// Removed points are part of what is seen as far as the part's own size around it.
std::uint64_t add_removed(std::span<const Vec3> removed, Vec3 offset, Extent& extent) {
  const Bounds part = extent.seen;
  std::uint64_t outside = 0;
  const Vec3 size = part.empty() ? Vec3{} : part.size();
  const double reach = std::max({size.x, size.y, size.z});
  for (const Vec3 p : removed) {
    if (!can_be_drawn(p)) {
      ++outside;
      continue;
    }
    Extent one{extent.axes, extent.anchor, {}};
    one.add(p - offset);
    const Vec3 at = one.seen.low;
    const bool near = part.empty() || (at.x >= part.low.x - reach && at.x <= part.high.x + reach &&
                                       at.y >= part.low.y - reach && at.y <= part.high.y + reach);
    if (near)
      extent.seen.add(at);
    else
      ++outside;
  }
  return outside;
}

Spot in_samples(const Spot& s) { return {s.x * kSamplesPerPixel, s.y * kSamplesPerPixel, s.depth * kSamplesPerPixel}; }

void place_corners(const Mesh& mesh, const Projection& project, Drawing& out, const Context& context) {
  out.corners.resize(mesh.positions.size());
  for_each_range(context, mesh.positions.size(), kGrain, [&](std::size_t b, std::size_t e) {
    constexpr double kGrid = static_cast<double>(kSamplesPerPixel) * kGridPerSample;
    const auto snapped = [](double v) {
      return static_cast<std::int32_t>(std::clamp(std::floor(v * kGrid + 0.5), -3e6, 3e6));
    };
    for (std::size_t v = b; v < e; ++v) {
      const Spot s = project(mesh.positions[v]);
      out.corners[v] = {snapped(s.x), snapped(s.y), static_cast<float>(s.depth * kSamplesPerPixel)};
    }
  });
  // One after the other: sums in the order of the triangles, 8 ms for 600,000.
  out.normals.assign(mesh.positions.size(), Vec3{});
  for (const Triangle& t : mesh.triangles) {
    const Vec3 a = (mesh.positions[t[0]] - project.centre) * project.px_per_mm,
               b = (mesh.positions[t[1]] - project.centre) * project.px_per_mm,
               c = (mesh.positions[t[2]] - project.centre) * project.px_per_mm;
    const Vec3 n = cross(b - a, c - a);
    for (const std::uint32_t v : t) out.normals[v] += n;
  }
  for_each_range(context, out.normals.size(), kGrain, [&](std::size_t b, std::size_t e) {
    for (std::size_t v = b; v < e; ++v) {
      const Vec3 n = out.normals[v];
      out.normals[v] = unit({dot(n, project.axes.right), dot(n, project.axes.up), dot(n, project.axes.toward)});
    }
  });
}

/// Edges without a single neighbour in red; where patches meet, dark.
void add_borders(const Mesh& mesh, const Projection& project, Style style, double pen, Drawing& out) {
  const auto across = edge_neighbours(mesh.positions.size(), mesh.triangles);
  const bool patches = style == Style::Patches && mesh.patch.size() == mesh.triangles.size();
  for (std::size_t h = 0; h < across.size(); ++h) {
    const std::size_t t = h / 3, e = h % 3;
    const bool open = across[h] == kNoTriangle;
    if (!open && !(patches && across[h] > t && mesh.patch[across[h]] != mesh.patch[t])) continue;
    const Triangle& v = mesh.triangles[t];
    const Spot a = in_samples(project(mesh.positions[v[e]])), b = in_samples(project(mesh.positions[v[(e + 1) % 3]]));
    // Lifted by twice the pen: on a surface that leans away by 60 degrees the whole width is still seen.
    out.lines.push_back({a, b, pen, 2 * pen + 1, open && style != Style::Error ? kBoundary : kInk});
  }
}

double mean_edge_px(const Mesh& mesh, const Projection& project) {
  double sum = 0;
  for (const Triangle& t : mesh.triangles) sum += norm(mesh.positions[t[1]] - mesh.positions[t[0]]);
  return sum / static_cast<double>(mesh.triangles.size()) * project.px_per_mm;
}

void add_surface(const Scene& scene, const Subject& s, const PictureParams& params, const Projection& project,
                 std::span<const double> scaled_error, const Context& context, Drawing& out) {
  const Mesh& mesh = *s.mesh();
  const double pixel = std::max(1.0, static_cast<double>(std::min(params.width, params.height)) / 800);
  out.mesh = &mesh;
  Surface& look = out.surface;
  look.front = params.style == Style::Wire ? Rgb{238, 242, 247} : kFront;
  look.back = params.style == Style::Wire ? Rgb{250, 226, 198} : kBack;
  if (params.style == Style::Patches) look.back = {140, 140, 140};
  if (params.style == Style::Error) {
    look.paint = Surface::Paint::Error;
    look.back = {140, 140, 140};
    look.error = scaled_error;
  } else if (params.style == Style::Patches) {
    look.paint = Surface::Paint::Patches;
  } else if (params.style == Style::Wire) {
    // Edges a few pixels apart would merge into a dark patch: they fade, and the shaded surface remains.
    look.wire_share = std::clamp(mean_edge_px(mesh, project) / 16, 0.1, 0.85);
  }
  place_corners(mesh, project, out, context);
  add_borders(mesh, project, params.style, (params.style == Style::Patches ? 1.3 : 1.5) * pixel, out);
  if (params.style != Style::Patches) return;
  for (const Vec3 seed : scene.seeds) {
    if (!can_be_drawn(seed)) continue;
    const Spot at = in_samples(project(seed - mesh.offset));
    const double radius = 7 * pixel;
    out.dots.push_back({at, radius, 1.5 * radius, kPaper});
    out.dots.push_back({at, radius - 2.4 * pixel, 1.5 * radius + 1, kInk});
  }
}

void add_points(const Scene& scene, const Subject& s, const Projection& project, const Extent& extent, Drawing& out) {
  const Vec3 seen = extent.seen.empty() ? Vec3{} : extent.seen.size();
  const double area = std::max(seen.x * project.px_per_mm, 40.0) * std::max(seen.y * project.px_per_mm, 40.0);
  // Wide enough to close a surface whose front and back cover the box; never so wide that single points lose their
  // place.
  const auto count = static_cast<double>(std::max<std::size_t>(s.points.size(), 1));
  const double radius = std::clamp(1.3 * std::sqrt(area / count), 0.75, 3.0) * kSamplesPerPixel;
  out.depth_shading = true;
  out.dots.reserve(s.points.size() + scene.removed.size());
  for (const Vec3 p : s.points)
    if (can_be_drawn(p)) out.dots.push_back({in_samples(project(p - s.points_offset)), radius, 0, kPointInk});
  for (const Vec3 p : scene.removed)
    if (can_be_drawn(p)) out.dots.push_back({in_samples(project(p - s.points_offset)), radius, 0, kRemoved});
}

std::vector<std::string> caption_of(const Subject& s, const PictureParams& params, std::uint64_t removed,
                                    std::uint64_t removed_of, std::uint64_t outside) {
  std::vector<std::string> lines;
  if (removed > 0) {
    lines.push_back(grouped(removed) + (removed_of > removed ? " of " + grouped(removed_of) : "") +
                    " removed points in red");
    if (outside > 0) lines.back() += ", " + grouped(outside) + " outside";
  }
  if (s.left_out > 0)
    lines.push_back(grouped(s.left_out) + (s.mesh() != nullptr ? " triangles" : " points") + " not finite, left out");
  const std::string view(view_words()[static_cast<std::size_t>(params.view)]);
  lines.push_back(params.view == View::Iso ? "isometric" : "seen from " + view);
  return lines;
}

std::string place_text(Vec3 p) {
  return "(" + number_text(p.x) + ", " + number_text(p.y) + ", " + number_text(p.z) + ") mm";
}

Result<Image> picture_of(const Scene& scene, const Subject& s, const PictureParams& params, const Context& context) {
  const int width = static_cast<int>(params.width), height = static_cast<int>(params.height);
  Image image(width, height, kPaper);
  const bool with_scale = params.style == Style::Error && s.mesh() != nullptr && !s.mesh()->triangles.empty();
  const double range = params.error_range_mm > 0 ? params.error_range_mm : automatic_error_range(scene.vertex_error);
  const Layout layout = layout_of(width, height, !params.title.empty(), with_scale ? range : 0);
  if (!params.title.empty()) draw_title(image, layout, params.title);

  Extent extent = extent_of(s, params.view);
  const bool nothing = extent.seen.empty();
  const std::uint64_t removed = params.style == Style::Points ? scene.removed.size() : 0;
  const std::uint64_t outside = removed > 0 ? add_removed(scene.removed, s.points_offset, extent) : 0;
  std::vector<std::string> caption = caption_of(s, params, removed, scene.removed_of, outside);
  const auto lettered = [&](std::vector<std::string> message) {
    draw_axes(image, layout, extent.axes);
    draw_caption(image, layout, caption);
    if (!message.empty()) draw_message(image, layout, message);
  };
  if (extent.seen.empty()) {
    lettered({params.style == Style::Points ? "nothing to draw: no finite point" : "nothing to draw: no triangle"});
    return image;
  }
  const Projection project = fit(extent, layout.part);
  if (norm2(extent.seen.size()) == 0 && !nothing)
    caption.insert(
        caption.begin(),
        "everything lies at " + place_text(s.mesh() != nullptr
                                               ? s.mesh()->positions[s.mesh()->triangles[0][0]] + s.mesh()->offset
                                               : extent.anchor + s.points_offset));

  std::vector<double> scaled(scene.vertex_error.begin(), scene.vertex_error.end());
  for (double& e : scaled) e /= range;
  Drawing drawing;
  if (s.mesh() != nullptr)
    add_surface(scene, s, params, project, scaled, context, drawing);
  else
    add_points(scene, s, project, extent, drawing);
  TRY(draw(drawing, image, context));
  draw_scale_bar(image, layout, project.px_per_mm);
  if (with_scale) draw_error_scale(image, layout, range);
  lettered({});
  return image;
}

}  // namespace

Result<Image> render(const Scene& scene, const PictureParams& params, const Context& context) {
  TRY(check(scene, params));
  const Subject subject = subject_of(scene, params.style);
  return picture_of(scene, subject, params, context);
}

}  // namespace scanmill::render
