// SPDX-License-Identifier: Apache-2.0
// Entities of fitted surfaces, and the choice among the styles. Coordinates are multiples of the surfaces' quantum, so
// they are written with that many digits.
#pragma once
#include "export/iges_curves.hpp"
#include "export/iges_entities.hpp"

namespace scanmill::exporting {

inline constexpr std::string_view kPart2d = "00010500";  // part of another entity, in parameter space
inline constexpr int kSplineDegree = 3;

/// Digits behind the point of multiples of a power of ten up to 1.
inline int iges_decimals(double quantum) {
  int decimals = 0;
  for (double step = 1; step > quantum * 1.5 && decimals < 15; step /= 10) ++decimals;
  return decimals;
}

template <class Record>
void put_place(Record& record, Vec3 p, int decimals) {
  for (const double c : {p.x, p.y, p.z}) record.real(iges_fixed(c, decimals));
}

template <class Record>
void put_knots(Record& record, const CubicSpans& spans, int decimals) {
  for (std::size_t k = 0; k < spans.poles() + 4; ++k) record.real(iges_fixed(spans.knot(k), decimals));
}

/// A cubic tensor-product surface (128).
template <class Record, class Room>
void put_spline(Record& record, const SplineSurface& surface, int decimals, Room&& room) {
  record.integer(128);
  for (const std::size_t poles : {surface.u.poles(), surface.v.poles()})
    record.integer(static_cast<std::int64_t>(poles) - 1);
  for (const int word : {kSplineDegree, kSplineDegree, 0, 0, 1, 0, 0}) record.integer(word);  // open; polynomial
  put_knots(record, surface.u, decimals);
  put_knots(record, surface.v, decimals);
  for (std::size_t k = 0; k < surface.poles.size(); ++k) record.text("1."), room();
  for (const Vec3& pole : surface.poles) put_place(record, pole, decimals), room();
  for (const CubicSpans* spans : {&surface.u, &surface.v}) {
    record.text("0.");
    record.real(iges_fixed(spans->end(), decimals));
  }
}

/// A chart: its surface, per loop the curve on the plane of parameters, in space, and both together (142); then the
/// trimmed surface (144).
template <class Out>
Result<void> emit_chart(const IgesPlan& plan, Out& out, std::uint32_t number, int decimals) {
  const FittedChart& chart = plan.options.surfaces->charts[number];
  const std::uint64_t surface = plan.chart(number);
  Result<void> done;
  const auto room = [&] {  // long records leave the buffer in pieces
    if (done.ok()) done = out.flush_when_full();
  };
  out.entity({128, 0, kPart}, [&](auto& record) { put_spline(record, chart.surface, decimals, room); });
  TRY(done);
  for (std::uint64_t l = 0; l < chart.loops.size(); ++l) {
    const TrimLoop& loop = chart.loops[l];
    out.entity({126, 0, kPart2d}, [&](auto& record) {
      put_polyline(
          record, loop.parameters.size(), true, Vec3{0, 0, 1},
          [&](std::size_t k) {
            put_place(record, {loop.parameters[k].u, loop.parameters[k].v, 0}, decimals);
          },
          room);
    });
    TRY(done);
    out.entity({126, 0, kPart}, [&](auto& record) {
      put_polyline(
          record, loop.places.size(), true, std::nullopt,
          [&](std::size_t k) { put_place(record, loop.places[k], decimals); }, room);
    });
    TRY(done);
    out.entity({142, 0, kPart}, [&](auto& record) {
      record.integer(142);
      record.integer(0);  // how it was made: unspecified
      record.pointer(surface);
      record.pointer(surface + 1 + 3 * l);
      record.pointer(surface + 2 + 3 * l);
      record.integer(1);  // the curve on the surface counts
    });
  }
  out.entity(plan.entry(144, 0, kRoot, number), [&](auto& record) {
    record.integer(144);
    record.pointer(surface);
    record.integer(1);  // the first loop is the outer border
    record.integer(static_cast<std::int64_t>(chart.loops.size()) - 1);
    for (std::uint64_t l = 0; l < chart.loops.size(); ++l) record.pointer(surface + 3 + 3 * l);
    put_name(record, plan, number);
  });
  return out.flush_when_full();
}

template <class Out>
Result<void> emit_surfaces(const IgesPlan& plan, Out& out) {
  const FittedSurfaces& fitted = *plan.options.surfaces;
  const int decimals = iges_decimals(fitted.quantum_mm);
  for (std::uint32_t c = 0; c < fitted.charts.size(); ++c) TRY(emit_chart(plan, out, c, decimals));
  if (fitted.corners.empty()) return {};
  const auto facets = static_cast<std::uint32_t>(plan.patches.size() - 1);
  for (const auto& corners : fitted.corners) {
    out.entity(plan.entry(128, 0, kMember, facets), [&](auto& record) {
      put_flat(record, [&] {
        for (const std::size_t k : {0, 1, 2, 2}) put_place(record, corners[k], decimals);
      });
    });
    TRY(out.flush_when_full());
  }
  return emit_group(plan, out, facets);
}

template <class Out>
Result<void> emit_iges(const IgesPlan& plan, Out& out) {
  emit_heads(plan, out);
  switch (plan.options.style) {
    case IgesStyle::Brep:
      return emit_brep(plan, out);
    case IgesStyle::Trimmed:
      return emit_trimmed(plan, out);
    case IgesStyle::Patches:
      return emit_patches(plan, out);
    case IgesStyle::Wire:
      return emit_wire(plan, out);
    case IgesStyle::Surfaces:
      return emit_surfaces(plan, out);
  }
  return {};
}

}  // namespace scanmill::exporting
