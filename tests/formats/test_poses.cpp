// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "formats/poses.hpp"
#include "hand_made.hpp"

namespace scanmill::formats {
namespace {

Result<std::vector<NamedPose>> poses(const std::string& text) { return read_poses(*memory_source("p.log", text)); }

std::string error_of(const std::string& text) {
  const auto read = poses(text);
  return read.ok() ? "no error" : read.error().text();
}

const std::string kTurned = "0 -1 0 10\n1 0 0 20\n0 0 1 30\n0 0 0 1\n";  // x to y
const std::string kShifted = "1 0 0 5\n0 1 0 6\n0 0 1 7\n0 0 0 1\n";

void expect_both(const Result<std::vector<NamedPose>>& read, const std::string& first, const std::string& second) {
  ASSERT_TRUE(read.ok()) << read.error().text();
  ASSERT_EQ(read->size(), 2u);
  EXPECT_EQ((*read)[0].name, first);
  EXPECT_EQ((*read)[1].name, second);
  EXPECT_EQ((*read)[0].pose.apply({1, 0, 0}), (Vec3{10, 21, 30}));
  EXPECT_EQ((*read)[1].pose.apply({1, 0, 0}), (Vec3{6, 6, 7}));
}

TEST(ReadPoses, TellsTheFormatsApartByContent) {
  expect_both(poses("0 0 1\n" + kTurned + "1 1 2\n" + kShifted), "", "");
  expect_both(poses("# two\n" + kTurned + "\n" + kShifted), "", "");
  expect_both(poses("0 -1 0 10 1 0 0 20 0 0 1 30 0 0 0 1\n1,0,0,5,0,1,0,6,0,0,1,7,0,0,0,1\n"), "", "");
  expect_both(poses("2\n./a b.ply\n#\n" + kTurned + "sub/c.ply\r\n# W:1\n" + kShifted + "0\n"), "a b.ply", "sub/c.ply");
  expect_both(poses("bmesh a.ply 10 20 30 0 0 -0.7071067811865476 0.7071067811865476\nmesh b.ply 5 6 7 0 0 0 1\n"),
              "a.ply", "b.ply");
}

TEST(ReadPoses, SaysWhatIsWrongAndWhere) {
  EXPECT_EQ(error_of(""), "p.log: the file holds no pose, wanted 4x4 matrices");
  EXPECT_EQ(error_of("0 0 1\n1 0 0 0\n0 1 0 0\n"),
            "p.log:4: the file ends, wanted a row of four numbers of a 4x4 matrix; it was cut");
  EXPECT_EQ(error_of("0 0 1\n" + kTurned + kShifted),
            "p.log:6: found \"1 0 0 5\", wanted three whole numbers before the matrix");
  EXPECT_EQ(error_of(kShifted + "1 0 0 x\n"),
            "p.log:5: found \"1 0 0 x\", wanted a row of four numbers of a 4x4 matrix");
  EXPECT_NE(error_of("2 0 0 5\n0 1 0 6\n0 0 1 7\n0 0 0 1\n").find("p.log:1: the rotation of a pose matrix is off"),
            std::string::npos);
  EXPECT_NE(error_of("1 0 0 0\n0 1 0 0\n0 0 1 0\n5 6 7 1\n").find("is the matrix transposed?"), std::string::npos);
  EXPECT_EQ(error_of("2\na.ply\n#\n" + kTurned + "0\n"),
            "p.log:9: the file ends, wanted a row of four numbers of a 4x4 matrix; it was cut");
  EXPECT_EQ(error_of("2\na.ply\n#\n" + kTurned),
            "p.log: the first line declares 2 meshes, the file holds 1; it was cut or the count is wrong");
  EXPECT_NE(error_of("1\n../a.ply\n#\n" + kTurned).find("inside the folder of the .aln"), std::string::npos);
}

TEST(ReadPoses, BearsCutsAndDamage) {
  for (const std::string& whole :
       {"0 0 1\n" + kTurned + "1 1 2\n" + kShifted, "2\na.ply\n#\n" + kTurned + "b\n#\n" + kShifted + "0\n"})
    for (std::size_t size = 0; size <= whole.size(); ++size)
      for (const char c : {'\0', '9', '\n', '-'}) {
        const auto read = poses(whole.substr(0, size) + c);
        EXPECT_TRUE(read.ok() || read.error().code == Code::BadInput) << read.error().text();
      }
}

}  // namespace
}  // namespace scanmill::formats
