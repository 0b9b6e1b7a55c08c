// SPDX-License-Identifier: Apache-2.0
// Where the rows of a cut scan lie among all of them: bricks are runs of rows, and so is every cell of the lattice that
// a brick's surroundings are read from.
#pragma once
#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "pipeline/cut_scan.hpp"
#include "pipeline/part_rows.hpp"

namespace scanmill::pipeline {

/// What stands behind the totals.
struct TotalsText {
  CountsText counts;
  double noise = 0;
  std::int32_t frame_radius = 1;
  std::uint32_t cell_bins = 32;
  std::uint64_t cells = 0;
};

/// A block of the lattice no larger than a brick, and its rows among all.
struct Cell {
  LocalBin low{};  // its least bin
  std::uint32_t batch = 0;
  std::uint64_t first = 0, rows = 0;
};

/// All bins of a scan, ascending key.
struct Totals {
  PartFile file;
  TotalsText text;
  std::vector<Cell> cells;  // ascending key
};
/// errors  IoFailed naming the task that makes it
Result<Totals> need_totals(const Cut& cut);

struct Brick {
  LocalBin low{};  // its least bin
  std::uint32_t batch = 0;
  std::uint64_t first = 0, rows = 0;
};
/// Ascending key, so that all rows follow one another.
std::vector<Brick> bricks_of(const Totals& totals, std::uint32_t brick_bins);

inline LocalBin low_of(const LocalBin& bin, std::uint32_t edge) {
  const auto mask = ~static_cast<std::int32_t>(edge - 1);
  return {bin[0] & mask, bin[1] & mask, bin[2] & mask};
}
inline bool stands_before(const BinKey& base, const LocalBin& a, const LocalBin& b) {
  return before(BinKey{base.i + a[0], base.j + a[1], base.k + a[2]},
                BinKey{base.i + b[0], base.j + b[1], base.k + b[2]});
}
/// In the brick, or at most `halo` bins from it.
inline bool is_inside(const LocalBin& bin, const LocalBin& low, std::uint32_t brick_bins, std::int32_t halo) {
  for (std::size_t k = 0; k < 3; ++k)
    if (bin[k] < low[k] - halo || bin[k] >= low[k] + static_cast<std::int32_t>(brick_bins) + halo) return false;
  return true;
}

/// Rows one after the other.
struct Run {
  std::uint64_t first = 0, rows = 0;
};
/// The brick's rows and those of all cells that come within `halo` bins of it, ascending.
std::vector<Run> runs_around(const Totals& totals, const BinKey& base, const Brick& brick, std::uint32_t brick_bins,
                             std::int32_t halo);
template <class Row>
Result<std::vector<Row>> read_runs(const PartFile& file, const std::vector<Run>& runs) {
  std::uint64_t count = 0;
  for (const Run& run : runs) count += run.rows;
  std::vector<Row> rows(static_cast<std::size_t>(count));
  std::size_t at = 0;
  for (const Run& run : runs) {
    TRY(file.read_rows(run.first, std::span(rows).subspan(at, static_cast<std::size_t>(run.rows))));
    at += static_cast<std::size_t>(run.rows);
  }
  return rows;
}

inline constexpr std::size_t kRowsAtOnce = 4096;

/// Rows of a part one after the other.
template <class Row>
class RowStream {
 public:
  explicit RowStream(const PartFile& file) : file_(file) {}
  bool at_end() const { return next_ == file_.rows(); }
  std::uint64_t row() const { return next_; }
  /// The row at hand; the pointer holds until the next step.
  Result<const Row*> get() {
    if (next_ < begin_ || next_ >= begin_ + rows_.size()) {
      begin_ = next_;
      rows_.resize(static_cast<std::size_t>(std::min<std::uint64_t>(kRowsAtOnce, file_.rows() - next_)));
      TRY(file_.read_rows(begin_, std::span<Row>(rows_)));
    }
    return &rows_[static_cast<std::size_t>(next_ - begin_)];
  }
  void step() { ++next_; }
  void move_to(std::uint64_t row) { next_ = row; }

 private:
  const PartFile& file_;
  std::vector<Row> rows_;
  std::uint64_t begin_ = 0, next_ = 0;
};

}  // namespace scanmill::pipeline
