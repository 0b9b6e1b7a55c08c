// SPDX-License-Identifier: Apache-2.0
#include "plan/calibrate.hpp"

#include <algorithm>
#include <cmath>

#include "geom/envelope.hpp"

namespace scanmill::plan {
namespace {

constexpr std::size_t kFewestViews = 6;
constexpr std::size_t kMostPoints = 2000;
constexpr int kRounds = 60;
constexpr double kMountMm = 5, kMountDeg = 5, kAxisMm = 2, kAxisDeg = 2;  // standard deviations before any view
constexpr double kTold = 0.1;   // of that: an unknown with more left is not told by these views
constexpr double kKept = 1e-6;  // what is not told stays where it is planned

/// A view with the points of its target.
struct Seen {
  const TargetView* view;
  std::vector<Vec3> points;
  std::size_t found = 0;
};

class Calibrator {
 public:
  Calibrator(const Machine& machine, const Mount& mount, const CalibrateParams& params, std::vector<Seen> seen)
      : machine_(machine), mount_(mount), params_(params), seen_(std::move(seen)) {
    const char* const words[] = {"x", "y", "z"};
    for (const char* word : words) add("mount turn " + std::string(word), "deg", kMountDeg);
    for (const char* word : words) add("mount " + std::string(word), "mm", kMountMm);
    for (const std::size_t axis : params_.axes) {
      const std::string& name = machine_.joints[axis].name;
      add("axis " + name + " across 1", "mm", kAxisMm);
      add("axis " + name + " across 2", "mm", kAxisMm);
      add("zero " + name, "deg", kAxisDeg);
    }
    settings_ = unknowns_.size();
    values_.assign(settings_ + targets(), 0.0);
  }

  /// First guess of the target, from the views as the plan places them.
  void guess(const std::vector<TargetFit>& fits) {
    Vec3 centre, normal;
    double radius = 0;
    for (std::size_t i = 0; i < seen_.size(); ++i) {
      const Pose pose = place(machine_, mount_, seen_[i].view->joints).view;
      centre += pose.apply(fits[i].centre);
      normal += pose.turn(fits[i].normal);
      radius += fits[i].radius;
    }
    const double share = 1 / static_cast<double>(seen_.size());
    centre_ = centre * share;
    normal_ = unit(normal);
    radius_ = params_.radius_mm.value_or(radius * share);
  }

  Calibration run() {
    Calibration out;
    // The target alone first: what the views say of it where the plan is right.
    std::vector<double> before;
    settle(settings_);
    out.before_mm = rms(before);
    settle(0);
    deviations();
    while (keep_one()) {
      std::fill(values_.begin(), values_.begin() + static_cast<std::ptrdiff_t>(settings_), 0.0);
      settle(settings_);
      settle(0);
      deviations();
    }
    std::vector<double> after;
    out.after_mm = rms(after);
    for (std::size_t i = 0; i < seen_.size(); ++i)
      out.views.push_back({seen_[i].view->station, seen_[i].found, before[i], after[i]});
    for (Unknown& unknown : unknowns_) unknown.deviation *= out.after_mm / noise();
    out.unknowns = unknowns_;
    for (std::size_t k = 0; k < settings_; ++k)
      if (!unknowns_[k].is_determined) values_[k] = out.unknowns[k].value = 0;  // to the last bit
    out.mount = mount_at(values_);
    out.joints = machine_at(values_).joints;
    const Target target = target_at(values_);
    out.radius_mm = target.radius;
    out.target = pose_shifted(target.centre);
    if (params_.kind == TargetKind::Plane) {
      const Vec3 x = perpendicular(target.normal), y = cross(target.normal, x);
      out.target.rotation = {x.x, y.x, target.normal.x, x.y, y.y, target.normal.y, x.z, y.z, target.normal.z};
      out.target.translation = target.centre;
    }
    return out;
  }

