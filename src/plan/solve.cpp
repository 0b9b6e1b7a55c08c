// SPDX-License-Identifier: Apache-2.0
#include "plan/solve.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "geom/angles.hpp"

namespace scanmill::plan {
namespace {

constexpr double kRadian = 0.017453292519943295;
constexpr double kGood = 1e-7;  // mm, at the place and at the aim
constexpr int kMostRounds = 80;
constexpr std::size_t kMostStarts = 256;

Vec3 column(const Pose& pose, std::size_t k) { return {pose.rotation[k], pose.rotation[3 + k], pose.rotation[6 + k]}; }

/// What is left between where the sensor is and where it should be: place, aim, roll, all in mm.
struct Residual {
  std::array<Vec3, 3> parts;
  double squared() const { return norm2(parts[0]) + norm2(parts[1]) + norm2(parts[2]); }
};

class Search {
 public:
  Search(const Machine& machine, const Mount& mount, double aim_mm, const Wish& wish, bool with_roll, bool bounded)
      : machine_(machine), mount_(mount), aim_(aim_mm), wish_(wish), with_roll_(with_roll), bounded_(bounded) {}

  /// Walks from `q` to the nearest minimum; the squared residual there.
  double run(std::vector<double>& q) const {
    if (bounded_) clamp(q);
    double damping = 1e-3;
    Residual now = residual(q);
    for (int round = 0; round < kMostRounds && now.squared() > 1e-22; ++round) {
      std::vector<double> matrix, gradient;
      normal_equations(q, now, matrix, gradient);
      bool better = false;
      for (int attempt = 0; attempt < 12 && !better; ++attempt) {
        std::vector<double> trial = q;
        if (step(matrix, gradient, damping, q, trial)) {
          const Residual there = residual(trial);
          if (there.squared() < now.squared()) {
            better = there.squared() < now.squared() * (1 - 1e-9);
            q = trial;
            now = there;
            damping = std::max(damping * 0.1, 1e-12);
            if (!better) return now.squared();
            break;
          }
        }
        damping *= 10;
      }
      if (!better) break;
    }
    return now.squared();
  }

  void misses(const std::vector<double>& q, Solution& out) const {
    const Pose view = place(machine_, mount_, q).view;
    out.miss_mm = norm(view.translation - wish_.view.translation);
    out.miss_deg = degrees_between(column(view, 2), column(wish_.view, 2));
    out.roll_deg = gap_between(view, wish_.view).degrees;
  }

 private:
  void clamp(std::vector<double>& q) const {
    for (std::size_t i = 0; i < q.size(); ++i)
      if (machine_.joints[i].low) q[i] = std::clamp(q[i], *machine_.joints[i].low, *machine_.joints[i].high);
  }

  Residual residual(const std::vector<double>& q) const {
    const Pose view = place(machine_, mount_, q).view;
    Residual r;
    r.parts[0] = view.translation - wish_.view.translation;
    r.parts[1] = (column(view, 2) - column(wish_.view, 2)) * aim_;
    if (with_roll_) r.parts[2] = (column(view, 0) - column(wish_.view, 0)) * aim_;
    return r;
  }

  /// J^T J row by row, and J^T r; units: mm per mm or per degree.
  void normal_equations(const std::vector<double>& q, const Residual& r, std::vector<double>& matrix,
                        std::vector<double>& gradient) const {
    const std::size_t n = q.size();
    const Placed at = place(machine_, mount_, q);
    const Pose to_part = at.part.inverse();
    const std::vector<AxisAt> axes = axes_at(machine_, q);
    std::vector<std::array<Vec3, 3>> columns(n);
    for (std::size_t i = 0; i < n; ++i) {
      const Joint& joint = machine_.joints[i];
      // Moving the part one way is moving the sensor the other way, as the part sees it.
      const double sign = joint.carries == Carries::Sensor ? 1 : -1;
      if (joint.type == JointType::Linear) {
        columns[i][0] = to_part.turn(axes[i].direction) * sign;
        continue;
      }
      const Vec3 spin = axes[i].direction * (sign * kRadian);
      columns[i][0] = to_part.turn(cross(spin, at.sensor.translation - axes[i].origin));
      columns[i][1] = to_part.turn(cross(spin, column(at.sensor, 2))) * aim_;
      if (with_roll_) columns[i][2] = to_part.turn(cross(spin, column(at.sensor, 0))) * aim_;
    }
    const auto product = [](const std::array<Vec3, 3>& a, const std::array<Vec3, 3>& b) {
      return dot(a[0], b[0]) + dot(a[1], b[1]) + dot(a[2], b[2]);
    };
    matrix.assign(n * n, 0);
    gradient.assign(n, 0);
    for (std::size_t i = 0; i < n; ++i) {
      gradient[i] = product(columns[i], r.parts);
      for (std::size_t j = 0; j < n; ++j) matrix[i * n + j] = product(columns[i], columns[j]);
    }
  }

