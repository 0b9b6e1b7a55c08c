// SPDX-License-Identifier: Apache-2.0
#include "pipeline/judge_scan.hpp"

#include <algorithm>
#include <atomic>
#include <numeric>

#include "base/text.hpp"
#include "pipeline/watched_points.hpp"
#include "verify/sections.hpp"

namespace scanmill::pipeline {
namespace {

/// A triangle's place in its patch by distance of its centroid from the seed, as growth gives it.
void rank_again(const Mesh& mesh, grow::Patches& patches) {
  if (patches.rank.empty()) return;
  std::vector<double> distance(mesh.triangles.size());
  for (std::size_t t = 0; t < distance.size(); ++t) {
    const Triangle& x = mesh.triangles[t];
    const Vec3 centroid = (mesh.positions[x[0]] + mesh.positions[x[1]] + mesh.positions[x[2]]) * (1.0 / 3);
    distance[t] = norm2(centroid + mesh.offset - patches.patches[mesh.patch[t]].seed);
  }
  std::vector<std::uint32_t> order(distance.size()), next(patches.patches.size(), 0);
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return distance[a] != distance[b] ? distance[a] < distance[b] : a < b;
  });
  for (const std::uint32_t t : order) patches.rank[t] = next[mesh.patch[t]]++;
}

constexpr int kNear = 2;  // bins

/// Per row: whether a vertex lies within kNear bins.
class VertexNeighbourhood {
 public:
  VertexNeighbourhood(const MeshedSurface& surface, const reduce::ReducedCloud& cloud)
      : cloud_(cloud), used_(cloud.size(), 0), reader_(cloud.index) {
    for (const std::uint32_t row : surface.vertex_row) used_[row] = 1;
  }
  bool used(std::size_t row) const { return used_[row] != 0; }
  bool holds_vertex(std::size_t row) {
    around_.clear();
    reader_.window(cloud_.bins[row], kNear, around_);
    return std::any_of(around_.begin(), around_.end(),
                       [&](std::int32_t near) { return used_[static_cast<std::size_t>(near)] != 0; });
  }

 private:
  const reduce::ReducedCloud& cloud_;
  std::vector<std::uint8_t> used_;
  BinIndex::Reader reader_;
  std::vector<std::int32_t> around_;
};

/// Per row of the reduced cloud: its points belong to a dropped piece.
std::vector<std::uint8_t> stray_bins(const MeshedSurface& surface, const reduce::ReducedCloud& cloud) {
  std::vector<std::uint8_t> stray(cloud.size(), 0);
  for (const std::uint32_t row : surface.stray_rows) stray[row] = 1;
  VertexNeighbourhood vertices(surface, cloud);
  BinIndex::Reader reader(cloud.index);
  std::vector<std::int32_t> around;
  for (const std::uint32_t row : surface.stray_rows) {
    around.clear();
    reader.window(cloud.bins[row], kNear, around);
    for (const std::int32_t other : around) {
      const auto at = static_cast<std::size_t>(other);
      if (!stray[at] && !vertices.used(at)) stray[at] = !vertices.holds_vertex(at);
    }
  }
  return stray;
}

/// Points without those of stray bins. A pure filter, so any order of blocks gives the same.
class JudgedPoints final : public PointSource {
 public:
  JudgedPoints(const PointSource& points, const reduce::ReducedCloud& cloud, std::vector<std::uint8_t> stray)
      : points_(points), cloud_(cloud), stray_(std::move(stray)) {}
  std::size_t block_count() const override { return points_.block_count(); }
  std::uint64_t expected_points() const override { return points_.expected_points(); }
  Result<void> read_block(std::size_t number, PointBlock& out) const override {
    TRY(points_.read_block(number, out));
    BinIndex::Reader reader(cloud_.index);
    std::size_t kept = 0;
    for (std::size_t i = 0; i < out.positions.size(); ++i) {
      if (is_stray(reader, out.positions[i])) continue;
      out.positions[kept] = out.positions[i];
      out.rows[kept++] = out.rows[i];
    }
    left_out_.fetch_add(out.positions.size() - kept, std::memory_order_relaxed);
    out.positions.resize(kept);
    out.rows.resize(kept);
    return {};
  }
  /// Over the blocks read so far.
  std::uint64_t left_out() const { return left_out_.load(); }

