// SPDX-License-Identifier: Apache-2.0
#include "cli/pipeline_work.hpp"

#include <algorithm>

#include "base/digest.hpp"
#include "pipeline/bin_forecast.hpp"
#include "pipeline/part_forecast.hpp"
#include "pipeline/what.hpp"

namespace scanmill::cli {

using document::Node;

namespace {

/// Whether name and file say all of it.
bool is_one_file(const pipeline::ScanSpec& scan) {
  const auto& [name, kind, description, units_mm, sensor, accuracy, datums, views, notes, broken] = scan;
  if (kind != pipeline::ScanKind::SingleFile || !description.empty() || units_mm != 0 || sensor || accuracy ||
      !datums.empty() || views.size() != 1 || !notes.empty() || !broken.empty())
    return false;
  const auto& [path, pose, in_file_units, mirrored, station, view_point, camera, missing, expected] = views[0];
  const Pose none;
  return pose.rotation == none.rotation && pose.translation == none.translation && !in_file_units && !mirrored &&
         station.empty() && !view_point.eye && !view_point.direction && !camera && !missing && expected.empty();
}

}  // namespace

const pipeline::ScanSpec& PipelineWork::spec_of(std::size_t scan, pipeline::ScanSpec& room) const {
  const Known& known = scans_[scan];
  if (known.spec) return *known.spec;
  room = {};
  room.name = known.name;
  room.views.resize(1);
  room.views[0].path = known.file;
  return room;
}

void PipelineWork::check_part(const Node& part, document::Problems& problems) const {
  pipeline::check_part(part, problems);
}

Node PipelineWork::overlay(Node base, const Node& over) const { return pipeline::overlay_what(std::move(base), over); }

Result<Node> PipelineWork::resolve(const Node& what, const std::string& name) const {
  TRY_ASSIGN(const pipeline::What values, pipeline::what_from(what, name));
  return pipeline::to_document(values);
}

Result<runner::Archive> PipelineWork::discover(const std::string& archive, const Node& what,
                                               const std::function<Node(const std::string& scan)>& what_for) {
  archive_ = archive;
  pipeline::DiscoveryKeys keys = pipeline::discovery_keys(what);
  keys.vertices_of = [&](const std::string& scan) {
    return pipeline::discovery_keys(what_for(scan)).mesh_vertices_as_scan;
  };
  TRY_ASSIGN(pipeline::Discovery found, pipeline::discover(archive, keys));
  runner::Archive result;
  result.notes = std::move(found.notes);
  scans_.clear();
  scans_.reserve(found.scans.size());
  result.scans.reserve(found.scans.size());
  for (pipeline::ScanSpec& scan : found.scans) {
    result.scans.push_back({scan.name, scan.notes, scan.broken, scan.kind == pipeline::ScanKind::Views});
    if (is_one_file(scan))
      scans_.push_back({std::move(scan.name), std::move(scan.views[0].path), nullptr});
    else
      scans_.push_back({scan.name, {}, std::make_unique<const pipeline::ScanSpec>(std::move(scan))});
  }
  return result;
}

Result<pipeline::KeyTexts> PipelineWork::keys_of(const pipeline::ScanSpec& scan, const Node& resolved) {
  if (last_resolved_.is_map() && document::same_values(last_resolved_, resolved)) return last_keys_;
  TRY_ASSIGN(const pipeline::What what, pipeline::what_from(resolved, scan.name));
  pipeline::KeyTexts keys = pipeline::key_texts(what, scan.name);
  if (what.views.empty()) {  // entries of `views` count for their scan alone
    last_resolved_ = resolved;
    last_keys_ = keys;
  }
  return keys;
}

Result<runner::Fingerprint> PipelineWork::fingerprint(std::size_t scan, const Node& resolved) {
  pipeline::ScanSpec room;
  const pipeline::ScanSpec& spec = spec_of(scan, room);
  TRY_ASSIGN(const pipeline::KeyTexts keys, keys_of(spec, resolved));
  runner::Fingerprint result;
  TRY_ASSIGN(pipeline::ScanDigests digests, pipeline::digests_of(archive_, spec, keys, hashes_));
  result.value = std::move(digests.all);
  result.mesh = std::move(digests.mesh);
  result.versions = pipeline::stage_versions();
  const auto add = [&](const std::string& path, bool missing) -> Result<void> {
    runner::InputFile input{path, {}, 0};
    if (!missing) {
      TRY_ASSIGN(const pipeline::HashCache::Entry entry, hashes_.entry_of(archive_ + "/" + path, path));
      input.sha256 = entry.sha256;
      input.bytes = entry.stamp.size;
    }
    result.inputs.push_back(std::move(input));
    return {};
  };
  if (!spec.description.empty()) TRY(add(spec.description, false));
  for (const pipeline::ViewSpec& view : spec.views) TRY(add(view.path, view.missing));
  return result;
}

std::vector<std::string> PipelineWork::paths_of(std::size_t scan) const {
  pipeline::ScanSpec room;
  const pipeline::ScanSpec& spec = spec_of(scan, room);
  std::vector<std::string> paths;
  if (!spec.description.empty()) paths.push_back(archive_ + "/" + spec.description);
  for (const pipeline::ViewSpec& view : spec.views)
    if (!view.missing) paths.push_back(archive_ + "/" + view.path);
  return paths;
}

std::optional<runner::Fingerprint> PipelineWork::known_fingerprint(std::size_t scan, const Node& resolved) {
  for (const std::string& path : paths_of(scan))
    if (!hashes_.knows(path)) return std::nullopt;
  auto known = fingerprint(scan, resolved);
  if (!known) return std::nullopt;
  return *std::move(known);
}

runner::InputLook PipelineWork::look_at(std::size_t scan) const {
  runner::InputLook look;
  for (const std::string& path : paths_of(scan)) {
    const auto stamp = store::stamp_of(path);
    if (!stamp) continue;
    look.bytes += stamp->size;
    look.newest_ns = std::max(look.newest_ns, stamp->mtime_ns);
  }
  return look;
}

namespace {

/// As the runner keeps it. Discovery's notes are known to the runner already.
runner::Outcome outcome_of(pipeline::ScanResult result, const pipeline::ScanSpec& spec) {
  runner::Outcome outcome;
  outcome.counts.set("points_read", result.points_read);
  outcome.counts.set("points_used", result.points_used);
  outcome.counts.set("points_meshed", result.points_meshed);
  outcome.counts.set("bins", result.bins);
  outcome.counts.set("kept", result.kept);
  outcome.counts.set("vertices", result.vertices);
  outcome.counts.set("triangles", result.triangles);
  outcome.counts.set("boundary_loops", result.boundary_loops);
  outcome.counts.set("patches", result.patches);
  outcome.counts.set("strays", result.strays);
  outcome.counts.set("max_error_mm", result.max_error_mm);
  outcome.counts.set("rms_mm", result.rms_mm);
  outcome.failed_gates = std::move(result.failed_gates);
  for (std::string& note : result.notes)
    if (std::find(spec.notes.begin(), spec.notes.end(), note) == spec.notes.end())
      outcome.notes.push_back(std::move(note));
  outcome.record_identity = std::move(result.record_identity);
  outcome.stage_seconds = std::move(result.stage_times.wall_s);
  outcome.stage_cpu_seconds = std::move(result.stage_times.cpu_s);
  return outcome;
}

}  // namespace

Result<runner::Outcome> PipelineWork::run(std::size_t scan, const Node& resolved, const std::string& folder,
                                          const Context& context, Progress& progress) {
  pipeline::ScanSpec room;
  const pipeline::ScanSpec& spec = spec_of(scan, room);
  TRY_ASSIGN(const pipeline::What what, pipeline::what_from(resolved, spec.name));
  std::optional<pipeline::MadeParts> parts;
  if (used_parts_ && used_parts_->scan == scan) {
    TRY_ASSIGN(pipeline::Cut cut, cut_of(scan, resolved, used_parts_->keys, used_parts_->folder));
    parts = pipeline::MadeParts{std::move(cut), used_parts_->took};
  }
  TRY_ASSIGN(pipeline::ScanResult result,
             pipeline::run_scan(archive_, spec, what, folder, frame_, context, progress, parts));
  return outcome_of(std::move(result), spec);
}

namespace {

constexpr std::uint64_t kPieceBytes = 512ull << 20;  // of input
constexpr std::uint32_t kMostParts = 4096, kEdge = 256;
constexpr const char* kInputs = "inputs";  // the part that reads all of the input once: its hash, and its bins

/// Numbers of the cut, by keys and bytes alone; the folder and the identity are not known yet.
pipeline::Cut cut_by(const runner::BrickKeys& keys, std::uint64_t bytes) {
  const auto by_bytes = static_cast<std::uint32_t>(std::min<std::uint64_t>(bytes / kPieceBytes + 1, kMostParts));
  pipeline::Cut cut;
  cut.pieces = keys.pieces > 0 ? static_cast<std::uint32_t>(keys.pieces) : by_bytes;
  cut.batches = keys.batches > 0 ? static_cast<std::uint32_t>(keys.batches) : by_bytes;
  cut.brick_bins = keys.edge_bins > 0 ? static_cast<std::uint32_t>(keys.edge_bins) : kEdge;
  return cut;
}

}  // namespace

Result<pipeline::Cut> PipelineWork::cut_of(std::size_t scan, const Node& resolved, const runner::BrickKeys& keys,
                                           const std::string& folder) {
  pipeline::Cut cut = cut_by(keys, look_at(scan).bytes);
  cut.folder = folder;
  TRY_ASSIGN(const runner::Fingerprint fingerprint, this->fingerprint(scan, resolved));
  cut.identity = sha256_hex(fingerprint.mesh + "\n" + std::to_string(cut.pieces) + " " + std::to_string(cut.batches) +
                            " " + std::to_string(cut.brick_bins) + "\n");
  return cut;
}

runner::CutParts PipelineWork::parts_of(std::size_t scan, const Node& resolved, const runner::BrickKeys& keys,
                                        const std::string& folder) const {
  pipeline::ScanSpec room;
  const pipeline::ScanSpec& spec = spec_of(scan, room);
  const std::uint64_t bytes = look_at(scan).bytes;
  const bool is_large = keys.cut_from > 0 && bytes >= keys.cut_from;
  if ((keys.edge_bins == 0 && !is_large) || !spec.broken.empty()) return {};
  const auto what = pipeline::what_from(resolved, spec.name);
  if (!what || !pipeline::is_cuttable(*what)) return {};
  runner::CutParts parts;
  parts.folder = folder;
  parts.waves.push_back({kInputs});
  parts.whole.push_back(false);
  for (const auto& wave : pipeline::scan_waves(cut_by(keys, bytes), *what)) {
    parts.whole.push_back(pipeline::wants_whole(wave.front().stage));
    parts.waves.emplace_back();
    for (const pipeline::PartTask& task : wave) parts.waves.back().push_back(pipeline::name_of(task));
  }
  return parts;
}

Result<void> PipelineWork::make_part(std::size_t scan, const Node& resolved, const runner::BrickKeys& keys,
                                     const std::string& folder, const std::string& part, const Context& context,
                                     Progress& progress) {
  pipeline::ScanSpec room;
  const pipeline::ScanSpec& spec = spec_of(scan, room);
  TRY_ASSIGN(const pipeline::What what, pipeline::what_from(resolved, spec.name));
  TRY_ASSIGN(const pipeline::Cut cut, cut_of(scan, resolved, keys, folder));
  if (part == kInputs) {  // its hash is known now; how large its parts will be is not
    if (pipeline::kept_counts(cut)) return {};
    TRY_ASSIGN(const pipeline::BinCounts bins, pipeline::count_scan(archive_, spec, what, cut, context, progress));
    return pipeline::keep_counts(cut, bins);
  }
  return pipeline::make_part(archive_, spec, what, cut, part, context, progress);
}

Result<std::optional<runner::CutForecast>> PipelineWork::forecast_parts(std::size_t scan, const Node& resolved,
                                                                        const runner::BrickKeys& keys,
                                                                        const std::string& folder,
                                                                        const Context& context, Progress& progress) {
  pipeline::ScanSpec room;
  const pipeline::ScanSpec& spec = spec_of(scan, room);
  TRY_ASSIGN(const pipeline::What what, pipeline::what_from(resolved, spec.name));
  TRY_ASSIGN(const pipeline::Cut cut, cut_of(scan, resolved, keys, folder));
  auto bins = pipeline::kept_counts(cut);
  if (!bins) {
    TRY_ASSIGN(bins, pipeline::count_scan(archive_, spec, what, cut, context, progress));
  }
  runner::CutForecast forecast{{}, {}, bins->of_all * pipeline::BinForecast::kBytesPerBin, bins->of_all};
  for (const pipeline::WaveForecast& wave : pipeline::forecast_waves(cut, what, *bins)) {
    forecast.disk.push_back(wave.disk);
    forecast.cpu.push_back(wave.cpu);
  }
  // What was made by an earlier run asks for nothing more.
  const auto waves = pipeline::scan_waves(cut, what);
  for (std::size_t n = 0; n < waves.size(); ++n)
    if (std::all_of(waves[n].begin(), waves[n].end(), [&](const auto& task) { return pipeline::is_done(cut, task); }))
      forecast.disk[n + 1] = 0;
  return std::optional(std::move(forecast));
}

void PipelineWork::use_parts(std::size_t scan, const runner::BrickKeys& keys, const std::string& folder,
                             const runner::StageSeconds& took) {
  used_parts_ = UsedParts{scan, keys, folder, {took.wall, took.cpu}};
}

Result<std::optional<runner::Outcome>> PipelineWork::rewrite(std::size_t scan, const Node& resolved,
                                                             const std::string& standing,
                                                             const std::vector<runner::OutputFile>& files,
                                                             const std::string& folder, const Context& context,
                                                             Progress& progress, std::string& refusal) {
  pipeline::ScanSpec room;
  const pipeline::ScanSpec& spec = spec_of(scan, room);
  TRY_ASSIGN(const pipeline::What what, pipeline::what_from(resolved, spec.name));
  pipeline::Previous previous{standing, {}};
  for (const runner::OutputFile& file : files) previous.files.push_back({file.name, file.sha256});
  TRY_ASSIGN(auto result,
             pipeline::rewrite_scan(archive_, spec, what, previous, folder, frame_, context, progress, refusal));
  if (!result) return std::optional<runner::Outcome>();
  return std::optional<runner::Outcome>(outcome_of(*std::move(result), spec));
}

}  // namespace scanmill::cli
