// SPDX-License-Identifier: Apache-2.0
// Every input point finds its nearest triangle; what is kept of it commutes (whole-number sums, greatest values,
// ranks), so blocks may come in any order and on any thread.
#include "verify/verify.hpp"

#include <algorithm>
#include <atomic>
#include <mutex>
#include <utility>

#include "base/text.hpp"
#include "verify/pieces.hpp"
#include "verify/sides.hpp"
#include "verify/space_order.hpp"

namespace scanmill::verify {
namespace {

constexpr double kFarthest = 1e15;  // mm
/// Cells by which the points of a block are put in order, in leaves of the index.
constexpr double kCellLeaves = 0.25;

/// The failure of the earliest block, so that the message does not depend on threads: blocks before a failed one are
/// still read.
class FirstFailure {
 public:
  bool is_behind(std::size_t block) const { return block > block_.load(std::memory_order_relaxed); }
  void set(std::size_t block, Error error) {
    const std::lock_guard guard(mutex_);
    if (block >= block_.load(std::memory_order_relaxed)) return;
    block_.store(block, std::memory_order_relaxed);
    error_ = std::move(error);
  }
  Result<void> result() && {
    if (block_.load() != kNone) return std::move(error_);
    return {};
  }

 private:
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);
  std::atomic<std::size_t> block_{kNone};
  std::mutex mutex_;
  Error error_;
};

struct Judged {
  const Mesh& mesh;
  const TriangleIndex index;
  const Sides sides;
  const Terms& terms;
  const std::size_t patch_count;
  Marks marks;

  Judged(const Mesh& m, const Terms& t, std::size_t patches)
      : mesh(m), index(m), sides(m), terms(t), patch_count(patches), marks(m, t) {}
  std::uint32_t patch_of(std::uint32_t triangle) const { return mesh.patch.empty() ? 0 : mesh.patch[triangle]; }
};

void count_signed(SignedHistogram& histogram, std::int64_t units) {
  constexpr std::int64_t kSide = SignedHistogram::kBinsEachSide << 20;
  constexpr std::int64_t kStep = (std::int64_t{1} << 20) / SignedHistogram::kStepsPerBin;
  if (units < -kSide)
    ++histogram.below;
  else if (units >= kSide)
    ++histogram.above;
  else
    ++histogram.counts[static_cast<std::size_t>((units + kSide) / kStep)];
}

class Worker {
 public:
  explicit Worker(Judged& judged)
      : judged_(judged), search_(judged.index), units_per_mm_(kUnitsPerBin / judged.terms.bin_mm) {
    seen.patches.resize(judged.patch_count);
    if (judged.marks.vertices) feed_.emplace(*judged.marks.vertices, *judged.terms.vertex_bins);
  }

  Result<void> take(const PointSource& points, std::size_t number) {
    block_.clear();
    TRY(points.read_block(number, block_));
    seen.points_read += block_.points_read;
    seen.not_finite += block_.not_finite;
    seen.sensor_invalid += block_.sensor_invalid;
    TRY(check_places());
    // Neighbours one after the other: they share a walk down the index, and caches.
    order_ = in_space_.of(block_.positions, judged_.index.leaf_size() * kCellLeaves);
    places_.resize(order_.size());
    local_.resize(order_.size());
    hits_.resize(order_.size());
    for (std::size_t n = 0; n < order_.size(); ++n) {
      places_[n] = block_.positions[order_[n]];
      local_[n] = places_[n] - judged_.mesh.offset;
    }
    search_.nearest(local_, hits_);
    if (feed_) feed_->begin(places_);
    for (std::size_t n = 0; n < order_.size(); ++n) judge(n);
    if (feed_) feed_->end();
    return {};
  }

  Seen seen;

 private:
  Result<void> check_places() const {
    for (std::size_t n = 0; n < block_.positions.size(); ++n) {
      const Vec3& at = block_.positions[n];
      if (!(std::max({std::abs(at.x), std::abs(at.y), std::abs(at.z)}) < kFarthest))
        return fail(Code::BadInput, "the point in row " + std::to_string(block_.rows[n]) + " of view " +
                                        std::to_string(index_of(block_.view)) + " lies at (" + number_text(at.x) +
                                        ", " + number_text(at.y) + ", " + number_text(at.z) +
                                        "); coordinates must be below 1e15 mm: check the file and its units");
    }
    return {};
  }
  void judge(std::size_t n) {
    const Hit& hit = hits_[n];
    const double distance = std::sqrt(hit.distance2);
    const std::int64_t units = units_of(distance, units_per_mm_);
    const bool is_above = judged_.sides.is_above(hit, local_[n]);
    const bool open_border = judged_.sides.at_open_border(hit);
    (open_border ? seen.open_border : seen.interior).add(distance, units, is_above);
    (open_border ? seen.open_border_ranks : seen.interior_ranks).add(units);
    if (judged_.sides.at_patch_border(hit)) {
      seen.patch_borders.add(distance, units, is_above);
      seen.patch_border_ranks.add(units);
    }
    seen.patches[judged_.patch_of(hit.triangle)].add(distance, units, is_above);
    count_signed(seen.histogram, is_above ? units : -units);
    const bool is_near = distance <= judged_.terms.bin_mm;
    seen.points_near += is_near;
    auto& near = judged_.marks.triangle_near[hit.triangle];
    if (is_near && near.load(std::memory_order_relaxed) == 0) near.store(1, std::memory_order_relaxed);
    if (feed_) feed_->add(n, distance, units, is_above, is_near);
    if (seen.worst.may_take(distance)) seen.worst.add(worst_point(n, distance, is_above, open_border));
    if (!open_border && seen.worst_interior.may_take(distance))
      seen.worst_interior.add(worst_point(n, distance, is_above, open_border));
  }
  WorstPoint worst_point(std::size_t n, double distance, bool is_above, bool open_border) const {
    const std::uint32_t triangle = hits_[n].triangle;
    return {places_[n], {block_.view, block_.rows[order_[n]]},
            distance,   is_above ? distance : -distance,
            triangle,   judged_.patch_of(triangle),
            open_border};
  }

