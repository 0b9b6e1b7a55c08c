// SPDX-License-Identifier: Apache-2.0
#include "reduce/binning.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <utility>

#include "base/large_pages.hpp"
#include "base/text.hpp"
#include "cloud/over_blocks.hpp"
#include "reduce/placing.hpp"

namespace scanmill::reduce {
namespace {

constexpr double kMaxLocal = 1 << 30;
constexpr std::size_t kAhead = 16;  // runs; what a bin holds is rarely in the first cache when a line comes back to it

/// Floor as a conversion and a correction: exact for |u| < 2^52 and no call into libm on plain x86-64.
std::int64_t floor_to_int(double u) {
  const auto i = static_cast<std::int64_t>(u);
  return i - (u < static_cast<double>(i));
}

void add_counts(ReadCounts& counts, const PointBlock& block) {
  counts.points_read += block.points_read;
  counts.not_finite += block.not_finite;
  counts.sensor_invalid += block.sensor_invalid;
  counts.points_used += block.positions.size();
}

void merge(ReadCounts& into, const ReadCounts& from) {
  into.points_read += from.points_read;
  into.not_finite += from.not_finite;
  into.sensor_invalid += from.sensor_invalid;
  into.points_used += from.points_used;
  into.bounds.add(from.bounds);
}

/// One check per block, before any conversion: all points of a box fit when its corners do.
Result<void> check_fit(const LocalFrame& frame, const PointBlock& block, Bounds& bounds) {
  const Bounds box = box_of(block.positions);
  LocalBin corner;
  if (!box.empty() && !(frame.bin_of(box.low, corner) && frame.bin_of(box.high, corner)))
    return fail(Code::BadInput,
                "the cloud is more than 2^30 bins wide; stray points far away, wrong units, or too small a bin edge");
  bounds.add(box);
  return {};
}

/// body(first) for the tiles of a block, placed and cut into runs; `first` is the tile's first point in the block.
template <class Body>
void over_tiles(const LocalFrame& frame, const PointBlock& block, Placed& placed, Body body) {
  for (std::size_t first = 0; first < block.positions.size(); first += Placed::kTile) {
    const std::size_t count = std::min(Placed::kTile, block.positions.size() - first);
    place(frame.lattice, frame.base, std::span(block.positions).subspan(first, count), placed);
    body(first);
  }
}

std::span<const LocalBin> run_bins(const Placed& placed) { return std::span(placed.bins).first(placed.runs); }
std::span<std::int32_t> run_slots(Placed& placed) { return std::span(placed.slots).first(placed.runs); }

struct alignas(64) PassOne {
  BinTree tree;
  Blocks<Cell> cells;
  Blocks<Direction> directions;  // empty while no view tells
  Placed placed;
  RunSums sums;
  ReadCounts counts;
};

Direction direction_units(Vec3 d) {
  return {floor_to_int(d.x * 0x1p20 + 0.5), floor_to_int(d.y * 0x1p20 + 0.5), floor_to_int(d.z * 0x1p20 + 0.5)};
}

/// The directions towards the sensor of the points of a run.
void add_directions(Direction& sum, const ViewPoint& view, std::span<const Vec3> points) {
  if (!view.eye) {
    const Direction d = direction_units(*view.direction);
    for (std::size_t k = 0; k < 3; ++k) sum[k] += d[k] * static_cast<std::int64_t>(points.size());
    return;
  }
  for (const Vec3 p : points) {
    const Direction d = direction_units(unit(*view.eye - p));
    for (std::size_t k = 0; k < 3; ++k) sum[k] += d[k];
  }
}

void bin_block(const LocalFrame& frame, const PointBlock& block, PassOne& pass) {
  Placed& placed = pass.placed;
  const bool seen = block.view_point.eye.has_value() || block.view_point.direction.has_value();
  over_tiles(frame, block, placed, [&](std::size_t first) {
    pass.tree.slots_of(run_bins(placed), run_slots(placed));
    pass.cells.grow(static_cast<std::size_t>(pass.tree.size()));
    auto cell_of = [&](std::size_t run) -> Cell& { return pass.cells[static_cast<std::size_t>(placed.slots[run])]; };
    auto fetch = [&](std::size_t run) {
      const char* cell = reinterpret_cast<const char*>(&cell_of(run));
      __builtin_prefetch(cell, 1);
      __builtin_prefetch(cell + 64, 1);
    };
    for (std::size_t run = 0; run < std::min(kAhead, placed.runs); ++run) fetch(run);
    sum_runs(placed, pass.sums);
    for (std::size_t run = 0; run < placed.runs; ++run) {
      if (run + kAhead < placed.runs) fetch(run + kAhead);
      Cell& cell = cell_of(run);
      cell.sums.add(pass.sums, run);
      const double least = pass.sums.least(run);
      if (least > cell.score) continue;
      for (std::size_t i = placed.first[run]; i < placed.first[run + 1]; ++i)
        if (placed.score[i] == least)
          cell.keep_better({least, block.positions[first + i], {block.view, block.rows[first + i]}});
    }
    if (!seen) return;
    pass.directions.grow(pass.cells.size());
    for (std::size_t run = 0; run < placed.runs; ++run)
      add_directions(
          pass.directions[static_cast<std::size_t>(placed.slots[run])], block.view_point,
          std::span(block.positions).subspan(first + placed.first[run], placed.first[run + 1] - placed.first[run]));
  });
}

/// The bins of all workers in ascending key: visit(bin, worker, slot, is_first), once for each worker that met it.
template <class Visit>
void over_bins(std::vector<PassOne>& pass, const BinKey& base, Visit visit) {
  struct Cursor {
    std::vector<BinTree::Entry> entries;
    std::size_t next = 0, worker = 0;
    BinKey key;
  };
  std::vector<Cursor> cursors(pass.size());
  auto key_of = [&](const LocalBin& bin) { return BinKey{base.i + bin[0], base.j + bin[1], base.k + bin[2]}; };
  auto later = [&](std::size_t a, std::size_t b) {
    const BinKey &x = cursors[a].key, &y = cursors[b].key;
    return x == y ? a > b : before(y, x);
  };
  std::vector<std::size_t> heap;
  for (std::size_t worker = 0; worker < pass.size(); ++worker) {
    Cursor& cursor = cursors[worker];
    cursor.worker = worker;
    cursor.entries = pass[worker].tree.sorted(base);
    pass[worker].tree = BinTree();
    if (cursor.entries.empty()) continue;
    cursor.key = key_of(cursor.entries.front().bin);
    heap.push_back(worker);
  }
  std::make_heap(heap.begin(), heap.end(), later);
  std::optional<BinKey> last;
  while (!heap.empty()) {
    std::pop_heap(heap.begin(), heap.end(), later);
    const std::size_t worker = heap.back();
    heap.pop_back();
    Cursor& cursor = cursors[worker];
    do {  // workers mostly met bins of their own
      const BinTree::Entry& entry = cursor.entries[cursor.next];
      visit(entry.bin, worker, static_cast<std::size_t>(entry.slot), last != cursor.key);
      last = cursor.key;
      if (++cursor.next == cursor.entries.size()) break;
      cursor.key = key_of(cursor.entries[cursor.next].bin);
    } while (heap.empty() || later(heap.front(), worker));
    if (cursor.next == cursor.entries.size()) continue;
    heap.push_back(worker);
    std::push_heap(heap.begin(), heap.end(), later);
  }
}

/// Where each worker's cells begin among all, which are moved to `all`.
std::vector<std::size_t> gather_cells(std::vector<PassOne>& pass, BinCells& all) {
  const bool any_seen =
      std::any_of(pass.begin(), pass.end(), [](const PassOne& part) { return part.directions.size() > 0; });
  std::vector<std::size_t> begins;
  for (PassOne& part : pass) {
    if (any_seen) part.directions.grow(part.cells.size());
    all.directions.take(std::exchange(part.directions, {}));
    begins.push_back(all.cells.take(std::exchange(part.cells, {})));
  }
  return begins;
}

Error changed_between_readings() {
  return fail(Code::BadInput,
              "an input changed between the first and the second reading; let it be written to its end "
              "and run again");
}

}  // namespace

bool better(const Winner& a, const Winner& b) {
  if (a.score != b.score) return a.score < b.score;
  if (!(a.position == b.position)) return before(a.position, b.position);
  return a.source < b.source;
}

bool LocalFrame::bin_of(Vec3 p, LocalBin& bin) const {
  const double h = lattice.edge_mm;
  const double u[3] = {(p.x - lattice.origin.x) / h, (p.y - lattice.origin.y) / h, (p.z - lattice.origin.z) / h};
  const std::int64_t from[3] = {base.i, base.j, base.k};
  for (int k = 0; k < 3; ++k) {
    if (!(std::abs(u[k]) < 0x1p51)) return false;
    const double local = static_cast<double>(floor_to_int(u[k]) - from[k]);
    if (!(std::abs(local) < kMaxLocal)) return false;
    bin[static_cast<std::size_t>(k)] = static_cast<std::int32_t>(local);
  }
  return true;
}

Result<void> check_numbers(std::uint64_t bins, std::uint64_t kept, double edge_mm) {
  const bool too_many_bins = bins > kMostBins;
  if (!too_many_bins && kept <= kMostKept) return {};
  const std::uint64_t found = too_many_bins ? bins : kept, most = too_many_bins ? kMostBins : kMostKept;
  // Bins of a surface go with the inverse square of the edge; a tenth more than that is sure to do.
  const double share = static_cast<double>(found) / static_cast<double>(most);
  return fail(Code::BadInput, "bins of " + number_text(edge_mm) + " mm give " + grouped(found) +
                                  (too_many_bins ? " or more of them" : " points of the mesh") + ", at most " +
                                  grouped(most) + " can be numbered; wanted bins of " +
                                  six_digits(1.1 * std::sqrt(share) * edge_mm) + " mm or more");
}

Result<ReadCounts> read_bounds(const PointSource& points, const Context& context) {
  std::vector<ReadCounts> part(static_cast<std::size_t>(context.loop.threads()));
  TRY(over_blocks(points, context, [&](int worker, const PointBlock& block) -> Result<void> {
    ReadCounts& counts = part[static_cast<std::size_t>(worker)];
    add_counts(counts, block);
    for (const Vec3 p : block.positions) counts.bounds.add(p);
    return {};
  }));
  ReadCounts total;
  for (const ReadCounts& counts : part) merge(total, counts);
  return total;
}

Result<Vec3> first_point(const PointSource& points) {
  PointBlock block;
  for (std::size_t number = 0; number < points.block_count(); ++number) {
    TRY(points.read_block(number, block));
    if (!block.positions.empty()) return block.positions.front();
  }
  return fail(Code::BadInput, "no finite point in any file of the scan; nothing to mesh");
}

Result<BinTotals> bin_points(const PointSource& points, const LocalFrame& frame, ReadCounts& counts,
                             const Context& context) {
  std::vector<PassOne> pass(static_cast<std::size_t>(context.loop.threads()));
  TRY(over_blocks(points, context, [&](int worker, const PointBlock& block) -> Result<void> {
    PassOne& mine = pass[static_cast<std::size_t>(worker)];
    add_counts(mine.counts, block);
    TRY(check_fit(frame, block, mine.counts.bounds));
    TRY(check_numbers(static_cast<std::uint64_t>(mine.tree.size()) + block.positions.size(), 0, frame.lattice.edge_mm));
    bin_block(frame, block, mine);
    return {};
  }));
  BinTotals totals;
  counts = {};
  std::size_t most = 0;
  for (const PassOne& part : pass) {
    merge(counts, part.counts);
    totals.index_bytes += part.tree.memory_bytes();
    most += part.cells.size();
  }
  BinCells& all = totals.cells;
  const std::vector<std::size_t> begins = gather_cells(pass, all);
  reserve_large(totals.bins, most);
  reserve_large(all.at, most);
  over_bins(pass, frame.base, [&](const LocalBin& bin, std::size_t worker, std::size_t slot, bool is_first) {
    const std::size_t place = begins[worker] + slot;
    if (is_first) {
      totals.bins.push_back(bin);
      all.at.push_back(static_cast<std::uint32_t>(place));
      return;
    }
    const std::size_t into = all.at.back();
    all.cells[into].keep_better(all.cells[place].winner());
    all.cells[into].sums.add(all.cells[place].sums);
    for (std::size_t k = 0; all.directions.size() > 0 && k < 3; ++k)
      all.directions[into][k] += all.directions[place][k];
  });
  TRY(check_numbers(totals.bins.size(), 0, frame.lattice.edge_mm));
  totals.cell_bytes = totals.bins.size() * (sizeof(Cell) + (all.directions.size() > 0 ? sizeof(Direction) : 0));
  return totals;
}

Result<std::uint64_t> count_bins(const PointSource& points, const LocalFrame& frame, const Context& context) {
  std::vector<PassOne> pass(static_cast<std::size_t>(context.loop.threads()));
  TRY(over_blocks(points, context, [&](int worker, const PointBlock& block) -> Result<void> {
    PassOne& mine = pass[static_cast<std::size_t>(worker)];
    TRY(check_fit(frame, block, mine.counts.bounds));
    TRY(check_numbers(static_cast<std::uint64_t>(mine.tree.size()) + block.positions.size(), 0, frame.lattice.edge_mm));
    over_tiles(frame, block, mine.placed,
               [&](std::size_t) { mine.tree.slots_of(run_bins(mine.placed), run_slots(mine.placed)); });
    return {};
  }));
  std::uint64_t bins = 0;
  over_bins(pass, frame.base,
            [&](const LocalBin&, std::size_t, std::size_t, bool is_first) { bins += is_first ? 1 : 0; });
  return bins;
}

Result<std::vector<Winner>> pick_against(const PointSource& points, const LocalFrame& frame, const BinIndex& index,
                                         const std::vector<Target>& targets, const Context& context) {
  struct alignas(64) Part {
    std::vector<Winner> winners;
    std::unique_ptr<BinIndex::Reader> reader;
    Placed placed;
    Bounds bounds;
  };
  std::vector<Part> parts(static_cast<std::size_t>(context.loop.threads()));
  TRY(over_blocks(points, context, [&](int worker, const PointBlock& block) -> Result<void> {
    Part& mine = parts[static_cast<std::size_t>(worker)];
    if (!mine.reader) {
      mine.reader = std::make_unique<BinIndex::Reader>(index);
      mine.winners.resize(targets.size());
    }
    TRY(check_fit(frame, block, mine.bounds));
    Placed& placed = mine.placed;
    bool known = true;
    over_tiles(frame, block, placed, [&](std::size_t first) {
      mine.reader->rows_of(run_bins(placed), run_slots(placed));
      auto fetch = [&](std::size_t run) {
        if (placed.slots[run] == kNoSlot) return;
        const auto row = static_cast<std::size_t>(placed.slots[run]);
        __builtin_prefetch(&targets[row]);
        __builtin_prefetch(&targets[row].normal.z);
        __builtin_prefetch(&mine.winners[row], 1);
      };
      for (std::size_t run = 0; run < std::min(kAhead, placed.runs); ++run) fetch(run);
      for (std::size_t run = 0; run < placed.runs; ++run) {
        if (run + kAhead < placed.runs) fetch(run + kAhead);
        if (placed.slots[run] == kNoSlot) {
          known = false;
          continue;
        }
        const auto row = static_cast<std::size_t>(placed.slots[run]);
        const Target target = targets[row];
        Winner& winner = mine.winners[row];
        for (std::size_t i = placed.first[run]; i < placed.first[run + 1]; ++i) {
          const Vec3 p = block.positions[first + i], d = p - target.foot;
          const double off = dot(d, target.normal);
          const double score = target.crease ? -std::abs(off) : norm2(d) + 3 * off * off;
          if (score > winner.score) continue;
          const Winner candidate{score, p, {block.view, block.rows[first + i]}};
          if (better(candidate, winner)) winner = candidate;
        }
      }
    });
    if (!known) return changed_between_readings();
    return {};
  }));
  std::vector<Winner> winners(targets.size());
  for (const Part& part : parts)
    for (std::size_t row = 0; row < part.winners.size(); ++row)
      if (better(part.winners[row], winners[row])) winners[row] = part.winners[row];
  const double none = Winner().score;
  for (const Winner& winner : winners)
    if (winner.score == none) return changed_between_readings();
  return winners;
}

}  // namespace scanmill::reduce
