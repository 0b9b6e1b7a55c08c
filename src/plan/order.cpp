// SPDX-License-Identifier: Apache-2.0
#include "plan/order.hpp"

#include <algorithm>
#include <cmath>

#include "plan/motion.hpp"

namespace scanmill::plan {
namespace {

constexpr double kBlocked = 1e6;  // no way round was found

/// A move with the places in between that keep the head clear.
struct Route {
  double cost = 0;
  std::vector<std::vector<double>> between;
};

bool is_clear(const ScanPlan& rig, const std::vector<double>& from, const std::vector<double>& to) {
  double most = 1;
  for (std::size_t i = 0; i < from.size(); ++i)
    most = std::max(most, std::abs(to[i] - from[i]) / (rig.machine->joints[i].type == JointType::Linear ? 5 : 2));
  const auto steps = static_cast<int>(std::ceil(std::min(most, 2000.0)));
  const Move move = move_between(*rig.machine, from, to);
  for (int k = 0; k <= steps; ++k)
    if (!bodies_met(rig, place(*rig.machine, rig.mount, move.at_share(static_cast<double>(k) / steps))).empty())
      return false;
  return true;
}

Route route_between(const ScanPlan& rig, const std::vector<double>& from, const std::vector<double>& to) {
  const Machine& machine = *rig.machine;
  const double straight = cost_of(move_between(machine, from, to));
  if (is_clear(rig, from, to)) return {straight, {}};
  Route best{kBlocked + straight, {}};
  for (std::size_t i = 0; i < machine.joints.size(); ++i) {
    if (machine.joints[i].type != JointType::Linear || !machine.joints[i].low) continue;
    for (const double end : {*machine.joints[i].high, *machine.joints[i].low}) {
      std::vector<double> back = from, across = to;
      back[i] = across[i] = end;
      const double cost = cost_of(move_between(machine, from, back)) + cost_of(move_between(machine, back, across)) +
                          cost_of(move_between(machine, across, to));
      if (cost < best.cost && is_clear(rig, from, back) && is_clear(rig, back, across) && is_clear(rig, across, to))
        best = {cost, {back, across}};
    }
  }
  return best;
}

}  // namespace

std::vector<Stop> shortest_way(const ScanPlan& rig, const std::vector<std::vector<double>>& places,
                               const Context& context) {
  std::vector<std::vector<double>> all{{}};  // home first
  for (const Joint& joint : rig.machine->joints) all[0].push_back(joint.home);
  all.insert(all.end(), places.begin(), places.end());
  const std::size_t n = all.size();
  std::vector<Route> routes(n * n);  // upper half: a way back costs the same
  context.loop.run(n, [&](std::size_t a, int) {
    for (std::size_t b = a + 1; b < n && !context.cancel.is_set(); ++b)
      routes[a * n + b] = route_between(rig, all[a], all[b]);
  });
  const auto cost = [&](std::size_t a, std::size_t b) { return routes[std::min(a, b) * n + std::max(a, b)].cost; };
  std::vector<std::size_t> order{0};
  std::vector<std::uint8_t> used(n, 0);
  used[0] = 1;
  while (order.size() < n) {
    std::size_t next = n;
    for (std::size_t b = 1; b < n; ++b)
      if (used[b] == 0 && (next == n || cost(order.back(), b) < cost(order.back(), next))) next = b;
    used[next] = 1;
    order.push_back(next);
  }
  // The way ends anywhere: reversing the tail saves its first move only.
  for (bool better = true; better;) {
    better = false;
    for (std::size_t i = 1; i + 1 < n; ++i)
      for (std::size_t j = i + 1; j < n; ++j) {
        const double old_cost = cost(order[i - 1], order[i]) + (j + 1 < n ? cost(order[j], order[j + 1]) : 0);
        const double new_cost = cost(order[i - 1], order[j]) + (j + 1 < n ? cost(order[i], order[j + 1]) : 0);
        if (!(new_cost < old_cost - 1e-9)) continue;
        std::reverse(order.begin() + static_cast<std::ptrdiff_t>(i),
                     order.begin() + static_cast<std::ptrdiff_t>(j) + 1);
        better = true;
      }
  }
  std::vector<Stop> stops;
  for (std::size_t k = 1; k < n; ++k) {
    const std::size_t a = order[k - 1], b = order[k];
    std::vector<std::vector<double>> between = routes[std::min(a, b) * n + std::max(a, b)].between;
    if (a > b) std::reverse(between.begin(), between.end());
    for (std::vector<double>& joints : between)
      if (joints != all[a] && joints != all[b]) stops.push_back({std::move(joints), true});
    stops.push_back({all[b], false});
  }
  return stops;
}

}  // namespace scanmill::plan