  Judged& judged_;
  TriangleIndex::Search search_;
  double units_per_mm_;
  std::optional<VertexErrors::Feed> feed_;
  PointBlock block_;
  SpaceOrder in_space_;
  std::span<const std::uint32_t> order_;  // row of the block behind each place
  std::vector<Vec3> places_, local_;      // global; in the frame of the mesh
  std::vector<Hit> hits_;
};

Result<Seen> judge_points(Judged& judged, const PointSource& points, const Context& context) {
  std::vector<std::unique_ptr<Worker>> workers(static_cast<std::size_t>(context.loop.threads()));
  FirstFailure failure;
  context.loop.run(points.block_count(), [&](std::size_t number, int worker) {
    if (context.cancel.is_set() || failure.is_behind(number)) return;
    auto& mine = workers[static_cast<std::size_t>(worker)];
    if (!mine) mine = std::make_unique<Worker>(judged);
    if (auto taken = mine->take(points, number); !taken.ok()) failure.set(number, std::move(taken).error());
  });
  if (context.cancel.is_set()) return fail(Code::Cancelled, "stopped on request");
  TRY(std::move(failure).result());
  Seen all;
  all.patches.resize(judged.patch_count);
  bool first = true;
  for (auto& worker : workers) {
    if (!worker) continue;
    if (std::exchange(first, false))
      all = std::move(worker->seen);
    else
      all.add(worker->seen);
  }
  return all;
}

Result<std::size_t> check(const Mesh& mesh, const Terms& terms, const Params& params) {
  std::vector<std::string> problems = problems_of(Params::fields(), &params);
  if (!(terms.bin_mm > 0 && terms.bin_mm < 1e12))
    problems.push_back("found a bin edge of " + number_text(terms.bin_mm) + " mm; it must be positive");
  if (!(terms.sensor_accuracy_mm >= 0 && terms.sensor_accuracy_mm < 1e12))
    problems.push_back("sensor.accuracy_mm: found " + number_text(terms.sensor_accuracy_mm) + "; it must be 0 or more");
  if (!problems.empty()) {
    std::string text = problems.front();
    for (std::size_t n = 1; n < problems.size(); ++n) text += "\n" + problems[n];
    return fail(Code::BadParameter, text);
  }
  if (mesh.triangles.empty()) return fail(Code::BadInput, "the mesh has no triangle; distances need a surface");
  TRY(check_mesh(mesh));
  std::size_t patches = 1;
  for (const std::uint32_t patch : mesh.patch) patches = std::max<std::size_t>(patches, std::size_t{patch} + 1);
  if (patches > mesh.triangles.size() + terms.patch_names.size() + 1)
    return fail(Code::BadInput, "the mesh names patch " + std::to_string(patches - 1) + " but has only " +
                                    grouped(mesh.triangles.size()) + " triangles; patches are numbered from 0");
  if (terms.vertex_bins)
    for (const std::uint32_t v : terms.vertex_bins->vertex_of_row)
      if (v != kNoVertex && v >= mesh.positions.size())
        return fail(Code::Internal,
                    "a bin names vertex " + std::to_string(v) + " of " + std::to_string(mesh.positions.size()));
  return patches;
}

void state_patches(const Mesh& mesh, const Terms& terms, const Seen& seen, Report& report) {
  std::vector<std::uint64_t> triangles(seen.patches.size(), 0);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) ++triangles[mesh.patch.empty() ? 0 : mesh.patch[t]];
  for (std::uint32_t patch = 0; patch < triangles.size(); ++patch) {
    if (triangles[patch] == 0) continue;
    const auto& names = terms.patch_names;
    report.patches.push_back({patch, patch < names.size() ? names[patch] : std::string(), triangles[patch],
                              figures_of(seen.patches[patch], nullptr, report.bin_mm)});
  }
}

