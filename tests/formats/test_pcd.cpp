// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "formats/lzf.hpp"
#include "hand_made.hpp"

namespace scanmill::formats {
namespace {

std::string header(const std::string& fields, const std::string& size, const std::string& type, std::size_t points,
                   const std::string& data, const std::string& more = "") {
  return "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS " + fields + "\nSIZE " + size + "\nTYPE " +
         type + "\n" + more + "WIDTH " + std::to_string(points) + "\nHEIGHT 1\nPOINTS " + std::to_string(points) +
         "\nDATA " + data + "\n";
}

/// Three points; the second is not finite.
const std::string kAscii = header("x y z", "4 4 4", "F F F", 3, "ascii") + "1 2 3\nnan 2 3\n\n-1.5\t0.25 1e2\r\n";
const std::string kRows =
    raw<float>({1, 2, 3}) + "ab" + raw<float>({NAN, 2, 3}) + "cd" + raw<float>({-1.5f, 0.25f, 100}) + "ef";
const std::string kBinary = header("x y z c", "4 4 4 1", "F F F U", 3, "binary", "COUNT 1 1 1 2\n") + kRows;

/// A stream of literal runs alone.
std::string packed(const std::string& bytes) {
  std::string out;
  for (std::size_t at = 0; at < bytes.size(); at += 32) {
    const std::string run = bytes.substr(at, 32);
    out += static_cast<char>(run.size() - 1);
    out += run;
  }
  return out;
}

std::string compressed(const std::string& head, const std::string& columns, const std::string& tokens) {
  return head + raw(static_cast<std::uint32_t>(tokens.size())) + raw(static_cast<std::uint32_t>(columns.size())) +
         tokens;
}

const std::string kColumns = raw<float>({1, NAN, -1.5f}) + raw<float>({2, 2, 0.25f}) + raw<float>({3, 3, 100});
const std::string kCompressed =
    compressed(header("x y z", "4 4 4", "F F F", 3, "binary_compressed"), kColumns, packed(kColumns));

void expect_two_points(const std::string& bytes, const char* format) {
  const auto whole = read_whole("a.pcd", bytes);
  ASSERT_TRUE(whole.ok()) << whole.error().text();
  EXPECT_EQ(whole->header.format, format);
  EXPECT_EQ(whole->header.row_meaning, RowMeaning::PointFromZero);
  EXPECT_EQ(whole->points_read, 3u);
  EXPECT_EQ(whole->not_finite, 1u);
  EXPECT_EQ(whole->positions, (std::vector<Vec3>{{1, 2, 3}, {-1.5, 0.25, 100}}));
  EXPECT_EQ(whole->rows, (std::vector<std::uint64_t>{0, 2}));
  EXPECT_TRUE(whole->header.notes.empty()) << whole->header.notes.front();
}

std::string error_of(const std::string& bytes) {
  const auto whole = read_whole("a.pcd", bytes);
  return whole.ok() ? "no error" : whole.error().text();
}

TEST(ReadPcd, GivesTheSamePointsInAllThreeEncodings) {
  expect_two_points(kAscii, "pcd ascii");
  expect_two_points(kBinary, "pcd binary");
  expect_two_points(kCompressed, "pcd binary_compressed");
  expect_two_points(kBinary + std::string(4096, '\0'), "pcd binary");  // a page of the library that wrote it
}

TEST(ReadPcd, TakesFieldsInAnyOrderAndOfAnyType) {
  const auto whole = read_whole("a.pcd", header("Z label Y X", "8 2 1 2", "F U I U", 2, "binary", "COUNT 1 3 1 1\n") +
                                             raw(0.125) + "abcdef" + raw<std::int8_t>(-7) + raw<std::uint16_t>(65535) +
                                             raw(-4.0) + "ghijkl" + raw<std::int8_t>(7) + raw<std::uint16_t>(0));
  ASSERT_TRUE(whole.ok()) << whole.error().text();
  EXPECT_EQ(whole->positions, (std::vector<Vec3>{{65535, -7, 0.125}, {0, 7, -4}}));
  const auto columns = read_whole("a.pcd", "FIELDS rgb z y x\nWIDTH 1\nDATA ascii\n4.2e6 3 2 1\n");
  ASSERT_TRUE(columns.ok()) << columns.error().text();
  EXPECT_EQ(columns->positions, (std::vector<Vec3>{{1, 2, 3}}));
}

TEST(ReadPcd, TakesTheEyeWhereTheFileKnowsIt) {
  auto eye = [](const std::string& view, std::size_t width, std::size_t height) {
    const auto whole =
        read_whole("a.pcd", "FIELDS x y z\nWIDTH " + std::to_string(width) + "\nHEIGHT " + std::to_string(height) +
                                "\n" + view + "DATA ascii\n1 2 3\n1 2 3\n" + "1 2 3\n1 2 3\n");
    EXPECT_TRUE(whole.ok()) << whole.error().text();
    return whole->header.view_point.eye;
  };
  EXPECT_EQ(eye("VIEWPOINT 1 2 3 0 1 0 0\n", 4, 1), (Vec3{1, 2, 3}));
  EXPECT_EQ(eye("VIEWPOINT 0 0 0 1 0 0 0\n", 4, 1), std::nullopt);  // also written by programs that do not know it
  EXPECT_EQ(eye("VIEWPOINT 0 0 0 1 0 0 0\n", 2, 2), (Vec3{0, 0, 0}));
  EXPECT_EQ(eye("", 2, 2), std::nullopt);
}

TEST(ReadPcd, RefusesWhatTheFileCannotHold) {
  const std::string lie = header("x y z", "4 4 4", "F F F", 4000000000000000ull, "binary");
  EXPECT_EQ(error_of(lie), "a.pcd: byte " + std::to_string(lie.size()) +
                               ": the header declares 4000000000000000 points of 12 bytes, the file ends after 0; it "
                               "was cut or its header is wrong");
  EXPECT_NE(error_of(header("x y z", "4 4 4", "F F F", 4, "ascii") + "1 2 3\n").find("a.pcd:11: the header declares 4"),
            std::string::npos);
  EXPECT_NE(error_of(compressed(header("x y z", "4 4 4", "F F F", 3, "binary_compressed"), kColumns + "x", ""))
                .find("declares 37 decoded bytes, the header 3 points of 12 bytes"),
            std::string::npos);
  // 360 MB out of nothing: the tokens end long before.
  const std::string head = header("x y z", "4 4 4", "F F F", 30000000, "binary_compressed");
  EXPECT_NE(error_of(head + raw<std::uint32_t>({5, 360000000}) + std::string("\3aaaa", 5)).find("ends after 4 decoded"),
            std::string::npos);
  EXPECT_NE(error_of(head + raw<std::uint32_t>({5000, 360000000})).find("declares 5000 bytes, the file has 0"),
            std::string::npos);
}

TEST(ReadPcd, SettlesTwoCountsByTheFile) {
  const std::string two = "FIELDS x y z\nWIDTH 9\nHEIGHT 2\nPOINTS 2\nDATA ascii\n1 2 3\n4 5 6\n";
  const auto whole = read_whole("a.pcd", two);
  ASSERT_TRUE(whole.ok()) << whole.error().text();
  EXPECT_EQ(whole->positions.size(), 2u);
  EXPECT_EQ(whole->header.notes,
            (std::vector<std::string>{"WIDTH x HEIGHT is 18, POINTS is 2; the file holds as many as POINTS says"}));
  EXPECT_EQ(error_of(two + "7 8 9\n"), "a.pcd: WIDTH x HEIGHT is 18, POINTS is 2; correct the header");
}

TEST(ReadPcd, NamesTheLineOfAMistake) {
  const std::string head = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 1\nDATA ascii\n";
  EXPECT_EQ(error_of(head + "1,5 2,5 3,5\n"),
            "a.pcd:6: found \"1,5 2,5 3,5\", wanted 3 values parted by blanks with numbers for x, y and z; write "
            "decimal points, and no commas");
  EXPECT_EQ(error_of(head + "1 2\n"), "a.pcd:6: found \"1 2\", wanted 3 values parted by blanks, found 2");
  EXPECT_EQ(error_of("FIELDS x y\nWIDTH 1\nDATA ascii\n"), "a.pcd:1: found 0 fields named z, wanted one");
  EXPECT_EQ(error_of("FIELDS x y z\nSIZE 4 4\nWIDTH 1\nDATA ascii\n"),
            "a.pcd:2: found 2 values in SIZE, wanted 3, one per field");
  EXPECT_EQ(error_of("FIELDS x y z\nSIZE 4 4 3\nTYPE F F F\nWIDTH 1\nDATA binary\n"),
            "a.pcd:2: found the size \"3\", wanted 1, 2, 4 or 8");
  EXPECT_NE(error_of("FIELDS x y z\nWIDTH 1\nDATA zipped\n").find("a.pcd:3: found DATA \"zipped\""), std::string::npos);
}

TEST(ReadPcd, BearsCutsAndDamage) {
  expect_bears_cuts("a.pcd", kAscii, {}, kAscii.size() - 7);
  expect_bears_cuts("a.pcd", kBinary, {}, kBinary.size());
  expect_bears_cuts("a.pcd", kCompressed, {}, kCompressed.size());
  for (const std::string& bytes : {kAscii, kBinary, kCompressed}) expect_bears_damage("a.pcd", bytes, {}, 1500);
}

/// Text that repeats at all distances, by tokens chosen at random; the decoded text by the same rules.
struct Sample {
  std::string tokens, text;
};

Sample sample_of(std::size_t size) {
  Sample sample;
  Random random(11, 1, 1);
  while (sample.text.size() < size) {
    if (sample.text.empty() || random.next() % 3 == 0) {
      const std::size_t run = 1 + random.next() % 32;
      sample.tokens += static_cast<char>(run - 1);
      for (std::size_t i = 0; i < run; ++i) {
        sample.text += static_cast<char>(random.next());
        sample.tokens += sample.text.back();
      }
      continue;
    }
    const std::size_t reach = std::min<std::size_t>(sample.text.size(), 8192);
    const std::size_t distance = 1 + random.next() % (random.next() % 2 ? reach : std::min<std::size_t>(reach, 9));
    const std::size_t run = 3 + random.next() % 262;
    const std::size_t back = distance - 1, length = run - 2;
    sample.tokens += static_cast<char>(std::min<std::size_t>(length, 7) << 5 | back >> 8);
    if (length >= 7) sample.tokens += static_cast<char>(length - 7);
    sample.tokens += static_cast<char>(back & 255);
    for (std::size_t i = 0; i < run; ++i) sample.text += sample.text[sample.text.size() - distance];
  }
  return sample;
}

TEST(Lzf, BeginsAnywhere) {
  const Sample sample = sample_of(1500000);
  const auto source = memory_source("a", "head" + sample.tokens + "tail");
  const auto stream = index_lzf(*source, 4, sample.tokens.size(), sample.text.size());
  ASSERT_TRUE(stream.ok()) << stream.error().text();
  EXPECT_GE(stream->marks.size(), 5u);
  for (std::uint64_t round = 0; round < 60; ++round) {
    Random random(12, round, 1);
    const std::size_t from = random.next() % sample.text.size();
    std::string part(std::min<std::size_t>(random.next() % 400000, sample.text.size() - from), '\0');
    ASSERT_TRUE(read_lzf(*source, *stream, from, std::span<char>(part.data(), part.size())).ok());
    EXPECT_EQ(part, sample.text.substr(from, part.size())) << from;
  }
}

TEST(Lzf, NamesTheByteThatIsBroken) {
  auto error = [](const std::string& tokens, std::uint64_t size) {
    const auto stream = index_lzf(*memory_source("a", tokens), 0, tokens.size(), size);
    return stream.ok() ? "no error" : stream.error().text();
  };
  EXPECT_EQ(error("\2ab", 3), "a: byte 0: the compressed data is broken: a run of bytes goes past its end");
  EXPECT_EQ(error(std::string("\0a\x20\1", 4), 4),
            "a: byte 2: the compressed data is broken: a token copies from before the beginning");
  EXPECT_EQ(error(std::string("\0a\xe0", 3), 4), "a: byte 2: the compressed data is broken: a token is cut");
  EXPECT_EQ(error(std::string("\0a\x20\0", 4), 4), "no error");
  EXPECT_NE(error(std::string("\0a\x20\0", 4), 3).find("gives more than the 3 bytes"), std::string::npos);
  EXPECT_NE(error(std::string("\0a\x20\0", 4), 5).find("ends after 4 decoded bytes"), std::string::npos);
}

}  // namespace
}  // namespace scanmill::formats
