// SPDX-License-Identifier: Apache-2.0
// Curves of IGES files beside single lines.
#pragma once
#include <optional>
#include <string>

#include "export/iges_lines.hpp"
#include "geom/vec3.hpp"

namespace scanmill::exporting {

inline constexpr std::string_view kIgesRoot = "00000000", kIgesMember = "00020000";

/// A polyline (126 of degree 1), its knots 0, 1, 2 ...; a closed one repeats its first place. `normal`: of the plane it
/// lies in, where it does. `place(k)` puts the k-th of `count` places; `room` is called every few bytes.
template <class Record, class Place, class Room>
void put_polyline(Record& record, std::size_t count, bool closed, std::optional<Vec3> normal, Place&& place,
                  Room&& room) {
  const std::size_t poles = closed ? count + 1 : count;
  record.integer(126);
  record.integer(static_cast<std::int64_t>(poles) - 1);
  record.integer(1);                                                                   // degree
  for (const int word : {normal ? 1 : 0, closed ? 1 : 0, 1, 0}) record.integer(word);  // polynomial; not periodic
  auto knot = [&](std::size_t k) { record.text(std::to_string(k) + "."); };
  knot(0);
  for (std::size_t k = 0; k < poles; ++k) knot(k), room();
  knot(poles - 1);
  for (std::size_t k = 0; k < poles; ++k) record.text("1."), room();  // weights
  for (std::size_t k = 0; k < poles; ++k) place(k == count ? 0 : k), room();
  knot(0);
  knot(poles - 1);
  const Vec3 n = normal.value_or(Vec3{});
  for (const double c : {n.x, n.y, n.z}) record.real(iges_fixed(c, 15));
}

}  // namespace scanmill::exporting