 private:
  struct Target {
    Vec3 centre, normal;
    double radius = 0;
  };

  void add(std::string name, const char* unit, double before) {
    unknowns_.push_back({std::move(name), unit, 0, before, true});
    springs_.push_back(before);
  }
  /// Numbers of the target: centre and, if it is not certified, radius; or two tilts and a shift.
  std::size_t targets() const { return params_.kind == TargetKind::Plane ? 3 : params_.radius_mm ? 3 : 4; }

  Mount mount_at(const std::vector<double>& v) const {
    Mount mount = mount_;
    const Vec3 turn{v[0], v[1], v[2]};
    Pose offset = pose_turned(turn, norm(turn));
    offset.translation = {v[3], v[4], v[5]};
    mount.offset = mount_.offset.after(offset);
    return mount;
  }
  Machine machine_at(const std::vector<double>& v) const {
    Machine machine = machine_;
    for (std::size_t k = 0; k < params_.axes.size(); ++k) {
      Joint& joint = machine.joints[params_.axes[k]];
      const Vec3 u = perpendicular(unit(joint.axis)), w = cross(unit(joint.axis), u);
      joint.origin += u * v[6 + 3 * k] + w * v[7 + 3 * k];
      joint.home += v[8 + 3 * k];
      if (joint.low) joint.low = *joint.low + v[8 + 3 * k];  // stops stay where they are
      if (joint.high) joint.high = *joint.high + v[8 + 3 * k];
    }
    return machine;
  }
  Target target_at(const std::vector<double>& v) const {
    const double* t = v.data() + settings_;
    if (params_.kind == TargetKind::Sphere)
      return {centre_ + Vec3{t[0], t[1], t[2]}, {}, radius_ + (params_.radius_mm ? 0 : t[3])};
    const Vec3 u = perpendicular(normal_), w = cross(normal_, u);
    const Vec3 normal = unit(normal_ + u * t[0] + w * t[1]);
    return {centre_ + normal * t[2], normal, 0};
  }
  Pose pose_at(const std::vector<double>& v, const Machine& machine, const Mount& mount, const Seen& seen) const {
    std::vector<double> joints = seen.view->joints;
    for (std::size_t k = 0; k < params_.axes.size(); ++k) joints[params_.axes[k]] += v[8 + 3 * k];
    return place(machine, mount, joints).view;
  }
  std::vector<Pose> poses_at(const std::vector<double>& v) const {
    const Machine machine = machine_at(v);
    const Mount mount = mount_at(v);
    std::vector<Pose> poses;
    for (const Seen& seen : seen_) poses.push_back(pose_at(v, machine, mount, seen));
    return poses;
  }

  /// Distance from the target and its derivative by the place of the point.
  double off(const Target& target, Vec3 p, Vec3& slope) const {
    if (params_.kind == TargetKind::Plane) {
      slope = target.normal;
      return dot(p - target.centre, target.normal);
    }
    const Vec3 d = p - target.centre;
    slope = unit(d);
    return norm(d) - target.radius;
  }

  double squares(const std::vector<double>& v) const {
    const Target target = target_at(v);
    const std::vector<Pose> poses = poses_at(v);
    double sum = 0;
    Vec3 slope;
    for (std::size_t i = 0; i < seen_.size(); ++i)
      for (const Vec3& p : seen_[i].points) {
        const double d = off(target, poses[i].apply(p), slope);
        sum += d * d;
      }
    return sum + spring_squares(v);
  }
  double noise() const { return std::max(params_.noise_mm, 1e-4); }
  /// Springs in the unit of squared distances: the noise is that of the sensor.
  double weight(std::size_t k) const {
    if (k >= settings_) return 0;
    const double spring = unknowns_[k].is_determined ? springs_[k] : kKept;
    return noise() * noise() / (spring * spring);
  }
  double spring_squares(const std::vector<double>& v) const {
    double sum = 0;
    for (std::size_t k = 0; k < settings_; ++k) sum += weight(k) * v[k] * v[k];
    return sum;
  }

