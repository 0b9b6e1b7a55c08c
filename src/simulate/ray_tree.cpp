// SPDX-License-Identifier: Apache-2.0
#include "simulate/ray_tree.hpp"

#include <emmintrin.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace scanmill::simulate {
namespace {

constexpr std::uint32_t kLeaf = 4;
constexpr std::uint32_t kSlices = 16;
constexpr int kSliced = 40;  // levels cut by area; deeper ones are halved, so that no mesh makes a tree of any depth
constexpr int kWaiting = 3 * (kSliced + 20);
constexpr float kInfinite = std::numeric_limits<float>::infinity();
// Of the tree's extent: origin, box and their difference are rounded to 6e-8 each and t to 1.2e-7 of at most twice
// that.
constexpr double kMargin = 2e-6;

double half_area(const Bounds& box) {
  if (box.empty()) return 0;
  const Vec3 s = box.size();
  return s.x * s.y + s.y * s.z + s.z * s.x;
}

double along(Vec3 p, int axis) { return axis == 0 ? p.x : axis == 1 ? p.y : p.z; }

}  // namespace

/// Splits ranges of triangles; order and tree follow from the mesh alone.
class RayTree::Builder {
 public:
  struct Item {
    Bounds box;
    Vec3 centre;
    std::uint32_t triangle;
  };
  Builder(RayTree& tree, std::vector<Item> items) : tree_(tree), items_(std::move(items)) {}

  /// A node over [begin, end), `level` below the root; returns its number.
  std::uint32_t node(std::size_t begin, std::size_t end, int level) {
    std::array<std::size_t, kWidth + 1> cuts{begin, begin, begin, begin, end};
    cuts[2] = end - begin > kLeaf ? cut(begin, end, level) : end;
    cuts[1] = cuts[2] - begin > kLeaf ? cut(begin, cuts[2], level) : cuts[2];
    cuts[3] = end - cuts[2] > kLeaf ? cut(cuts[2], end, level) : end;
    const auto number = static_cast<std::uint32_t>(tree_.nodes_.size());
    tree_.nodes_.emplace_back();
    for (std::uint32_t lane = 0; lane < kWidth; ++lane) fill(number, lane, cuts[lane], cuts[lane + 1], level);
    return number;
  }
  const std::vector<Item>& items() const { return items_; }

 private:
  void fill(std::uint32_t number, std::uint32_t lane, std::size_t begin, std::size_t end, int level) {
    Bounds box;
    for (std::size_t i = begin; i < end; ++i) box.add(items_[i].box);
    const bool is_leaf = end - begin <= kLeaf;
    const std::uint32_t child = is_leaf ? static_cast<std::uint32_t>(begin) : node(begin, end, level + 1);
    Node& node = tree_.nodes_[number];
    for (int k = 0; k < 3; ++k) {
      const double centre = along(tree_.centre_, k), margin = tree_.margin_;
      node.low[k][lane] = box.empty() ? kInfinite : static_cast<float>(along(box.low, k) - centre - margin);
      node.high[k][lane] = box.empty() ? -kInfinite : static_cast<float>(along(box.high, k) - centre + margin);
    }
    node.child[lane] = child;
    node.count[lane] = is_leaf ? static_cast<std::uint32_t>(end - begin) : 0;
  }

  /// Where the two parts cost a ray least: by slices along the axis with the widest centres, in the middle when all
  /// centres are the same.
  std::size_t cut(std::size_t begin, std::size_t end, int level) {
    Bounds centres;
    for (std::size_t i = begin; i < end; ++i) centres.add(items_[i].centre);
    const Vec3 size = centres.size();
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const double low = along(centres.low, axis), width = along(size, axis);
    if (!(width > 0) || level >= kSliced) return begin + (end - begin) / 2;
    auto slice_of = [&](const Item& item) {
      const double share = (along(item.centre, axis) - low) / width;
      return std::min(kSlices - 1, static_cast<std::uint32_t>(share * kSlices));
    };
    std::array<Bounds, kSlices> boxes{};
    std::array<std::size_t, kSlices> counts{};
    for (std::size_t i = begin; i < end; ++i) {
      const std::uint32_t slice = slice_of(items_[i]);
      boxes[slice].add(items_[i].box);
      ++counts[slice];
    }
    std::array<double, kSlices> left{};
    Bounds sum;
    std::size_t count = 0;
    for (std::uint32_t s = 0; s + 1 < kSlices; ++s) {
      sum.add(boxes[s]);
      count += counts[s];
      left[s] = half_area(sum) * static_cast<double>(count);
    }
    sum = {};
    count = 0;
    double least = std::numeric_limits<double>::infinity();
    std::uint32_t best = 0;
    for (std::uint32_t s = kSlices - 1; s-- > 0;) {
      sum.add(boxes[s + 1]);
      count += counts[s + 1];
      const double cost = left[s] + half_area(sum) * static_cast<double>(count);
      if (cost > least) continue;
      least = cost;
      best = s;
    }
    const auto first = items_.begin() + static_cast<std::ptrdiff_t>(begin);
    const auto middle = std::stable_partition(first, items_.begin() + static_cast<std::ptrdiff_t>(end),
                                              [&](const Item& item) { return slice_of(item) <= best; });
    // The outermost slices hold a centre each, so neither part is empty.
    return begin + static_cast<std::size_t>(middle - first);
  }

  RayTree& tree_;
  std::vector<Item> items_;
};

