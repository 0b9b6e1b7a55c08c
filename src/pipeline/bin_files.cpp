// SPDX-License-Identifier: Apache-2.0
#include "pipeline/bin_files.hpp"

#include <algorithm>
#include <filesystem>
#include <limits>
#include <numeric>

#include "base/digest.hpp"
#include "export/comparing_sink.hpp"
#include "pipeline/scan_record.hpp"
#include "store/bin_grids.hpp"
#include "store/files.hpp"

namespace scanmill::pipeline {
namespace {

std::string drop_meaning() {
  std::string text = "why the bin's point is no vertex candidate:";
  const std::vector<std::string> names = drop_names();
  for (std::size_t n = 0; n < names.size(); ++n) text += " " + std::to_string(n) + " " + names[n] + ";";
  text.pop_back();
  return text;
}

}  // namespace

Result<WrittenFile> write_bins_file(const reduce::ReducedCloud& cloud, const std::string& path) {
  std::vector<BinKey> keys(cloud.size());
  std::vector<std::int32_t> points(cloud.size()), rows(cloud.size()), drop(cloud.size());
  std::iota(rows.begin(), rows.end(), 0);
  for (std::size_t row = 0; row < cloud.size(); ++row) {
    keys[row] = cloud.key(row);
    points[row] =
        static_cast<std::int32_t>(std::min<std::int64_t>(cloud.counts[row], std::numeric_limits<std::int32_t>::max()));
    drop[row] = static_cast<std::int32_t>(cloud.drop[row]);
  }
  const store::BinColumn columns[] = {{"points", "input points in the bin", points},
                                      {"row", "row of /reduced in record.h5", rows},
                                      {"drop", drop_meaning(), drop}};
  TRY_ASSIGN(auto sink, store::create_file(path));
  TRY(store::write_bin_grids(cloud.lattice, keys, columns, *sink));
  TRY(sink->commit());
  TRY_ASSIGN(const auto source, store::open_file(path, path));
  exporting::ComparingSink same(*source);
  TRY(store::write_bin_grids(cloud.lattice, keys, columns, same));
  TRY(same.commit());
  WrittenFile file;
  file.name = std::filesystem::path(path).filename().string();
  file.bytes = source->size();
  TRY_ASSIGN(file.sha256, sha256_of(*source));
  return file;
}

}  // namespace scanmill::pipeline
