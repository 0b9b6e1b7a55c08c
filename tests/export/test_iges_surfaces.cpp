// SPDX-License-Identifier: Apache-2.0
// Fitted surfaces and sections as IGES, by a reader of our own and splines evaluated from the file alone.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "export/iges.hpp"
#include "export/section_files.hpp"
#include "support/iges_reader.hpp"

namespace scanmill::exporting {
namespace {

using support::IgesEntity;
using support::IgesFile;

double real(const std::string& text) {
  std::string plain = text;
  std::replace(plain.begin(), plain.end(), 'D', 'e');
  return std::stod(plain);
}

/// A B-spline (126, 128 in one direction) by its definition, without any of ours.
double basis(const std::vector<double>& knots, std::size_t i, int degree, double t) {
  if (degree == 0) {
    const bool last = t == knots.back() && knots[i + 1] == t && knots[i] < t;
    return (knots[i] <= t && t < knots[i + 1]) || last ? 1 : 0;
  }
  const auto d = static_cast<std::size_t>(degree);
  double value = 0;
  if (knots[i + d] > knots[i]) value += (t - knots[i]) / (knots[i + d] - knots[i]) * basis(knots, i, degree - 1, t);
  if (knots[i + d + 1] > knots[i + 1])
    value += (knots[i + d + 1] - t) / (knots[i + d + 1] - knots[i + 1]) * basis(knots, i + 1, degree - 1, t);
  return value;
}

struct FileSurface {
  std::vector<double> u, v;
  int degree_u = 0, degree_v = 0;
  std::vector<Vec3> poles;
  explicit FileSurface(const IgesEntity& entity) {
    std::size_t next = 0;
    auto integer = [&] { return std::stoi(entity.parameters.at(next++)); };
    auto number = [&] { return real(entity.parameters.at(next++)); };
    const int k1 = integer(), k2 = integer();
    degree_u = integer(), degree_v = integer();
    EXPECT_EQ(entity.parameters.at(6), "1") << "polynomial";
    next += 5;
    for (int k = 0; k < k1 + degree_u + 2; ++k) u.push_back(number());
    for (int k = 0; k < k2 + degree_v + 2; ++k) v.push_back(number());
    for (int k = 0; k < (k1 + 1) * (k2 + 1); ++k) EXPECT_EQ(number(), 1) << "weights";
    for (int k = 0; k < (k1 + 1) * (k2 + 1); ++k) {
      const double x = number(), y = number();
      poles.push_back({x, y, number()});
    }
    EXPECT_EQ(number(), u.front());
    EXPECT_EQ(number(), u.back());
    EXPECT_EQ(number(), v.front());
    EXPECT_EQ(number(), v.back());
    EXPECT_EQ(next, entity.parameters.size());
  }
  Vec3 at(double a, double b) const {
    const std::size_t across = u.size() - static_cast<std::size_t>(degree_u) - 1;
    Vec3 sum;
    for (std::size_t k = 0; k < poles.size(); ++k)
      sum += poles[k] * (basis(u, k % across, degree_u, a) * basis(v, k / across, degree_v, b));
    return sum;
  }
};

/// The places of a curve 126 of degree 1.
std::vector<Vec3> polyline(const IgesEntity& entity) {
  const int count = std::stoi(entity.parameters.at(0)) + 1;
  EXPECT_EQ(entity.parameters.at(1), "1") << "degree";
  std::size_t next = 6 + static_cast<std::size_t>(count) + 2;
  std::vector<Vec3> places;
  for (int k = 0; k < count; ++k) EXPECT_EQ(real(entity.parameters.at(next++)), 1);
  for (int k = 0; k < count; ++k) {
    const double x = real(entity.parameters.at(next)), y = real(entity.parameters.at(next + 1));
    places.push_back({x, y, real(entity.parameters.at(next + 2))});
    next += 3;
  }
  EXPECT_EQ(real(entity.parameters.at(next)), 0);
  EXPECT_EQ(real(entity.parameters.at(next + 1)), count - 1);
  EXPECT_EQ(entity.parameters.size(), next + 5);
  return places;
}

/// A saddle of 3 x 2 spans over a square with a square hole, and a facet.
FittedSurfaces saddle() {
  FittedSurfaces fitted;
  fitted.quantum_mm = 0.001;
  fitted.tolerance_mm = 0.25;
  FittedChart chart;
  chart.surface.u = {3, 2.5};
  chart.surface.v = {2, 4.125};
  auto height = [](double u, double v) { return 0.1 * u * v - 1; };
  for (std::size_t j = 0; j < chart.surface.v.poles(); ++j)
    for (std::size_t i = 0; i < chart.surface.u.poles(); ++i) {
      const double u = chart.surface.u.greville(i), v = chart.surface.v.greville(j);
      chart.surface.poles.push_back({u, v, height(u, v)});
    }
  for (const auto& corners :
       {std::vector<Uv>{{1, 1}, {6, 1}, {6, 7}, {1, 7}}, std::vector<Uv>{{3, 3}, {3, 4}, {4, 4}}}) {
    TrimLoop& loop = chart.loops.emplace_back();
    for (const Uv& p : corners) {
      loop.parameters.push_back(p);
      loop.places.push_back({p.u, p.v, height(p.u, p.v)});
    }
  }
  chart.triangles = {0};
  fitted.charts.push_back(chart);
  fitted.facets = {1};
  fitted.corners.push_back({Vec3{0, 0, 0}, Vec3{1.25, 0, 0}, Vec3{0, 1.5, 0.001}});
  return fitted;
}

Mesh two_triangles() {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
  mesh.triangles = {{0, 1, 2}, {1, 3, 2}};
  return mesh;
}

std::string written(const FittedSurfaces& fitted, IgesCounts& counts) {
  std::string bytes;
  const auto sink = memory_sink("mesh.igs", bytes);
  IgesOptions options;
  options.style = IgesStyle::Surfaces;
  options.surfaces = &fitted;
  const auto done = write_iges(two_triangles(), options, *sink);
  EXPECT_TRUE(done.ok()) << (done.ok() ? "" : done.error().text());
  EXPECT_TRUE(sink->commit().ok());
  if (done.ok()) counts = *done;
  return bytes;
}

TEST(IgesSurfaces, HoldTheSplineAndItsBordersTwice) {
  IgesCounts counts;
  const IgesFile file = support::read_iges(written(saddle(), counts));
  ASSERT_TRUE(file.faults.empty()) << file.faults[0];
  EXPECT_EQ(static_cast<std::uint64_t>(file.directory_lines), counts.directory_lines);
  EXPECT_EQ(static_cast<std::uint64_t>(file.parameter_lines), counts.parameter_lines);
  EXPECT_EQ(counts.surfaces, 1u);
  EXPECT_EQ(counts.faces, 2u);
  EXPECT_EQ(file.count(144), 1u);
  EXPECT_EQ(file.count(142), 2u);
  EXPECT_EQ(file.count(126), 4u);
  EXPECT_EQ(file.count(128), 2u);
  EXPECT_EQ(file.count(402, 7), 1u);
  for (const auto& [number, trimmed] : file.entities) {
    if (trimmed.type != 144) continue;
    EXPECT_EQ(trimmed.level, 1);
    EXPECT_EQ(trimmed.parameters.at(2), "1") << "one hole";
    const IgesEntity& spline = file.entities.at(std::stol(trimmed.parameters.at(0)));
    const FileSurface surface(spline);
    EXPECT_EQ(surface.degree_u, 3);
    EXPECT_EQ(surface.poles.size(), 30u);
    for (const std::size_t loop : {3, 4}) {
      const IgesEntity& on = file.entities.at(std::stol(trimmed.parameters.at(loop)));
      ASSERT_EQ(on.type, 142);
      EXPECT_EQ(on.parameters.at(1), trimmed.parameters.at(0));
      const auto flat = polyline(file.entities.at(std::stol(on.parameters.at(2))));
      const auto space = polyline(file.entities.at(std::stol(on.parameters.at(3))));
      EXPECT_EQ(file.entities.at(std::stol(on.parameters.at(2))).status, "00010500");
      ASSERT_EQ(flat.size(), loop == 3 ? 5u : 4u) << "closed";
      ASSERT_EQ(space.size(), flat.size());
      EXPECT_EQ(flat.front(), flat.back());
      for (std::size_t k = 0; k < flat.size(); ++k)
        EXPECT_LT(norm(surface.at(flat[k].x, flat[k].y) - space[k]), 2e-3) << "multiples of 0.001 mm";
    }
  }
}

TEST(IgesSurfaces, HoldFacetsAsTheyAreAndNameEverything) {
  IgesCounts counts;
  const std::string bytes = written(saddle(), counts);
  const IgesFile file = support::read_iges(bytes);
  for (const auto& [number, entity] : file.entities)
    if (entity.type == 128 && entity.level == 2) {
      const FileSurface facet(entity);
      EXPECT_EQ(facet.poles, (std::vector<Vec3>{{0, 0, 0}, {1.25, 0, 0}, {0, 1.5, 0.001}, {0, 1.5, 0.001}}));
    }
  EXPECT_NE(bytes.find("9Hsurface_0"), std::string::npos);
  EXPECT_NE(bytes.find("6Hfacets"), std::string::npos);
  EXPECT_NE(bytes.find("surface_0 max_mm 0 rms_mm 0 points 0"), std::string::npos) << "the fit, for people";
  IgesCounts again;
  EXPECT_EQ(written(saddle(), again), bytes);
}

TEST(IgesSurfaces, HoldLargeSplines) {
  FittedSurfaces fitted = saddle();
  SplineSurface& surface = fitted.charts[0].surface;
  surface.u = {120, 0.1};
  surface.v = {120, 0.1};
  surface.poles.assign(surface.u.poles() * surface.v.poles(), {-123.456, 234.567, -345.678});
  IgesCounts counts;
  const std::string bytes = written(fitted, counts);
  const IgesFile file = support::read_iges(bytes);
  EXPECT_TRUE(file.faults.empty());
  EXPECT_EQ(bytes.size(), counts.bytes);
  EXPECT_GT(bytes.size(), 400'000u) << "more than a buffer";
}

TEST(IgesSurfaces, AreWantedByTheirStyle) {
  std::string bytes;
  const auto sink = memory_sink("mesh.igs", bytes);
  IgesOptions options;
  options.style = IgesStyle::Surfaces;
  EXPECT_EQ(write_iges(two_triangles(), options, *sink).error().code, Code::Internal);
}

TEST(IgesSections, HoldTheLinesInSpaceToTheLastBit) {
  Section section;
  section.frame = {"x = 2 mm", {2, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 0}, 1};
  section.lines.push_back({{{0.1, 0.2}, {1.0 / 3, 0.2}, {0.7, 1.1}}, true});
  section.lines.push_back({{{5, 5}, {6, 6.5}}, false});
  section.lines.push_back({{{9, 9}}, false});
  Section other = section;
  other.frame.name = "none";
  other.lines.clear();
  const std::vector<Section> sections{section, other};
  std::string bytes;
  const auto sink = memory_sink("sections.igs", bytes);
  ASSERT_TRUE(write_sections_iges(sections, *sink).ok());
  ASSERT_TRUE(sink->commit().ok());
  const IgesFile file = support::read_iges(bytes);
  ASSERT_TRUE(file.faults.empty()) << file.faults[0];
  ASSERT_EQ(file.count(126), 2u) << "a place is no line";
  EXPECT_EQ(file.count(402, 7), 2u);
  EXPECT_NE(bytes.find("section_1: x = 2 mm"), std::string::npos);
  std::vector<std::vector<Vec3>> lines;
  for (const auto& [number, entity] : file.entities)
    if (entity.type == 126) {
      lines.push_back(polyline(entity));
      EXPECT_EQ(entity.level, 1);
      EXPECT_EQ(entity.parameters.at(2), "1") << "in a plane";
    }
  ASSERT_EQ(lines[0].size(), 4u);
  for (std::size_t k = 0; k < 4; ++k) EXPECT_EQ(lines[0][k], section.frame.place(section.lines[0].points[k % 3]));
  EXPECT_EQ(lines[1], (std::vector<Vec3>{{2, 5, 5}, {2, 6, 6.5}}));
}

}  // namespace
}  // namespace scanmill::exporting
