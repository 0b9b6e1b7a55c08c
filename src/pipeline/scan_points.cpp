// SPDX-License-Identifier: Apache-2.0
#include "pipeline/scan_points.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

#include "base/digest.hpp"
#include "base/text.hpp"
#include "pipeline/block_band.hpp"
#include "pipeline/plan_scan.hpp"
#include "pipeline/unit_hint.hpp"
#include "pipeline/what.hpp"

namespace scanmill::pipeline {
namespace {

/// Counters of one block; threads may read the same block at once, all of them store the same numbers.
struct BlockCounts {
  std::atomic<std::uint64_t> points_read{0}, not_finite{0}, sensor_invalid{0};
  void store(std::uint64_t read, std::uint64_t broken, std::uint64_t invalid) {
    points_read.store(read, std::memory_order_relaxed);
    not_finite.store(broken, std::memory_order_relaxed);
    sensor_invalid.store(invalid, std::memory_order_relaxed);
  }
};

ViewPoint to_global(const ViewPoint& view_point, const Pose& pose) {
  ViewPoint out;
  if (view_point.eye) out.eye = pose.apply(*view_point.eye);
  if (view_point.direction) out.direction = pose.turn(*view_point.direction);
  return out;
}

/// Files in the folder of a view, named in messages as the view is.
auto beside_of(const std::string& full_path, const std::string& path) {
  return [full = folder_of(full_path), shown = folder_of(path)](const std::string& name) {
    return store::open_file(full + name, shown + name);
  };
}

/// Finite numbers of a file may leave the range of double on the way to mm in the global frame.
Result<void> check_finite(const PointBlock& block, const std::string& path) {
  double doubt = 0;  // x - x is 0 for finite numbers, NaN otherwise
  for (const Vec3 p : block.positions) doubt += (p.x - p.x) + (p.y - p.y) + (p.z - p.z);
  if (doubt == 0) return {};
  return fail(Code::BadInput, "a point is too far away to be placed in the global frame; are the units wrong?", path);
}

/// As the job names it.
std::string unit_word(double mm) {
  for (const std::string_view word : unit_words())
    if (plan::unit_mm(word) == mm) return std::string(word);
  return number_text(mm) + " mm";
}

}  // namespace

struct ScanPoints::Impl {
  struct Source {
    std::shared_ptr<const ByteSource> file;
    std::unique_ptr<formats::ViewReader> reader;
    std::string full_path, expected_sha256;
    std::size_t first_block = 0;
    bool is_identity = false;
  };
  double units = 1;
  bool units_open = false;  // nobody has said them yet
  std::optional<scanmill::Sensor> sensor;
  formats::Format format = formats::Format::Auto;
  std::vector<ViewSpec> specs;
  std::vector<OpenView> views;
  std::vector<Source> sources;  // one per view
  std::size_t blocks = 0;
  std::uint64_t expected = 0;
  std::unique_ptr<BlockCounts[]> counts;
  std::unique_ptr<BlockBand[]> bands;  // with a sensor only

  /// All scans of one file.
  Result<void> add(const std::string& archive, const ViewSpec& spec) {
    const std::string full_path = archive + "/" + spec.path;
    // The stamp is taken first: a change between the two calls shows as a difference later, never as a match.
    const auto stamp = store::stamp_of(full_path);
    TRY_ASSIGN(const auto file, store::open_file(full_path, spec.path));
    TRY_ASSIGN(auto readers, formats::open_views(file, {format, spec.camera, beside_of(full_path, spec.path)}));
    for (auto& reader : readers) {
      OpenView& view = views.emplace_back();
      view.id = ViewId{static_cast<std::uint32_t>(specs.size())};
      view.path = spec.path;
      if (stamp.ok()) view.stamp = *stamp;
      view.header = reader->header();
      if (const double says = view.header.mm_per_unit; says > 0 && units_open)
        units = says;
      else if (says > 0 && says != units)
        return fail(Code::BadInput,
                    "the names of the columns say " + unit_word(says) + ", the points are to be read as " +
                        unit_word(units) + "; set units: " + unit_word(says) + " (--units " + unit_word(says) +
                        "), or take the unit out of the names where it is wrong",
                    spec.path);
      units_open = false;
      place(spec, view);
      specs.push_back(spec);
      sources.push_back(
          {file, std::move(reader), full_path, spec.expected_sha256, blocks, view.pose == Pose{} && !spec.mirrored});
      blocks += sources.back().reader->block_count();
      expected += view.header.rows;
    }
    return {};
  }

