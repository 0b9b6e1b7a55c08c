// SPDX-License-Identifier: Apache-2.0
// Files larger than memory: made from blocks, counted instead of kept.
#include <gtest/gtest.h>

#include <cstdlib>
#include <cstring>
#include <fstream>
#include <limits>

#include "export/dxf.hpp"
#include "export/iges.hpp"
#include "export/long_mesh.hpp"
#include "export/mesh_writers.hpp"
#include "export/threemf.hpp"
#include "export/writers.hpp"
#include "export/zip.hpp"

namespace scanmill::exporting {
namespace {

Mesh in_memory(const MeshStream& stream) {
  Mesh mesh;
  EXPECT_TRUE(stream.each_vertices([&](std::span<const Vec3> block) -> Result<void> {
    mesh.positions.insert(mesh.positions.end(), block.begin(), block.end());
    return {};
  }));
  EXPECT_TRUE(stream.each_triangles(Corners::No, [&](const TriangleBlock& block) -> Result<void> {
    mesh.triangles.insert(mesh.triangles.end(), block.rows.begin(), block.rows.end());
    mesh.patch.insert(mesh.patch.end(), block.patch.begin(), block.patch.end());
    return {};
  }));
  return mesh;
}

template <class Write>
std::string bytes_of(Write write) {
  std::string bytes;
  const auto sink = memory_sink("memory", bytes);
  const auto done = write(*sink);
  EXPECT_TRUE(done.ok()) << (done.ok() ? "" : done.error().text());
  EXPECT_TRUE(sink->commit().ok());
  return bytes;
}

TEST(MeshStream, BlocksGiveTheBytesOfTheMesh) {
  for (const bool patches : {false, true}) {
    const LongMesh stream(20'001, 5'000, patches);
    const Mesh mesh = in_memory(stream);
    // Not EXPECT_EQ: what it tells of two long texts takes their lines squared of memory.
    auto same = [](const auto& a, const auto& b) { EXPECT_TRUE(bytes_of(a) == bytes_of(b)); };
    same([&](ByteSink& s) { return write_stl(mesh, s); }, [&](ByteSink& s) { return stream_stl(stream, s); });
    same([&](ByteSink& s) { return write_stl_ascii(mesh, s); },
         [&](ByteSink& s) { return stream_stl_ascii(stream, s); });
    same([&](ByteSink& s) { return write_ply_mesh(mesh, {}, s); },
         [&](ByteSink& s) { return stream_ply_mesh(stream, {}, s); });
    same([&](ByteSink& s) { return write_obj(mesh, s); }, [&](ByteSink& s) { return stream_obj(stream, s); });
    same([&](ByteSink& s) { return write_dxf(mesh, DxfStyle::Faces, s); },
         [&](ByteSink& s) { return stream_dxf_faces(stream, s); });
    same([&](ByteSink& s) { return write_3mf(mesh, s); }, [&](ByteSink& s) { return stream_3mf(stream, s); });
  }
}

TEST(WriteStl, RefusesWhat32BitsDoNotCountBeforeTheFirstByte) {
  CountingSink sink;
  const auto done = stream_stl(LongMesh(std::numeric_limits<std::uint32_t>::max() + 1ull, 1000), sink);
  ASSERT_FALSE(done.ok());
  EXPECT_EQ(done.error().code, Code::Unsupported);
  EXPECT_NE(done.error().text().find("4,294,967,296 triangles"), std::string::npos) << done.error().text();
  EXPECT_NE(done.error().text().find("4,294,967,295"), std::string::npos);
  EXPECT_EQ(sink.count, 0u);
}

TEST(WritePly, RefusesMoreVerticesThan31BitsNumber) {
  CountingSink sink;
  const auto done = stream_ply_mesh(LongMesh(10, 1ull << 31), {}, sink);
  ASSERT_FALSE(done.ok());
  EXPECT_NE(done.error().text().find("2,147,483,648 vertices"), std::string::npos) << done.error().text();
  EXPECT_EQ(sink.count, 0u);
}

TEST(ZipWriter, WidePartsAreReadByOthers) {
  const std::string path = testing::TempDir() + "scanmill-wide-" + std::to_string(std::rand()) + ".zip";
  std::string plain;
  for (const ZipLimits limits :
       {ZipLimits{}, ZipLimits{0xfffffffeull, 10}, ZipLimits{100, 10}, ZipLimits{0, 1 << 20}}) {
    const std::string bytes = bytes_of([&](ByteSink& sink) -> Result<void> {
      ZipWriter zip(sink, limits);
      TRY(zip.add("small", [](ByteSink& part) { return part.write(std::string_view("abc")); }));
      TRY(zip.add("large", [](ByteSink& part) -> Result<void> {
        for (int line = 0; line < 20'000; ++line) TRY(part.write(std::string_view(std::to_string(line * 7919) + "\n")));
        return {};
      }));
      TRY(zip.add("last", [](ByteSink& part) { return part.write(std::string_view("xyz")); }));
      return zip.finish();
    });
    if (limits.narrow == ZipLimits{}.narrow) {
      if (plain.empty()) plain = bytes;
      EXPECT_TRUE(bytes == plain);  // made twice or kept: the same
    } else {
      EXPECT_FALSE(bytes == plain);
      EXPECT_NE(bytes.find("PK\x06\x06"), std::string::npos);
    }
    std::ofstream(path, std::ios::binary) << bytes;
    const std::string program =
        "import zipfile; z = zipfile.ZipFile(\"" + path +
        "\"); assert z.testzip() is None; assert z.namelist() == [\"small\", \"large\", \"last\"]; "
        "assert z.read(\"large\").decode() == \"\".join(\"%d\\n\" % (7919 * n) for n in range(20000)); "
        "assert z.read(\"last\") == b\"xyz\"";
    EXPECT_EQ(std::system((std::string(PYTHON3) + " -c '" + program + "'").c_str()), 0) << "narrow " << limits.narrow;
  }
  std::remove(path.c_str());
}

}  // namespace
}  // namespace scanmill::exporting
