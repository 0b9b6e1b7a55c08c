// SPDX-License-Identifier: Apache-2.0
// Nearly all pairs of triangles lie apart, and cheap sufficient signs show it before any exact test: triangles are
// packed sixteen by sixteen along the Z-order curve of their least rows; boxes of blocks, then of triangles, that do
// not meet; a shared vertex whose fan some plane shows unfolded.
#include "stars/crossings.hpp"

#include <algorithm>
#include <bit>
#include <limits>

#include "base/wide.hpp"

namespace scanmill::stars {
namespace {

constexpr int kLanes = 16;
constexpr std::size_t kGrain = 64;  // blocks
constexpr int kAxes = 6;            // x y z x+y y+z z+x

/// Extents along the axes. Rounding to float never changes the order of two numbers, so extents that are apart after
/// rounding were apart before.
struct Block {
  float low[kAxes][kLanes], high[kAxes][kLanes];
  std::uint32_t id[3][kLanes];
  std::uint32_t unfolded[3][kLanes];  // id of a corner whose fan is unfolded, else kNone
  std::uint32_t number[kLanes];
};

struct Box {
  float low[3], high[3];
  bool meets(const Box& other) const {
    return low[0] <= other.high[0] && other.low[0] <= high[0] && low[1] <= other.high[1] && other.low[1] <= high[1] &&
           low[2] <= other.high[2] && other.low[2] <= high[2];
  }
};

/// hits[i]: bit l where triangle l of t may cross triangle i of s.
SCANMILL_WIDE void meeting_lanes(const Block& s, const Block& t, const Box& box, std::uint32_t* hits) {
  for (int i = 0; i < kLanes; ++i) {
    hits[i] = 0;
    const float lx = s.low[0][i], ly = s.low[1][i], lz = s.low[2][i];
    const float hx = s.high[0][i], hy = s.high[1][i], hz = s.high[2][i];
    if (!(lx <= box.high[0] && box.low[0] <= hx && ly <= box.high[1] && box.low[1] <= hy && lz <= box.high[2] &&
          box.low[2] <= hz))
      continue;
    const std::uint32_t a = s.unfolded[0][i], b = s.unfolded[1][i], c = s.unfolded[2][i];
    std::uint32_t mask = 0;
    for (int l = 0; l < kLanes; ++l) {
      unsigned meets = static_cast<unsigned>((lx <= t.high[0][l]) & (t.low[0][l] <= hx) & (ly <= t.high[1][l]) &
                                             (t.low[1][l] <= hy) & (lz <= t.high[2][l]) & (t.low[2][l] <= hz));
      for (int k = 3; k < kAxes; ++k)
        meets &= static_cast<unsigned>((s.low[k][i] <= t.high[k][l]) & (t.low[k][l] <= s.high[k][i]));
      for (int k = 0; k < 3; ++k)
        meets &= static_cast<unsigned>((t.id[k][l] != a) & (t.id[k][l] != b) & (t.id[k][l] != c));
      mask |= meets << l;
    }
    hits[i] = mask;
  }
}

/// Living triangles by least row, sixteen to a block.
std::vector<Block> pack(const Site& site, const Context& context) {
  const Complex& complex = site.complex;
  std::vector<std::uint32_t> next(complex.vertex_count() + 1, 0);
  for (std::uint32_t t = 0; t < complex.triangle_count(); ++t)
    if (complex.alive(t)) ++next[complex.triangle(t)[0] + 1];
  for (std::size_t v = 1; v < next.size(); ++v) next[v] += next[v - 1];
  std::vector<std::uint32_t> order(next.back());
  for (std::uint32_t t = 0; t < complex.triangle_count(); ++t)
    if (complex.alive(t)) order[next[complex.triangle(t)[0]]++] = t;
  std::vector<std::uint8_t> unfolded(complex.vertex_count());
  for_each_range(context, unfolded.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) unfolded[v] = unfolded_fan(site, static_cast<std::uint32_t>(v));
  });
  std::vector<Block> blocks((order.size() + kLanes - 1) / kLanes);
  for_each_range(context, blocks.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t n = begin * kLanes; n < end * kLanes; ++n) {
      Block& block = blocks[n / kLanes];
      const std::size_t l = n % kLanes;
      for (int k = 0; k < kAxes; ++k) {
        block.low[k][l] = std::numeric_limits<float>::infinity();
        block.high[k][l] = -std::numeric_limits<float>::infinity();
      }
      if (n >= order.size()) {
        for (std::size_t k = 0; k < 3; ++k) block.id[k][l] = block.unfolded[k][l] = kNone;
        continue;
      }
      const Triangle& t = complex.triangle(order[n]);
      block.number[l] = order[n];
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec3 p = site.measured(t[k]);
        const double along[kAxes] = {p.x, p.y, p.z, p.x + p.y, p.y + p.z, p.z + p.x};
        for (int axis = 0; axis < kAxes; ++axis) {
          const auto at = static_cast<float>(along[axis]);
          block.low[axis][l] = std::min(block.low[axis][l], at);
          block.high[axis][l] = std::max(block.high[axis][l], at);
        }
        block.id[k][l] = t[k];
        block.unfolded[k][l] = unfolded[t[k]] ? t[k] : kNone;
      }
    }
  });
  return blocks;
}

