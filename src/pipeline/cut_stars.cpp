// SPDX-License-Identifier: Apache-2.0
#include "pipeline/cut_stars.hpp"

#include "pipeline/brick_rows.hpp"
#include "pipeline/part_lists.hpp"
#include "pipeline/point_parts.hpp"
#include "pipeline/surface.hpp"

namespace scanmill::pipeline {
namespace {

/// A brick's own points and those around it that its stars look at.
struct StarPart {
  reduce::ReducedCloud cloud;
  std::vector<stars::Role> roles;
  std::vector<std::uint32_t> rows;  // their places among all
};

Result<StarPart> read_part(const PointParts& points, const PartFile& settled, const Totals& totals, const Brick& brick,
                           std::uint32_t brick_bins) {
  StarPart part{empty_cloud(points.text), {}, {}};
  const auto runs = runs_around(totals, part.cloud.base, brick, brick_bins, stars::kStarHalo);
  TRY_ASSIGN(const auto around, read_runs<PointRow>(points.file, runs));
  TRY_ASSIGN(const auto drops, read_runs<reduce::Drop>(settled, runs));
  std::size_t at = 0;
  for (const Run& run : runs)
    for (std::uint64_t row = run.first; row < run.first + run.rows; ++row, ++at) {
      const LocalBin bin = around[at].local();
      if (!is_inside(bin, brick.low, brick_bins, stars::kStarHalo)) continue;
      push_point(part.cloud, around[at]);
      part.cloud.drop.back() = drops[at];
      part.roles.push_back(is_inside(bin, brick.low, brick_bins, 0)                   ? stars::Role::Own
                           : is_inside(bin, brick.low, brick_bins, stars::kStarReach) ? stars::Role::Near
                                                                                      : stars::Role::Around);
      part.rows.push_back(static_cast<std::uint32_t>(row));
    }
  part.cloud.index = BinIndex::over(part.cloud.bins);
  return part;
}

void renumber(Triangle& t, const std::vector<std::uint32_t>& rows) {
  for (std::uint32_t& corner : t) corner = rows[corner];
}

/// Adds a brick's to those of its batch.
void append(stars::Ballot& all, stars::Ballot&& brick, const std::vector<std::uint32_t>& rows) {
  for (stars::Agreed& t : brick.agreed) renumber(t.corners, rows);
  for (stars::Candidate& t : brick.candidates) renumber(t.corners, rows);
  for (auto& link : brick.links) link = {rows[link[0]], rows[link[1]]};
  all.agreed.insert(all.agreed.end(), brick.agreed.begin(), brick.agreed.end());
  all.candidates.insert(all.candidates.end(), brick.candidates.begin(), brick.candidates.end());
  all.links.insert(all.links.end(), brick.links.begin(), brick.links.end());
  all.refused.range += brick.refused.range;
  all.refused.angle += brick.refused.angle;
}

template <class Store, class Ballot>
void store_ballot(Store& store, Ballot& ballot) {
  store(ballot.agreed, ballot.candidates, ballot.links, ballot.refused);
}

}  // namespace

Result<void> star_batch(const Cut& cut, std::uint32_t batch, const What& what, const Context& context) {
  const PartTask task{PartStage::Stars, batch};
  if (is_done(cut, task)) return {};
  TRY_ASSIGN(const Totals totals, need_totals(cut));
  TRY_ASSIGN(const PointParts points, need_points(cut));
  TRY_ASSIGN(const PartFile settled, need_part(cut, {PartStage::Settle, 0}));
  reduce::ReadCounts counts;
  add_counts(counts, totals.text.counts);
  const Vec3 offset = float32_offset(counts.bounds, points.text.edge_mm);
  stars::Ballot all;
  for (const Brick& brick : bricks_of(totals, cut.brick_bins)) {
    if (brick.batch != batch) continue;
    TRY_ASSIGN(const StarPart part, read_part(points, settled, totals, brick, cut.brick_bins));
    const WrittenPoints written = written_points(part.cloud, offset);
    TRY_ASSIGN(stars::Ballot ballot,
               stars::ballot_of(surface_points(part.cloud, written), part.roles, star_params(what), context));
    append(all, std::move(ballot), part.rows);
  }
  TRY_ASSIGN(PartWriter writer, create_part(cut, task));
  Keeper keeper(writer);
  store_ballot(keeper, all);
  TRY(std::move(keeper.state));
  return writer.commit();
}

Result<std::vector<stars::Ballot>> read_ballots(const Cut& cut) {
  std::vector<stars::Ballot> ballots(cut.batches);
  for (std::uint32_t batch = 0; batch < cut.batches; ++batch) {
    TRY_ASSIGN(const PartFile file, need_part(cut, {PartStage::Stars, batch}));
    Taker taker(file);
    store_ballot(taker, ballots[batch]);
    TRY(std::move(taker.state));
  }
  return ballots;
}

}  // namespace scanmill::pipeline
