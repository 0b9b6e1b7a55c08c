// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "base/random.hpp"
#include "export/writers.hpp"

namespace scanmill::exporting {
namespace {

/// A sheet of n x n squares with uneven heights, two triangles each.
Mesh sheet(std::uint32_t n) {
  Mesh mesh;
  Random random(1, n, 0);
  for (std::uint32_t j = 0; j <= n; ++j)
    for (std::uint32_t i = 0; i <= n; ++i) mesh.positions.push_back({i * 0.1, j * 0.1, random.uniform(-1, 1)});
  for (std::uint32_t j = 0; j < n; ++j)
    for (std::uint32_t i = 0; i < n; ++i) {
      const std::uint32_t a = j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
      mesh.triangles.push_back({a, b, d});
      mesh.triangles.push_back({a, d, c});
    }
  return mesh;
}

std::string written(const Mesh& mesh) {
  std::string bytes;
  const auto sink = memory_sink("mesh.stl", bytes);
  EXPECT_TRUE(write_stl(mesh, *sink).ok());
  EXPECT_TRUE(sink->commit().ok());
  return bytes;
}

float float_at(const std::string& bytes, std::size_t at) {
  float value = 0;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

class FullDisk final : public ByteSink {
 public:
  explicit FullDisk(std::size_t room) : room_(room) {}
  const std::string& name() const override { return name_; }
  Result<void> write(std::span<const char> bytes) override {
    if (bytes.size() > room_) return fail(Code::NoSpace, "the disk is full", name_);
    room_ -= bytes.size();
    return {};
  }
  Result<void> commit() override { return {}; }

 private:
  std::string name_ = "full";
  std::size_t room_;
};

TEST(WriteStl, HasTheHeaderAndSizeOfTheFormat) {
  const std::string bytes = written(sheet(3));
  EXPECT_EQ(bytes.size(), 84u + 50 * 18);
  EXPECT_EQ(bytes.rfind("scanmill", 0), 0u);
  EXPECT_EQ(bytes.find("solid"), std::string::npos);
  EXPECT_EQ(static_cast<unsigned char>(bytes[80]), 18);
  EXPECT_EQ(bytes.substr(81, 3), std::string(3, '\0'));
  for (std::size_t t = 0; t < 18; ++t) EXPECT_EQ(bytes.substr(84 + 50 * t + 48, 2), std::string(2, '\0'));
  EXPECT_EQ(bytes, written(sheet(3)));
}

TEST(WriteStl, ReadsBackCornerForCorner) {
  const Mesh mesh = sheet(100);  // 20,000 triangles: more than one buffer
  const auto source = memory_source("mesh.stl", written(mesh));
  const auto corners = read_stl(*source);
  ASSERT_TRUE(corners.ok()) << corners.error().text();
  ASSERT_EQ(corners->size(), mesh.triangles.size());
  for (std::size_t t = 0; t < corners->size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 p = mesh.positions[mesh.triangles[t][k]];
      ASSERT_EQ((*corners)[t][3 * k], static_cast<float>(p.x));
      ASSERT_EQ((*corners)[t][3 * k + 1], static_cast<float>(p.y));
      ASSERT_EQ((*corners)[t][3 * k + 2], static_cast<float>(p.z));
    }
  EXPECT_TRUE(compare_stl(mesh, *source).ok());
}

TEST(WriteStl, HasUnitNormalsByTheRightHandRule) {
  const Mesh mesh = sheet(20);
  const std::string bytes = written(mesh);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3 n{float_at(bytes, 84 + 50 * t), float_at(bytes, 88 + 50 * t), float_at(bytes, 92 + 50 * t)};
    const auto [a, b, c] = mesh.triangles[t];
    const Vec3 wanted = unit(cross(mesh.positions[b] - mesh.positions[a], mesh.positions[c] - mesh.positions[a]));
    ASSERT_NEAR(norm(n - wanted), 0, 1e-5);
    ASSERT_NEAR(norm(n), 1, 1e-6);
  }
}

TEST(WriteStl, WritesNoMinusZeroAndAZeroNormalWithoutArea) {
  Mesh mesh;
  mesh.positions = {{-0.0, -0.0, -0.0}, {1, -1e-60, 0}, {0, 1, -0.0}, {2, 0, 0}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}};  // downwards: a normal of (-0, -0, -1); then three points on a line
  const std::string bytes = written(mesh);
  for (std::size_t t = 0; t < 2; ++t)
    for (std::size_t i = 0; i < 12; ++i) {
      const float value = float_at(bytes, 84 + 50 * t + 4 * i);
      EXPECT_FALSE(value == 0 && std::signbit(value)) << "triangle " << t << " number " << i;
    }
  EXPECT_EQ(float_at(bytes, 92), -1);
  EXPECT_EQ(float_at(bytes, 134), 0);
  EXPECT_EQ(float_at(bytes, 142), 0);
}

TEST(WriteStl, AcceptsAnEmptyMesh) {
  const std::string bytes = written(Mesh{});
  EXPECT_EQ(bytes.size(), 84u);
  const auto corners = read_stl(*memory_source("mesh.stl", bytes));
  ASSERT_TRUE(corners.ok());
  EXPECT_TRUE(corners->empty());
}

TEST(WriteStl, ReportsAFullDiskWhereverItHappens) {
  const Mesh mesh = sheet(100);
  for (const std::size_t room : {0u, 100u, 500000u}) {
    FullDisk sink(room);
    const auto result = write_stl(mesh, sink);
    ASSERT_FALSE(result.ok());
    EXPECT_EQ(result.error().code, Code::NoSpace);
  }
}

TEST(ReadStl, RefusesAFileThatIsCutOrLies) {
  const std::string bytes = written(sheet(1));
  ASSERT_TRUE(read_stl(*memory_source("a.stl", bytes)).ok());
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    const auto cut = read_stl(*memory_source("cut.stl", bytes.substr(0, length)));
    ASSERT_FALSE(cut.ok()) << length;
    EXPECT_EQ(cut.error().code, Code::BadInput);
    EXPECT_EQ(cut.error().where, "cut.stl: byte " + std::to_string(length));
  }
  EXPECT_FALSE(read_stl(*memory_source("a.stl", bytes + "x")).ok());
  std::string lying = bytes;
  lying[80] = lying[81] = lying[82] = lying[83] = '\xff';
  const auto huge = read_stl(*memory_source("a.stl", lying));
  ASSERT_FALSE(huge.ok());
  EXPECT_NE(huge.error().message.find("4,294,967,295"), std::string::npos) << huge.error().message;
}

