// SPDX-License-Identifier: Apache-2.0
// A triangle covers a sample when three integer edge functions agree (Pineda 1988), with the top-left rule on a grid of
// 1/64 sample: watertight and the same on every machine. First depth alone decides which triangle each sample shows,
// then what is seen gets its colour: once per pixel where all four samples show one triangle. Depth and light are
// planes over the triangle, from the same corner whatever the tile, so tiles and threads leave no trace. Depth shading
// darkens a sample by how far its neighbours stand before it (after Boucheny 2009, with a rational falloff in place of
// the exponential).
#include "render/raster.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <optional>
#include <span>
#include <utility>

#include "base/wide.hpp"
#include "render/colours.hpp"

namespace scanmill::render {
namespace {

constexpr int kTilePixels = 64;
constexpr int kTileSamples = kTilePixels * kSamplesPerPixel;
constexpr float kNothing = -std::numeric_limits<float>::max();
// Reach of the depth shading, in samples; tiles are drawn this much larger so that they need no neighbour.
constexpr int kApron = 4;
constexpr double kCreaseDot = 0.8;              // normals further apart than 37 degrees are not smoothed over
const Vec3 kLight = unit({-0.42, 0.52, 0.74});  // in the axes of the view: over the viewer's left shoulder

constexpr std::uint32_t kNoFace = 0xffffffffu;

struct Packed {
  std::uint8_t r = 255, g = 255, b = 255, covered = 0;
};

/// The samples of a tile; (0, 0) is sample (x0, y0) of the picture.
struct Tile {
  int x0 = 0, y0 = 0, width = 0, height = 0;
  std::vector<float> depth;
  std::vector<std::uint32_t> face;  // place in the tile's list of what each sample shows, unless `colour` covers it
  std::vector<Packed> colour;       // of lines and dots, and of everything with depth shading; empty without any
  std::size_t row(int y) const { return static_cast<std::size_t>(y) * static_cast<std::size_t>(width); }
};

struct Range {
  int x0, y0, x1, y1;  // tiles or samples, end excluded
  bool empty() const { return x0 >= x1 || y0 >= y1; }
};

/// Largest whole number not above a / 2^bits; C++20 shifts keep the sign.
constexpr int floor_shift(int a, int bits) { return a >> bits; }
constexpr int kGridBits = 6, kTileBits = 7;
static_assert(kGridPerSample == 1 << kGridBits && kTileSamples == 1 << kTileBits);

/// Samples whose centres may lie in the box of a triangle.
Range samples_of(const Corner& a, const Corner& b, const Corner& c) {
  const auto [x0, x1] = std::minmax({a.x, b.x, c.x});
  const auto [y0, y1] = std::minmax({a.y, b.y, c.y});
  constexpr int kHalf = kGridPerSample / 2;
  return {floor_shift(x0 + kHalf - 1, kGridBits), floor_shift(y0 + kHalf - 1, kGridBits),
          floor_shift(x1 - kHalf, kGridBits) + 1, floor_shift(y1 - kHalf, kGridBits) + 1};
}

/// Saturating: whatever lies outside the picture stays outside.
int to_sample(double v) { return static_cast<int>(std::clamp(std::floor(v), -1e6, 1e6)); }

Range samples_around(const Spot& a, const Spot& b, double reach) {
  return {to_sample(std::min(a.x, b.x) - reach), to_sample(std::min(a.y, b.y) - reach),
          to_sample(std::max(a.x, b.x) + reach) + 1, to_sample(std::max(a.y, b.y) + reach) + 1};
}

Range clipped(const Range& r, const Tile& tile) {
  return {std::max(r.x0 - tile.x0, 0), std::max(r.y0 - tile.y0, 0), std::min(r.x1 - tile.x0, tile.width),
          std::min(r.y1 - tile.y0, tile.height)};
}

std::uint8_t shaded(double channel, double light) {
  const double value = channel * light + 0.5;
  return static_cast<std::uint8_t>(value < 255 ? value : 255);
}

/// 0.34 in the dark, 1.06 where the light stands upright; soft where the surface turns away.
double brightness(Vec3 normal) {
  const double wrapped = 0.5 + 0.5 * dot(normal, kLight);
  return 0.34 + 0.72 * wrapped * wrapped;
}

// --- triangles ---------------------------------------------------------------------------------------------------

struct Edge {
  std::int64_t start, step_x, step_y;  // value at the first sample of the box, and from there
};

/// Positive on the inside; zero counts for top and left edges only (by one step of the integer).
Edge edge_over(const Corner& a, const Corner& b, int x, int y) {
  const std::int64_t dx = b.x - a.x, dy = b.y - a.y;
  const std::int64_t px = static_cast<std::int64_t>(x) * kGridPerSample + kGridPerSample / 2 - a.x;
  const std::int64_t py = static_cast<std::int64_t>(y) * kGridPerSample + kGridPerSample / 2 - a.y;
  const bool top_left = dy < 0 || (dy == 0 && dx > 0);
  return {dx * py - dy * px - (top_left ? 0 : 1), -dy * kGridPerSample, dx * kGridPerSample};
}

std::int64_t doubled_area(const Corner& a, const Corner& b, const Corner& c) {
  return static_cast<std::int64_t>(b.x - a.x) * (c.y - a.y) - static_cast<std::int64_t>(b.y - a.y) * (c.x - a.x);
}

/// Values at the corners as a plane over the samples of the tile.
struct Plane {
  double origin = 0, x = 0, y = 0;
  double at(double sx, double sy) const { return origin + x * sx + y * sy; }
};

/// A triangle with corners in clockwise order as seen, and its edge functions over the tile's samples.
struct Face {
  Triangle v;
  bool back;
  double per_area;
  std::array<Edge, 3> edge;  // from the tile's first sample
  Range box;                 // of the tile

