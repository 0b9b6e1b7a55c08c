// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "hand_made.hpp"

namespace scanmill::formats {
namespace {

const std::string kAxes = "1 0 0\n0 1 0\n0 0 1\n";
const std::string kPlain = "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n";
/// A quarter turn about z (x to y), then +10, +20, +30; row vectors, as PTX writes it.
const std::string kTurned = "0 1 0 0\n-1 0 0 0\n0 0 1 0\n10 20 30 1\n";
const std::string kTwoScans = "1\n2\n0 0 0\n" + kAxes + kPlain + "1 2 3 0.5\n0 0 0 0.5 0 0 0\n" +  //
                              "2\n2\n10 20 30\n0 1 0\n-1 0 0\n0 0 1\n" + kTurned +
                              "1 0 0 0.5 1 2 3\nnan 0 0 0\n\n0 0 0 0\n0 -2 1 0.25\n";

std::string error_of(const char* name, const std::string& bytes) {
  const auto scans = read_scans(name, bytes);
  return scans.ok() ? "no error" : scans.error().text();
}

TEST(ReadPtx, GivesOneViewPerScanWithItsPose) {
  const auto scans = read_scans("a.ptx", kTwoScans);
  ASSERT_TRUE(scans.ok()) << scans.error().text();
  ASSERT_EQ(scans->size(), 2u);
  const Whole& first = (*scans)[0];
  EXPECT_EQ(first.header.format, "ptx");
  EXPECT_EQ(first.header.row_meaning, RowMeaning::LineFromOne);
  EXPECT_EQ(first.positions, (std::vector<Vec3>{{1, 2, 3}}));
  EXPECT_EQ(first.rows, (std::vector<std::uint64_t>{11}));
  EXPECT_EQ(first.sensor_invalid, 1u);
  EXPECT_EQ(first.header.pose, Pose{});
  EXPECT_EQ(*first.header.view_point.eye, (Vec3{0, 0, 0}));
  const Whole& second = (*scans)[1];
  EXPECT_EQ(second.header.rows, 4u);
  EXPECT_EQ(second.positions, (std::vector<Vec3>{{1, 0, 0}, {0, -2, 1}}));
  EXPECT_EQ(second.rows, (std::vector<std::uint64_t>{23, 27}));
  EXPECT_EQ(second.not_finite, 1u);
  EXPECT_EQ(second.sensor_invalid, 1u);
  EXPECT_EQ(second.header.pose.apply({1, 0, 0}), (Vec3{10, 21, 30}));
  EXPECT_EQ(second.header.pose.apply({0, -2, 1}), (Vec3{12, 20, 31}));
  EXPECT_TRUE(second.header.notes.empty()) << second.header.notes[0];
}

TEST(ReadPtx, AppliesAMatrixThatIsNoPoseAsWritten) {
  const auto scans = read_scans("a.ptx", "1\n1\n5 6 7\n" + kAxes + "1 0 0 0\n0 1 0 0\n0 0 2 0\n5 6 7 1\n1 2 3 0\n");
  ASSERT_TRUE(scans.ok()) << scans.error().text();
  const Whole& scan = scans->front();
  EXPECT_EQ(scan.positions, (std::vector<Vec3>{{6, 8, 13}}));
  EXPECT_EQ(scan.header.pose, Pose{});
  EXPECT_EQ(*scan.header.view_point.eye, (Vec3{5, 6, 7}));
  ASSERT_EQ(scan.header.notes.size(), 2u);
  EXPECT_NE(scan.header.notes[0].find("line 7 is no rigid pose"), std::string::npos);
  EXPECT_NE(scan.header.notes[1].find("differ from the 4x4 matrix"), std::string::npos);
}

TEST(ReadPtx, SaysWhatIsWrongAndWhere) {
  const std::string head = "2\n2\n0 0 0\n" + kAxes + kPlain;
  EXPECT_EQ(error_of("a.ptx", head + "1 2 3\n1 2 3\n1 2 3\n"),
            "a.ptx:1: the scan declares 2 x 2 = 4 cells, the file ends after 3 of them; it was cut or the header is "
            "wrong");
  EXPECT_EQ(error_of("a.ptx", head + "1 2 3\n1 2 3\n1 2 3\n1 2 3\n7 8 9\n"),
            "a.ptx:15: found \"7 8 9\", wanted the end of the file or the number of columns of a further scan; the "
            "scan at line 1 declares 2 x 2 = 4 cells");
  EXPECT_EQ(error_of("a.ptx", "9000000000000000\n9000000000000000\n0 0 0\n"),
            "a.ptx:1: the scan declares 9000000000000000 x 9000000000000000 cells, the whole file has 40 bytes; it was "
            "cut or the header is wrong");
  EXPECT_EQ(error_of("a.ptx", "1\n1\n0 0 0\n" + kAxes + "1 0 0 5\n0 1 0 6\n0 0 1 7\n0 0 0 1\n1 2 3 0\n"),
            "a.ptx:7: the last column of the scan's 4x4 matrix is 5 6 7 1, wanted 0 0 0 1: PTX has the translation in "
            "the last row");
  EXPECT_EQ(error_of("a.ptx", "1\n1\n0 0 0\n" + kAxes + "0 0 0 0\n0 0 0 0\n0 0 0 0\n0 0 0 1\n1 2 3 0\n"),
            "a.ptx:7: the scan's 4x4 matrix flattens space, so it cannot place the points");
  EXPECT_EQ(error_of("a.ptx", "1\n1\n0 0\n"), "a.ptx:3: found \"0 0\", wanted 3 numbers: the scanner's position");
  EXPECT_EQ(error_of("a.ptx", head + "1 2 3\n1 2 three\n1 2 3\n1 2 3\n"),
            "a.ptx:12: found \"1 2 three\", wanted three numbers");
}

TEST(ReadPtx, ManyCellsComeInBlocksThatKeepTheirLines) {
  std::string bytes = "300\n400\n0 0 0\n" + kAxes + kPlain;
  for (int i = 0; i < 120000; ++i) bytes += i % 3 == 0 ? "0 0 0 0.5\n" : std::to_string(i) + ".5 -1 2.25 0.125 1 2 3\n";
  bytes += kTwoScans;
  const auto readers = open_views(std::shared_ptr<const ByteSource>(memory_source("a.ptx", bytes)));
  ASSERT_TRUE(readers.ok()) << readers.error().text();
  ASSERT_EQ(readers->size(), 3u);
  EXPECT_GE((*readers)[0]->block_count(), 3u);
  const auto whole = read_whole(*(*readers)[0]);
  ASSERT_TRUE(whole.ok()) << whole.error().text();
  EXPECT_EQ(whole->sensor_invalid, 40000u);
  ASSERT_EQ(whole->positions.size(), 80000u);
  for (std::size_t k = 0; k < whole->positions.size(); ++k)
    ASSERT_EQ(whole->positions[k].x, static_cast<double>(whole->rows[k] - 11) + 0.5);
}

TEST(ReadPtx, BearsCutsAndDamage) {
  expect_bears_cuts("a.ptx", kTwoScans, {}, 60);
  expect_bears_damage("a.ptx", kTwoScans, {}, 2000);
}

TEST(ReadPts, TakesPartsWithACountEach) {
  const auto one = read_whole("a.pts", "2\r\n1 2 3 -1500 10 20 30\r\n0 0 0\r\n");
  ASSERT_TRUE(one.ok()) << one.error().text();
  EXPECT_EQ(one->header.format, "pts");
  EXPECT_EQ(one->positions, (std::vector<Vec3>{{1, 2, 3}, {0, 0, 0}}));  // a point like any other
  EXPECT_EQ(one->rows, (std::vector<std::uint64_t>{2, 3}));
  EXPECT_TRUE(one->header.notes.empty());
  const auto two = read_whole("a.pts", "1\n1 2 3\n# more\n2\n4 5 6\nnan 5 6\n");
  ASSERT_TRUE(two.ok()) << two.error().text();
  EXPECT_EQ(two->rows, (std::vector<std::uint64_t>{2, 5}));
  EXPECT_EQ(two->header.rows, 3u);
  EXPECT_EQ(two->header.notes.size(), 1u);
  const auto none = read_whole("a.pts", "1 2 3\n4 5 6\n");
  ASSERT_TRUE(none.ok()) << none.error().text();
  EXPECT_EQ(none->positions.size(), 2u);
}

TEST(ReadPts, NamesTheLineOfACountThatLies) {
  EXPECT_EQ(error_of("a.pts", "3\n1 2 3\n4 5 6\n"),
            "a.pts:1: the line declares 3 points, the file holds 2 lines of numbers behind it; it was cut or the count "
            "is wrong");
  EXPECT_NE(error_of("a.pts", "1\n1 2 3\n4 5 6\n").find("a.pts:3: found \"4 5 6\" behind the last point"),
            std::string::npos);
  EXPECT_NE(error_of("a.pts", "9007199254740000\n1 2 3\n").find("the file holds 1 lines"), std::string::npos);
  expect_bears_cuts("a.pts", "2\n1.5 2.5 3.5 7\n4.5 5.5 6.5 7\n", {}, 18);
  expect_bears_damage("a.pts", "2\n1.5 2.5 3.5 7\n4.5 5.5 6.5 7\n1\n1 2 3\n", {}, 1500);
}

}  // namespace
}  // namespace scanmill::formats
