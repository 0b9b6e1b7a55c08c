// SPDX-License-Identifier: Apache-2.0
#include "verify/crossings.hpp"

#include <algorithm>
#include <atomic>

#include "geom/predicates.hpp"
#include "verify/box_tree.hpp"
#include "verify/edges.hpp"

namespace scanmill::verify {
namespace {

constexpr std::size_t kLeavesAtOnce = 256;

/// The triangles of a leaf with their boxes in double.
struct LeafBoxes {
  std::uint32_t triangle[kLeaf];
  Vec3 low[kLeaf], high[kLeaf];
  std::size_t count = 0;

  void fill(const Mesh& mesh, const BoxTree& tree, std::size_t leaf) {
    const auto order = tree.triangles();
    count = 0;
    for (std::size_t i = leaf * kLeaf; i < std::min(order.size(), (leaf + 1) * kLeaf); ++i) {
      const Triangle& t = mesh.triangles[order[i]];
      const Vec3 a = mesh.positions[t[0]], b = mesh.positions[t[1]], c = mesh.positions[t[2]];
      triangle[count] = order[i];
      low[count] = {std::min({a.x, b.x, c.x}), std::min({a.y, b.y, c.y}), std::min({a.z, b.z, c.z})};
      high[count++] = {std::max({a.x, b.x, c.x}), std::max({a.y, b.y, c.y}), std::max({a.z, b.z, c.z})};
    }
  }
};

bool boxes_meet(const Vec3& low, const Vec3& high, const Vec3& other_low, const Vec3& other_high) {
  return low.x <= other_high.x && other_low.x <= high.x && low.y <= other_high.y && other_low.y <= high.y &&
         low.z <= other_high.z && other_low.z <= high.z;
}

Corners corners_of(const Mesh& mesh, std::uint32_t t) {
  const auto& [a, b, c] = mesh.triangles[t];
  return {{mesh.positions[a], mesh.positions[b], mesh.positions[c]}, {a, b, c}};
}

bool cross_each_other(const Mesh& mesh, std::uint32_t s, std::uint32_t t) {
  const Triangle &u = mesh.triangles[s], &v = mesh.triangles[t];
  int shared = 0;
  for (const std::uint32_t i : u) shared += i == v[0] || i == v[1] || i == v[2];
  return shared < 3 && triangles_cross(corners_of(mesh, s), corners_of(mesh, t));
}

/// The least pairs of one piece of the sweep, and how many there were.
struct Found {
  std::uint64_t count = 0;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;

  void add(std::uint32_t s, std::uint32_t t, std::size_t listed) {
    ++count;
    pairs.push_back(std::minmax(s, t));
    if (pairs.size() > 2 * listed + 1000) shorten(listed);
  }
  void shorten(std::size_t listed) {
    std::sort(pairs.begin(), pairs.end());
    pairs.resize(std::min(pairs.size(), listed));
  }
};

class Sweep {
 public:
  Sweep(const Mesh& mesh, const BoxTree& tree, std::size_t listed, CrossingPairs& all)
      : mesh_(mesh), tree_(tree), listed_(listed), all_(all) {}

  void leaf(std::size_t number, Found& found) {
    mine_.fill(mesh_, tree_, number);
    Bounds box;
    for (std::size_t i = 0; i < mine_.count; ++i) {
      box.add(mine_.low[i]);
      box.add(mine_.high[i]);
    }
    if (box.empty()) return;
    leaves_.clear();
    tree_.leaves_meeting(holding(box), tree_.leaf_count(), leaves_);
    for (const std::uint32_t other : leaves_) {
      if (other < number) continue;
      theirs_.fill(mesh_, tree_, other);
      for (std::size_t j = 0; j < theirs_.count; ++j) {
        if (!boxes_meet(box.low, box.high, theirs_.low[j], theirs_.high[j])) continue;  // two of three
        for (std::size_t i = 0; i < (other == number ? j : mine_.count); ++i) {
          if (!boxes_meet(mine_.low[i], mine_.high[i], theirs_.low[j], theirs_.high[j])) continue;
          const std::uint32_t s = mine_.triangle[i], t = theirs_.triangle[j];
          if (!cross_each_other(mesh_, s, t)) continue;
          found.add(s, t, listed_);
          for (const std::uint32_t c : {s, t})  // several workers may find it
            std::atomic_ref(all_.crossed[c]).store(1, std::memory_order_relaxed);
        }
      }
    }
  }

 private:
  const Mesh& mesh_;
  const BoxTree& tree_;
  std::size_t listed_;
  CrossingPairs& all_;
  LeafBoxes mine_, theirs_;
  std::vector<std::uint32_t> leaves_;
};

}  // namespace

CrossingPairs crossing_pairs(const Mesh& mesh, std::size_t listed, const Context& context) {
  std::vector<std::uint32_t> proper;
  proper.reserve(mesh.triangles.size());
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    if (!names_a_vertex_twice(mesh.triangles[t])) proper.push_back(t);
  const BoxTree tree(mesh, std::move(proper));
  CrossingPairs all;
  all.crossed.assign(mesh.triangles.size(), 0);
  std::vector<Found> by_piece((tree.leaf_count() + kLeavesAtOnce - 1) / kLeavesAtOnce);
  for_each_piece(context, tree.leaf_count(), kLeavesAtOnce,
                 [&](std::size_t begin, std::size_t end, std::size_t piece, int) {
                   Sweep sweep(mesh, tree, listed, all);
                   for (std::size_t leaf = begin; leaf < end && !context.cancel.is_set(); ++leaf)
                     sweep.leaf(leaf, by_piece[piece]);
                   by_piece[piece].shorten(listed);
                 });
  Found total;
  for (const Found& found : by_piece) {
    total.pairs.insert(total.pairs.end(), found.pairs.begin(), found.pairs.end());
    total.count += found.count;
    total.shorten(listed);
  }
  all.count = total.count;
  all.first = std::move(total.pairs);
  return all;
}

}  // namespace scanmill::verify
