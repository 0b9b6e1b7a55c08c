// SPDX-License-Identifier: Apache-2.0
#include "pipeline/cut_scan.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
#include <queue>

#include "base/text.hpp"
#include "cloud/piece.hpp"
#include "pipeline/part_rows.hpp"
#include "verify/verify.hpp"

namespace scanmill::pipeline {
namespace {

using reduce::BinTotals;
using reduce::Frames;
using reduce::LocalFrame;
using reduce::Winner;

constexpr std::size_t kRowsAtOnce = 4096;

std::string link_name(std::uint32_t piece) { return "link " + std::to_string(piece); }

Result<PartFile> need_link(const Cut& cut, std::uint32_t piece) {
  const std::string name = link_name(piece), path = path_of(cut, name);
  if (auto file = PartFile::open(path, kind_of(cut, name, sizeof(std::uint64_t)))) return *std::move(file);
  return fail(Code::IoFailed, "is not there or another run's; the task 'gather' makes it", path);
}

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

/// A block of the lattice no larger than a brick, and its rows among the totals.
struct Cell {
  LocalBin low{};  // its least bin
  std::uint32_t batch = 0;
  std::uint64_t first = 0, rows = 0;
};

/// What stands behind the totals.
struct TotalsText {
  CountsText counts;
  double noise = 0;
  std::int32_t frame_radius = 1;
  std::uint32_t cell_bins = 32;
  std::uint64_t cells = 0;
};

struct Totals {
  PartFile file;
  TotalsText text;
  std::vector<Cell> cells;  // ascending key
};

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

LocalBin low_of(const LocalBin& bin, std::uint32_t edge) {
  const auto mask = ~static_cast<std::int32_t>(edge - 1);
  return {bin[0] & mask, bin[1] & mask, bin[2] & mask};
}

bool stands_before(const BinKey& base, const LocalBin& a, const LocalBin& b) {
  return before(BinKey{base.i + a[0], base.j + a[1], base.k + a[2]},
                BinKey{base.i + b[0], base.j + b[1], base.k + b[2]});
}

/// Bricks stay whole; every batch gets about as many bins as the others, in the order of keys.
void share_out(std::vector<Cell>& cells, std::uint64_t bins, const Cut& cut) {
  std::uint32_t batch = 0;
  std::uint64_t before = 0;
  for (std::size_t n = 0; n < cells.size(); ++n) {
    const bool begins = n == 0 || low_of(cells[n].low, cut.brick_bins) != low_of(cells[n - 1].low, cut.brick_bins);
    while (begins && batch + 1 < cut.batches && before * cut.batches >= bins * (batch + 1)) ++batch;
    cells[n].batch = batch;
    before += cells[n].rows;
  }
}

}  // namespace

std::string name_of(const PartTask& task) {
  static constexpr const char* kNames[] = {"map", "gather", "frame", "pick", "mesh", "verify"};
  const std::string name = kNames[static_cast<int>(task.stage)];
  const bool is_one = task.stage == PartStage::Gather || task.stage == PartStage::Mesh;
  return is_one ? name : name + " " + std::to_string(task.number);
}

PartKind kind_of(const Cut& cut, std::string name, std::size_t row_bytes) {
  return {cut.identity, std::move(name), row_bytes};
}

std::string path_of(const Cut& cut, std::string name) {
  std::replace(name.begin(), name.end(), ' ', '-');
  return cut.folder + "/" + name + ".part";
}

std::optional<PartFile> open_part(const Cut& cut, const PartTask& task) {
  static constexpr std::size_t kRowBytes[] = {
      sizeof(TotalRow), sizeof(TotalRow), sizeof(FrameRow), sizeof(PickRow), 1, sizeof(verify::PieceVerdict::Vertex)};
  const std::string name = name_of(task);
  return PartFile::open(path_of(cut, name), kind_of(cut, name, kRowBytes[static_cast<int>(task.stage)]));
}

Result<PartFile> need_part(const Cut& cut, const PartTask& task) {
  if (auto file = open_part(cut, task)) return *std::move(file);
  return fail(Code::IoFailed, "is not there or another run's; the task '" + name_of(task) + "' makes it",
              path_of(cut, name_of(task)));
}

std::vector<std::vector<PartTask>> waves_of(const Cut& cut, reduce::Representative representative) {
  std::vector<std::vector<PartTask>> waves(representative == reduce::Representative::Surface ? 4 : 3);
  for (std::uint32_t n = 0; n < cut.pieces; ++n) waves[0].push_back({PartStage::Map, n});
  waves[1].push_back({PartStage::Gather, 0});
  for (std::uint32_t n = 0; n < cut.batches; ++n) waves[2].push_back({PartStage::Frame, n});
  if (waves.size() > 3)
    for (std::uint32_t n = 0; n < cut.pieces; ++n) waves[3].push_back({PartStage::Pick, n});
  return waves;
}

std::vector<std::vector<PartTask>> scan_waves(const Cut& cut, reduce::Representative representative) {
  auto waves = waves_of(cut, representative);
  waves.push_back({{PartStage::Mesh, 0}});
  waves.emplace_back();
  for (std::uint32_t n = 0; n < cut.pieces; ++n) waves.back().push_back({PartStage::Verify, n});
  return waves;
}

bool is_done(const Cut& cut, const PartTask& task) { return open_part(cut, task).has_value(); }

CutReduction::CutReduction(const PointSource& points, const reduce::LatticeParams& lattice,
                           const reduce::Params& params, Cut cut)
    : points_(points), lattice_(lattice), params_(params), cut_(std::move(cut)) {}

Result<void> CutReduction::make(const PartTask& task, const Context& context) const {
  if (is_done(cut_, task)) return {};
  switch (task.stage) {
    case PartStage::Map:
      return map(task.number, context);
    case PartStage::Gather:
      return gather(context);
    case PartStage::Frame:
      return frame(task.number, context);
    case PartStage::Pick:
      return pick(task.number, context);
    default:
      break;
  }
  return fail(Code::Internal, "is no part of the reduction", name_of(task));
}

Result<void> CutReduction::map(std::uint32_t piece, const Context& context) const {
  TRY_ASSIGN(const LocalFrame frame, reduce::frame_of_parts(points_, lattice_, params_));
  reduce::ReadCounts counts;
  const PiecePoints points(points_, piece, cut_.pieces);
  TRY_ASSIGN(const BinTotals totals, reduce::bin_points(points, frame, counts, context));
  const std::string name = name_of({PartStage::Map, piece});
  TRY_ASSIGN(PartWriter writer, PartWriter::create(path_of(cut_, name), kind_of(cut_, name, sizeof(TotalRow))));
  std::vector<TotalRow> rows;
  for (std::size_t first = 0; first < totals.bins.size(); first += rows.size()) {
    rows.resize(std::min(kRowsAtOnce, totals.bins.size() - first));
    for (std::size_t n = 0; n < rows.size(); ++n)
      rows[n] = total_row(totals.bins[first + n], totals.cells[first + n], totals.cells.direction(first + n));
    TRY(writer.add_rows(std::span<const TotalRow>(rows)));
  }
  const CountsText text = counts_text(counts);
  return writer.commit({reinterpret_cast<const char*>(&text), sizeof text});
}

Result<void> CutReduction::gather(const Context& context) const {
  TRY_ASSIGN(const LocalFrame frame, reduce::frame_of_parts(points_, lattice_, params_));
  std::vector<PartFile> files;
  std::vector<PartWriter> links;
  reduce::ReadCounts counts;
  for (std::uint32_t piece = 0; piece < cut_.pieces; ++piece) {
    TRY_ASSIGN(PartFile file, need_part(cut_, {PartStage::Map, piece}));
    CountsText text;
    if (file.text().size() != sizeof text)
      return fail(Code::IoFailed, "holds no counts", path_of(cut_, name_of({PartStage::Map, piece})));
    std::memcpy(&text, file.text().data(), sizeof text);
    add_counts(counts, text);
    files.push_back(std::move(file));
    const std::string name = link_name(piece);
    TRY_ASSIGN(PartWriter link, PartWriter::create(path_of(cut_, name), kind_of(cut_, name, sizeof(std::uint64_t))));
    links.push_back(std::move(link));
  }
  if (counts.points_used == 0) return fail(Code::BadInput, "no finite point in any file of the scan; nothing to mesh");
  std::vector<RowStream<TotalRow>> streams(files.begin(), files.end());
  const auto later = [&](std::size_t a, std::size_t b) {  // rows at hand were read when the piece was pushed
    const LocalBin x = (*streams[a].get())->local(), y = (*streams[b].get())->local();
    return x == y ? a > b : stands_before(frame.base, y, x);
  };
  std::priority_queue<std::size_t, std::vector<std::size_t>, decltype(later)> next(later);
  for (std::size_t n = 0; n < streams.size(); ++n) {
    if (streams[n].at_end()) continue;
    TRY(streams[n].get());
    next.push(n);
  }
  const std::string name = name_of({PartStage::Gather, 0});
  TRY_ASSIGN(PartWriter writer, PartWriter::create(path_of(cut_, name), kind_of(cut_, name, sizeof(TotalRow))));
  std::vector<LocalBin> bins;
  reduce::BinCells sums;
  std::vector<Cell> cells;
  const std::uint32_t cell_bins = std::min(cut_.brick_bins, 32u);
  while (!next.empty()) {
    if (context.cancel.is_set()) return fail(Code::Cancelled, "stopped on request");
    TotalRow row = **streams[next.top()].get();
    const std::uint64_t at = bins.size();
    for (bool first = true; !next.empty(); first = false) {
      const std::size_t n = next.top();
      const TotalRow& other = **streams[n].get();
      if (other.local() != row.local()) break;
      if (!first) add_row(row, other);
      TRY(links[n].add_rows(std::span<const std::uint64_t>(&at, 1)));
      next.pop();
      streams[n].step();
      if (streams[n].at_end()) continue;
      TRY(streams[n].get());
      next.push(n);
    }
    const LocalBin low = low_of(row.local(), cell_bins);
    if (cells.empty() || cells.back().low != low) cells.push_back({low, 0, at, 0});
    ++cells.back().rows;
    bins.push_back(row.local());
    push_row(sums, row);
    TRY(writer.add_rows(std::span<const TotalRow>(&row, 1)));
  }
  TRY(reduce::check_numbers(bins.size(), 0, frame.lattice.edge_mm));
  share_out(cells, bins.size(), cut_);
  const reduce::Levels levels = reduce::levels_of_parts(frame, std::move(bins), sums, context);
  if (context.cancel.is_set()) return fail(Code::Cancelled, "stopped on request");
  for (PartWriter& link : links) TRY(link.commit());
  TotalsText text;
  text.counts = counts_text(counts);
  text.noise = levels.noise;
  text.frame_radius = levels.frame_radius;
  text.cell_bins = cell_bins;
  text.cells = cells.size();
  std::string bytes(reinterpret_cast<const char*>(&text), sizeof text);
  bytes.append(reinterpret_cast<const char*>(cells.data()), cells.size() * sizeof(Cell));
  return writer.commit(bytes);
}

namespace {

/// The totals of one brick and of the bins around it, in the order of keys; `own` counts the brick's.
struct BrickTotals {
  std::vector<TotalRow> rows;
  std::uint64_t first = 0, own = 0;  // of the brick's rows among all
};

class BrickReader {
 public:
  BrickReader(const Totals& totals, const BinKey& base, std::uint32_t brick_bins)
      : totals_(totals), base_(base), edge_(static_cast<std::int32_t>(brick_bins)) {}

