// SPDX-License-Identifier: Apache-2.0
#include "pipeline/brick_rows.hpp"

#include <cstring>

namespace scanmill::pipeline {

Result<Totals> need_totals(const Cut& cut) {
  TRY_ASSIGN(PartFile file, need_part(cut, {PartStage::Gather, 0}));
  Totals totals{std::move(file), {}, {}};
  const std::string& text = totals.file.text();
  const Error cut_short = fail(Code::IoFailed, "ends inside its table", path_of(cut, "gather"));
  if (text.size() < sizeof totals.text) return cut_short;
  std::memcpy(&totals.text, text.data(), sizeof totals.text);
  if (text.size() != sizeof totals.text + totals.text.cells * sizeof(Cell)) return cut_short;
  totals.cells.resize(totals.text.cells);
  std::memcpy(totals.cells.data(), text.data() + sizeof totals.text, totals.cells.size() * sizeof(Cell));
  return totals;
}

std::vector<Brick> bricks_of(const Totals& totals, std::uint32_t brick_bins) {
  std::vector<Brick> bricks;
  for (const Cell& cell : totals.cells) {
    const LocalBin low = low_of(cell.low, brick_bins);
    if (bricks.empty() || bricks.back().low != low) bricks.push_back({low, cell.batch, cell.first, 0});
    bricks.back().rows += cell.rows;
  }
  return bricks;
}

std::vector<Run> runs_around(const Totals& totals, const BinKey& base, const Brick& brick, std::uint32_t brick_bins,
                             std::int32_t halo) {
  const auto edge = static_cast<std::int32_t>(brick_bins), step = static_cast<std::int32_t>(totals.text.cell_bins);
  const std::int32_t out = (halo + step - 1) / step * step;
  std::vector<Run> runs{{brick.first, brick.rows}};
  LocalBin at;
  for (at[0] = brick.low[0] - out; at[0] < brick.low[0] + edge + out; at[0] += step)
    for (at[1] = brick.low[1] - out; at[1] < brick.low[1] + edge + out; at[1] += step)
      for (at[2] = brick.low[2] - out; at[2] < brick.low[2] + edge + out; at[2] += step) {
        if (low_of(at, brick_bins) == brick.low) continue;
        const auto cell =
            std::lower_bound(totals.cells.begin(), totals.cells.end(), at,
                             [&](const Cell& c, const LocalBin& wanted) { return stands_before(base, c.low, wanted); });
        if (cell != totals.cells.end() && cell->low == at) runs.push_back({cell->first, cell->rows});
      }
  std::sort(runs.begin(), runs.end(), [](const Run& a, const Run& b) { return a.first < b.first; });
  return runs;
}

}  // namespace scanmill::pipeline