TEST(CompareStl, NamesTheFirstDifference) {
  const Mesh mesh = sheet(100);
  std::string bytes = written(mesh);
  const std::size_t at = 84 + 50 * 12345 + 30;
  bytes[at] = static_cast<char>(bytes[at] ^ 1);
  bytes[at + 500] = static_cast<char>(bytes[at + 500] ^ 1);
  const auto result = compare_stl(mesh, *memory_source("mesh.stl", bytes));
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.error().code, Code::Internal);
  EXPECT_EQ(result.error().where, "mesh.stl: byte " + std::to_string(at));
  EXPECT_NE(result.error().message.find("second corner of triangle 12,345"), std::string::npos)
      << result.error().message;
  const auto other = compare_stl(sheet(99), *memory_source("mesh.stl", bytes));
  ASSERT_FALSE(other.ok());
  EXPECT_NE(other.error().message.find("20,000 triangles"), std::string::npos) << other.error().message;
}

TEST(StlHeader, TellsTheOffsetAsFarAsThereIsRoom) {
  EXPECT_EQ(stl_header({}).find("offset_mm"), std::string::npos);
  EXPECT_NE(stl_header({512000, -4096, 0}).find("offset_mm 512000 -4096 0"), std::string::npos);
  EXPECT_EQ(stl_header({512000, -4096, 0}).size(), 80u);
  EXPECT_EQ(stl_header({1.0 / 3, -1.0 / 3, 2.0 / 3}).find("offset_mm"), std::string::npos);
}

}  // namespace
}  // namespace scanmill::exporting