  Plane plane(const std::array<double, 3>& corner) const {
    const double b = (corner[1] - corner[0]) * per_area, c = (corner[2] - corner[0]) * per_area;
    const auto value = [](std::int64_t n) { return static_cast<double>(n); };
    return {corner[0] + (value(edge[1].start) * b + value(edge[2].start) * c),
            value(edge[1].step_x) * b + value(edge[2].step_x) * c,
            value(edge[1].step_y) * b + value(edge[2].step_y) * c};
  }
};

/// Samples are looked at eight at a time, so tiles are a multiple of eight wide.
constexpr int kLanes = 8;
static_assert(kTileSamples % kLanes == 0 && 2 * kApron % kLanes == 0);
/// Up to this size edge functions fit 32 bits: twice the area of the box, and a step over its end.
constexpr std::int32_t kSmallBox = 1 << 14;

/// One triangle's samples of a tile: `first` is the value of each edge at the first sample of the box.
struct Cover {
  std::array<std::int32_t, 3> first, step_x, step_y;
  Range box;  // x0 and x1 are multiples of kLanes
  double depth, slope_x, slope_y;
  std::uint32_t face;
};

/// One loop per row, which goes into wide registers without a rest.
SCANMILL_WIDE void cover_small(const Cover& c, int width, float* depth, std::uint32_t* face) {
  std::int32_t row0 = c.first[0], row1 = c.first[1], row2 = c.first[2];
  const std::int32_t x0 = c.step_x[0], x1 = c.step_x[1], x2 = c.step_x[2];
  const std::int32_t lanes = (c.box.x1 - c.box.x0) / kLanes * kLanes;
  const std::uint32_t mine = c.face;
  const double slope = c.slope_x;
  for (int sy = c.box.y0; sy < c.box.y1; ++sy) {
    const double row_depth = c.depth + c.slope_y * sy + slope * c.box.x0;
    float* const depth_row = depth + static_cast<std::ptrdiff_t>(sy) * width + c.box.x0;
    std::uint32_t* const face_row = face + static_cast<std::ptrdiff_t>(sy) * width + c.box.x0;
    for (std::int32_t k = 0; k < lanes; ++k) {
      const std::int32_t inside = (row0 + k * x0) | (row1 + k * x1) | (row2 + k * x2);
      const float z = static_cast<float>(row_depth + slope * static_cast<double>(k));
      const float before = depth_row[k];
      const bool shows = (inside >= 0) & (z > before);
      depth_row[k] = shows ? z : before;
      face_row[k] = shows ? mine : face_row[k];
    }
    row0 += c.step_y[0];
    row1 += c.step_y[1];
    row2 += c.step_y[2];
  }
}

/// The same for triangles of any size.
void cover_large(const Face& f, const Plane& depth, std::uint32_t mine, Tile& tile) {
  for (int sy = f.box.y0; sy < f.box.y1; ++sy)
    for (int sx = f.box.x0; sx < f.box.x1; ++sx) {
      std::int64_t inside = 0;
      for (const Edge& e : f.edge) inside |= e.start + sx * e.step_x + sy * e.step_y;
      if (inside < 0) continue;
      const std::size_t at = tile.row(sy) + static_cast<std::size_t>(sx);
      const auto z = static_cast<float>(depth.origin + depth.y * sy + depth.x * sx);
      if (!(z > tile.depth[at])) continue;
      tile.depth[at] = z;
      tile.face[at] = mine;
    }
}

/// How one triangle looks: light, error and distances from its edges over the samples of the tile.
struct FaceLook {
  Rgb base;
  bool back = false;
  Plane light, error;
  std::array<Plane, 3> edge;  // distance in samples
};

/// The triangles of one tile.
class FacePainter {
 public:
  FacePainter(const Drawing& drawing, Tile& tile, std::span<const std::uint32_t> things)
      : d_(drawing), tile_(tile), things_(things), look_of_(things.size(), kNoFace) {}

