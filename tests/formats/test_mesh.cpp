// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <limits>

#include "base/random.hpp"
#include "formats/mesh_reader.hpp"
#include "formats/probe.hpp"
#include "store/files.hpp"
#include "support/temp_folder.hpp"

namespace scanmill::formats {
namespace {

Result<MeshFile> read(const std::string& name, const std::string& bytes) {
  return read_mesh(std::shared_ptr<const ByteSource>(memory_source(name, bytes)));
}
MeshFile good(const std::string& name, const std::string& bytes) {
  auto file = read(name, bytes);
  EXPECT_TRUE(file.ok()) << file.error().text();
  return file.ok() ? *file : MeshFile{};
}
void expect_failure(const std::string& name, const std::string& bytes, const std::string& where,
                    const std::string& part, Code code = Code::BadInput) {
  const auto file = read(name, bytes);
  ASSERT_FALSE(file.ok()) << "wanted: " << part;
  EXPECT_EQ(file.error().code, code);
  EXPECT_EQ(file.error().where, where) << file.error().text();
  EXPECT_NE(file.error().message.find(part), std::string::npos) << file.error().text();
}
bool has_note(const MeshFile& file, const std::string& part) {
  return std::any_of(file.notes.begin(), file.notes.end(),
                     [&](const std::string& note) { return note.find(part) != std::string::npos; });
}

template <class T>
std::string bytes_of(T value, bool big = false) {
  std::string text(sizeof(T), '\0');
  std::memcpy(text.data(), &value, sizeof(T));
  if (big) std::reverse(text.begin(), text.end());
  return text;
}

std::string binary_stl(const std::vector<std::array<float, 9>>& facets, std::string title = "any") {
  title.resize(80, ' ');
  std::string bytes = title + bytes_of(static_cast<std::uint32_t>(facets.size()));
  for (const auto& facet : facets) {
    bytes += std::string(12, '\0');
    for (const float c : facet) bytes += bytes_of(c);
    bytes += std::string(2, '\0');
  }
  return bytes;
}
const std::vector<std::array<float, 9>> kTwo = {{0, 0, 0, 1, 0, 0, 0, 1, 0}, {-0.0f, 0, 0, 0, 1, 0, 0, 0, 1}};

// ---- STL

TEST(ReadStlMesh, JoinsExactlyEqualCorners) {
  const MeshFile file = good("a.stl", binary_stl(kTwo));
  EXPECT_EQ(file.format, "stl binary");
  EXPECT_EQ(file.positions, (std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}));
  EXPECT_EQ(file.triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}}));
  EXPECT_TRUE(file.patch.empty());
  EXPECT_EQ(file.comments, std::vector<std::string>{"any"});
}

TEST(ReadStlMesh, KnowsABinaryFileThatBeginsWithSolid) {
  const std::string bytes = binary_stl(kTwo, "solid from a CAD program");
  EXPECT_EQ(good("a.stl", bytes).format, "stl binary");
  EXPECT_EQ(good("without_suffix", bytes).triangles.size(), 2u);
}

TEST(ReadStlMesh, JoinsManyCornersLikeASortedList) {
  Random random(1, 2, 3);
  std::vector<std::array<float, 9>> facets(5000);
  std::vector<std::array<float, 3>> corners;
  for (auto& facet : facets)
    for (std::size_t c = 0; c < 3; ++c) {
      std::array<float, 3> p{};
      for (float& x : p) x = static_cast<float>(random.next() % 17);
      std::copy(p.begin(), p.end(), facet.begin() + static_cast<std::ptrdiff_t>(3 * c));
      corners.push_back(p);
    }
  const MeshFile file = good("a.stl", binary_stl(facets));
  std::sort(corners.begin(), corners.end());
  corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
  EXPECT_EQ(file.positions.size(), corners.size());
  std::uint64_t repeated = 0;
  for (std::size_t t = 0; t < facets.size(); ++t) {
    const Triangle& rows = file.triangles[t];
    repeated += rows[0] == rows[1] || rows[1] == rows[2] || rows[2] == rows[0];
    for (std::size_t c = 0; c < 3; ++c)
      ASSERT_EQ(file.positions[rows[c]], (Vec3{facets[t][3 * c], facets[t][3 * c + 1], facets[t][3 * c + 2]}));
  }
  EXPECT_EQ(file.repeated_corners, repeated);
  EXPECT_TRUE(repeated > 0 && has_note(file, "name a vertex twice"));
}

