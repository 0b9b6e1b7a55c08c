// SPDX-License-Identifier: Apache-2.0
// Pictures of clouds and meshes without a display: the same bytes on every machine and thread count.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "base/context.hpp"
#include "base/fields.hpp"
#include "base/result.hpp"
#include "mesh/mesh.hpp"
#include "render/camera.hpp"
#include "render/image.hpp"
#include "render/png.hpp"

namespace scanmill::render {

/// Points: measured points (without any, the mesh's vertices), shaded by what stands before them; removed ones red.
/// Wire: every edge over a light surface that hides what is behind it.
/// Shaded: outside blue-grey, inside orange, so that holes and turned triangles show; edges that do not join two
/// triangles red.
/// Patches: a colour per patch number, borders dark, seeds as black dots.
/// Error: the signed fit error per vertex, blue (inside) over white to red (outside), with a scale.
enum class Style : std::int32_t { Points, Wire, Shaded, Patches, Error };

/// What there is to draw; nothing is copied. For a cloud that memory does not hold give a sample.
struct Scene {
  const Mesh* mesh = nullptr;
  std::span<const Vec3> points;          // global frame, mm
  std::span<const Vec3> removed;         // global frame, mm; style Points only
  std::span<const double> vertex_error;  // mm, per vertex of the mesh; NaN where none is known
  std::span<const Vec3> seeds{};         // global frame, mm; style Patches only
  std::uint64_t removed_of = 0;          // `removed` is a sample of so many; 0: it is all
};

struct PictureParams {
  Style style = Style::Shaded;
  View view = View::Iso;
  std::int64_t width = 1280, height = 960;  // pixels
  double error_range_mm = 0;  // both ends of the error scale; 0: the 99th percentile, rounded up to 1, 2, 5
  std::string title;          // UTF-8; shortened to fit
  static std::span<const Field> fields();  // all but the title
};

/// The words of the job and the command line, by number.
std::span<const std::string_view> style_words();
std::span<const std::string_view> view_words();

/// The part as large as the picture allows, below it a scale bar in mm and the axes. What cannot be drawn (no triangle,
/// no finite point) gives a picture that says so. Points that are not finite are left out, and triangles at vertices
/// that are not. Removed points farther from the part than its own size do not shrink it: they are left out and counted
/// in the picture.
/// errors  BadParameter for a size outside 320x240 .. 16384x16384, a range that is negative or not finite, style Error
///         without errors; BadInput naming a triangle whose vertex does not exist; Unsupported above 1e9 things;
///         Cancelled
/// cost    600,000 triangles in 1280x960: 0.4 CPU s; about 60 bytes per vertex, 16 per triangle, 64 per point
Result<Image> render(const Scene& scene, const PictureParams& params, const Context& context);

/// The range that `error_range_mm` 0 stands for; 0.001 when no error is finite or all are zero.
double automatic_error_range(std::span<const double> errors);

}  // namespace scanmill::render