  /// Normal equations of the values from `first` on.
  void normal_equations(std::size_t first, std::vector<std::vector<double>>& matrix, std::vector<double>& right) const {
    const std::size_t n = values_.size();
    const std::vector<Pose> poses = poses_at(values_);
    const Target target = target_at(values_);
    // Poses and target a little to both sides in every value: exact enough, since both are smooth.
    std::vector<std::vector<Pose>> low(n), high(n);
    std::vector<Target> less(n), more(n);
    constexpr double kStep = 1e-4;
    for (std::size_t k = first; k < n; ++k) {
      std::vector<double> v = values_;
      v[k] = values_[k] - kStep;
      if (k < settings_) low[k] = poses_at(v);
      less[k] = target_at(v);
      v[k] = values_[k] + kStep;
      if (k < settings_) high[k] = poses_at(v);
      more[k] = target_at(v);
    }
    matrix.assign(n, std::vector<double>(n, 0.0));
    right.assign(n, 0.0);
    std::vector<double> slope(n, 0.0);
    for (std::size_t i = 0; i < seen_.size(); ++i)
      for (const Vec3& p : seen_[i].points) {
        Vec3 along, unused;
        const Vec3 at = poses[i].apply(p);
        const double d = off(target, at, along);
        for (std::size_t k = first; k < n; ++k)
          slope[k] = k < settings_ ? dot(along, high[k][i].apply(p) - low[k][i].apply(p)) / (2 * kStep)
                                   : (off(more[k], at, unused) - off(less[k], at, unused)) / (2 * kStep);
        for (std::size_t k = first; k < n; ++k) {
          for (std::size_t j = first; j <= k; ++j) matrix[k][j] += slope[k] * slope[j];
          right[k] -= slope[k] * d;
        }
      }
    for (std::size_t k = first; k < settings_; ++k) {
      matrix[k][k] += weight(k);
      right[k] -= weight(k) * values_[k];
    }
  }

  static bool solve(const std::vector<std::vector<double>>& matrix, std::size_t first, double damping,
                    std::vector<double>& right) {
    const std::size_t n = right.size() - first;
    Envelope system(std::vector<std::size_t>(n, 0));
    for (std::size_t k = 0; k < n; ++k)
      for (std::size_t j = 0; j <= k; ++j) system.at(k, j) = matrix[first + k][first + j] * (j == k ? 1 + damping : 1);
    std::vector<double> x(right.begin() + static_cast<std::ptrdiff_t>(first), right.end());
    if (!system.factor()) return false;
    system.solve(x);
    std::copy(x.begin(), x.end(), right.begin() + static_cast<std::ptrdiff_t>(first));
    return true;
  }

  /// Moves the values from `first` on to the least sum of squares.
  void settle(std::size_t first) {
    double damping = 1e-6, now = squares(values_);
    std::vector<std::vector<double>> matrix;
    std::vector<double> right;
    for (int round = 0; round < kRounds; ++round) {
      normal_equations(first, matrix, right);
      bool better = false;
      for (int attempt = 0; attempt < 12 && !better; ++attempt, damping *= 10) {
        std::vector<double> step = right, trial = values_;
        if (!solve(matrix, first, damping, step)) continue;
        for (std::size_t k = first; k < trial.size(); ++k) trial[k] += step[k];
        const double there = squares(trial);
        if (!(there < now)) continue;
        better = true;
        const bool is_done = now - there <= 1e-12 * now;
        values_ = trial;
        now = there;
        damping = std::max(damping * 0.01, 1e-12);
        if (is_done) return;
      }
      if (!better) return;
    }
  }