  /// Decides by depth what each sample shows.
  void cover(std::uint32_t place) {
    const auto face = face_of(things_[place]);
    if (!face) return;
    const Face& f = *face;
    const Plane depth = f.plane({d_.corners[f.v[0]].depth, d_.corners[f.v[1]].depth, d_.corners[f.v[2]].depth});
    if (!is_small(f)) return cover_large(f, depth, place, tile_);
    Cover c;
    c.box = {f.box.x0 / kLanes * kLanes, f.box.y0, (f.box.x1 + kLanes - 1) / kLanes * kLanes, f.box.y1};
    for (std::size_t k = 0; k < 3; ++k) {
      const Edge& e = f.edge[k];
      c.first[k] = static_cast<std::int32_t>(e.start + c.box.x0 * e.step_x + c.box.y0 * e.step_y);
      c.step_x[k] = static_cast<std::int32_t>(e.step_x);
      c.step_y[k] = static_cast<std::int32_t>(e.step_y);
    }
    c.depth = depth.origin;
    c.slope_x = depth.x;
    c.slope_y = depth.y;
    c.face = place;
    cover_small(c, tile_.width, tile_.depth.data(), tile_.face.data());
  }

  /// Colour of a triangle of the tile's list at a place in samples, (0, 0) being the centre of the first sample.
  Packed colour(std::uint32_t place, double sx, double sy) {
    const FaceLook& look = this->look(place);
    const Surface& s = d_.surface;
    double light = look.light.at(sx, sy);
    Rgb base = look.base;
    if (s.paint == Surface::Paint::Error) {
      base = scale_.at(look.error.at(sx, sy));
      // Colour carries the number here, light only hints at the shape; the inside is half grey.
      light = 0.62 + 0.38 * light;
      if (look.back) base = {half(base.r, s.back.r), half(base.g, s.back.g), half(base.b, s.back.b)};
    }
    Packed out{shaded(base.r, light), shaded(base.g, light), shaded(base.b, light), 1};
    if (s.wire_share > 0) {
      const double distance = std::min({look.edge[0].at(sx, sy), look.edge[1].at(sx, sy), look.edge[2].at(sx, sy)});
      const double ink = s.wire_share * std::clamp(1.5 - distance, 0.0, 1.0);
      if (ink > 0) out = {inked(out.r, kInk.r, ink), inked(out.g, kInk.g, ink), inked(out.b, kInk.b, ink), 1};
    }
    return out;
  }

 private:
  static bool is_small(const Face& f) {
    for (const Edge& e : f.edge)
      if (std::abs(e.step_x) > std::int64_t{kSmallBox} * kGridPerSample ||
          std::abs(e.step_y) > std::int64_t{kSmallBox} * kGridPerSample)
        return false;
    return true;
  }

