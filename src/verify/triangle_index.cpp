// SPDX-License-Identifier: Apache-2.0
#include "verify/triangle_index.hpp"

#include <emmintrin.h>

#include <algorithm>
#include <limits>

namespace scanmill::verify {
namespace {

/// Float32 linear forms over |x| + |y| + |z| + radius are off by less than 6 * 2^-24 of that; and by 1e-8 of it where
/// the normal of a sliver is.
constexpr float kMargin = 0x1p-20f;
/// A point's own coordinates in float32 are off by 2^-25 of them.
constexpr float kBoxMargin = 0x1p-22f;
constexpr double kFlatSine2 = 1e-16;
constexpr std::size_t kMostInRun = 32, kLeastInRun = 4, kMostGathered = 64;
/// Runs are no wider than this many leaves.
constexpr double kRunLeaves = 1;
constexpr float kNowhere = 1e15f;

struct FloatPoint {
  __m128 x, y, z;
  float size;  // |x| + |y| + |z|
  FloatPoint(const Vec3& p, const float* origin) {
    const auto fx = static_cast<float>(p.x - static_cast<double>(origin[0]));
    const auto fy = static_cast<float>(p.y - static_cast<double>(origin[1]));
    const auto fz = static_cast<float>(p.z - static_cast<double>(origin[2]));
    x = _mm_set1_ps(fx);
    y = _mm_set1_ps(fy);
    z = _mm_set1_ps(fz);
    size = std::abs(fx) + std::abs(fy) + std::abs(fz);
  }
};
constexpr float kZero[3] = {0, 0, 0};

/// Squared distances to four boxes.
__m128 distances2(const BoxTree::Node& node, const FloatPoint& p) {
  const __m128 zero = _mm_setzero_ps(), at[3] = {p.x, p.y, p.z};
  __m128 sum = zero;
  for (int k = 0; k < 3; ++k) {
    const __m128 below = _mm_sub_ps(_mm_load_ps(node.low[k]), at[k]);
    const __m128 above = _mm_sub_ps(at[k], _mm_load_ps(node.high[k]));
    const __m128 out = _mm_max_ps(_mm_max_ps(below, above), zero);
    sum = _mm_add_ps(sum, _mm_mul_ps(out, out));
  }
  return sum;
}

/// Squared lower bounds of the distances to four triangles; `outside` gets how far p lies beyond their sides, along
/// their planes: negative over the inside.
__m128 bounds2(const float (&plane)[4][4][4], const FloatPoint& p, __m128& outside) {
  __m128 value[4];
  for (int k = 0; k < 4; ++k)
    value[k] = _mm_sub_ps(
        _mm_add_ps(_mm_add_ps(_mm_mul_ps(_mm_load_ps(plane[k][0]), p.x), _mm_mul_ps(_mm_load_ps(plane[k][1]), p.y)),
                   _mm_mul_ps(_mm_load_ps(plane[k][2]), p.z)),
        _mm_load_ps(plane[k][3]));
  outside = _mm_max_ps(_mm_max_ps(value[1], value[2]), value[3]);
  const __m128 out = _mm_max_ps(outside, _mm_setzero_ps());
  return _mm_add_ps(_mm_mul_ps(value[0], value[0]), _mm_mul_ps(out, out));
}

std::vector<std::uint32_t> with_area(const Mesh& mesh) {
  std::vector<std::uint32_t> triangles;
  triangles.reserve(mesh.triangles.size());
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& [a, b, c] = mesh.triangles[t];
    const Vec3 n = cross(mesh.positions[b] - mesh.positions[a], mesh.positions[c] - mesh.positions[a]);
    if (n != Vec3{}) triangles.push_back(t);
  }
  return triangles;
}

}  // namespace

