// SPDX-License-Identifier: Apache-2.0
#include "plan/propose.hpp"

#include <algorithm>
#include <cmath>

#include "base/text.hpp"
#include "geom/angles.hpp"
#include "lattice/lattice.hpp"
#include "plan/motion.hpp"
#include "plan/order.hpp"
#include "plan/solve.hpp"

namespace scanmill::plan {
namespace {

constexpr double kWidestTilt = 0.64;  // cosine of 50 degrees: how far a view may lean off the normal of its target

struct Candidate {
  Pose view;
  std::vector<double> joints;
  std::vector<std::uint32_t> seen;
};

/// The eight corners, twelve edges and six faces of a cube, as directions.
std::vector<Vec3> directions() {
  std::vector<Vec3> list;
  for (int x = -1; x <= 1; ++x)
    for (int y = -1; y <= 1; ++y)
      for (int z = -1; z <= 1; ++z)
        if (x != 0 || y != 0 || z != 0)
          list.push_back(unit({static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)}));
  return list;
}

/// One facet per coarse cell and side: the one nearest the mean of its cell.
std::vector<Facet> targets_of(const Surface& surface, double cell_mm) {
  struct Row {
    BinKey cell;
    int side;
    std::uint32_t facet;
  };
  const Lattice lattice{cell_mm, {0.37 * cell_mm, 0.41 * cell_mm, 0.43 * cell_mm}};
  std::vector<Row> rows;
  for (std::size_t f = 0; f < surface.facets.size(); ++f) {
    const Vec3 n = surface.facets[f].normal;
    const double x = std::abs(n.x), y = std::abs(n.y), z = std::abs(n.z);
    const int side = x >= y && x >= z ? (n.x > 0 ? 0 : 1) : y >= z ? (n.y > 0 ? 2 : 3) : (n.z > 0 ? 4 : 5);
    rows.push_back({bin_of(lattice, surface.facets[f].point), side, static_cast<std::uint32_t>(f)});
  }
  std::sort(rows.begin(), rows.end(), [](const Row& a, const Row& b) {
    if (!(a.cell == b.cell)) return before(a.cell, b.cell);
    return a.side != b.side ? a.side < b.side : a.facet < b.facet;
  });
  std::vector<Facet> targets;
  for (std::size_t first = 0; first < rows.size();) {
    std::size_t end = first;
    Vec3 mean, normal;
    for (; end < rows.size() && rows[end].cell == rows[first].cell && rows[end].side == rows[first].side; ++end) {
      mean += surface.facets[rows[end].facet].point;
      normal += surface.facets[rows[end].facet].normal;
    }
    mean = mean * (1 / static_cast<double>(end - first));
    std::size_t best = first;
    for (std::size_t k = first; k < end; ++k)
      if (norm2(surface.facets[rows[k].facet].point - mean) < norm2(surface.facets[rows[best].facet].point - mean))
        best = k;
    targets.push_back({surface.facets[rows[best].facet].point, unit(normal)});
    first = end;
  }
  return targets;
}

/// Joints rounded to counts; false where the machine may not stand like that.
bool take_joints(const ScanPlan& rig, std::vector<double> joints, Candidate& candidate) {
  ScanPlan one = rig;
  one.stations.assign(1, Station{});
  one.stations.front().joints = std::move(joints);
  const State state = settle(one).front();
  for (const Finding& finding : state.findings)
    if (finding.severity == Severity::Error) return false;
  candidate.joints = state.joints;
  candidate.view = state.at.view;
  return true;
}

/// Where the machine can go; without joints everywhere. A machine of few joints hardly ever reaches a place exactly:
/// the nearest one it can take is as good, what it sees is looked at there.
bool take_place(const ScanPlan& rig, std::span<const double> home, Candidate& candidate) {
  if (!rig.machine || rig.machine->joints.empty()) return true;
  const Solution found = solve(*rig.machine, rig.mount, rig.sensor.stand_off_mm, {candidate.view, false}, home);
  if (found.reach == Reach::OutsideLimits) return false;
  return take_joints(rig, found.joints, candidate);
}

/// All settings of a machine of up to four joints, 15 degrees or a third of the field apart, at most 4,000.
std::vector<std::vector<double>> grid_of(const ScanPlan& rig) {
  constexpr std::size_t kMostPlaces = 4000;
  const std::vector<Joint>& joints = rig.machine->joints;
  std::vector<std::vector<double>> grid;
  if (joints.empty() || joints.size() > 4) return grid;
  const double field = std::min(rig.sensor.field_x_mm, rig.sensor.field_y_mm);
  std::vector<std::size_t> steps;
  std::vector<double> low, pitch;
  for (const Joint& joint : joints) {
    const bool rotary = joint.type == JointType::Rotary, round = rotary && !joint.low;
    const double range = joint.low ? *joint.high - *joint.low : rotary ? 360 : 0;
    const double wanted = std::ceil(range / (rotary ? 15 : field / 3));
    steps.push_back(std::max<std::size_t>(1, static_cast<std::size_t>(std::min(wanted, 100.0)) + (round ? 0 : 1)));
    low.push_back(joint.low ? *joint.low : joint.home);
    pitch.push_back(range);
  }
  const auto places = [&] {
    std::size_t product = 1;
    for (const std::size_t n : steps) product *= n;
    return product;
  };
  while (places() > kMostPlaces) {
    std::size_t& most = *std::max_element(steps.begin(), steps.end());
    most = most * 3 / 4;
  }
  for (std::size_t n = 0; n < places(); ++n) {
    std::vector<double> q;
    std::size_t rest = n;
    for (std::size_t i = 0; i < joints.size(); ++i) {
      const bool round = joints[i].type == JointType::Rotary && !joints[i].low;
      const double parts = static_cast<double>(round ? steps[i] : std::max<std::size_t>(steps[i] - 1, 1));
      q.push_back(low[i] + pitch[i] * static_cast<double>(rest % steps[i]) / parts);
      rest /= steps[i];
    }
    grid.push_back(std::move(q));
  }
  return grid;
}

std::vector<Candidate> candidates_of(const ScanPlan& rig, const Surface& surface, double min_cosine,
                                     const Context& context) {
  const Sensor& sensor = rig.sensor;
  const std::vector<Facet> targets =
      targets_of(surface, std::max(std::min(sensor.field_x_mm, sensor.field_y_mm) * 0.3, 2 * surface.bin_mm));
  std::vector<Candidate> all;
  for (const Facet& target : targets) {
    std::vector<Vec3> ways{target.normal};
    for (const Vec3 d : directions())
      if (dot(d, target.normal) >= kWidestTilt) ways.push_back(d);
    for (const Vec3 way : ways)
      for (const double sunk : {0.0, 0.5 * sensor.depth_mm}) {
        const Vec3 aim = target.point - way * sunk;
        all.push_back({pose_looking_at(aim + way * sensor.stand_off_mm, aim, {0, 0, 1}), {}, {}});
      }
  }
  std::vector<double> home;
  if (rig.machine)
    for (const Joint& joint : rig.machine->joints) home.push_back(joint.home);
  const std::size_t aimed = all.size();
  const std::vector<std::vector<double>> grid = rig.machine ? grid_of(rig) : std::vector<std::vector<double>>();
  all.resize(aimed + grid.size());
  context.loop.run(all.size(), [&](std::size_t c, int) {
    if (context.cancel.is_set()) return;
    if (!(c < aimed ? take_place(rig, home, all[c]) : take_joints(rig, grid[c - aimed], all[c]))) return;
    all[c].seen = facets_seen(surface, sensor, all[c].view, min_cosine);
  });
  std::erase_if(all, [](const Candidate& candidate) { return candidate.seen.empty(); });
  return all;
}

/// Greedy cover, and back over the choice for what later ones made superfluous.
std::vector<std::size_t> cover(const std::vector<Candidate>& candidates, std::size_t facets, double share,
                               std::size_t most, Proposal& out) {
  std::vector<std::uint32_t> times(facets, 0);
  for (const Candidate& candidate : candidates)
    for (const std::uint32_t f : candidate.seen) out.visible += times[f]++ == 0;
  times.assign(facets, 0);
  const auto wanted = static_cast<std::uint64_t>(std::ceil(share * static_cast<double>(out.visible)));
  std::vector<std::size_t> gain;
  for (const Candidate& candidate : candidates) gain.push_back(candidate.seen.size());
  std::vector<std::size_t> chosen;
  while (out.covered < wanted && chosen.size() < most) {
    // Gains only shrink, so the largest known gain that is still true is the largest of all.
    std::size_t best = candidates.size(), best_gain = 0;
    for (std::size_t c = 0; c < candidates.size(); ++c) {
      if (gain[c] <= best_gain) continue;
      gain[c] = static_cast<std::size_t>(std::count_if(candidates[c].seen.begin(), candidates[c].seen.end(),
                                                       [&](std::uint32_t f) { return times[f] == 0; }));
      if (gain[c] <= best_gain) continue;
      best = c;
      best_gain = gain[c];
    }
    if (best == candidates.size()) break;
    chosen.push_back(best);
    out.covered += best_gain;
    for (const std::uint32_t f : candidates[best].seen) ++times[f];
  }
  for (std::size_t k = 0; k < chosen.size();) {
    const std::vector<std::uint32_t>& seen = candidates[chosen[k]].seen;
    const auto alone = static_cast<std::uint64_t>(
        std::count_if(seen.begin(), seen.end(), [&](std::uint32_t f) { return times[f] == 1; }));
    if (out.covered - alone < wanted) {
      ++k;
      continue;
    }
    out.covered -= alone;
    for (const std::uint32_t f : seen) --times[f];
    chosen.erase(chosen.begin() + static_cast<std::ptrdiff_t>(k));
  }
  return chosen;
}

std::string name_of(std::size_t number, std::size_t count) {
  std::string digits = std::to_string(number);
  const std::size_t width = count >= 100 ? 3 : 2;
  digits.insert(0, digits.size() < width ? width - digits.size() : 0, '0');
  return "s" + digits;
}

}  // namespace

