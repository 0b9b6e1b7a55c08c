// SPDX-License-Identifier: Apache-2.0
#include "optimise/creases.hpp"

#include <algorithm>

#include "geom/angles.hpp"
#include "optimise/surface.hpp"

namespace scanmill::optimise {
namespace {

constexpr double kTick = 0x1p-24;  // of a degree, of unit_mm, of |n - n'|^2: room for 1e9 edges in 63 bits

std::uint64_t ticks(double value) { return static_cast<std::uint64_t>(value / kTick + 0.5); }

}  // namespace

void CreaseSums::add(const CreaseSums& other) {
  edges += other.edges;
  sharp += other.sharp;
  degrees += other.degrees;
  length += other.length;
  square += other.square;
}

Creases CreaseSums::creases(double unit_mm) const {
  Creases out;
  out.inner_edges = edges;
  out.sharp_edges = sharp;
  out.dihedral_sum_deg = static_cast<double>(degrees) * kTick;
  out.sharp_length_mm = static_cast<double>(length) * kTick * unit_mm;
  if (edges > 0) out.normal_variation_rms = std::sqrt(static_cast<double>(square) * kTick / static_cast<double>(edges));
  return out;
}

CreaseSums creases_of(const Surface& surface, double unit_mm, const Context& context,
                      std::span<const std::uint8_t> own) {
  constexpr std::size_t kGrain = 8192;
  std::vector<Vec3> normal(surface.slot_count());
  for_each_range(context, normal.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) normal[t] = surface.normal(static_cast<std::uint32_t>(t));
  });
  std::vector<CreaseSums> pieces((normal.size() + kGrain - 1) / kGrain);
  for_each_piece(context, normal.size(), kGrain, [&](std::size_t begin, std::size_t end, std::size_t piece, int) {
    CreaseSums sums;
    for (auto h = static_cast<std::uint32_t>(kPerSlot * begin); h < kPerSlot * end; ++h) {
      const std::uint32_t twin = surface.twin(h);
      if (twin == kNone || twin < h) continue;
      if (!own.empty() && !own[std::min(surface.from(h), surface.to(h))]) continue;
      const Vec3 change = normal[slot_of(h)] - normal[slot_of(twin)];
      const double chord2 = norm2(change), degrees = degrees_of_chord(std::sqrt(chord2));
      ++sums.edges;
      sums.degrees += ticks(degrees);
      sums.square += ticks(chord2);
      if (degrees <= kSharpDegrees) continue;
      ++sums.sharp;
      sums.length += ticks(norm(surface.at(surface.from(h)) - surface.at(surface.to(h))) / unit_mm);
    }
    pieces[piece] = sums;
  });
  CreaseSums all;
  for (const CreaseSums& sums : pieces) all.add(sums);
  return all;
}

}  // namespace scanmill::optimise
