// SPDX-License-Identifier: Apache-2.0
#include "optimise/surface.hpp"

#include <algorithm>
#include <numeric>

namespace scanmill::optimise {

Surface::Surface(const Mesh& mesh) : at_(mesh.positions), patch_(mesh.patch), slots_(mesh.triangles.size()) {
  for (std::size_t t = 0; t < slots_.size(); ++t) slots_[t].corner = mesh.triangles[t];
  find_twins();
  find_fans();
}

void Surface::find_twins() {
  // Half-edges in buckets by their lesser vertex; a bucket holds a handful.
  std::vector<std::uint32_t> first(at_.size() + 2, 0);
  for (const Slot& s : slots_)
    for (std::size_t e = 0; e < 3; ++e) ++first[std::min(s.corner[e], s.corner[e == 2 ? 0 : e + 1]) + 2];
  std::partial_sum(first.begin(), first.end(), first.begin());
  struct Half {
    std::uint32_t greater, half;
  };
  std::vector<Half> halves(slots_.size() * 3);
  for (std::uint32_t t = 0; t < slots_.size(); ++t)
    for (std::uint32_t e = 0; e < 3; ++e) {
      const std::uint32_t a = slots_[t].corner[e], b = slots_[t].corner[e == 2 ? 0 : e + 1];
      halves[first[std::min(a, b) + 1]++] = {std::max(a, b), half_of(t, e)};
    }
  // Now first[v] is where v's bucket begins.
  for (std::size_t v = 0; v < at_.size(); ++v) {
    const Half *const begin = halves.data() + first[v], *const end = halves.data() + first[v + 1];
    for (const Half* i = begin; i != end; ++i) {
      std::uint32_t others = 0, other = kNone;
      for (const Half* j = begin; j != end; ++j)
        if (j != i && j->greater == i->greater) {
          ++others;
          other = j->half;
        }
      // Two triangles that disagree in direction are no neighbours here.
      if (others == 1 && from(other) != from(i->half)) slots_[slot_of(i->half)].twin[i->half & 3u] = other;
    }
  }
}

void Surface::find_fans() {
  out_.assign(at_.size(), kNone);
  split_.assign(at_.size(), 0);
  std::vector<std::uint32_t> corners(at_.size(), 0);
  for (std::uint32_t t = 0; t < slots_.size(); ++t)
    for (std::uint32_t e = 0; e < 3; ++e) {
      const std::uint32_t v = slots_[t].corner[e];
      ++corners[v];
      out_[v] = half_of(t, e);
    }
  for (std::uint32_t v = 0; v < at_.size(); ++v) {
    std::uint32_t met = 0;
    any_around(v, [&](std::uint32_t, std::uint32_t, std::uint32_t) { return ++met > corners[v]; });
    split_[v] = met != corners[v];
  }
  for (std::uint32_t t = 0; t < slots_.size(); ++t)
    for (std::uint32_t e = 0; e < 3; ++e)
      if (split_[slots_[t].corner[e]]) split_corners_.emplace_back(slots_[t].corner[e], half_of(t, e));
  std::sort(split_corners_.begin(), split_corners_.end());
}

std::span<const std::pair<std::uint32_t, std::uint32_t>> Surface::corners_of_split(std::uint32_t v) const {
  const auto begin = std::lower_bound(split_corners_.begin(), split_corners_.end(), std::pair{v, 0u});
  const auto end = std::upper_bound(begin, split_corners_.end(), std::pair{v, kNone});
  return {begin, end};
}

// Only the swap that owns the slot of out_[v] replaces it; a neighbour that swaps at the same time merely looks.
void Surface::leave_from(std::uint32_t v, const Quad& quad, std::uint32_t h) {
  std::atomic_ref out(out_[v]);
  const std::uint32_t slot = slot_of(out.load(std::memory_order_relaxed));
  if (slot == quad.t || slot == quad.u) out.store(h, std::memory_order_relaxed);
}

void Surface::swap(const Quad& q) {
  const std::uint32_t bc = twin(q.bc), ca = twin(q.ca), ad = twin(q.ad), db = twin(q.db);
  slots_[q.t].corner = {q.c, q.d, q.b};
  slots_[q.u].corner = {q.d, q.c, q.a};
  const std::uint32_t t = half_of(q.t, 0), u = half_of(q.u, 0);
  link(t, u);
  link(t + 1, db);
  link(t + 2, bc);
  link(u + 1, ca);
  link(u + 2, ad);
  leave_from(q.c, q, t);
  leave_from(q.d, q, t + 1);
  leave_from(q.b, q, t + 2);
  leave_from(q.a, q, u + 2);
}

void Surface::write_to(Mesh& mesh) const {
  // Buckets by least vertex, then the handful of each sorted.
  std::vector<std::uint32_t> first(at_.size() + 2, 0);
  auto least = [](const Slot& s) { return std::min({s.corner[0], s.corner[1], s.corner[2]}); };
  for (const Slot& s : slots_) ++first[least(s) + 2];
  std::partial_sum(first.begin(), first.end(), first.begin());
  struct Face {
    Triangle corners;
    std::uint32_t patch;
  };
  std::vector<Face> faces(slots_.size());
  for (std::size_t t = 0; t < slots_.size(); ++t) {
    Face face{slots_[t].corner, patch_.empty() ? 0 : patch_[t]};
    std::rotate(face.corners.begin(), std::min_element(face.corners.begin(), face.corners.end()), face.corners.end());
    faces[first[face.corners[0] + 1]++] = face;
  }
  for (std::size_t v = 0; v < at_.size(); ++v)
    std::sort(faces.begin() + first[v], faces.begin() + first[v + 1],
              [](const Face& a, const Face& b) { return a.corners < b.corners; });
  for (std::size_t t = 0; t < faces.size(); ++t) {
    mesh.triangles[t] = faces[t].corners;
    if (!mesh.patch.empty()) mesh.patch[t] = faces[t].patch;
  }
}

}  // namespace scanmill::optimise