void state_coverage(const Mesh& mesh, const Terms& terms, const Marks& marks, Report& report) {
  Coverage& coverage = report.coverage;
  coverage.triangles = mesh.triangles.size();
  for (const auto& near : marks.triangle_near) coverage.triangles_near += near.load();
  if (!marks.vertices) return;
  coverage.bins = terms.vertex_bins->vertex_of_row.size();
  coverage.bins_near = marks.vertices->bins_near();
  report.vertices = marks.vertices->errors(report.bin_mm);
}

Result<Report> report_of(const Mesh& mesh, const Terms& terms, const Params& params, Seen seen, const Marks& marks) {
  Report report;
  report.bin_mm = terms.bin_mm;
  report.points_read = seen.points_read;
  report.not_finite = seen.not_finite;
  report.sensor_invalid = seen.sensor_invalid;
  report.points_near = seen.points_near;
  report.interior = figures_of(seen.interior, &seen.interior_ranks, terms.bin_mm);
  report.open_border = figures_of(seen.open_border, &seen.open_border_ranks, terms.bin_mm);
  report.patch_borders = figures_of(seen.patch_borders, &seen.patch_border_ranks, terms.bin_mm);
  seen.interior.add(seen.open_border);
  seen.interior_ranks.add(seen.open_border_ranks);
  report.all = figures_of(seen.interior, &seen.interior_ranks, terms.bin_mm);
  if (report.all.count == 0)
    return fail(Code::BadInput, "the cloud has no finite point; nothing can be compared with the mesh");
  state_patches(mesh, terms, seen, report);
  report.histogram = seen.histogram;
  report.histogram.step_mm = terms.bin_mm / SignedHistogram::kStepsPerBin;
  report.worst = seen.worst.list();
  report.worst_interior = seen.worst_interior.list();
  state_coverage(mesh, terms, marks, report);
  report.fit_error_mm = report.all.max_mm;
  report.sensor_accuracy_mm = terms.sensor_accuracy_mm;
  report.total_error_mm = report.fit_error_mm + report.sensor_accuracy_mm;
  report.gates = gates_of(params, report.all.max_mm, report.all.rms_mm);
  return report;
}

/// use(seen, marks) of a pass over the points, if the mesh can be judged.
template <class Use>
auto with_judged(const Mesh& mesh, const PointSource& points, const Terms& terms, const Params& params,
                 const Context& context, Use use) -> decltype(use(Seen(), std::declval<const Marks&>())) {
  TRY_ASSIGN(const std::size_t patches, check(mesh, terms, params));
  Judged judged(mesh, terms, patches);
  if (judged.index.empty())
    return fail(Code::BadInput, "no triangle of the mesh has an area; distances need a surface");
  TRY_ASSIGN(Seen seen, judge_points(judged, points, context));
  return use(std::move(seen), judged.marks);
}

}  // namespace

Result<Report> verify_mesh(const Mesh& mesh, const PointSource& points, const Terms& terms, const Params& params,
                           const Context& context) {
  return with_judged(mesh, points, terms, params, context, [&](Seen seen, const Marks& marks) {
    return report_of(mesh, terms, params, std::move(seen), marks);
  });
}

Result<PieceVerdict> verify_piece(const Mesh& mesh, const PointSource& piece, const Terms& terms, const Params& params,
                                  const Context& context) {
  return with_judged(mesh, piece, terms, params, context, [&](const Seen& seen, const Marks& marks) {
    return Result<PieceVerdict>(verdict_of(seen, marks));
  });
}

struct PieceVerdicts::Impl {
  const Mesh& mesh;
  const Terms& terms;
  const Params& params;
  Seen seen;
  Marks marks;
};

PieceVerdicts::PieceVerdicts(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
PieceVerdicts::PieceVerdicts(PieceVerdicts&&) noexcept = default;
PieceVerdicts::~PieceVerdicts() = default;

Result<PieceVerdicts> PieceVerdicts::of(const Mesh& mesh, const Terms& terms, const Params& params) {
  TRY_ASSIGN(const std::size_t patches, check(mesh, terms, params));
  std::unique_ptr<Impl> impl(new Impl{mesh, terms, params, {}, Marks(mesh, terms)});
  impl->seen.patches.resize(patches);
  return PieceVerdicts(std::move(impl));
}

Result<void> PieceVerdicts::add(const PieceVerdict& verdict) {
  if (!add_verdict(verdict, impl_->seen, impl_->marks))
    return fail(Code::BadInput, "is no verdict on a piece of points of this mesh");
  return {};
}

Result<Report> PieceVerdicts::report() && {
  return report_of(impl_->mesh, impl_->terms, impl_->params, std::move(impl_->seen), impl_->marks);
}

std::vector<Gate> gates_of(const Params& params, double max_mm, double rms_mm) {
  std::vector<Gate> gates;
  auto gate = [&](const char* name, const std::optional<double>& limit, double found) {
    if (limit) gates.push_back({name, *limit, found, found <= *limit});
  };
  gate("max_error_mm", params.max_error_mm, max_mm);
  gate("rms_mm", params.rms_mm, rms_mm);
  return gates;
}

}  // namespace scanmill::verify
