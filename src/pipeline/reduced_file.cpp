// SPDX-License-Identifier: Apache-2.0
#include "pipeline/reduced_file.hpp"

#include <array>
#include <bit>
#include <cmath>
#include <optional>
#include <span>
#include <sstream>

#include "base/text.hpp"
#include "formats/table.hpp"

namespace scanmill::pipeline {
namespace {

using reduce::Drop;
using reduce::ReducedCloud;

constexpr double kMostRows = 0x1p53;  // whole numbers are whole in a double up to here
constexpr const char* kMark = "scanmill reduced 1";
constexpr const char* kVertexColumns[] = {"x", "y", "z", "nx", "ny", "nz"};
constexpr const char* kBinColumns[] = {"i",         "j",    "k",        "x",         "y",
                                       "z",         "px",   "py",       "pz",        "nx",
                                       "ny",        "nz",   "residual", "variation", "plane_distance",
                                       "count",     "view", "row",      "drop",      "frame_valid",
                                       "sign_known"};

std::string header_of(const ReducedCloud& cloud, std::uint64_t kept) {
  std::string text = "ply\nformat binary_little_endian 1.0\ncomment " + std::string(kMark) + "\n";
  const Vec3 o = cloud.lattice.origin;
  text += "comment bin_mm " + number_text(cloud.lattice.edge_mm) + "\n";
  text += "comment origin_mm " + number_text(o.x) + " " + number_text(o.y) + " " + number_text(o.z) + "\n";
  text += "comment base " + std::to_string(cloud.base.i) + " " + std::to_string(cloud.base.j) + " " +
          std::to_string(cloud.base.k) + "\n";
  text += "element vertex " + std::to_string(kept) + "\n";
  for (const char* name : kVertexColumns) text += std::string("property double ") + name + "\n";
  text += "element bin " + std::to_string(cloud.size()) + "\n";
  for (const char* name : kBinColumns) text += std::string("property double ") + name + "\n";
  return text + "end_header\n";
}

void append(std::string& bytes, std::initializer_list<double> values) {
  static_assert(std::endian::native == std::endian::little, "the file is little-endian");
  bytes.append(reinterpret_cast<const char*>(values.begin()), values.size() * sizeof(double));
}

/// The words behind "NAME " in the comments.
std::optional<std::vector<double>> numbers_behind(const formats::Table& table, const std::string& name,
                                                  std::size_t count) {
  for (const std::string& comment : table.comments) {
    if (comment.rfind(name + " ", 0) != 0) continue;
    std::istringstream words(comment.substr(name.size() + 1));
    std::vector<double> values;
    for (std::string word; words >> word;)
      if (const auto value = parse_number(word)) values.push_back(*value);
    if (values.size() == count) return values;
  }
  return std::nullopt;
}

/// Values of one bin that `write_reduced` can have written. The file is input like any other: a NaN or a number out of
/// range must not reach the stages, which take finite frames for granted.
bool is_plausible(const ReducedCloud& cloud, std::size_t row, std::span<const double> rest) {
  const double h = cloud.lattice.edge_mm;
  const Vec3 p = cloud.measured[row], centre = centre_of(cloud.lattice, cloud.key(row)), n = cloud.normal[row];
  const Vec3 to_centre = p - centre, off = cloud.projected[row] - p;
  const bool in_bin =
      norm2(to_centre) <= h * h && norm2(off) <= 4 * h * h;  // half a diagonal; kMaxProjection of reduce
  if (!in_bin || !(std::abs(norm2(n) - 1) < 1e-6)) return false;
  auto within = [&](std::size_t k, double low, double high) { return rest[k] >= low && rest[k] <= high; };
  return within(0, 0, 1e6) && within(1, 0, 1) && within(2, 0, 1e6) && within(3, 1, kMostRows) &&
         within(4, 0, 0xffffffffu) && within(5, 0, kMostRows) && within(6, 0, 4);
}

}  // namespace

Result<void> write_reduced(const ReducedCloud& cloud, ByteSink& sink) {
  std::uint64_t kept = 0;
  for (const Drop drop : cloud.drop) kept += drop == Drop::Kept;
  TRY(sink.write(std::string_view(header_of(cloud, kept))));
  std::string bytes;
  bytes.reserve((1 << 20) + 8 * std::size(kBinColumns));
  auto flush = [&](std::size_t from) -> Result<void> {
    if (bytes.size() < from) return {};
    TRY(sink.write(std::string_view(bytes)));
    bytes.clear();
    return {};
  };
  for (std::size_t row = 0; row < cloud.size(); ++row) {
    if (cloud.drop[row] != Drop::Kept) continue;
    const Vec3 p = cloud.measured[row], n = cloud.normal[row];
    append(bytes, {p.x, p.y, p.z, n.x, n.y, n.z});
    TRY(flush(1 << 20));
  }
  for (std::size_t row = 0; row < cloud.size(); ++row) {
    const BinKey key = cloud.key(row);
    const Vec3 p = cloud.measured[row], q = cloud.projected[row], n = cloud.normal[row];
    append(bytes, {static_cast<double>(key.i),
                   static_cast<double>(key.j),
                   static_cast<double>(key.k),
                   p.x,
                   p.y,
                   p.z,
                   q.x,
                   q.y,
                   q.z,
                   n.x,
                   n.y,
                   n.z,
                   cloud.residual[row],
                   cloud.variation[row],
                   cloud.plane_distance[row],
                   static_cast<double>(cloud.counts[row]),
                   static_cast<double>(index_of(cloud.source[row].view)),
                   static_cast<double>(cloud.source[row].row),
                   static_cast<double>(cloud.drop[row]),
                   static_cast<double>(cloud.frame_valid[row]),
                   static_cast<double>(cloud.sign_known[row])});
    TRY(flush(1 << 20));
  }
  return flush(0);
}

Result<ReducedCloud> read_reduced(const ByteSource& source) {
  TRY_ASSIGN(const formats::Table table, formats::read_ply_table(source, "bin"));
  const auto bin = numbers_behind(table, "bin_mm", 1), origin = numbers_behind(table, "origin_mm", 3),
             base = numbers_behind(table, "base", 3);
  std::vector<const std::vector<double>*> column;
  for (const char* name : kBinColumns) column.push_back(table.find(name));
  bool complete = bin && origin && base && (*bin)[0] > 0 && (*bin)[0] <= 1e6;
  for (std::size_t k = 0; complete && k < 3; ++k)
    complete = std::isfinite((*origin)[k]) && std::abs((*base)[k]) < 0x1p52;
  for (const auto* values : column) complete = complete && values != nullptr;
  if (!complete)
    return fail(Code::BadInput, "has no bins as `scanmill reduce` writes them; leave --as-is away to reduce it",
                source.name());
  ReducedCloud cloud;
  cloud.lattice = {(*bin)[0], {(*origin)[0], (*origin)[1], (*origin)[2]}};
  auto whole = [](double value) { return static_cast<std::int64_t>(value); };
  cloud.base = {whole((*base)[0]), whole((*base)[1]), whole((*base)[2])};
  const std::size_t n = column[0]->size();
  auto at = [&](std::size_t c, std::size_t row) { return (*column[c])[row]; };
  auto wrong = [&](std::size_t row) {
    return fail(Code::BadInput, "bin " + std::to_string(row) + " holds values that `scanmill reduce` does not write",
                source.name());
  };
  for (std::size_t row = 0; row < n; ++row) {
    const double di = at(0, row) - (*base)[0], dj = at(1, row) - (*base)[1], dk = at(2, row) - (*base)[2];
    if (!(std::abs(di) < 0x1p30 && std::abs(dj) < 0x1p30 && std::abs(dk) < 0x1p30)) return wrong(row);
    cloud.bins.push_back({static_cast<std::int32_t>(di), static_cast<std::int32_t>(dj), static_cast<std::int32_t>(dk)});
    if (row > 0 && !before(cloud.key(row - 1), cloud.key(row)))
      return fail(Code::BadInput, "bin " + std::to_string(row) + " is out of order", source.name());
    cloud.measured.push_back({at(3, row), at(4, row), at(5, row)});
    cloud.projected.push_back({at(6, row), at(7, row), at(8, row)});
    cloud.normal.push_back({at(9, row), at(10, row), at(11, row)});
    const std::array<double, 7> rest{at(12, row), at(13, row), at(14, row), at(15, row),
                                     at(16, row), at(17, row), at(18, row)};
    if (!is_plausible(cloud, row, rest)) return wrong(row);
    cloud.residual.push_back(static_cast<float>(rest[0]));
    cloud.variation.push_back(static_cast<float>(rest[1]));
    cloud.plane_distance.push_back(static_cast<float>(rest[2]));
    cloud.counts.push_back(whole(rest[3]));
    cloud.source.push_back({ViewId{static_cast<std::uint32_t>(rest[4])}, static_cast<std::uint64_t>(rest[5])});
    cloud.drop.push_back(static_cast<Drop>(static_cast<std::uint8_t>(rest[6])));
    cloud.frame_valid.push_back(at(19, row) != 0);
    cloud.sign_known.push_back(at(20, row) != 0);
  }
  cloud.index = BinIndex::over(cloud.bins);
  return cloud;
}

}  // namespace scanmill::pipeline
