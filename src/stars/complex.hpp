// SPDX-License-Identifier: Apache-2.0
// The growing set of triangles: fans per vertex, open edges counted as they come and go, a journal to undo a repair.
// Internal to `stars`.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "mesh/mesh.hpp"

namespace scanmill::stars {

/// Triangle numbers at one vertex; most vertices have fewer than eight.
class Fan {
 public:
  Fan() = default;
  Fan(const Fan&) = delete;
  Fan& operator=(const Fan&) = delete;
  Fan(Fan&& other) noexcept : size_(other.size_), capacity_(other.capacity_), heap_(other.heap_) {
    for (unsigned k = 0; k < kInline; ++k) inline_[k] = other.inline_[k];
    other.heap_ = nullptr;
    other.size_ = 0;
    other.capacity_ = kInline;
  }
  ~Fan() { delete[] heap_; }
  const std::uint32_t* begin() const { return heap_ != nullptr ? heap_ : inline_; }
  const std::uint32_t* end() const { return begin() + size_; }
  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  void add(std::uint32_t triangle);
  void remove(std::uint32_t triangle);

 private:
  static constexpr unsigned kInline = 8;
  std::uint32_t* data() { return heap_ != nullptr ? heap_ : inline_; }
  std::uint16_t size_ = 0, capacity_ = kInline;
  std::uint32_t inline_[kInline];
  std::uint32_t* heap_ = nullptr;
};

inline constexpr std::uint32_t kNone = 0xffffffffu;

class Complex {
 public:
  /// kept[v]: v is to be used; counted as unused while its fan is empty.
  explicit Complex(std::span<const std::uint8_t> kept);

  std::size_t vertex_count() const { return fans_.size(); }
  std::size_t triangle_count() const { return triangles_.size(); }  // numbers given so far, removed ones included
  const Triangle& triangle(std::uint32_t t) const { return triangles_[t]; }
  bool alive(std::uint32_t t) const { return alive_[t]; }
  std::uint8_t votes(std::uint32_t t) const { return votes_[t]; }
  const Fan& fan(std::uint32_t v) const { return fans_[v]; }
  bool kept(std::uint32_t v) const { return kept_[v]; }

  /// The triangle that holds the directed edge a -> b, or kNone.
  std::uint32_t half(std::uint32_t a, std::uint32_t b) const {
    for (const std::uint32_t t : fans_[a]) {
      const Triangle& x = triangles_[t];
      if ((x[0] == a && x[1] == b) || (x[1] == a && x[2] == b) || (x[2] == a && x[0] == b)) return t;
    }
    return kNone;
  }
  /// The other corners of t after v, in t's sense.
  void after(std::uint32_t t, std::uint32_t v, std::uint32_t& a, std::uint32_t& b) const {
    const Triangle& x = triangles_[t];
    const int k = x[0] == v ? 0 : x[1] == v ? 1 : 2;
    a = x[static_cast<std::size_t>((k + 1) % 3)];
    b = x[static_cast<std::size_t>((k + 2) % 3)];
  }
  /// All three directed edges are free.
  bool edges_free(const Triangle& t) const {
    return half(t[0], t[1]) == kNone && half(t[1], t[2]) == kNone && half(t[2], t[0]) == kNone;
  }

  /// Room for so many triangles at once.
  void reserve(std::size_t triangles);
  std::uint32_t add(const Triangle& t, int votes);
  void remove(std::uint32_t t);
  /// Makes a thinned-out vertex one to be used.
  void revive(std::uint32_t v);

  /// Half-edges without partner, and vertices to be used that have no triangle.
  std::int64_t open_edges() const { return open_edges_; }
  std::int64_t unused() const { return unused_; }
  /// v ends at least one half-edge without partner.
  bool is_open(std::uint32_t v) const { return open_at_[v] != 0; }

  /// From here on every change is kept in a journal until `keep` or `undo`. Not nested.
  void begin();
  void keep();
  void undo();
  /// Triangles added or removed since `begin`.
  std::vector<std::uint32_t> touched() const;

  /// v's triangles form one fan.
  bool single_fan(std::uint32_t v) const;
  /// Fans of v as groups of triangles joined over edges at v, each ascending; the order of groups is by least triangle.
  void split_fans(std::uint32_t v, std::vector<std::vector<std::uint32_t>>& groups) const;

 private:
  void link(std::uint32_t t);
  void unlink(std::uint32_t t);
  void count_edges(const Triangle& t, int sign);

  std::vector<Fan> fans_;
  std::vector<Triangle> triangles_;
  std::vector<std::uint8_t> alive_, votes_, kept_;
  std::vector<std::uint16_t> open_at_;
  std::int64_t open_edges_ = 0, unused_ = 0;
  struct Change {
    enum Kind : std::uint8_t { Added, Removed, Revived } kind;
    std::uint32_t what;
  };
  std::vector<Change> journal_;
  bool logging_ = false;
};

}  // namespace scanmill::stars
