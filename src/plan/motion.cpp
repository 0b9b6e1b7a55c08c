// SPDX-License-Identifier: Apache-2.0
#include "plan/motion.hpp"

#include <algorithm>
#include <cmath>

namespace scanmill::plan {
namespace {

constexpr double kStepMm = 5, kStepDeg = 2;
constexpr double kMostSteps = 2000;

std::size_t places_of(const Machine& machine, const Move& move) {
  double most = 1;
  for (std::size_t i = 0; i < move.from.size(); ++i) {
    const double way = std::abs(move.to[i] - move.from[i]);
    most = std::max(most, way / (machine.joints[i].type == JointType::Linear ? kStepMm : kStepDeg));
  }
  return static_cast<std::size_t>(std::ceil(std::min(most, kMostSteps)));
}

/// Way of the sensor and what the head meets on it; the last place is the station's own and judged there.
void follow(const ScanPlan& plan, const std::string& name, Step& step) {
  const Machine& machine = *plan.machine;
  const std::size_t places = places_of(machine, *step.move);
  std::vector<std::string> met = bodies_met(plan, step.state.at);
  for (std::size_t k = 0; k <= places; ++k) {
    const double share = static_cast<double>(k) / static_cast<double>(places);
    const std::vector<double> joints = step.move->at_share(share);
    const Placed at = place(machine, plan.mount, joints);
    if (!step.path.empty()) step.path_mm += norm(at.view.translation - step.path.back());
    step.path.push_back(at.view.translation);
    if (k == 0 || k == places) continue;
    for (const std::string& body : bodies_met(plan, at)) {
      if (std::find(met.begin(), met.end(), body) != met.end()) continue;
      met.push_back(body);
      std::string where;
      for (std::size_t i = 0; i < joints.size(); ++i)
        where += (where.empty() ? "" : ", ") + machine.joints[i].name + " " + rounded(joints[i]);
      step.state.findings.push_back({Severity::Error, "collision", name, "", share, 0,
                                     "station " + name + ": on the way there the head meets " + body + " (at " + where +
                                         "); put a station between"});
    }
  }
}

}  // namespace

std::vector<double> Move::at_share(double share) const {
  std::vector<double> joints(from.size());
  for (std::size_t i = 0; i < from.size(); ++i) joints[i] = share >= 1 ? to[i] : from[i] + (to[i] - from[i]) * share;
  return joints;
}

double Move::share_at(double t) const {
  if (!time_s || t >= *time_s) return 1;
  if (t <= 0) return 0;
  if (ramp == 0) return t * speed;
  const double top = std::min(speed > 0 ? speed : 1e300, std::sqrt(ramp));  // sqrt(ramp): a triangle's top
  const double rise = top / ramp, rest = *time_s - t;
  if (t < rise) return ramp * t * t / 2;
  if (rest < rise) return 1 - ramp * rest * rest / 2;
  return top * rise / 2 + (t - rise) * top;
}

Move move_between(const Machine& machine, std::span<const double> from, std::span<const double> to) {
  Move move;
  move.from.assign(from.begin(), from.end());
  move.to.assign(to.begin(), to.end());
  double speed = 1e300, ramp = 1e300;
  bool moves = false, timed = true;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const double way = std::abs(to[i] - from[i]);
    if (way == 0) continue;
    moves = true;
    timed &= machine.joints[i].velocity.has_value();
    if (machine.joints[i].velocity) speed = std::min(speed, *machine.joints[i].velocity / way);
    if (machine.joints[i].acceleration) ramp = std::min(ramp, *machine.joints[i].acceleration / way);
  }
  move.speed = speed < 1e300 ? speed : 0;
  move.ramp = ramp < 1e300 ? ramp : 0;
  if (!moves)
    move.time_s = 0;
  else if (timed && move.ramp == 0)
    move.time_s = 1 / speed;
  else if (timed)  // v^2 >= a: the top is never reached, a triangle
    move.time_s = speed * speed >= ramp ? 2 / std::sqrt(ramp) : 1 / speed + speed / ramp;
  return move;
}

double cost_of(const Move& move) {
  if (move.time_s) return *move.time_s;
  double sum = 0;
  for (std::size_t i = 0; i < move.from.size(); ++i) sum += std::abs(move.to[i] - move.from[i]);
  return sum;
}

Replay replay(const ScanPlan& plan) {
  Replay out;
  std::vector<State> states = settle(plan);
  std::vector<double> here;
  if (plan.machine)
    for (const Joint& joint : plan.machine->joints) here.push_back(joint.home);
  Totals& totals = out.totals;
  totals.travel.assign(here.size(), 0);
  totals.time_s = totals.moving_s = plan.machine && !here.empty() ? std::optional<double>(0) : std::nullopt;
  for (std::size_t s = 0; s < states.size(); ++s) {
    Step& step = out.steps.emplace_back();
    const double dwell = plan.machine && !plan.stations[s].via ? plan.machine->dwell_s : 0;
    step.state = std::move(states[s]);
    if (step.state.known) {
      step.move = move_between(*plan.machine, here, step.state.joints);
      follow(plan, plan.stations[s].name, step);
      for (std::size_t i = 0; i < here.size(); ++i) totals.travel[i] += std::abs(step.state.joints[i] - here[i]);
      here = step.state.joints;
      if (step.move->time_s) step.time_s = *step.move->time_s + dwell;
    } else {
      step.path.push_back(step.state.at.view.translation);
      if (s > 0 && !out.steps[s - 1].path.empty()) step.path_mm = norm(step.path.back() - out.steps[s - 1].path.back());
    }
    step.begin_s = totals.time_s;
    totals.path_mm += step.path_mm;
    if (!step.time_s) {
      totals.time_s.reset();
      totals.moving_s.reset();
    } else if (totals.time_s) {
      *totals.time_s += *step.time_s;
      *totals.moving_s += *step.move->time_s;
    }
  }
  count_findings(out);
  return out;
}

void count_findings(Replay& replay) {
  replay.totals.errors = replay.totals.warnings = 0;
  for (const Step& step : replay.steps)
    for (const Finding& finding : step.state.findings)
      ++(finding.severity == Severity::Error ? replay.totals.errors : replay.totals.warnings);
}

}  // namespace scanmill::plan
