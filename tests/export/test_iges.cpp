// SPDX-License-Identifier: Apache-2.0
// IGES by a reader of our own that shares nothing with the writer: structure, counts, areas, what is refused.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "export/iges.hpp"
#include "export/shells.hpp"
#include "support/iges_reader.hpp"

namespace scanmill::exporting {
namespace {

using support::IgesFile;
using support::IgesShape;

/// A sphere of `rings` rings with float32 corners; patches are quarters of its height.
Mesh sphere(int rings, Vec3 centre = {}, double radius = 10) {
  Mesh mesh;
  const int around = 2 * rings;
  auto add = [&](double z, double turn, double r) {
    const Vec3 p{centre.x + r * std::cos(turn), centre.y + r * std::sin(turn), centre.z + z};
    mesh.positions.push_back({static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)});
  };
  add(-radius, 0, 0);
  for (int i = 1; i < rings; ++i)
    for (int k = 0; k < around; ++k)
      add(-radius * std::cos(M_PI * i / rings), 2 * M_PI * k / around, radius * std::sin(M_PI * i / rings));
  add(radius, 0, 0);
  auto at = [&](int i, int k) { return static_cast<std::uint32_t>(1 + (i - 1) * around + k % around); };
  auto face = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, int ring) {
    while (a > b || a > c) std::swap(a, b), std::swap(b, c);
    mesh.triangles.push_back({a, b, c});
    mesh.patch.push_back(static_cast<std::uint32_t>(4 * ring / rings));
  };
  for (int k = 0; k < around; ++k) {
    face(0, at(1, k + 1), at(1, k), 0);
    for (int i = 1; i + 1 < rings; ++i) {
      face(at(i, k), at(i, k + 1), at(i + 1, k), i);
      face(at(i, k + 1), at(i + 1, k + 1), at(i + 1, k), i);
    }
    face(at(rings - 1, k), at(rings - 1, k + 1), static_cast<std::uint32_t>(mesh.positions.size() - 1), rings - 1);
  }
  return mesh;
}

Mesh joined(const Mesh& a, const Mesh& b) {
  Mesh both = a;
  const auto shift = static_cast<std::uint32_t>(a.positions.size());
  both.positions.insert(both.positions.end(), b.positions.begin(), b.positions.end());
  for (const Triangle& t : b.triangles) both.triangles.push_back({t[0] + shift, t[1] + shift, t[2] + shift});
  both.patch.insert(both.patch.end(), b.patch.begin(), b.patch.end());
  return both;
}

Mesh without_top(Mesh mesh) {
  for (std::size_t t = mesh.triangles.size(); t-- > 0;)
    if (mesh.patch[t] == 3) {
      mesh.triangles.erase(mesh.triangles.begin() + static_cast<std::ptrdiff_t>(t));
      mesh.patch.erase(mesh.patch.begin() + static_cast<std::ptrdiff_t>(t));
    }
  return mesh;
}

double area_of(const Mesh& mesh) {
  double area = 0;
  for (const Triangle& t : mesh.triangles)
    area += norm(cross(mesh.positions[t[1]] - mesh.positions[t[0]], mesh.positions[t[2]] - mesh.positions[t[0]])) / 2;
  return area;
}

std::string written(const Mesh& mesh, IgesStyle style, IgesCounts* counts = nullptr) {
  std::string bytes;
  const auto sink = memory_sink("mesh.igs", bytes);
  const auto done = write_iges(mesh, {style, 0.5}, *sink);
  EXPECT_TRUE(done.ok()) << (done.ok() ? "" : done.error().text());
  EXPECT_TRUE(sink->commit().ok());
  if (counts && done.ok()) *counts = *done;
  return bytes;
}

