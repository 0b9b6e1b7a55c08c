// SPDX-License-Identifier: Apache-2.0
#include "clean/clean.hpp"

#include <algorithm>
#include <atomic>
#include <bit>
#include <mutex>

#include "base/digest.hpp"
#include "base/text.hpp"
#include "clean/smallest.hpp"
#include "cloud/over_blocks.hpp"

namespace scanmill::clean {
namespace {

// One in ten thousand of 8,192 points is less than one: a plane's share is known to about half a percent.
constexpr std::size_t kPlaneSample = 8192;

struct ByPosition {
  Vec3 p;
  bool operator<(const ByPosition& other) const { return before(p, other.p); }
};

/// By the coordinates alone: neither file names nor rows choose the sample.
std::uint64_t hash_of(Vec3 p) {
  auto bits = [](double value) { return std::bit_cast<std::uint64_t>(value == 0 ? 0.0 : value); };
  return mix64(bits(p.x) ^ mix64(bits(p.y) ^ mix64(bits(p.z))));
}
std::uint64_t hash_of(const SourceKey& source) { return mix64(source.row ^ mix64(index_of(source.view))); }

/// The points that no box takes, a fixed number of them.
Result<std::vector<Vec3>> sample_of(const PointSource& points, const Rules& rules, const Context& context) {
  std::vector<Smallest<ByPosition>> parts(static_cast<std::size_t>(context.loop.threads()),
                                          Smallest<ByPosition>(kPlaneSample));
  TRY(over_blocks(points, context, [&](int worker, const PointBlock& block) -> Result<void> {
    auto& part = parts[static_cast<std::size_t>(worker)];
    for (const Vec3& p : block.positions) {
      const std::uint64_t hash = hash_of(p);
      if (part.wants(hash) && rules.of(p) == Rule::Kept) part.offer(hash, {p});
    }
    return {};
  }));
  for (std::size_t worker = 1; worker < parts.size(); ++worker) parts[0].offer(parts[worker]);
  std::vector<Vec3> sample;
  for (const ByPosition& entry : parts[0].sorted()) sample.push_back(entry.p);
  return sample;
}

Result<void> fix_plane(const PointSource& points, const PlaneRule& rule, std::uint64_t seed, Rules& rules,
                       const Context& context) {
  FittedPlane plane;
  if (rule.fit) {
    TRY_ASSIGN(const std::vector<Vec3> sample, sample_of(points, rules, context));
    TRY_ASSIGN(plane, fit_largest_plane(sample, rule, seed, context));
  } else {
    plane.plane = {*rule.point, unit(*rule.normal)};
  }
  rules.plane = plane;
  rules.plane_distance_mm = rule.distance_mm;
  rules.below_plane = rule.below;
  return {};
}

/// The first point that stays so far; the bins are counted from near it.
Result<std::optional<Vec3>> first_kept(const PointSource& points, const Rules& rules) {
  PointBlock block;
  for (std::size_t number = 0; number < points.block_count(); ++number) {
    TRY(points.read_block(number, block));
    for (const Vec3& p : block.positions)
      if (rules.of(p) == Rule::Kept) return std::optional<Vec3>(p);
  }
  return std::optional<Vec3>();
}

Result<void> fix_outliers(const PointSource& points, const OutlierRules& outliers, double bin_mm, Rules& rules,
                          const Context& context) {
  const double edge = outliers.bin_mm.value_or(bin_mm);
  if (!(edge > 0))
    return fail(Code::BadParameter, "clean.outliers: found no bin edge; give clean.outliers.bin_mm or lattice.bin_mm");
  TRY_ASSIGN(const std::optional<Vec3> first, first_kept(points, rules));
  if (!first) return {};
  const OutlierLattice lattice = outlier_lattice(edge, *first);
  struct alignas(64) Part {
    BinCounter bins;
    std::vector<Vec3> kept;
  };
  std::vector<Part> parts(static_cast<std::size_t>(context.loop.threads()));
  TRY(over_blocks(points, context, [&](int worker, const PointBlock& block) -> Result<void> {
    Part& part = parts[static_cast<std::size_t>(worker)];
    part.kept.clear();
    for (const Vec3& p : block.positions)
      if (rules.of(p) == Rule::Kept) part.kept.push_back(p);
    return part.bins.add(lattice, part.kept);
  }));
  for (std::size_t worker = 1; worker < parts.size(); ++worker) {
    parts[0].bins.add(parts[worker].bins, lattice.base);
    parts[worker] = Part();
  }
  const CountedBins bins = parts[0].bins.sorted(lattice.base);
  const std::vector<BinFate> fate = judge_bins(bins, outliers, rules.outlier_report, context);
  if (context.cancel.is_set()) return fail(Code::Cancelled, "stopped on request");
  std::vector<LocalBin> going;
  for (std::size_t row = 0; row < fate.size(); ++row) {
    if (fate[row] == BinFate::Kept) continue;
    going.push_back(bins.bins[row]);
    rules.fates.push_back(fate[row]);
  }
  rules.outliers = BinIndex::over(going);
  rules.lattice = lattice;
  return {};
}

}  // namespace

const char* name_of(Rule rule) {
  static constexpr const char* kNames[kRules] = {
      "kept", "keep_box", "remove_box", "remove_plane", "below_plane", "outliers.statistical", "outliers.component"};
  return kNames[static_cast<std::size_t>(rule)];
}

std::uint64_t RuleCounts::removed() const {
  std::uint64_t sum = 0;
  for (std::size_t rule = 1; rule < kRules; ++rule) sum += points[rule];
  return sum;
}

Rule Rules::of(Vec3 p) const {
  if (keep_box && !keep_box->holds(p)) return Rule::KeepBox;
  for (const Box& box : remove_box)
    if (box.holds(p)) return Rule::RemoveBox;
  if (!plane) return Rule::Kept;
  const double height = plane->plane.height(p);
  if (std::abs(height) <= plane_distance_mm) return Rule::OnPlane;
  return below_plane && height < 0 ? Rule::BelowPlane : Rule::Kept;
}

Result<std::shared_ptr<const Rules>> fix_rules(const PointSource& points, const Params& params, double bin_mm,
                                               std::uint64_t seed, const Context& context) {
  std::string problems;
  for (const std::string& problem : params.problems()) problems += (problems.empty() ? "clean." : "\nclean.") + problem;
  if (!problems.empty()) return fail(Code::BadParameter, problems);
  auto rules = std::make_shared<Rules>();
  rules->keep_box = params.keep_box;
  rules->remove_box = params.remove_box;
  if (params.remove_plane) TRY(fix_plane(points, *params.remove_plane, seed, *rules, context));
  if (params.outliers) TRY(fix_outliers(points, *params.outliers, bin_mm, *rules, context));
  return std::shared_ptr<const Rules>(std::move(rules));
}

struct CleanPoints::Impl {
  const PointSource& points;
  std::shared_ptr<const Rules> rules;
  std::mutex mutex;  // of what follows
  std::vector<std::uint8_t> seen;
  std::vector<RuleCounts> by_view;
  Smallest<RemovedPoint> sample;
  std::atomic<std::uint64_t> greatest_wanted{~std::uint64_t{0}};

