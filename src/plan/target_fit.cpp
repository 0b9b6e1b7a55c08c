// SPDX-License-Identifier: Apache-2.0
// Samples of as few points as make a shape, the one that most agree with (Fischler and Bolles 1981), then least
// squares.
#include "plan/target_fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/random.hpp"
#include "geom/envelope.hpp"
#include "geom/plane_fit.hpp"

namespace scanmill::plan {
namespace {

constexpr int kSamples = 400;
constexpr std::size_t kJudges = 2000;  // points that vote
constexpr std::size_t kFewest = 100;
constexpr double kLeastShare = 0.1;
constexpr std::uint64_t kPurpose = 0x746172676574;  // "target"

double distance(const TargetFit& fit, TargetKind kind, Vec3 p) {
  return kind == TargetKind::Sphere ? norm(p - fit.centre) - fit.radius : dot(p - fit.centre, fit.normal);
}

/// Through four points; false when they lie flat.
bool sphere_through(const std::array<Vec3, 4>& p, TargetFit& fit) {
  const Vec3 a = p[1] - p[0], b = p[2] - p[0], c = p[3] - p[0];
  const double det = dot(a, cross(b, c));
  if (std::abs(det) < 1e-3 * norm(a) * norm(b) * norm(c)) return false;
  const Vec3 to_centre = (cross(b, c) * norm2(a) + cross(c, a) * norm2(b) + cross(a, b) * norm2(c)) * (0.5 / det);
  fit.centre = p[0] + to_centre;
  fit.radius = norm(to_centre);
  return true;
}

bool plane_through(const std::array<Vec3, 4>& p, TargetFit& fit) {
  const Vec3 n = cross(p[1] - p[0], p[2] - p[0]);
  if (norm(n) < 1e-3 * norm(p[1] - p[0]) * norm(p[2] - p[0])) return false;
  fit.centre = p[0];
  fit.normal = unit(n);
  return true;
}

std::vector<std::uint32_t> rows_within(std::span<const Vec3> points, const TargetFit& fit, TargetKind kind,
                                       double reach) {
  std::vector<std::uint32_t> rows;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (std::abs(distance(fit, kind, points[i])) <= reach) rows.push_back(static_cast<std::uint32_t>(i));
  return rows;
}

/// Gauss-Newton on centre and radius.
void settle_sphere(std::span<const Vec3> points, TargetFit& fit) {
  for (int round = 0; round < 12; ++round) {
    Envelope system({0, 0, 0, 0});
    std::vector<double> right(4, 0.0);
    for (const std::uint32_t row : fit.rows) {
      const Vec3 d = points[row] - fit.centre;
      const double length = norm(d), off = length - fit.radius;
      if (length == 0) continue;
      const double slope[4] = {-d.x / length, -d.y / length, -d.z / length, -1};
      for (std::size_t i = 0; i < 4; ++i) {
        for (std::size_t j = 0; j <= i; ++j) system.at(i, j) += slope[i] * slope[j];
        right[i] -= slope[i] * off;
      }
    }
    if (!system.factor()) return;
    system.solve(right);
    fit.centre += {right[0], right[1], right[2]};
    fit.radius += right[3];
    if (norm({right[0], right[1], right[2]}) < 1e-9) return;
  }
}

void settle_plane(std::span<const Vec3> points, TargetFit& fit) {
  Vec3 sum;
  for (const std::uint32_t row : fit.rows) sum += points[row];
  fit.centre = sum * (1 / static_cast<double>(fit.rows.size()));
  Covariance c;
  for (const std::uint32_t row : fit.rows) {
    const Vec3 d = points[row] - fit.centre;
    c.xx += d.x * d.x, c.xy += d.x * d.y, c.xz += d.x * d.z;
    c.yy += d.y * d.y, c.yz += d.y * d.z, c.zz += d.z * d.z;
  }
  fit.normal = fit_plane(c).normal;
}

void settle(std::span<const Vec3> points, TargetKind kind, TargetFit& fit) {
  if (kind == TargetKind::Sphere)
    settle_sphere(points, fit);
  else
    settle_plane(points, fit);
  double sum = 0;
  for (const std::uint32_t row : fit.rows) {
    const double off = distance(fit, kind, points[row]);
    sum += off * off;
  }
  fit.rms_mm = std::sqrt(sum / static_cast<double>(fit.rows.size()));
}

}  // namespace

std::optional<TargetFit> find_target(std::span<const Vec3> points, TargetKind kind, std::optional<double> radius_mm,
                                     double noise_mm, std::uint64_t seed) {
  if (points.size() < kFewest) return {};
  const double reach = std::max(8 * noise_mm, 0.02);
  const std::size_t stride = std::max<std::size_t>(1, points.size() / kJudges);
  // A floor is a piece of a very large sphere too; without a certified radius the ball must fit into what is seen.
  Bounds box;
  for (const Vec3& p : points) box.add(p);
  const double largest = 0.75 * norm(box.size());
  TargetFit best;
  std::size_t most = 0;
  for (int sample = 0; sample < kSamples; ++sample) {
    Random random(seed, static_cast<std::uint64_t>(sample), kPurpose);
    std::array<Vec3, 4> drawn{};
    for (Vec3& p : drawn) p = points[static_cast<std::size_t>(random.uniform() * static_cast<double>(points.size()))];
    TargetFit fit;
    if (kind == TargetKind::Sphere ? !sphere_through(drawn, fit) : !plane_through(drawn, fit)) continue;
    if (kind == TargetKind::Sphere && !radius_mm && fit.radius > largest) continue;
    if (kind == TargetKind::Sphere && radius_mm && std::abs(fit.radius - *radius_mm) > 0.1 * *radius_mm) continue;
    std::size_t votes = 0;
    for (std::size_t i = 0; i < points.size(); i += stride) votes += std::abs(distance(fit, kind, points[i])) <= reach;
    if (votes <= most) continue;
    most = votes;
    best = fit;
  }
  if (most == 0) return {};
  for (int round = 0; round < 3; ++round) {
    best.rows = rows_within(points, best, kind, round == 0 ? reach : std::max(4 * best.rms_mm, 1e-6));
    if (best.rows.size() < kFewest ||
        static_cast<double>(best.rows.size()) < kLeastShare * static_cast<double>(points.size()))
      return {};
    settle(points, kind, best);
  }
  if (dot(best.normal, best.centre) > 0) best.normal = -best.normal;
  return best;
}

}  // namespace scanmill::plan
