// SPDX-License-Identifier: Apache-2.0
#include "pipeline/refine_scan.hpp"

#include <algorithm>
#include <cmath>

#include "base/digest.hpp"
#include "base/text.hpp"
#include "document/document.hpp"
#include "store/files.hpp"

namespace scanmill::pipeline {
namespace {

using document::Node;

/// To a tenth of a micrometre, for sentences.
std::string short_mm(double value) { return number_text(std::floor(value * 1e4 + 0.5) / 1e4); }

Result<refine::Accuracy> accuracy_of(const ScanSpec& scan, const refine::Params& params) {
  const bool is_given = params.max_shift_mm && params.max_turn_deg;
  if (!is_given && !scan.accuracy)
    return fail(Code::BadParameter,
                "refine.poses is on, but how far the machine may be off is not known; give refine.max_shift_mm and "
                "refine.max_turn_deg, or a plan whose joints state their accuracy",
                scan.description);
  refine::Accuracy accuracy = scan.accuracy.value_or(refine::Accuracy{});
  accuracy.shift_mm = params.max_shift_mm.value_or(accuracy.shift_mm);
  accuracy.turn_deg = params.max_turn_deg.value_or(accuracy.turn_deg);
  return accuracy;
}

Node numbers_of(const Pose& pose) {
  Node list = Node::sequence();
  for (const double value : pose.matrix()) list.push(Node(value));
  return list;
}

std::string view_name(const ScanPoints& points, std::uint32_t view) {
  const ViewSpec& spec = points.specs()[view];
  return spec.station.empty() ? spec.path : spec.station;
}

constexpr const char* kMotions[] = {"turn about x",  "turn about y",  "turn about z",
                                    "shift along x", "shift along y", "shift along z"};

/// Bend says more than this of the stated accuracy: pieces are too coarse for the part.
constexpr double kCoarse = 0.1;

bool too_coarse(const RefinedScan& refined) {
  const refine::Report& report = *refined.report;
  return report.bend_mm > report.noise_mm && report.bend_mm > kCoarse * refined.accuracy.shift_mm;
}

}  // namespace

Result<RefinedScan> refine_scan(ScanPoints& points, const ScanSpec& scan, const What& what, const Context& context,
                                Progress& progress) {
  RefinedScan out;
  if (!what.refine.poses) return out;
  TRY_ASSIGN(out.accuracy, accuracy_of(scan, what.refine));
  if (what.refine.datum && scan.datums.empty())
    return fail(Code::BadParameter,
                "refine.datum is on, but the plan has no keep_out body that moves with the part (on: part)",
                scan.description);
  out.on_datum = what.refine.datum;
  progress.stage("refine", 0, 0);
  out.told.resize(points.specs().size());
  for (const OpenView& view : points.views()) out.told[index_of(view.id)] = view.pose;
  const std::vector<refine::Datum> none;
  TRY_ASSIGN(refine::Refinement refined,
             refine::refine_poses(points, out.told, out.accuracy, what.refine.datum ? scan.datums : none, what.refine,
                                  context));
  out.poses = std::move(refined.poses);
  out.report = std::move(refined.report);
  points.move_views(out.poses);
  return out;
}

void add_refine_notes(const RefinedScan& refined, const ScanPoints& points, std::vector<std::string>& notes) {
  if (!refined.report) return;
  const refine::Report& report = *refined.report;
  double shift = 0, turn = 0;
  std::string held;
  std::uint64_t at_limit = 0;
  for (std::size_t v = 0; v < report.views.size(); ++v) {
    shift = std::max(shift, report.views[v].shift_mm);
    turn = std::max(turn, report.views[v].turn_deg);
    if (!report.views[v].at_limit) continue;
    if (++at_limit <= 3) held += (held.empty() ? "" : ", ") + view_name(points, static_cast<std::uint32_t>(v));
  }
  if (too_coarse(refined))
    notes.push_back("refine: pieces of " + short_mm(report.patch_mm) +
                    " mm are coarse for this surface: its bend leaves their height open by " +
                    short_mm(report.bend_mm) + " mm, noise by " + short_mm(report.noise_mm) +
                    " mm; they count by that, and where they say little views stay where the machine says; denser "
                    "views tell more");
  std::string open;
  for (std::size_t i = 0; i < report.datum_open.size(); ++i)
    if (report.datum_open[i]) open += (open.empty() ? "" : ", ") + std::string(kMotions[i]);
  if (!open.empty())
    notes.push_back("refine: the datum's faces in view leave open: " + open +
                    " of the whole; there the machine's word counts");
  if (report.left) {
    notes.push_back("refine: views were left where the machine says: gaps between " +
                    counted(report.pairs.size(), "pair") + " of views are " + short_mm(report.before_mm) +
                    " mm there, and moving views brought them to " + short_mm(report.fitted_mm) +
                    " mm, no gain beyond noise");
    return;
  }
  notes.push_back("refine: views were moved by up to " + short_mm(shift) + " mm and " + short_mm(turn) +
                  " deg; gaps between " + counted(report.pairs.size(), "pair") + " of views went from " +
                  short_mm(report.before_mm) + " to " + short_mm(report.after_mm) + " mm" +
                  (report.settled ? "" : "; not settled after " + std::to_string(report.rounds) + " rounds"));
  if (at_limit > 0)
    notes.push_back("refine: " + counted(at_limit, "view") + " stopped at the machine's accuracy of " +
                    short_mm(refined.accuracy.shift_mm) + " mm and " + short_mm(refined.accuracy.turn_deg) +
                    " deg and would have gone farther: " + held + (at_limit > 3 ? ", ..." : "") +
                    "; is the sensor's mount calibrated?");
}

void add_refinement(const RefinedScan& refined, const ScanPoints& points, provenance::Record& record) {
  if (!refined.report) return;
  const refine::Report& report = *refined.report;
  auto add = [&](const char* name, double value, bool integer) {
    record.counters.push_back({"refine", name, value, integer});
  };
  add("rounds", static_cast<double>(report.rounds), true);
  add("settled", report.settled ? 1 : 0, true);
  add("patches", static_cast<double>(report.patches), true);
  add("matches", static_cast<double>(report.matches), true);
  add("datum_matches", static_cast<double>(report.datum_matches), true);
  add("patch_mm", report.patch_mm, false);
  add("max_shift_mm", refined.accuracy.shift_mm, false);
  add("max_turn_deg", refined.accuracy.turn_deg, false);
  add("gap_before_mm", report.before_mm, false);
  add("gap_after_mm", report.after_mm, false);
  add("datum_gap_before_mm", report.datum_before_mm, false);
  add("datum_gap_after_mm", report.datum_after_mm, false);
  for (const refine::PairReport& pair : report.pairs)
    record.pose_pairs.push_back({pair.a, pair.b, pair.matches, pair.before_mm, pair.after_mm});
  for (std::size_t v = 0; v < refined.told.size(); ++v) {
    record.told_poses.push_back(refined.told[v].matrix());
    if (!points.specs()[v].mirrored) continue;  // of the rows as the file holds them, like the poses of the inputs
    for (const std::size_t at : {2u, 6u, 10u}) record.told_poses[v][at] = 0 - record.told_poses[v][at];
  }
}

Result<WrittenFile> write_refinement(const RefinedScan& refined, const ScanPoints& points, const std::string& folder) {
  const refine::Report& report = *refined.report;
  Node root = Node::map();
  root.set("scanmill_refinement", std::int64_t{1});
  root.set("max_shift_mm", refined.accuracy.shift_mm);
  root.set("max_turn_deg", refined.accuracy.turn_deg);
  root.set("patch_mm", report.patch_mm);
  root.set("rounds", report.rounds);
  root.set("settled", report.settled);
  root.set("gap_before_mm", report.before_mm);
  root.set("gap_after_mm", report.after_mm);
  root.set("fitted_mm", report.fitted_mm);
  root.set("left", report.left);
  root.set("noise_mm", report.noise_mm);
  root.set("bend_mm", report.bend_mm);
  root.set("coarse", too_coarse(refined));
  if (refined.on_datum) {
    Node open = Node::sequence();
    for (std::size_t i = 0; i < report.datum_open.size(); ++i)
      if (report.datum_open[i]) open.push(Node(kMotions[i]));
    root.set("datum_open", std::move(open));
  }
  if (report.datum_matches > 0) {
    root.set("datum_matches", report.datum_matches);
    root.set("datum_gap_before_mm", report.datum_before_mm);
    root.set("datum_gap_after_mm", report.datum_after_mm);
  }
  Node views = Node::sequence();
  for (std::size_t v = 0; v < report.views.size(); ++v) {
    const refine::ViewReport& view = report.views[v];
    Node row = Node::map();
    row.set("view", view_name(points, static_cast<std::uint32_t>(v)));
    row.set("patches", view.patches);
    row.set("shift_mm", view.shift_mm);
    row.set("turn_deg", view.turn_deg);
    row.set("at_limit", view.at_limit);
    row.set("told_pose", numbers_of(refined.told[v]));
    row.set("pose", numbers_of(refined.poses[v]));
    views.push(std::move(row));
  }
  root.set("views", std::move(views));
  Node pairs = Node::sequence();
  for (const refine::PairReport& pair : report.pairs) {
    Node row = Node::map();
    row.set("a", view_name(points, pair.a));
    row.set("b", view_name(points, pair.b));
    row.set("matches", pair.matches);
    row.set("before_mm", pair.before_mm);
    row.set("after_mm", pair.after_mm);
    pairs.push(std::move(row));
  }
  root.set("pairs", std::move(pairs));
  const std::string text = document::to_json(root, 1) + "\n";
  WrittenFile file;
  file.name = "refinement.json";
  file.bytes = text.size();
  file.sha256 = sha256_hex(text);
  TRY(store::write_text(folder + "/" + file.name, text));
  return file;
}

}  // namespace scanmill::pipeline