  double rms(std::vector<double>& of_view) const {
    const std::vector<Pose> poses = poses_at(values_);
    const Target target = target_at(values_);
    double sum = 0, count = 0;
    Vec3 slope;
    for (std::size_t i = 0; i < seen_.size(); ++i) {
      double own = 0;
      for (const Vec3& p : seen_[i].points) {
        const double d = off(target, poses[i].apply(p), slope);
        own += d * d;
      }
      of_view.push_back(std::sqrt(own / static_cast<double>(seen_[i].points.size())));
      sum += own;
      count += static_cast<double>(seen_[i].points.size());
    }
    return std::sqrt(sum / count);
  }

  /// Of what the views leave open, the number they leave most open stays as planned; that may settle others.
  bool keep_one() {
    std::size_t most = settings_;
    double share = kTold;
    for (std::size_t k = 0; k < settings_; ++k) {
      if (!unknowns_[k].is_determined || unknowns_[k].deviation <= share * springs_[k]) continue;
      share = unknowns_[k].deviation / springs_[k];
      most = k;
    }
    if (most == settings_) return false;
    unknowns_[most].is_determined = false;
    return true;
  }

  /// From the diagonal of the inverse of the normal matrix, for the sensor's noise.
  void deviations() {
    std::vector<std::vector<double>> matrix;
    std::vector<double> right;
    normal_equations(0, matrix, right);
    for (std::size_t k = 0; k < settings_; ++k) {
      std::vector<double> one(values_.size(), 0.0);
      one[k] = 1;
      unknowns_[k].value = values_[k];
      if (!solve(matrix, 0, 0, one)) continue;
      unknowns_[k].deviation = noise() * std::sqrt(std::max(one[k], 0.0));
    }
  }

  const Machine& machine_;
  const Mount& mount_;
  const CalibrateParams& params_;
  std::vector<Seen> seen_;
  std::vector<Unknown> unknowns_;
  std::vector<double> springs_, values_;  // degrees and mm; the target's behind the settings
  std::size_t settings_ = 0;
  Vec3 centre_, normal_;
  double radius_ = 0;
};

Result<void> check(const Machine& machine, const CalibrateParams& params) {
  if (machine.joints.empty())
    return fail(Code::BadParameter, "the plan's machine has no joints; its poses do not depend on the mount");
  for (const std::size_t axis : params.axes)
    if (machine.joints[axis].type != JointType::Rotary)
      return fail(Code::BadParameter, "joint " + machine.joints[axis].name +
                                          " is linear; only rotary joints have a place and a zero that views can tell");
  return {};
}

}  // namespace

Result<Calibration> calibrate(const Machine& machine, const Mount& mount, std::span<const TargetView> views,
                              const CalibrateParams& params) {
  TRY(check(machine, params));
  std::vector<Seen> seen;
  std::vector<TargetFit> fits;
  std::vector<std::string> without;
  for (std::size_t i = 0; i < views.size(); ++i) {
    auto fit = find_target(views[i].points, params.kind, params.radius_mm, params.noise_mm, i);
    if (!fit) {
      without.push_back(views[i].station);
      continue;
    }
    Seen one{&views[i], {}, fit->rows.size()};
    const std::size_t stride = std::max<std::size_t>(1, fit->rows.size() / kMostPoints);
    for (std::size_t k = 0; k < fit->rows.size(); k += stride) one.points.push_back(views[i].points[fit->rows[k]]);
    seen.push_back(std::move(one));
    fits.push_back(std::move(*fit));
  }
  if (seen.size() < kFewestViews)
    return fail(Code::BadInput,
                std::string("the ") + (params.kind == TargetKind::Sphere ? "sphere" : "plane") + " was found in " +
                    std::to_string(seen.size()) + " of " + std::to_string(views.size()) +
                    " views, wanted at least 6 from different directions; is it the largest thing in view, and the "
                    "radius right?");
  Calibrator calibrator(machine, mount, params, std::move(seen));
  calibrator.guess(fits);
  Calibration out = calibrator.run();
  out.without_target = std::move(without);
  return out;
}

}  // namespace scanmill::plan