TEST(ReadStlMesh, TellsOfColoursAndOfBytesBehind) {
  std::string bytes = binary_stl(kTwo);
  bytes[84 + 48] = 1;
  bytes += "xyz";
  const MeshFile file = good("a.stl", bytes);
  EXPECT_EQ(file.triangles.size(), 2u);
  EXPECT_TRUE(has_note(file, "the attribute bytes of 1 facets"));
  EXPECT_TRUE(has_note(file, "3 bytes behind the last facet (from byte 184)"));
}

TEST(ReadStlMesh, RefusesBinaryFilesThatLie) {
  const std::string bytes = binary_stl(kTwo);
  expect_failure("a.stl", bytes.substr(0, 183), "a.stl: byte 183", "announces 2 facets, which take 184 bytes");
  expect_failure("a.stl", bytes.substr(0, 40), "a.stl: byte 40", "ends after 40 bytes");
  std::string lying = bytes;
  lying.replace(80, 4, "\xff\xff\xff\xff");
  expect_failure("a.stl", lying, "a.stl: byte 184", "announces 4,294,967,295 facets");
  lying.replace(80, 4, std::string(4, '\0'));
  expect_failure("a.stl", lying, "a.stl: byte 84", "announces 0 facets");
  auto facets = kTwo;
  facets[1][4] = std::numeric_limits<float>::quiet_NaN();
  expect_failure("a.stl", binary_stl(facets), "a.stl: byte 134", "found nan as a coordinate");
}

TEST(ReadStlMesh, TakesAsciiInAnyCaseWithSeveralSolids) {
  const MeshFile file = good(
      "a.stl",
      "SOLID first part offset_mm 1 2 3\r\n FACET NORMAL 0 0 nan\r\n  Outer Loop\r\n   vertex 0 0 0\r\n"
      "   VERTEX 1.5e0 0 0\r\n\r\n  vertex 0 1 0\r\n endloop\r\n endfacet\r\nEndSolid first part\r\n"
      "solid\nfacet normal 0 0 1 outer loop vertex 0 0 0 vertex 0 1 0 vertex 0 0\n 1 endloop endfacet\nendsolid\n");
  EXPECT_EQ(file.format, "stl ascii");
  EXPECT_EQ(file.positions, (std::vector<Vec3>{{0, 0, 0}, {1.5, 0, 0}, {0, 1, 0}, {0, 0, 1}}));
  EXPECT_EQ(file.triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}}));
  EXPECT_EQ(file.offset, (Vec3{1, 2, 3}));
  EXPECT_TRUE(has_note(file, "2 solids"));
}

TEST(ReadStlMesh, NamesTheLineOfAFaultInAscii) {
  const std::string head = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n";
  expect_failure("a.stl", head + "vertex 1 x 0\n", "a.stl:5", "found \"x\", wanted a number");
  expect_failure("a.stl", head + "vertex 1 1e39 0\nvertex 2 0 0\nendloop\nendfacet\nendsolid\n", "a.stl:2",
                 "found inf as a coordinate");
  expect_failure("a.stl", head + "endloop\n", "a.stl:5", "found \"endloop\", wanted vertex");
  expect_failure("a.stl", head, "a.stl:4", "ends where vertex is wanted; it was cut");
  expect_failure("a.stl", head + "vertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n", "a.stl:8",
                 "ends where facet or endsolid is wanted");
}

// ---- OBJ

