// SPDX-License-Identifier: Apache-2.0
// Files larger than memory: made from blocks, counted instead of kept.
#include <gtest/gtest.h>

#include <cstdlib>
#include <cstring>
#include <fstream>
#include <limits>

#include "export/dxf.hpp"
#include "export/iges.hpp"
#include "export/mesh_writers.hpp"
#include "export/threemf.hpp"
#include "export/writers.hpp"
#include "export/zip.hpp"

namespace scanmill::exporting {
namespace {

/// Counts bytes and keeps the first and last few.
class CountingSink final : public ByteSink {
 public:
  const std::string& name() const override { return name_; }
  using ByteSink::write;
  Result<void> write(std::span<const char> bytes) override {
    if (head.size() < 4096) head.append(bytes.data(), std::min<std::size_t>(bytes.size(), 4096 - head.size()));
    tail.append(bytes.data() + (bytes.size() > 256 ? bytes.size() - 256 : 0), std::min<std::size_t>(bytes.size(), 256));
    if (tail.size() > 256) tail.erase(0, tail.size() - 256);
    count += bytes.size();
    return {};
  }
  Result<void> commit() override { return {}; }
  std::uint64_t count = 0;
  std::string head, tail;

 private:
  std::string name_ = "counted";
};

/// A wall of bricks, any number of triangles long: triangle t joins vertices t / 2 and those beside it, so rows follow
/// from the number. All corners lie in a box of 64 mm, which keeps the text of every number short.
class LongMesh final : public MeshStream {
 public:
  LongMesh(std::uint64_t triangles, std::uint64_t vertices, bool with_patches = false)
      : triangles_(triangles), vertices_(vertices), with_patches_(with_patches) {}
  std::uint64_t vertices() const override { return vertices_; }
  std::uint64_t triangles() const override { return triangles_; }
  Vec3 offset() const override { return {}; }
  Bounds bounds() const override {
    Bounds box;
    for (std::uint64_t v = 0; v < std::min<std::uint64_t>(vertices_, 1 << 18); ++v) box.add(place(v));
    return box;
  }
  std::vector<std::uint32_t> patch_ids() const override {
    return with_patches_ ? std::vector<std::uint32_t>{0, 7} : std::vector<std::uint32_t>{};
  }
  bool is_closed() const override { return false; }
  static Vec3 place(std::uint64_t v) {
    return {static_cast<double>(v & 63), static_cast<double>(v >> 6 & 63), static_cast<double>(v >> 12 & 63)};
  }
  Result<void> each_vertices(OnVertices visit) const override {
    std::vector<Vec3> block(4096);
    for (std::uint64_t v = 0; v < vertices_; v += block.size()) {
      const std::size_t count = static_cast<std::size_t>(std::min<std::uint64_t>(block.size(), vertices_ - v));
      for (std::size_t i = 0; i < count; ++i) block[i] = place(v + i);
      TRY(visit(std::span(block).first(count)));
    }
    return {};
  }
  Result<void> each_triangles(Corners corners, OnTriangles visit) const override {
    std::vector<Triangle> rows(4096);
    std::vector<std::array<Vec3, 3>> places(4096);
    std::vector<std::uint32_t> patch(4096);
    for (std::uint64_t t = 0; t < triangles_; t += rows.size()) {
      const std::size_t count = static_cast<std::size_t>(std::min<std::uint64_t>(rows.size(), triangles_ - t));
      for (std::size_t i = 0; i < count; ++i) {
        const std::uint64_t first = (t + i) / 2 % (vertices_ - 2);
        for (std::uint32_t c = 0; c < 3; ++c) rows[i][c] = static_cast<std::uint32_t>(first + c);
        if (corners == Corners::Yes) places[i] = {place(rows[i][0]), place(rows[i][1]), place(rows[i][2])};
        patch[i] = (t + i) < triangles_ / 2 ? 0 : 7;
      }
      TRY(visit(
          {std::span(rows).first(count),
           corners == Corners::Yes ? std::span<const std::array<Vec3, 3>>(places).first(count)
                                   : std::span<const std::array<Vec3, 3>>(),
           with_patches_ ? std::span<const std::uint32_t>(patch).first(count) : std::span<const std::uint32_t>()}));
    }
    return {};
  }

