// SPDX-License-Identifier: Apache-2.0
// The mesh while its edges are being swapped: triangles in fixed slots, each edge known from both sides. Internal to
// `optimise`.
#pragma once
#include <array>
#include <atomic>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "mesh/mesh.hpp"

namespace scanmill::optimise {

inline constexpr std::uint32_t kNone = 0xffffffffu;

/// Half-edge 4 t + e runs from corner e of slot t to corner e + 1; numbers 4 t + 3 are not in use, so that no step
/// needs a division. Arrays per half-edge have kPerSlot entries for each slot.
inline constexpr std::uint32_t kPerSlot = 4;
constexpr std::uint32_t slot_of(std::uint32_t h) { return h >> 2; }
constexpr std::uint32_t half_of(std::uint32_t t, std::uint32_t e) { return t << 2 | e; }
constexpr std::uint32_t next_in(std::uint32_t h) { return (h & ~3u) | (0b00'10'01u >> 2 * (h & 3u) & 3u); }
constexpr std::uint32_t before_in(std::uint32_t h) { return (h & ~3u) | (0b01'00'10u >> 2 * (h & 3u) & 3u); }

struct alignas(32) Slot {
  Triangle corner;
  std::uint32_t unused = 0;
  std::array<std::uint32_t, kPerSlot> twin{kNone, kNone, kNone, kNone};  // the half-edge over each edge; last: kNone
};

/// The two triangles (a, b, c) and (b, a, d) at an edge a-b. After the swap: (c, d, b) in slot t and (d, c, a) in u.
struct Quad {
  std::uint32_t t, u;            // slots
  std::uint32_t a, b, c, d;      // vertices
  std::uint32_t bc, ca, ad, db;  // half-edges of t and u along the sides
};

class Surface {
 public:
  explicit Surface(const Mesh& mesh);

  std::size_t slot_count() const { return slots_.size(); }
  std::size_t vertex_count() const { return at_.size(); }
  Vec3 at(std::uint32_t v) const { return at_[v]; }
  std::span<const Vec3> positions() const { return at_; }
  const Slot& slot(std::uint32_t t) const { return slots_[t]; }
  std::uint32_t from(std::uint32_t h) const { return slots_[slot_of(h)].corner[h & 3u]; }
  std::uint32_t to(std::uint32_t h) const { return from(next_in(h)); }
  std::uint32_t twin(std::uint32_t h) const { return slots_[slot_of(h)].twin[h & 3u]; }
  /// Unit normal of a slot's triangle.
  Vec3 normal(std::uint32_t t) const {
    const Triangle& v = slots_[t].corner;
    return unit(cross(at_[v[1]] - at_[v[0]], at_[v[2]] - at_[v[0]]));
  }
  bool same_patch(std::uint32_t t, std::uint32_t u) const { return patch_.empty() || patch_[t] == patch_[u]; }

  /// h has a twin.
  Quad quad(std::uint32_t h) const {
    const std::uint32_t k = twin(h), t = slot_of(h), u = slot_of(k), bc = next_in(h), ca = next_in(bc), ad = next_in(k),
                        db = next_in(ad);
    return {t, u, from(h), from(bc), from(ca), from(db), bc, ca, ad, db};
  }
  /// Several fans meet at v, or v lies on an edge with more than two triangles; its triangles are never touched.
  bool is_split(std::uint32_t v) const { return split_[v] != 0; }

  /// visit(t, p, q) for each triangle (v, p, q) at v until it returns true; true then. Order is not defined.
  template <class Visit>
  bool any_around(std::uint32_t v, const Visit& visit) const {
    if (is_split(v)) {
      for (const auto& [vertex, h] : corners_of_split(v))
        if (visit(slot_of(h), to(h), from(before_in(h)))) return true;
      return false;
    }
    const std::uint32_t start = std::atomic_ref(const_cast<std::uint32_t&>(out_[v])).load(std::memory_order_relaxed);
    if (start == kNone) return false;
    std::uint32_t h = start;
    do {
      const std::uint32_t back = before_in(h);
      if (visit(slot_of(h), to(h), from(back))) return true;
      h = twin(back);
    } while (h != kNone && h != start);
    if (h == start) return false;
    for (h = twin(start); h != kNone; h = twin(h)) {  // an open fan: the other way from where it began
      h = next_in(h);
      if (visit(slot_of(h), to(h), from(before_in(h)))) return true;
    }
    return false;
  }

  /// Puts in the other diagonal. Quads that share no triangle with each other's sides may be swapped at the same time.
  void swap(const Quad& quad);

  /// Triangles and patch numbers in the order of mesh.hpp.
  void write_to(Mesh& mesh) const;

 private:
  std::span<const std::pair<std::uint32_t, std::uint32_t>> corners_of_split(std::uint32_t v) const;
  void find_twins();
  void find_fans();
  void link(std::uint32_t h, std::uint32_t k) {
    slots_[slot_of(h)].twin[h & 3u] = k;
    if (k != kNone) slots_[slot_of(k)].twin[k & 3u] = h;
  }
  void leave_from(std::uint32_t v, const Quad& quad, std::uint32_t h);

  std::span<const Vec3> at_;
  std::span<const std::uint32_t> patch_;
  std::vector<Slot> slots_;
  std::vector<std::uint32_t> out_;  // some half-edge that leaves the vertex
  std::vector<std::uint8_t> split_;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> split_corners_;  // (vertex, half-edge that leaves it), ascending
};

}  // namespace scanmill::optimise
