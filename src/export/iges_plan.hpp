// SPDX-License-Identifier: Apache-2.0
// What the passes over the entities of an IGES file look up, and how entities are numbered: in blocks, so that every
// directory number follows by counting.
#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "export/iges.hpp"
#include "export/iges_lines.hpp"
#include "export/shells.hpp"

namespace scanmill::exporting {

struct PatchEntry {
  std::uint32_t id = 0;
  std::string name;
  std::vector<std::uint64_t> members;  // entities of its group (patches, wire)
};

/// Everything that the passes over the entities look up.
struct IgesPlan {
  const Mesh& mesh;
  const IgesOptions& options;
  Shells shells;                        // brep, wire
  std::vector<PatchEntry> patches;      // ascending ids
  std::vector<std::uint32_t> patch_of;  // per triangle: index into patches
  std::vector<std::array<IgesReal, 3>> position;
  std::vector<std::uint8_t> drawn;            // per triangle: has area
  std::vector<std::uint32_t> point_of;        // brep: vertex to its place among the points (116)
  std::vector<std::uint32_t> point_rows;      // brep: vertices that stand for a plane's place, ascending
  std::vector<std::uint64_t> first_of_chart;  // surfaces: entities before each chart's, and before the facets'
  std::uint64_t left_out = 0, faces = 0;

  // First entity of each block.
  std::uint64_t colours() const { return 0; }
  std::uint64_t names() const { return patches.size(); }
  std::uint64_t geometry() const { return 2 * patches.size(); }
  std::uint64_t lines() const { return geometry() + point_rows.size(); }
  std::uint64_t vertex_list() const { return lines() + shells.edges.size(); }
  std::uint64_t edge_list() const { return vertex_list() + 1; }
  std::uint64_t facets() const { return edge_list() + 1; }
  std::uint64_t face(std::uint64_t triangle) const { return facets() + 4 * triangle + 3; }
  /// Surfaces: the first entity of a chart, and of the facets.
  std::uint64_t chart(std::size_t number) const { return geometry() + first_of_chart[number]; }
  std::uint64_t roots() const { return facets() + 4 * mesh.triangles.size(); }

  IgesEntry entry(int type, int form, std::string_view status, std::uint32_t patch) const {
    return {type,
            form,
            status,
            std::int64_t{patches[patch].id} + 1,
            -static_cast<std::int64_t>(iges_directory_number(colours() + patch)),
            "PATCH",
            patches[patch].id};
  }
};

/// All but the texts of positions.
/// errors  BadInput where style brep cannot be had, or there is no triangle; Internal when patch ids do not fit the
/// mesh
Result<IgesPlan> iges_plan_of(const Mesh& mesh, const IgesOptions& options, const std::string& name);
/// 84 bytes per vertex; not before the count of entities is known to fit.
void iges_add_positions(IgesPlan& plan);
std::uint64_t iges_entities_of(const IgesPlan& plan);
/// All but lines and bytes.
IgesCounts iges_counts_of(const IgesPlan& plan);

}  // namespace scanmill::exporting
