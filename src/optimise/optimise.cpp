// SPDX-License-Identifier: Apache-2.0
#include "optimise/optimise.hpp"

#include <algorithm>

#include "base/text.hpp"
#include "optimise/creases.hpp"
#include "optimise/feature.hpp"
#include "optimise/parts.hpp"
#include "optimise/rounds.hpp"
#include "optimise/shape.hpp"
#include "optimise/smooth.hpp"

namespace scanmill::optimise {
namespace {

struct Shape {
  double angle_p5_deg = 0, longest_mm = 0;
};

Shape shape_of(const Surface& surface, const Context& context) {
  Shapes shapes = shapes_of(surface, context);
  return {fifth_percentile_deg(std::move(shapes.cos2)), std::sqrt(shapes.longest2)};
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
    report.before_feature = creases_of(surface, limits.range_mm, context).creases(limits.range_mm);
    TRY(pass([&] { return FeatureRule(surface, context); }, report.feature));
    report.after_feature = creases_of(surface, limits.range_mm, context).creases(limits.range_mm);
  }
  if (context.cancel.is_set()) return fail(Code::Cancelled, "cancelled while swapping edges");
  surface.write_to(mesh);
  return report;
}

namespace {

/// Final triangles whose least vertex is own, in numbers among all.
void write_own(const Surface& surface, const Part& part, SwappedPart& out) {
  struct Face {
    Triangle corners;
    std::uint32_t patch;
  };
  std::vector<Face> faces;
  for (std::uint32_t t = 0; t < surface.slot_count(); ++t) {
    Triangle v = surface.slot(t).corner;
    std::rotate(v.begin(), std::min_element(v.begin(), v.end()), v.end());
    if (!part.own[v[0]]) continue;
    for (std::uint32_t& corner : v) corner = part.vertex[corner];
    faces.push_back({v, part.mesh.patch.empty() ? 0 : part.mesh.patch[t]});
  }
  std::sort(faces.begin(), faces.end(), [](const Face& a, const Face& b) { return a.corners < b.corners; });
  for (const Face& face : faces) {
    out.triangles.push_back(face.corners);
    if (!part.mesh.patch.empty()) out.patch.push_back(face.patch);
  }
}

Shapes shapes_of_own(const Surface& surface, const Part& part, const Context& context) {
  std::vector<std::uint32_t> own;
  for (std::uint32_t t = 0; t < surface.slot_count(); ++t) {
    const Triangle& v = surface.slot(t).corner;
    if (part.own[std::min({v[0], v[1], v[2]})]) own.push_back(t);
  }
  return shapes_of(
      surface.positions(), own.size(), [&](std::size_t n) -> const Triangle& { return surface.slot(own[n]).corner; },
      context);
}

/// Numbers of the blocks with own vertices, and of others that may have a vertex at most near_mm from an own one, along
/// each axis; both ascending.
struct Sides {
  std::vector<std::uint32_t> own, watched;
};
Sides sides_of(const Part& part, const Witness& witness, double near_mm) {
  const std::span<const Block> blocks = witness.blocks();
  std::vector<std::uint8_t> is_own(blocks.size(), 0);
  for (std::uint32_t v = 0; v < part.own.size(); ++v)
    if (part.own[v]) is_own[witness.block_of(v)] = 1;
  // Float32 moves a position by less than a hundredth of a block.
  const auto steps = static_cast<std::int32_t>(std::ceil(near_mm / part.block_mm + 0.01));
  auto has_own_near = [&](const Block& block) {
    Block at;
    for (at[0] = block[0] - steps; at[0] <= block[0] + steps; ++at[0])
      for (at[1] = block[1] - steps; at[1] <= block[1] + steps; ++at[1]) {
        at[2] = block[2] - steps;
        auto found = std::lower_bound(blocks.begin(), blocks.end(), at);
        for (; found != blocks.end() && (*found)[0] == at[0] && (*found)[1] == at[1] && (*found)[2] <= block[2] + steps;
             ++found)
          if (is_own[static_cast<std::size_t>(found - blocks.begin())]) return true;
      }
    return false;
  };
  Sides sides;
  for (std::uint32_t n = 0; n < blocks.size(); ++n) {
    if (is_own[n])
      sides.own.push_back(n);
    else if (has_own_near(blocks[n]))
      sides.watched.push_back(n);
  }
  return sides;
}

}  // namespace

Result<SwappedPart> optimise_part(const Part& part, const Params& params, const Limits& limits,
                                  const Context& context) {
  TRY(check(part.mesh, limits));
  SwappedPart out;
  Surface surface(part.mesh);
  const double longest = std::max(shape_of(surface, context).longest_mm, limits.range_mm);
  NearVertices near(surface, longest);
  Witness witness(part);
  std::uint16_t passes = 0;
  auto pass = [&](auto make_rule) -> Result<void> {
    const std::uint16_t n = passes++;
    witness.begin_pass(n);
    auto rule = make_rule();
    PassReport report;
    TRY(run_rounds(surface, rule, near, limits, context, report, part.own, &witness));
    out.tally.swaps[n] = witness.own_swaps();
    out.tally.turns[n] = witness.turns();
    out.tally.refused[n] = report.refused;
    Shapes shapes = shapes_of_own(surface, part, context);
    out.tally.longest2[n] = shapes.longest2;
    if (n == 0 && params.smooth && params.feature) out.between = std::move(shapes.cos2);
    return {};
  };
  if (params.smooth) TRY(pass([&] { return SmoothRule(surface); }));
  if (params.feature) {
    out.tally.before_feature = creases_of(surface, limits.range_mm, context, part.own);
    TRY(pass([&] { return FeatureRule(surface, context); }));
    out.tally.after_feature = creases_of(surface, limits.range_mm, context, part.own);
  }
  if (context.cancel.is_set()) return fail(Code::Cancelled, "cancelled while swapping edges");
  write_own(surface, part, out);
  // An edge at an own vertex is judged by what lies at most three edges from it; and the triangles there are whole only
  // where one edge more is there.
  out.tally.is_sure = part.reach_mm > 4 * longest;
  const Sides sides = sides_of(part, witness, 3 * longest);
  for (const std::uint32_t block : sides.own) out.own.push_back(witness.blocks()[block]);
  for (const std::uint32_t block : sides.watched) out.watched.push_back(witness.blocks()[block]);
  out.events = witness.events([&](std::uint32_t block) {
    return std::binary_search(sides.own.begin(), sides.own.end(), block) ||
           std::binary_search(sides.watched.begin(), sides.watched.end(), block);
  });
  out.rounds = std::move(witness.rounds());
  return out;
}

}  // namespace scanmill::optimise