  std::optional<Face> face_of(std::uint32_t t) const {
    Triangle v = d_.mesh->triangles[t];
    std::int64_t area = doubled_area(d_.corners[v[0]], d_.corners[v[1]], d_.corners[v[2]]);
    if (area == 0) return std::nullopt;
    const bool back = area > 0;  // y runs down: outward counter-clockwise turns negative
    if (area < 0) {
      std::swap(v[1], v[2]);
      area = -area;
    }
    const Corner &a = d_.corners[v[0]], &b = d_.corners[v[1]], &c = d_.corners[v[2]];
    const Range box = clipped(samples_of(a, b, c), tile_);
    if (box.empty()) return std::nullopt;
    const int x = tile_.x0, y = tile_.y0;
    return Face{v,
                back,
                1 / static_cast<double>(area),
                {edge_over(b, c, x, y), edge_over(c, a, x, y), edge_over(a, b, x, y)},
                box};
  }

  /// Made when it is first seen: most triangles of a fine mesh are hidden or miss every sample.
  const FaceLook& look(std::uint32_t place) {
    std::uint32_t& number = look_of_[place];
    if (number == kNoFace) {
      number = static_cast<std::uint32_t>(looks_.size());
      looks_.push_back(make_look(things_[place]));
    }
    return looks_[number];
  }

  /// In the axes of the view, from the snapped corners' own depths: needs no position.
  Vec3 flat_normal(const Triangle& v) const {
    const auto place = [&](std::uint32_t i) {
      const Corner& c = d_.corners[i];
      return Vec3{static_cast<double>(c.x) / kGridPerSample, -static_cast<double>(c.y) / kGridPerSample, c.depth};
    };
    const Vec3 a = place(v[0]), n = cross(place(v[1]) - a, place(v[2]) - a);
    return n.z < 0 ? unit(-n) : unit(n);  // to the viewer
  }

  FaceLook make_look(std::uint32_t t) const {
    FaceLook look;
    const auto face = face_of(t);
    if (!face) return look;
    const Triangle& v = face->v;
    const Surface& s = d_.surface;
    look.back = face->back;
    look.base = look.back ? s.back : s.front;
    if (s.paint == Surface::Paint::Patches && !look.back && t < d_.mesh->patch.size())
      look.base = d_.mesh->patch[t] < s.colours.size() ? s.colours[d_.mesh->patch[t]] : patch_colour(d_.mesh->patch[t]);
    const Vec3 flat = flat_normal(v);
    std::array<double, 3> light{}, error{};
    for (std::size_t k = 0; k < 3; ++k) {
      Vec3 n = d_.normals[v[k]];
      if (look.back) n = -n;
      light[k] = brightness(dot(n, flat) > kCreaseDot ? n : flat);
      if (s.paint == Surface::Paint::Error) error[k] = s.error[v[k]];
    }
    look.light = face->plane(light);
    look.error = face->plane(error);
    if (s.wire_share > 0)
      for (std::size_t k = 0; k < 3; ++k) {
        const Corner &p = d_.corners[v[(k + 1) % 3]], &q = d_.corners[v[(k + 2) % 3]];
        const double dx = q.x - p.x, dy = q.y - p.y, per = 1 / (std::sqrt(dx * dx + dy * dy) * kGridPerSample);
        const Edge& e = face->edge[k];
        look.edge[k] = {static_cast<double>(e.start) * per, static_cast<double>(e.step_x) * per,
                        static_cast<double>(e.step_y) * per};
      }
    return look;
  }

  static std::uint8_t half(std::uint8_t a, std::uint8_t b) { return static_cast<std::uint8_t>((a + b) / 2); }
  static std::uint8_t inked(std::uint8_t from, std::uint8_t to, double share) {
    return static_cast<std::uint8_t>(from + (to - from) * share + 0.5);
  }

