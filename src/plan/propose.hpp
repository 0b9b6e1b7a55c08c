// SPDX-License-Identifier: Apache-2.0
// Stations from which a sensor sees all of an object it can see, few and near each other.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "mesh/mesh.hpp"
#include "plan/plan.hpp"

namespace scanmill::plan {

/// A place of the surface to be seen: the mean of the samples of one bin that face about the same way, so that both
/// sides of a thin wall count.
struct Facet {
  Vec3 point, normal;
};

struct Surface {
  double bin_mm = 1;
  std::vector<Facet> facets;  // in the order of their bins
  std::vector<Vec3> samples;  // of the whole surface, half a bin apart: what stands in the way
};

/// Samples every triangle of a mesh whose faces turn outward.
/// errors  BadInput for a mesh without area; BadParameter when the bins would be more than 20 million samples
Result<Surface> surface_of(const Mesh& mesh, double bin_mm);
/// The six sides of a box as a mesh.
Mesh mesh_of_box(const Box& box);

/// Numbers of the facets that a view sees: in field and depth band, not steeper than the cosine says, and with nothing
/// nearer on the ray (a depth buffer of the samples; a facet less than two bins behind them is not hidden).
std::vector<std::uint32_t> facets_seen(const Surface& surface, const Sensor& sensor, const Pose& view,
                                       double min_cosine);

struct ProposeParams {
  double max_angle_deg = 60;  // a facet seen at a steeper angle does not count; the sensor's own limit holds as well
  double coverage = 0.995;    // of the visible facets
  std::size_t max_stations = 500;
};

struct Proposal {
  std::vector<Station> stations;  // in the order of the way, with joints and counts where the machine has joints
  std::uint64_t facets = 0;       // of the object
  std::uint64_t visible = 0;      // from some place the machine can take
  std::uint64_t covered = 0;      // by the stations
  std::uint64_t candidates = 0;   // places looked at that the machine can take
};

/// Candidates look at places spread over the surface, along the normal and from directions around it; those that the
/// machine cannot take (at least nearly) or where the head would meet a body are left out; machines of up to four
/// joints are tried all over their range as well. Greedy cover: the candidate that adds most (ties: the first), until
/// `coverage` of what is visible is seen; stations that others make superfluous go. Order: nearest neighbour from home,
/// improved by reversing pieces (2-opt), by the time of the moves; where the straight way meets a body, the head is
/// drawn back along a linear joint first (stations marked via). errors  BadInput when no place is left from which
/// anything is seen; Cancelled cost    about 0.5 ms per candidate and 50,000 samples
Result<Proposal> propose(const ScanPlan& rig, const Surface& surface, const ProposeParams& params,
                         const Context& context);

}  // namespace scanmill::plan