  /// The brick whose first cell is at place `cell`; `end` becomes the place behind its last.
  Result<BrickTotals> read(std::size_t cell, std::size_t& end) const {
    const std::vector<Cell>& cells = totals_.cells;
    const LocalBin low = low_of(cells[cell].low, static_cast<std::uint32_t>(edge_));
    BrickTotals brick;
    brick.first = cells[cell].first;
    for (end = cell; end < cells.size() && low_of(cells[end].low, static_cast<std::uint32_t>(edge_)) == low; ++end)
      brick.own += cells[end].rows;
    TRY(append(brick.first, brick.own, brick.rows));
    const auto step = static_cast<std::int32_t>(totals_.text.cell_bins);
    LocalBin at;
    for (at[0] = low[0] - step; at[0] < low[0] + edge_ + step; at[0] += step)
      for (at[1] = low[1] - step; at[1] < low[1] + edge_ + step; at[1] += step)
        for (at[2] = low[2] - step; at[2] < low[2] + edge_ + step; at[2] += step) {
          if (low_of(at, static_cast<std::uint32_t>(edge_)) == low) continue;
          TRY(append_halo(at, low, brick.rows));
        }
    std::sort(brick.rows.begin(), brick.rows.end(),
              [&](const TotalRow& a, const TotalRow& b) { return stands_before(base_, a.local(), b.local()); });
    return brick;
  }
  static bool is_inside(const LocalBin& bin, const LocalBin& low, std::int32_t edge, std::int32_t halo) {
    for (std::size_t k = 0; k < 3; ++k)
      if (bin[k] < low[k] - halo || bin[k] >= low[k] + edge + halo) return false;
    return true;
  }