  const Drawing& d_;
  Tile& tile_;
  std::span<const std::uint32_t> things_;
  std::vector<std::uint32_t> look_of_;
  std::vector<FaceLook> looks_;
  inline static const ErrorScale scale_;
};

// --- lines and dots ----------------------------------------------------------------------------------------------

void paint_line(const Line& line, Tile& tile) {
  const Range box = clipped(samples_around(line.a, line.b, line.half_width), tile);
  const double dx = line.b.x - line.a.x, dy = line.b.y - line.a.y, length2 = dx * dx + dy * dy;
  const double per_length2 = length2 > 0 ? 1 / length2 : 0, reach2 = line.half_width * line.half_width;
  for (int sy = box.y0; sy < box.y1; ++sy)
    for (int sx = box.x0; sx < box.x1; ++sx) {
      const double px = sx + tile.x0 + 0.5 - line.a.x, py = sy + tile.y0 + 0.5 - line.a.y;
      const double t = std::clamp((px * dx + py * dy) * per_length2, 0.0, 1.0);
      const double ex = px - t * dx, ey = py - t * dy;
      if (ex * ex + ey * ey > reach2) continue;
      const auto z = static_cast<float>(line.a.depth + t * (line.b.depth - line.a.depth) + line.lift);
      const std::size_t at = tile.row(sy) + static_cast<std::size_t>(sx);
      if (!(z > tile.depth[at])) continue;
      tile.depth[at] = z;
      tile.colour[at] = {line.colour.r, line.colour.g, line.colour.b, 1};
    }
}

void paint_dot(const Dot& dot, Tile& tile) {
  const Range box = clipped(samples_around(dot.at, dot.at, dot.radius), tile);
  const double reach2 = dot.radius * dot.radius;
  const auto z = static_cast<float>(dot.at.depth + dot.lift);
  for (int sy = box.y0; sy < box.y1; ++sy)
    for (int sx = box.x0; sx < box.x1; ++sx) {
      const double px = sx + tile.x0 + 0.5 - dot.at.x, py = sy + tile.y0 + 0.5 - dot.at.y;
      const std::size_t at = tile.row(sy) + static_cast<std::size_t>(sx);
      if (px * px + py * py > reach2 || !(z > tile.depth[at])) continue;
      tile.depth[at] = z;
      tile.colour[at] = {dot.colour.r, dot.colour.g, dot.colour.b, 1};
    }
}

/// Row by row and neighbour by neighbour: what runs along a row goes into wide registers, and the sums add up in the
/// same order for every sample.
SCANMILL_WIDE void shade_by_depth(Tile& tile) {
  static constexpr int kSteps[8][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, 1}, {-1, 1}, {1, -1}, {-1, -1}};
  const auto width = static_cast<std::size_t>(tile.width - 2 * kApron);
  std::vector<double> sum(width);
  for (int y = kApron; y < tile.height - kApron; ++y) {
    const std::size_t first = tile.row(y) + kApron;
    std::fill(sum.begin(), sum.end(), 0.0);
    for (const auto& step : kSteps)
      for (const int reach : {2, kApron}) {
        const float* own = &tile.depth[first];
        const float* other =
            &tile.depth[tile.row(y + step[1] * reach) + static_cast<std::size_t>(kApron + step[0] * reach)];
        const float per_reach = 1 / static_cast<float>(reach);  // a power of two: exact
        // A cliff counts no more than a steep slope: beyond that distance says nothing of shape. Where there is
        // nothing, the depth is so low that it counts as 0.
        for (std::size_t x = 0; x < width; ++x) {
          const float rise = (other[x] - own[x]) * per_reach;
          sum[x] += static_cast<double>(rise > 0 ? (rise < 4 ? rise : 4) : 0);
        }
      }
    for (std::size_t x = 0; x < width; ++x) {
      Packed& c = tile.colour[first + x];
      if (c.covered == 0) continue;
      const double light = 1 / (1 + 0.055 * sum[x]);
      c = {shaded(c.r, light), shaded(c.g, light), shaded(c.b, light), 1};
    }
  }
}

// --- tiles -------------------------------------------------------------------------------------------------------

/// Numbers of the things that may touch each tile, ascending.
struct TileLists {
  int columns = 0, rows = 0;
  std::vector<std::size_t> first;  // per tile, and one more
  std::vector<std::uint32_t> things;
};

class Binning {
 public:
  Binning(const Drawing& drawing, const Image& image, int apron)
      : d_(drawing),
        columns_((image.width + kTilePixels - 1) / kTilePixels),
        rows_((image.height + kTilePixels - 1) / kTilePixels),
        apron_(apron) {}

