// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>

#include "pipeline/convert_notes.hpp"

namespace scanmill::pipeline {
namespace {

bool has(const std::vector<std::string>& losses, const std::string& part) {
  return std::any_of(losses.begin(), losses.end(),
                     [&](const std::string& line) { return line.find(part) != std::string::npos; });
}

formats::MeshFile rich_mesh() {
  formats::MeshFile mesh;
  mesh.format = "ply ascii";
  mesh.positions = {{0, 0, 0}, {0.1, 0, 0}, {0, 1, 0}, {5, 5, 5}};
  mesh.triangles = {{0, 1, 2}};
  mesh.patch = {3};
  mesh.error = {0, 0, 0, 0};
  mesh.offset = Vec3{100, 0, 0};
  mesh.properties = {"3 normals (\"vn\")"};
  mesh.comments = {"who made it"};
  return mesh;
}

TEST(ConversionLosses, NameEverythingThatStlCannotHold) {
  const auto losses = conversion_losses(rich_mesh(), ConvertTarget::StlBinary);
  for (const char* part : {"the patch ids of 1 triangles", "the errors of 4 vertices", "1 vertices that no face uses",
                           "which corners share a vertex", "3 normals", "1 comment", "the offset 100 0 0 mm",
                           "the largest change is 1.4901161138336505e-09 mm"})
    EXPECT_TRUE(has(losses, part)) << part;
  EXPECT_EQ(losses.size(), 8u);
}

TEST(ConversionLosses, CountTrianglesThatFloat32Collapses) {
  formats::MeshFile mesh;
  mesh.format = "obj";
  mesh.positions = {{4.52e6, 0, 0}, {4.52e6 + 0.1, 0, 0}, {4.52e6, 1, 0}};
  mesh.triangles = {{0, 1, 2}};
  const auto losses = conversion_losses(mesh, ConvertTarget::PlyMesh, 1000);
  ASSERT_EQ(losses.size(), 2u);
  EXPECT_TRUE(has(losses, "1 triangles lose their area"));
  EXPECT_TRUE(has(losses, "the largest change is 99.99999962747097 mm")) << losses[0];
  EXPECT_TRUE(conversion_losses(mesh, ConvertTarget::PlyMeshDouble).empty());
}

TEST(ConversionLosses, AreFewWhereTheFormatHoldsAll) {
  EXPECT_EQ(conversion_losses(rich_mesh(), ConvertTarget::PlyMeshDouble),
            std::vector<std::string>{"3 normals (\"vn\")"});
  const auto to_points = conversion_losses(rich_mesh(), ConvertTarget::PlyPoints);
  EXPECT_TRUE(has(to_points, "1 triangles: a cloud holds points only"));
}

TEST(ConvertTarget, FollowsTheSuffix) {
  EXPECT_EQ(*convert_target_of("a.STL", false, false), ConvertTarget::StlBinary);
  EXPECT_EQ(*convert_target_of("a.stl", false, true), ConvertTarget::StlAscii);
  EXPECT_EQ(*convert_target_of("a.ply", false, false), ConvertTarget::PlyMesh);
  EXPECT_EQ(*convert_target_of("a.ply", true, false), ConvertTarget::PlyPoints);
  EXPECT_EQ(convert_target_of("a.stl", true, false).error().code, Code::BadUsage);
  EXPECT_EQ(convert_target_of("a.plly", false, false).error().message,
            "found the suffix \"plly\"; allowed stl, ply, obj, igs, iges, dxf, 3mf; nearest ply");
}

}  // namespace
}  // namespace scanmill::pipeline