void expect_sound(const std::string& bytes, const IgesCounts& counts, IgesFile& file, IgesShape& shape) {
  file = support::read_iges(bytes);
  ASSERT_TRUE(file.faults.empty()) << file.faults[0];
  shape = support::shape_of(file);
  ASSERT_TRUE(shape.faults.empty()) << shape.faults[0];
  EXPECT_EQ(static_cast<std::uint64_t>(file.directory_lines), counts.directory_lines);
  EXPECT_EQ(static_cast<std::uint64_t>(file.parameter_lines), counts.parameter_lines);
  EXPECT_EQ(bytes.size(), counts.bytes);
  EXPECT_EQ(shape.faces.size(), counts.faces);
  EXPECT_EQ(shape.solids, counts.solids);
  EXPECT_EQ(shape.open_shells + shape.closed_shells, counts.shells);
}

TEST(IgesBrep, MakesASolidOfAClosedMesh) {
  const Mesh mesh = sphere(12);
  IgesCounts counts;
  IgesFile file;
  IgesShape shape;
  expect_sound(written(mesh, IgesStyle::Brep, &counts), counts, file, shape);
  EXPECT_EQ(shape.solids, 1u);
  EXPECT_EQ(shape.open_shells, 0u);
  ASSERT_EQ(shape.faces.size(), mesh.triangles.size());
  EXPECT_EQ(file.count(110), mesh.triangles.size() * 3 / 2) << "edges are shared";
  EXPECT_EQ(file.count(502), 1u);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t c = 0; c < 3; ++c)
      ASSERT_EQ(shape.faces[t][c], mesh.positions[mesh.triangles[t][c]]) << "to the last bit, triangle " << t;
  EXPECT_NEAR(shape.area / area_of(mesh), 1, 1e-14);
  EXPECT_NEAR(shape.volume / signed_volume(mesh), 1, 1e-14);
  EXPECT_LT(shape.greatest_plane_gap, 1e-13);
}

TEST(IgesBrep, GivesEachComponentItsRoot) {
  // A closed sphere, an open one, and one turned inside out.
  Mesh inside_out = sphere(6, {60, 0, 0});
  for (Triangle& t : inside_out.triangles) std::swap(t[1], t[2]);
  const Mesh mesh = joined(joined(without_top(sphere(8)), sphere(6, {30, 0, 0})), inside_out);
  IgesCounts counts;
  IgesFile file;
  IgesShape shape;
  expect_sound(written(mesh, IgesStyle::Brep, &counts), counts, file, shape);
  EXPECT_EQ(shape.solids, 1u);
  EXPECT_EQ(shape.open_shells, 1u);
  EXPECT_EQ(shape.closed_shells, 1u);
  EXPECT_EQ(counts.inside_out, 1u);
  EXPECT_EQ(file.count(514, 2), 1u);
  EXPECT_NEAR(shape.area / area_of(mesh), 1, 1e-14);
}

TEST(IgesBrep, GivesFacesLevelColourAndNameOfTheirPatch) {
  Mesh mesh = sphere(12);
  for (std::uint32_t& patch : mesh.patch) patch = 7 * patch + 1;
  for (const IgesStyle style : {IgesStyle::Brep, IgesStyle::Trimmed}) {
    IgesCounts counts;
    IgesFile file;
    IgesShape shape;
    expect_sound(written(mesh, style, &counts), counts, file, shape);
    ASSERT_EQ(shape.face_names.size(), mesh.triangles.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      EXPECT_EQ(shape.face_names[t], "patch_" + std::to_string(mesh.patch[t]));
      EXPECT_EQ(shape.face_levels[t], static_cast<long>(mesh.patch[t]) + 1);
      EXPECT_EQ(file.entities[shape.face_colours[t]].subscript, static_cast<long>(mesh.patch[t]));
    }
    EXPECT_EQ(file.count(314), 4u);
  }
}

TEST(IgesTrimmed, HoldsEveryTriangleAsATrimmedSurface) {
  const Mesh mesh = without_top(sphere(10));
  IgesCounts counts;
  IgesFile file;
  IgesShape shape;
  expect_sound(written(mesh, IgesStyle::Trimmed, &counts), counts, file, shape);
  EXPECT_EQ(file.count(144), mesh.triangles.size());
  EXPECT_EQ(file.count(110), 3 * mesh.triangles.size());
  EXPECT_NEAR(shape.area / area_of(mesh), 1, 1e-14);
}