  Impl(const PointSource& source, std::shared_ptr<const Rules> fixed, std::size_t sample_size)
      : points(source), rules(std::move(fixed)), seen(source.block_count(), 0), sample(sample_size) {}

  /// The rule for each point of a block; Kept for those that stay.
  Result<std::vector<Rule>> judge(const PointBlock& block) const {
    std::vector<Rule> fate(block.positions.size());
    for (std::size_t i = 0; i < fate.size(); ++i) fate[i] = rules->of(block.positions[i]);
    if (rules->fates.empty()) return fate;
    std::vector<LocalBin> bins;
    std::vector<std::size_t> at;
    bins.reserve(fate.size());
    at.reserve(fate.size());
    for (std::size_t i = 0; i < fate.size(); ++i) {
      if (fate[i] != Rule::Kept) continue;
      LocalBin bin;
      if (!rules->lattice->bin_of(block.positions[i], bin))
        return fail(Code::BadInput,
                    "an input changed between two readings; let it be written to its end and run again");
      bins.push_back(bin);
      at.push_back(i);
    }
    std::vector<std::int32_t> rows(bins.size());
    BinIndex::Reader(rules->outliers).rows_of(bins, rows);
    for (std::size_t k = 0; k < rows.size(); ++k)
      if (rows[k] != kNoSlot)
        fate[at[k]] = rules->fates[static_cast<std::size_t>(rows[k])] == BinFate::Statistical ? Rule::Statistical
                                                                                              : Rule::Component;
    return fate;
  }