TriangleIndex::TriangleIndex(const Mesh& mesh)
    : mesh_(&mesh), tree_(mesh, with_area(mesh)), leaves_(tree_.leaf_count()) {
  double sum = 0;
  for (std::size_t n = 0; n < leaves_.size(); ++n) {
    fill(n, leaves_[n]);
    sum += 2 * static_cast<double>(leaves_[n].radius);
  }
  if (!leaves_.empty()) leaf_size_ = sum / static_cast<double>(leaves_.size());
}

std::size_t TriangleIndex::memory_bytes() const { return tree_.memory_bytes() + leaves_.size() * sizeof(Leaf); }

void TriangleIndex::fill(std::size_t number, Leaf& leaf) const {
  const auto order = tree_.triangles();
  const std::size_t begin = number * kLeaf, end = std::min(order.size(), begin + kLeaf);
  Bounds box;
  for (std::size_t i = begin; i < end; ++i)
    for (const std::uint32_t v : mesh_->triangles[order[i]]) box.add(mesh_->positions[v]);
  const Vec3 middle = box.low + (box.high - box.low) * 0.5;
  const double coordinates[3] = {middle.x, middle.y, middle.z};
  for (int k = 0; k < 3; ++k) leaf.origin[k] = static_cast<float>(coordinates[k]);
  const Vec3 origin{static_cast<double>(leaf.origin[0]), static_cast<double>(leaf.origin[1]),
                    static_cast<double>(leaf.origin[2])};
  leaf.radius = static_cast<float>(norm(box.size()) / 2);
  for (std::size_t slot = 0; slot < kLeaf; ++slot) {
    auto& plane = leaf.plane[slot / 4];
    auto set = [&](int which, Vec3 direction, double w) {
      const double terms[4] = {direction.x, direction.y, direction.z, w};
      for (int k = 0; k < 4; ++k) plane[which][k][slot % 4] = static_cast<float>(terms[k]);
    };
    for (int which = 0; which < 4; ++which) set(which, {}, 0);
    leaf.triangle[slot] = kNoTriangle;
    if (begin + slot >= end) {
      plane[0][3][slot % 4] = kNowhere;
      continue;
    }
    leaf.triangle[slot] = order[begin + slot];
    const Triangle& t = mesh_->triangles[leaf.triangle[slot]];
    const Vec3 at[3] = {mesh_->positions[t[0]], mesh_->positions[t[1]], mesh_->positions[t[2]]};
    const Vec3 ab = at[1] - at[0], ac = at[2] - at[0], n = cross(ab, ac);
    if (!(norm2(n) > kFlatSine2 * norm2(ab) * norm2(ac))) continue;  // no plane to trust
    const Vec3 up = unit(n);
    set(0, up, dot(up, at[0] - origin));
    for (int e = 0; e < 3; ++e) {
      const Vec3 out = unit(cross(at[(e + 1) % 3] - at[e], up));
      set(1 + e, out, dot(out, at[e] - origin));
    }
  }
}

/// Nearest so far; `bound` is its distance in float32, never too small.
struct TriangleIndex::Search::Best {
  Hit hit{std::numeric_limits<double>::infinity(), kNoTriangle, Feature::Face};
  float bound = std::numeric_limits<float>::infinity();
  std::uint32_t leaf = 0;
  float limit2(float margin) const {
    const float limit = bound + margin;
    return limit * limit;
  }
};

TriangleIndex::Search::Search(const TriangleIndex& index) : index_(&index), reach_(index.leaf_size_ / 8) {}