TEST(IgesPatches, GroupsSurfacesByPatch) {
  const Mesh mesh = sphere(10);
  IgesCounts counts;
  IgesFile file;
  IgesShape shape;
  expect_sound(written(mesh, IgesStyle::Patches, &counts), counts, file, shape);
  EXPECT_EQ(file.count(402, 7), 4u);
  EXPECT_NEAR(shape.area / area_of(mesh), 1, 1e-14);
  std::size_t members = 0;
  for (const auto& [number, entity] : file.entities) {
    if (entity.type != 402) continue;
    const auto size = static_cast<std::size_t>(std::stol(entity.parameters[0]));
    members += size;
    for (std::size_t i = 0; i < size; ++i)
      EXPECT_EQ(file.entities[std::stol(entity.parameters[1 + i])].level, entity.level);
  }
  EXPECT_EQ(members, mesh.triangles.size());
}

TEST(IgesWire, HoldsEveryEdgeOnce) {
  const Mesh mesh = without_top(sphere(10));
  IgesCounts counts;
  IgesFile file;
  IgesShape shape;
  expect_sound(written(mesh, IgesStyle::Wire, &counts), counts, file, shape);
  double length = 0;
  for (const auto& [a, b] : shells_of(mesh).edges) length += norm(mesh.positions[b] - mesh.positions[a]);
  EXPECT_NEAR(shape.line_length / length, 1, 1e-14);
  EXPECT_EQ(file.count(110), counts.edges);
}

TEST(Iges, SaysUnitsResolutionAndAFixedDate) {
  const IgesFile file = support::read_iges(written(sphere(12), IgesStyle::Brep));
  ASSERT_EQ(file.global.size(), 25u);
  EXPECT_EQ(file.global[13], "2");
  EXPECT_EQ(file.global[14], "MM");
  EXPECT_EQ(file.global[17], "20000101.000000");
  EXPECT_EQ(file.global[18], "1.D-05") << "0.5 mm bins: not above 5e-5";
  EXPECT_EQ(file.global[19], "10.");
  EXPECT_EQ(file.global[22], "11");
}

TEST(Iges, GivesTheSameBytesTwiceAndReadsThemBack) {
  const Mesh mesh = joined(sphere(20), without_top(sphere(9, {40, 0, 0})));
  for (const IgesStyle style : {IgesStyle::Brep, IgesStyle::Trimmed, IgesStyle::Patches, IgesStyle::Wire}) {
    const std::string bytes = written(mesh, style);
    EXPECT_EQ(bytes, written(mesh, style));
    EXPECT_TRUE(compare_iges(mesh, {style, 0.5}, *memory_source("f", bytes)).ok());
    std::string bad = bytes;
    bad[bytes.size() / 2] = static_cast<char>(bad[bytes.size() / 2] ^ 1);
    const auto found = compare_iges(mesh, {style, 0.5}, *memory_source("f", bad));
    ASSERT_FALSE(found.ok());
    EXPECT_EQ(found.error().where, "f: byte " + std::to_string(bytes.size() / 2));
  }
}

TEST(Iges, SaysTheOffset) {
  Mesh mesh = sphere(6);
  mesh.offset = {4520000, -0.125, 0};
  const IgesFile file = support::read_iges(written(mesh, IgesStyle::Brep));
  ASSERT_EQ(file.start.size(), 2u);
  EXPECT_EQ(file.start[1], "offset_mm 4520000 -0.125 0");
}