  /// q - (J^T J + damping diag)^-1 J^T r; joints that would be pushed through a limit they stand at are held.
  bool step(const std::vector<double>& matrix, const std::vector<double>& gradient, double damping,
            const std::vector<double>& q, std::vector<double>& out) const {
    const std::size_t n = q.size();
    std::vector<std::size_t> free;
    for (std::size_t i = 0; i < n; ++i) {
      const Joint& joint = machine_.joints[i];
      const bool held = bounded_ && joint.low &&
                        ((q[i] <= *joint.low && gradient[i] > 0) || (q[i] >= *joint.high && gradient[i] < 0));
      if (!held) free.push_back(i);
    }
    const std::size_t m = free.size();
    if (m == 0) return false;
    std::vector<double> a(m * m), b(m);
    for (std::size_t i = 0; i < m; ++i) {
      b[i] = gradient[free[i]];
      for (std::size_t j = 0; j < m; ++j) a[i * m + j] = matrix[free[i] * n + free[j]];
      a[i * m + i] += damping * std::max(a[i * m + i], 1e-6);
    }
    for (std::size_t k = 0; k < m; ++k) {  // Gauss without pivoting: the matrix is positive definite
      if (!(a[k * m + k] > 0)) return false;
      for (std::size_t i = k + 1; i < m; ++i) {
        const double f = a[i * m + k] / a[k * m + k];
        for (std::size_t j = k; j < m; ++j) a[i * m + j] -= f * a[k * m + j];
        b[i] -= f * b[k];
      }
    }
    for (std::size_t k = m; k-- > 0;) {
      for (std::size_t j = k + 1; j < m; ++j) b[k] -= a[k * m + j] * b[j];
      b[k] /= a[k * m + k];
    }
    for (std::size_t i = 0; i < m; ++i) {
      const double most = machine_.joints[free[i]].type == JointType::Rotary ? 40 : 1e9;  // no wild turns
      out[free[i]] = q[free[i]] - std::clamp(b[i], -most, most);
    }
    if (bounded_) clamp(out);
    return true;
  }

  const Machine& machine_;
  const Mount& mount_;
  double aim_;
  const Wish& wish_;
  bool with_roll_, bounded_;
};

/// Where the search begins: where the machine is, then rotary joints at places all round their range.
std::vector<std::vector<double>> starts(const Machine& machine, std::span<const double> near) {
  std::vector<std::vector<double>> list{std::vector<double>(near.begin(), near.end())};
  std::vector<std::size_t> rotary;
  std::vector<double> middle(near.begin(), near.end());
  for (std::size_t i = 0; i < machine.joints.size(); ++i) {
    const Joint& joint = machine.joints[i];
    if (joint.type == JointType::Rotary)
      rotary.push_back(i);
    else if (joint.low)
      middle[i] = (*joint.low + *joint.high) / 2;
  }
  std::size_t count = 1;
  for (std::size_t k = 0; k < rotary.size() && count * 4 <= kMostStarts; ++k) count *= 4;
  for (std::size_t n = 0; n < count; ++n) {
    std::vector<double> q = middle;
    std::size_t rest = n;
    for (const std::size_t i : rotary) {
      const Joint& joint = machine.joints[i];
      const double low = joint.low ? std::max(*joint.low, -180.0) : -180,
                   high = joint.low ? std::min(*joint.high, 180.0) : 180;
      q[i] = low + (high - low) * (static_cast<double>(rest % 4) + 0.5) / 4;
      rest /= 4;
    }
    list.push_back(std::move(q));
  }
  return list;
}

/// Whole turns that bring a joint within its limits.
void unwind(const Machine& machine, std::vector<double>& q) {
  for (std::size_t i = 0; i < q.size(); ++i) {
    const Joint& joint = machine.joints[i];
    if (joint.type != JointType::Rotary || !joint.low) continue;
    if (q[i] > *joint.high) q[i] -= 360 * std::floor((q[i] - *joint.high) / 360 + 1 - 1e-12);
    if (q[i] < *joint.low) q[i] += 360 * std::floor((*joint.low - q[i]) / 360 + 1 - 1e-12);
  }
}

double beyond(const Machine& machine, const std::vector<double>& q) {
  double sum = 0;
  for (std::size_t i = 0; i < q.size(); ++i)
    if (const Joint& joint = machine.joints[i]; joint.low)
      sum += std::max({0.0, *joint.low - q[i], q[i] - *joint.high});
  return sum;
}

}  // namespace

Solution solve(const Machine& machine, const Mount& mount, double aim_mm, const Wish& wish,
               std::span<const double> near) {
  const auto begins = starts(machine, near);
  const double good = kGood * kGood;
  Solution best;
  best.joints.assign(near.begin(), near.end());
  double least = 1e300;
  for (const bool with_roll : {true, false}) {
    if (with_roll && !wish.roll_matters) continue;
    const Search search(machine, mount, aim_mm, wish, with_roll, true);
    for (const auto& begin : begins) {
      std::vector<double> q = begin;
      const double left = search.run(q);
      if (left <= good) {
        Solution found{with_roll || !wish.roll_matters ? Reach::Exact : Reach::RollFree, q, 0, 0, 0};
        search.misses(q, found);
        if (!wish.roll_matters) found.roll_deg = 0;
        return found;
      }
      if (!with_roll && left < least) {
        least = left;
        best.joints = q;
      }
    }
    if (!with_roll) search.misses(best.joints, best);
  }
  // Without limits: which of them forbids it?
  const Search search(machine, mount, aim_mm, wish, false, false);
  double nearest = 1e300;
  for (const auto& begin : begins) {
    std::vector<double> q = begin;
    if (search.run(q) > good) continue;
    unwind(machine, q);
    const double far = beyond(machine, q);
    if (far >= nearest) continue;
    nearest = far;
    best.reach = Reach::OutsideLimits;
    best.joints = q;
  }
  if (best.reach == Reach::OutsideLimits) search.misses(best.joints, best);
  return best;
}

}  // namespace scanmill::plan