  /// In the sensor frame: positions as the file gives them, units apart.
  plan::BandCounts band_of(const PointBlock& block) const {
    plan::BandCounts seen;
    if (units == 1) {
      plan::count_band(*sensor, block.positions, seen);
      return seen;
    }
    std::vector<Vec3> scaled(block.positions);
    for (Vec3& p : scaled) p = p * units;
    plan::count_band(*sensor, scaled, seen);
    return seen;
  }

  /// The scan's pose after the file's own; what the scan says about the eye goes before what the file says.
  void place(const ViewSpec& spec, OpenView& view) const {
    view.pose = spec.pose;
    if (spec.pose_in_file_units) view.pose.translation = view.pose.translation * units;
    if (!(view.header.pose == Pose{})) {
      Pose own = view.header.pose;
      own.translation = own.translation * units;
      view.pose = view.pose.after(own);
    }
    ViewPoint seen = spec.view_point;
    if (seen.eye && spec.pose_in_file_units) seen.eye = *seen.eye * units;
    if (!seen.eye && !seen.direction) {
      seen = view.header.view_point;
      if (seen.eye) seen.eye = *seen.eye * units;
    }
    view.view_point = to_global(seen, view.pose);
  }
};

ScanPoints::ScanPoints(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
ScanPoints::~ScanPoints() = default;

Result<std::unique_ptr<ScanPoints>> ScanPoints::open(const std::string& archive, const ScanSpec& scan, double units_mm,
                                                     formats::Format format) {
  if (!scan.broken.empty()) return fail(Code::BadInput, scan.broken);
  auto impl = std::make_unique<Impl>();
  impl->units_open = scan.units_mm <= 0 && units_mm <= 0;
  impl->units = scan.units_mm > 0 ? scan.units_mm : units_mm > 0 ? units_mm : 1;
  impl->format = format;
  impl->sensor = scan.sensor;
  for (const ViewSpec& spec : scan.views) {
    if (spec.missing)
      impl->specs.push_back(spec);
    else
      TRY(impl->add(archive, spec));
  }
  if (impl->expected == 0) {
    const std::string place = impl->views.size() == 1 ? impl->views[0].path : scan.name;
    return fail(Code::BadInput, "the scan holds no points (0 rows); wanted at least one view with points", place);
  }
  impl->counts = std::make_unique<BlockCounts[]>(impl->blocks);
  if (impl->sensor) impl->bands = std::make_unique<BlockBand[]>(impl->blocks);
  return std::unique_ptr<ScanPoints>(new ScanPoints(std::move(impl)));
}

std::size_t ScanPoints::block_count() const { return impl_->blocks; }
std::uint64_t ScanPoints::expected_points() const { return impl_->expected; }
const std::vector<OpenView>& ScanPoints::views() const { return impl_->views; }
const std::vector<ViewSpec>& ScanPoints::specs() const { return impl_->specs; }
double ScanPoints::units_mm() const { return impl_->units; }

void ScanPoints::move_views(std::span<const Pose> poses) {
  for (std::size_t i = 0; i < impl_->views.size(); ++i) {
    OpenView& view = impl_->views[i];
    const Pose& pose = poses[index_of(view.id)];
    if (pose == view.pose) continue;
    view.view_point = to_global(view.view_point, pose.after(view.pose.inverse()));
    view.pose = pose;
    impl_->sources[i].is_identity = false;
  }
}

Result<void> ScanPoints::read_block(std::size_t number, PointBlock& out) const {
  const auto behind =
      std::upper_bound(impl_->sources.begin(), impl_->sources.end(), number,
                       [](std::size_t n, const Impl::Source& source) { return n < source.first_block; });
  const auto at = static_cast<std::size_t>(behind - impl_->sources.begin()) - 1;
  const Impl::Source& source = impl_->sources[at];
  const OpenView& view = impl_->views[at];
  TRY(source.reader->read_block(number - source.first_block, out));
  out.view = view.id;
  out.view_point = view.view_point;
  const double units = impl_->units;
  if (impl_->specs[index_of(view.id)].mirrored)
    for (Vec3& p : out.positions) p.z = -p.z;
  if (impl_->bands && view.header.pose == Pose{}) impl_->bands[number].store(impl_->band_of(out));
  if (!source.is_identity)
    for (Vec3& p : out.positions) p = view.pose.apply(p * units);
  else if (units != 1)
    for (Vec3& p : out.positions) p = p * units;
  if (!source.is_identity || units != 1) TRY(check_finite(out, view.path));
  impl_->counts[number].store(out.points_read, out.not_finite, out.sensor_invalid);
  return {};
}

std::vector<BlockTrace> ScanPoints::traces() const {
  std::vector<BlockTrace> traces;
  for (std::size_t block = 0; block < impl_->blocks; ++block) {
    const BlockCounts& counts = impl_->counts[block];
    const BlockTrace trace{block, counts.points_read, counts.not_finite, counts.sensor_invalid,
                           impl_->bands ? impl_->bands[block].load() : plan::BandCounts()};
    if (trace.points_read > 0) traces.push_back(trace);
  }
  return traces;
}

bool ScanPoints::recall(std::span<const BlockTrace> traces) const {
  for (const BlockTrace& trace : traces) {
    if (trace.block >= impl_->blocks) return false;
    const auto block = static_cast<std::size_t>(trace.block);
    impl_->counts[block].store(trace.points_read, trace.not_finite, trace.sensor_invalid);
    if (impl_->bands) impl_->bands[block].store(trace.band);
  }
  return true;
}

std::vector<ViewCounts> ScanPoints::counts() const {
  std::vector<ViewCounts> sums(impl_->views.size());
  for (std::size_t i = 0; i < sums.size(); ++i) {
    const std::size_t end = i + 1 < sums.size() ? impl_->sources[i + 1].first_block : impl_->blocks;
    for (std::size_t block = impl_->sources[i].first_block; block < end; ++block) {
      sums[i].points_read += impl_->counts[block].points_read.load(std::memory_order_relaxed);
      sums[i].not_finite += impl_->counts[block].not_finite.load(std::memory_order_relaxed);
      sums[i].sensor_invalid += impl_->counts[block].sensor_invalid.load(std::memory_order_relaxed);
      if (impl_->bands) sums[i].band.add(impl_->bands[block].load());
    }
  }
  return sums;
}

Result<std::vector<std::string>> ScanPoints::digests(const Context& context) const {
  std::vector<Result<std::string>> results(impl_->sources.size(), Result<std::string>(std::string()));
  // Scans of one file stand together; its first one hashes it.
  const auto is_first = [&](std::size_t i) { return i == 0 || impl_->sources[i].file != impl_->sources[i - 1].file; };
  context.loop.run(impl_->sources.size(), [&](std::size_t i, int) {
    if (is_first(i) && !context.cancel.is_set()) results[i] = sha256_of(*impl_->sources[i].file);
  });
  if (context.cancel.is_set()) return fail(Code::Cancelled, "stopped while input files were hashed");
  std::vector<std::string> digests;
  for (std::size_t i = 0; i < results.size(); ++i) {
    TRY_ASSIGN(std::string digest, is_first(i) ? std::move(results[i]) : Result<std::string>(digests.back()));
    const std::string& expected = impl_->sources[i].expected_sha256;
    if (!expected.empty() && expected != digest)
      return fail(Code::BadInput,
                  (impl_->specs[index_of(impl_->views[i].id)].station.empty()
                       ? ""
                       : "station " + impl_->specs[index_of(impl_->views[i].id)].station + ": ") +
                      "the file has SHA-256 " + digest + ", its plan names " + expected +
                      "; it was changed or exchanged",
                  impl_->views[i].path);
    digests.push_back(std::move(digest));
  }
  return digests;
}

std::vector<plan::Finding> ScanPoints::band_findings() const {
  std::vector<plan::Finding> all;
  if (!impl_->sensor) return all;
  const std::vector<ViewCounts> sums = counts();
  for (std::size_t i = 0; i < sums.size(); ++i) {
    const std::string& station = impl_->specs[index_of(impl_->views[i].id)].station;
    for (plan::Finding& finding : plan::band_findings(*impl_->sensor, station, sums[i].band))
      all.push_back(std::move(finding));
  }
  return all;
}

Result<void> ScanPoints::check_bands(std::vector<std::string>& notes) const {
  std::string errors;
  for (const plan::Finding& finding : band_findings())
    if (finding.severity == plan::Severity::Warning)
      notes.push_back(finding.text);
    else
      errors += (errors.empty() ? "" : "\n") + finding.text;
  if (!errors.empty()) return fail(Code::BadInput, errors);
  return {};
}

Result<void> ScanPoints::verify_unchanged() const {
  for (std::size_t i = 0; i < impl_->sources.size(); ++i) {
    const auto now = store::stamp_of(impl_->sources[i].full_path);
    if (!now.ok() || *now != impl_->views[i].stamp)
      return fail(Code::BadInput, "the file changed while it was read; let it be written to its end and run again",
                  impl_->views[i].path);
  }
  return {};
}

namespace {

constexpr double kMostPlausibleBins = 50000;              // across a cloud
constexpr double kSmallestPart = 5, kLargestPart = 5000;  // mm
constexpr double kBinsOfAPart = 20;                       // across the least that shows a shape

std::string rounded(double value) {
  double step = 1;  // two digits are enough to recognise a size
  while (value >= 100 * step) step *= 10;
  while (value > 0 && value < 10 * step && step > 1e-12) step /= 10;
  return number_text(step < 1 ? std::floor(value / step + 0.5) / std::floor(1 / step + 0.5)
                              : std::floor(value / step + 0.5) * step);
}

}  // namespace

std::string implausible_size(const Bounds& bounds, double units_mm, double bin_mm, std::uint64_t points) {
  if (bounds.empty()) return {};
  const Vec3 size = bounds.size();
  const double largest = std::max({size.x, size.y, size.z});
  if (largest <= 0)
    return (points == 1 ? std::string("holds one point")
                        : "all " + (points > 0 ? grouped(points) + " " : std::string()) + "points coincide") +
           "; wanted points of a surface";
  const bool few_bins = bin_mm > 0 && largest < 4 * bin_mm;
  const bool below_1_mm = units_mm == 1 && largest < 1;
  const bool tiny = few_bins || below_1_mm;
  // A survey is hundreds of metres wide and has bins to match; a part declared as metres has bins of a part.
  const bool huge = units_mm >= 1000 && largest > 1e5 && (bin_mm <= 0 || largest > kMostPlausibleBins * bin_mm);
  if (!tiny && !huge) return {};
  const std::string text = std::string("size ")
                               .append(rounded(size.x))
                               .append(" x ")
                               .append(rounded(size.y))
                               .append(" x ")
                               .append(rounded(size.z));
  if (few_bins && largest >= kSmallestPart)
    return text + " mm is less than 4 bins of " + number_text(bin_mm) + " mm; choose a lattice.bin_mm of at most " +
           rounded(largest / kBinsOfAPart) + ", or set units if the numbers are in another unit";
  const std::string sentence =
      text + " mm cannot be" + (few_bins && !below_1_mm ? " with bins of " + number_text(bin_mm) + " mm" : "");
  // The units that make an object of 20 bins and 5 mm to 5 m out of the same numbers.
  std::string plurals, words;
  for (const LengthUnit& unit : kLengthUnits) {
    const double guess = largest / units_mm * unit.mm;
    if (unit.mm == units_mm || guess < std::max(kSmallestPart, kBinsOfAPart * bin_mm) || guess > kLargestPart) continue;
    plurals += std::string(plurals.empty() ? "" : " or ").append(unit.plural);
    words += std::string(words.empty() ? "" : " or ").append(unit.word);
    if (huge) break;  // millimetres first: what made them a thousand times too large
  }
  if (plurals.empty()) return sentence + "; check units and lattice.bin_mm";
  return sentence + "; the numbers look like " + plurals + ": set units to " + words +
         (few_bins && !below_1_mm ? " (or choose a smaller lattice.bin_mm)" : "");
}

}  // namespace scanmill::pipeline
