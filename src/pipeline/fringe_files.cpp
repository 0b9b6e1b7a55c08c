// SPDX-License-Identifier: Apache-2.0
#include "pipeline/fringe_files.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "base/digest.hpp"
#include "export/grey_png.hpp"
#include "export/range_maps.hpp"
#include "export/writers.hpp"
#include "store/files.hpp"

namespace scanmill::pipeline {
namespace {

std::string folder_of_file(const std::string& path) {
  const std::string folder = std::filesystem::path(path).parent_path().string();
  return folder.empty() ? "." : folder;
}

/// Writes a picture unless the same stands there; returns its SHA-256.
Result<std::string> write_picture(const std::string& path, const fringe::Picture& picture, int bits) {
  std::string bytes;
  const auto memory = memory_sink(path, bytes);
  TRY(exporting::write_grey_png(picture.pixels, static_cast<std::uint32_t>(picture.width), bits, *memory));
  TRY(memory->commit());
  const std::string digest = sha256_hex(bytes);
  if (store::exists(path)) {
    const auto there = store::open_file(path, path);
    if (there.ok()) {
      const auto same = sha256_of(**there);
      if (same.ok() && *same == digest) return digest;
    }
  }
  TRY_ASSIGN(auto sink, store::create_file(path));
  TRY(sink->write(std::string_view(bytes)));
  TRY(sink->commit());
  return digest;
}

Result<void> write_grey(const std::string& path, const std::vector<std::uint16_t>& pixels, std::int64_t width,
                        int bits) {
  TRY_ASSIGN(auto sink, store::create_file(path));
  TRY(exporting::write_grey_png(pixels, static_cast<std::uint32_t>(width), bits, *sink));
  return sink->commit();
}

/// Values from low to high as 1 to 65535; NaN as 0.
std::vector<std::uint16_t> grey_of(const std::vector<double>& values, double low, double high) {
  std::vector<std::uint16_t> pixels(values.size(), 0);
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!std::isfinite(values[i])) continue;
    const double share = high > low ? (values[i] - low) / (high - low) : 0;
    pixels[i] = static_cast<std::uint16_t>(1 + std::floor(std::clamp(share, 0.0, 1.0) * 65534 + 0.5));
  }
  return pixels;
}

}  // namespace

formats::OpenBeside beside(const std::string& path) {
  return [folder = folder_of_file(path)](const std::string& name) {
    return store::open_file(folder + "/" + name, folder + "/" + name);
  };
}

Result<void> write_fringe_view(const std::string& path, const simulate::FringeRig& rig, const scanmill::Sensor& sensor,
                               const std::vector<fringe::Picture>& object, const std::vector<fringe::Picture>& plate) {
  formats::FringeSet set;
  set.optics = simulate::optics_of(sensor, rig);
  const std::string folder = folder_of_file(path), stem = std::filesystem::path(path).stem().string();
  const int bits = static_cast<int>(rig.bits);
  std::size_t picture = 0;
  for (std::size_t g = 0; g < rig.periods_mm.size(); ++g) {
    formats::FringeGrating& grating = set.gratings.emplace_back();
    grating.period_mm = rig.periods_mm[g];
    for (std::int64_t k = 0; k < rig.steps; ++k, ++picture) {
      const std::string shift = ".g" + std::to_string(g + 1) + ".s" + std::to_string(k + 1) + ".png";
      grating.object.push_back(stem + shift);
      grating.plate.push_back("plate" + shift);
      TRY_ASSIGN(std::string of_object, write_picture(folder + "/" + stem + shift, object[picture], bits));
      TRY_ASSIGN(std::string of_plate, write_picture(folder + "/plate" + shift, plate[picture], bits));
      set.sha256.push_back({stem + shift, std::move(of_object)});
      set.sha256.push_back({"plate" + shift, std::move(of_plate)});
    }
  }
  return store::write_text(path, formats::fringe_set_text(set));
}

Result<ToolReport> decode_fringe_file(const std::string& path, const std::string& folder, Progress& progress) {
  TRY_ASSIGN(const auto source, store::open_file(path, path));
  TRY_ASSIGN(const formats::FringeSet set, formats::read_fringe_set(*source));
  progress.stage("decode", 0, 0);
  TRY_ASSIGN(const fringe::RangeMap map, formats::decode_fringes(set, beside(path), path));
  TRY(store::make_folders(folder));
  double low = 1e300, high = -1e300;
  for (const double turns : map.unwrapped)
    if (std::isfinite(turns)) {
      low = std::min(low, turns);
      high = std::max(high, turns);
    }
  TRY(write_grey(folder + "/wrapped.png", grey_of(map.wrapped, -0.5, 0.5), map.width, 16));
  TRY(write_grey(folder + "/unwrapped.png", grey_of(map.unwrapped, low, high), map.width, 16));
  std::vector<std::uint16_t> quality(map.flaws.size(), 0);
  for (std::size_t i = 0; i < quality.size(); ++i)
    if (map.flaws[i] == fringe::Flaw::None)
      quality[i] = static_cast<std::uint16_t>(1 + 254 * std::clamp(static_cast<double>(map.visibility[i]), 0.0, 1.0));
  TRY(write_grey(folder + "/quality.png", quality, map.width, 8));
  std::vector<double> depths(map.points.size());
  for (std::size_t i = 0; i < depths.size(); ++i) depths[i] = map.points[i].z;
  const double near = set.optics.stand_off_mm - set.optics.depth_mm,
               far = set.optics.stand_off_mm + set.optics.depth_mm;
  TRY(write_grey(folder + "/range.png", grey_of(depths, near, far), map.width, 16));
  TRY_ASSIGN(auto sink, store::create_file(folder + "/range.ply"));
  const std::vector<std::string> comments{"scanmill fringes " + std::filesystem::path(path).filename().string()};
  TRY(exporting::write_view_ply(map.points, comments, *sink));
  TRY(sink->commit());
  ToolReport report;
  document::Node& out = report.values;
  out.set("pixels", static_cast<std::uint64_t>(map.flaws.size()));
  out.set("points", map.count(fringe::Flaw::None));
  out.set("saturated", map.count(fringe::Flaw::Saturated));
  out.set("dark", map.count(fringe::Flaw::Dark));
  out.set("shadow", map.count(fringe::Flaw::Shadow));
  out.set("ambiguous", map.count(fringe::Flaw::Ambiguous));
  out.set("out_of_band", map.count(fringe::Flaw::OutOfBand));
  if (map.regions > 0) out.set("regions", static_cast<std::uint64_t>(map.regions));
  if (low <= high) {
    out.set("least_turns", low);
    out.set("most_turns", high);
  }
  out.set("folder", folder);
  out.set("written", "wrapped.png unwrapped.png quality.png range.png range.ply");
  return report;
}

}  // namespace scanmill::pipeline