 private:
  Result<void> append(std::uint64_t first, std::uint64_t count, std::vector<TotalRow>& rows) const {
    const std::size_t old = rows.size();
    rows.resize(old + static_cast<std::size_t>(count));
    return totals_.file.read_rows(first, std::span(rows).subspan(old));
  }
  Result<void> append_halo(const LocalBin& at, const LocalBin& low, std::vector<TotalRow>& rows) const {
    const auto cell =
        std::lower_bound(totals_.cells.begin(), totals_.cells.end(), at,
                         [&](const Cell& c, const LocalBin& wanted) { return stands_before(base_, c.low, wanted); });
    if (cell == totals_.cells.end() || cell->low != at) return {};
    const std::size_t old = rows.size();
    TRY(append(cell->first, cell->rows, rows));
    std::erase_if(rows, [&, n = std::size_t{0}](const TotalRow& row) mutable {
      return n++ >= old && !is_inside(row.local(), low, edge_, reduce::kFrameHalo);
    });
    return {};
  }

  const Totals& totals_;
  BinKey base_;
  std::int32_t edge_;
};

}  // namespace

Result<void> CutReduction::frame(std::uint32_t batch, const Context& context) const {
  TRY_ASSIGN(const LocalFrame frame, reduce::frame_of_parts(points_, lattice_, params_));
  TRY_ASSIGN(const Totals totals, need_totals(cut_));
  const std::string name = name_of({PartStage::Frame, batch});
  TRY_ASSIGN(PartWriter writer, PartWriter::create(path_of(cut_, name), kind_of(cut_, name, sizeof(FrameRow))));
  const BrickReader reader(totals, frame.base, cut_.brick_bins);
  for (std::size_t cell = 0, end = 0; cell < totals.cells.size(); cell = end) {
    if (totals.cells[cell].batch != batch) {
      end = cell + 1;
      continue;
    }
    TRY_ASSIGN(const BrickTotals brick, reader.read(cell, end));
    const LocalBin low = low_of(totals.cells[cell].low, cut_.brick_bins);
    std::vector<LocalBin> bins(brick.rows.size());
    reduce::BinCells sums;
    for (std::size_t n = 0; n < bins.size(); ++n) {
      bins[n] = brick.rows[n].local();
      push_row(sums, brick.rows[n]);
    }
    const Frames frames = reduce::frames_of_parts(frame, bins, sums, totals.text.frame_radius, context);
    if (context.cancel.is_set()) return fail(Code::Cancelled, "stopped on request");
    std::vector<FrameRow> rows;
    for (std::size_t n = 0; n < bins.size(); ++n)
      if (BrickReader::is_inside(bins[n], low, static_cast<std::int32_t>(cut_.brick_bins), 0))
        rows.push_back(frame_row(frames, n));
    TRY(writer.add_rows(std::span<const FrameRow>(rows)));
  }
  return writer.commit();
}

namespace {

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

/// All frames, or those at `rows` (ascending).
Result<Frames> read_frames(FrameReader& reader, std::uint64_t count, const std::vector<std::uint64_t>* rows) {
  Frames frames;
  frames.resize(static_cast<std::size_t>(count));
  for (std::size_t n = 0; n < count; ++n) {
    TRY_ASSIGN(const FrameRow* row, reader.get(rows ? (*rows)[n] : n));
    set_frame(frames, n, *row);
  }
  return frames;
}

}  // namespace

Result<void> CutReduction::pick(std::uint32_t piece, const Context& context) const {
  TRY_ASSIGN(const LocalFrame frame, reduce::frame_of_parts(points_, lattice_, params_));
  TRY_ASSIGN(const Totals totals, need_totals(cut_));
  TRY_ASSIGN(const PartFile map, need_part(cut_, {PartStage::Map, piece}));
  TRY_ASSIGN(const PartFile link, need_link(cut_, piece));
  TRY_ASSIGN(FrameReader reader, FrameReader::open(cut_, totals));
  const std::string name = name_of({PartStage::Pick, piece});
  TRY_ASSIGN(PartWriter writer, PartWriter::create(path_of(cut_, name), kind_of(cut_, name, sizeof(PickRow))));
  double median = 0;
  if (params_.edge_aware) {
    TRY_ASSIGN(const Frames all, read_frames(reader, totals.file.rows(), nullptr));
    median = reduce::median_residual_of(all);
  }
  std::vector<LocalBin> bins;
  bins.reserve(static_cast<std::size_t>(map.rows()));
  for (RowStream<TotalRow> rows(map); !rows.at_end(); rows.step()) {
    TRY_ASSIGN(const TotalRow* row, rows.get());
    bins.push_back(row->local());
  }
  std::vector<std::uint64_t> at(static_cast<std::size_t>(link.rows()));
  TRY(link.read_rows(0, std::span<std::uint64_t>(at)));
  if (at.size() != bins.size())
    return fail(Code::IoFailed, "holds other bins than the piece", path_of(cut_, link_name(piece)));
  TRY_ASSIGN(const Frames frames, read_frames(reader, at.size(), &at));
  const auto targets = reduce::targets_of(frame, bins, frames, median, params_);
  const BinIndex index = BinIndex::over(bins);
  const PiecePoints points(points_, piece, cut_.pieces);
  TRY_ASSIGN(const std::vector<Winner> winners, reduce::pick_against(points, frame, index, targets, context));
  std::vector<PickRow> rows;
  for (std::size_t first = 0; first < winners.size(); first += rows.size()) {
    rows.resize(std::min(kRowsAtOnce, winners.size() - first));
    for (std::size_t n = 0; n < rows.size(); ++n) rows[n] = pick_row(winners[first + n]);
    TRY(writer.add_rows(std::span<const PickRow>(rows)));
  }
  return writer.commit();
}

Result<BrickCounts> CutReduction::bricks() const {
  TRY_ASSIGN(const Totals totals, need_totals(cut_));
  BrickCounts counts;
  std::uint64_t bins = 0;
  for (std::size_t n = 0; n < totals.cells.size(); ++n) {
    const bool begins =
        n == 0 || low_of(totals.cells[n].low, cut_.brick_bins) != low_of(totals.cells[n - 1].low, cut_.brick_bins);
    if (begins) bins = 0;
    counts.bricks += begins;
    bins += totals.cells[n].rows;
    counts.bins += totals.cells[n].rows;
    counts.most_bins = std::max(counts.most_bins, bins);
  }
  return counts;
}

Result<reduce::Reduction> CutReduction::join(const Context& context) const {
  TRY_ASSIGN(const LocalFrame frame, reduce::frame_of_parts(points_, lattice_, params_));
  TRY_ASSIGN(const Totals totals, need_totals(cut_));
  TRY_ASSIGN(FrameReader reader, FrameReader::open(cut_, totals));
  const std::uint64_t count = totals.file.rows();
  BinTotals all;
  all.bins.reserve(count);
  all.cells.at.reserve(count);
  for (RowStream<TotalRow> rows(totals.file); !rows.at_end(); rows.step()) {
    TRY_ASSIGN(const TotalRow* row, rows.get());
    reduce::Cell cell;
    cell.sums.count = static_cast<double>(row->moments[0]);
    if (params_.representative == reduce::Representative::Centre) cell.keep_better(winner_of(*row));
    all.bins.push_back(row->local());
    all.cells.push_back(cell, {});
  }
  if (params_.representative == reduce::Representative::Surface)
    for (std::uint32_t piece = 0; piece < cut_.pieces; ++piece) {
      TRY_ASSIGN(const PartFile picks, need_part(cut_, {PartStage::Pick, piece}));
      TRY_ASSIGN(const PartFile link, need_link(cut_, piece));
      RowStream<PickRow> rows(picks);
      RowStream<std::uint64_t> at(link);
      for (; !rows.at_end() && !at.at_end(); rows.step(), at.step()) {
        TRY_ASSIGN(const PickRow* row, rows.get());
        TRY_ASSIGN(const std::uint64_t* place, at.get());
        all.cells[*place].keep_better(winner_of(*row));
      }
    }
  TRY_ASSIGN(Frames frames, read_frames(reader, count, nullptr));
  reduce::ReadCounts counts;
  add_counts(counts, totals.text.counts);
  const reduce::Levels levels{totals.text.noise, totals.text.frame_radius};
  return reduce::join_parts(frame, std::move(all), std::move(frames), counts, levels, params_, context);
}

}  // namespace scanmill::pipeline