void TriangleIndex::Search::try_leaf(std::uint32_t number, const Vec3& p, Best& best) const {
  const Leaf& leaf = index_->leaves_[number];
  const FloatPoint local(p, leaf.origin);
  const float margin = kMargin * (local.size + leaf.radius);
  __m128 out0, out1;
  const __m128 b0 = bounds2(leaf.plane[0], local, out0), b1 = bounds2(leaf.plane[1], local, out1);
  auto within = [](__m128 bounds, __m128 limit) {  // what is no number stays
    return static_cast<unsigned>(_mm_movemask_ps(_mm_cmpngt_ps(bounds, limit)));
  };
  auto lanes_within = [&](float limit2) {
    const __m128 limit = _mm_set1_ps(limit2);
    return within(b0, limit) | within(b1, limit) << 4;
  };
  unsigned lanes = lanes_within(best.limit2(margin));
  if (lanes == 0) return;
  const __m128 clearly = _mm_set1_ps(-margin);
  const unsigned over_face = static_cast<unsigned>(_mm_movemask_ps(_mm_cmplt_ps(out0, clearly))) |
                             static_cast<unsigned>(_mm_movemask_ps(_mm_cmplt_ps(out1, clearly))) << 4;
  if ((lanes & (lanes - 1)) != 0) {  // several: the one with the least bound, which mostly rules out the others
    __m128 least = _mm_min_ps(b0, b1);
    least = _mm_min_ps(least, _mm_movehl_ps(least, least));
    least = _mm_min_ss(least, _mm_shuffle_ps(least, least, 1));
    const unsigned first = lanes & lanes_within(_mm_cvtss_f32(least));
    const unsigned lane = static_cast<unsigned>(__builtin_ctz(first != 0 ? first : lanes));
    measure(leaf.triangle[lane], (over_face >> lane & 1) != 0, number, p, best);
    lanes &= ~(1u << lane) & lanes_within(best.limit2(margin));
  }
  for (; lanes != 0; lanes &= lanes - 1) {
    const auto lane = static_cast<unsigned>(__builtin_ctz(lanes));
    measure(leaf.triangle[lane], (over_face >> lane & 1) != 0, number, p, best);
  }
}

inline void TriangleIndex::Search::measure(std::uint32_t t, bool over_face, std::uint32_t leaf, const Vec3& p,
                                           Best& best) const {
  if (t == kNoTriangle) return;
  const Triangle& corners = index_->mesh_->triangles[t];
  const Vec3* at = index_->mesh_->positions.data();
  const Vec3 &a = at[corners[0]], &b = at[corners[1]], &c = at[corners[2]];
  const Closest found =
      over_face ? Closest{distance2_over_face(p, a, b, c), Feature::Face} : closest_on_triangle(p, a, b, c);
  if (found.distance2 < best.hit.distance2 || (found.distance2 == best.hit.distance2 && t < best.hit.triangle)) {
    best.hit = {found.distance2, t, found.feature};
    best.bound = static_cast<float>(std::sqrt(found.distance2)) * (1 + kMargin);
    best.leaf = leaf;
  }
}

void TriangleIndex::Search::walk(const Vec3& p, Best& best) const {
  struct Visit {
    std::uint32_t level, node;
    float distance2;
  };
  const auto levels = index_->tree_.levels();
  const FloatPoint at(p, kZero);
  const float margin = kBoxMargin * at.size;
  Visit stack[80];  // at most three wait on each of 17 levels
  int waiting = 0;
  stack[waiting++] = {static_cast<std::uint32_t>(levels.size() - 1), 0, 0};
  while (waiting > 0) {
    const Visit visit = stack[--waiting];
    if (visit.distance2 > best.limit2(margin)) continue;
    const std::size_t children = visit.level > 0 ? levels[visit.level - 1].size() : index_->leaves_.size();
    alignas(16) float d[4];
    _mm_store_ps(d, distances2(levels[visit.level][visit.node], at));
    std::uint32_t order[4];
    int found = 0;
    for (std::uint32_t lane = 0; lane < 4; ++lane) {  // nearest first
      if (4 * visit.node + lane >= children || d[lane] > best.limit2(margin)) continue;
      int k = found++;
      for (; k > 0 && d[lane] < d[order[k - 1]]; --k) order[k] = order[k - 1];
      order[k] = lane;
    }
    if (visit.level > 0) {
      for (int k = found - 1; k >= 0; --k) stack[waiting++] = {visit.level - 1, 4 * visit.node + order[k], d[order[k]]};
    } else {
      for (int k = 0; k < found; ++k)
        if (!(d[order[k]] > best.limit2(margin))) try_leaf(4 * visit.node + order[k], p, best);
    }
  }
}

