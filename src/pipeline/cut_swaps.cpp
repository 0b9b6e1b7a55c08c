// SPDX-License-Identifier: Apache-2.0
#include "pipeline/cut_swaps.hpp"

#include <algorithm>
#include <span>
#include <utility>

#include "optimise/parts.hpp"
#include "pipeline/brick_rows.hpp"
#include "pipeline/judge_scan.hpp"
#include "pipeline/point_parts.hpp"
#include "pipeline/surface_lists.hpp"

namespace scanmill::pipeline {
namespace {

/// Bins around a brick whose mesh is swapped with it. Its decisions hang on what is within 11.5 bins (edges of at most
/// 2.5); what goes wrong at the rim came 5 bins far in tests.
constexpr std::int32_t kSwapHalo = 24;

/// What `mesh` leaves, to be read brick by brick.
struct MeshLists {
  ListView<LocalBin> bins;  // of the vertices
  double bin_mm = 0;
  ListView<Vec3> positions;
  ListView<Triangle> triangles;
  ListView<std::uint32_t> patch;
  ListView<std::uint32_t> vertex_row;

  static Result<MeshLists> open(const PartFile& file) {
    std::uint64_t at = 0;
    TRY_ASSIGN(auto bins, ListView<LocalBin>::open(file, at));
    double bin_mm = 0;
    TRY(take_value(file, at, bin_mm));
    TRY_ASSIGN(auto positions, ListView<Vec3>::open(file, at));
    TRY_ASSIGN(auto triangles, ListView<Triangle>::open(file, at));
    TRY_ASSIGN(auto patch, ListView<std::uint32_t>::open(file, at));
    Vec3 offset;
    TRY(take_value(file, at, offset));
    TRY_ASSIGN(auto vertex_row, ListView<std::uint32_t>::open(file, at));
    return MeshLists{bins, bin_mm, positions, triangles, patch, vertex_row};
  }

