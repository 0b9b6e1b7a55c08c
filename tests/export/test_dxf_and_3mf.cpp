// SPDX-License-Identifier: Apache-2.0
// DXF as pairs of lines, 3MF as a ZIP of deflated parts, both taken apart by code of this test.
#include <gtest/gtest.h>
#include <zlib.h>

#include <cstring>
#include <map>
#include <sstream>

#include "export/dxf.hpp"
#include "export/threemf.hpp"

namespace scanmill::exporting {
namespace {

/// A strip of triangles, patches by turns.
Mesh strip(std::uint32_t triangles, std::uint32_t patches) {
  Mesh mesh;
  for (std::uint32_t v = 0; v < triangles + 2; ++v)
    mesh.positions.push_back({0.1f * static_cast<float>(v), static_cast<float>(v % 2), -0.0});
  for (std::uint32_t t = 0; t < triangles; ++t) {
    mesh.triangles.push_back(t % 2 == 0 ? Triangle{t, t + 2, t + 1} : Triangle{t, t + 1, t + 2});
    mesh.patch.push_back(t * patches / triangles + 3);
  }
  return mesh;
}

Mesh tetrahedron() {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.triangles = {{0, 1, 3}, {0, 2, 1}, {0, 3, 2}, {1, 2, 3}};
  return mesh;
}

using Pairs = std::vector<std::pair<int, std::string>>;

Pairs pairs_of(const std::string& text) {
  Pairs pairs;
  std::istringstream lines(text);
  std::string code, value;
  while (std::getline(lines, code)) {
    EXPECT_TRUE(std::getline(lines, value)) << "a code without value: " << code;
    pairs.push_back({std::stoi(code), value});
  }
  return pairs;
}

std::string dxf_of(const Mesh& mesh, DxfStyle style) {
  std::string bytes;
  const auto sink = memory_sink("mesh.dxf", bytes);
  const auto done = write_dxf(mesh, style, *sink);
  EXPECT_TRUE(done.ok());
  EXPECT_TRUE(sink->commit().ok());
  return bytes;
}

TEST(Dxf, HoldsAFacePerTriangleOnTheLayerOfItsPatch) {
  const Mesh mesh = strip(20, 4);
  const Pairs pairs = pairs_of(dxf_of(mesh, DxfStyle::Faces));
  std::size_t t = 0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (pairs[i] != std::pair<int, std::string>{0, "3DFACE"}) continue;
    ASSERT_EQ(pairs[i + 1].second, "PATCH_" + std::to_string(mesh.patch[t]));
    for (std::size_t c = 0; c < 4; ++c) {
      const Vec3 p = mesh.positions[mesh.triangles[t][std::min<std::size_t>(c, 2)]];
      const double wanted[] = {p.x, p.y, p.z};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        EXPECT_EQ(pairs[i + 2 + 3 * c + axis].first, static_cast<int>(10 + c + 10 * axis));
        EXPECT_EQ(std::stod(pairs[i + 2 + 3 * c + axis].second), wanted[axis]);
      }
    }
    ++t;
  }
  EXPECT_EQ(t, mesh.triangles.size());
  EXPECT_EQ(pairs.back().second, "EOF");
  EXPECT_EQ(std::count(pairs.begin(), pairs.end(), std::pair<int, std::string>{0, "LAYER"}), 4);
}