 private:
  bool is_stray(BinIndex::Reader& reader, Vec3 p) const {
    const BinKey key = bin_of(cloud_.lattice, p);
    const std::int32_t row = reader.row_at({static_cast<std::int32_t>(key.i - cloud_.base.i),
                                            static_cast<std::int32_t>(key.j - cloud_.base.j),
                                            static_cast<std::int32_t>(key.k - cloud_.base.k)});
    return row != kNoSlot && stray_[static_cast<std::size_t>(row)] != 0;
  }
  const PointSource& points_;
  const reduce::ReducedCloud& cloud_;
  std::vector<std::uint8_t> stray_;
  mutable std::atomic<std::uint64_t> left_out_{0};
};

}  // namespace

optimise::Limits swap_limits(const What& what, double bin_mm) {
  return {what.grow.range_bins * bin_mm, cos_of_degrees(what.grow.min_angle_deg)};
}

void measure_again(MeshedSurface& surface) {
  surface.patches.patch = surface.mesh.patch;
  measure_patches(surface.mesh, surface.patches);
  rank_again(surface.mesh, surface.patches);
}

Result<optimise::Report> optimise_surface(MeshedSurface& surface, const What& what, double bin_mm,
                                          const Context& context, Progress& progress) {
  progress.stage("optimise", 0, 0);
  TRY_ASSIGN(optimise::Report report,
             optimise::optimise(surface.mesh, what.optimise, swap_limits(what, bin_mm), context));
  measure_again(surface);
  return report;
}

namespace {

/// What distances are stated in, with the bins behind the vertices.
struct FitTerms {
  std::vector<std::uint32_t> vertex_of_row;
  verify::Terms terms;

  FitTerms(const MeshedSurface& surface, const reduce::ReducedCloud& cloud, const What& what)
      : vertex_of_row(cloud.size(), verify::kNoVertex) {
    for (std::size_t v = 0; v < surface.vertex_row.size(); ++v)
      vertex_of_row[surface.vertex_row[v]] = static_cast<std::uint32_t>(v);
    terms.bin_mm = cloud.lattice.edge_mm;
    terms.sensor_accuracy_mm = what.sensor.accuracy_mm;
    terms.vertex_bins = verify::VertexBins{cloud.lattice, cloud.base, &cloud.index, vertex_of_row};
  }
  FitTerms(const FitTerms&) = delete;
};

/// judge(points that count) and the number of those that do not.
template <class Judge>
auto without_stray_points(const MeshedSurface& surface, const reduce::ReducedCloud& cloud, const PointSource& points,
                          std::uint64_t& in_strays, Judge judge) -> decltype(judge(points)) {
  if (surface.stray_rows.empty()) return judge(points);
  const JudgedPoints judged(points, cloud, stray_bins(surface, cloud));
  auto result = judge(judged);
  in_strays = judged.left_out();
  return result;
}

}  // namespace

Result<Fit> measure_fit(const MeshedSurface& surface, const reduce::ReducedCloud& cloud, const PointSource& points,
                        const What& what, const Context& context, Progress& progress) {
  const WatchedPoints watched(points, "verify", progress);
  const FitTerms fit_terms(surface, cloud, what);
  Fit fit;
  TRY_ASSIGN(fit.report,
             without_stray_points(surface, cloud, watched, fit.points_in_strays, [&](const PointSource& judged) {
               return verify::verify_mesh(surface.mesh, judged, fit_terms.terms, what.verify, context);
             }));
  return fit;
}

Result<verify::PieceVerdict> judge_piece(const MeshedSurface& surface, const reduce::ReducedCloud& cloud,
                                         const PointSource& piece, const What& what, const Context& context,
                                         std::uint64_t& in_strays) {
  const FitTerms fit_terms(surface, cloud, what);
  return without_stray_points(surface, cloud, piece, in_strays, [&](const PointSource& judged) {
    return verify::verify_piece(surface.mesh, judged, fit_terms.terms, what.verify, context);
  });
}

struct FitOfPieces::Impl {
  FitTerms terms;
  Result<verify::PieceVerdicts> verdicts;
  std::uint64_t in_strays = 0;

  Impl(const MeshedSurface& surface, const reduce::ReducedCloud& cloud, const What& what)
      : terms(surface, cloud, what), verdicts(verify::PieceVerdicts::of(surface.mesh, terms.terms, what.verify)) {}
};

