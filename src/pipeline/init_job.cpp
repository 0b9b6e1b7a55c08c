// SPDX-License-Identifier: Apache-2.0
#include "pipeline/init_job.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "base/text.hpp"
#include "document/document.hpp"
#include "pipeline/cloud_measure.hpp"
#include "pipeline/discovery.hpp"
#include "pipeline/init_depth.hpp"
#include "pipeline/scan_points.hpp"
#include "pipeline/watched_points.hpp"
#include "pipeline/what.hpp"
#include "plan/plan.hpp"
#include "store/files.hpp"

namespace scanmill::pipeline {
namespace {

constexpr std::size_t kMeasured = 40;  // scans looked at in full
constexpr double kDiffers = 1.1;       // bins that differ by more than this get an override
constexpr double kNoisesOfDepth = 8;   // in a bin of depth maps: noise of an eighth of a bin meshes well
constexpr double kBinsOfFew = 10;      // across a scan with too few points to tell

/// Units by the size an object would have: a scanned part is 5 mm to 5 m; larger only when metres make a room of it.
struct UnitGuess {
  const char* word;
  const char* reason;
};

UnitGuess guess_units(double extent) {
  if (extent >= 5 && extent <= 5000)
    return {"mm",
            "as millimetres the scans are 5 mm to 5 m (a room or a building in metres has such numbers too: then "
            "set units to m, and bin_mm a thousand times larger)"};
  if (extent >= 0.005 && extent < 5) return {"m", "as millimetres the scans would be below 5 mm"};
  if (extent > 5000) return {"um", "as millimetres the scans would be above 5 m"};
  return {"m", "as millimetres the scans would be below 0.005 mm"};
}

/// Two significant digits, so that a person can read the job.
double rounded(double value) {
  double scale = 1;
  while (value * scale < 10) scale *= 10;
  while (value * scale >= 100) scale /= 10;
  return static_cast<double>(static_cast<std::int64_t>(value * scale + 0.5)) / scale;
}

std::string short_text(double value) { return value > 0 ? number_text(rounded(value)) : "0"; }

std::string size_text(Vec3 size) {
  return short_text(size.x) + " x " + short_text(size.y) + " x " + short_text(size.z);
}

struct Seen {
  const ScanSpec* scan = nullptr;
  CloudMeasure measure;  // in the units found
  std::string units;     // empty when a plan says them
  bool stated = false;   // by the names of the columns
  std::string trouble;   // why it could not be measured
  double bin_mm = 0;     // to be set for it; one that `run` does not refuse
};

/// Of depth maps, which 1000 steps a metre make metres.
bool is_depth(const ScanSpec& scan) { return !scan.views.empty() && scan.views.front().camera.has_value(); }

Seen look_at(const std::string& archive, const ScanSpec& scan, const Context& context, Progress& progress) {
  Seen seen;
  seen.scan = &scan;
  double stated_mm = 0;
  auto measured = [&](double units_mm) -> Result<CloudMeasure> {
    TRY_ASSIGN(const auto points, ScanPoints::open(archive, scan, units_mm));
    stated_mm = 0;
    for (const OpenView& view : points->views()) stated_mm = std::max(stated_mm, view.header.mm_per_unit);
    const WatchedPoints watched(*points, "look at " + scan.name, progress);
    return measure_cloud(watched, context);
  };
  auto first = measured(0);
  if (!first.ok()) {
    seen.trouble = first.error().where.empty() ? scan.name + ": " + first.error().text() : first.error().text();
    return seen;
  }
  seen.measure = *first;
  if (scan.units_mm > 0) return seen;
  for (const std::string_view word : unit_words())
    if (stated_mm > 0 && plan::unit_mm(word) == stated_mm) seen.units = word;
  seen.stated = !seen.units.empty();
  if (seen.stated) return seen;
  const Vec3 size = first->bounds.size();
  seen.units = is_depth(scan) ? "m" : guess_units(std::max({size.x, size.y, size.z})).word;
  if (seen.units == "mm") return seen;
  // Lengths go with the unit; measured again, because trial lattices begin at the origin.
  if (auto again = measured(plan::unit_mm(seen.units).value_or(1)); again.ok()) seen.measure = *again;
  return seen;
}

/// Numbers of the scans to look at: spread evenly, the first and the last among them.
std::vector<std::size_t> chosen(std::size_t count) {
  std::vector<std::size_t> rows;
  const std::size_t wanted = std::min(count, kMeasured);
  for (std::size_t k = 0; k < wanted; ++k) rows.push_back(wanted == 1 ? 0 : k * (count - 1) / (wanted - 1));
  return rows;
}

std::string most_common_units(const std::vector<Seen>& list) {
  std::string best;
  std::ptrdiff_t most = 0;
  for (const Seen& seen : list) {
    if (seen.units.empty()) continue;
    const auto count = std::count_if(list.begin(), list.end(), [&](const Seen& s) { return s.units == seen.units; });
    if (count > most || (count == most && seen.units < best)) {
      most = count;
      best = seen.units;
    }
  }
  return best;
}

/// The bin for a scan that was measured: the suggested one, or tenths of a scan of few points; halved while `run` would
/// say that the scan cannot have this size.
double bin_for(const Seen& seen) {
  const Vec3 size = seen.measure.bounds.size();
  const double largest = std::max({size.x, size.y, size.z});
  double bin = rounded(seen.measure.suggested_bin_mm.value_or(largest / kBinsOfFew));
  // Noise of depth cameras is far above their pixels, and many frames over each other make up for coarse bins.
  if (is_depth(*seen.scan) && seen.measure.noise_mm)
    bin = rounded(std::max(bin, kNoisesOfDepth * *seen.measure.noise_mm));
  const double units = seen.scan->units_mm > 0 ? seen.scan->units_mm : plan::unit_mm(seen.units).value_or(1);
  for (int halved = 0; halved < 8 && !implausible_size(seen.measure.bounds, units, bin).empty(); ++halved)
    bin = rounded(bin / 2);
  return bin;
}

std::optional<double> middle_bin(const std::vector<Seen>& list) {
  std::vector<double> bins;
  for (const Seen& seen : list)
    if (seen.measure.suggested_bin_mm) bins.push_back(seen.bin_mm);
  if (bins.empty()) return std::nullopt;
  std::nth_element(bins.begin(), bins.begin() + static_cast<std::ptrdiff_t>(bins.size() / 2), bins.end());
  return rounded(bins[bins.size() / 2]);
}

std::string comment_of(const Seen& seen) {
  std::string text = "#   " + seen.scan->name + ": ";
  if (!seen.trouble.empty()) return text + "not readable: " + seen.trouble + "\n";
  text += grouped(seen.measure.points_used) + " points in " + counted(seen.scan->views.size(), "view") + ", " +
          size_text(seen.measure.bounds.size()) + " mm";
  if (seen.measure.spacing_mm) {
    text += ", spacing " + short_text(*seen.measure.spacing_mm) + " mm";
    if (seen.measure.noise_mm) text += ", noise at most " + short_text(*seen.measure.noise_mm) + " mm";
    text += ", bins of " + short_text(seen.bin_mm) + " mm would suit";
  } else
    text += ", too few to tell spacing and noise";
  return text + "\n";
}

std::string quoted(const std::string& word) { return document::to_json(document::Node(word)); }

/// Why a scan got its unit, where another than that of the job.
std::string unit_reason(const Seen& seen) {
  if (is_depth(*seen.scan)) return "# Depth maps of 1000 steps a metre.";
  if (seen.stated) return "# The names of the columns say so.";
  const Vec3 size = seen.measure.bounds.size();
  const double extent = std::max({size.x, size.y, size.z}) / plan::unit_mm(seen.units).value_or(1);
  return "# The numbers span " + short_text(extent) + ": " + guess_units(extent).reason + ".";
}

std::string override_of(const Seen& seen, const std::string& units, double bin) {
  std::string keys;
  if (!seen.units.empty() && seen.units != units)
    keys += "    " + unit_reason(seen) + "\n    units: " + seen.units + "\n";
  if (const double own = seen.bin_mm; own > 0 && (own > bin * kDiffers || own * kDiffers < bin))
    keys += "    lattice: {bin_mm: " + short_text(own) + "}\n";
  return keys.empty() ? keys : "  - scans: " + quoted(seen.scan->name) + "\n" + keys;
}

std::string units_text(const std::vector<Seen>& list, const std::string& units) {
  if (units.empty()) return "\n# The scan plans say the units of their files.\n";
  const auto seen = std::find_if(list.begin(), list.end(), [&](const Seen& s) { return s.units == units; });
  if (is_depth(*seen->scan)) return "\n# Depth maps of 1000 steps a metre.\nunits: " + units + "\n";
  if (seen->stated) return "\n# The names of the columns say so.\nunits: " + units + "\n";
  const Vec3 size = seen->measure.bounds.size();
  const double extent = std::max({size.x, size.y, size.z}) / plan::unit_mm(units).value_or(1);
  return "\n# The files do not say their units: " + std::string(guess_units(extent).reason) + "; the numbers span " +
         short_text(extent) + ".\nunits: " + units + "\n";
}

std::string job_text(const std::string& name, const Discovery& found, const std::vector<DepthViews>& depth,
                     const std::vector<Seen>& list) {
  std::string text =
      "# A first job for this archive; every other key has a default (scanmill schema job lists them).\n"
      "scanmill: 1\n"
      "archive: " +
      quoted(name) + "\n\n";
  text += "# " + counted(found.scans.size(), "scan") + " found" +
          (list.size() < found.scans.size() ? ", " + std::to_string(list.size()) + " of them looked at" : "") + ":\n";
  for (const Seen& seen : list) text += comment_of(seen);
  for (const std::string& note : found.notes) text += "# note: " + note + "\n";
  for (const std::string& file : found.pose_files)
    text += "# note: " + file +
            " holds 4x4 matrices: poses of views of one scan? Then name files and poses in views (docs/formats.md).\n";
  const std::string units = most_common_units(list);
  text += units_text(list, units);
  if (!depth.empty()) text += views_text(depth);
  const auto bin = middle_bin(list);
  const bool by_noise = std::any_of(list.begin(), list.end(), [](const Seen& s) { return is_depth(*s.scan); });
  text += by_noise
              ? "\n# Eight times the noise of the depth maps, or two point spacings where that is more: finer bins "
                "would mesh the noise.\nlattice:\n"
              : "\n# Two point spacings, up to three where there is noise: finer bins would leave holes and mesh "
                "the noise.\nlattice:\n";
  text += bin ? "  bin_mm: " + number_text(*bin) + "\n"
              : "  bin_mm: 1  # no scan has points enough to tell: choose the detail you need\n";
  std::string overrides;
  for (const Seen& seen : list)
    if (seen.trouble.empty()) overrides += override_of(seen, units, bin.value_or(1));
  if (!overrides.empty()) text += "\n# Scans that differ from the rest.\noverrides:\n" + overrides;
  const double edge = bin.value_or(1);
  text +=
      "\n# A mesh beyond these bounds ends the run with exit code 4. Every input point is measured, a lone one far "
      "from "
      "the\n# part as well: clean takes such out first.\n# clean:\n#   outliers: {min_component_points: 50}\n# "
      "verify:\n#   max_error_mm: " +
      short_text(2 * edge) + "\n#   rms_mm: " + short_text(edge / 2) + "\n";
  return text;
}

}  // namespace

Result<FirstJob> first_job(const std::string& archive, const std::string& name_in_job, const Context& context,
                           Progress& progress) {
  TRY_ASSIGN(Discovery found, discover(archive, false));
  std::vector<DepthViews> depth;
  if (!found.depth_maps.empty()) {
    TRY_ASSIGN(const std::vector<std::string> files, store::list_files(archive));
    depth = guess_depth_views(archive, found.depth_maps, files);
    DiscoveryKeys keys;
    for (const DepthViews& guess : depth) keys.views.push_back(guess.spec);
    TRY_ASSIGN(found, discover(archive, keys));
  }
  if (found.scans.empty()) {
    std::string text = "found no scan; wanted point files, .conf files or scan plans";
    for (const std::string& note : found.notes) text += "\n" + archive + ": note: " + note;
    return fail(Code::BadUsage, text, archive);  // as `run` of it
  }
  std::vector<Seen> list;
  for (const std::size_t row : chosen(found.scans.size())) {
    list.push_back(look_at(archive, found.scans[row], context, progress));
    if (list.back().trouble.empty()) list.back().bin_mm = bin_for(list.back());
    if (context.cancel.is_set()) return fail(Code::Cancelled, "stopped on request", archive);
  }
  if (std::all_of(list.begin(), list.end(), [](const Seen& seen) { return !seen.trouble.empty(); }))
    return fail(Code::BadInput, "no scan can be read; the first: " + list.front().trouble, archive);
  const auto readable = std::count_if(list.begin(), list.end(), [](const Seen& s) { return s.trouble.empty(); });
  return FirstJob{job_text(name_in_job, found, depth, list), found.scans.size(), static_cast<std::size_t>(readable)};
}

}  // namespace scanmill::pipeline
