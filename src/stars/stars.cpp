// SPDX-License-Identifier: Apache-2.0
// The paper grows patches by joining the next nearest point to a front; taken literally that leaves hundreds of open
// and non-manifold edges. Its first optimisation pass drives any start mesh towards the local Delaunay triangulation,
// so we compute that fixed point directly, point by point, and complete the few places where neighbours disagree.
#include "stars/stars.hpp"

#include <algorithm>

#include "stars/complete.hpp"
#include "stars/parts.hpp"

namespace scanmill::stars {

namespace {

Result<void> check(const Params& params) {
  if (params.range_bins > 0 && params.range_bins <= 2.5 && params.min_angle_deg >= 0 && params.min_angle_deg <= 45)
    return {};
  return fail(Code::BadParameter, "range_bins must be in (0, 2.5] and min_angle_deg in [0, 45]");
}

/// From the vote to the finished surface. `report` holds what was counted before.
Result<Surface> complete_vote(const SurfacePoints& points, const Params& params, Vote vote, const Report& counted,
                              const Context& context, Progress& progress) {
  Surface surface;
  Report& report = surface.report = counted;
  for (const std::uint8_t kept : points.kept) report.kept += kept != 0;
  Site site(points, params, std::move(vote.normal));
  site.complex.reserve(vote.confirmed.size() + vote.confirmed.size() / 16);
  for (const Triangle& t : vote.confirmed) {
    if (site.complex.edges_free(t))
      site.complex.add(t, 3);
    else
      vote.candidates.insert(vote.candidates.begin(), {t, 3, 0});
  }
  report.confirmed = site.complex.triangle_count();
  report.candidates = vote.candidates.size();
  complete(site, vote.candidates, report, context, progress);
  if (context.cancel.is_set()) return fail(Code::Cancelled, "stopped on request");
  report.open_edges = static_cast<std::uint64_t>(site.complex.open_edges());
  report.unused_points = static_cast<std::uint64_t>(site.complex.unused());
  surface.triangles.reserve(site.complex.triangle_count());
  for (std::uint32_t t = 0; t < site.complex.triangle_count(); ++t)
    if (site.complex.alive(t)) surface.triangles.push_back(site.complex.triangle(t));
  // Confirmed ones were added in order, and most triangles are.
  const auto rest = std::is_sorted_until(surface.triangles.begin(), surface.triangles.end());
  std::sort(rest, surface.triangles.end());
  std::inplace_merge(surface.triangles.begin(), rest, surface.triangles.end());
  surface.normal = std::move(site.normal);
  surface.sign_known = std::move(vote.sign_known);
  return surface;
}

}  // namespace

Result<Surface> mesh_points(const SurfacePoints& points, const Params& params, const Context& context,
                            Progress& progress) {
  TRY(check(params));
  progress.stage("stars", 0, 0);
  Report report;
  Vote vote;
  {
    const std::vector<Star> stars = stars_of(points, {}, params, report.refused, context);
    if (context.cancel.is_set()) return fail(Code::Cancelled, "stopped on request");
    const auto ballots = ballots_of(points, stars, {}, cos_of_degrees(params.min_angle_deg), context);
    for (const Ballot& ballot : ballots) report.refused.angle += ballot.refused.angle;
    vote = count_votes(points, ballots, &stars);
  }
  if (context.cancel.is_set()) return fail(Code::Cancelled, "stopped on request");
  return complete_vote(points, params, std::move(vote), report, context, progress);
}

Result<Ballot> ballot_of(const SurfacePoints& points, std::span<const Role> roles, const Params& params,
                         const Context& context) {
  TRY(check(params));
  Ballot all;
  const std::vector<Star> stars = stars_of(points, roles, params, all.refused, context);
  if (context.cancel.is_set()) return fail(Code::Cancelled, "stopped on request");
  const auto ballots = ballots_of(points, stars, roles, cos_of_degrees(params.min_angle_deg), context);
  all.links = links_of(stars, roles, ballots);
  for (const Ballot& ballot : ballots) {
    all.agreed.insert(all.agreed.end(), ballot.agreed.begin(), ballot.agreed.end());
    all.candidates.insert(all.candidates.end(), ballot.candidates.begin(), ballot.candidates.end());
    all.refused.angle += ballot.refused.angle;
  }
  return all;
}

Result<Surface> mesh_ballots(const SurfacePoints& points, std::vector<Ballot> ballots, const Params& params,
                             const Context& context, Progress& progress) {
  TRY(check(params));
  Report report;
  for (const Ballot& ballot : ballots) {
    report.refused.range += ballot.refused.range;
    report.refused.angle += ballot.refused.angle;
  }
  Vote vote = count_votes(points, ballots, nullptr);
  ballots = {};
  return complete_vote(points, params, std::move(vote), report, context, progress);
}

}  // namespace scanmill::stars