  void count(std::size_t number, const PointBlock& block, const std::vector<Rule>& fate) {
    {
      std::lock_guard<std::mutex> guard(mutex);
      if (seen[number]) return;
    }
    RuleCounts counts;
    std::vector<std::pair<std::uint64_t, RemovedPoint>> candidates;  // outside the lock: most are not wanted
    const std::uint64_t limit = greatest_wanted.load(std::memory_order_relaxed);
    for (std::size_t i = 0; i < fate.size(); ++i) {
      ++counts[fate[i]];
      if (fate[i] == Rule::Kept) continue;
      const SourceKey source{block.view, block.rows[i]};
      if (const std::uint64_t hash = hash_of(source); hash <= limit)
        candidates.push_back({hash, {source, block.positions[i], fate[i]}});
    }
    std::lock_guard<std::mutex> guard(mutex);
    if (seen[number]) return;  // another thread read it meanwhile
    seen[number] = 1;
    const std::size_t view = index_of(block.view);
    if (by_view.size() <= view) by_view.resize(view + 1);
    for (std::size_t rule = 0; rule < kRules; ++rule) by_view[view].points[rule] += counts.points[rule];
    for (const auto& [hash, point] : candidates) sample.offer(hash, point);
    greatest_wanted.store(sample.greatest_wanted(), std::memory_order_relaxed);
  }
};

CleanPoints::CleanPoints(const PointSource& points, std::shared_ptr<const Rules> rules, std::size_t sample)
    : impl_(new Impl(points, std::move(rules), std::max<std::size_t>(sample, 1))) {}
CleanPoints::~CleanPoints() = default;

std::size_t CleanPoints::block_count() const { return impl_->points.block_count(); }
std::uint64_t CleanPoints::expected_points() const { return impl_->points.expected_points(); }

Result<void> CleanPoints::read_block(std::size_t number, PointBlock& out) const {
  TRY(impl_->points.read_block(number, out));
  TRY_ASSIGN(const std::vector<Rule> fate, impl_->judge(out));
  impl_->count(number, out, fate);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < fate.size(); ++i) {
    if (fate[i] != Rule::Kept) continue;
    out.positions[kept] = out.positions[i];
    out.rows[kept++] = out.rows[i];
  }
  out.positions.resize(kept);
  out.rows.resize(kept);
  return {};
}

std::vector<RuleCounts> CleanPoints::counts_by_view() const {
  std::lock_guard<std::mutex> guard(impl_->mutex);
  return impl_->by_view;
}

RuleCounts CleanPoints::counts() const {
  RuleCounts all;
  for (const RuleCounts& view : counts_by_view())
    for (std::size_t rule = 0; rule < kRules; ++rule) all.points[rule] += view.points[rule];
  return all;
}

std::vector<RemovedPoint> CleanPoints::removed_sample() const {
  std::lock_guard<std::mutex> guard(impl_->mutex);
  std::vector<RemovedPoint> sample = impl_->sample.sorted();
  std::sort(sample.begin(), sample.end());
  return sample;
}

const Rules& CleanPoints::rules() const { return *impl_->rules; }

std::string summary_of(const RuleCounts& counts) {
  std::string text;
  for (std::size_t rule = 1; rule < kRules; ++rule)
    if (counts.points[rule] > 0)
      text += (text.empty() ? "" : ", ") + std::string(name_of(static_cast<Rule>(rule))) + " " +
              grouped(counts.points[rule]);
  return text;
}

}  // namespace scanmill::clean
