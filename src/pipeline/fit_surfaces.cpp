// SPDX-License-Identifier: Apache-2.0
#include "pipeline/fit_surfaces.hpp"

#include <algorithm>
#include <cmath>

#include "base/text.hpp"
#include "surfaces/surfaces.hpp"
#include "verify/on_triangles.hpp"

namespace scanmill::pipeline {
namespace {

constexpr std::uint64_t kMostPoints = 4'000'000;

/// To a thousandth.
std::string mm_text(double mm) { return number_text(std::floor(mm * 1000 + 0.5) / 1000); }

std::string percent_text(double share) { return number_text(std::floor(share * 1e4 + 0.5) / 100); }

}  // namespace

const Output* surfaces_output(const std::vector<Output>& outputs) {
  const auto at = std::find_if(outputs.begin(), outputs.end(),
                               [](const Output& o) { return o.format == "iges" && o.style == "surfaces"; });
  return at == outputs.end() ? nullptr : &*at;
}

Result<ScanSurfaces> fit_scan_surfaces(const Mesh& mesh, const PointSource& points, const Output& output, double bin_mm,
                                       const Context& context, Progress& progress) {
  progress.stage("surfaces", 0, 0);
  TRY_ASSIGN(verify::PointsOnTriangles found, verify::points_on_triangles(mesh, points, bin_mm, kMostPoints, context));
  ScanSurfaces surfaces;
  surfaces.step = found.step;
  surfaces.bin_mm = bin_mm;
  TRY_ASSIGN(surfaces.fitted,
             surfaces::fit_surfaces(mesh, {std::move(found.places), std::move(found.triangle), found.left_out},
                                    {output.tolerance_bins}, bin_mm, context));
  return surfaces;
}

Result<ScanSurfaces> fit_mesh_surfaces(const Mesh& mesh, const Output& output, const Context& context) {
  double sum = 0;
  std::uint64_t edges = 0;
  for (const Triangle& t : mesh.triangles)
    for (std::size_t e = 0; e < 3; ++e, ++edges) sum += norm(mesh.positions[t[(e + 1) % 3]] - mesh.positions[t[e]]);
  ScanSurfaces surfaces;
  surfaces.bin_mm = edges > 0 ? sum / static_cast<double>(edges) : 0;
  TRY_ASSIGN(surfaces.fitted, surfaces::fit_surfaces(mesh, surfaces::samples_of(mesh), {output.tolerance_bins},
                                                     surfaces.bin_mm, context));
  return surfaces;
}

std::string surfaces_note(const ScanSurfaces& surfaces, const std::string& file) {
  const FittedSurfaces& fitted = surfaces.fitted;
  const double share = fitted.area_mm2 > 0 ? fitted.fitted_area_mm2 / fitted.area_mm2 : 0;
  const std::string judges = surfaces.step == 0   ? "the mesh's vertices"
                             : surfaces.step == 1 ? "the cloud"
                                                  : "every " + std::to_string(surfaces.step) +
                                                        (surfaces.step == 2   ? "nd"
                                                         : surfaces.step == 3 ? "rd"
                                                                              : "th") +
                                                        " point of the cloud";
  if (fitted.charts.empty())
    return file + " holds " + counted(fitted.corners.size(), "triangle") +
           " and no B-spline surface: the mesh is too coarse or too rough for surfaces within " +
           mm_text(fitted.tolerance_mm) + " mm; style brep says the same in a form that CAD programs take better";
  const char* wide =
      fitted.gap_mm > 2 * fitted.tolerance_mm
          ? ", more than twice the tolerance: look at the edges before the file is used, or write style brep"
          : "";
  return file + " holds " + counted(fitted.charts.size(), "B-spline surface") + " over " + percent_text(share) +
         " % of the area, within " + mm_text(fitted.tolerance_mm) + " mm of " + judges + " (greatest distance " +
         mm_text(fitted.max_mm) + ", rms " + mm_text(fitted.rms_mm) + " mm), and " + percent_text(1 - share) +
         " % as facets (" + counted(fitted.corners.size(), "triangle") +
         "); along their borders surfaces are at most " + mm_text(fitted.gap_mm) + " mm apart" + wide;
}

}  // namespace scanmill::pipeline
