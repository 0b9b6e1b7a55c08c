// SPDX-License-Identifier: Apache-2.0
#include "verify/box_tree.hpp"

#include <emmintrin.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace scanmill::verify {
namespace {

constexpr float kInfinite = std::numeric_limits<float>::infinity();
constexpr FloatBox kNothing{{kInfinite, kInfinite, kInfinite}, {-kInfinite, -kInfinite, -kInfinite}};

float rounded_down(double value) {
  const auto f = static_cast<float>(value);
  return static_cast<double>(f) > value ? std::nextafter(f, -kInfinite) : f;
}
float rounded_up(double value) {
  const auto f = static_cast<float>(value);
  return static_cast<double>(f) < value ? std::nextafter(f, kInfinite) : f;
}

/// Places triangles of one range after the other: every subtree of 4^level leaves gets its run of the order.
class Splitter {
 public:
  struct Item {
    float centre[3];
    std::uint32_t triangle;
  };
  explicit Splitter(std::vector<Item>& items) : items_(items) {}

  /// [begin, end) becomes leaves in order; `piece` is the number of triangles of a full child.
  void split(std::size_t begin, std::size_t end, std::size_t piece) {
    if (end - begin <= kLeaf) return;
    while (piece >= end - begin) piece /= 4;
    if (piece < kLeaf) piece = kLeaf;
    const std::size_t middle = begin + 2 * piece;
    if (middle < end) cut(begin, end, middle);
    for (std::size_t half = begin; half < end; half += 2 * piece) {
      const std::size_t stop = std::min(end, half + 2 * piece);
      if (half + piece < stop) cut(half, stop, half + piece);
    }
    if (piece == kLeaf) return;
    for (std::size_t child = begin; child < end; child += piece) split(child, std::min(end, child + piece), piece / 4);
  }

 private:
  /// Those before `at` have the lesser centroids along the longest extent; ties by number of the triangle.
  void cut(std::size_t begin, std::size_t end, std::size_t at) {
    float low[3], high[3];
    for (int k = 0; k < 3; ++k) low[k] = high[k] = items_[begin].centre[k];
    for (std::size_t i = begin; i < end; ++i)
      for (int k = 0; k < 3; ++k) {
        low[k] = std::min(low[k], items_[i].centre[k]);
        high[k] = std::max(high[k], items_[i].centre[k]);
      }
    int axis = 0;
    for (int k = 1; k < 3; ++k)
      if (high[k] - low[k] > high[axis] - low[axis]) axis = k;
    auto item = [&](std::size_t i) { return items_.begin() + static_cast<std::ptrdiff_t>(i); };
    std::nth_element(item(begin), item(at), item(end), [axis](const Item& a, const Item& b) {
      return a.centre[axis] != b.centre[axis] ? a.centre[axis] < b.centre[axis] : a.triangle < b.triangle;
    });
  }
  std::vector<Item>& items_;
};

}  // namespace

FloatBox holding(const Bounds& box) {
  return {{rounded_down(box.low.x), rounded_down(box.low.y), rounded_down(box.low.z)},
          {rounded_up(box.high.x), rounded_up(box.high.y), rounded_up(box.high.z)}};
}

BoxTree::BoxTree(const Mesh& mesh, std::vector<std::uint32_t> triangles) : order_(std::move(triangles)) {
  const std::size_t count = order_.size();
  std::vector<Splitter::Item> items(count);
  for (std::size_t i = 0; i < count; ++i) {
    const auto& [a, b, c] = mesh.triangles[order_[i]];
    const Vec3 sum = mesh.positions[a] + mesh.positions[b] + mesh.positions[c];
    items[i] = {{static_cast<float>(sum.x / 3), static_cast<float>(sum.y / 3), static_cast<float>(sum.z / 3)},
                order_[i]};
  }
  std::size_t piece = kLeaf;
  while (piece < count) piece *= 4;
  Splitter(items).split(0, count, piece);
  for (std::size_t i = 0; i < count; ++i) order_[i] = items[i].triangle;
  items = {};

  std::vector<FloatBox> boxes(leaf_count());
  for (std::size_t leaf = 0; leaf < boxes.size(); ++leaf) {
    Bounds box;
    for (std::size_t i = leaf * kLeaf; i < std::min(count, (leaf + 1) * kLeaf); ++i)
      for (const std::uint32_t v : mesh.triangles[order_[i]]) box.add(mesh.positions[v]);
    boxes[leaf] = holding(box);
  }
  do {
    std::vector<Node> nodes(std::max<std::size_t>(1, (boxes.size() + 3) / 4));
    std::vector<FloatBox> parents(nodes.size(), kNothing);
    for (std::size_t i = 0; i < nodes.size() * 4; ++i) {
      const FloatBox& box = i < boxes.size() ? boxes[i] : kNothing;
      Node& node = nodes[i / 4];
      FloatBox& parent = parents[i / 4];
      for (int k = 0; k < 3; ++k) {
        node.low[k][i % 4] = box.low[k];
        node.high[k][i % 4] = box.high[k];
        parent.low[k] = std::min(parent.low[k], box.low[k]);
        parent.high[k] = std::max(parent.high[k], box.high[k]);
      }
    }
    levels_.push_back(std::move(nodes));
    boxes = std::move(parents);
  } while (boxes.size() > 1);
}

std::size_t BoxTree::memory_bytes() const {
  std::size_t bytes = order_.size() * sizeof(std::uint32_t);
  for (const auto& level : levels_) bytes += level.size() * sizeof(Node);
  return bytes;
}

bool BoxTree::leaves_meeting(const FloatBox& box, std::size_t most, std::vector<std::uint32_t>& leaves) const {
  struct Visit {
    std::uint32_t level, node;
  };
  Visit stack[64];  // at most three wait on each of 17 levels
  int waiting = 0;
  __m128 low[3], high[3];
  for (int k = 0; k < 3; ++k) {
    low[k] = _mm_set1_ps(box.low[k]);
    high[k] = _mm_set1_ps(box.high[k]);
  }
  stack[waiting++] = {static_cast<std::uint32_t>(levels_.size() - 1), 0};
  while (waiting > 0) {
    const Visit visit = stack[--waiting];
    const Node& node = levels_[visit.level][visit.node];
    __m128 meets = _mm_cmple_ps(_mm_load_ps(node.low[0]), high[0]);
    meets = _mm_and_ps(meets, _mm_cmpge_ps(_mm_load_ps(node.high[0]), low[0]));
    for (int k = 1; k < 3; ++k) {
      meets = _mm_and_ps(meets, _mm_cmple_ps(_mm_load_ps(node.low[k]), high[k]));
      meets = _mm_and_ps(meets, _mm_cmpge_ps(_mm_load_ps(node.high[k]), low[k]));
    }
    const int lanes = _mm_movemask_ps(meets);
    for (std::uint32_t lane = 0; lane < 4; ++lane) {
      if ((lanes & (1 << lane)) == 0) continue;
      const std::uint32_t child = 4 * visit.node + lane;
      if (visit.level > 0) {
        if (child < levels_[visit.level - 1].size()) stack[waiting++] = {visit.level - 1, child};
      } else if (child < leaf_count()) {  // a box without bounds meets missing ones too
        if (leaves.size() >= most) return false;
        leaves.push_back(child);
      }
    }
  }
  return true;
}

}  // namespace scanmill::verify
