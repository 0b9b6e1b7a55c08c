// SPDX-License-Identifier: Apache-2.0
#include "pipeline/run_scan.hpp"

#include <cmath>

#include "base/digest.hpp"
#include "base/paged_memory.hpp"
#include "base/text.hpp"
#include "cloud/over_blocks.hpp"
#include "pipeline/brick_rows.hpp"
#include "pipeline/clean_scan.hpp"
#include "pipeline/cut_reduction.hpp"
#include "pipeline/cut_stars.hpp"
#include "pipeline/cut_surface.hpp"
#include "pipeline/cut_swaps.hpp"
#include "pipeline/density.hpp"
#include "pipeline/finish_scan.hpp"
#include "pipeline/judge_scan.hpp"
#include "pipeline/read_order.hpp"
#include "pipeline/refine_scan.hpp"
#include "pipeline/scan_pictures.hpp"
#include "pipeline/scan_points.hpp"
#include "pipeline/scan_record.hpp"
#include "pipeline/surface.hpp"
#include "pipeline/watched_points.hpp"

namespace scanmill::pipeline {
namespace {

using provenance::NoteKind;

/// Stages do not know files: an error without a place gets the file that stands for the scan.
Error name_file(Error error, const ScanSpec& scan) {
  if (!error.where.empty()) return error;
  return std::move(error).at(scan.description.empty() ? scan.views.front().path : scan.description);
}

/// To a hundredth of a millimetre.
std::string place_text(Vec3 p) {
  auto text = [](double v) { return number_text(std::floor(v * 100 + 0.5) / 100); };
  return text(p.x) + " " + text(p.y) + " " + text(p.z);
}

void add_notes(const MeshedSurface& surface, const reduce::Report& report, const Mesh& mesh,
               std::vector<std::string>& notes) {
  if (report.not_finite > 0)
    notes.push_back(counted(report.not_finite, "point") + (report.not_finite == 1 ? " is" : " are") +
                    " NaN or infinite and dropped");
  if (!surface.strays.empty())
    notes.push_back(counted(surface.strays.size(), "stray component") +
                    (surface.strays.size() == 1 ? " was" : " were") + " dropped (" +
                    counted(surface.kept_in_strays, "point") + "), listed in the record under /strays");
  if (surface.sides_by_volume > 0 && !surface.loops.empty())
    notes.push_back("no view tells which side of " + counted(surface.sides_by_volume, "component") + " is outside; " +
                    (surface.sides_by_volume == 1 ? "it was" : "each was") +
                    " turned so that it bulges outward (ground: upward), which for open surfaces is a guess; where the "
                    "sensor sat says it (views: eye, or a scan plan with its sensor)");
  if (!(mesh.offset == Vec3{}))
    notes.push_back(
        "float32 would cost more than a thousandth of the bin edge this far from the origin: the STL is "
        "translated by " +
        number_text(0 - mesh.offset.x) + " " + number_text(0 - mesh.offset.y) + " " + number_text(0 - mesh.offset.z) +
        " mm");
}

std::vector<std::string> coverage_warnings(const ScanResults& all, const Unmeshed& off) {
  std::vector<std::string> list;
  const reduce::ReducedCloud& cloud = all.reduction.cloud;
  if (std::string note = fine_bins_note(cloud); !note.empty()) list.push_back(std::move(note));
  if (std::string note =
          coverage_note(all.fit.points_near, all.reduction.report.points_used, off, cloud, all.what.seeds.cover);
      !note.empty())
    list.push_back(std::move(note));
  return list;
}

/// What a few points far off hide of the rest; empty when they hide nothing.
std::string beyond_the_farthest(const verify::Report& fit, std::uint64_t points) {
  if (points == 0 || points >= fit.worst.size()) return {};
  const double last = std::abs(fit.worst[points - 1].signed_mm), next = std::abs(fit.worst[points].signed_mm);
  if (last < 2 * next) return {};
  return "; after the " + (points == 1 ? std::string("farthest point") : std::to_string(points) + " farthest points") +
         " the greatest distance is " + number_text(std::floor(next * 1000 + 0.5) / 1000) + " mm";
}

/// Where the mesh stands for nearly all points, but not for some.
void add_unmeshed_note(const ScanResults& all, const Unmeshed& off, std::vector<std::string>& notes) {
  if (off.points == 0) return;
  const std::string points = counted(off.points, "input point") + " in " + counted(off.bins, "bin");
  const std::string place = std::string(off.points == 1 ? "is" : "are") + " on no triangle, first near " +
                            place_text(off.first) + "; " + (off.points == 1 ? "it counts" : "they count") +
                            " in the fit error" + beyond_the_farthest(all.fit, off.points);
  if (all.what.seeds.cover)
    notes.push_back(points + " of bare surroundings " + place + ": remove " + (off.points == 1 ? "it" : "them") +
                    " (clean.outliers) or choose larger bins");
  else
    notes.push_back(points + ", where no given seed reaches (seeds.cover: false) or in bare surroundings, " + place);
}

/// What cleaning, meshing and judging have to say.
void add_findings(const ScanResults& all, NoteList& notes) {
  std::vector<std::string> found;
  add_clean_notes(all.cleaned, found);
  add_notes(all.surface, all.reduction.report, all.surface.mesh, found);
  if (all.points_in_strays > 0)
    found.push_back(counted(all.points_in_strays, "input point") + (all.points_in_strays == 1 ? " lies" : " lie") +
                    " in dropped components and " + (all.points_in_strays == 1 ? "is" : "are") +
                    " not part of the fit error");
  notes.add(std::move(found));
  const Unmeshed off = unmeshed_points(all.surface, all.reduction.cloud);
  std::vector<std::string> warnings = coverage_warnings(all, off), unmeshed;
  if (warnings.empty()) add_unmeshed_note(all, off, unmeshed);
  notes.add(std::move(warnings), NoteKind::Warning);
  notes.add(std::move(unmeshed));
}

/// errors  BadInput when no scan is so large, or so small
Result<void> check_size(const ScanPoints& points, const Bounds& bounds, double bin_mm, std::uint64_t points_used) {
  std::string problem = implausible_size(bounds, points.units_mm(), bin_mm, points_used);
  return problem.empty() ? Result<void>() : fail(Code::BadInput, std::move(problem));
}

/// The same of a scan that is cut, once `gather` has seen all of it.
Result<void> check_size(const ScanPoints& points, const Cut& cut, const What& what) {
  TRY_ASSIGN(const Totals totals, need_totals(cut));
  reduce::ReadCounts counts;
  add_counts(counts, totals.text.counts);
  return check_size(points, counts.bounds, *what.lattice.bin_mm, counts.points_used);
}

/// What a task of a scan that is cut makes. `source`: the cleaned points.
Result<void> make_what(const PartTask& task, const ScanPoints& points, const PointSource& source, const What& what,
                       const Cut& cut, const Context& context, Progress& progress) {
  switch (task.stage) {
    case PartStage::Stars:
      return star_batch(cut, task.number, what, context);
    case PartStage::Mesh:
      return mesh_cut(cut, what, context, progress);
    case PartStage::Swap:
      return swap_batch(cut, task.number, what, context);
    case PartStage::Join:
      return join_swaps(cut, what, context, progress);
    case PartStage::Verify:
      return verify_piece(cut, task.number, {source, points}, what, context);
    default:
      if (task.stage == PartStage::Points) TRY(check_size(points, cut, what));
      TRY(CutReduction(source, what.lattice, what.reduce, cut).make(task, context));
      return task.stage == PartStage::Gather ? check_size(points, cut, what) : Result<void>();
  }
}

Result<void> make_task(const PartTask& task, const ScanPoints& points, const PointSource& source, const What& what,
                       const Cut& cut, const Context& context, Progress& progress) {
  if (!is_done(cut, task)) TRY(make_what(task, points, source, what, cut, context, progress));
  remove_read_parts(cut, task.stage);
  return {};
}

/// "stars", of "stars 3".
std::string kind_word(PartStage stage) {
  const std::string name = name_of({stage, 0});
  return name.substr(0, name.find(' '));
}

/// Some part at the end of the scan is there.
bool has_come_far(const Cut& cut) {
  for (std::uint32_t n = 0; n < verify_tasks(cut); ++n)
    if (open_part(cut, {PartStage::Verify, n})) return true;
  return open_part(cut, {PartStage::Join, 0}).has_value();
}

/// Every part of the middle of the job that is not there, one after the other, and what they come to: those that a disk
/// lost. Where the parts have not been made yet it is too early.
Result<MadeSurface> make_in_parts(const ScanPoints& points, const PointSource& source, const What& what, const Cut& cut,
                                  const Context& context, Progress& progress, StageClock& clock) {
  if (!has_come_far(cut)) return need_part(cut, {PartStage::Join, 0}).error();
  for (const auto& wave : scan_waves(cut, what)) {
    const PartStage stage = wave.front().stage;
    if (stage == PartStage::Verify) break;
    for (const PartTask& task : wave) {
      const WatchedPoints watched(source, name_of(task), progress);
      TRY(make_task(task, points, watched, what, cut, context, progress));
    }
    if (stage >= PartStage::Settle) clock.lap(stage == PartStage::Settle ? "reduce" : kind_word(stage).c_str());
  }
  auto made = join_surface(cut);
  clock.lap("join");
  return made;
}

/// Once more when a part was found damaged: it is gone then, and made again.
template <class Make>
auto made_or_mended(Make make) -> decltype(make()) {
  auto made = make();
  return made.ok() || made.error().code != Code::IoFailed ? std::move(made) : make();
}

/// From the points to the finished mesh. `source`: the cleaned points in the order they are best read in. `notes`: what
/// the sensor's band says.
Result<MadeSurface> make_surface(const ScanPoints& points, const CleanedScan& cleaned, const PointSource& source,
                                 const What& what, const Context& context, Progress& progress, StageClock& clock,
                                 std::vector<std::string>& notes) {
  const WatchedPoints watched(source, "reduce", progress);
  auto reduced = reduce::reduce_cloud(watched, what.lattice, what.reduce, context);
  if (!reduced.ok()) return explained(std::move(reduced).error(), cleaned);
  TRY(points.check_bands(notes));
  MadeSurface made{std::move(reduced).value(), {}, {}};
  const reduce::Report& report = made.reduction.report;
  TRY(check_size(points, report.bounds, report.bin_mm, report.points_used));
  clock.lap("reduce");
  TimedStages timed(clock, progress);
  TRY_ASSIGN(made.surface, mesh_surface(made.reduction.cloud, report.bounds, what, context, timed));
  timed.end();
  TRY_ASSIGN(made.swaps, optimise_surface(made.surface, what, report.bin_mm, context, progress));
  clock.lap("optimise");
  return made;
}

}  // namespace

bool is_cuttable(const What& what) { return reduce::is_cuttable(what.lattice) && !what.refine.poses; }

Result<void> make_part(const std::string& archive, const ScanSpec& scan, const What& what, const Cut& cut,
                       const std::string& part, const Context& context, Progress& progress) {
  TRY_ASSIGN(const auto points, ScanPoints::open(archive, scan, what.units_mm, what.format));
  auto clean = clean_scan(*points, what, context, progress);
  if (!clean.ok()) return name_file(std::move(clean).error(), scan);
  const CleanedScan cleaned = std::move(clean).value();
  const WatchedPoints watched(*cleaned.points, part, progress);
  for (const auto& wave : scan_waves(cut, what))
    for (const PartTask& task : wave) {
      if (name_of(task) != part) continue;
      auto made = make_task(task, *points, watched, what, cut, context, progress);
      if (!made.ok()) return name_file(explained(std::move(made).error(), cleaned), scan);
      auto unchanged = points->verify_unchanged();
      if (!unchanged.ok()) (void)store::remove_tree(path_of(cut, part));  // made of two states of the file
      return unchanged;
    }
  return fail(Code::BadParameter, "found part '" + part + "'; such a scan has no part of this name", scan.name);
}

Result<BinCounts> count_scan(const std::string& archive, const ScanSpec& scan, const What& what, const Cut& cut,
                             const Context& context, Progress& progress) {
  TRY_ASSIGN(const auto points, ScanPoints::open(archive, scan, what.units_mm, what.format));
  auto clean = clean_scan(*points, what, context, progress);
  if (!clean.ok()) return name_file(std::move(clean).error(), scan);
  const CleanedScan cleaned = std::move(clean).value();
  auto counts = count_bins(WatchedPoints(*cleaned.points, "inputs", progress), what, cut, context);
  if (!counts.ok()) return name_file(explained(std::move(counts).error(), cleaned), scan);
  return counts;
}

std::vector<std::pair<std::string, std::string>> stage_versions() {
  return {{"read", "3"}, {"clean", "1"},    {"reduce", "3"}, {"stars", "2"},  {"front", "1"},  {"merge", "2"},
          {"grow", "2"}, {"optimise", "1"}, {"verify", "2"}, {"export", "3"}, {"record", "7"}, {"report", "6"}};
}

KeyTexts key_texts(const What& what, const std::string& scan) {
  document::Node keys = to_document(what_for(what, scan)), late = document::Node::map();
  for (const char* key : {"outputs", "previews", "sensor", "verify"}) {
    if (const document::Node* value = keys.find(key)) late.set(key, *value);
    std::erase_if(keys.entries(), [&](const document::Node::Entry& entry) { return entry.key == key; });
  }
  KeyTexts texts{document::to_canonical_json(keys), document::to_canonical_json(late)};
  // Views that were moved are not made again from a record: with them every key means meshing.
  if (what.refine.poses) texts.mesh += "\nrefine 2\n" + texts.late;
  return texts;
}

Result<ScanDigests> digests_of(const std::string& archive, const ScanSpec& scan, const KeyTexts& keys,
                               HashCache& cache) {
  Sha256 hash;
  auto line = [&](const std::string& text) {
    hash.add(std::string_view(text));
    hash.add(std::string_view("\n"));
  };
  for (const auto& [stage, version] : stage_versions()) line(stage + " " + version);
  line(keys.mesh);
  line(scan.name);
  if (!scan.broken.empty()) line("broken: " + scan.broken);  // mended elsewhere, perhaps: another scan's name
  if (!scan.description.empty()) {
    TRY_ASSIGN(const HashCache::Entry entry, cache.entry_of(archive + "/" + scan.description, scan.description));
    line(scan.description + " " + entry.sha256);
  }
  for (const ViewSpec& view : scan.views) {
    if (view.missing) {
      line(view.path + " missing");
      continue;
    }
    TRY_ASSIGN(const HashCache::Entry entry, cache.entry_of(archive + "/" + view.path, view.path));
    line(view.path + " " + entry.sha256);
  }
  ScanDigests digests;
  digests.mesh = hash.hex();
  digests.all = sha256_hex(digests.mesh + "\n" + keys.late + "\n");
  return digests;
}

Result<ScanResult> run_scan(const std::string& archive, const ScanSpec& scan, const What& what,
                            const std::string& folder, const RunFrame& frame, const Context& context,
                            Progress& progress, const std::optional<MadeParts>& in_tasks) {
  ScanResult result;
  result.name = scan.name;
  if (in_tasks) result.stage_times = in_tasks->took;
  const Cut* const cut = in_tasks ? &in_tasks->cut : nullptr;
  NoteList notes;
  notes.add(scan.notes, NoteKind::Archive);
  StageClock clock(result.stage_times);

  TRY_ASSIGN(const auto points, ScanPoints::open(archive, scan, what.units_mm, what.format));
  for (const OpenView& view : points->views())
    for (const std::string& note : view.header.notes) notes.add({view.path + ": " + note});
  clock.lap("open");

  auto moved = refine_scan(*points, scan, what, context, progress);
  if (!moved.ok()) return name_file(std::move(moved).error(), scan);
  const RefinedScan refined = std::move(moved).value();
  std::vector<std::string> moves;
  add_refine_notes(refined, *points, moves);
  notes.add(std::move(moves));
  if (refined.report) clock.lap("refine");

  auto clean = clean_scan(*points, what, context, progress);
  if (!clean.ok()) return name_file(std::move(clean).error(), scan);
  const CleanedScan cleaned = std::move(clean).value();
  if (cleaned.cleaned) clock.lap("clean");

  std::unique_ptr<PointSource> ordered;
  if (!cut) {
    auto best = in_best_order(*cleaned.points, what.lattice, what.reduce, context, progress);
    if (!best.ok()) return name_file(std::move(best).error(), scan);
    ordered = std::move(best).value();
    if (ordered) clock.lap("order");
  }
  const PointSource& source = ordered ? *ordered : *cleaned.points;
  const Cut* parts = cut && is_cuttable(what) ? cut : nullptr;
  std::vector<std::string> found;
  const auto in_parts = [&] { return make_in_parts(*points, source, what, *parts, context, progress, clock); };
  auto made =
      parts ? made_or_mended(in_parts) : make_surface(*points, cleaned, source, what, context, progress, clock, found);
  if (!made.ok() && parts) return name_file(explained(std::move(made).error(), cleaned), scan);
  if (!made.ok()) return name_file(std::move(made).error(), scan);
  // Other processes read the points: what the rules took is counted by one pass of its own.
  if (parts && cleaned.cleaned) {
    TRY(reduce::read_bounds(WatchedPoints(*cleaned.points, "clean", progress), context));
    clock.lap("clean");
  }

  ScanResults all{archive, scan, what, *points, cleaned, {}, {}};
  all.refined = &refined;
  progress.stage("verify", 0, 0);
  TRY_ASSIGN(all.quality, verify::quality_of(made->surface.mesh, context));
  const auto fit_of_pieces = [&] {
    return measure_fit_in_pieces(*parts, *made, {WatchedPoints(source, "verify", progress), *points}, what, context);
  };
  TRY_ASSIGN(Fit fit, parts ? made_or_mended(fit_of_pieces)
                            : measure_fit(made->surface, made->reduction.cloud, source, what, context, progress));
  // Which blocks were read is known when all pieces are there.
  if (parts)
    if (auto seen = points->check_bands(found); !seen.ok()) return name_file(std::move(seen).error(), scan);
  notes.add(std::move(found));
  all.reduction = std::move(made->reduction);
  all.surface = std::move(made->surface);
  all.swaps = std::move(made->swaps);
  MeshedSurface& surface = all.surface;
  all.fit = std::move(fit.report);
  all.points_in_strays = fit.points_in_strays;
  clock.lap("verify");
  const auto& farthest = all.fit.worst_interior.empty() ? all.fit.worst : all.fit.worst_interior;
  const std::optional<Vec3> worst = farthest.empty() ? std::nullopt : std::optional<Vec3>(farthest[0].place);
  FinishedScan finished;
  TRY_ASSIGN(finished.sections, measure_sections(surface, all.reduction.cloud, source, what, worst, context));
  if (!finished.sections.sections.empty()) clock.lap("sections");
  if (const Output* output = surfaces_output(what.outputs)) {
    const auto kept = without_strays(surface, all.reduction.cloud, source);
    const double bin_mm = all.reduction.report.bin_mm;
    TRY_ASSIGN(finished.surfaces, fit_scan_surfaces(surface.mesh, *kept, *output, bin_mm, context, progress));
    clock.lap("surfaces");
  }

  add_findings(all, notes);
  all.notes = std::move(notes);
  TRY_ASSIGN(all.digests, points->digests(context));
  TRY(points->verify_unchanged());
  TRY_ASSIGN(finished.record, record_of(all));
  finished.quality = std::move(all.quality);
  if (refined.report) {
    TRY_ASSIGN(WrittenFile motions, write_refinement(refined, *points, folder));
    finished.written.push_back(std::move(motions));
  }
  finished.cloud = &all.reduction.cloud;
  clock.lap("hash inputs");
  const auto draw = [&] { return write_pictures(all, folder, context, progress); };
  TRY(finish_scan(finished, what, frame, folder, draw, clock, progress, result));
  return result;
}

}  // namespace scanmill::pipeline
