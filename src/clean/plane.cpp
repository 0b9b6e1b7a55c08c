// SPDX-License-Identifier: Apache-2.0
#include "clean/plane.hpp"

#include <algorithm>
#include <numeric>

#include "base/random.hpp"
#include "base/text.hpp"
#include "geom/plane_fit.hpp"
#include "mesh/limits.hpp"

namespace scanmill::clean {
namespace {

// A plane of a tenth of the points is missed by 4,096 trials with probability (1 - 0.001)^4096 = 1.7 %, one of a fifth
// with 5e-15.
constexpr std::size_t kTrials = 4096, kTrialsAtOnce = 64;
constexpr std::size_t kRefined = 16;
constexpr int kRounds = 8;
constexpr std::uint64_t kPurpose = 0x64656b63'706c616eull;

struct Candidate {
  Plane plane;
  std::size_t held = 0;
};

std::size_t held_by(std::span<const Vec3> sample, const Plane& plane, double distance) {
  std::size_t held = 0;
  for (const Vec3& p : sample) held += std::abs(plane.height(p)) <= distance;
  return held;
}

class Fit {
 public:
  Fit(std::span<const Vec3> sample, const PlaneRule& rule, std::uint64_t seed)
      : sample_(sample), rule_(rule), seed_(seed) {
    if (rule.normal) {
      wanted_ = unit(*rule.normal);
      least_dot_ = cos_of_degrees(rule.max_tilt_deg);
    }
  }

  Candidate trial(std::size_t number) const {
    Random random(seed_, number, kPurpose);
    auto draw = [&] { return sample_[static_cast<std::size_t>(random.next() % sample_.size())]; };
    Candidate candidate;
    const Vec3 a = draw(), b = draw(), c = draw();
    const Vec3 n = cross(b - a, c - a);
    if (!(norm2(n) > 0) || !is_finite(n)) return candidate;
    candidate.plane = {a, unit(n)};
    if (faces_right(candidate.plane)) candidate.held = held_by(sample_, candidate.plane, rule_.distance_mm);
    return candidate;
  }

  /// Least squares over the points held, again while that holds more.
  Candidate refined(Candidate best) const {
    for (int round = 0; round < kRounds; ++round) {
      Candidate next;
      next.plane = plane_through(best);
      if (!faces_right(next.plane)) break;
      next.held = held_by(sample_, next.plane, rule_.distance_mm);
      if (next.held < best.held) break;
      const bool grew = next.held > best.held;
      best = next;
      if (!grew) break;
    }
    return best;
  }

  FittedPlane finish(const Candidate& best) const {
    FittedPlane fitted{best.plane, 0, 0, sample_.size()};
    std::size_t above = 0, below = 0;
    double sum = 0;
    for (const Vec3& p : sample_) {
      const double height = best.plane.height(p);
      if (std::abs(height) <= rule_.distance_mm)
        sum += height * height;
      else
        ++(height > 0 ? above : below);
    }
    const bool turn = wanted_ ? dot(fitted.plane.normal, *wanted_) < 0 : below > above;
    if (turn) fitted.plane.normal = -fitted.plane.normal;
    fitted.share = static_cast<double>(best.held) / static_cast<double>(sample_.size());
    if (best.held > 0) fitted.rms_mm = std::sqrt(sum / static_cast<double>(best.held));
    return fitted;
  }

 private:
  bool faces_right(const Plane& plane) const { return !wanted_ || std::abs(dot(plane.normal, *wanted_)) >= least_dot_; }

  Plane plane_through(const Candidate& from) const {
    Vec3 sum;
    double count = 0;
    auto is_held = [&](Vec3 p) { return std::abs(from.plane.height(p)) <= rule_.distance_mm; };
    for (const Vec3& p : sample_)
      if (is_held(p)) sum += p - from.plane.point, ++count;
    if (count < 3) return from.plane;
    const Vec3 centre = from.plane.point + sum * (1 / count);
    Covariance c;
    for (const Vec3& p : sample_) {
      if (!is_held(p)) continue;
      const Vec3 d = p - centre;
      c.xx += d.x * d.x, c.xy += d.x * d.y, c.xz += d.x * d.z;
      c.yy += d.y * d.y, c.yz += d.y * d.z, c.zz += d.z * d.z;
    }
    return {centre, fit_plane(c).normal};
  }

  std::span<const Vec3> sample_;
  const PlaneRule& rule_;
  std::uint64_t seed_;
  std::optional<Vec3> wanted_;
  double least_dot_ = 0;
};

/// Cut, not rounded: a share below the wanted one never reads like it.
std::string percent(double share) { return number_text(std::floor(share * 10000 + 1e-6) / 100) + " %"; }

}  // namespace

Result<FittedPlane> fit_largest_plane(std::span<const Vec3> sample, const PlaneRule& rule, std::uint64_t seed,
                                      const Context& context) {
  if (sample.size() < 3)
    return fail(Code::BadInput,
                "clean.remove_plane: only " + std::to_string(sample.size()) + " points are left to fit a plane to");
  const Fit fit(sample, rule, seed);
  std::vector<Candidate> candidates(kTrials);
  for_each_range(context, kTrials, kTrialsAtOnce, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) candidates[i] = fit.trial(i);
  });
  if (context.cancel.is_set()) return fail(Code::Cancelled, "stopped on request");
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.held > b.held; });
  Candidate best;
  for (std::size_t i = 0; i < kRefined && candidates[i].held > 0; ++i) {
    const Candidate candidate = fit.refined(candidates[i]);
    if (candidate.held > best.held) best = candidate;
  }
  FittedPlane fitted = fit.finish(best);
  if (best.held == 0 || fitted.share < rule.min_share)
    return fail(Code::BadInput,
                "clean.remove_plane: no plane" + std::string(rule.normal ? " facing about the given normal" : "") +
                    " holds " + percent(rule.min_share) + " of the points within " + number_text(rule.distance_mm) +
                    " mm; the best holds " + percent(fitted.share) +
                    ". Give the plane by point and normal, raise distance_mm, or lower clean.remove_plane.min_share");
  return fitted;
}

}  // namespace scanmill::clean