TEST(ReadObjMesh, TakesIndicesOfAllKinds) {
  const MeshFile file = good("a.obj",
                             "# made by hand\nmtllib a.mtl\no thing\nv 0 0 0\nv 1 0 0 \r\nv 1 1 0 1.0\n"
                             "v 0 1 0 0.5 0.5 0.5\nvt 0 0\nvn 0 0 1\nusemtl red\ns off\n"
                             "f 1 2/1 3/1/1 4//1\nf -4 -3 \\\r\n  -1\nl 1 2\nf 2 3 5 # later vertex\nv 2 2 2\n");
  EXPECT_EQ(file.positions.size(), 5u);
  EXPECT_EQ(file.triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}, {0, 1, 3}, {1, 2, 4}}));
  EXPECT_EQ(file.polygons_split, 1u);
  EXPECT_EQ(file.comments, std::vector<std::string>{" made by hand"});
  EXPECT_TRUE(file.patch.empty());
  for (const char* part : {"1 faces of more than three corners", "1 vertex colours", "1 normals (\"vn\")",
                           "1 uses of materials (\"usemtl\")", "1 texture coordinates (\"vt\")", "1 lines (\"l\")"})
    EXPECT_TRUE(has_note(file, part)) << part;
}

TEST(ReadObjMesh, TakesPatchesOnlyWhereEveryFaceHasOne) {
  const std::string vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";
  EXPECT_EQ(good("a.obj", vertices + "g patch_3\nf 1 2 3 4\ng patch_0\nf 1 3 4\n").patch,
            (std::vector<std::uint32_t>{3, 3, 0}));
  const MeshFile mixed = good("a.obj", vertices + "g patch_3\nf 1 2 3\ng lid\nf 1 3 4\n");
  EXPECT_TRUE(mixed.patch.empty());
  EXPECT_TRUE(has_note(mixed, "1 group names"));
  EXPECT_TRUE(good("a.obj", vertices + "f 1 2 3\ng patch_1\nf 1 3 4\n").patch.empty());
}

TEST(ReadObjMesh, NamesTheLineOfAFault) {
  const std::string vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  expect_failure("a.obj", vertices + "f 1 2 4\n", "a.obj:4", "names vertex 3 (counted from 0), the file has 3");
  expect_failure("a.obj", vertices + "f 1 2 99999999999\n", "a.obj:4", "names vertex 99,999,999,998");
  expect_failure("a.obj", vertices + "f 1 2 -4\n", "a.obj:4", "names vertex -4, but only 3");
  expect_failure("a.obj", vertices + "f 1 0 2\n", "a.obj:4", "found \"0\" in \"f 1 0 2\"");
  expect_failure("a.obj", vertices + "f 1 b 2\n", "a.obj:4", "found \"b\"");
  expect_failure("a.obj", "v 1 2\n", "a.obj:1", "wanted \"v x y z\"");
  expect_failure("a.obj", "v 1 2 3 red\n", "a.obj:1", "found \"red\" behind a vertex");
  expect_failure("a.obj", "g empty\n", "a.obj", "no line \"v x y z\"");
}

// ---- OFF

TEST(ReadOffMesh, TakesTheVariants) {
  const std::string body = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n3 0 2 1\n";
  const std::vector<Triangle> wanted{{0, 1, 2}, {0, 2, 3}, {0, 2, 1}};
  for (const std::string head : {"OFF\n4 2 0\n", "OFF 4 2 5\n", "OFF4 2 0\n", "# c\n\nOFF # d\n # e\n 4 2 # f\n",
                                 "4 2 0\n", "OFF\r\n4 2 0\r\n"}) {
    const MeshFile file = good("a.off", head + body);
    EXPECT_EQ(file.triangles, wanted) << head;
    EXPECT_EQ(file.positions.size(), 4u);
  }
  const MeshFile coloured = good("x",
                                 "STCNOFF\n3 1 0\n0 0 0 0 0 1 1 0 0 1 .5 .5\n1 0 0 0 0 1 255 0 0 1 0 0\n"
                                 "0 1 0 0 0 1 1 1 1 1 1 1\n3 0 1 2 255 0 0\n");
  EXPECT_EQ(coloured.format, "stcnoff");
  EXPECT_EQ(coloured.triangles.size(), 1u);
  EXPECT_TRUE(has_note(coloured, "the coordinates of 3 vertices"));
  EXPECT_TRUE(has_note(coloured, "the corners of 1 faces"));
}