FitOfPieces::FitOfPieces(const MeshedSurface& surface, const reduce::ReducedCloud& cloud, const What& what)
    : impl_(new Impl(surface, cloud, what)) {}
FitOfPieces::~FitOfPieces() = default;

Result<void> FitOfPieces::add(const verify::PieceVerdict& verdict, std::uint64_t in_strays) {
  if (!impl_->verdicts.ok()) return impl_->verdicts.error();
  impl_->in_strays += in_strays;
  return impl_->verdicts->add(verdict);
}

Result<Fit> FitOfPieces::fit() && {
  TRY_ASSIGN(verify::PieceVerdicts verdicts, std::move(impl_->verdicts));
  Fit fit;
  TRY_ASSIGN(fit.report, std::move(verdicts).report());
  fit.points_in_strays = impl_->in_strays;
  return fit;
}

std::unique_ptr<PointSource> without_strays(const MeshedSurface& surface, const reduce::ReducedCloud& cloud,
                                            const PointSource& points) {
  std::vector<std::uint8_t> stray =
      surface.stray_rows.empty() ? std::vector<std::uint8_t>(cloud.size(), 0) : stray_bins(surface, cloud);
  return std::make_unique<JudgedPoints>(points, cloud, std::move(stray));
}

Result<SectionResults> cut_sections(const Mesh& mesh, std::span<const BorderLoop> loops, const PointSource& points,
                                    std::span<const verify::SectionRule> rules, double bin_mm,
                                    std::optional<Vec3> worst, const Context& context) {
  SectionResults results;
  verify::SectionFeatures features;
  features.worst = worst;
  const BorderLoop* longest = nullptr;
  for (const BorderLoop& loop : loops)
    if (!longest || loop.length_mm > longest->length_mm) longest = &loop;
  if (longest) features.longest_loop = longest->centre;
  for (const verify::SectionRule& rule : rules)
    if (rule.where == verify::SectionRule::Where::Loop && !longest)
      results.notes.push_back("verify.sections: there is no open loop to cut through");
  std::vector<double> magnify;
  TRY_ASSIGN(const auto frames, verify::section_frames(mesh, rules, bin_mm, features, magnify));
  TRY_ASSIGN(results.sections, verify::sections_of(mesh, points, frames, magnify, bin_mm, context));
  for (const Section& section : results.sections)
    if (section.lines.empty()) results.notes.push_back("section " + section.frame.name + " does not meet the mesh");
  return results;
}

Result<SectionResults> measure_sections(const MeshedSurface& surface, const reduce::ReducedCloud& cloud,
                                        const PointSource& points, const What& what, std::optional<Vec3> worst,
                                        const Context& context) {
  if (what.verify.sections.empty()) return SectionResults();
  std::optional<JudgedPoints> judged;
  if (!surface.stray_rows.empty()) judged.emplace(points, cloud, stray_bins(surface, cloud));
  const PointSource& source = judged ? static_cast<const PointSource&>(*judged) : points;
  return cut_sections(surface.mesh, surface.loops, source, what.verify.sections, cloud.lattice.edge_mm, worst, context);
}

Unmeshed unmeshed_points(const MeshedSurface& surface, const reduce::ReducedCloud& cloud) {
  const std::vector<std::uint8_t> stray = stray_bins(surface, cloud);
  VertexNeighbourhood vertices(surface, cloud);
  Unmeshed found;
  found.rows.assign(cloud.size(), 0);
  for (std::size_t row = 0; row < cloud.size(); ++row) {
    if (vertices.used(row) || vertices.holds_vertex(row)) continue;
    found.rows[row] = 1;
    if (stray[row]) continue;
    if (found.bins == 0) found.first = cloud.measured[row];
    ++found.bins;
    found.points += static_cast<std::uint64_t>(cloud.counts[row]);
  }
  return found;
}

std::vector<std::string> failed_gates(const std::vector<verify::Gate>& gates) {
  std::vector<std::string> list;
  for (const verify::Gate& gate : gates)
    if (!gate.passed)
      list.push_back("verify." + gate.name + ": found " + six_digits(gate.found) + " mm, allowed " +
                     number_text(gate.limit) + " mm");
  return list;
}

}  // namespace scanmill::pipeline
