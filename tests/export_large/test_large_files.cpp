// SPDX-License-Identifier: Apache-2.0
// Files beyond the counts of 32 bits, written whole. Minutes each.
#include <gtest/gtest.h>

#include <cstring>

#include "export/dxf.hpp"
#include "export/long_mesh.hpp"
#include "export/threemf.hpp"

namespace scanmill::exporting {
namespace {

constexpr std::uint64_t kMany = (1ull << 31) + 12'345;

TEST(LargeFiles, StlOfMoreThan2To31Triangles) {
  CountingSink sink;
  ASSERT_TRUE(stream_stl(LongMesh(kMany, 1000), sink).ok());
  EXPECT_EQ(sink.count, 84 + 50 * kMany);  // 107 GB
  std::uint32_t count = 0;
  std::memcpy(&count, sink.head.data() + 80, sizeof count);
  EXPECT_EQ(count, kMany);
}

TEST(LargeFiles, PlyOfMoreThan2To31TrianglesAndVerticesUpToTheLimit) {
  CountingSink sink;
  const std::uint64_t vertices = (1ull << 31) - 1;
  ASSERT_TRUE(stream_ply_mesh(LongMesh(kMany, vertices, true), {}, sink).ok());
  const std::size_t header = sink.head.find("end_header\n") + 11;
  EXPECT_EQ(sink.count, header + 12 * vertices + 17 * kMany);
  EXPECT_NE(sink.head.find("element face " + std::to_string(kMany) + "\n"), std::string::npos);
  EXPECT_NE(sink.head.find("element vertex 2147483647\n"), std::string::npos);
}

TEST(LargeFiles, TextFormatsOfMoreThan2To31Triangles) {
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

TEST(LargeFiles, ThreeMfOfMoreThan4GiB) {
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