TEST(ReadOffMesh, NamesTheLineOfAFault) {
  expect_failure("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n", "a.off:4", "declares 3 vertices, the file ends after 2");
  expect_failure("a.off", "OFF\n18446744073709551615 1 0\n0 0 0\n", "a.off:3", "the file ends after 1");
  expect_failure("a.off", "OFF\n3 2 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", "a.off:6", "declares 2 faces");
  expect_failure("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", "a.off:6", "names vertex 3");
  expect_failure("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n", "a.off:6", "as face 0, wanted the number");
  expect_failure("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n4000000000 0 1\n", "a.off:6", "as face 0");
  expect_failure("a.off", "OFF\n3 1 0\n0 0\n", "a.off:3", "found \"0 0\" as vertex 0");
  expect_failure("a.off", "OFF\nmany\n", "a.off:2", "wanted the numbers of vertices");
  expect_failure("a.off", "4OFF\n1 0 0\n", "a.off:1", "three dimensions", Code::Unsupported);
  expect_failure("a.off", "OFF BINARY\n1 0 0\n", "a.off:1", "binary OFF", Code::Unsupported);
}

// ---- PLY

std::string ply(const std::string& encoding, const std::string& elements, const std::string& body) {
  return "ply\nformat " + encoding + " 1.0\n" + elements + "end_header\n" + body;
}
const std::string kVertex = "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n";

TEST(ReadPlyMesh, TakesAsciiAndBothByteOrders) {
  const std::string elements =
      "comment offset_mm 10 20 30\n" + kVertex + "property float error\nproperty uchar red\n" +
      "element face 2\nproperty uint patch\nproperty list uchar int vertex_index\nproperty float quality\n"
      "element edge 1\nproperty int a\n";
  for (const std::string encoding : {"ascii", "binary_little_endian", "binary_big_endian"}) {
    SCOPED_TRACE(encoding);
    std::string body;
    if (encoding == "ascii") {
      body = "0 0 0 -0.5 9\n1 0 0 0 9\n\n1 1 0 .25 9\n0 1 0 1 9\n5 4 0 1 2 3 0\n1 3 0 2 1 0\n7\n";
    } else {
      const bool big = encoding == "binary_big_endian";
      const float rows[4][4] = {{0, 0, 0, -0.5f}, {1, 0, 0, 0}, {1, 1, 0, 0.25f}, {0, 1, 0, 1}};
      for (const auto& row : rows) {
        for (const float c : row) body += bytes_of(c, big);
        body += '\x09';
      }
      body += bytes_of(5u, big) + '\x04';
      for (const int c : {0, 1, 2, 3}) body += bytes_of(c, big);
      body += bytes_of(0.f, big) + bytes_of(1u, big) + '\x03';
      for (const int c : {0, 2, 1}) body += bytes_of(c, big);
      body += bytes_of(0.f, big) + bytes_of(7, big);
    }
    const MeshFile file = good("a", ply(encoding, elements, body));
    EXPECT_EQ(file.format, "ply " + encoding);
    EXPECT_EQ(file.positions, (std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}));
    EXPECT_EQ(file.triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}, {0, 2, 1}}));
    EXPECT_EQ(file.patch, (std::vector<std::uint32_t>{5, 5, 1}));
    EXPECT_EQ(file.error, (std::vector<double>{-0.5, 0, 0.25, 1}));
    EXPECT_EQ(file.offset, (Vec3{10, 20, 30}));
    EXPECT_TRUE(has_note(file, "property \"red\" of the vertices"));
    EXPECT_TRUE(has_note(file, "property \"quality\" of the faces"));
    EXPECT_TRUE(has_note(file, "element \"edge\" with 1 rows"));
  }
}

TEST(ReadPlyMesh, TakesFacesBeforeVerticesAndStrips) {
  const MeshFile file =
      good("a.ply", ply("ascii", "element tristrips 1\nproperty list int int vertex_indices\n" + kVertex,
                        "9 0 1 2 3 -1 3 2 2 1\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n"));
  EXPECT_EQ(file.triangles, (std::vector<Triangle>{{0, 1, 2}, {2, 1, 3}}));
}