/// Boxes over boxes, sixteen to one; level 0 has one box per block.
using Levels = std::vector<std::vector<Box>>;

Levels boxes_over(const std::vector<Block>& blocks) {
  Levels levels(1);
  for (const Block& block : blocks) {
    Box box;
    for (int k = 0; k < 3; ++k) {
      box.low[k] = *std::min_element(block.low[k], block.low[k] + kLanes);
      box.high[k] = *std::max_element(block.high[k], block.high[k] + kLanes);
    }
    levels[0].push_back(box);
  }
  while (levels.back().size() > 1) {
    const std::vector<Box>& lower = levels.back();
    std::vector<Box> upper;
    for (std::size_t n = 0; n < lower.size(); ++n) {
      if (n % kLanes == 0) upper.push_back(lower[n]);
      for (int k = 0; k < 3; ++k) {
        upper.back().low[k] = std::min(upper.back().low[k], lower[n].low[k]);
        upper.back().high[k] = std::max(upper.back().high[k], lower[n].high[k]);
      }
    }
    levels.push_back(std::move(upper));
  }
  return levels;
}

/// body(block) for each block from `first` on whose box meets the given one.
template <class Body>
void visit_meeting(const Levels& levels, std::size_t level, std::size_t node, const Box& box, std::size_t first,
                   Body& body) {
  if (!levels[level][node].meets(box)) return;
  if (level == 0) return body(node);
  const std::size_t end = std::min((node + 1) * kLanes, levels[level - 1].size());
  const std::size_t span = std::size_t{1} << (4 * (level - 1));  // blocks under a child
  for (std::size_t child = std::max(node * kLanes, first / span); child < end; ++child)
    visit_meeting(levels, level - 1, child, box, first, body);
}

}  // namespace

bool unfolded_fan(const Site& site, std::uint32_t v) {
  const Fan& fan = site.complex.fan(v);
  if (fan.size() < 3 || site.complex.is_open(v)) return false;
  constexpr std::size_t kMost = 32;
  if (fan.size() > kMost) return false;
  Vec3 a[kMost], b[kMost], sum;
  const Vec3 at = site.measured(v);
  std::size_t n = 0;
  for (const std::uint32_t t : fan) {
    std::uint32_t p, q;
    site.complex.after(t, v, p, q);
    a[n] = site.measured(p) - at;
    b[n] = site.measured(q) - at;
    sum += cross(a[n], b[n]);
    ++n;
  }
  // Seen along `sum`, on the coordinate plane that it meets most steeply. Every step round the fan must turn left, by
  // far more than rounding can do, and the steps must make one turn.
  const double x = std::abs(sum.x), y = std::abs(sum.y), z = std::abs(sum.z);
  const double least = 1e-6 * site.h() * site.h();
  const int axis = x > y && x > z ? 0 : y > z ? 1 : 2;
  auto turned = [axis](Vec3 p) { return axis == 0 ? Vec3{p.y, p.z, p.x} : axis == 1 ? Vec3{p.z, p.x, p.y} : p; };
  sum = turned(sum);
  if (!(std::abs(sum.z) > least)) return false;
  const double side = sum.z > 0 ? 1 : -1, along_x = sum.x / sum.z, along_y = sum.y / sum.z;
  int turns = 0;
  bool left = true;
  for (std::size_t k = 0; k < n; ++k) {
    const Vec3 p = turned(a[k]), q = turned(b[k]);
    const double px = p.x - along_x * p.z, py = side * (p.y - along_y * p.z);
    const double qx = q.x - along_x * q.z, qy = side * (q.y - along_y * q.z);
    left = left && px * qy - py * qx > least;
    turns += py < 0 && qy >= 0;
  }
  return left && turns == 1;
}

std::vector<std::array<std::uint32_t, 2>> crossing_pairs(const Site& site, const Context& context) {
  using Pairs = std::vector<std::array<std::uint32_t, 2>>;
  const std::vector<Block> blocks = pack(site, context);
  if (blocks.empty()) return {};
  const Levels levels = boxes_over(blocks);
  std::vector<Pairs> found((blocks.size() + kGrain - 1) / kGrain);
  auto test = [&](std::uint32_t s, std::uint32_t t, Pairs& out) {
    if (s > t) std::swap(s, t);
    if (triangles_cross(site.corners(site.complex.triangle(s)), site.corners(site.complex.triangle(t))))
      out.push_back({s, t});
  };
  for_each_piece(context, blocks.size(), kGrain, [&](std::size_t begin, std::size_t end, std::size_t piece, int) {
    for (std::size_t own = begin; own < end; ++own) {
      auto against = [&](std::size_t other) {
        std::uint32_t hits[kLanes];
        meeting_lanes(blocks[own], blocks[other], levels[0][other], hits);
        for (std::uint32_t i = 0; i < kLanes; ++i) {
          std::uint32_t left = own == other ? hits[i] & ~((2u << i) - 1) : hits[i];
          for (; left != 0; left &= left - 1)
            test(blocks[own].number[i], blocks[other].number[std::countr_zero(left)], found[piece]);
        }
      };
      visit_meeting(levels, levels.size() - 1, 0, levels[0][own], own, against);
    }
  });
  Pairs all;
  for (const Pairs& pairs : found) all.insert(all.end(), pairs.begin(), pairs.end());
  return all;
}

}  // namespace scanmill::stars