TEST(Iges, WritesNumbersThatReadBackToTheSameDouble) {
  Mesh mesh = sphere(4);
  const double odd[] = {0.1f, -1e-30, 1e20, -0.0, 123456.789f, 3, 1e-7f};
  for (std::size_t v = 0; v + 1 < mesh.positions.size(); ++v)
    mesh.positions[v] = {odd[v % 7], odd[(v + 1) % 7], odd[v * 3 % 7] + static_cast<double>(v)};
  const IgesFile file = support::read_iges(written(mesh, IgesStyle::Wire));
  ASSERT_TRUE(file.faults.empty()) << file.faults[0];
  const IgesShape shape = support::shape_of(file);
  EXPECT_TRUE(shape.faults.empty()) << shape.faults[0];
  const auto edges = shells_of(mesh).edges;
  std::size_t e = 0;
  for (const auto& [number, entity] : file.entities) {
    if (entity.type != 110) continue;
    IgesShape ignored;
    for (std::size_t c = 0; c < 2; ++c) {
      std::string x = entity.parameters[3 * c];
      std::replace(x.begin(), x.end(), 'D', 'e');
      EXPECT_EQ(std::stod(x), mesh.positions[edges[e][c]].x);
    }
    ++e;
  }
}

TEST(IgesBrep, RefusesWhatIsNoManifold) {
  Mesh mesh = sphere(6);
  mesh.triangles.push_back(mesh.triangles[5]);
  mesh.patch.push_back(0);
  std::string bytes;
  const auto sink = memory_sink("mesh.igs", bytes);
  const auto fan = write_iges(mesh, {}, *sink);
  ASSERT_FALSE(fan.ok());
  EXPECT_EQ(fan.error().code, Code::BadInput);
  EXPECT_NE(fan.error().message.find("3 edges with more than two triangles, or two in one direction, the first near"),
            std::string::npos)
      << fan.error().text();
  mesh = sphere(6);
  mesh.positions[1] = mesh.positions[2];
  const auto flat = write_iges(mesh, {}, *sink);
  ASSERT_FALSE(flat.ok());
  EXPECT_NE(flat.error().message.find("triangles without area, the first is number"), std::string::npos)
      << flat.error().text();
  IgesCounts counts;
  (void)written(mesh, IgesStyle::Patches, &counts);
  EXPECT_EQ(counts.left_out, 2u);
  EXPECT_EQ(counts.faces, mesh.triangles.size() - 2);
  EXPECT_FALSE(write_iges(Mesh{}, {}, *sink).ok());
}

TEST(Iges, RefusesMoreLinesThanSevenDigitsNumber) {
  // A long strip; nothing is laid out before the count is known, so this costs little.
  Mesh mesh;
  const std::uint32_t count = 900'000;
  for (std::uint32_t v = 0; v < count + 2; ++v)
    mesh.positions.push_back(
        {static_cast<double>(v % 1000), static_cast<double>(v / 1000), static_cast<double>(v % 2)});
  for (std::uint32_t t = 0; t < count; ++t) mesh.triangles.push_back({t, t + 1, t + 2});
  std::string bytes;
  const auto sink = memory_sink("mesh.igs", bytes);
  const auto done = write_iges(mesh, {IgesStyle::Trimmed, 0.5, true}, *sink);
  ASSERT_FALSE(done.ok());
  EXPECT_EQ(done.error().code, Code::Unsupported);
  EXPECT_NE(done.error().message.find("style trimmed needs 12,600,004 directory lines for 900,000 triangles"),
            std::string::npos)
      << done.error().text();
  EXPECT_NE(done.error().message.find("9,999,999 at most: choose a larger bin (about 714,000 triangles fit), style "
                                      "patches, style wire, style surfaces, or 3mf, stl or ply"),
            std::string::npos)
      << done.error().text();
  EXPECT_TRUE(write_iges(mesh, {IgesStyle::Patches, 0.5, true}, *sink).ok());
  ASSERT_TRUE(sink->commit().ok());
  EXPECT_TRUE(bytes.empty()) << "a forecast writes nothing";
}

}  // namespace
}  // namespace scanmill::exporting
