// SPDX-License-Identifier: Apache-2.0
#include "refine/patches.hpp"

#include <algorithm>
#include <cmath>

#include "base/text.hpp"
#include "cloud/over_blocks.hpp"
#include "geom/plane_fit.hpp"

namespace scanmill::refine {
namespace {

constexpr double kWanted = 60;       // points per patch
constexpr std::size_t kFewest = 8;   // that make one at all
constexpr double kThickness = 0.08;  // of the edge: a patch whose points lie farther from its plane (rms) is none
constexpr double kRoundness = 0.5;   // of the patch: strips at the border of a view have no normal to speak of
constexpr double kReach = 3;         // times the rms: farther points belong to something else

/// Row of a point and its cube, 21 bits a coordinate.
struct Placed {
  std::uint64_t cube;
  std::uint32_t row;
};

std::uint64_t cube_of(Vec3 p, double edge) {
  constexpr double kMiddle = 1 << 20;
  auto step = [&](double v) {
    return static_cast<std::uint64_t>(std::clamp(std::floor(v / edge) + kMiddle, 0.0, 2 * kMiddle - 1));
  };
  return step(p.x) << 42 | step(p.y) << 21 | step(p.z);
}

std::vector<Placed> sorted_by_cube(const std::vector<Vec3>& points, double edge) {
  std::vector<Placed> placed(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) placed[i] = {cube_of(points[i], edge), static_cast<std::uint32_t>(i)};
  std::sort(placed.begin(), placed.end(),
            [](const Placed& a, const Placed& b) { return a.cube != b.cube ? a.cube < b.cube : a.row < b.row; });
  return placed;
}

/// The edge that puts about kWanted points of this block in a cube of those that hold any.
double edge_for(const std::vector<Vec3>& points) {
  Bounds box;
  for (const Vec3& p : points) box.add(p);
  double edge = norm(box.size()) / 50;
  for (int round = 0; round < 4 && edge > 0; ++round) {
    const std::vector<Placed> placed = sorted_by_cube(points, edge);
    double cubes = 0;
    for (std::size_t i = 0; i < placed.size(); ++i) cubes += i == 0 || placed[i].cube != placed[i - 1].cube;
    edge *= std::sqrt(kWanted * cubes / static_cast<double>(points.size()));
  }
  return edge;
}

struct Plane {
  Vec3 centre, normal;
  double rms = 0, roundness = 0;
};

Plane plane_through(const std::vector<Vec3>& points) {
  Vec3 sum;
  for (const Vec3& p : points) sum += p;
  const double n = static_cast<double>(points.size());
  Plane plane;
  plane.centre = sum * (1 / n);
  Covariance c;
  for (const Vec3& p : points) {
    const Vec3 d = p - plane.centre;
    c.xx += d.x * d.x, c.xy += d.x * d.y, c.xz += d.x * d.z;
    c.yy += d.y * d.y, c.yz += d.y * d.z, c.zz += d.z * d.z;
  }
  const PlaneFit fit = fit_plane(c);
  // 1 for a round patch, 0 for a line: the product of the two larger eigenvalues over the square of their mean.
  const double minors = c.xx * c.yy - c.xy * c.xy + c.yy * c.zz - c.yz * c.yz + c.zz * c.xx - c.xz * c.xz;
  plane.roundness = fit.trace > 0 ? 4 * minors / (fit.trace * fit.trace) : 0;
  plane.normal = fit.normal;
  plane.rms = std::sqrt(std::max(fit.least, 0.0) / n);
  return plane;
}

/// The patch of one cube, if its points make one; `points` is used up.
std::optional<Plane> plane_of(std::vector<Vec3>& points, double edge) {
  for (int round = 0; round < 3; ++round) {
    if (points.size() < kFewest) return {};
    const Plane plane = plane_through(points);
    const std::size_t before = points.size();
    std::erase_if(points,
                  [&](const Vec3& p) { return std::abs(dot(p - plane.centre, plane.normal)) > kReach * plane.rms; });
    if (points.size() == before || round == 2)
      return plane.rms <= kThickness * edge && plane.roundness >= kRoundness ? std::optional(plane) : std::nullopt;
  }
  return {};
}

void add_patches(const PointBlock& block, double edge, std::vector<Patch>& out, bool& sided) {
  const std::vector<Placed> placed = sorted_by_cube(block.positions, edge);
  std::vector<Vec3> points;
  for (std::size_t begin = 0, end = 0; begin < placed.size(); begin = end) {
    points.clear();
    for (; end < placed.size() && placed[end].cube == placed[begin].cube; ++end)
      points.push_back(block.positions[placed[end].row]);
    const auto plane = plane_of(points, edge);
    if (!plane) continue;
    Patch patch{plane->centre, plane->normal, index_of(block.view), plane->rms,
                static_cast<std::uint32_t>(points.size())};
    const ViewPoint& seen = block.view_point;
    if (seen.eye || seen.direction) {
      const Vec3 towards = seen.eye ? *seen.eye - patch.centre : *seen.direction;
      if (dot(towards, patch.normal) < 0) patch.normal = -patch.normal;
    } else {
      sided = false;
    }
    out.push_back(patch);
  }
}

}  // namespace

Result<Patches> patches_of(const PointSource& points, std::optional<double> edge_mm, const Context& context) {
  Patches patches;
  patches.edge_mm = edge_mm.value_or(0);
  const std::size_t blocks = points.block_count();
  PointBlock first;
  // The middle block that holds enough; the others only if it does not.
  for (std::size_t k = 0; k < blocks && patches.edge_mm <= 0; ++k) {
    first.clear();
    TRY(points.read_block((blocks / 2 + k) % blocks, first));
    if (first.positions.size() >= 1000 || (k + 1 == blocks && !first.positions.empty()))
      patches.edge_mm = edge_for(first.positions);
  }
  if (!(patches.edge_mm > 0)) return fail(Code::BadInput, "there are no points to move views by");
  std::vector<std::vector<Patch>> of_block(blocks);
  std::vector<std::uint8_t> sided(blocks, 1);
  FirstBlockError failed;
  std::vector<PointBlock> buffers(static_cast<std::size_t>(context.loop.threads()));
  context.loop.run(blocks, [&](std::size_t number, int worker) {
    if (context.cancel.is_set() || failed.is_before(number)) return;
    PointBlock& block = buffers[static_cast<std::size_t>(worker)];
    block.clear();
    auto read = points.read_block(number, block);
    if (!read.ok()) return failed.report(number, std::move(read).error());
    bool known = true;
    add_patches(block, patches.edge_mm, of_block[number], known);
    sided[number] = known;
  });
  TRY(failed.take(context));
  for (std::size_t number = 0; number < blocks; ++number) {
    patches.list.insert(patches.list.end(), of_block[number].begin(), of_block[number].end());
    patches.sided &= sided[number] != 0;
  }
  if (patches.list.empty())
    return fail(Code::BadInput, "no piece of " + six_digits(patches.edge_mm) +
                                    " mm of any view is flat enough to compare views by; set refine.patch_mm smaller, "
                                    "or refine.poses: false");
  std::stable_sort(patches.list.begin(), patches.list.end(),
                   [](const Patch& a, const Patch& b) { return a.view < b.view; });
  return patches;
}

}  // namespace scanmill::refine