std::size_t TriangleIndex::Search::run_length(std::span<const Vec3> points, Bounds& box) const {
  const double widest = kRunLeaves * index_->leaf_size_;
  box = {};
  std::size_t n = 0;
  for (; n < std::min(points.size(), kMostInRun); ++n) {
    Bounds wider = box;
    wider.add(points[n]);
    const Vec3 size = wider.size();
    if (n > 0 && !(std::max({size.x, size.y, size.z}) <= widest)) break;
    box = wider;
  }
  return n;
}

bool TriangleIndex::Search::gather(const Bounds& box) {
  const Vec3 reach{reach_, reach_, reach_};
  leaves_.clear();
  if (!index_->tree_.leaves_meeting(holding({box.low - reach, box.high + reach}), kMostGathered, leaves_)) return false;
  boxes_.resize((leaves_.size() + 3) / 4);
  const auto& nodes = index_->tree_.levels()[0];
  for (std::size_t i = 0; i < boxes_.size() * 4; ++i) {
    BoxTree::Node& to = boxes_[i / 4];
    const bool real = i < leaves_.size();
    const BoxTree::Node& from = nodes[real ? leaves_[i] / 4 : 0];
    for (int k = 0; k < 3; ++k) {
      to.low[k][i % 4] = real ? from.low[k][leaves_[i] % 4] : std::numeric_limits<float>::infinity();
      to.high[k][i % 4] = real ? from.high[k][leaves_[i] % 4] : -std::numeric_limits<float>::infinity();
    }
  }
  return !leaves_.empty();
}

void TriangleIndex::Search::among_gathered(const Vec3& p, Best& best) const {
  try_leaf(last_leaf_, p, best);
  const FloatPoint at(p, kZero);
  const float margin = kBoxMargin * at.size;
  for (std::size_t node = 0; node < boxes_.size(); ++node) {
    const __m128 d = distances2(boxes_[node], at);
    auto lanes = static_cast<unsigned>(_mm_movemask_ps(_mm_cmpngt_ps(d, _mm_set1_ps(best.limit2(margin)))));
    for (; lanes != 0; lanes &= lanes - 1) {
      const std::size_t i = 4 * node + static_cast<std::size_t>(__builtin_ctz(lanes));
      if (i < leaves_.size() && leaves_[i] != last_leaf_) try_leaf(leaves_[i], p, best);
    }
  }
}

void TriangleIndex::Search::nearest(std::span<const Vec3> points, std::span<Hit> hits) {
  for (std::size_t i = 0; i < points.size();) {
    Bounds box;
    const std::size_t length = run_length(points.subspan(i), box);
    const bool shared = length >= kLeastInRun && gather(box);
    std::size_t missed = 0;
    for (std::size_t n = i; n < i + length; ++n) {
      Best best;
      if (shared)
        among_gathered(points[n], best);
      else
        try_leaf(last_leaf_, points[n], best);
      if (!shared || !(static_cast<double>(best.bound) <= reach_)) {
        ++missed;
        walk(points[n], best);
      }
      last_leaf_ = best.leaf;
      hits[n] = best.hit;
    }
    // Reach trades leaves gathered in vain against walks; it never decides an answer.
    if (shared) reach_ *= 4 * missed > length ? 1.5 : missed == 0 ? 0.97 : 1;
    reach_ = std::clamp(reach_, index_->leaf_size_ / 64, index_->leaf_size_);
    i += length;
  }
}

Hit TriangleIndex::Search::nearest(Vec3 point) {
  Hit hit;
  nearest({&point, 1}, {&hit, 1});
  return hit;
}

}  // namespace scanmill::verify
