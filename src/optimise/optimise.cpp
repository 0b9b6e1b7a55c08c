// SPDX-License-Identifier: Apache-2.0
#include "optimise/optimise.hpp"

#include <algorithm>

#include "base/text.hpp"
#include "geom/angles.hpp"
#include "optimise/creases.hpp"
#include "optimise/feature.hpp"
#include "optimise/rounds.hpp"
#include "optimise/smooth.hpp"

namespace scanmill::optimise {
namespace {

struct Shape {
  double angle_p5_deg = 0, longest_mm = 0;
};

/// The smallest angle that 5 % of the triangles stay below, and the longest edge.
Shape shape_of(const Surface& surface, const Context& context) {
  constexpr std::size_t kGrain = 8192;
  std::vector<double> cos2(surface.slot_count());
  std::vector<double> longest2((cos2.size() + kGrain - 1) / kGrain, 0);
  for_each_piece(context, cos2.size(), kGrain, [&](std::size_t begin, std::size_t end, std::size_t piece, int) {
    for (std::size_t t = begin; t < end; ++t) {
      const auto& v = surface.slot(static_cast<std::uint32_t>(t)).corner;
      const Vec3 a = surface.at(v[0]), b = surface.at(v[1]), c = surface.at(v[2]);
      const double x = norm2(a - b), y = norm2(b - c), z = norm2(c - a);
      cos2[t] = smallest_angle_cos2(x, y, z);
      longest2[piece] = std::max({longest2[piece], x, y, z});
    }
  });
  if (cos2.empty()) return {};
  const auto fifth = cos2.begin() + static_cast<std::ptrdiff_t>(cos2.size() / 20);
  std::nth_element(cos2.begin(), fifth, cos2.end(), std::greater<>());
  return {acos_degrees(std::sqrt(*fifth)), std::sqrt(*std::max_element(longest2.begin(), longest2.end()))};
}

Result<void> check(const Mesh& mesh, const Limits& limits) {
  if (!(limits.range_mm > 0))
    return fail(Code::BadParameter,
                "longest edge " + number_text(limits.range_mm) + " mm; give one above 0 (g1 times the bin edge)");
  if (!(limits.cos_min_angle >= 0.5 && limits.cos_min_angle <= 1))
    return fail(Code::BadParameter, "cosine of the smallest angle " + number_text(limits.cos_min_angle) +
                                        "; give one of 0 to 60 degrees (g2)");
  if (!mesh.patch.empty() && mesh.patch.size() != mesh.triangles.size())
    return fail(Code::Internal, std::to_string(mesh.patch.size()) + " patch numbers for " +
                                    std::to_string(mesh.triangles.size()) + " triangles");
  if (mesh.triangles.size() >= kNone / kPerSlot)
    return fail(Code::Unsupported,
                std::to_string(mesh.triangles.size()) + " triangles; edge swaps take up to 1.07e9 in one piece");
  return {};
}

}  // namespace

Result<Report> optimise(Mesh& mesh, const Params& params, const Limits& limits, const Context& context) {
  TRY(check(mesh, limits));
  Report report;
  if ((!params.smooth && !params.feature) || mesh.triangles.empty()) return report;
  Surface surface(mesh);
  Shape shape = shape_of(surface, context);
  if (context.cancel.is_set()) return fail(Code::Cancelled, "cancelled before swapping edges");
  NearVertices near(surface, std::max(shape.longest_mm, limits.range_mm));
  auto pass = [&](auto make_rule, PassReport& to) -> Result<void> {
    to.done = true;
    to.angle_p5_before_deg = shape.angle_p5_deg;
    auto rule = make_rule();
    TRY(run_rounds(surface, rule, near, limits, context, to));
    shape = shape_of(surface, context);
    to.angle_p5_after_deg = shape.angle_p5_deg;
    to.longest_edge_mm = shape.longest_mm;
    return {};
  };
  if (params.smooth) TRY(pass([&] { return SmoothRule(surface); }, report.smooth));
  if (params.feature) {
    report.before_feature = creases_of(surface, limits.range_mm, context);
    TRY(pass([&] { return FeatureRule(surface, context); }, report.feature));
    report.after_feature = creases_of(surface, limits.range_mm, context);
  }
  if (context.cancel.is_set()) return fail(Code::Cancelled, "cancelled while swapping edges");
  surface.write_to(mesh);
  return report;
}

}  // namespace scanmill::optimise
