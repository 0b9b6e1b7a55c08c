// SPDX-License-Identifier: Apache-2.0
// The entities of each style in directory order. `Out` is one of the passes of iges_lines.hpp.
#pragma once
#include "export/iges_plan.hpp"
#include "export/patch_colours.hpp"

namespace scanmill::exporting {

inline constexpr std::string_view kPart = "00010000";        // physically part of another entity
inline constexpr std::string_view kMember = "00020000";      // of a group
inline constexpr std::string_view kDefinition = "00000200";  // colours
inline constexpr std::string_view kProperty = "00020300";    // names, shared
inline constexpr std::string_view kRoot = "00000000";
inline constexpr int kNormalDecimals = 15;  // three of them and their type fit a line

template <class Record>
void put_position(Record& record, const IgesPlan& plan, std::uint32_t vertex) {
  for (const IgesReal& c : plan.position[vertex]) record.real(c);
}

/// Behind the parameters: no back pointers, one property: the name.
template <class Record>
void put_name(Record& record, const IgesPlan& plan, std::uint32_t patch) {
  record.integer(0);
  record.integer(1);
  record.pointer(plan.names() + patch);
}

template <class Out>
void emit_heads(const IgesPlan& plan, Out& out) {
  for (std::uint32_t p = 0; p < plan.patches.size(); ++p)
    out.entity({314, 0, kDefinition, 0, static_cast<std::int64_t>(p % 7 + 2), "COLOUR", plan.patches[p].id},
               [&](auto& record) {
                 record.integer(314);
                 for (const double share : patch_colour_shares(plan.patches[p].id))
                   record.real(iges_fixed(100 * share, 3));
               });
  for (std::uint32_t p = 0; p < plan.patches.size(); ++p)
    out.entity({406, 15, kProperty, 0, 0, "NAME", plan.patches[p].id}, [&](auto& record) {
      record.integer(406);
      record.integer(1);
      record.text(iges_hollerith(plan.patches[p].name));
    });
}

template <class Out>
void emit_line(const IgesPlan& plan, Out& out, const IgesEntry& entry, std::uint32_t a, std::uint32_t b) {
  out.entity(entry, [&](auto& record) {
    record.integer(110);
    put_position(record, plan, a);
    put_position(record, plan, b);
  });
}

/// Vertices and edges of all faces, in one list each.
template <class Out>
Result<void> emit_lists(const IgesPlan& plan, Out& out) {
  const auto& edges = plan.shells.edges;
  Result<void> done;
  out.entity({502, 1, kPart}, [&](auto& record) {
    record.integer(502);
    record.integer(static_cast<std::int64_t>(plan.mesh.positions.size()));
    for (std::uint32_t v = 0; v < plan.mesh.positions.size() && done.ok(); ++v) {
      put_position(record, plan, v);
      done = out.flush_when_full();
    }
  });
  TRY(done);
  out.entity({504, 1, kPart}, [&](auto& record) {
    record.integer(504);
    record.integer(static_cast<std::int64_t>(edges.size()));
    for (std::uint64_t e = 0; e < edges.size() && done.ok(); ++e) {
      record.pointer(plan.lines() + e);
      for (const std::uint32_t vertex : edges[e]) {
        record.pointer(plan.vertex_list());
        record.integer(std::int64_t{vertex} + 1);
      }
      done = out.flush_when_full();
    }
  });
  return done;
}

/// Direction, plane, loop and face of a triangle.
template <class Out>
void emit_facet(const IgesPlan& plan, Out& out, std::uint32_t t) {
  const Triangle& corners = plan.mesh.triangles[t];
  const std::uint64_t first = plan.facets() + 4 * std::uint64_t{t};
  out.entity({123, 0, kPart}, [&](auto& record) {
    const Vec3 a = plan.mesh.positions[corners[0]];
    const Vec3 n = cross(plan.mesh.positions[corners[1]] - a, plan.mesh.positions[corners[2]] - a);
    const double length = norm(n);
    record.integer(123);
    for (const double c : {n.x / length, n.y / length, n.z / length}) record.real(iges_fixed(c, kNormalDecimals));
  });
  out.entity({190, 0, kPart}, [&](auto& record) {
    record.integer(190);
    record.pointer(plan.geometry() + plan.point_of[corners[0]]);
    record.pointer(first);
  });
  out.entity({508, 1, kPart}, [&](auto& record) {
    record.integer(508);
    record.integer(3);
    for (std::size_t e = 0; e < 3; ++e) {
      record.integer(0);  // an edge, not a vertex
      record.pointer(plan.edge_list());
      record.integer(std::int64_t{plan.shells.edge_of[t][e]} + 1);
      record.integer(corners[e] < corners[(e + 1) % 3]);
      record.integer(0);  // no curve in parameter space
    }
  });
  const std::uint32_t patch = plan.patch_of[t];
  out.entity(plan.entry(510, 1, kPart, patch), [&](auto& record) {
    record.integer(510);
    record.pointer(first + 1);
    record.integer(1);
    record.integer(1);  // the loop is the outer one
    record.pointer(first + 2);
    put_name(record, plan, patch);
  });
}

template <class Out>
Result<void> emit_shells(const IgesPlan& plan, Out& out) {
  std::uint64_t entity = plan.roots();
  for (const Shell& shell : plan.shells.shells) {
    const bool solid = shell.closed && shell.volume_mm3 > 0;
    Result<void> done;
    out.entity({514, shell.closed ? 1 : 2, solid ? kPart : kRoot}, [&](auto& record) {
      record.integer(514);
      record.integer(static_cast<std::int64_t>(shell.triangles.size()));
      for (const std::uint32_t t : shell.triangles) {
        record.pointer(plan.face(t));
        record.integer(1);
        done = out.flush_when_full();
        if (!done.ok()) return;
      }
    });
    TRY(done);
    if (solid)
      out.entity({186, 0, kRoot}, [&](auto& record) {
        record.integer(186);
        record.pointer(entity);
        record.integer(1);
        record.integer(0);
      });
    entity += solid ? 2 : 1;
  }
  return {};
}

template <class Out>
Result<void> emit_brep(const IgesPlan& plan, Out& out) {
  for (const std::uint32_t v : plan.point_rows) {
    out.entity({116, 0, kPart}, [&](auto& record) {
      record.integer(116);
      put_position(record, plan, v);
      record.integer(0);
    });
    TRY(out.flush_when_full());
  }
  for (const auto& [a, b] : plan.shells.edges) {
    emit_line(plan, out, {110, 0, kPart}, a, b);
    TRY(out.flush_when_full());
  }
  TRY(emit_lists(plan, out));
  for (std::uint32_t t = 0; t < plan.mesh.triangles.size(); ++t) {
    emit_facet(plan, out, t);
    TRY(out.flush_when_full());
  }
  return emit_shells(plan, out);
}

/// A surface of degrees 1 and 1 whose four poles `poles` puts.
template <class Record, class Poles>
void put_flat(Record& record, Poles&& poles) {
  for (const int n : {128, 1, 1, 1, 1, 0, 0, 1, 0, 0}) record.integer(n);  // degrees 1, 1; polynomial; open
  for (int direction = 0; direction < 2; ++direction)
    for (const char* knot : {"0.", "0.", "1.", "1."}) record.text(knot);
  for (int pole = 0; pole < 4; ++pole) record.text("1.");  // weights
  poles();
  for (const char* bound : {"0.", "1.", "0.", "1."}) record.text(bound);
}

/// A plane patch with the corners a, b, d, c: b + c - a is d for a trimmed face, c for a face that ends there.
template <class Out>
void emit_bilinear(const IgesPlan& plan, Out& out, const IgesEntry& entry, const Triangle& t, bool degenerate) {
  out.entity(entry, [&](auto& record) {
    put_flat(record, [&] {
      put_position(record, plan, t[0]);
      put_position(record, plan, t[1]);
      put_position(record, plan, t[2]);
      if (degenerate) {
        put_position(record, plan, t[2]);
      } else {
        const Vec3 d = plan.mesh.positions[t[1]] + plan.mesh.positions[t[2]] - plan.mesh.positions[t[0]];
        for (const double c : {d.x, d.y, d.z}) record.real(iges_real(c));
      }
    });
  });
}

template <class Out>
Result<void> emit_trimmed(const IgesPlan& plan, Out& out) {
  std::uint64_t entity = plan.geometry();
  for (std::uint32_t t = 0; t < plan.mesh.triangles.size(); ++t) {
    if (!plan.drawn[t]) continue;
    const Triangle& corners = plan.mesh.triangles[t];
    emit_bilinear(plan, out, {128, 0, kPart}, corners, false);
    for (std::size_t e = 0; e < 3; ++e) emit_line(plan, out, {110, 0, kPart}, corners[e], corners[(e + 1) % 3]);
    out.entity({102, 0, kPart}, [&](auto& record) {
      record.integer(102);
      record.integer(3);
      for (std::uint64_t e = 1; e <= 3; ++e) record.pointer(entity + e);
    });
    out.entity({142, 0, kPart}, [&](auto& record) {
      record.integer(142);
      record.integer(0);  // how it was made: unspecified
      record.pointer(entity);
      record.integer(0);  // no curve in parameter space
      record.pointer(entity + 4);
      record.integer(2);  // the curve in space counts
    });
    const std::uint32_t patch = plan.patch_of[t];
    out.entity(plan.entry(144, 0, kRoot, patch), [&](auto& record) {
      record.integer(144);
      record.pointer(entity);
      record.integer(1);
      record.integer(0);
      record.pointer(entity + 5);
      put_name(record, plan, patch);
    });
    entity += 7;
    TRY(out.flush_when_full());
  }
  return {};
}

template <class Out>
Result<void> emit_group(const IgesPlan& plan, Out& out, std::uint32_t p) {
  Result<void> done;
  out.entity(plan.entry(402, 7, kRoot, p), [&](auto& record) {
    record.integer(402);
    record.integer(static_cast<std::int64_t>(plan.patches[p].members.size()));
    for (const std::uint64_t member : plan.patches[p].members) {
      record.pointer(member);
      done = out.flush_when_full();
      if (!done.ok()) return;
    }
    put_name(record, plan, p);
  });
  return done;
}

template <class Out>
Result<void> emit_groups(const IgesPlan& plan, Out& out) {
  for (std::uint32_t p = 0; p < plan.patches.size(); ++p) TRY(emit_group(plan, out, p));
  return {};
}

template <class Out>
Result<void> emit_patches(const IgesPlan& plan, Out& out) {
  for (std::uint32_t t = 0; t < plan.mesh.triangles.size(); ++t) {
    if (!plan.drawn[t]) continue;
    emit_bilinear(plan, out, plan.entry(128, 0, kMember, plan.patch_of[t]), plan.mesh.triangles[t], true);
    TRY(out.flush_when_full());
  }
  return emit_groups(plan, out);
}

template <class Out>
Result<void> emit_wire(const IgesPlan& plan, Out& out) {
  for (std::size_t e = 0; e < plan.shells.edges.size(); ++e) {
    const auto& [a, b] = plan.shells.edges[e];
    emit_line(plan, out, plan.entry(110, 0, kMember, plan.patch_of[plan.shells.first_triangle[e]]), a, b);
    TRY(out.flush_when_full());
  }
  return emit_groups(plan, out);
}

}  // namespace scanmill::exporting