  /// Counts per piece and tile, then every piece writes into places of its own: ascending whatever the threads.
  TileLists run(const Context& context) const {
    const std::size_t tiles = static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_);
    const std::size_t faces = d_.mesh != nullptr ? d_.mesh->triangles.size() : 0;
    const std::size_t count = faces + d_.lines.size() + d_.dots.size();
    const std::size_t grain = std::max<std::size_t>(16384, count / 64 + 1), pieces = (count + grain - 1) / grain;
    std::vector<std::size_t> place(pieces * tiles, 0);
    for_each_piece(context, count, grain, [&](std::size_t b, std::size_t e, std::size_t piece, int) {
      std::size_t* mine = place.data() + piece * tiles;
      for (std::size_t i = b; i < e; ++i) for_tiles(i, faces, [&](std::size_t tile) { ++mine[tile]; });
    });
    TileLists lists{columns_, rows_, std::vector<std::size_t>(tiles + 1, 0), {}};
    std::size_t sum = 0;
    for (std::size_t tile = 0; tile < tiles; ++tile) {
      lists.first[tile] = sum;
      for (std::size_t piece = 0; piece < pieces; ++piece) sum += std::exchange(place[piece * tiles + tile], sum);
    }
    lists.first[tiles] = sum;
    lists.things.resize(sum);
    for_each_piece(context, count, grain, [&](std::size_t b, std::size_t e, std::size_t piece, int) {
      std::size_t* mine = place.data() + piece * tiles;
      for (std::size_t i = b; i < e; ++i)
        for_tiles(i, faces, [&](std::size_t tile) { lists.things[mine[tile]++] = static_cast<std::uint32_t>(i); });
    });
    return lists;
  }

 private:
  Range samples_of_thing(std::size_t i, std::size_t faces) const {
    if (i < faces) {
      const Triangle& t = d_.mesh->triangles[i];
      const Corner &a = d_.corners[t[0]], &b = d_.corners[t[1]], &c = d_.corners[t[2]];
      return doubled_area(a, b, c) == 0 ? Range{0, 0, 0, 0} : samples_of(a, b, c);
    }
    i -= faces;
    if (i < d_.lines.size()) return samples_around(d_.lines[i].a, d_.lines[i].b, d_.lines[i].half_width);
    const Dot& dot = d_.dots[i - d_.lines.size()];
    return samples_around(dot.at, dot.at, dot.radius);
  }
  template <class F>
  void for_tiles(std::size_t i, std::size_t faces, F&& take) const {
    const Range s = samples_of_thing(i, faces);
    if (s.empty()) return;
    const int x0 = std::max(floor_shift(s.x0 - apron_, kTileBits), 0),
              x1 = std::min(floor_shift(s.x1 - 1 + apron_, kTileBits), columns_ - 1),
              y0 = std::max(floor_shift(s.y0 - apron_, kTileBits), 0),
              y1 = std::min(floor_shift(s.y1 - 1 + apron_, kTileBits), rows_ - 1);
    for (int y = y0; y <= y1; ++y)
      for (int x = x0; x <= x1; ++x)
        take(static_cast<std::size_t>(y) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(x));
  }

  const Drawing& d_;
  int columns_, rows_, apron_;
};

/// Gives every sample that shows a triangle its colour, for what follows to work on.
void colour_samples(Tile& tile, FacePainter& painter) {
  for (int sy = 0; sy < tile.height; ++sy)
    for (int sx = 0; sx < tile.width; ++sx)
      if (const std::size_t at = tile.row(sy) + static_cast<std::size_t>(sx);
          tile.colour[at].covered == 0 && tile.face[at] != kNoFace)
        tile.colour[at] = painter.colour(tile.face[at], sx, sy);
}