 private:
  template <class T>
  static Result<void> take_value(const PartFile& file, std::uint64_t& at, T& value) {
    Taker taker(file, at);
    taker(value);
    at = taker.at();
    return std::move(taker.state);
  }
};

/// Bricks one after the other whose edges are swapped together: small ones have more around them than in them.
struct Group {
  std::span<const Brick> bricks;
  std::uint64_t first = 0, last = 0;  // their rows
};
constexpr std::uint64_t kGroupRows = 1 << 17;

std::vector<Group> groups_of(std::span<const Brick> bricks) {
  std::vector<Group> groups;
  for (std::size_t n = 0; n < bricks.size(); ++n) {
    const Brick& brick = bricks[n];
    const std::uint64_t last = brick.first + brick.rows;
    const bool is_more =
        !groups.empty() && groups.back().bricks.back().batch == brick.batch && last - groups.back().first <= kGroupRows;
    if (!is_more) groups.push_back({bricks.subspan(n, 0), brick.first, 0});
    groups.back().bricks = {groups.back().bricks.data(), groups.back().bricks.size() + 1};
    groups.back().last = last;
  }
  return groups;
}

/// The cells around all of them, ascending, each once.
std::vector<Run> runs_around(const Totals& totals, const BinKey& base, const Group& group, std::uint32_t brick_bins) {
  std::vector<Run> runs{{group.first, group.last - group.first}};
  for (const Brick& brick : group.bricks)
    for (const Run& run : runs_around(totals, base, brick, brick_bins, kSwapHalo))
      if (run.first < group.first || run.first >= group.last) runs.push_back(run);
  std::sort(runs.begin(), runs.end(), [](const Run& a, const Run& b) { return a.first < b.first; });
  const auto same = [](const Run& a, const Run& b) { return a.first == b.first; };
  runs.erase(std::unique(runs.begin(), runs.end(), same), runs.end());
  return runs;
}

/// Vertices and triangles lie in the order of rows, so a run of rows is a run of both.
Result<optimise::Part> read_part(const MeshLists& mesh, const Totals& totals, const BinKey& base, const Group& group,
                                 std::uint32_t brick_bins) {
  optimise::Part part;
  part.reach_mm = kSwapHalo * mesh.bin_mm;
  part.block_mm = optimise::kBlockBins * mesh.bin_mm;
  std::vector<Triangle> triangles;
  std::vector<std::uint32_t> patch;
  std::vector<LocalBin> bins;
  std::vector<Vec3> positions;
  LocalBin low = group.bricks.front().low, high = low;
  for (const Brick& brick : group.bricks)
    for (std::size_t k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], brick.low[k] - kSwapHalo);
      high[k] = std::max(high[k], brick.low[k] + static_cast<std::int32_t>(brick_bins) + kSwapHalo);
    }
  auto is_near = [&](const LocalBin& bin) {
    for (std::size_t k = 0; k < 3; ++k)
      if (bin[k] < low[k] || bin[k] >= high[k]) return false;
    return true;
  };
  for (const Run& run : runs_around(totals, base, group, brick_bins)) {
    auto first_from = [&](std::uint64_t row) {
      return mesh.vertex_row.first_not([&](std::uint32_t at) { return at < row; });
    };
    auto first_at = [&](std::uint64_t vertex) {
      return mesh.triangles.first_not([&](const Triangle& t) { return t[0] < vertex; });
    };
    TRY_ASSIGN(const std::uint64_t begin, first_from(run.first));
    TRY_ASSIGN(const std::uint64_t end, first_from(run.first + run.rows));
    bins.clear();
    positions.clear();
    TRY(mesh.bins.read(begin, end, bins));
    TRY(mesh.positions.read(begin, end, positions));
    for (std::size_t n = 0; n < bins.size(); ++n) {
      if (!is_near(bins[n])) continue;
      part.vertex.push_back(static_cast<std::uint32_t>(begin + n));
      part.mesh.positions.push_back(positions[n]);
      part.own.push_back(run.first == group.first);
      optimise::Block block;
      for (std::size_t k = 0; k < 3; ++k) block[k] = bins[n][k] >> 2;
      part.block.push_back(block);
    }
    TRY_ASSIGN(const std::uint64_t first, first_at(begin));
    TRY_ASSIGN(const std::uint64_t last, first_at(end));
    TRY(mesh.triangles.read(first, last, triangles));
    TRY(mesh.patch.read(first, last, patch));
  }
  for (std::size_t n = 0; n < triangles.size(); ++n) {
    Triangle here{};
    bool is_whole = true;
    for (std::size_t k = 0; k < 3 && is_whole; ++k) {
      const auto at = std::lower_bound(part.vertex.begin(), part.vertex.end(), triangles[n][k]);
      is_whole = at != part.vertex.end() && *at == triangles[n][k];
      here[k] = static_cast<std::uint32_t>(at - part.vertex.begin());
    }
    if (!is_whole) continue;
    part.mesh.triangles.push_back(here);
    part.mesh.patch.push_back(patch[n]);
  }
  return part;
}
static_assert(optimise::kBlockBins == 1 << 2);

template <class Store, class Swapped>
void store_swapped(Store& store, Swapped& part) {
  store(part.triangles, part.patch, part.between, part.rounds, part.events, part.own, part.watched, part.tally);
}

struct JoinedSwaps {
  std::vector<Triangle> triangles;
  std::vector<std::uint32_t> patch;
  optimise::PartReports reports;
  std::vector<optimise::Account> accounts;
};

/// Groups follow one another as their rows do, and so do their triangles.
Result<JoinedSwaps> read_swaps(const Cut& cut) {
  TRY_ASSIGN(const Totals totals, need_totals(cut));
  JoinedSwaps all;
  std::optional<PartFile> file;
  std::uint32_t batch = 0;
  std::uint64_t at = 0;
  const std::vector<Brick> bricks = bricks_of(totals, cut.brick_bins);
  for (const Group& group : groups_of(bricks)) {
    if (!file || group.bricks.front().batch != batch) {
      batch = group.bricks.front().batch;
      TRY_ASSIGN(file, need_part(cut, {PartStage::Swap, batch}));
      at = 0;
    }
    optimise::SwappedPart part;
    Taker taker(*file, at);
    store_swapped(taker, part);
    TRY(std::move(taker.state));
    at = taker.at();
    all.triangles.insert(all.triangles.end(), part.triangles.begin(), part.triangles.end());
    all.patch.insert(all.patch.end(), part.patch.begin(), part.patch.end());
    all.reports.add(part.tally, part.rounds, part.between);
    all.accounts.push_back({std::move(part.events), std::move(part.own), std::move(part.watched), part.tally.turns,
                            part.tally.is_sure != 0});
  }
  return all;
}

}  // namespace

