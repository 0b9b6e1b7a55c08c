// SPDX-License-Identifier: Apache-2.0
// Export then import gives the same mesh, whatever the numbers; a damaged file never passes the comparison.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>

#include "base/random.hpp"
#include "export/mesh_writers.hpp"
#include "export/writers.hpp"
#include "formats/mesh_reader.hpp"

namespace scanmill::exporting {
namespace {

/// Float32 coordinates of any exponent, triangles over distinct corners in the order a mesh has, some patches.
Mesh random_mesh(std::uint64_t seed, std::size_t vertices, std::size_t triangles) {
  Random random(7, seed, 0);
  Mesh mesh;
  for (std::size_t v = 0; v < vertices; ++v) {
    auto coordinate = [&] {
      float value = 0;
      do {
        const auto bits = static_cast<std::uint32_t>(random.next());
        std::memcpy(&value, &bits, sizeof value);
      } while (!std::isfinite(value));
      if (random.uniform() < 0.5) value = static_cast<float>(random.uniform(-100, 100));
      return double{value};
    };
    mesh.positions.push_back({coordinate(), coordinate(), coordinate()});
  }
  for (std::size_t t = 0; t < triangles; ++t) {
    std::uint32_t corner[3];
    do {
      for (std::uint32_t& c : corner) c = static_cast<std::uint32_t>(random.next() % vertices);
    } while (corner[0] == corner[1] || corner[1] == corner[2] || corner[2] == corner[0]);
    while (corner[0] > corner[1] || corner[0] > corner[2]) {
      const std::uint32_t first = corner[0];
      corner[0] = corner[1], corner[1] = corner[2], corner[2] = first;
    }
    mesh.triangles.push_back({corner[0], corner[1], corner[2]});
  }
  std::sort(mesh.triangles.begin(), mesh.triangles.end());
  mesh.triangles.erase(std::unique(mesh.triangles.begin(), mesh.triangles.end()), mesh.triangles.end());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    mesh.patch.push_back(static_cast<std::uint32_t>(random.next() % 5));
  if (seed % 2 == 1) mesh.offset = {4520000, -0.125, 1e-3};
  return mesh;
}

using Writer = std::function<Result<void>(const Mesh&, ByteSink&)>;
using Comparer = std::function<Result<void>(const Mesh&, const ByteSource&)>;
struct Format {
  const char* name;
  Writer write;
  Comparer compare;
  bool keeps_rows;  // vertex rows, offset and patches come back
};
const Format kFormats[] = {
    {"binary.stl", write_stl, compare_stl, false},
    {"ascii.stl", write_stl_ascii, compare_stl_ascii, false},
    {"a.obj", write_obj, compare_obj, true},
    {"float.ply", [](const Mesh& m, ByteSink& s) { return write_ply_mesh(m, {}, s); },
     [](const Mesh& m, const ByteSource& s) { return compare_ply_mesh(m, {}, s); }, true},
    {"double.ply", [](const Mesh& m, ByteSink& s) { return write_ply_mesh(m, {.double_positions = true}, s); },
     [](const Mesh& m, const ByteSource& s) { return compare_ply_mesh(m, {.double_positions = true}, s); }, true},
};

std::string written(const Format& format, const Mesh& mesh) {
  std::string bytes;
  const auto sink = memory_sink(format.name, bytes);
  const auto done = format.write(mesh, *sink);
  EXPECT_TRUE(done.ok()) << format.name;
  EXPECT_TRUE(sink->commit().ok());
  return bytes;
}

TEST(MeshRoundTrip, GivesTheSameMeshInEveryFormat) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Mesh mesh = random_mesh(seed, 3 + 40 * seed, 9 + 100 * seed);
    for (const Format& format : kFormats) {
      SCOPED_TRACE(std::string(format.name) + ", seed " + std::to_string(seed));
      const std::string bytes = written(format, mesh);
      const auto file = formats::read_mesh(memory_source(format.name, bytes));
      ASSERT_TRUE(file.ok()) << file.error().text();
      const Mesh back = formats::mesh_of(*file);
      if (format.keeps_rows) {
        EXPECT_EQ(back.positions, mesh.positions);
        EXPECT_EQ(back.triangles, mesh.triangles);
        EXPECT_EQ(back.patch, mesh.patch);
        EXPECT_EQ(back.offset, mesh.offset);
        continue;
      }
      ASSERT_EQ(file->triangles.size(), mesh.triangles.size());
      for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        for (std::size_t c = 0; c < 3; ++c)
          ASSERT_EQ(file->positions[file->triangles[t][c]], mesh.positions[mesh.triangles[t][c]]);
    }
  }
}

TEST(MeshRoundTrip, AsciiStlKeepsTheOffset) {
  const Mesh mesh = random_mesh(1, 10, 10);
  const auto file = formats::read_mesh(memory_source("a.stl", written(kFormats[1], mesh)));
  ASSERT_TRUE(file.ok());
  EXPECT_EQ(file->format, "stl ascii");
  EXPECT_EQ(file->offset, mesh.offset);
}

TEST(MeshRoundTrip, AsciiAndBinaryStlHoldTheSameFacets) {
  const Mesh mesh = random_mesh(4, 100, 300);
  const auto a = formats::read_mesh(memory_source("a.stl", written(kFormats[0], mesh)));
  const auto b = formats::read_mesh(memory_source("b.stl", written(kFormats[1], mesh)));
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_EQ(a->positions, b->positions);
  EXPECT_EQ(a->triangles, b->triangles);
}