RayTree::RayTree(const Mesh& mesh) {
  std::vector<Builder::Item> items;
  items.reserve(mesh.triangles.size());
  normals_.reserve(mesh.triangles.size());
  auto corner_of = [&](std::uint32_t row) { return mesh.positions[row] + mesh.offset; };
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& [a, b, c] = mesh.triangles[t];
    const Vec3 p = corner_of(a), q = corner_of(b), r = corner_of(c);
    Builder::Item item;
    for (const Vec3 v : {p, q, r}) item.box.add(v);
    item.centre = (item.box.low + item.box.high) * 0.5;
    item.triangle = static_cast<std::uint32_t>(t);
    items.push_back(item);
    bounds_.add(item.box);
    normals_.push_back(unit(cross(q - p, r - p)));
  }
  if (items.empty()) return;
  centre_ = (bounds_.low + bounds_.high) * 0.5;
  margin_ = static_cast<float>(kMargin * (norm(bounds_.size()) + 1e-3));
  Builder builder(*this, std::move(items));
  builder.node(0, mesh.triangles.size(), 0);
  corners_.reserve(mesh.triangles.size());
  for (const Builder::Item& item : builder.items()) {
    const auto& [a, b, c] = mesh.triangles[item.triangle];
    corners_.push_back({corner_of(a), corner_of(b), corner_of(c), item.triangle});
  }
}

void RayTree::meet(const Corner& corner, const Ray& ray, Interval range, Hit& best) const {
  const Vec3 a = corner.a - ray.origin, b = corner.b - ray.origin, c = corner.c - ray.origin;
  const double u = dot(ray.direction, cross(c, b)), v = dot(ray.direction, cross(a, c)),
               w = dot(ray.direction, cross(b, a));
  if ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0)) return;
  const double sum = u + v + w;
  if (sum == 0) return;  // seen edge on, or without area
  const double t = (u * dot(a, ray.direction) + v * dot(b, ray.direction) + w * dot(c, ray.direction)) / sum;
  if (t < range.low || t > range.high) return;
  if (best.triangle != kNoTriangle && (t > best.t || (t == best.t && corner.triangle > best.triangle))) return;
  best = {t, corner.triangle};
}

RayTree::Hit RayTree::first(const Ray& ray, Interval range) const {
  Hit best;
  if (nodes_.empty()) return best;
  Bounds outer = bounds_;
  const double margin = margin_;
  outer.low = outer.low - Vec3{margin, margin, margin};
  outer.high = outer.high + Vec3{margin, margin, margin};
  const Interval inside = clip(ray, outer);
  if (inside.low > range.high || inside.high < range.low || inside.low > inside.high) return best;
  // Float32 from where the ray enters the tree: nothing is farther away than the tree is large.
  const double start = std::max(inside.low, range.low);
  const Vec3 entry = ray.at(start) - centre_;
  const double d[3] = {ray.direction.x, ray.direction.y, ray.direction.z};
  const double o[3] = {entry.x, entry.y, entry.z};
  __m128 origin[3], inverse[3];
  bool is_negative[3];
  for (int k = 0; k < 3; ++k) {
    is_negative[k] = d[k] < 0;
    const double least = is_negative[k] ? std::min(d[k], -1e-18) : std::max(d[k], 1e-18);
    origin[k] = _mm_set1_ps(static_cast<float>(o[k]));
    inverse[k] = _mm_set1_ps(static_cast<float>(1 / least));
  }
  const auto limit = [&](double t) { return static_cast<float>(std::min(t - start, 1e30)) * 1.000001f + 2 * margin_; };
  float last = limit(range.high);
  struct Visit {
    std::uint32_t node;
    float near;
  };
  Visit stack[kWaiting];  // three wait on each level
  int waiting = 0;
  stack[waiting++] = {0, 0};
  while (waiting > 0) {
    const Visit visit = stack[--waiting];
    if (visit.near > last) continue;
    const Node& node = nodes_[visit.node];
    __m128 near = _mm_setzero_ps(), far = _mm_set1_ps(last);
    for (int k = 0; k < 3; ++k) {
      const __m128 low = _mm_load_ps(node.low[k]), high = _mm_load_ps(node.high[k]);
      const __m128 in = _mm_mul_ps(_mm_sub_ps(is_negative[k] ? high : low, origin[k]), inverse[k]);
      const __m128 out = _mm_mul_ps(_mm_sub_ps(is_negative[k] ? low : high, origin[k]), inverse[k]);
      near = _mm_max_ps(near, in);
      far = _mm_min_ps(far, out);
    }
    int lanes = _mm_movemask_ps(_mm_cmple_ps(near, far));
    if (lanes == 0) continue;
    alignas(16) float nears[kWidth];
    _mm_store_ps(nears, near);
    Visit inner[kWidth];
    int found = 0;
    for (std::uint32_t lane = 0; lane < kWidth; ++lane) {
      if ((lanes & (1 << lane)) == 0) continue;
      const std::uint32_t count = node.count[lane], child = node.child[lane];
      if (count > 0) {
        for (std::uint32_t i = child; i < child + count; ++i) meet(corners_[i], ray, range, best);
        if (best.triangle != kNoTriangle) last = std::min(last, limit(best.t));
      } else if (child != 0) {  // empty lanes lead to the root
        int at = found++;
        for (; at > 0 && inner[at - 1].near < nears[lane]; --at) inner[at] = inner[at - 1];
        inner[at] = {child, nears[lane]};
      }
    }
    for (int i = 0; i < found; ++i) stack[waiting++] = inner[i];
  }
  return best;
}

}  // namespace scanmill::simulate
