// SPDX-License-Identifier: Apache-2.0
#include "pipeline/clean_scan.hpp"

#include "base/text.hpp"
#include "pipeline/watched_points.hpp"

namespace scanmill::pipeline {
namespace {

/// The job has no seed of its own: equal jobs give equal bytes.
constexpr std::uint64_t kSeed = 0;

/// To one part of `per_unit`, for the reader of a sentence; the record has all digits.
std::string rounded(double value, double per_unit) {
  return number_text(std::floor(value * per_unit + 0.5) / per_unit + 0.0);
}
std::string triple(Vec3 p, double per_unit) {
  return rounded(p.x, per_unit) + " " + rounded(p.y, per_unit) + " " + rounded(p.z, per_unit);
}

}  // namespace

Result<CleanedScan> clean_scan(const PointSource& points, const What& what, const Context& context,
                               Progress& progress) {
  CleanedScan scan{&points, nullptr};
  if (!what.clean.any()) return scan;
  const WatchedPoints watched(points, "clean", progress);
  TRY_ASSIGN(auto rules, clean::fix_rules(watched, what.clean, what.lattice.bin_mm.value_or(0), kSeed, context));
  scan.cleaned = std::make_unique<clean::CleanPoints>(points, std::move(rules));
  scan.points = scan.cleaned.get();
  return scan;
}

Error explained(Error error, const CleanedScan& scan) {
  if (!scan.cleaned || error.code != Code::BadInput) return error;
  const clean::RuleCounts counts = scan.cleaned->counts();
  if (counts[clean::Rule::Kept] > 0 || counts.removed() == 0) return error;
  return fail(Code::BadInput, "the clean rules took all " + grouped(counts.removed()) + " points (" +
                                  clean::summary_of(counts) + "); widen keep_box, or correct the rule that took them");
}

void add_clean_notes(const CleanedScan& scan, std::vector<std::string>& notes) {
  if (!scan.cleaned) return;
  const clean::RuleCounts counts = scan.cleaned->counts();
  const clean::Rules& rules = scan.cleaned->rules();
  if (rules.plane && rules.plane->sample > 0)
    notes.push_back("clean: the plane found holds " + rounded(rules.plane->share * 100, 10) +
                    " % of the points; it goes through " + triple(rules.plane->plane.point, 1e3) + " mm with normal " +
                    triple(rules.plane->plane.normal, 1e6));
  if (counts.removed() > 0)
    notes.push_back("clean: " + grouped(counts.removed()) + " of " +
                    grouped(counts.removed() + counts[clean::Rule::Kept]) + " points were removed (" +
                    clean::summary_of(counts) + ")");
  else
    notes.push_back("clean: no rule took a point");
}

void add_clean_counters(const CleanedScan& scan, provenance::Record& record) {
  if (!scan.cleaned) return;
  auto add = [&](const std::string& name, double value, bool integer) {
    record.counters.push_back({"clean", name, value, integer});
  };
  auto count = [&](const std::string& name, std::uint64_t value) { add(name, static_cast<double>(value), true); };
  const clean::RuleCounts counts = scan.cleaned->counts();
  for (std::size_t rule = 0; rule < clean::kRules; ++rule) count(kCleanCounters[rule], counts.points[rule]);
  const clean::Rules& rules = scan.cleaned->rules();
  if (rules.plane) {
    const Vec3 &p = rules.plane->plane.point, &n = rules.plane->plane.normal;
    add("plane_point_x", p.x, false), add("plane_point_y", p.y, false), add("plane_point_z", p.z, false);
    add("plane_normal_x", n.x, false), add("plane_normal_y", n.y, false), add("plane_normal_z", n.z, false);
    if (rules.plane->sample > 0) {
      add("plane_share", rules.plane->share, false);
      add("plane_rms_mm", rules.plane->rms_mm, false);
    }
  }
  if (rules.lattice) {
    const clean::OutlierReport& report = rules.outlier_report;
    add("outlier_bin_mm", rules.lattice->edge_mm, false);
    add("outlier_mean_distance_bins", report.mean_distance, false);
    add("outlier_deviation_bins", report.deviation, false);
    add("outlier_greatest_distance_bins", report.greatest_distance, false);
    count("outlier_bins_statistical", report.statistical_bins);
    count("outlier_components", report.components);
    count("outlier_components_removed", report.components_removed);
    count("outlier_largest_removed", report.largest_removed);
  }
  const std::vector<clean::RuleCounts> views = scan.cleaned->counts_by_view();
  for (std::size_t view = 0; view < views.size() && view < record.inputs.size(); ++view)
    record.inputs[view].points_used -= views[view].removed();
}

}  // namespace scanmill::pipeline
