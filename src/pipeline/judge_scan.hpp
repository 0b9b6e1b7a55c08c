// SPDX-License-Identifier: Apache-2.0
// The finished mesh, swapped and judged.
#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/progress.hpp"
#include "base/result.hpp"
#include "mesh/section.hpp"
#include "optimise/optimise.hpp"
#include "pipeline/surface.hpp"
#include "pipeline/what.hpp"
#include "reduce/reduce.hpp"
#include "verify/verify.hpp"

namespace scanmill::pipeline {

/// Edge swaps under the job's limits; patches are measured and their triangles ranked again, borders and loops stay.
Result<optimise::Report> optimise_surface(MeshedSurface& surface, const What& what, double bin_mm,
                                          const Context& context, Progress& progress);

/// What the swaps keep to.
optimise::Limits swap_limits(const What& what, double bin_mm);
/// After the swaps.
void measure_again(MeshedSurface& surface);

struct Fit {
  verify::Report report;
  std::uint64_t points_in_strays = 0;  // in bins of dropped pieces: listed with these, not judged
};

/// Distances of the points that were reduced, with the errors of each vertex's own bin. A piece that was dropped says
/// nothing about the mesh, so the points of its bins, and of bins within two of it that no vertex is as near to, are
/// counted apart.
Result<Fit> measure_fit(const MeshedSurface& surface, const reduce::ReducedCloud& cloud, const PointSource& points,
                        const What& what, const Context& context, Progress& progress);

/// The same over a piece of the points, without conclusions. `in_strays`: of its points, left out.
Result<verify::PieceVerdict> judge_piece(const MeshedSurface& surface, const reduce::ReducedCloud& cloud,
                                         const PointSource& piece, const What& what, const Context& context,
                                         std::uint64_t& in_strays);
/// Puts together what measure_fit gives from verdicts on pieces, in any order.
class FitOfPieces {
 public:
  /// All three must outlive it.
  FitOfPieces(const MeshedSurface& surface, const reduce::ReducedCloud& cloud, const What& what);
  ~FitOfPieces();
  /// errors  BadInput when the verdict is on another mesh
  Result<void> add(const verify::PieceVerdict& verdict, std::uint64_t in_strays);
  Result<Fit> fit() &&;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

struct SectionResults {
  std::vector<Section> sections;   // those the job asks for
  std::vector<std::string> notes;  // of those that could not be had
};

/// Cuts a mesh. `worst`: where the fit is worst.
Result<SectionResults> cut_sections(const Mesh& mesh, std::span<const BorderLoop> loops, const PointSource& points,
                                    std::span<const verify::SectionRule> rules, double bin_mm,
                                    std::optional<Vec3> worst, const Context& context);

/// `points` without those of dropped pieces; all three must outlive it.
std::unique_ptr<PointSource> without_strays(const MeshedSurface& surface, const reduce::ReducedCloud& cloud,
                                            const PointSource& points);

/// Cuts the mesh where the job says, with the same points as measure_fit. `worst`: where the fit is worst.
Result<SectionResults> measure_sections(const MeshedSurface& surface, const reduce::ReducedCloud& cloud,
                                        const PointSource& points, const What& what, std::optional<Vec3> worst,
                                        const Context& context);

/// Points in bins that have no vertex within two bins and belong to no dropped piece: no triangle reaches them.
struct Unmeshed {
  std::uint64_t points = 0, bins = 0;
  Vec3 first;                      // kept point of the first such bin by key
  std::vector<std::uint8_t> rows;  // per row of the reduced cloud: no vertex within two bins, dropped pieces included
};
Unmeshed unmeshed_points(const MeshedSurface& surface, const reduce::ReducedCloud& cloud);

/// One sentence per gate that failed.
std::vector<std::string> failed_gates(const std::vector<verify::Gate>& gates);

}  // namespace scanmill::pipeline
