// SPDX-License-Identifier: Apache-2.0
// The vertices of a PLY file as blocks. Rows of fixed size are read in place; ascii rows and rows with lists are found
// by one pass at opening, so that any block can be read by any thread.
#include <algorithm>
#include <array>
#include <numeric>

#include "formats/ply_decode.hpp"
#include "formats/ply_layout.hpp"
#include "formats/ply_rows.hpp"
#include "formats/readers.hpp"

namespace scanmill::formats {
namespace {

/// Columns of x, y, z in the vertex element.
Result<std::array<int, 3>> find_xyz(const ByteSource& source, const PlyElement& vertex) {
  std::array<int, 3> columns{};
  static constexpr std::string_view kNames[3][2] = {{"x", "X"}, {"y", "Y"}, {"z", "Z"}};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    columns[axis] = vertex.find_scalar(kNames[axis][0]);
    if (columns[axis] < 0) columns[axis] = vertex.find_scalar(kNames[axis][1]);
    if (columns[axis] < 0)
      return fail(
          Code::BadInput,
          "element \"vertex\" has no number property \"" + std::string(kNames[axis][0]) + "\"; wanted x, y and z",
          source.name());
  }
  return columns;
}

class PlyReader final : public ViewReader {
 public:
  PlyReader(std::shared_ptr<const ByteSource> source, PlyHeader ply, std::size_t vertex, std::array<int, 3> columns,
            PlyLayout layout)
      : source_(std::move(source)),
        ply_(std::move(ply)),
        vertex_(ply_.elements[vertex]),
        columns_(columns),
        runs_(std::move(layout.runs)) {
    header_.format = ply_.format_name();
    header_.rows = vertex_.count;
    for (const PlyElement& element : ply_.elements) {
      header_.has_faces |= (element.name == "face" || element.name == "tristrips") && element.count > 0;
      header_.has_grid |= element.name == "range_grid";
    }
    header_.notes = ply_.notes;
    header_.notes.insert(header_.notes.end(), layout.notes.begin(), layout.notes.end());
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto column = static_cast<std::size_t>(columns_[axis]);
      xyz_[axis].type = vertex_.properties[column].type;
      for (std::size_t i = 0; i < column; ++i) xyz_[axis].offset += size_of(vertex_.properties[i].type);
    }
    sorted_ = columns_;
    std::sort(sorted_.begin(), sorted_.end());
  }

  const ViewHeader& header() const override { return header_; }
  std::size_t block_count() const override { return runs_.size() - 1; }

  Result<void> read_block(std::size_t number, PointBlock& out) const override {
    const PlyRun& run = runs_[number];
    const auto count = static_cast<std::size_t>(runs_[number + 1].row - run.row);
    out.points_read = count;
    out.not_finite = out.sensor_invalid = 0;
    out.positions.resize(count);  // not cleared before: a block used again for the same size is not zeroed again
    out.rows.resize(count);
    std::iota(out.rows.begin(), out.rows.end(), run.row);
    bool all_finite = true;
    if (ply_.encoding == PlyEncoding::Ascii)
      TRY(read_lines(number, out.positions, all_finite));
    else if (vertex_.has_lists)
      TRY(read_lists(number, out.positions, all_finite));
    else
      TRY(read_fixed(run, count, out.positions, all_finite));
    if (!all_finite) out.not_finite = drop_not_finite(out.positions, out.rows);
    return {};
  }

 private:
  Result<void> read_fixed(const PlyRun& run, std::size_t count, std::vector<Vec3>& positions, bool& all_finite) const {
    thread_local std::vector<char> bytes;
    bytes.resize(std::max<std::size_t>(bytes.size(), count * vertex_.stride));
    TRY(read_exactly(*source_, run.offset, std::span<char>(bytes.data(), count * vertex_.stride)));
    all_finite = decode_positions(bytes.data(), vertex_.stride, xyz_, ply_.swaps_bytes(), count, positions.data());
    return {};
  }

  Result<void> read_lines(std::size_t number, std::vector<Vec3>& positions, bool& all_finite) const {
    thread_local std::vector<char> bytes;
    const PlyRun& run = runs_[number];
    bytes.resize(static_cast<std::size_t>(runs_[number + 1].offset - run.offset));
    TRY(read_exactly(*source_, run.offset, bytes));
    std::string_view rest(bytes.data(), bytes.size());
    std::uint64_t line_number = run.line;
    for (std::size_t i = 0; i < positions.size(); ++line_number) {
      if (rest.empty())
        return fail(Code::IoFailed, "the file changed while it was read", line_place(source_->name(), line_number));
      const auto end = std::min(rest.find('\n'), rest.size());
      const std::string_view line = rest.substr(0, end);
      rest.remove_prefix(std::min(end + 1, rest.size()));
      if (line.find_first_not_of(" \t\r") == std::string_view::npos) continue;
      std::array<double, 3> values{};
      TRY(read_ascii_row(line, vertex_, sorted_, values, source_->name(), line_number));
      positions[i] = in_order(values);
      all_finite &= is_finite(positions[i]);
      ++i;
    }
    return {};
  }

  Result<void> read_lists(std::size_t number, std::vector<Vec3>& positions, bool& all_finite) const {
    Cursor cursor(*source_, runs_[number].offset);
    for (std::size_t i = 0; i < positions.size(); ++i) {
      std::array<double, 3> values{};
      TRY(read_binary_row(cursor, *source_, ply_, vertex_, sorted_, values, runs_[number].row + i));
      positions[i] = in_order(values);
      all_finite &= is_finite(positions[i]);
    }
    return {};
  }

  /// Values in file order to x, y, z.
  Vec3 in_order(const std::array<double, 3>& values) const {
    std::array<double, 3> p{};
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (std::size_t k = 0; k < 3; ++k)
        if (sorted_[k] == columns_[axis]) p[axis] = values[k];
    return {p[0], p[1], p[2]};
  }

  std::shared_ptr<const ByteSource> source_;
  PlyHeader ply_;
  const PlyElement& vertex_;
  std::array<int, 3> columns_;  // of x, y, z
  std::array<int, 3> sorted_;   // the same in file order
  Coordinate xyz_[3];
  std::vector<PlyRun> runs_;
  ViewHeader header_;
};

}  // namespace

Result<std::unique_ptr<ViewReader>> open_ply(std::shared_ptr<const ByteSource> source) {
  TRY_ASSIGN(PlyHeader header, read_ply_header(*source));
  const int vertex = header.find("vertex");
  if (vertex < 0)
    return fail(Code::BadInput, "the header declares no element \"vertex\", so there are no points", source->name());
  TRY_ASSIGN(const auto columns, find_xyz(*source, header.elements[static_cast<std::size_t>(vertex)]));
  TRY_ASSIGN(PlyLayout layout, find_rows(*source, header, static_cast<std::size_t>(vertex)));
  return std::unique_ptr<ViewReader>(std::make_unique<PlyReader>(
      std::move(source), std::move(header), static_cast<std::size_t>(vertex), columns, std::move(layout)));
}

}  // namespace scanmill::formats
