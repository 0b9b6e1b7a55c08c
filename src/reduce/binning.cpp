// SPDX-License-Identifier: Apache-2.0
#include "reduce/binning.hpp"

#include <atomic>
#include <limits>
#include <mutex>

namespace scanmill::reduce {
namespace {

constexpr double kMaxLocal = 1 << 30;

/// Floor as a conversion and a correction: exact for |u| < 2^52 and no call into libm on plain x86-64.
std::int64_t floor_to_int(double u) {
  const auto i = static_cast<std::int64_t>(u);
  return i - (u < static_cast<double>(i));
}

/// The first failure in block order, so that the message does not depend on threads: blocks behind a failed one are
/// skipped, those before it are still read.
class FirstError {
 public:
  void report(std::size_t block, Error error) {
    std::lock_guard<std::mutex> guard(mutex_);
    if (block >= block_.load(std::memory_order_relaxed)) return;
    error_ = std::move(error);
    block_.store(block, std::memory_order_relaxed);
  }
  bool is_before(std::size_t block) const { return block_.load(std::memory_order_relaxed) < block; }
  Result<void> take(const Context& context) {
    if (block_.load(std::memory_order_relaxed) != kNone) return std::move(error_);
    if (context.cancel.is_set()) return fail(Code::Cancelled, "stopped on request");
    return {};
  }