TEST(Dxf, SplitsPolyfacesWhereTheirNumbersEnd) {
  const Mesh mesh = strip(70'000, 1);
  const Pairs pairs = pairs_of(dxf_of(mesh, DxfStyle::Polyface));
  std::vector<long> vertices, faces;
  long corners = 0, largest = 0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const auto& [code, value] = pairs[i];
    if (code == 0 && value == "POLYLINE")
      for (std::size_t k = i + 1; pairs[k].first != 0; ++k) {
        if (pairs[k].first == 71) vertices.push_back(std::stol(pairs[k].second));
        if (pairs[k].first == 72) faces.push_back(std::stol(pairs[k].second));
      }
    if (code == 0 && value == "VERTEX")
      for (std::size_t k = i + 1; pairs[k].first != 0; ++k)
        if (pairs[k].first >= 71 && pairs[k].first <= 73)
          ++corners, largest = std::max(largest, std::stol(pairs[k].second));
  }
  ASSERT_EQ(faces.size(), 3u);
  EXPECT_EQ(faces[0] + faces[1] + faces[2], 70'000);
  EXPECT_EQ(corners, 210'000);
  EXPECT_EQ(largest, 32'767);
  for (const long count : vertices) EXPECT_LE(count, 32'767);
}

TEST(Dxf, DrawsPolylinesPointsAndText) {
  std::string bytes;
  const auto sink = memory_sink("s.dxf", bytes);
  DxfWriter out(*sink);
  const DxfLayer layers[] = {{"MESH", 5}, {"POINTS", 8}};
  ASSERT_TRUE(out.begin({}, layers, {}).ok());
  const Vec3 line[] = {{0, 0, 0}, {1, 1e-12, 1e20}};
  ASSERT_TRUE(out.polyline("MESH", line, true).ok());
  ASSERT_TRUE(out.point("POINTS", {1, 2, 3}).ok());
  ASSERT_TRUE(out.text("MESH", {0, 0, 0}, 2.5, "0.8 mm").ok());
  ASSERT_TRUE(out.end().ok());
  ASSERT_TRUE(sink->commit().ok());
  EXPECT_NE(bytes.find("POLYLINE\n8\nMESH\n66\n1\n10\n0.0\n20\n0.0\n30\n0.0\n70\n9\n0\nVERTEX\n"), std::string::npos);
  EXPECT_NE(bytes.find("10\n1.0\n20\n1e-12\n30\n1e+20\n70\n32\n0\nSEQEND\n"), std::string::npos) << bytes;
  EXPECT_NE(bytes.find("0\nPOINT\n8\nPOINTS\n10\n1.0\n20\n2.0\n30\n3.0\n"), std::string::npos);
  EXPECT_NE(bytes.find("40\n2.5\n1\n0.8 mm\n"), std::string::npos);
}

template <class T>
T value_at(const std::string& bytes, std::size_t at) {
  T value{};
  if (at + sizeof value <= bytes.size()) std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

std::map<std::string, std::string> parts_of(const std::string& zip) {
  std::map<std::string, std::string> parts;
  const std::size_t end = zip.size() - 22;
  EXPECT_EQ(value_at<std::uint32_t>(zip, end), 0x06054b50u);
  std::size_t at = value_at<std::uint32_t>(zip, end + 16);
  for (int n = value_at<std::uint16_t>(zip, end + 10); n > 0; --n) {
    EXPECT_EQ(value_at<std::uint32_t>(zip, at), 0x02014b50u);
    const auto crc = value_at<std::uint32_t>(zip, at + 16), packed = value_at<std::uint32_t>(zip, at + 20),
               size = value_at<std::uint32_t>(zip, at + 24), local = value_at<std::uint32_t>(zip, at + 42);
    const auto name_size = value_at<std::uint16_t>(zip, at + 28);
    const std::string name = zip.substr(at + 46, name_size);
    EXPECT_EQ(zip.substr(local + 30, name_size), name);
    EXPECT_EQ(value_at<std::uint32_t>(zip, local + 14), crc);
    std::string plain(size, '\0');
    z_stream z{};
    EXPECT_EQ(inflateInit2(&z, -15), Z_OK);
    z.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(zip.data() + local + 30 + name_size));
    z.avail_in = packed;
    z.next_out = reinterpret_cast<Bytef*>(plain.data());
    z.avail_out = size;
    EXPECT_EQ(inflate(&z, Z_FINISH), Z_STREAM_END);
    inflateEnd(&z);
    EXPECT_EQ(crc32(0, reinterpret_cast<const Bytef*>(plain.data()), size), crc);
    parts[name] = plain;
    at += 46u + name_size;
  }
  return parts;
}

std::string package_of(const Mesh& mesh, ThreeMfCounts* counts = nullptr) {
  std::string bytes;
  const auto sink = memory_sink("mesh.3mf", bytes);
  const auto done = write_3mf(mesh, *sink);
  EXPECT_TRUE(done.ok());
  EXPECT_TRUE(sink->commit().ok());
  if (counts && done.ok()) *counts = *done;
  return bytes;
}

TEST(ThreeMf, IsAPackageWithAModelInMillimetres) {
  ThreeMfCounts counts;
  const auto parts = parts_of(package_of(tetrahedron(), &counts));
  ASSERT_EQ(parts.size(), 3u);
  EXPECT_EQ(parts.count("[Content_Types].xml") + parts.count("_rels/.rels"), 2u);
  const std::string& model = parts.at("3D/3dmodel.model");
  EXPECT_NE(model.find("<model unit=\"millimeter\""), std::string::npos);
  EXPECT_NE(model.find("<object id=\"2\" type=\"model\">"), std::string::npos);
  EXPECT_NE(model.find("<vertex x=\"0\" y=\"0\" z=\"1\"/>"), std::string::npos);
  EXPECT_NE(model.find("<triangle v1=\"1\" v2=\"2\" v3=\"3\"/>"), std::string::npos);
  EXPECT_TRUE(counts.closed);
}

TEST(ThreeMf, SaysPatchesOffsetAndThatASurfaceIsOpen) {
  Mesh mesh = strip(10, 2);
  mesh.offset = {1e6, 0, 0.5};
  mesh.triangles.push_back({0, 0, 1});
  mesh.patch.push_back(3);
  ThreeMfCounts counts;
  const auto parts = parts_of(package_of(mesh, &counts));
  const std::string& model = parts.at("3D/3dmodel.model");
  EXPECT_FALSE(counts.closed);
  EXPECT_EQ(counts.left_out, 1u);
  EXPECT_EQ(counts.triangles, 10u);
  EXPECT_NE(model.find("type=\"surface\" pid=\"1\" pindex=\"0\""), std::string::npos);
  EXPECT_NE(model.find("<base name=\"patch_4\" displaycolor=\"#F0D854\"/>"), std::string::npos) << model;
  EXPECT_NE(model.find("v3=\"11\" pid=\"1\" p1=\"1\"/>"), std::string::npos);
  EXPECT_NE(model.find("<metadata name=\"scanmill:offset_mm\">1e+06 0 0.5</metadata>"), std::string::npos) << model;
  EXPECT_EQ(model.find("\"-0\""), std::string::npos);
}

TEST(DxfAndThreeMf, FindDamagedBytesAndGiveTheSameTwice) {
  const Mesh mesh = strip(2000, 3);
  const std::string dxf = dxf_of(mesh, DxfStyle::Polyface), package = package_of(mesh);
  EXPECT_EQ(dxf, dxf_of(mesh, DxfStyle::Polyface));
  EXPECT_EQ(package, package_of(mesh));
  EXPECT_TRUE(compare_dxf(mesh, DxfStyle::Polyface, *memory_source("f", dxf)).ok());
  EXPECT_TRUE(compare_3mf(mesh, *memory_source("f", package)).ok());
  for (const std::size_t at : {std::size_t{3}, package.size() / 2, package.size() - 1}) {
    std::string bad = package;
    bad[at] = static_cast<char>(bad[at] ^ 1);
    EXPECT_FALSE(compare_3mf(mesh, *memory_source("f", bad)).ok());
  }
  EXPECT_FALSE(compare_dxf(mesh, DxfStyle::Faces, *memory_source("f", dxf)).ok());
  std::string bytes;
  const auto sink = memory_sink("f", bytes);
  EXPECT_EQ(write_dxf(Mesh{}, DxfStyle::Faces, *sink).error().code, Code::BadInput);
  EXPECT_EQ(write_3mf(Mesh{}, *sink).error().code, Code::BadInput);
}

}  // namespace
}  // namespace scanmill::exporting
