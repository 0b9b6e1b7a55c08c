// SPDX-License-Identifier: Apache-2.0
// Triangles, lines and dots to pixels: 2x2 samples per pixel, a depth per sample, tiles in parallel.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "base/context.hpp"
#include "base/result.hpp"
#include "mesh/mesh.hpp"
#include "render/camera.hpp"
#include "render/image.hpp"

namespace scanmill::render {

inline constexpr int kSamplesPerPixel = 2;  // on each axis
inline constexpr int kGridPerSample = 64;   // corners are snapped to this grid, so that neighbours meet without a gap

/// A vertex as the tiles see it; x and y in grid steps, depth in samples towards the viewer.
struct Corner {
  std::int32_t x = 0, y = 0;
  float depth = 0;
};

/// Round pen from a to b, in samples.
struct Line {
  Spot a, b;
  double half_width = 1;
  double lift = 0;  // nearer to the viewer than it is, so that the surface it lies on does not hide half of it
  Rgb colour;
};

struct Dot {
  Spot at;  // in samples
  double radius = 1, lift = 0;
  Rgb colour;
};

/// How the triangles look.
struct Surface {
  enum class Paint { Lit, Patches, Error };
  Paint paint = Paint::Lit;
  Rgb front, back;
  double wire_share = 0;          // 0: no edges drawn; 1: in full ink
  std::span<const double> error;  // per vertex, in units of the scale's range; Paint::Error
  std::span<const Rgb> colours;   // per patch number, in place of patch_colour; Paint::Patches
};

struct Drawing {
  const Mesh* mesh = nullptr;   // may be null
  std::vector<Corner> corners;  // per vertex of the mesh
  std::vector<Vec3> normals;    // per vertex, unit, in the axes of the view
  Surface surface;
  std::vector<Line> lines;
  std::vector<Dot> dots;
  bool depth_shading = false;  // darkens what lies just behind something else: gives clouds their shape
};

/// A sample whose centre lies on an edge belongs to the triangle whose top or left edge it is; of several things at one
/// sample the nearest shows, of equally near ones the first: triangles by number, then lines, then dots. Where nothing
/// is, the image keeps its colour. Cost: about 60 ns per triangle and 5 ns per covered sample.
/// errors  Cancelled
Result<void> draw(const Drawing& drawing, Image& image, const Context& context);

}  // namespace scanmill::render