/// Means of 2x2 samples into the pixels of the tile. Light is a plane over a triangle, so where it fills a pixel the
/// mean is the colour in the middle; `each_sample` where it is not (edges drawn in).
void resolve(const Tile& tile, int apron, int pixel_x, int pixel_y, bool each_sample, FacePainter& painter,
             Image& image) {
  const int right = std::min(pixel_x + kTilePixels, image.width),
            bottom = std::min(pixel_y + kTilePixels, image.height);
  const auto width = static_cast<std::size_t>(tile.width);
  for (int y = pixel_y; y < bottom; ++y)
    for (int x = pixel_x; x < right; ++x) {
      const int sx = (x - pixel_x) * kSamplesPerPixel + apron, sy = (y - pixel_y) * kSamplesPerPixel + apron;
      const std::size_t at = tile.row(sy) + static_cast<std::size_t>(sx);
      const std::array<std::size_t, 4> sample{at, at + 1, at + width, at + width + 1};
      const std::uint32_t face = tile.face[at];
      const bool one_face =
          tile.face[sample[1]] == face && tile.face[sample[2]] == face && tile.face[sample[3]] == face;
      std::array<Packed, 4> c;
      if (!tile.colour.empty())
        for (std::size_t k = 0; k < 4; ++k) c[k] = tile.colour[sample[k]];
      const bool bare = (c[0].covered | c[1].covered | c[2].covered | c[3].covered) == 0;
      if (bare && one_face && face == kNoFace) continue;
      std::uint8_t* p = image.at(x, y);
      if (bare && one_face && !each_sample) {
        const Packed middle = painter.colour(face, sx + 0.5, sy + 0.5);
        p[0] = middle.r, p[1] = middle.g, p[2] = middle.b;
        continue;
      }
      int r = 2, g = 2, b = 2, paper = 4;
      for (std::size_t k = 0; k < 4; ++k) {
        if (c[k].covered == 0 && tile.face[sample[k]] != kNoFace)
          c[k] = painter.colour(tile.face[sample[k]], sx + static_cast<int>(k % 2), sy + static_cast<int>(k / 2));
        if (c[k].covered == 0) continue;
        r += c[k].r;
        g += c[k].g;
        b += c[k].b;
        --paper;
      }
      p[0] = static_cast<std::uint8_t>((r + paper * p[0]) / 4);
      p[1] = static_cast<std::uint8_t>((g + paper * p[1]) / 4);
      p[2] = static_cast<std::uint8_t>((b + paper * p[2]) / 4);
    }
}

}  // namespace

Result<void> draw(const Drawing& drawing, Image& image, const Context& context) {
  const int apron = drawing.depth_shading ? kApron : 0;
  const TileLists lists = Binning(drawing, image, apron).run(context);
  const std::size_t faces = drawing.mesh != nullptr ? drawing.mesh->triangles.size() : 0;
  const std::size_t tiles = lists.first.size() - 1;
  for_each_range(context, tiles, 1, [&](std::size_t number, std::size_t) {
    const std::span<const std::uint32_t> things(lists.things.data() + lists.first[number],
                                                lists.first[number + 1] - lists.first[number]);
    if (things.empty()) return;
    const int pixel_x = static_cast<int>(number) % lists.columns * kTilePixels;
    const int pixel_y = static_cast<int>(number) / lists.columns * kTilePixels;
    Tile tile;
    tile.x0 = pixel_x * kSamplesPerPixel - apron;
    tile.y0 = pixel_y * kSamplesPerPixel - apron;
    tile.width = tile.height = kTileSamples + 2 * apron;
    tile.depth.assign(tile.row(tile.height), kNothing);
    tile.face.assign(tile.row(tile.height), kNoFace);
    if (drawing.depth_shading || things.back() >= faces) tile.colour.resize(tile.row(tile.height));
    FacePainter painter(drawing, tile, things);
    for (std::uint32_t place = 0; place < things.size(); ++place) {
      const std::size_t thing = things[place];
      if (thing < faces)
        painter.cover(place);
      else if (thing < faces + drawing.lines.size())
        paint_line(drawing.lines[thing - faces], tile);
      else
        paint_dot(drawing.dots[thing - faces - drawing.lines.size()], tile);
    }
    if (drawing.depth_shading) {
      colour_samples(tile, painter);
      shade_by_depth(tile);
    }
    resolve(tile, apron, pixel_x, pixel_y, drawing.surface.wire_share > 0, painter, image);
  });
  if (context.cancel.is_set()) return fail(Code::Cancelled, "stopped while drawing a picture");
  return {};
}

}  // namespace scanmill::render