Result<Proposal> propose(const ScanPlan& rig, const Surface& surface, const ProposeParams& params,
                         const Context& context) {
  Proposal out;
  out.facets = surface.facets.size();
  const double min_cosine = sine_cosine_of(std::min(params.max_angle_deg, rig.sensor.max_incidence_deg)).cosine;
  const std::vector<Candidate> candidates = candidates_of(rig, surface, min_cosine, context);
  if (context.cancel.is_set()) return fail(Code::Cancelled, "stopped while stations were looked for");
  out.candidates = candidates.size();
  if (candidates.empty())
    return fail(Code::BadInput,
                "the machine finds no place from which the sensor sees anything of the object; is the object where "
                "machine.part_frame says, and its size one for this sensor?");
  const std::vector<std::size_t> chosen =
      cover(candidates, surface.facets.size(), params.coverage, params.max_stations, out);
  if (!rig.machine || rig.machine->joints.empty()) {
    for (const std::size_t c : chosen) {
      Station& station = out.stations.emplace_back();
      station.name = name_of(out.stations.size(), chosen.size());
      station.given_pose = station.pose = candidates[c].view;
    }
    return out;
  }
  std::vector<std::vector<double>> places;
  for (const std::size_t c : chosen) places.push_back(candidates[c].joints);
  std::size_t number = 0;
  for (const Stop& stop : shortest_way(rig, places, context)) {
    Station& station = out.stations.emplace_back();
    station.via = stop.via;
    station.name = stop.via ? "via-" + std::to_string(out.stations.size()) : name_of(++number, chosen.size());
    station.joints = stop.joints;
  }
  // Joints to counts on the way that was chosen: lost motion depends on the direction of each move.
  ScanPlan planned = rig;
  planned.stations = out.stations;
  const std::vector<State> states = settle(planned);
  for (std::size_t s = 0; s < states.size(); ++s) {
    out.stations[s].pose = states[s].at.view;
    out.stations[s].joints = states[s].joints;
    bool counted = false;
    for (const Joint& joint : rig.machine->joints) counted |= counts_per_turn(joint) > 0;
    if (counted) out.stations[s].counts = states[s].counts;
  }
  return out;
}

}  // namespace scanmill::plan
