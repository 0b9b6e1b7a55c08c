// SPDX-License-Identifier: Apache-2.0
// Our IGES in an independent CAD kernel: solids, shells, faces, validity, area and volume.
#include <gtest/gtest.h>

#include <cmath>

#include "export/iges.hpp"
#include "export/section_files.hpp"
#include "export/shells.hpp"
#include "pipeline/discovery.hpp"
#include "pipeline/fit_surfaces.hpp"
#include "pipeline/mesh_files.hpp"
#include "pipeline/scan_points.hpp"
#include "simulate/demo_plans.hpp"
#include "store/files.hpp"
#include "support/meshing.hpp"
#include "support/occt_shapes.hpp"
#include "support/shapes.hpp"
#include "support/temp_folder.hpp"
#include "verify/sections.hpp"

namespace scanmill {
namespace {

using exporting::IgesStyle;

struct Known {
  double area = 0, volume = 0, edge_length = 0;
  std::size_t solids = 0, open_shells = 0, edges = 0;
};

Known known_of(const Mesh& mesh) {
  Known known;
  for (const Triangle& t : mesh.triangles)
    known.area +=
        norm(cross(mesh.positions[t[1]] - mesh.positions[t[0]], mesh.positions[t[2]] - mesh.positions[t[0]])) / 2;
  const exporting::Shells shells = exporting::shells_of(mesh);
  known.edges = shells.edges.size();
  for (const auto& [a, b] : shells.edges) known.edge_length += norm(mesh.positions[b] - mesh.positions[a]);
  for (const exporting::Shell& shell : shells.shells) {
    (shell.closed ? known.solids : known.open_shells) += 1;
    if (shell.closed) known.volume += shell.volume_mm3;
  }
  return known;
}

support::CadShape through_occt(const Mesh& mesh, IgesStyle style) {
  const support::TempFolder folder;
  const std::string path = folder.path() + "/mesh.igs";
  auto sink = store::create_file(path);
  EXPECT_TRUE(sink.ok());
  const auto counts = exporting::write_iges(mesh, {style, {}}, **sink);
  EXPECT_TRUE(counts.ok()) << counts.error().text();
  EXPECT_TRUE((*sink)->commit().ok());
  return support::read_with_occt(path);
}

void expect_brep(const Mesh& mesh) {
  const Known known = known_of(mesh);
  const support::CadShape shape = through_occt(mesh, IgesStyle::Brep);
  ASSERT_TRUE(shape.readable);
  EXPECT_TRUE(shape.valid);
  EXPECT_EQ(shape.solids, static_cast<int>(known.solids));
  EXPECT_EQ(shape.shells, static_cast<int>(known.solids + known.open_shells));
  EXPECT_EQ(shape.roots, static_cast<int>(known.solids + known.open_shells));
  EXPECT_EQ(shape.faces, static_cast<int>(mesh.triangles.size()));
  EXPECT_EQ(shape.edges, static_cast<int>(known.edges)) << "edges are shared";
  EXPECT_NEAR(shape.area / known.area, 1, 1e-9);
  if (known.open_shells == 0) {
    EXPECT_NEAR(shape.volume / known.volume, 1, 1e-9);
  }
  std::cout << mesh.triangles.size() << " triangles: " << shape.solids << " solids, " << shape.shells
            << " shells, area " << std::abs(shape.area / known.area - 1) << " off\n";
}

void expect_other_styles(const Mesh& mesh) {
  const Known known = known_of(mesh);
  for (const IgesStyle style : {IgesStyle::Trimmed, IgesStyle::Patches}) {
    const support::CadShape shape = through_occt(mesh, style);
    ASSERT_TRUE(shape.readable);
    EXPECT_EQ(shape.faces, static_cast<int>(mesh.triangles.size()));
    EXPECT_NEAR(shape.area / known.area, 1, 1e-9) << static_cast<int>(style);
  }
  const support::CadShape wire = through_occt(mesh, IgesStyle::Wire);
  EXPECT_EQ(wire.edges, static_cast<int>(known.edges));
  EXPECT_EQ(wire.faces, 0);
  EXPECT_NEAR(wire.line_length / known.edge_length, 1, 1e-9);
}

Result<Mesh> mesh_of_shape(const std::string& name, double h) {
  const auto what = support::what_of(h);
  TRY_ASSIGN(auto meshed, support::mesh_points(support::shape_named(name).points(h), what, 2));
  return std::move(meshed.surface.mesh);
}

Mesh demo_mesh(const std::string& name, double h) {
  const auto object = simulate::make_object(name);
  const support::Workers workers(2);
  auto points = simulate::measured_points(**object, simulate::demo_plan(name), workers.context());
  return std::move(support::mesh_points(std::move(points), support::what_of(h), 2).value().surface.mesh);
}

TEST(OcctReadsBrep, OfClosedShapesAsValidSolids) {
  for (const char* name : {"sphere", "torus"}) {
    SCOPED_TRACE(name);
    const auto mesh = mesh_of_shape(name, 1);
    ASSERT_TRUE(mesh.ok()) << mesh.error().text();
    expect_brep(*mesh);
  }
}

TEST(OcctReadsBrep, OfDemoSolids) {
  for (const char* name : {"figurine", "handset"}) {
    SCOPED_TRACE(name);
    const Mesh mesh = demo_mesh(name, name[0] == 'f' ? 1.0 : 2.0);
    expect_brep(mesh);
    if (name[0] == 'h') {
      EXPECT_GT(known_of(mesh).open_shells, 0u) << "its bottom was not seen";
      expect_other_styles(mesh);
    }
  }
}

/// The cloud of a demo solid, fitted as a job does, in a file of style surfaces, beside one of style brep.
void expect_surfaces(const std::string& name, double h) {
  const auto object = simulate::make_object(name);
  const support::Workers workers(2);
  const std::vector<Vec3> cloud = simulate::measured_points(**object, simulate::demo_plan(name), workers.context());
  const Mesh mesh = std::move(support::mesh_points(cloud, support::what_of(h), 2).value().surface.mesh);
  NoProgress silent;
  pipeline::Output output{"iges", false, "surfaces"};
  const auto surfaces = pipeline::fit_scan_surfaces(mesh, MemoryPoints(cloud), output, h, workers.context(), silent);
  ASSERT_TRUE(surfaces.ok()) << surfaces.error().text();
  const FittedSurfaces& fitted = surfaces->fitted;
  EXPECT_GT(fitted.fitted_area_mm2, 0.9 * fitted.area_mm2);
  EXPECT_LE(fitted.max_mm, 0.25 * h);
  EXPECT_LE(fitted.gap_mm, 0.25 * h);
  const support::TempFolder folder;
  const auto small = pipeline::write_mesh_file(mesh, output, {}, folder.path() + "/mesh.igs", h, &*surfaces);
  const auto large = pipeline::write_mesh_file(mesh, {"iges", false, "brep"}, {}, folder.path() + "/brep.igs", h);
  ASSERT_TRUE(small.ok() && large.ok());
  EXPECT_LT(static_cast<double>(small->bytes), 0.02 * static_cast<double>(large->bytes));
  const support::CadShape shape = support::read_with_occt(folder.path() + "/mesh.igs");
  ASSERT_TRUE(shape.readable);
  EXPECT_EQ(shape.invalid_faces, 0);
  EXPECT_EQ(shape.faces, static_cast<int>(fitted.charts.size() + fitted.corners.size()));
  EXPECT_NEAR(shape.area / known_of(mesh).area, 1, 0.05) << "sharp edges come back: more area than the mesh's";
  const bool closed = known_of(mesh).open_shells == 0;
  const int open = support::open_edges_with_occt(folder.path() + "/mesh.igs", 0.25 * h);
  if (closed)
    EXPECT_EQ(open, 0) << "sewn, it is closed";
  else
    EXPECT_GT(open, 0);
  std::cout << small->notes.at(0) << "; " << small->bytes << " bytes, "
            << 100.0 * static_cast<double>(small->bytes) / static_cast<double>(large->bytes) << " % of brep, "
            << shape.faces << " faces, " << shape.invalid_faces << " invalid, " << open << " open edges when sewn\n";
}

TEST(OcctReadsSurfaces, OfTheFigurine) { expect_surfaces("figurine", 1); }
TEST(OcctReadsSurfaces, OfTheHandset) { expect_surfaces("handset", 2); }

TEST(OcctReadsSections, AsCurvesOfTheirLength) {
  const auto mesh = mesh_of_shape("torus", 1);
  ASSERT_TRUE(mesh.ok());
  verify::SectionRule rule;
  rule.axis = {0, 0.6, 0.8};
  rule.count = 3;
  rule.where = verify::SectionRule::Where::Count;
  std::vector<double> magnify;
  const auto frames = verify::section_frames(*mesh, {{rule}}, 1, {}, magnify);
  ASSERT_TRUE(frames.ok());
  const support::Workers workers(1);
  const auto sections = verify::sections_of(*mesh, MemoryPoints({}), *frames, magnify, 1, workers.context());
  ASSERT_TRUE(sections.ok());
  double length = 0;
  for (const Section& section : *sections) length += section.length_mm;
  const support::TempFolder folder;
  auto sink = store::create_file(folder.path() + "/sections.igs");
  ASSERT_TRUE(exporting::write_sections_iges(*sections, **sink).ok());
  ASSERT_TRUE((*sink)->commit().ok());
  const support::CadShape shape = support::read_with_occt(folder.path() + "/sections.igs");
  ASSERT_TRUE(shape.readable);
  EXPECT_GT(length, 50);
  EXPECT_NEAR(shape.line_length / length, 1, 1e-9);
}

class OcctReadsBunny : public testing::TestWithParam<int> {};

TEST_P(OcctReadsBunny, AsBrepAndInEveryOtherStyle) {
  const std::string archive = support::data_folder() + "/range-views/bunny";
  if (!store::is_folder(archive)) GTEST_SKIP() << "no " << archive;
  const support::Workers workers(2);
  const auto found = pipeline::discover(archive, false);
  ASSERT_TRUE(found.ok()) << found.error().text();
  const auto points = pipeline::ScanPoints::open(archive, found->scans.front(), 1000);
  ASSERT_TRUE(points.ok()) << points.error().text();
  document::Node tree = document::Node::map();
  tree.set("lattice", document::Node::map()).set("target_points", GetParam() / 2);
  const auto what = pipeline::what_from(tree, "test");
  ASSERT_TRUE(what.ok()) << what.error().text();
  const auto meshed = support::mesh_cloud(**points, *what, 2);
  ASSERT_TRUE(meshed.ok()) << meshed.error().text();
  const Mesh& mesh = meshed->surface.mesh;
  EXPECT_NEAR(static_cast<double>(mesh.triangles.size()), GetParam(), 0.2 * GetParam());
  expect_brep(mesh);
  if (GetParam() < 10000) expect_other_styles(mesh);
}

INSTANTIATE_TEST_SUITE_P(Triangles, OcctReadsBunny, testing::Values(2000, 6000, 60000));

}  // namespace
}  // namespace scanmill
