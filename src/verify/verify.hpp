// SPDX-License-Identifier: Apache-2.0
// A mesh judged against every input point (Bradley 2001, section 5: greatest fit error, cross-checked here by every
// point's exact distance).
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/result.hpp"
#include "cloud/cloud.hpp"
#include "lattice/bin_index.hpp"
#include "mesh/mesh.hpp"
#include "verify/params.hpp"
#include "verify/quality.hpp"
#include "verify/report.hpp"

namespace scanmill::verify {

/// Which bins the vertices came from.
inline constexpr std::uint32_t kNoVertex = 0xffffffffu;
struct VertexBins {
  Lattice lattice;
  BinKey base;                                   // bins of the index are base + local
  const BinIndex* index = nullptr;               // local bin -> row
  std::span<const std::uint32_t> vertex_of_row;  // vertex of the mesh, or kNoVertex; one per row of the index
};

/// What the distances are stated in and against.
struct Terms {
  double bin_mm = 1;                              // h: unit of sums, histogram and coverage
  double sensor_accuracy_mm = kPaperAccuracy;     // the job's sensor.accuracy_mm
  std::span<const std::string> patch_names = {};  // by patch number; may be shorter
  std::optional<VertexBins> vertex_bins;
};

/// Distance of every point to the mesh as it will be written.
///
/// mesh     any mesh with a triangle, sound or not; a point's place is taken relative to mesh.offset
/// points   global frame, mm; read once, blocks in parallel, in any order
/// returns  the same for any number of threads and any order of blocks: greatest values are exact, sums whole numbers
/// errors   BadInput when no triangle of the mesh has an area, check_mesh refuses it, no point is there, or one lies
///          beyond 1e15 mm; BadParameter when the bin edge is not positive or a gate outside its limits; Cancelled;
///          what `points` reports
/// ties     of equally near triangles the one with the least number
/// cost     about 0.4 us per point in scan order, 0.8 us shuffled; 200 bytes per triangle, 32 per vertex, 2 to 90 MB
///          per thread
/// source   signs: Baerentzen and Aanaes 2005
Result<Report> verify_mesh(const Mesh& mesh, const PointSource& points, const Terms& terms, const Params& params,
                           const Context& context);

/// What a pass over a piece of the points has found. Bytes for the same machine family; nothing in them depends on
/// threads or the order of blocks.
struct PieceVerdict {
  /// Sums over the points of a vertex's own bin; vertices without such points are left out.
  struct Vertex {
    std::uint64_t vertex = 0, count = 0, low = 0, high = 0, worst = 0;
  };
  std::vector<Vertex> vertices;  // ascending
  std::string seen;              // everything else
};
/// The same as verify_mesh over a part of the points, without its conclusions.
/// errors  those of verify_mesh
Result<PieceVerdict> verify_piece(const Mesh& mesh, const PointSource& piece, const Terms& terms, const Params& params,
                                  const Context& context);

/// The report of verify_mesh over all points, from verdicts on pieces of them: any pieces, in any order.
class PieceVerdicts {
 public:
  /// All three must outlive it.
  /// errors  those of verify_mesh before its pass
  static Result<PieceVerdicts> of(const Mesh& mesh, const Terms& terms, const Params& params);
  PieceVerdicts(PieceVerdicts&&) noexcept;
  ~PieceVerdicts();
  /// errors  BadInput when the verdict is cut or on another mesh
  Result<void> add(const PieceVerdict& verdict);
  /// errors  BadInput when no piece held a finite point
  Result<Report> report() &&;

 private:
  struct Impl;
  explicit PieceVerdicts(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// The job's limits against what was found: of all judged points the greatest distance and the rms.
std::vector<Gate> gates_of(const Params& params, double max_mm, double rms_mm);

}  // namespace scanmill::verify