TEST(ReadPlyMesh, DropsVerticesThatAreNotFiniteWhereNoFaceUsesThem) {
  const std::string elements =
      kVertex + "property float error\nelement face 1\nproperty list uchar int vertex_indices\n";
  const std::string vertices = "0 0 0 1\nnan 0 0 2\n1 0 0 3\n0 1 0 4\n";
  const MeshFile file = good("a.ply", ply("ascii", elements, vertices + "3 0 2 3\n"));
  EXPECT_EQ(file.positions, (std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
  EXPECT_EQ(file.triangles, (std::vector<Triangle>{{0, 1, 2}}));
  EXPECT_EQ(file.error, (std::vector<double>{1, 3, 4}));
  EXPECT_TRUE(has_note(file, "1 vertices that no face uses"));
  expect_failure("a.ply", ply("ascii", elements, vertices + "3 0 1 2\n"), "a.ply", "vertex 1 (counted from 0) is NaN");
}

TEST(ReadPlyMesh, RefusesFilesThatLie) {
  const std::string faces = "element face 1\nproperty list uchar int vertex_indices\n";
  const std::string vertices = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n";
  auto ascii = [&](const std::string& face) { return ply("ascii", kVertex + faces, vertices + face); };
  expect_failure("a.ply", ascii("3 0 1 4\n"), "a.ply:14", "names vertex 4");
  expect_failure("a.ply", ascii("3 0 1 -1\n"), "a.ply:14", "found vertex number -1");
  expect_failure("a.ply", ascii("3 0 1 1.5\n"), "a.ply:14", "found vertex number 1.5");
  expect_failure("a.ply", ascii("200 0 1 2\n"), "a.ply:14", "announces 200 items, the line can hold");
  expect_failure("a.ply", ascii("3 0 1 2 3\n"), "a.ply:14", "found \"3\" behind the last");
  expect_failure("a.ply", ascii("3 0 1\n"), "a.ply:14", "announces 3 items, the line can hold 2 at most");
  const std::string cut = ascii("");
  expect_failure("a.ply", cut, "a.ply: byte " + std::to_string(cut.size()), "declares 1 rows of element \"face\"");
  expect_failure("a.ply", ply("ascii", kVertex, vertices), "a.ply", "the file is a cloud");

  const std::string head =
      ply("binary_little_endian", kVertex + "element face 1\nproperty list uint uint vertex_indices\n",
          std::string(48, '\0'));
  expect_failure("a.ply", head + "\xff\xff\xff\xff" + std::string(12, '\0'),
                 "a.ply: byte " + std::to_string(head.size()),
                 "announces 4294967295 items, the rest of the file can hold 3 at most");
  const std::string many =
      ply("binary_little_endian",
          "element vertex 4000000000000\nproperty float x\nproperty float y\nproperty float z\n" + faces,
          std::string(120, '\0'));
  expect_failure("a.ply", many, "a.ply: byte " + std::to_string(many.size()), "the file ends after 10");
}

// ---- all

TEST(ReadMesh, JudgesByContentBeforeSuffix) {
  auto kind = [](const std::string& name, const std::string& bytes) {
    return *mesh_kind_of(*memory_source(name, bytes));
  };
  EXPECT_EQ(kind("a.obj", "OFF\n1 0 0\n"), MeshKind::Off);
  EXPECT_EQ(kind("a.txt", "ply\nformat"), MeshKind::Ply);
  EXPECT_EQ(kind("a", "  solid x\nfacet"), MeshKind::Stl);
  EXPECT_EQ(kind("a", "# x\nv 0 0 0\nv 1 0 0\nf 1 2 3\n"), MeshKind::Obj);
  EXPECT_EQ(kind("a.obj", "o solid\nv 0 0 0\n"), MeshKind::Obj);
  EXPECT_EQ(kind("a.OFF", "3 1 0\n"), MeshKind::Off);
  EXPECT_EQ(kind("a.xyz", "0 0 0\n1 1 1\n"), MeshKind::None);
  expect_failure("a.xyz", "0 0 0\n", "a.xyz", "wanted STL, OBJ, OFF or PLY");
  expect_failure("a.stl", "", "a.stl", "the file is empty");
  EXPECT_TRUE(probe(*memory_source("a.obj", "v 0 0 0\n"))->has_faces);
}

TEST(ReadMesh, MeshOfTurnsAndSortsTriangles) {
  MeshFile file;
  file.positions.resize(4);
  file.triangles = {{3, 1, 2}, {2, 0, 1}};
  file.patch = {8, 9};
  const Mesh mesh = mesh_of(file);
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {1, 2, 3}}));
  EXPECT_EQ(mesh.patch, (std::vector<std::uint32_t>{9, 8}));
}