Result<void> write_mesh(const Cut& cut, const MeshedSurface& surface, const std::vector<LocalBin>& bins,
                        double bin_mm) {
  TRY_ASSIGN(PartWriter writer, create_part(cut, kMeshTask));
  std::vector<LocalBin> of_vertices;
  of_vertices.reserve(surface.vertex_row.size());
  for (const std::uint32_t row : surface.vertex_row) of_vertices.push_back(bins[row]);
  Keeper keeper(writer);
  keeper(of_vertices, bin_mm);
  store_judged(keeper, surface);
  store_rest(keeper, surface);
  TRY(std::move(keeper.state));
  return writer.commit();
}

Result<void> swap_batch(const Cut& cut, std::uint32_t batch, const What& what, const Context& context) {
  const PartTask task{PartStage::Swap, batch};
  if (is_done(cut, task)) return {};
  TRY_ASSIGN(const Totals totals, need_totals(cut));
  TRY_ASSIGN(const PointParts points, need_points(cut));
  const BinKey base = empty_cloud(points.text).base;
  TRY_ASSIGN(const PartFile file, need_part(cut, kMeshTask));
  TRY_ASSIGN(const MeshLists mesh, MeshLists::open(file));
  TRY_ASSIGN(PartWriter writer, create_part(cut, task));
  Keeper keeper(writer);
  const std::vector<Brick> bricks = bricks_of(totals, cut.brick_bins);
  for (const Group& group : groups_of(bricks)) {
    if (group.bricks.front().batch != batch) continue;
    TRY_ASSIGN(const optimise::Part part, read_part(mesh, totals, base, group, cut.brick_bins));
    TRY_ASSIGN(const optimise::SwappedPart swapped,
               optimise::optimise_part(part, what.optimise, swap_limits(what, mesh.bin_mm), context));
    store_swapped(keeper, swapped);
    TRY(std::move(keeper.state));
  }
  return writer.commit();
}

Result<void> join_swaps(const Cut& cut, const What& what, const Context& context, Progress& progress) {
  if (is_done(cut, kJoinTask)) return {};
  TRY_ASSIGN(JoinedSwaps swaps, read_swaps(cut));
  TRY_ASSIGN(const PartFile file, need_part(cut, kMeshTask));
  MeshedSurface surface;
  std::vector<LocalBin> bins;
  double bin_mm = 0;
  Taker taker(file);
  taker(bins, bin_mm);
  store_judged(taker, surface);
  store_rest(taker, surface);
  TRY(std::move(taker.state));
  optimise::Report report;
  if (optimise::agree(swaps.accounts) && swaps.triangles.size() == surface.mesh.triangles.size()) {
    swaps.triangles.swap(surface.mesh.triangles);
    surface.mesh.patch = std::move(swaps.patch);
    report = swaps.reports.report(swaps.triangles, surface.mesh, what.optimise, swap_limits(what, bin_mm), context);
    if (context.cancel.is_set()) return fail(Code::Cancelled, "cancelled while joining swapped edges");
    measure_again(surface);
  } else {
    TRY_ASSIGN(report, optimise_surface(surface, what, bin_mm, context, progress));
  }
  TRY_ASSIGN(PartWriter writer, create_part(cut, kJoinTask));
  Keeper keeper(writer);
  store_judged(keeper, surface);
  store_rest(keeper, surface);
  keeper(report);
  TRY(std::move(keeper.state));
  return writer.commit();
}

}  // namespace scanmill::pipeline
