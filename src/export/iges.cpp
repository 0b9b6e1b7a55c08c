// SPDX-License-Identifier: Apache-2.0
#include "export/iges.hpp"

#include <algorithm>
#include <cmath>

#include "base/text.hpp"
#include "export/comparing_sink.hpp"
#include "export/iges_lines.hpp"
#include "export/iges_plan.hpp"
#include "export/iges_surfaces.hpp"

namespace scanmill::exporting {
namespace {

constexpr std::string_view kStyles[] = {"brep", "trimmed", "patches", "wire", "surfaces"};
// Lines per triangle of the fuller section, of a large closed mesh (half a vertex and one and a half edges each).
constexpr double kLinesPerTriangle[] = {12, 14, 5, 3, 0.3};

/// What the receiver is to take for equal: a ten-thousandth of the bin (of the mean edge where no bin is known), never
/// above a tenth of the shortest edge, as a power of ten.
double resolution_of(const Mesh& mesh, const IgesOptions& options) {
  if (options.style == IgesStyle::Surfaces) return options.surfaces->quantum_mm;
  double least2 = 0, sum = 0;
  std::uint64_t edges = 0;
  for (const Triangle& t : mesh.triangles)
    for (std::size_t e = 0; e < 3; ++e) {
      const double length2 = norm2(mesh.positions[t[(e + 1) % 3]] - mesh.positions[t[e]]);
      if (!(length2 > 0)) continue;
      if (edges == 0 || length2 < least2) least2 = length2;
      sum += std::sqrt(length2);
      ++edges;
    }
  const double detail = options.bin_mm.value_or(edges > 0 ? sum / static_cast<double>(edges) : 1);
  double wanted = detail / 1e4;
  if (edges > 0) wanted = std::min(wanted, std::sqrt(least2) / 10);
  double resolution = 1;
  for (const double step : {1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12})
    if (resolution > wanted) resolution = step;
  return resolution;
}

void put_global(const Mesh& mesh, const IgesOptions& options, IgesHeader& global) {
  double largest = 0;
  for (const Vec3& p : mesh.positions) largest = std::max({largest, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
  put_iges_global(global, "mesh", resolution_of(mesh, options), largest);
}

/// The fit of each surface, for whoever opens the file in an editor.
void put_fit(const FittedSurfaces& fitted, IgesHeader& start) {
  auto mm = [&](double value) { return number_text(std::floor(value / fitted.quantum_mm + 0.5) * fitted.quantum_mm); };
  start.free_text("tolerance_mm " + number_text(fitted.tolerance_mm) + ", gap_mm " + mm(fitted.gap_mm));
  for (std::size_t c = 0; c < fitted.charts.size(); ++c)
    start.free_text("surface_" + std::to_string(c) + " max_mm " + mm(fitted.charts[c].max_mm) + " rms_mm " +
                    mm(fitted.charts[c].rms_mm) + " points " + std::to_string(fitted.charts[c].samples));
}

Error too_many_lines(const IgesPlan& plan, std::uint64_t directory, std::uint64_t parameters, const std::string& name) {
  const std::uint64_t triangles = plan.mesh.triangles.size();
  const auto style = static_cast<std::size_t>(plan.options.style);
  std::string sentence = "style " + std::string(kStyles[style]) + " needs " + grouped(directory) + " directory lines" +
                         (parameters > 0 ? " and " + grouped(parameters) + " parameter lines" : "") + " for " +
                         counted(triangles, "triangle") + "; IGES numbers them with seven digits, so " +
                         grouped(kIgesLines) + " at most";
  auto fits = [&](std::size_t other) {
    return static_cast<double>(triangles) * kLinesPerTriangle[other] < static_cast<double>(kIgesLines);
  };
  const std::uint64_t fitting =
      static_cast<std::uint64_t>(static_cast<double>(kIgesLines) / kLinesPerTriangle[style]) / 1000 * 1000;
  sentence += ": choose a larger bin (about " + grouped(fitting) + " triangles fit)";
  for (const std::size_t other : {std::size_t{2}, std::size_t{3}, std::size_t{4}})
    if (other != style && fits(other)) sentence += ", style " + std::string(kStyles[other]);
  return fail(Code::Unsupported, sentence + ", or 3mf, stl or ply", name);
}

}  // namespace

std::span<const std::string_view> iges_style_words() { return kStyles; }

Result<IgesCounts> write_iges(const Mesh& mesh, const IgesOptions& options, ByteSink& sink) {
  TRY_ASSIGN(IgesPlan plan, iges_plan_of(mesh, options, sink.name()));
  IgesCounts counts = iges_counts_of(plan);
  counts.directory_lines = 2 * iges_entities_of(plan);
  if (counts.directory_lines > kIgesLines) return too_many_lines(plan, counts.directory_lines, 0, sink.name());
  iges_add_positions(plan);
  IgesCounter counter;
  TRY(emit_iges(plan, counter));
  counts.parameter_lines = counter.total();
  if (2 * counter.lines().size() != counts.directory_lines)
    return fail(
        Code::Internal,
        grouped(counter.lines().size()) + " entities came, " + grouped(counts.directory_lines / 2) + " were announced",
        sink.name());
  if (counts.parameter_lines > kIgesLines)
    return too_many_lines(plan, counts.directory_lines, counts.parameter_lines, sink.name());

  TextBuffer out(sink);
  IgesHeader start(out, 'S'), global(out, 'G');
  start.free_text("scanmill mesh, units mm, style " + std::string(kStyles[static_cast<std::size_t>(options.style)]));
  if (!(mesh.offset == Vec3{}))
    start.free_text("offset_mm " + number_text(mesh.offset.x) + " " + number_text(mesh.offset.y) + " " +
                    number_text(mesh.offset.z));
  if (options.style == IgesStyle::Surfaces) put_fit(*options.surfaces, start);
  put_global(mesh, options, global);
  counts.bytes = 81 * (start.lines() + global.lines() + counts.directory_lines + counts.parameter_lines + 1);
  if (options.forecast_only) return counts;
  IgesDirectory directory(out, counter.lines());
  TRY(emit_iges(plan, directory));
  IgesParameters parameters(out);
  TRY(emit_iges(plan, parameters));
  put_iges_terminate(out, start.lines(), global.lines(), counts.directory_lines, counts.parameter_lines);
  TRY(out.flush());
  return counts;
}

Result<void> compare_iges(const Mesh& mesh, const IgesOptions& options, const ByteSource& source) {
  ComparingSink sink(source);
  TRY(write_iges(mesh, options, sink));
  return sink.commit();
}

}  // namespace scanmill::exporting