TEST(ReadMesh, ReadsTheCollectedFiles) {
  if (support::data_folder().empty()) GTEST_SKIP() << "no development data";
  const struct {
    const char* path;
    const char* format;
    std::size_t vertices, triangles;
  } kFiles[] = {{"cad/bottle_ascii.stl", "stl ascii", 1191, 1240},
                {"cad/angle_block.STL", "stl binary", 398, 704},
                {"formats/stl/Spider_ascii.stl", "stl ascii", 722, 1368},
                {"formats/stl/Spider_binary.stl", "stl binary", 722, 1368},
                {"broken/CubeInvalidUnicode.stl", "stl binary", 8, 12},
                {"cad/cube.off", "off", 24, 12},
                {"clouds/fandisk.obj", "obj", 6475, 12946},
                {"clouds/igea.ply", "ply binary_little_endian", 134345, 268686},
                {"formats/ply/platonic_shelf_ascii.ply", "ply ascii", 50, 80},
                {"formats/ply/platonic_shelf_big_endian.ply", "ply binary_big_endian", 50, 80},
                {"range-views/bunny/bun_zipper.ply", "ply ascii", 35947, 69451}};
  for (const auto& wanted : kFiles) {
    SCOPED_TRACE(wanted.path);
    auto source = store::open_file(support::data_folder() + "/" + wanted.path, wanted.path);
    ASSERT_TRUE(source.ok());
    const auto file = read_mesh(std::shared_ptr<const ByteSource>(std::move(*source)));
    ASSERT_TRUE(file.ok()) << file.error().text();
    EXPECT_EQ(file->format, wanted.format);
    EXPECT_EQ(file->positions.size(), wanted.vertices);
    EXPECT_EQ(file->triangles.size(), wanted.triangles);
  }
}

TEST(ReadMesh, SurvivesEveryCutAndDamage) {
  const std::string files[][2] = {
      {"a.stl", binary_stl(kTwo)},
      {"a.stl",
       "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
       "endsolid a\n"},
      {"a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\ng patch_1\nf 1/1 2/2 \\\n -1\n"},
      {"a.off", "COFF\n3 1 0\n0 0 0 1 1 1 1\n1 0 0 1 1 1 1\n0 1 0 1 1 1 1\n3 0 1 2\n"},
      {"a.ply", ply("ascii", kVertex + "element face 1\nproperty list uchar int vertex_indices\n",
                    "0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 1 2\n")},
      {"a.ply", ply("binary_big_endian",
                    "element vertex 1\nproperty double x\nproperty list uchar short l\nproperty double y\n"
                    "property double z\nelement face 1\nproperty list ushort uint vertex_indices\n",
                    std::string(8, '\0') + std::string("\x01\0\0", 3) + std::string(16, '\0') + std::string("\0\3", 2) +
                        std::string(12, '\0'))}};
  Random random(11, 0, 0);
  for (const auto& [name, bytes] : files) {
    ASSERT_TRUE(read(name, bytes).ok()) << read(name, bytes).error().text();
    for (std::size_t cut = 0; cut < bytes.size(); ++cut) (void)read(name, bytes.substr(0, cut));
    for (int round = 0; round < 3000; ++round) {
      std::string damaged = bytes;
      for (int k = 0; k < 1 + round % 3; ++k)
        damaged[random.next() % damaged.size()] = static_cast<char>(random.next() % 256);
      const auto file = read(name, damaged);
      if (!file.ok()) {
        EXPECT_TRUE(file.error().code == Code::BadInput || file.error().code == Code::Unsupported)
            << file.error().text();
        EXPECT_EQ(file.error().where.rfind(name, 0), 0u);
        continue;
      }
      for (const Triangle& t : file->triangles)
        for (const std::uint32_t corner : t) ASSERT_LT(corner, file->positions.size());
    }
  }
}

}  // namespace
}  // namespace scanmill::formats
