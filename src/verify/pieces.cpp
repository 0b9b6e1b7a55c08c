// SPDX-License-Identifier: Apache-2.0
#include "verify/pieces.hpp"

#include <algorithm>
#include <cstring>
#include <string_view>
#include <type_traits>

namespace scanmill::verify {
namespace {

/// Appends values as they stand in memory.
struct Writer {
  std::string& bytes;
  template <class T>
  void value(const T& v) {
    static_assert(std::is_trivially_copyable_v<T>);
    bytes.append(reinterpret_cast<const char*>(&v), sizeof v);
  }
  void ranks(const Ranks& r) {
    std::uint64_t used = 0;
    r.visit([&](std::size_t, std::uint64_t) { ++used; });
    value(used);
    r.visit([&](std::size_t bucket, std::uint64_t count) {
      value(static_cast<std::uint64_t>(bucket));
      value(count);
    });
  }
  void worst(const Worst& w) {
    value(static_cast<std::uint64_t>(w.list().size()));
    for (const WorstPoint& point : w.list()) value(point);
  }
};

/// Takes values off the front; everything is zero behind the first that is not there whole.
struct Reader {
  std::string_view bytes;
  bool whole = true;
  template <class T>
  T value() {
    T v{};
    if (bytes.size() < sizeof v) {
      whole = false;
      bytes = {};
      return v;
    }
    std::memcpy(&v, bytes.data(), sizeof v);
    bytes.remove_prefix(sizeof v);
    return v;
  }
  void ranks(Ranks& r) {
    for (auto left = value<std::uint64_t>(); whole && left > 0; --left) {
      const auto bucket = value<std::uint64_t>(), count = value<std::uint64_t>();
      whole = whole && bucket < Ranks::kBuckets;
      if (whole) r.add(static_cast<std::size_t>(bucket), count);
    }
  }
  void worst(Worst& w) {
    for (auto left = value<std::uint64_t>(); whole && left > 0; --left) {
      const auto point = value<WorstPoint>();
      if (whole) w.add(point);
    }
  }
};

}  // namespace

PieceVerdict verdict_of(const Seen& seen, const Marks& marks) {
  PieceVerdict verdict;
  Writer out{verdict.seen};
  for (const std::uint64_t count : {seen.points_read, seen.not_finite, seen.sensor_invalid, seen.points_near})
    out.value(count);
  for (const Sums* sums : {&seen.interior, &seen.open_border, &seen.patch_borders}) out.value(*sums);
  out.value(static_cast<std::uint64_t>(seen.patches.size()));
  for (const Sums& sums : seen.patches) out.value(sums);
  out.value(seen.histogram);
  out.ranks(seen.interior_ranks);
  out.ranks(seen.open_border_ranks);
  out.ranks(seen.patch_border_ranks);
  out.worst(seen.worst);
  out.worst(seen.worst_interior);
  out.value(static_cast<std::uint64_t>(marks.triangle_near.size()));
  for (std::size_t t = 0; t < marks.triangle_near.size(); t += 8) {
    std::uint8_t bits = 0;
    for (std::size_t n = t; n < std::min(t + 8, marks.triangle_near.size()); ++n)
      bits = static_cast<std::uint8_t>(bits | marks.triangle_near[n].load() << (n - t));
    out.value(bits);
  }
  if (!marks.vertices) return verdict;
  marks.vertices->visit_near([&](std::uint64_t word) { out.value(word); });
  verdict.vertices = marks.vertices->sums();
  return verdict;
}

bool add_verdict(const PieceVerdict& verdict, Seen& seen, Marks& marks) {
  Reader in{verdict.seen};
  Seen piece;
  for (std::uint64_t* count : {&piece.points_read, &piece.not_finite, &piece.sensor_invalid, &piece.points_near})
    *count = in.value<std::uint64_t>();
  for (Sums* sums : {&piece.interior, &piece.open_border, &piece.patch_borders}) *sums = in.value<Sums>();
  if (in.value<std::uint64_t>() != seen.patches.size()) return false;
  piece.patches.resize(seen.patches.size());
  for (Sums& sums : piece.patches) sums = in.value<Sums>();
  piece.histogram = in.value<SignedHistogram>();
  in.ranks(piece.interior_ranks);
  in.ranks(piece.open_border_ranks);
  in.ranks(piece.patch_border_ranks);
  in.worst(piece.worst);
  in.worst(piece.worst_interior);
  if (!in.whole || in.value<std::uint64_t>() != marks.triangle_near.size()) return false;
  seen.add(piece);
  for (std::size_t t = 0; t < marks.triangle_near.size(); t += 8) {
    const auto bits = in.value<std::uint8_t>();
    for (std::size_t n = t; n < std::min(t + 8, marks.triangle_near.size()); ++n)
      if ((bits >> (n - t) & 1) != 0) marks.triangle_near[n].store(1);
  }
  if (!marks.vertices) return in.whole && in.bytes.empty() && verdict.vertices.empty();
  marks.vertices->add_near([&] { return in.value<std::uint64_t>(); });
  return marks.vertices->add(verdict.vertices) && in.whole && in.bytes.empty();
}

}  // namespace scanmill::verify