 private:
  std::uint64_t triangles_, vertices_;
  bool with_patches_;
};

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
  if (std::system("python3 -c 'import zipfile' > /dev/null 2>&1") != 0) GTEST_SKIP() << "no python3 here";
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
    EXPECT_EQ(std::system(("python3 -c '" + program + "'").c_str()), 0) << "narrow " << limits.narrow;
  }
  std::remove(path.c_str());
}

// Minutes each, so disabled by name; CMakeLists.txt makes tests with the label slow of them.
constexpr std::uint64_t kMany = (1ull << 31) + 12'345;

TEST(Slow, DISABLED_StlOfMoreThan2To31Triangles) {
  CountingSink sink;
  ASSERT_TRUE(stream_stl(LongMesh(kMany, 1000), sink).ok());
  EXPECT_EQ(sink.count, 84 + 50 * kMany);  // 107 GB
  std::uint32_t count = 0;
  std::memcpy(&count, sink.head.data() + 80, sizeof count);
  EXPECT_EQ(count, kMany);
}

TEST(Slow, DISABLED_PlyOfMoreThan2To31TrianglesAndVerticesUpToTheLimit) {
  CountingSink sink;
  const std::uint64_t vertices = (1ull << 31) - 1;
  ASSERT_TRUE(stream_ply_mesh(LongMesh(kMany, vertices, true), {}, sink).ok());
  const std::size_t header = sink.head.find("end_header\n") + 11;
  EXPECT_EQ(sink.count, header + 12 * vertices + 17 * kMany);
  EXPECT_NE(sink.head.find("element face " + std::to_string(kMany) + "\n"), std::string::npos);
  EXPECT_NE(sink.head.find("element vertex 2147483647\n"), std::string::npos);
}

TEST(Slow, DISABLED_TextFormatsOfMoreThan2To31Triangles) {
  const LongMesh mesh(kMany, 12);  // ten rows of nine digits at most: lengths follow by counting
  CountingSink obj, dxf;
  ASSERT_TRUE(stream_obj(mesh, obj).ok());
  std::uint64_t wanted = std::string("# scanmill mesh, units mm\n").size();
  for (std::uint64_t v = 0; v < 12; ++v) wanted += std::string("v 0 0 \n").size() + std::to_string(v).size();
  std::uint64_t per_ten = 0;
  const auto length = [](std::uint64_t first) {
    return 2 + std::to_string(first + 1).size() + std::to_string(first + 2).size() + std::to_string(first + 3).size() +
           3;
  };
  for (std::uint64_t f = 0; f < 10; ++f) per_ten += 2 * length(f);
  wanted += kMany / 20 * per_ten;
  for (std::uint64_t t = kMany / 20 * 20; t < kMany; ++t) wanted += length(t / 2 % 10);
  EXPECT_EQ(obj.count, wanted);
  ASSERT_TRUE(stream_dxf_faces(mesh, dxf).ok());
  EXPECT_GT(dxf.count, kMany * 100);
  EXPECT_NE(dxf.tail.find("EOF\n"), std::string::npos);
}

TEST(Slow, DISABLED_ThreeMfOfMoreThan4GiB) {
  CountingSink sink;
  const std::uint64_t triangles = 120'000'000;
  const auto counts = stream_3mf(LongMesh(triangles, 1000), sink);
  ASSERT_TRUE(counts.ok()) << counts.error().text();
  EXPECT_EQ(counts->triangles, triangles);
  EXPECT_NE(sink.tail.find("PK\x05\x06"), std::string::npos);
  EXPECT_NE(sink.tail.find(std::string("\x01\x00\x18\x00", 4)), std::string::npos);  // the ZIP64 field of the model
}

}  // namespace
}  // namespace scanmill::exporting