 private:
  static constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
  std::mutex mutex_;
  Error error_;
  std::atomic<std::size_t> block_{kNone};
};

/// Reads every block once, on all workers; body(worker, block) sees a private buffer.
template <class Body>
Result<void> over_blocks(const PointSource& points, const Context& context, Body body) {
  FirstError first;
  std::vector<PointBlock> buffers(static_cast<std::size_t>(context.loop.threads()));
  context.loop.run(points.block_count(), [&](std::size_t number, int worker) {
    if (context.cancel.is_set() || first.is_before(number)) return;
    PointBlock& block = buffers[static_cast<std::size_t>(worker)];
    auto read = points.read_block(number, block);
    if (read.ok()) read = body(worker, block);
    if (!read.ok()) first.report(number, std::move(read).error());
  });
  return first.take(context);
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

/// Places of a block's points in the lattice: local bins, and where in its bin a point lies, in bin edges about the centre.
struct Placed {
  std::vector<LocalBin> bins;
  std::vector<Vec3> inside;
  std::vector<std::int32_t> slots;
};

Result<void> place_points(const LocalFrame& frame, const PointBlock& block, Placed& out, Bounds& bounds) {
  const std::size_t n = block.positions.size();
  out.bins.resize(n);
  out.inside.resize(n);
  out.slots.resize(n);
  const double h = frame.lattice.edge_mm;
  const Vec3 origin = frame.lattice.origin;
  Bounds box;
  for (const Vec3 p : block.positions) box.add(p);
  // One check per block, before any conversion: all points of a box fit when its corners do.
  LocalBin corner;
  if (n > 0 && !(frame.bin_of(box.low, corner) && frame.bin_of(box.high, corner)))
    return fail(Code::BadInput,
                "the cloud is more than 2^30 bins wide; stray points far away, wrong units, or too small a bin edge");
  bounds.add(box);
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3 p = block.positions[i];
    const double u[3] = {(p.x - origin.x) / h, (p.y - origin.y) / h, (p.z - origin.z) / h};
    const std::int64_t bin[3] = {floor_to_int(u[0]), floor_to_int(u[1]), floor_to_int(u[2])};
    out.bins[i] = {static_cast<std::int32_t>(bin[0] - frame.base.i), static_cast<std::int32_t>(bin[1] - frame.base.j),
                   static_cast<std::int32_t>(bin[2] - frame.base.k)};
    out.inside[i] = {u[0] - static_cast<double>(bin[0]) - 0.5, u[1] - static_cast<double>(bin[1]) - 0.5,
                     u[2] - static_cast<double>(bin[2]) - 0.5};
  }
  return {};
}

struct alignas(64) PassOne {
  BinTree tree;
  std::vector<Winner> winners;
  std::vector<Moments> moments;
  Placed placed;
  ReadCounts counts;
};

void add_moments(Moments& m, Vec3 inside) {
  const std::int64_t x = floor_to_int(inside.x * 1024 + 0.5), y = floor_to_int(inside.y * 1024 + 0.5),
                     z = floor_to_int(inside.z * 1024 + 0.5);
  ++m.count;
  m.sum[0] += x;
  m.sum[1] += y;
  m.sum[2] += z;
  m.product[0] += x * x;
  m.product[1] += x * y;
  m.product[2] += x * z;
  m.product[3] += y * y;
  m.product[4] += y * z;
  m.product[5] += z * z;
}

void add_direction(Moments& m, const ViewPoint& view, Vec3 p) {
  const Vec3 d = view.eye ? unit(*view.eye - p) : *view.direction;
  m.view_direction[0] += floor_to_int(d.x * 0x1p20 + 0.5);
  m.view_direction[1] += floor_to_int(d.y * 0x1p20 + 0.5);
  m.view_direction[2] += floor_to_int(d.z * 0x1p20 + 0.5);
}

void add(Moments& into, const Moments& from) {
  into.count += from.count;
  for (int k = 0; k < 3; ++k) into.sum[k] += from.sum[k];
  for (int k = 0; k < 6; ++k) into.product[k] += from.product[k];
  for (int k = 0; k < 3; ++k) into.view_direction[k] += from.view_direction[k];
}

void bin_block(const PointBlock& block, bool with_moments, PassOne& pass) {
  Placed& placed = pass.placed;
  pass.tree.slots_of(placed.bins, placed.slots);
  const auto slots = static_cast<std::size_t>(pass.tree.size());
  pass.winners.resize(slots);
  if (with_moments) pass.moments.resize(slots);
  const bool seen = block.view_point.eye.has_value() || block.view_point.direction.has_value();
  for (std::size_t i = 0; i < block.positions.size(); ++i) {
    const auto slot = static_cast<std::size_t>(placed.slots[i]);
    const Winner candidate{norm2(placed.inside[i]), block.positions[i], {block.view, block.rows[i]}};
    Winner& winner = pass.winners[slot];
    if (candidate.score < winner.score || (candidate.score == winner.score && better(candidate, winner))) winner = candidate;
    if (!with_moments) continue;
    add_moments(pass.moments[slot], placed.inside[i]);
    if (seen) add_direction(pass.moments[slot], block.view_point, block.positions[i]);
  }
}

Error changed_between_readings() {
  return fail(Code::BadInput, "an input changed between the first and the second reading; let it be written to its end "
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
    if (!(std::abs(u[k]) < 0x1p52)) return false;
    const double local = static_cast<double>(floor_to_int(u[k]) - from[k]);
    if (!(std::abs(local) < kMaxLocal)) return false;
    bin[static_cast<std::size_t>(k)] = static_cast<std::int32_t>(local);
  }
  return true;
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

Result<BinTotals> bin_points(const PointSource& points, const LocalFrame& frame, bool with_moments, ReadCounts& counts,
                             const Context& context) {
  std::vector<PassOne> pass(static_cast<std::size_t>(context.loop.threads()));
  TRY(over_blocks(points, context, [&](int worker, const PointBlock& block) -> Result<void> {
    PassOne& mine = pass[static_cast<std::size_t>(worker)];
    add_counts(mine.counts, block);
    TRY(place_points(frame, block, mine.placed, mine.counts.bounds));
    bin_block(block, with_moments, mine);
    return {};
  }));
  PassOne& all = pass.front();
  BinTotals totals;
  for (const PassOne& part : pass) totals.index_bytes += part.tree.memory_bytes();
  for (std::size_t worker = 1; worker < pass.size(); ++worker) {
    PassOne& part = pass[worker];
    merge(all.counts, part.counts);
    const auto entries = part.tree.sorted(frame.base);
    std::vector<LocalBin> bins(entries.size());
    std::vector<std::int32_t> slots(entries.size());
    for (std::size_t i = 0; i < entries.size(); ++i) bins[i] = entries[i].bin;
    all.tree.slots_of(bins, slots);
    all.winners.resize(static_cast<std::size_t>(all.tree.size()));
    if (with_moments) all.moments.resize(all.winners.size());
    for (std::size_t i = 0; i < entries.size(); ++i) {
      const auto from = static_cast<std::size_t>(entries[i].slot), to = static_cast<std::size_t>(slots[i]);
      if (better(part.winners[from], all.winners[to])) all.winners[to] = part.winners[from];
      if (with_moments) add(all.moments[to], part.moments[from]);
    }
    part = PassOne();
  }
  counts = all.counts;
  totals.order = all.tree.sorted(frame.base);
  totals.winners = std::move(all.winners);
  totals.moments = std::move(all.moments);
  return totals;
}

Result<std::uint64_t> count_bins(const PointSource& points, const LocalFrame& frame, const Context& context) {
  std::vector<PassOne> pass(static_cast<std::size_t>(context.loop.threads()));
  TRY(over_blocks(points, context, [&](int worker, const PointBlock& block) -> Result<void> {
    PassOne& mine = pass[static_cast<std::size_t>(worker)];
    TRY(place_points(frame, block, mine.placed, mine.counts.bounds));
    mine.tree.slots_of(mine.placed.bins, mine.placed.slots);
    return {};
  }));
  BinTree& all = pass.front().tree;
  for (std::size_t worker = 1; worker < pass.size(); ++worker) {
    const auto entries = pass[worker].tree.sorted(frame.base);
    std::vector<LocalBin> bins(entries.size());
    std::vector<std::int32_t> slots(entries.size());
    for (std::size_t i = 0; i < entries.size(); ++i) bins[i] = entries[i].bin;
    all.slots_of(bins, slots);
  }
  return static_cast<std::uint64_t>(all.size());
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
    TRY(place_points(frame, block, mine.placed, mine.bounds));
    mine.reader->rows_of(mine.placed.bins, mine.placed.slots);
    for (std::size_t i = 0; i < block.positions.size(); ++i) {
      const std::int32_t slot = mine.placed.slots[i];
      if (slot == kNoSlot) return changed_between_readings();
      const auto row = static_cast<std::size_t>(slot);
      const Target& target = targets[row];
      const Vec3 d = block.positions[i] - target.foot;
      const double off = dot(d, target.normal);
      const double score = target.crease ? -std::abs(off) : norm2(d) + 3 * off * off;
      Winner& winner = mine.winners[row];
      if (score > winner.score) continue;
      const Winner candidate{score, block.positions[i], {block.view, block.rows[i]}};
      if (better(candidate, winner)) winner = candidate;
    }
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
