// SPDX-License-Identifier: Apache-2.0
// The moves between stations: how long, how far, and what they meet on the way.
#pragma once
#include <optional>
#include <span>
#include <vector>

#include "plan/stations.hpp"

namespace scanmill::plan {

/// All joints start and stop together: one trapezoid in time, scaled so that no joint exceeds its velocity or
/// acceleration. A machine whose moving joints state no velocity has no times.
struct Move {
  std::vector<double> from, to;
  double speed = 0, ramp = 0;    // shares of the way per second, and per second^2; 0: without limit
  std::optional<double> time_s;  // empty when a joint that moves states no velocity
  /// Joints at a share of the way in [0, 1].
  std::vector<double> at_share(double share) const;
  /// Share of the way `t` seconds after the start.
  double share_at(double t) const;
};
Move move_between(const Machine& machine, std::span<const double> from, std::span<const double> to);

/// One station of a replay with the move that led there.
struct Step {
  State state;
  std::optional<Move> move;       // empty where the machine's place before or after is not known
  std::optional<double> time_s;   // of the move and the dwell
  std::optional<double> begin_s;  // when the move begins, from the start of the plan
  double path_mm = 0;             // way of the sensor's reference point in the global frame
  std::vector<Vec3> path;         // that way as points, first and last included
};

struct Totals {
  std::optional<double> time_s, moving_s;
  double path_mm = 0;
  std::vector<double> travel;  // per joint, mm or degrees
  std::uint64_t errors = 0, warnings = 0;
};

struct Replay {
  std::vector<Step> steps;
  Totals totals;
};

/// The whole plan offline: every station, every move between, from home. The way is looked at every 5 mm and 2 degrees
/// of any joint (at most 2,000 places per move) for bodies that the head meets; such findings go to the station that
/// the move leads to.
/// cost  about 2 us per station and place looked at
Replay replay(const ScanPlan& plan);

/// The longest of the moves' times in any order matters when stations are sorted: time of a move, or its way in mm and
/// degrees where no times are known.
double cost_of(const Move& move);

/// Adds the findings of `steps` up.
void count_findings(Replay& replay);

}  // namespace scanmill::plan
