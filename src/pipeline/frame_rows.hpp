// SPDX-License-Identifier: Apache-2.0
// Frames of a cut scan, out of the files of its batches, and the links from the bins of a piece to those of the whole.
#pragma once
#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "pipeline/brick_rows.hpp"

namespace scanmill::pipeline {

/// Frames by their place among all bins, out of the files of all batches.
class FrameReader {
 public:
  static Result<FrameReader> open(const Cut& cut, const Totals& totals) {
    FrameReader reader;
    reader.begins_.assign(cut.batches + 1, 0);
    for (const Cell& cell : totals.cells) reader.begins_[cell.batch + 1] += cell.rows;
    for (std::uint32_t n = 0; n < cut.batches; ++n) {
      reader.begins_[n + 1] += reader.begins_[n];
      TRY_ASSIGN(PartFile file, need_part(cut, {PartStage::Frame, n}));
      if (file.rows() != reader.begins_[n + 1] - reader.begins_[n])
        return fail(Code::IoFailed, "holds other bins than the totals; remove the folder and run again",
                    path_of(cut, name_of({PartStage::Frame, n})));
      reader.files_.push_back(std::move(file));
    }
    return reader;
  }
  /// `row` does not fall from call to call for speed.
  Result<const FrameRow*> get(std::uint64_t row) {
    if (row < first_ || row >= first_ + rows_.size()) {
      const auto batch =
          static_cast<std::size_t>(std::upper_bound(begins_.begin(), begins_.end(), row) - begins_.begin() - 1);
      first_ = row;
      rows_.resize(static_cast<std::size_t>(std::min<std::uint64_t>(kRowsAtOnce, begins_[batch + 1] - row)));
      TRY(files_[batch].read_rows(row - begins_[batch], std::span<FrameRow>(rows_)));
    }
    return &rows_[static_cast<std::size_t>(row - first_)];
  }

 private:
  std::vector<PartFile> files_;
  std::vector<std::uint64_t> begins_;  // first row of each batch
  std::vector<FrameRow> rows_;
  std::uint64_t first_ = 0;
};

/// errors  IoFailed naming the task that makes it
Result<PartFile> need_link(const Cut& cut, std::uint32_t piece);

}  // namespace scanmill::pipeline