TEST(MeshRoundTrip, KeepsAnEmptyMesh) {
  for (const Format& format : kFormats) {
    const std::string bytes = written(format, Mesh{});
    EXPECT_TRUE(format.compare(Mesh{}, *memory_source(format.name, bytes)).ok()) << format.name;
    if (std::string(format.name) == "a.obj") continue;  // an OBJ without vertices is no mesh to anybody
    const auto file = formats::read_mesh(memory_source(format.name, bytes));
    ASSERT_TRUE(file.ok()) << file.error().text();
    EXPECT_TRUE(file->triangles.empty());
  }
}

TEST(MeshRoundTrip, KeepsVertexErrors) {
  const Mesh mesh = random_mesh(2, 30, 40);
  std::vector<float> error, rms;
  for (int i = 0; i < 30; ++i)
    error.push_back(static_cast<float>(i - 15) * 0.01f), rms.push_back(static_cast<float>(i) * 0.1f);
  const std::string comment = "made\nup";
  const PlyMeshOptions options{false, error, rms, {&comment, 1}};
  std::string bytes;
  const auto sink = memory_sink("a.ply", bytes);
  ASSERT_TRUE(write_ply_mesh(mesh, options, *sink).ok());
  ASSERT_TRUE(sink->commit().ok());
  EXPECT_TRUE(compare_ply_mesh(mesh, options, *memory_source("a.ply", bytes)).ok());
  const auto file = formats::read_mesh(memory_source("a.ply", bytes));
  ASSERT_TRUE(file.ok()) << file.error().text();
  EXPECT_EQ(file->error, std::vector<double>(error.begin(), error.end()));
  EXPECT_EQ(file->error_rms, std::vector<double>(rms.begin(), rms.end()));
  EXPECT_EQ(file->coordinates, formats::CoordinateForm::Float32);
  EXPECT_EQ(file->comments, (std::vector<std::string>{"scanmill mesh, units mm", "made up"}));
  EXPECT_TRUE(file->notes.empty()) << file->notes[0];
}

TEST(MeshWriters, RefuseColumnsThatDoNotFit) {
  Mesh mesh = random_mesh(2, 30, 40);
  std::string bytes;
  const auto sink = memory_sink("a", bytes);
  const std::vector<float> error(29);
  EXPECT_EQ(write_ply_mesh(mesh, {.error = error}, *sink).error().code, Code::Internal);
  mesh.patch.pop_back();
  EXPECT_EQ(write_ply_mesh(mesh, {}, *sink).error().code, Code::Internal);
  EXPECT_EQ(write_obj(mesh, *sink).error().code, Code::Internal);
}

TEST(MeshWriters, WriteTextThatPeopleExpect) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {0.1f, 0, 0}, {0, 1e-7f, -0.0}, {0, 0, 1}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.patch = {7, 2};
  EXPECT_EQ(written(kFormats[2], mesh),
            "# scanmill mesh, units mm\nv 0 0 0\nv 0.10000000149011612 0 0\nv 0 1.0000000116860974e-07 0\nv 0 0 1\n"
            "g patch_2\nf 1 3 4\ng patch_7\nf 1 2 3\n");
  const std::string stl = written(kFormats[1], mesh);
  EXPECT_EQ(stl.rfind("solid scanmill UNITS=mm\n  facet normal 0 0 1\n    outer loop\n      vertex 0 0 0\n"
                      "      vertex 0.1 0 0\n      vertex 0 1e-07 0\n    endloop\n  endfacet\n",
                      0),
            0u)
      << stl;
  EXPECT_EQ(stl.substr(stl.size() - 18), "endsolid scanmill\n");
}

TEST(MeshWriters, FindEveryDamagedByteWhenReadingBack) {
  const Mesh mesh = random_mesh(3, 6, 5);
  for (const Format& format : kFormats) {
    const std::string good = written(format, mesh);
    ASSERT_TRUE(format.compare(mesh, *memory_source("f", good)).ok()) << format.name;
    const std::size_t first = std::string(format.name) == "binary.stl" ? 80 : 0;  // the title carries nothing
    for (std::size_t at = first; at < good.size(); ++at) {
      std::string bad = good;
      bad[at] = static_cast<char>(bad[at] ^ 1);
      const auto found = format.compare(mesh, *memory_source("f", bad));
      ASSERT_FALSE(found.ok()) << format.name << ", byte " << at;
      if (first == 0) {
        EXPECT_EQ(found.error().where, "f: byte " + std::to_string(at));
      }
    }
    EXPECT_FALSE(format.compare(mesh, *memory_source("f", good.substr(0, good.size() - 1))).ok()) << format.name;
    EXPECT_FALSE(format.compare(mesh, *memory_source("f", good + "\n")).ok()) << format.name;
  }
}

TEST(MeshWriters, GiveTheSameBytesTwiceAndAcrossBufferBorders) {
  const Mesh mesh = random_mesh(6, 20000, 40000);
  for (const Format& format : kFormats) {
    const std::string bytes = written(format, mesh);
    EXPECT_EQ(bytes, written(format, mesh)) << format.name;
    EXPECT_TRUE(format.compare(mesh, *memory_source("f", bytes)).ok()) << format.name;
    EXPECT_TRUE(formats::read_mesh(memory_source(format.name, bytes)).ok()) << format.name;
  }
}

}  // namespace
}  // namespace scanmill::exporting
